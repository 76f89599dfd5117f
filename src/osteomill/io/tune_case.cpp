// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/tune_case.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/io/case_file.hpp"
#include "osteomill/io/section.hpp"

namespace osteomill::io {
namespace {

constexpr int kHalvings = 9;  // of the range of forces: to 0.2 % of the limit

const control::SugitaLoop& loop_of(const TuneCase& input) {
  return std::get<control::SugitaLoop>(input.job.controller.law);
}

/// The case with another loop, delay and entry feed.
SimulateCase with(const TuneCase& input, const control::SugitaLoop& loop, double entry_feed,
                  int delay) {
  SimulateCase made = input.job;
  made.controller.law = loop;
  made.machine.delay_updates = delay;
  if (made.controller.predictive) made.controller.predictive->entry_feed = entry_feed;
  return made;
}

std::vector<int> delays_of(const control::TuningRange& range) {
  if (range.least_delay == range.largest_delay) return {range.least_delay};
  return {range.least_delay, range.largest_delay};
}

class Trial {
 public:
  Trial(const TuneCase& input, const Progress& progress) : input_(input), progress_(progress) {}

  std::vector<TunedRun> run(const char* name, const control::SugitaLoop& loop, double entry_feed) {
    std::vector<TunedRun> done;
    for (const int delay : delays_of(input_.range)) {
      const double share = std::min(1.0, ++count_ / (2.0 * kHalvings + 4.0));
      if (!go_on(progress_, "tuning", share)) throw NoSolution("stopped before it was tuned");
      const auto runs = run_simulations({with(input_, loop, entry_feed, delay)});
      done.push_back({name, delay, runs.front().summary});
    }
    return done;
  }

 private:
  const TuneCase& input_;
  const Progress& progress_;
  int count_ = 0;
};

void find_reference(const TuneCase& input, const Progress& progress, Tuning& tuning) {
  const double most = input.share * input.job.force_limit;
  const control::SugitaLoop& given = loop_of(input);
  Trial trial(input, progress);
  const auto entry_of = [&](double reference) {
    return std::min(reference / input.range.largest_gain, input.job.controller.limits.highest);
  };
  const auto peak_at = [&](double reference) {
    control::SugitaLoop loop = tuning.proposed;
    loop.reference_force = reference;
    double peak = 0.0;
    for (const TunedRun& run : trial.run("proposed", loop, entry_of(reference))) {
      if (run.summary.status != simulate::Status::finished) return 2.0 * most;
      peak = std::max(peak, run.summary.peak_force);
    }
    return peak;
  };
  double low = 0.0;
  double high = input.job.force_limit;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = 0.5 * (low + high);
    (peak_at(middle) <= most ? low : high) = middle;
  }
  if (low == 0.0) {
    throw NoSolution(fmt::format(
        "no reference force keeps the peaks of this bone below {:g} N with these gains: ask for "
        "smaller margins, or for a law that looks ahead (model-adaptive, model-predictive)",
        most));
  }
  tuning.proposed.reference_force = low;
  tuning.entry_feed = entry_of(low);
  const double entry = input.job.controller.predictive ? input.job.controller.predictive->entry_feed
                                                       : tuning.entry_feed;
  tuning.runs = trial.run("as given", given, entry);
  const std::vector<TunedRun> proposed = trial.run("proposed", tuning.proposed, tuning.entry_feed);
  tuning.runs.insert(tuning.runs.end(), proposed.begin(), proposed.end());
}

void warn_of_other_bone(const TuneCase& input, Tuning& tuning) {
  const simulate::LineProfile& bone = input.job.stock.profile;
  constexpr double kStep = 0.1e-3;
  // On the line with most of it.
  double harder = 0.0, hardest = 0.0, softer = 0.0, softest = input.range.least_gain;
  for (int line = 0; line < bone.lines; ++line) {
    double hard = 0.0, soft = 0.0;
    for (double x = 0.5 * kStep; x < bone.line_length; x += kStep) {
      const double gain = simulate::gain_at(bone, line, x);
      if (gain > input.range.largest_gain * (1.0 + 1e-9)) hard += kStep;
      if (gain > 0.0 && gain < input.range.least_gain * (1.0 - 1e-9)) {
        soft += kStep;
        softest = std::min(softest, gain);
      }
      hardest = std::max(hardest, gain);
    }
    harder = std::max(harder, hard);
    softer = std::max(softer, soft);
  }
  const auto warn = [&](double gain, double length, const char* side, const char* key) {
    if (length == 0.0) return;
    tuning.warnings.push_back(fmt::format(
        "the bone of the case has {:.3g} N/(mm/s), {} tune.{}, on {:.1f} mm of a line: the margins "
        "do not hold there; the simulated peaks count it",
        gain * units::mm_per_s, side, key, length / units::mm));
  };
  warn(hardest, harder, "above", "largest_gain_n_per_mm_per_s");
  warn(softest, softer, "below", "least_gain_n_per_mm_per_s");
}

}  // namespace

void bind_tune(Section& section, TuneCase& to) {
  bind_simulate(section, to.job);
  section.table("tune", "what the loop has to stand", Need::required, [&](Section& s) {
    const Quantity gain{1e3, "N/(mm/s)"};
    s.number("least_gain_n_per_mm_per_s", to.range.least_gain, gain, positive(),
             "of the softest bone: mean force over feed");
    s.number("largest_gain_n_per_mm_per_s", to.range.largest_gain, gain, positive(),
             "of the hardest bone that lasts");
    std::vector<double> delay = {1.0, 1.0};
    s.numbers("delay_updates", delay, {}, between(1, 100),
              "least and most control periods from a force to its feed", Need::optional);
    if (delay.size() == 2 && delay[0] <= delay[1]) {
      to.range.least_delay = static_cast<int>(delay[0]);
      to.range.largest_delay = static_cast<int>(delay[1]);
    } else {
      s.fault("delay_updates", "must be two numbers, the smaller first");
    }
    s.number("gain_margin", to.goal.gain_margin, {}, between(1.0, 100.0), "at least, a factor",
             Need::optional);
    s.number("phase_margin_deg", to.goal.phase_margin, {units::deg, "deg"}, between(0.0, 89.0),
             "at least", Need::optional);
    s.number("force_share", to.share, {}, between(0.05, 1.0),
             "of limits.force_n that a simulated peak may reach", Need::optional);
  });
}

void bind_tune_keys(Section& section) {
  TuneCase unused;
  bind_tune(section, unused);
}

TuneCase read_tune_case(const CaseRun& run) {
  TuneCase made;
  prepare(made.job, run);
  made.job.expanded = Section::read(run, [&](Section& section) { bind_tune(section, made); });
  complete(made.job);
  if (!std::holds_alternative<control::SugitaLoop>(made.job.controller.law)) {
    throw InvalidInput(Fault{"controller.kind", "", "must be \"sugita\": gains are its own",
                             "the other laws identify the bone and have no gain to tune"});
  }
  made.range.servo = made.job.machine.servo;
  made.range.period = made.job.controller.period;
  control::check(made.range);
  control::check(made.goal);
  return made;
}

Tuning tune(const TuneCase& input, const Progress& progress) {
  const control::SugitaLoop& given = loop_of(input);
  const double unit = control::gain_on_sum(given, 1.0);
  Tuning tuning;
  tuning.proposed = given;
  // Down is what keeps the force; up at half of it, as published.
  tuning.proposed.gain_down = control::largest_gain(input.range, input.goal) / unit;
  tuning.proposed.gain_up = 0.5 * tuning.proposed.gain_down;
  tuning.entry_feed = std::min(given.reference_force / input.range.largest_gain,
                               input.job.controller.limits.highest);
  tuning.bare_critical_loop_gain =
      control::margins({input.range.largest_gain, std::nullopt, input.range.period, 1}, 1e-6)
          .critical_loop_gain;
  for (const control::LinearPlant& plant : control::corners(input.range)) {
    TunedCorner corner{plant, 0.0, {}, {}, {}, {}};
    corner.given_up = control::margins(plant, given.gain_up * unit);
    corner.given_down = control::margins(plant, given.gain_down * unit);
    corner.proposed_up = control::margins(plant, tuning.proposed.gain_up * unit);
    corner.proposed_down = control::margins(plant, tuning.proposed.gain_down * unit);
    corner.critical_gain = corner.given_down.critical_loop_gain / plant.force_gain;
    tuning.corners.push_back(corner);
  }
  if (input.job.stock.kind == StockKind::line_profile) {
    warn_of_other_bone(input, tuning);
    find_reference(input, progress, tuning);
  }
  return tuning;
}

}  // namespace osteomill::io
