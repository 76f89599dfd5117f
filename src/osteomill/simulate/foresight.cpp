// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/simulate/foresight.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"

namespace osteomill::simulate {
namespace {

struct Found {
  std::vector<double> forces;  ///< mean, N
  std::vector<double> peaks;   ///< N
  std::vector<double> rises;   ///< K
};

/// What every place answers when the path is milled at one feed.
Found milled_at(Workpiece& workpiece, Machine machine, double feed, const ForesightOptions& options,
                const Progress& progress) {
  const double spacing = options.spacing;
  machine.servo.reset();
  machine.force_noise = 0.0;
  machine.start_feed = feed;
  // Periods of one spacing, of whole samples.
  machine.period =
      std::max(1.0, std::round(spacing / feed * machine.sample_rate)) / machine.sample_rate;
  Milling milling(workpiece, machine, 1.0);
  for (int period = 0; !milling.finished(); ++period) {
    milling.advance({feed, 0, false});
    if (period % 50 == 0 &&
        !go_on(progress, "looking ahead", milling.report().position / workpiece.length()))
      break;
  }
  const auto count = static_cast<std::size_t>(std::ceil(workpiece.length() / spacing)) + 1;
  const std::vector<double> none(count, 0.0);
  Found found{none, none, none};
  // As many periods as a revolution takes.
  const auto turn = static_cast<std::size_t>(
      std::ceil(2.0 * std::numbers::pi / machine.spindle_speed / machine.period));
  double from = 0.0;
  const std::vector<Step>& steps = milling.steps();
  for (std::size_t at = 0; at < steps.size(); ++at) {
    const Step& step = steps[at];
    double peak = 0.0;
    for (std::size_t k = 0; k < std::min(turn, at + 1); ++k)
      peak = std::max(peak, steps[at - k].peak_force);
    const auto first = static_cast<std::size_t>(std::max(0.0, std::floor(from / spacing)));
    const auto last = static_cast<std::size_t>(std::ceil(step.position / spacing));
    for (std::size_t i = first; i <= last && i < count; ++i) {
      found.forces[i] = std::max(found.forces[i], step.mean_force);
      found.peaks[i] = std::max(found.peaks[i], peak);
      found.rises[i] = std::max(found.rises[i], step.temperature - options.body_temperature);
    }
    from = step.position;
  }
  return found;
}

}  // namespace

Foresight foresee(const std::function<std::unique_ptr<Workpiece>()>& fresh, const Machine& machine,
                  const ForesightOptions& options, const Progress& progress) {
  require_positive("map.spacing_mm", options.spacing / units::mm, "mm");
  require_positive("map.slow_feed_mm_per_s", options.slow_feed / units::mm_per_s, "mm/s");
  if (!(options.fast_feed > options.slow_feed)) {
    throw InvalidInput(Fault{"limits.max_feed_mm_per_s",
                             std::to_string(options.fast_feed / units::mm_per_s) + " mm/s",
                             "must be greater than the feed that the map is found at", ""});
  }
  // The spindle is that of each copy: the drive is not asked.
  Machine held = machine;
  held.spindle.reset();
  const std::unique_ptr<Workpiece> first = fresh();
  const Found at_slow = milled_at(*first, held, options.slow_feed, options, progress);
  const std::unique_ptr<Workpiece> second = fresh();
  const Found at_fast = milled_at(*second, held, options.fast_feed, options, progress);
  Foresight found;
  found.spacing = options.spacing;
  const double between = options.fast_feed - options.slow_feed;
  const auto line = [&](const std::vector<double>& slow, const std::vector<double>& fast,
                        std::vector<double>& gains, std::vector<double>& edges) {
    for (std::size_t i = 0; i < slow.size(); ++i) {
      const double gain = std::max(0.0, (fast[i] - slow[i]) / between);
      gains.push_back(gain);
      edges.push_back(std::max(0.0, slow[i] - gain * options.slow_feed));
    }
  };
  line(at_slow.forces, at_fast.forces, found.gains, found.edges);
  line(at_slow.peaks, at_fast.peaks, found.peak_gains, found.peak_edges);
  if (options.body_temperature > 0.0) {
    found.slow_rises = at_slow.rises;
    found.fast_rises = at_fast.rises;
    if (options.other_speed > 0.0) {
      held.spindle_speed = options.other_speed;
      const std::unique_ptr<Workpiece> third = fresh();
      found.other_rises = milled_at(*third, held, options.fast_feed, options, progress).rises;
    }
  }
  return found;
}

}  // namespace osteomill::simulate
