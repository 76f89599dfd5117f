// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/vibration/modal.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "osteomill/base/error.hpp"

namespace osteomill::vibration {

double modal_stiffness(const Mode& mode) {
  const double omega = 2.0 * std::numbers::pi * mode.frequency_hz;
  return mode.modal_mass * omega * omega;
}

void check(const std::vector<Mode>& modes) {
  std::vector<Fault> faults;
  if (modes.empty()) {
    faults.push_back({"structure.modes", "", "at least one mode is needed",
                      "add modes = [ { direction = \"x\", frequency_hz = ..., damping_ratio = ..., "
                      "modal_mass_kg = ... } ]"});
  }
  for (std::size_t i = 0; i < modes.size(); ++i) {
    const Mode& mode = modes[i];
    const auto expect = [&](bool good, const char* field, double value, const char* rule) {
      if (good) return;
      faults.push_back(
          {fmt::format("structure.modes[{}].{}", i, field), fmt::format("{:g}", value), rule, ""});
    };
    expect(mode.frequency_hz > 0.0 && std::isfinite(mode.frequency_hz), "frequency_hz",
           mode.frequency_hz, "must be > 0");
    expect(mode.damping_ratio > 0.0 && mode.damping_ratio < 1.0, "damping_ratio",
           mode.damping_ratio, "must lie between 0 and 1: without damping nothing is stable");
    expect(mode.modal_mass > 0.0 && std::isfinite(mode.modal_mass), "modal_mass_kg",
           mode.modal_mass, "must be > 0");
    expect(std::abs(std::hypot(mode.direction_x, mode.direction_y) - 1.0) < 1e-9, "direction",
           std::hypot(mode.direction_x, mode.direction_y), "must be a unit vector");
  }
  if (!faults.empty()) throw InvalidInput(std::move(faults));
}

TipReceptance tip_receptance(const std::vector<Mode>& modes, double frequency_hz) {
  TipReceptance sum{};
  for (const Mode& mode : modes) {
    const double r = frequency_hz / mode.frequency_hz;
    const std::complex<double> one =
        1.0 /
        (modal_stiffness(mode) * std::complex<double>(1.0 - r * r, 2.0 * mode.damping_ratio * r));
    sum.xx += mode.direction_x * mode.direction_x * one;
    sum.xy += mode.direction_x * mode.direction_y * one;
    sum.yy += mode.direction_y * mode.direction_y * one;
  }
  return sum;
}

}  // namespace osteomill::vibration
