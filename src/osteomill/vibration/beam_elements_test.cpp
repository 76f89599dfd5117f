// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/vibration/beam_elements.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/vibration/exact_beam.hpp"

namespace osteomill::vibration {
namespace {

using units::mm;

Beam thesis_tool(double pin) {
  return {.segments = {{.length = 100 * mm, .diameter = 3.1 * mm}},
          .supports = {{.position = 0.0, .type = SupportType::clamp},
                       {.position = pin, .type = SupportType::pin}},
          .youngs_modulus = 197 * units::gpa,
          .density = 7850.0};
}

double relative_miss(const Beam& beam, int elements, Mesh mesh, int mode) {
  const BeamModel model(beam, {.elements = elements, .mesh = mesh});
  const double exact = exact_natural_frequencies(beam, mode + 1)[mode];
  return model.natural_frequencies_hz()[mode] / exact - 1.0;
}

TEST(BeamElements, ConvergeWithFourthOrderFromAboveWhenThePinIsANode) {
  const Beam beam = thesis_tool(50 * mm);
  for (const int mode : {0, 1, 2}) {
    const double coarse = relative_miss(beam, 8, Mesh::equal, mode);
    const double fine = relative_miss(beam, 16, Mesh::equal, mode);
    EXPECT_GT(fine, 0.0);  // a restricted shape is never softer: Rayleigh's principle
    EXPECT_NEAR(std::log2(coarse / fine), 4.0, 0.15) << mode;
  }
}

TEST(BeamElements, ConvergeWithThirdOrderOnlyWhenThePinStandsBetweenNodes) {
  // The shear force jumps inside an element. 1/3 keeps its place in the element under halving
  // (2/3 and 1/3 alternate), so the order is seen over two halvings.
  const Beam beam = thesis_tool(100.0 / 3.0 * mm);
  const double coarse = relative_miss(beam, 10, Mesh::equal, 0);
  const double fine = relative_miss(beam, 40, Mesh::equal, 0);
  const double order = 0.5 * std::log2(coarse / fine);
  EXPECT_GT(order, 2.6);
  EXPECT_LT(order, 3.4);
  EXPECT_LT(relative_miss(beam, 10, Mesh::aligned, 0), 0.02 * coarse);
}

TEST(BeamElements, NineElementsOfTheThesisComeWithinATenthOfAPercentOfTheExactBeam) {
  // Nodes 5 and 7 of ten equally spaced ones: 44.4 and 66.7 mm.
  for (const int node : {4, 5, 6}) {
    EXPECT_LT(relative_miss(thesis_tool(100.0 * node / 9.0 * mm), 9, Mesh::equal, 0), 1e-3);
  }
}

TEST(BeamElements, StaticComplianceIsTheBeamFormula) {
  Beam beam = thesis_tool(66 * mm);
  beam.supports.pop_back();
  const double ei = section(beam, beam.segments[0]).bending_stiffness;
  const BeamModel model(beam, {.elements = 7, .mesh = Mesh::equal});
  const double a = 62 * mm, b = 100 * mm;
  // Elements with cubic shapes are exact at their nodes for nodal loads.
  const double tip = std::pow(b, 3) / (3.0 * ei);
  EXPECT_NEAR(model.static_compliance(b, b), tip, 1e-8 * tip);
  EXPECT_NEAR(model.static_compliance(a, b), model.static_compliance(b, a), 1e-12 * tip);
  const BeamModel fine(beam, {.elements = 50, .mesh = Mesh::equal});
  EXPECT_NEAR(fine.static_compliance(a, b), a * a * (3.0 * b - a) / (6.0 * ei), 1e-7 * tip);
}

TEST(BeamElements, TimoshenkoApproachesEulerBernoulliForSlenderShaftsOnly) {
  Beam beam = thesis_tool(66 * mm);
  const auto ratio = [&](int mode) {
    const BeamModel stout(beam, {.elements = 60, .theory = BeamTheory::timoshenko});
    return stout.natural_frequencies_hz()[mode] / exact_natural_frequencies(beam, mode + 1)[mode];
  };
  EXPECT_LT(ratio(0), 1.0);
  EXPECT_GT(ratio(0), 0.99);
  beam.segments[0].diameter = 15 * mm;
  EXPECT_LT(ratio(0), 0.95);
}

TEST(BeamElements, TimoshenkoGivesTheKnownSolutionOfAPinnedPinnedShaft) {
  // For sine shapes the frequency solves ρA ρI ω⁴ − … in closed form: mode n of length l.
  Beam beam = thesis_tool(0.0);
  beam.segments[0].diameter = 10 * mm;
  beam.supports = {{.position = 0.0, .type = SupportType::pin},
                   {.position = 100 * mm, .type = SupportType::pin}};
  const Section s = section(beam, beam.segments[0]);
  const BeamModel model(beam, {.elements = 80, .theory = BeamTheory::timoshenko});
  const BeamModel half(beam, {.elements = 40, .theory = BeamTheory::timoshenko});
  for (int n = 1; n <= 3; ++n) {
    const double k = n * std::numbers::pi / 0.1;
    // −ρA ω² W + κGA (k² W − k Θ) = 0;  −ρI ω² Θ + EI k² Θ + κGA (Θ − k W) = 0.
    const double g = s.shear_stiffness, m = s.mass_per_length, j = s.rotary_inertia;
    const double a = m * j;
    const double b = -(m * (s.bending_stiffness * k * k + g) + j * g * k * k);
    const double c = g * k * k * s.bending_stiffness * k * k;
    const double omega = std::sqrt((-b - std::sqrt(b * b - 4.0 * a * c)) / (2.0 * a));
    const double expected = omega / (2.0 * std::numbers::pi);
    // The shear strain is constant along an element: second order in its share of the deflection.
    const double fine = model.natural_frequencies_hz()[n - 1] / expected - 1.0;
    const double coarse = half.natural_frequencies_hz()[n - 1] / expected - 1.0;
    EXPECT_NEAR(coarse / fine, 4.0, 0.4) << n;
    EXPECT_LT(std::abs(fine), 1e-5 * n * n) << n;
  }
}

TEST(BeamElements, SpinningShaftSplitsEachModeIntoBackwardAndForwardWhirl) {
  Beam beam = thesis_tool(66 * mm);
  beam.segments[0].diameter = 10 * mm;
  const BeamModel model(beam, {.elements = 30, .theory = BeamTheory::timoshenko});
  const double rest = model.natural_frequencies_hz()[0];
  const auto still = model.whirl_frequencies_hz(0.0, 2);
  EXPECT_NEAR(still[0], rest, 1e-8 * rest);
  EXPECT_NEAR(still[1], rest, 1e-8 * rest);
  const auto turning = model.whirl_frequencies_hz(100000 * units::rpm, 2);
  EXPECT_LT(turning[0], rest);
  EXPECT_GT(turning[1], rest);
  // First order of perturbation: the split is symmetric, and doubles with the speed.
  const auto half = model.whirl_frequencies_hz(50000 * units::rpm, 2);
  EXPECT_NEAR((turning[1] - turning[0]) / (half[1] - half[0]), 2.0, 1e-2);
  // Opposite spin is the same by mirror symmetry.
  EXPECT_NEAR(model.whirl_frequencies_hz(-100000 * units::rpm, 2)[0], turning[0], 1e-7 * rest);
}

TEST(BeamElements, TipModesSumToTheExactReceptance) {
  const Beam beam = thesis_tool(66 * mm);
  const BeamModel model(beam, {.elements = 60});
  const auto modes = tip_modes(model, 100 * mm, 40, 1e-9, 0.0, 1.0);
  for (const double f : {0.0, 500.0, 1500.0, 2500.0}) {
    const TipReceptance h = tip_receptance(modes, f);
    const double exact = exact_tip_receptance(beam, f);
    // 40 modes leave out a tail of order 1/40³ of the static compliance.
    EXPECT_NEAR(h.yy.real(), exact, 1e-4 * exact_tip_receptance(beam, 0.0)) << f;
    EXPECT_EQ(std::abs(h.xx), 0.0);
  }
}

}  // namespace
}  // namespace osteomill::vibration
