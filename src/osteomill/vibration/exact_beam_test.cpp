// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/vibration/exact_beam.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"

namespace osteomill::vibration {
namespace {

using ::testing::HasSubstr;
using units::mm;

Beam shaft() {  // the M10 mill of [plaskos2002] §4.3.1 without its flutes
  return {.segments = {{.length = 100 * mm, .diameter = 3.1 * mm}},
          .supports = {{.position = 0.0, .type = SupportType::clamp}},
          .youngs_modulus = 197 * units::gpa,
          .density = 7850.0};
}

Beam pinned_shaft(double at) {
  Beam beam = shaft();
  beam.supports.push_back({.position = at, .type = SupportType::pin});
  return beam;
}

/// κ² l² of a natural frequency.
double squared_wave_number(const Beam& beam, double frequency_hz, double l) {
  const Section s = section(beam, beam.segments.front());
  return 2.0 * std::numbers::pi * frequency_hz *
         std::sqrt(s.mass_per_length / s.bending_stiffness) * l * l;
}

TEST(ExactBeam, GivesTheCantileversRoots) {
  const Beam beam = shaft();
  const auto f = exact_natural_frequencies(beam, 3);
  // Tabulated roots of cos x cosh x = −1, four decimals.
  EXPECT_NEAR(squared_wave_number(beam, f[0], 100 * mm), 3.5160, 5e-5);
  EXPECT_NEAR(squared_wave_number(beam, f[1], 100 * mm), 22.0345, 5e-5);
  EXPECT_NEAR(squared_wave_number(beam, f[2], 100 * mm), 61.6972, 5e-5);
}

TEST(ExactBeam, GivesTheSimplySupportedRootsForTwoPins) {
  Beam beam = shaft();
  beam.supports = {{.position = 0.0, .type = SupportType::pin},
                   {.position = 100 * mm, .type = SupportType::pin}};
  const auto f = exact_natural_frequencies(beam, 4);
  for (int n = 1; n <= 4; ++n) {
    const double expected = std::pow(n * std::numbers::pi, 2);
    EXPECT_NEAR(squared_wave_number(beam, f[n - 1], 100 * mm), expected, 1e-9 * expected);
  }
}

TEST(ExactBeam, ReproducesTheComputedFrequenciesOfTheThesisTool) {
  // Independent computation, five digits; the thesis itself prints 5-10 % more.
  const auto near = exact_natural_frequencies(pinned_shaft(66 * mm), 2);
  EXPECT_NEAR(near[0], 1034.05, 2e-5 * 1034.05);
  EXPECT_NEAR(near[1], 2847.57, 2e-5 * 2847.57);
  const auto far = exact_natural_frequencies(pinned_shaft(44 * mm), 2);
  EXPECT_NEAR(far[0], 516.17, 2e-5 * 516.17);
  EXPECT_NEAR(far[1], 3459.66, 2e-5 * 3459.66);
}

TEST(ExactBeam, RootsAreZerosOfThePrintedDeterminant) {
  const Beam beam = pinned_shaft(66 * mm);
  for (const double f : exact_natural_frequencies(beam, 3)) {
    const double kappa = std::sqrt(squared_wave_number(beam, f, 1.0));
    const double below = clamp_pin_determinant(kappa * (1.0 - 1e-9), 66 * mm, 34 * mm);
    const double above = clamp_pin_determinant(kappa * (1.0 + 1e-9), 66 * mm, 34 * mm);
    EXPECT_LT(below * above, 0.0) << f;
  }
}

TEST(ExactBeam, PinThatMovesToTheClampMakesACantileverAgain) {
  const double free_length = 34 * mm;
  double previous = 1.0;
  for (const double supported : {4.0, 1.0, 0.25}) {
    Beam beam = pinned_shaft(supported * mm);
    beam.segments.front().length = supported * mm + free_length;
    const auto f = exact_natural_frequencies(beam, 2);
    const double miss = 1.0 - squared_wave_number(beam, f[0], free_length) / 3.5160153;
    // A short span beside the pin turns by L_s/4 of a clamp's moment: first order in L_s.
    EXPECT_GT(miss, 0.0);
    EXPECT_LT(miss, 0.3 * previous);
    previous = miss;
    EXPECT_NEAR(squared_wave_number(beam, f[1], free_length), 22.0345, 22.0 * supported / 34.0);
  }
}

TEST(ExactBeam, DoesNotDependOnHowItIsCutIntoSegments) {
  const Beam whole = pinned_shaft(66 * mm);
  Beam pieces = whole;
  pieces.segments = {{.length = 13 * mm, .diameter = 3.1 * mm},
                     {.length = 60 * mm, .diameter = 3.1 * mm},
                     {.length = 27 * mm, .diameter = 3.1 * mm}};
  const auto a = exact_natural_frequencies(whole, 6);
  const auto b = exact_natural_frequencies(pieces, 6);
  for (int i = 0; i < 6; ++i) EXPECT_NEAR(a[i], b[i], 1e-9 * a[i]);
}

TEST(ExactBeam, StiffSpringBecomesAPinAndSoftSpringNothing) {
  const auto with_spring = [](double stiffness) {
    Beam beam = shaft();
    beam.supports.push_back(
        {.position = 66 * mm, .type = SupportType::spring, .stiffness = stiffness});
    return exact_natural_frequencies(beam, 1)[0];
  };
  EXPECT_NEAR(with_spring(1e12), exact_natural_frequencies(pinned_shaft(66 * mm), 1)[0], 1e-2);
  EXPECT_NEAR(with_spring(1e-6), exact_natural_frequencies(shaft(), 1)[0], 1e-6);
}

TEST(ExactBeam, TipReceptanceBeginsAtTheStaticOneAndChangesSignAtResonance) {
  const Beam beam = shaft();
  const Section s = section(beam, beam.segments.front());
  const double compliance = std::pow(0.1, 3) / (3.0 * s.bending_stiffness);
  EXPECT_NEAR(exact_tip_receptance(beam, 0.0), compliance, 1e-10 * compliance);
  const double f = exact_natural_frequencies(beam, 1)[0];
  EXPECT_GT(exact_tip_receptance(beam, f * 0.999), 0.0);
  EXPECT_LT(exact_tip_receptance(beam, f * 1.001), 0.0);
}

TEST(ExactBeam, ModeShapeIsZeroAtThePinAndLargestAtTheTip) {
  const Beam beam = pinned_shaft(66 * mm);
  const auto f = exact_natural_frequencies(beam, 1);
  const auto shape = exact_mode_shape(beam, f[0], {0.0, 33 * mm, 66 * mm, 83 * mm, 100 * mm});
  EXPECT_NEAR(shape[0], 0.0, 1e-9);
  EXPECT_NEAR(shape[2], 0.0, 1e-9);
  EXPECT_LT(shape[1], 0.0);
  EXPECT_GT(shape[3], 0.0);
  EXPECT_DOUBLE_EQ(shape[4], 1.0);
}

TEST(Beam, TubeAroundTheShaftAddsItsStiffness) {
  // [plaskos2006] §5.5.3: K = 3E(I_T + I_C)/L³, 264.8 and 45.4 N/mm at 50 and 90 mm.
  for (const auto& [extension, printed] : {std::pair{50.0, 264.8}, std::pair{90.0, 45.4}}) {
    const Beam beam{.segments = {{.length = extension * mm,
                                  .diameter = 3.17 * mm,
                                  .tube_outer_diameter = 6 * mm,
                                  .tube_inner_diameter = 4 * mm}},
                    .supports = {{.position = 0.0, .type = SupportType::clamp}},
                    .youngs_modulus = 197 * units::gpa,
                    .density = 7850.0};
    EXPECT_NEAR(1.0 / exact_tip_receptance(beam, 0.0) * mm, printed, 0.05);
  }
}

struct BadBeam {
  const char* field;
  void (*spoil)(Beam&);
};

class BadBeams : public ::testing::TestWithParam<BadBeam> {};

TEST_P(BadBeams, AreNamed) {
  Beam beam = pinned_shaft(66 * mm);
  GetParam().spoil(beam);
  try {
    exact_natural_frequencies(beam, 1);
    FAIL() << GetParam().field;
  } catch (const InvalidInput& error) {
    EXPECT_THAT(error.what(), HasSubstr(GetParam().field));
  }
}

INSTANTIATE_TEST_SUITE_P(
    All, BadBeams,
    ::testing::Values(
        BadBeam{"beam.youngs_modulus_gpa", [](Beam& b) { b.youngs_modulus = 0.0; }},
        BadBeam{"beam.density_kg_per_m3", [](Beam& b) { b.density = -1.0; }},
        BadBeam{"beam.poissons_ratio", [](Beam& b) { b.poissons_ratio = 0.5; }},
        BadBeam{"beam.segments", [](Beam& b) { b.segments.clear(); }},
        BadBeam{"beam.segments[0].length_mm", [](Beam& b) { b.segments[0].length = NAN; }},
        BadBeam{"beam.segments[0].diameter_mm", [](Beam& b) { b.segments[0].diameter = 0.0; }},
        BadBeam{"beam.segments[0].inner_diameter_mm",
                [](Beam& b) { b.segments[0].inner_diameter = 4 * mm; }},
        BadBeam{"beam.segments[0].effective_diameter_factor",
                [](Beam& b) { b.segments[0].effective_diameter_factor = 1.2; }},
        BadBeam{"beam.segments[0].tube_inner_diameter_mm",
                [](Beam& b) { b.segments[0].tube_inner_diameter = 1 * mm; }},
        BadBeam{"beam.supports[1].at_mm", [](Beam& b) { b.supports[1].position = 0.2; }},
        BadBeam{"beam.supports[1].stiffness_n_per_mm",
                [](Beam& b) { b.supports[1].stiffness = -1.0; }},
        BadBeam{"beam.supports", [](Beam& b) { b.supports = {b.supports[1]}; }}));

}  // namespace
}  // namespace osteomill::vibration
