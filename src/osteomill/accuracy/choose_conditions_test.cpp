// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/accuracy/choose_conditions.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"

namespace osteomill::accuracy {
namespace {

using cutting::PowerLaw;
using units::mm;
using units::rpm;

cutting::CuttingLaw law() {
  const auto power = [](double k, double n) { return PowerLaw{k * units::n_per_mm, n}; };
  return {.tangential = {power(71.1, 0.684), power(63.1, 0.569)},
          .radial = {power(32.5, 0.479), power(18.6, 0.341)},
          .lateral = {}};
}

Candidate mill(const char* name, double diameter, int flutes, double length) {
  return {.name = name,
          .cutter = {.radius = 0.5 * diameter, .flutes = flutes, .cutting_length = length},
          .tool_length = length,
          .effective_diameter_factor = 0.82};
}

const std::vector<Candidate> kMills = {mill("slim", 3.1 * mm, 2, 35 * mm),
                                       mill("slim-4", 3.1 * mm, 4, 35 * mm),
                                       mill("stout", 4.0 * mm, 2, 35 * mm)};

ChoiceProblem problem() {
  ChoiceProblem p;
  p.law = law();
  p.fibre_angle = 0.5 * std::numbers::pi;
  p.kerf_area = 3000 * units::mm2;
  p.spans = {Span{1e-6, 0.1e-3}, Span{20000 * rpm, 20000 * rpm}, Span{1 * mm, 30 * mm}, Span{}};
  p.limits.peak_force = 15.0;
  p.limits.deflection = 0.3 * mm;
  return p;
}

TEST(Choose, AgreesWithBruteForce) {
  const Choice fine = choose(problem(), kMills);
  const Choice grid = choose_by_grid(problem(), kMills, 25);
  ASSERT_TRUE(fine.feasible);
  ASSERT_TRUE(grid.feasible);
  EXPECT_EQ(fine.candidate, grid.candidate);
  // A grid of 25 steps over 30:1 and 100:1 misses the optimum by up to two steps of 15-21 %.
  EXPECT_LE(fine.goal, grid.goal * (1.0 + 1e-6));
  EXPECT_GT(fine.goal, 0.6 * grid.goal);
  EXPECT_LT(fine.evaluations, 2 * grid.evaluations * 3);
}

TEST(Choose, WithALimitOfChatterComesUpToAGrid) {
  // The boundary of chatter has corners, at which a search may stop short.
  ChoiceProblem p = problem();
  p.spans = {Span{5e-6, 50e-6}, Span{10000 * rpm, 40000 * rpm}, Span{0.2 * mm, 30 * mm}, Span{}};
  p.limits.chatter = 0.9;
  Candidate stiff = mill("stiff", 8.0 * mm, 2, 36 * mm);
  const Choice fine = choose(p, {stiff});
  const Choice grid = choose_by_grid(p, {stiff}, 8);
  ASSERT_TRUE(grid.feasible);
  ASSERT_TRUE(fine.feasible);
  // A grid may hit a corner of the boundary that a search, which goes on while it gains a
  // thousandth, comes close to.
  EXPECT_LE(fine.goal, 1.01 * grid.goal);
}

TEST(Choose, WhereNothingIsFeasibleComesAsCloseAsAGrid) {
  ChoiceProblem p = problem();
  p.limits.peak_force = 0.05;
  p.limits.deflection = 0.001 * mm;
  const Choice closest = choose(p, kMills);
  const Choice grid = choose_by_grid(p, kMills, 15);
  EXPECT_EQ(closest.status, "infeasible");
  EXPECT_EQ(closest.candidate, grid.candidate);
  // The search for the least excess ends at a part in ten thousand.
  const double least = excess(limit_uses(p, grid.quality));
  EXPECT_LE(excess(limit_uses(p, closest.quality)), least * (1.0 + 1e-3));
}

TEST(Choose, NamesTheBindingLimitAndWhatRelaxingItBuys) {
  const Choice choice = choose(problem(), kMills);
  EXPECT_EQ(choice.status, "optimal");
  EXPECT_THAT(choice.binding, testing::Contains("peak_force"));
  ASSERT_FALSE(choice.relaxations.empty());
  for (const Relaxation& relaxation : choice.relaxations) EXPECT_GE(relaxation.gain, 0.0);
  EXPECT_GT(choice.relaxations.front().gain, 0.02);
}

TEST(Choose, KeepsEveryLimit) {
  for (const Goal goal : {Goal::time, Goal::force, Goal::heat, Goal::error}) {
    ChoiceProblem p = problem();
    p.goal = goal;
    p.limits.time = 400.0;
    const Choice choice = choose(p, kMills);
    ASSERT_TRUE(choice.feasible) << static_cast<int>(goal);
    for (const LimitUse& use : limit_uses(p, choice.quality)) EXPECT_LE(use.use, 1.002) << use.name;
  }
}

TEST(Choose, PrefersShallowAndFastAtEqualTime) {
  // [plaskos2002] §4.5.3: thicker chips of smaller width.
  ChoiceProblem p = problem();
  p.limits = {};
  p.limits.time = 186.0;  // 50 mm³/s with the slim mill
  p.goal = Goal::force;
  p.spans[2] = {5 * mm, 30 * mm};
  const Choice choice = choose(p, {kMills[0]});
  const auto equal =
      compare_at_removal_rate(p, {kMills[0]}, 50 * units::mm3, 20000 * rpm, {30 * mm, 5 * mm});
  EXPECT_NEAR(equal[0].feed_rate / units::mm_per_s, 50.0 / (3.1 * 30.0), 1e-9);
  EXPECT_NEAR(equal[0].quality.time, equal[1].quality.time, 1e-9);
  EXPECT_LT(equal[1].quality.deflection, equal[0].quality.deflection);
  EXPECT_LT(equal[1].quality.peak_force, equal[0].quality.peak_force);
  EXPECT_NEAR(choice.point[2] / mm, 5.0, 0.05);
  EXPECT_NEAR(choice.goal, equal[1].quality.peak_force, 0.02 * choice.goal);
}

TEST(Choose, ReproducesTheComparisonAtEqualRemovalRate) {
  // 50 mm³/s: 35 mm at 0.461 mm/s against 5 mm at 3.23 mm/s, [plaskos2002] §4.4.3.
  Candidate extended = mill("extended", 3.1 * mm, 2, 55 * mm);
  extended.effective_diameter_factor = 2.76 / 3.1;
  const auto list = compare_at_removal_rate(problem(), {extended}, 50 * units::mm3, 20000 * rpm,
                                            {35 * mm, 5 * mm});
  EXPECT_NEAR(list[0].feed_rate / units::mm_per_s, 0.461, 5e-4);
  EXPECT_NEAR(list[1].feed_rate / units::mm_per_s, 3.23, 5e-3);
  EXPECT_NEAR(1.0 - list[1].quality.deflection / list[0].quality.deflection, 0.5, 0.06);
}

TEST(Choose, SaysWhatIsInfeasibleAndWhatComesClosest) {
  ChoiceProblem p = problem();
  p.limits.time = 20.0;
  const Choice choice = choose(p, kMills);
  EXPECT_FALSE(choice.feasible);
  EXPECT_EQ(choice.status, "infeasible");
  ASSERT_FALSE(choice.violated.empty());
  // No point of a grid exceeds its limits by less.
  EXPECT_LE(choice.goal, choose_by_grid(p, kMills, 15).goal + 1e-3);
}

TEST(Choose, KeepsAwayFromChatter) {
  ChoiceProblem p = problem();
  p.limits = {};
  p.limits.chatter = 0.95;
  p.damping_ratio = 0.05;
  p.spans[0] = {2e-6, 20e-6};
  p.spans[1] = {10000 * rpm, 60000 * rpm};
  p.spans[2] = {0.05 * mm, 10 * mm};
  const std::vector<Candidate> thick = {mill("thick", 10 * mm, 2, 25 * mm)};
  const Choice choice = choose(p, thick);
  ASSERT_TRUE(choice.feasible);
  EXPECT_LE(choice.quality.chatter, 0.952);
  p.limits.chatter.reset();
  EXPECT_LT(choose(p, thick).goal, choice.goal);
}

TEST(Choose, ParetoFrontTradesTimeForError) {
  ChoiceProblem p = problem();
  p.spans[0] = {2e-6, 0.1e-3};
  const auto front = pareto_front(p, {kMills[1]}, 6);
  ASSERT_GE(front.size(), 3u);
  for (std::size_t i = 1; i < front.size(); ++i) {
    EXPECT_GT(front[i].time, front[i - 1].time);
    EXPECT_LT(front[i].error, front[i - 1].error);
  }
}

TEST(Choose, BadInputsAreNamed) {
  const auto message = [](const ChoiceProblem& p, const std::vector<Candidate>& candidates) {
    try {
      choose(p, candidates);
    } catch (const InvalidInput& error) {
      return std::string(error.what());
    }
    return std::string("none");
  };
  using testing::HasSubstr;
  EXPECT_THAT(message(problem(), {}), HasSubstr("candidates"));
  ChoiceProblem p = problem();
  p.spans[0] = {0.0, 1.0};
  p.volume = 1.0;
  p.limits.temperature = 47.0;
  EXPECT_THAT(message(p, kMills),
              testing::AllOf(HasSubstr("choose.feed_per_tooth"), HasSubstr("job"),
                             HasSubstr("limits.temperature_c")));
  p = problem();
  p.spans[2].high = 50 * mm;
  EXPECT_THAT(message(p, kMills), HasSubstr("choose.axial_depth"));
}

}  // namespace
}  // namespace osteomill::accuracy
