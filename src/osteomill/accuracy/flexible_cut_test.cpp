// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/accuracy/flexible_cut.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"

namespace osteomill::accuracy {
namespace {

using cutting::Condition;
using cutting::Cutter;
using cutting::CuttingLaw;
using cutting::Immersion;
using cutting::ImmersionKind;
using cutting::LinearLaw;
using cutting::PowerLaw;
using units::mm;
using units::rpm;

constexpr double kTurn = 2.0 * std::numbers::pi;

// As in tool_deflection_test.cpp: reproduces what [plaskos2002] §4.4.3 quotes.
CuttingLaw thesis_law() {
  const auto law = [](double k, double n) { return PowerLaw{k * units::n_per_mm, n}; };
  return {.tangential = {law(71.1, 0.684), law(63.1, 0.569)},
          .radial = {law(32.5, 0.479), law(18.6, 0.341)},
          .lateral = {}};
}

CuttingLaw linear_law() {
  const LinearLaw tangential{.pressure = 60e6}, radial{.pressure = 25e6};
  return {.tangential = {tangential, tangential}, .radial = {radial, radial}, .lateral = {}};
}

Cutter mill(int flutes, double helix_deg = 0.0) {
  return {.radius = 1.55 * mm,
          .flutes = flutes,
          .helix_angle = helix_deg * units::deg,
          .cutting_length = 35 * mm};
}

Cutter eccentric(int flutes, double offset_um, double helix_deg = 0.0) {
  Cutter cutter = mill(flutes, helix_deg);
  cutter.run_out.offset = offset_um * units::um;
  return cutter;
}

Condition at_feed(double feed_mm_per_s, int flutes) {
  return {.spindle_speed = 20000 * rpm,
          .feed_per_tooth = cutting::feed_per_tooth(feed_mm_per_s * mm, 20000 * rpm, flutes),
          .fibre_T = cutting::fibre_at_angle(std::numbers::pi / 2.0)};
}

Immersion slot(double depth_mm) {
  return {.kind = ImmersionKind::slot, .axial_depth = depth_mm * mm};
}

ToolCompliance tool(double diameter_mm, double length_mm = 35.0) {
  return ToolCompliance::cantilever(length_mm * mm, diameter_mm * mm, 197 * units::gpa);
}

struct ThesisCut {
  int flutes;
  double length_mm, diameter_mm, depth_mm;
};
constexpr std::array<ThesisCut, 6> kThesisCuts = {{{2, 35, 2.54, 35},
                                                   {2, 35, 2.54, 5},
                                                   {2, 55, 2.76, 35},
                                                   {2, 55, 2.76, 5},
                                                   {4, 35, 2.54, 35},
                                                   {4, 55, 2.76, 5}}};

TEST(FlexibleCut, ComesToRestInTheCutsOfTheThesisWithTheDeflectionsOfTheRigidCut) {
  // No run-out: "virtually identical" forces, [plaskos2002] §4.5.5.3. What is left are roundings.
  for (const ThesisCut& cut : kThesisCuts) {
    const ToolCompliance held = tool(cut.diameter_mm, cut.length_mm);
    const Condition feed = at_feed(50.0 / (3.1 * cut.depth_mm), cut.flutes);
    const DeflectionOptions coarse{.slice_height = 2.5 * mm, .steps = 120};
    const FlexibleCut flexible =
        flexible_cut(held, mill(cut.flutes), thesis_law(), feed, slot(cut.depth_mm), coarse);
    const ToolDeflection rigid =
        tool_deflection(held, mill(cut.flutes), thesis_law(), feed, slot(cut.depth_mm), coarse);
    EXPECT_EQ(flexible.rest, Rest::at_rest) << cut.flutes << " " << cut.depth_mm;
    EXPECT_LT(flexible.residual, 1e-12);
    EXPECT_NEAR(flexible.total_tip, rigid.total_tip, 1e-9 * rigid.total_tip);
    ASSERT_EQ(flexible.surface.error.size(), rigid.surface.error.size());
    for (std::size_t i = 0; i < rigid.surface.error.size(); ++i) {
      EXPECT_NEAR(flexible.surface.error[i], rigid.surface.error[i], 1e-12);
    }
  }
}

TEST(FlexibleCut, OfAStiffToolIsTheRigidOneWithRunOutToo) {
  // A tool of 200 mm bends a millionth of a slender one: chips of the rigid model.
  const Cutter cutter = eccentric(4, 3.0, 30.0);
  const Immersion down{
      .kind = ImmersionKind::down, .radial_depth = 1.0 * mm, .axial_depth = 5.0 * mm};
  const DeflectionOptions options{.slice_height = 1.0 * mm, .steps = 120};
  const FlexibleCut flexible =
      flexible_cut(tool(200), cutter, thesis_law(), at_feed(10, 4), down, options);
  const ToolDeflection rigid =
      tool_deflection(tool(200), cutter, thesis_law(), at_feed(10, 4), down, options);
  EXPECT_EQ(flexible.rest, Rest::at_rest);
  EXPECT_NEAR(flexible.total_tip, rigid.total_tip, 1e-4 * rigid.total_tip);
  // The edge that reaches out 3 um makes the wall.
  EXPECT_NEAR(flexible.surface.error.front() / units::um, -3.0, 0.01);
}

/// The slow reference: turns of an eccentric cutter with straight flutes in a slot and a linear
/// law, from the uncut wall on, until one repeats the one before. Every edge keeps the surface that
/// it leaves; the law being linear, the balance at an angle is a linear system of two unknowns, the
/// tip's deflections. One slice. Returns tip_y over the last turn.
struct March {
  std::vector<double> tip_y;
  int turns = 0;
};
March march(const ToolCompliance& held, const Cutter& cutter, const Condition& condition,
            double depth, int steps) {
  const double c = held.between(0.5 * depth, 0.5 * depth), to_tip = held.between(0.0, 0.5 * depth);
  const int pitch = steps / cutter.flutes;
  std::vector<double> left(static_cast<std::size_t>(steps), 0.0);
  March result;
  for (result.turns = 1; result.turns < 5000; ++result.turns) {
    std::vector<double> tip_y;
    for (int i = 0; i < steps; ++i) {
      std::array<double, 2> d{0.0, 0.0};
      std::vector<bool> cuts(static_cast<std::size_t>(cutter.flutes), true);
      const auto chip = [&](int j, double& sine, double& cosine, std::size_t& bin) {
        bin = static_cast<std::size_t>((i - j * pitch + steps) % steps);
        sine = std::sin(kTurn * static_cast<double>(bin) / steps);
        cosine = std::cos(kTurn * static_cast<double>(bin) / steps);
        const double out = cutter.run_out.offset * std::cos(kTurn * j / cutter.flutes);
        return condition.feed_per_tooth * sine + out + sine * d[0] + cosine * d[1] - left[bin];
      };
      double sine = 0.0, cosine = 0.0;
      std::size_t bin = 0;
      for (int round = 0; round < 10; ++round) {  // until the same edges cut
        double a = 1.0, b = 0.0, e = 0.0, f = 1.0, right_x = 0.0, right_y = 0.0;
        d = {0.0, 0.0};
        for (int j = 0; j < cutter.flutes; ++j) {
          const double free = chip(j, sine, cosine, bin);
          if (sine <= 1e-9 || !cuts[static_cast<std::size_t>(j)]) continue;
          const double kx = depth * (-60e6 * cosine - 25e6 * sine);
          const double ky = depth * (60e6 * sine - 25e6 * cosine);
          a -= c * kx * sine;
          b -= c * kx * cosine;
          e -= c * ky * sine;
          f -= c * ky * cosine;
          right_x += c * kx * free;
          right_y += c * ky * free;
        }
        const double det = a * f - b * e;
        d = {(right_x * f - b * right_y) / det, (a * right_y - e * right_x) / det};
        bool same = true;
        for (int j = 0; j < cutter.flutes; ++j) {
          const bool now = chip(j, sine, cosine, bin) > 0.0 && sine > 1e-9;
          same = same && (now == cuts[static_cast<std::size_t>(j)] || sine <= 1e-9);
          cuts[static_cast<std::size_t>(j)] = now;
        }
        if (same) break;
      }
      tip_y.push_back(to_tip / c * d[1]);
      for (int j = 0; j < cutter.flutes; ++j) {
        const double h = chip(j, sine, cosine, bin);
        if (sine <= 1e-9) continue;
        left[bin] +=
            h > 0.0 ? h - condition.feed_per_tooth * sine : -condition.feed_per_tooth * sine;
      }
    }
    double change = 0.0;
    for (std::size_t i = 0; i < tip_y.size() && !result.tip_y.empty(); ++i) {
      change = std::max(change, std::abs(tip_y[i] - result.tip_y[i]));
    }
    const bool repeats = !result.tip_y.empty() && change < 1e-15;
    result.tip_y = tip_y;
    if (repeats) break;
  }
  return result;
}

TEST(FlexibleCut, IsWhatManyRevolutionsFromAnUncutWallComeTo) {
  for (const int flutes : {2, 4}) {
    for (const double diameter : {3.0, 6.35}) {
      const ToolCompliance held = tool(diameter);
      const Cutter cutter = eccentric(flutes, 4.0);
      const DeflectionOptions options{.slice_height = 2.0 * mm, .steps = 120};
      const FlexibleCut at_once =
          flexible_cut(held, cutter, linear_law(), at_feed(10, flutes), slot(2), options);
      const March slow = march(held, cutter, at_feed(10, flutes), 2 * mm, 120);
      EXPECT_EQ(at_once.rest, Rest::at_rest);
      EXPECT_LT(slow.turns, 5000);
      ASSERT_EQ(at_once.tip_y.size(), slow.tip_y.size());
      for (std::size_t i = 0; i < slow.tip_y.size(); ++i) {
        // The march ends where a turn changes by 1e-15 m, and takes up to 1000 turns to get there.
        EXPECT_NEAR(at_once.tip_y[i], slow.tip_y[i], 1e-12) << flutes << " " << diameter;
      }
    }
  }
}

TEST(FlexibleCut, EvensOutTheRunOutThatARigidToolFeelsInFull) {
  const Condition feed = at_feed(10.0, 2);  // 15 µm a tooth: one cuts 23 µm, the other 7
  const auto cut = [&](double diameter, const Cutter& cutter) {
    return flexible_cut(tool(diameter), cutter, thesis_law(), feed, slot(1));
  };
  const FlexibleCut rigid = cut(200, eccentric(2, 4)), stout = cut(6.35, eccentric(2, 4));
  const FlexibleCut slender = cut(2.54, eccentric(2, 4)), even = cut(6.35, mill(2));
  EXPECT_GT(rigid.peak_force, 1.2 * even.peak_force);
  EXPECT_LT(stout.peak_force, 0.97 * rigid.peak_force);
  EXPECT_LT(slender.peak_force, 0.9 * stout.peak_force);
  EXPECT_GT(slender.peak_force, even.peak_force);
}

TEST(FlexibleCut, WithUnequalPitchHasTheForcesOfTheRigidCutWhereTheToolIsStiff) {
  Cutter cutter = mill(2);
  cutter.pitch = {170 * units::deg, 190 * units::deg};
  const DeflectionOptions options{.slice_height = 1.0 * mm, .steps = kUnequalSteps};
  const FlexibleCut stiff =
      flexible_cut(tool(200), cutter, thesis_law(), at_feed(10, 2), slot(2), options);
  const ToolDeflection rigid =
      tool_deflection(tool(200), cutter, thesis_law(), at_feed(10, 2), slot(2), options);
  EXPECT_EQ(stiff.rest, Rest::at_rest);
  EXPECT_NEAR(stiff.total_tip, rigid.total_tip, 1e-4 * rigid.total_tip);
  EXPECT_EQ(flexible_cut(tool(4), cutter, thesis_law(), at_feed(10, 2), slot(2), options).rest,
            Rest::at_rest);
}

TEST(FlexibleCut, SaysWhenTheBalanceDoesNotStay) {
  // A law whose radial force falls as the chip grows: as stiff as the tool, it pushes a disturbance
  // on. Re z < -1/2 for z = compliance x dF/dh makes |z/(1+z)| > 1.
  CuttingLaw falling = linear_law();
  const ToolCompliance held = tool(4);
  const double depth = 2 * mm, c = held.between(0.5 * depth, 0.5 * depth);
  const LinearLaw radial{.pressure = -0.7 / (c * depth), .edge = 1e5};
  falling.radial = {radial, radial};
  const FlexibleCut cut = flexible_cut(held, mill(2), falling, at_feed(2, 2), slot(2),
                                       {.slice_height = depth, .steps = 60});
  EXPECT_EQ(cut.rest, Rest::unstable);
  // |z/(1+z)| = 7/3 a tooth, two teeth a revolution.
  EXPECT_NEAR(cut.growth, 49.0 / 9.0, 1e-6);
}

TEST(FlexibleCut, BadInputsAreNamed) {
  const auto with = [](const Cutter& cutter, double depth_mm, const DeflectionOptions& options) {
    return flexible_cut(tool(4), cutter, thesis_law(), at_feed(1.0, 2), slot(depth_mm), options);
  };
  Cutter ball = mill(2);
  ball.shape = cutting::CutterShape::ball;
  EXPECT_THROW(with(ball, 1, {}), InvalidInput);
  EXPECT_THROW(with(mill(2), 36, {}), InvalidInput);
  EXPECT_THROW(with(mill(2), 5, {.slice_height = 0.0}), InvalidInput);
  EXPECT_THROW(with(mill(2), 5, {.steps = 5}), InvalidInput);
}

}  // namespace
}  // namespace osteomill::accuracy
