// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/robot/placement.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <nlopt.hpp>

#include "osteomill/base/error.hpp"
#include "osteomill/base/random.hpp"
#include "osteomill/base/units.hpp"

namespace osteomill::robot {
namespace {

using units::deg;
using units::mm;

GuidePositioner prototype() { return {.link1 = 60.0 * mm, .link2 = 30.0 * mm}; }

PerCut<CutLine> generic_lines(int size) { return cut_lines(profile_of(generic_family(), size)); }

ImplantFamily random_family(Random& random) {
  ImplantFamily family;
  family.anteroposterior = {random.uniform(40.0, 70.0) * mm};
  family.distal_half_length = random.uniform(0.15, 0.32);
  family.anterior = family.distal_half_length + random.uniform(0.1, 0.35);
  family.posterior = family.distal_half_length + random.uniform(0.1, 0.3);
  family.anterior_chamfer_angle = random.uniform(30.0, 60.0) * deg;
  family.posterior_chamfer_angle = random.uniform(30.0, 60.0) * deg;
  family.anterior_tilt = random.uniform(0.0, 12.0) * deg;
  family.posterior_tilt = random.uniform(-3.0, 8.0) * deg;
  return family;
}

/// The plainest possible search, around the allowed region found on a coarse grid.
std::optional<double> grid_search(const GuidePositioner& robot, const PerCut<CutLine>& lines,
                                  double step, BranchRule rule) {
  Vector2 low(1.0, 1.0);
  Vector2 high(-1.0, -1.0);
  const double coarse = 1.0 * mm;
  for (double x = -0.09; x < 0.09; x += coarse) {
    for (double y = -0.12; y < 0.12; y += coarse) {
      if (!gaps_at(robot, lines, {x, y}, rule).allowed) continue;
      low = low.cwiseMin(Vector2(x, y));
      high = high.cwiseMax(Vector2(x, y));
    }
  }
  std::optional<double> best;
  for (double x = low.x() - coarse; x <= high.x() + coarse; x += step) {
    for (double y = low.y() - coarse; y <= high.y() + coarse; y += step) {
      double largest = 0.0;
      for (const CutLine& line : lines) {
        auto g = gap(robot, {x, y}, line);
        if (rule == BranchRule::nearest && g) {
          const auto inner = gap(robot, {x, y}, line, Branch::innermost);
          if (*inner >= 0.0) g = inner;
        }
        largest = g && *g >= 0.0 ? std::max(largest, *g) : 1.0;
        if (largest >= best.value_or(1.0)) break;
      }
      if (largest < best.value_or(1.0)) best = largest;
    }
  }
  return best;
}

TEST(Placement, IsNeverBeatenByAFineGrid) {
  Random random(5);
  int feasible = 0;
  for (int i = 0; i < 100; ++i) {
    const PerCut<CutLine> lines = cut_lines(profile_of(random_family(random), 1));
    const GuidePositioner robot{.link1 = random.uniform(45.0, 75.0) * mm,
                                .link2 = random.uniform(5.0, 35.0) * mm};
    const Placement placement = place(robot, lines);
    const auto grid = grid_search(robot, lines, 0.05 * mm, BranchRule::outermost);
    ASSERT_TRUE(placement.converged);
    if (grid) {
      ASSERT_TRUE(placement.feasible);
      // The certificate's own precision.
      EXPECT_LE(placement.largest_gap, *grid + 1e-7);
      EXPECT_LE(placement.lower_bound, placement.largest_gap);
      EXPECT_GE(placement.lower_bound, placement.largest_gap - 1.1e-7);
    }
    feasible += placement.feasible;
  }
  EXPECT_GT(feasible, 50);
}

TEST(Placement, WithTheNearestBranchIsNeverBeatenByAGridNorByTheOutermostBranch) {
  Random random(6);
  for (int i = 0; i < 20; ++i) {
    const PerCut<CutLine> lines = cut_lines(profile_of(random_family(random), 1));
    const GuidePositioner robot{.link1 = random.uniform(60.0, 90.0) * mm,
                                .link2 = random.uniform(2.0, 10.0) * mm};
    const Placement nearest = place(robot, lines, {.branch = BranchRule::nearest});
    const Placement outermost = place(robot, lines);
    EXPECT_EQ(nearest.feasible, outermost.feasible);
    if (!outermost.feasible) continue;
    EXPECT_LE(nearest.largest_gap, outermost.largest_gap + 2e-7);
    const auto grid = grid_search(robot, lines, 0.2 * mm, BranchRule::nearest);
    if (grid) {
      EXPECT_LE(nearest.largest_gap, *grid + 1e-7);
    }
  }
}

/// Epigraph form of the minimax for SLSQP: variables x0, y0, t in mm.
struct Epigraph {
  const GuidePositioner* robot;
  const PerCut<CutLine>* lines;
};

double slsqp(const GuidePositioner& robot, const PerCut<CutLine>& lines, const Vector2& start) {
  Epigraph problem{&robot, &lines};
  nlopt::opt optimiser(nlopt::LD_SLSQP, 3);
  optimiser.set_min_objective(
      [](unsigned, const double* v, double* gradient, void*) {
        if (gradient != nullptr) {
          gradient[0] = gradient[1] = 0.0;
          gradient[2] = 1.0;
        }
        return v[2];
      },
      nullptr);
  const std::vector<double> tolerances(10, 1e-9);
  optimiser.add_inequality_mconstraint(
      [](unsigned, double* result, unsigned n, const double* v, double* gradient, void* data) {
        const auto& p = *static_cast<Epigraph*>(data);
        const Vector2 at = Vector2(v[0], v[1]) * mm;
        for (unsigned i = 0; i < 5; ++i) {
          const CutLine& line = (*p.lines)[i];
          const auto g = gap(*p.robot, at, line);
          const Vector2 slope = g ? gap_gradient(*p.robot, at, line) : Vector2(0.0, 0.0);
          result[2 * i] = g ? -*g / mm : 1e3;
          result[2 * i + 1] = g ? *g / mm - v[2] : 1e3;
          if (gradient == nullptr) continue;
          double* avoid = gradient + 2 * i * n;
          double* below = avoid + n;
          avoid[0] = -slope.x(), avoid[1] = -slope.y(), avoid[2] = 0.0;
          below[0] = slope.x(), below[1] = slope.y(), below[2] = -1.0;
        }
      },
      &problem, tolerances);
  optimiser.set_maxeval(300);
  optimiser.set_xtol_rel(1e-10);
  const GapReport here = gaps_at(robot, lines, start);
  std::vector<double> v{start.x() / mm, start.y() / mm, here.largest_gap / mm};
  double value = 0.0;
  try {
    optimiser.optimize(v, value);
  } catch (const std::exception&) {
    return std::numeric_limits<double>::infinity();  // this start did not converge
  }
  const GapReport there = gaps_at(robot, lines, Vector2(v[0], v[1]) * mm + Vector2(1e-9, 0.0));
  return there.allowed ? there.largest_gap : std::numeric_limits<double>::infinity();
}

TEST(Placement, AgreesWithMultiStartSequentialQuadraticProgramming) {
  int agreed = 0;
  for (int size = 1; size <= 7; ++size) {
    const GuidePositioner robot = prototype();
    const PerCut<CutLine> lines = generic_lines(size);
    const Placement placement = place(robot, lines);
    ASSERT_TRUE(placement.feasible);
    double best = std::numeric_limits<double>::infinity();
    Random random(7, static_cast<std::uint64_t>(size));
    for (int start = 0; start < 40; ++start) {
      const Vector2 from = Vector2(random.uniform(-50.0, 0.0), random.uniform(-20.0, 25.0)) * mm;
      if (gaps_at(robot, lines, from).allowed) best = std::min(best, slsqp(robot, lines, from));
    }
    EXPECT_GE(best, placement.largest_gap - 2e-7) << size;
    // SLSQP's own constraint tolerance of 1e-9 mm and the shift of 1 nm into the allowed region.
    agreed += best <= placement.largest_gap + 1e-6;
  }
  EXPECT_EQ(agreed, 7);
}

TEST(Placement, FollowsThePublishedTrendsForTheGenericFamily) {
  double before = 0.0;
  for (int size = 1; size <= 7; ++size) {
    const GuidePositioner robot = prototype();
    const PerCut<CutLine> lines = generic_lines(size);
    const Placement placement = place(robot, lines);
    ASSERT_TRUE(placement.feasible);
    EXPECT_GT(placement.largest_gap, before) << "grows with size";
    before = placement.largest_gap;
    // [plaskos2006] Table 4.3: 4.1 ... 15.4 mm; Table 4.5: 1.00 ... 1.21 mm/mm.
    EXPECT_THAT(placement.largest_gap / mm, testing::AllOf(testing::Ge(4.0), testing::Le(15.4)));
    EXPECT_THAT(placement.gradient.x(), testing::AllOf(testing::Ge(0.99), testing::Le(1.22)));
    // 4.4.2.2: the optimum is the proximal tip of the allowed region.
    EXPECT_FALSE(placement.touching.empty());
    for (double x = -0.09; x < placement.axis_position.x() - 0.2 * mm; x += 0.25 * mm) {
      for (double y = -0.04; y < 0.04; y += 0.25 * mm) {
        EXPECT_FALSE(gaps_at(robot, lines, {x, y}).allowed) << x << ' ' << y;
      }
    }
  }
}

TEST(Placement, GradientIsTheFiniteDifferenceOfTheLimitingGap) {
  const GuidePositioner robot = prototype();
  const PerCut<CutLine> lines = generic_lines(4);
  Random random(8);
  for (int i = 0; i < 100; ++i) {
    const Vector2 at = Vector2(random.uniform(-45.0, 0.0), random.uniform(-15.0, 20.0)) * mm;
    for (const CutLine& line : lines) {
      for (const Branch branch : {Branch::outermost, Branch::innermost}) {
        const double h = 1e-6;
        const auto at_offset = [&](double dx, double dy) {
          return gap(robot, at + Vector2(dx, dy), line, branch);
        };
        if (!at_offset(h, h) || !at_offset(-h, -h)) continue;
        const Vector2 slope{(*at_offset(h, 0) - *at_offset(-h, 0)) / (2 * h),
                            (*at_offset(0, h) - *at_offset(0, -h)) / (2 * h)};
        const Vector2 exact = gap_gradient(robot, at, line, branch);
        // h^2 times the third derivative; rounding 1e-17 / h.
        if (exact.norm() < 10.0) {
          EXPECT_LT((exact - slope).norm(), 1e-6);
        }
      }
    }
  }
}

TEST(Placement, DoesNotChangeWhenAnImplantIsScaledWithItsRobot) {
  ImplantFamily family = generic_family();
  const Placement one = place(prototype(), cut_lines(profile_of(family, 3)));
  for (double& ap : family.anteroposterior) ap *= 1.25;
  const Placement other = place({.link1 = 75.0 * mm, .link2 = 37.5 * mm},
                                cut_lines(profile_of(family, 3), {.distal_overhang = 12.5 * mm}));
  // Both are known to 1e-7 m.
  EXPECT_NEAR(other.largest_gap, 1.25 * one.largest_gap, 3e-7);
  EXPECT_NEAR((other.axis_position - 1.25 * one.axis_position).norm(), 0.0, 1e-6);
}

TEST(Placement, NamesTheCutThatFails) {
  // The posterior cut far below the others' reach.
  ImplantFamily family = generic_family();
  family.posterior = 1.0;
  const GuidePositioner robot{.link1 = 45.0 * mm, .link2 = 5.0 * mm};
  const Placement placement = place(robot, cut_lines(profile_of(family, 7)));
  EXPECT_FALSE(placement.feasible);
  EXPECT_TRUE(placement.converged);
  EXPECT_THAT(placement.reason, testing::HasSubstr("posterior"));
  EXPECT_FALSE(
      grid_search(robot, cut_lines(profile_of(family, 7)), 0.5 * mm, BranchRule::outermost));
}

TEST(Placement, StaysAllowedAndNeverBetterWithAMargin) {
  const GuidePositioner robot = prototype();
  const PerCut<CutLine> lines = generic_lines(4);
  const Placement tight = place(robot, lines);
  double before = tight.largest_gap;
  for (const double margin : {1.0 * mm, 2.0 * mm, 3.0 * mm}) {
    const Placement placement = place(robot, lines, {.margin = margin});
    ASSERT_TRUE(placement.feasible);
    EXPECT_GT(placement.largest_gap, before);
    before = placement.largest_gap;
    const PlacementTolerance tolerance =
        placement_tolerance(robot, lines, placement.axis_position, margin);
    EXPECT_GE(tolerance.to_forbidden, margin - 1e-9);
    for (int i = 0; i < 360; ++i) {
      const Vector2 p = placement.axis_position +
                        0.999999 * margin * Vector2(std::cos(i * deg), std::sin(i * deg));
      const GapReport there = gaps_at(robot, lines, p);
      ASSERT_TRUE(there.allowed);
      EXPECT_LE(there.largest_gap, tolerance.worst_gap + 1e-6);
    }
  }
  const SafeZone zone = safe_zone(robot, lines);
  ASSERT_TRUE(zone.exists);
  EXPECT_FALSE(place(robot, lines, {.margin = zone.radius + 0.01 * mm}).feasible);
  EXPECT_TRUE(place(robot, lines, {.margin = zone.radius - 0.01 * mm}).feasible);
}

TEST(Placement, SlideClosesTheGapUpToItsStroke) {
  GuidePositioner robot = prototype();
  robot.slide_stroke = 5.0 * mm;
  const Placement placement = place(robot, generic_lines(4));
  EXPECT_EQ(placement.required_stroke, placement.largest_gap);
  EXPECT_NEAR(placement.residual_gap, placement.largest_gap - 5.0 * mm, 1e-15);
  robot.slide_stroke = 40.0 * mm;
  EXPECT_EQ(place(robot, generic_lines(4)).residual_gap, 0.0);
}

TEST(GapMap, HasItsSmallestValueAtTheOptimum) {
  const GuidePositioner robot = prototype();
  const PerCut<CutLine> lines = generic_lines(4);
  const Placement placement = place(robot, lines);
  const GapMap map = gap_map(robot, lines, {-0.050, -0.025}, {0.0, 0.025}, 0.25 * mm);
  ASSERT_EQ(map.largest.size(), map.x.size() * map.y.size());
  double smallest = 1.0;
  for (const auto& value : map.largest) {
    if (value) smallest = std::min(smallest, *value);
  }
  EXPECT_GE(smallest, placement.largest_gap - 1e-7);
  // Half a grid diagonal at the steepest gradient, about 2 mm/mm at the tip.
  EXPECT_LE(smallest, placement.largest_gap + 0.8 * mm);
}

TEST(Implant, ProfileIsTheSameHoweverItIsDrawn) {
  const Profile profile = profile_of(generic_family(), 2);
  std::vector<Vector2> drawn;
  const Eigen::Rotation2Dd turn(0.7);
  for (const Vector2& corner : profile.corners) {
    drawn.push_back(turn * Vector2(corner.x(), -corner.y()) + Vector2(0.3, -0.2));
  }
  const Profile again = make_profile(drawn);
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_LT((again.corners[i] - profile.corners[i]).norm(), 1e-12);
  }
}

TEST(Implant, LinesMoveOutwardByHalfTheTool) {
  const Profile profile = profile_of(generic_family(), 2);
  const auto bare = cut_lines(profile);
  const auto thick = cut_lines(profile, {.tool_thickness = 6.0 * mm});
  for (std::size_t i = 0; i < 5; ++i) {
    const Vector2 shift = thick[i].entry - bare[i].entry;
    EXPECT_NEAR(shift.norm(), 3.0 * mm, 1e-15);
    EXPECT_NEAR(shift.dot(bare[i].direction), 0.0, 1e-15);
    // Outward: away from a point inside the bone.
    EXPECT_GT(shift.dot(bare[i].entry - Vector2(-0.015, 0.0)), 0.0);
  }
}

TEST(Implant, RefusesWhatIsNoProfile) {
  const Profile good = profile_of(generic_family(), 1);
  const std::vector<Vector2> corners(good.corners.begin(), good.corners.end());
  auto bad = corners;
  bad.pop_back();
  EXPECT_THROW(make_profile(bad), InvalidInput);
  bad = corners;
  bad[1] = {0.01, 0.05};  // distal of the distal cut: no longer convex
  EXPECT_THROW(make_profile(bad), InvalidInput);
  bad = corners;
  bad[3] = bad[2];
  EXPECT_THROW(make_profile(bad), InvalidInput);
  bad = corners;
  bad[4].x() = std::nan("");
  EXPECT_THROW(make_profile(bad), InvalidInput);
  EXPECT_THROW(profile_of(generic_family(), 0), InvalidInput);
  EXPECT_THROW(profile_of(generic_family(), 8), InvalidInput);
}

TEST(Placement, RefusesBadInput) {
  const PerCut<CutLine> lines = generic_lines(1);
  EXPECT_THROW(place({.link1 = -1.0, .link2 = 0.0}, lines), InvalidInput);
  EXPECT_THROW(place(prototype(), lines, {.margin = -1.0}), InvalidInput);
  EXPECT_THROW(place(prototype(), lines, {.precision = 0.0}), InvalidInput);
  EXPECT_THROW(gap_map(prototype(), lines, {0.0, 0.0}, {0.0, 1.0}, 1.0 * mm), InvalidInput);
  EXPECT_THROW(gap_map(prototype(), lines, {0.0, 0.0}, {1.0, 1.0}, 0.0), InvalidInput);
}

}  // namespace
}  // namespace osteomill::robot
