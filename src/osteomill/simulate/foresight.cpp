// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/simulate/foresight.hpp"

#include <algorithm>
#include <cmath>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"

namespace osteomill::simulate {
namespace {

/// Mean force at every place when the path is milled at one feed.
std::vector<double> forces_at(Workpiece& workpiece, Machine machine, double feed, double spacing) {
  machine.servo.reset();
  machine.force_noise = 0.0;
  machine.start_feed = feed;
  // Periods of one spacing, of whole samples.
  machine.period =
      std::max(1.0, std::round(spacing / feed * machine.sample_rate)) / machine.sample_rate;
  Milling milling(workpiece, machine, 1.0);
  while (!milling.finished()) milling.advance({feed, 0, false});
  const auto count = static_cast<std::size_t>(std::ceil(workpiece.length() / spacing)) + 1;
  std::vector<double> forces(count, 0.0);
  double from = 0.0;
  for (const Step& step : milling.steps()) {
    const auto first = static_cast<std::size_t>(std::max(0.0, std::floor(from / spacing)));
    const auto last = static_cast<std::size_t>(std::ceil(step.position / spacing));
    for (std::size_t i = first; i <= last && i < count; ++i) {
      forces[i] = std::max(forces[i], step.mean_force);
    }
    from = step.position;
  }
  return forces;
}

}  // namespace

Foresight foresee(const std::function<std::unique_ptr<Workpiece>()>& fresh, const Machine& machine,
                  const ForesightOptions& options) {
  require_positive("map.spacing_mm", options.spacing / units::mm, "mm");
  require_positive("map.slow_feed_mm_per_s", options.slow_feed / units::mm_per_s, "mm/s");
  if (!(options.fast_feed > options.slow_feed)) {
    throw InvalidInput(Fault{"limits.max_feed_mm_per_s",
                             std::to_string(options.fast_feed / units::mm_per_s) + " mm/s",
                             "must be greater than the feed that the map is found at", ""});
  }
  const std::unique_ptr<Workpiece> first = fresh();
  const std::vector<double> slow = forces_at(*first, machine, options.slow_feed, options.spacing);
  const std::unique_ptr<Workpiece> second = fresh();
  const std::vector<double> fast = forces_at(*second, machine, options.fast_feed, options.spacing);
  Foresight found;
  found.spacing = options.spacing;
  for (std::size_t i = 0; i < slow.size(); ++i) {
    const double gain =
        std::max(0.0, (fast[i] - slow[i]) / (options.fast_feed - options.slow_feed));
    found.gains.push_back(gain);
    found.edges.push_back(std::max(0.0, slow[i] - gain * options.slow_feed));
  }
  return found;
}

}  // namespace osteomill::simulate
