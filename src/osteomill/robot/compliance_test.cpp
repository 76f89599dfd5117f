// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/robot/compliance.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/robot/fixation.hpp"

namespace osteomill::robot {
namespace {

using units::deg;
using units::mm;
using units::n_per_mm;

TEST(Compliance, OfTheMillingTubeIsThePublishedOne) {
  // [plaskos2006] 5.5.3: K50 = 264.8 and K90 = 45.4 N/mm, printed to one decimal.
  EXPECT_NEAR(tip_stiffness(milling_tube(50.0 * mm)) / n_per_mm, 264.8, 0.05);
  EXPECT_NEAR(tip_stiffness(milling_tube(90.0 * mm)) / n_per_mm, 45.4, 0.05);
}

TEST(Compliance, OfTwoHalfBeamsInSeriesIsThatOfTheWhole) {
  const Vector3 direction = Vector3(1.0, 2.0, -0.5).normalized();
  const Vector3 root(0.01, 0.02, 0.03);
  const Compliance whole = cantilever("whole", root, direction, milling_tube(80.0 * mm));
  const Compliance first = cantilever("first", root, direction, milling_tube(30.0 * mm));
  const Compliance second =
      cantilever("second", root + 30.0 * mm * direction, direction, milling_tube(50.0 * mm));
  const Compliance both = series("both", {second, first});
  EXPECT_LT((both.matrix - whole.matrix).norm(), 1e-10 * whole.matrix.norm());
}

TEST(Compliance, IsSymmetricAndKeepsItsWorkWhenMoved) {
  const Compliance beam = cantilever("beam", Vector3::Zero(), Vector3::UnitX(), milling_tube(0.05));
  const Compliance moved = moved_to(beam, {0.02, -0.03, 0.01});
  EXPECT_LT((moved.matrix - moved.matrix.transpose()).norm(), 1e-15);
  EXPECT_LT((moved_to(moved, beam.point).matrix - beam.matrix).norm(), 1e-12 * beam.matrix.norm());
}

TEST(Compliance, OfTwoEqualPartsSideBySideIsHalf) {
  const Compliance beam = cantilever("beam", Vector3::Zero(), Vector3::UnitX(), milling_tube(0.05));
  const Compliance two = parallel("two", {beam, beam});
  EXPECT_LT((two.matrix - 0.5 * beam.matrix).norm(), 1e-9 * beam.matrix.norm());
}

TEST(Compliance, SharesOfTheChainAddUpToTheDeflection) {
  const Vector3 edge(0.1, 0.02, 0.0);
  const std::vector<Compliance> chain = {
      translation_spring("adjustment", Vector3::Zero(), Vector3::Constant(500.0 * n_per_mm)),
      hinge_spring("gear", {0.0, 0.0, 0.0}, Vector3::UnitZ(), 1100.0),
      cantilever("tube", {0.05, 0.02, 0.0}, Vector3::UnitX(), milling_tube(0.05))};
  const EdgeDeflection result = deflection_at(chain, edge, {0.0, 50.0, 0.0});
  Vector3 sum = Vector3::Zero();
  for (const auto& share : result.shares) sum += share.translation;
  EXPECT_LT((sum - result.translation).norm(), 1e-15);
  // By hand: 50/500e3 + 50 * 0.1^2 / 1100 + 50/264.8e3.
  EXPECT_NEAR(result.translation.y(), 1e-4 + 50.0 * 0.01 / 1100.0 + 50.0 / 264.8e3, 1e-8);
}

TEST(StrainWaveGear, WindsUpByATenthOfADegreeAtTwoNewtonMetres) {
  const StrainWaveGear gear = size8_gear();
  // [plaskos2006] 5.4: "~0.1°", one digit.
  EXPECT_NEAR(wind_up(gear, 2.0) / deg, 0.1, 1e-12);
  EXPECT_NEAR(2.0 / size8_secant_stiffness(), wind_up(gear, 2.0), 1e-15);
  EXPECT_EQ(wind_up(gear, -2.0), -wind_up(gear, 2.0));
  for (const double torque : {0.1, 0.29, 0.5, 0.75, 3.0}) {
    const double h = 1e-4;
    const double slope = (wind_up(gear, torque + h) - wind_up(gear, torque)) / h;
    EXPECT_NEAR(slope * gear_stiffness(gear, torque + 0.5 * h), 1.0, 1e-9);
  }
}

TEST(Fixation, HasTheStiffnessThatTheTextQuotes) {
  // [plaskos2006] 5.7: three days, slope of dP: K = 125 N/mm (bicortical).
  EXPECT_NEAR(1.0 / fixation_at(Fixation::bicortical, 0.520).displacement_magnitude, 125.0, 1e-9);
  const double middle = fixation_at(Fixation::augmented, 0.597).displacement_magnitude;
  EXPECT_NEAR(middle, 0.5 * (0.0154 + 0.0026), 1e-12);
  EXPECT_THROW(fixation_at(Fixation::augmented, 0.918), InvalidInput);
  EXPECT_THROW(fixation_at(Fixation::bicortical, 0.721), InvalidInput);
}

TEST(Compliance, RefusesWhatIsNoPart) {
  EXPECT_THROW(series("none", {}), InvalidInput);
  EXPECT_THROW(parallel("rigid", {hinge_spring("hinge", Vector3::Zero(), Vector3::UnitZ(), 1.0)}),
               InvalidInput);
  EXPECT_THROW(hinge_spring("hinge", Vector3::Zero(), Vector3::UnitZ(), 0.0), InvalidInput);
  EXPECT_THROW(cantilever("beam", Vector3::Zero(), Vector3::UnitX(), Beam{}), InvalidInput);
  EXPECT_THROW(fixation_compliance(fixation_tests()[0], Vector3::Zero(), 0.0), InvalidInput);
}

}  // namespace
}  // namespace osteomill::robot
