// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/control/tuning.hpp"

#include <algorithm>
#include <deque>
#include <numbers>
#include <numeric>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"

namespace osteomill::control {

void check(const TuningRange& range) {
  require_positive("tune.least_gain_n_per_mm_per_s", range.least_gain / 1e3, "N/(mm/s)");
  require_positive("tune.largest_gain_n_per_mm_per_s", range.largest_gain / 1e3, "N/(mm/s)");
  if (range.largest_gain < range.least_gain) {
    throw InvalidInput(Fault{"tune.largest_gain_n_per_mm_per_s",
                             std::to_string(range.largest_gain / 1e3) + " N/(mm/s)",
                             "must not be less than least_gain_n_per_mm_per_s", ""});
  }
  require_within("tune.delay_updates[0]", range.least_delay, 1, 100, "");
  require_within("tune.delay_updates[1]", range.largest_delay, range.least_delay, 100, "");
  if (range.servo) numerics::check(*range.servo, "machine.servo");
  require_positive("controller.period_ms", range.period / units::ms, "ms");
}

void check(const TuningGoal& goal) {
  require_within("tune.gain_margin", goal.gain_margin, 1.0, 100.0, "");
  require_within("tune.phase_margin_deg", goal.phase_margin / units::deg, 0.0, 89.0, "deg");
}

std::vector<LinearPlant> corners(const TuningRange& range) {
  check(range);
  std::vector<LinearPlant> plants;
  for (const int delay : {range.least_delay, range.largest_delay}) {
    for (const double gain : {range.least_gain, range.largest_gain}) {
      plants.push_back({gain, range.servo, range.period, delay});
    }
  }
  return plants;
}

double largest_gain(const TuningRange& range, const TuningGoal& goal) {
  check(goal);
  const std::vector<LinearPlant> plants = corners(range);
  const auto holds = [&](double gain) {
    return std::all_of(plants.begin(), plants.end(), [&](const LinearPlant& plant) {
      const Margins found = margins(plant, gain);
      return found.gain_margin >= goal.gain_margin && found.phase_margin >= goal.phase_margin;
    });
  };
  // Both margins fall as the gain grows; above critical in the hardest bone there is none.
  double high = margins({range.largest_gain, range.servo, range.period, range.largest_delay}, 1e-6)
                    .critical_loop_gain /
                range.largest_gain;
  double low = 0.0;
  for (int i = 0; i < 40; ++i) {  // to 1e-12 of the critical gain
    const double middle = 0.5 * (low + high);
    (holds(middle) ? low : high) = middle;
  }
  return low;
}

std::vector<double> step_response(const LinearPlant& plant, double gain, int periods) {
  require_positive("gain", gain, "m/s per N");
  require_positive("force_gain", plant.force_gain, "N/(m/s)");
  require_within("delay_updates", plant.delay_updates, 1, 100, "");
  std::optional<numerics::HeldLag> servo;
  if (plant.servo) servo.emplace(*plant.servo, plant.period);
  numerics::LagState state;
  std::deque<double> forces(static_cast<std::size_t>(plant.delay_updates), 0.0);  // newest first
  std::deque<double> taps(kSugitaTaps, 0.0);
  double reference = 0.0;
  std::vector<double> response;
  for (int i = 0; i < periods; ++i) {
    taps.push_front(1.0 - forces.back());
    taps.pop_back();
    reference += gain * std::accumulate(taps.begin(), taps.end(), 0.0);
    double feed = reference;
    if (servo) {
      const numerics::LagState next = servo->advance({0.0, state.value, state.rate}, reference);
      feed = next.integral / plant.period;
      state = next;
    }
    forces.push_front(plant.force_gain * feed);
    forces.pop_back();
    response.push_back(forces.front());
  }
  return response;
}

}  // namespace osteomill::control
