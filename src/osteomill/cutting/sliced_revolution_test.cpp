// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/cutting/sliced_revolution.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"

namespace osteomill::cutting {
namespace {

CuttingLaw bovine() {
  CuttingLaw law;
  law.tangential = {LogLaw{0.42083, 0.58122, -0.06584}, LogLaw{0.27242, 0.66537, -0.08710}};
  law.radial = {LogLaw{0.62379, 0.43160, -0.20553}, LogLaw{0.64731, 0.17764, -0.06681}};
  law.lateral = DirectionalLaw{LogLaw{-0.19495, 0.61971, -0.07352}, {}};
  law.lateral_inclination = 0.5;
  return law;
}

Cutter cutter(CutterShape shape, int flutes) { return {shape, 3e-3, flutes, 0.5, 0.0, 20e-3}; }

const Condition kCondition{500.0, 7e-6, 0.0, fibre_at_angle(0.4)};

TEST(SlicedRevolution, InVectorsEqualsOneElementAfterTheOther) {
  for (const CutterShape shape : {CutterShape::cylindrical, CutterShape::ball}) {
    for (const ImmersionKind kind : {ImmersionKind::slot, ImmersionKind::up, ImmersionKind::down}) {
      for (const double elevation : {0.0, -0.3}) {
        Condition condition = kCondition;
        condition.feed_elevation = elevation;
        const Immersion cut{kind, 1.1e-3, 4e-3};
        const auto run = [&](bool vectorise) {
          return sliced_revolution(cutter(shape, 3), bovine(), condition, cut,
                                   {181, 17, vectorise});
        };
        const SlicedRevolution fast = run(true);
        const SlicedRevolution slow = run(false);
        double largest = 0.0;
        for (const double x : slow.x) largest = std::max(largest, std::abs(x));
        for (std::size_t i = 0; i < slow.x.size(); ++i) {
          EXPECT_NEAR(fast.x[i], slow.x[i], 1e-12 * largest);
          EXPECT_NEAR(fast.y[i], slow.y[i], 1e-12 * largest);
          EXPECT_NEAR(fast.z[i], slow.z[i], 1e-12 * largest);
        }
      }
    }
  }
}

/// Largest difference to the exact revolution over the largest force.
double error(const CuttingLaw& law, const Condition& condition, int slices) {
  const Immersion slot{ImmersionKind::slot, 0.0, 5e-3};
  const Cutter tool = cutter(CutterShape::cylindrical, 2);
  const SlicedRevolution sliced = sliced_revolution(tool, law, condition, slot, {36, slices});
  const Revolution exact = revolution(tool, law, condition, slot, 36);
  double worst = 0.0;
  double largest = 0.0;
  for (std::size_t i = 0; i < exact.loads.size(); ++i) {
    const auto& f = exact.loads[i].force;
    worst = std::max(worst, std::hypot(f.x() - sliced.x[i], f.y() - sliced.y[i]));
    largest = std::max(largest, f.norm());
  }
  return worst / largest;
}

TEST(SlicedRevolution, ConvergesAtSecondOrderForALawWithoutEdgeForce) {
  CuttingLaw law;
  law.tangential = {LinearLaw{200e6, 0.0}, {}};
  law.radial = {LinearLaw{90e6, 0.0}, {}};
  // The force along the edge is continuous and has a kink at entry and exit: second order.
  const double coarse = error(law, kCondition, 40);
  const double fine = error(law, kCondition, 160);
  EXPECT_LT(fine, coarse / 10.0);
  EXPECT_LT(fine, 1e-4);
}

TEST(SlicedRevolution, OfTheLogLawIsCloseWithAHundredSlices) {
  EXPECT_LT(error(bovine(), kCondition, 100), 5e-3);  // infinite slope at entry and exit
}

TEST(SlicedRevolution, RefusesUnequalFlutes) {
  Cutter uneven = cutter(CutterShape::cylindrical, 2);
  uneven.run_out.offset = 1e-6;
  EXPECT_THROW(sliced_revolution(uneven, bovine(), kCondition, {ImmersionKind::slot, 0.0, 4e-3}),
               InvalidInput);
}

}  // namespace
}  // namespace osteomill::cutting
