// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/robot/fixation.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"

namespace osteomill::robot {

const std::vector<FixationTest>& fixation_tests() {
  static const std::vector<FixationTest> tests = {
      {Fixation::augmented, 1, 0.721, {0.0035, 0.0007, 0.0012}, 0.0030, {0.0018, 0.0024, 0.0043}},
      {Fixation::augmented, 2, 0.674, {0.0031, 0.0013, 0.0032}, 0.0026, {0.0030, 0.0031, 0.0036}},
      {Fixation::augmented, 3, 0.520, {0.0160, 0.0023, -0.0002}, 0.0154, {0.0169, 0.0016, 0.0116}},
      {Fixation::bicortical, 2, 0.674, {0.0079, 0.0007, 0.0035}, 0.0084, {0.0052, 0.0017, 0.0099}},
      {Fixation::bicortical, 3, 0.520, {0.0074, 0.0000, 0.0026}, 0.0080, {0.0090, 0.0004, 0.0051}},
  };
  return tests;
}

FixationTest fixation_at(Fixation fixation, double mineral_density) {
  std::vector<FixationTest> tests;
  for (const FixationTest& test : fixation_tests()) {
    if (test.fixation == fixation) tests.push_back(test);
  }
  std::sort(tests.begin(), tests.end(), [](const FixationTest& a, const FixationTest& b) {
    return a.mineral_density < b.mineral_density;
  });
  require_within("bone.mineral_density_g_per_cm2", mineral_density, tests.front().mineral_density,
                 tests.back().mineral_density, "g/cm2");
  for (std::size_t i = 1; i < tests.size(); ++i) {
    const FixationTest& a = tests[i - 1];
    const FixationTest& b = tests[i];
    if (mineral_density > b.mineral_density) continue;
    const double t =
        (mineral_density - a.mineral_density) / (b.mineral_density - a.mineral_density);
    FixationTest mix = t < 0.5 ? a : b;
    mix.mineral_density = mineral_density;
    mix.displacement_magnitude =
        (1.0 - t) * a.displacement_magnitude + t * b.displacement_magnitude;
    for (std::size_t k = 0; k < 3; ++k) {
      mix.displacement[k] = (1.0 - t) * a.displacement[k] + t * b.displacement[k];
      mix.rotation[k] = (1.0 - t) * a.rotation[k] + t * b.rotation[k];
    }
    return mix;
  }
  return tests.front();
}

Compliance fixation_compliance(const FixationTest& test, const Vector3& point, double lever) {
  require_positive("fixation.lever_mm", lever / units::mm, "mm");
  Compliance part{"fixation", point, Matrix6::Zero()};
  for (int k = 0; k < 3; ++k) {
    const auto i = static_cast<std::size_t>(k);
    part.matrix(k, k) = std::max(0.0, test.displacement[i]) * units::mm;
    part.matrix(3 + k, 3 + k) = std::max(0.0, test.rotation[i]) * units::deg / lever;
  }
  return part;
}

}  // namespace osteomill::robot
