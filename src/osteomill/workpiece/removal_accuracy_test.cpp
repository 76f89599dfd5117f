// SPDX-License-Identifier: BSD-3-Clause
// Volume and mean force against analytic cuts, and how both converge with the spacing: the table of
// docs/theory/removal.md, at two of its spacings.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "osteomill/base/units.hpp"
#include "osteomill/cutting/engaged_force.hpp"
#include "osteomill/workpiece/removal_for_test.hpp"
#include "osteomill/workpiece/remover.hpp"

namespace osteomill::workpiece {
namespace {

constexpr double mm = units::mm;
constexpr double kPi = std::numbers::pi;

/// A cut along a curve of poses; the bone is where `distance` is negative.
struct AccuracyCase {
  const char* name;
  cutting::CutterShape shape;
  double radius;                                 ///< m
  std::function<double(const Vector3& p)> bone;  ///< signed distance, m
  std::function<ToolPose(double s)> pose;        ///< at a way of the tip, m
  double from, to;                               ///< ways between which it counts, m
  double volume;                                 ///< removed there, m³
  /// Whether the point of the envelope with this outward normal, at this place, is in contact.
  std::function<bool(const Vector3& p_W, const Vector3& n_W)> contact;
  Vector3 lower, upper;  ///< of the grid, m
};

// Off the layers of voxels on purpose, and 0.5 rad to their rows.
const Vector3 kOffset(0.013 * mm, 0.037 * mm, -0.021 * mm);
const Vector3 kAlong(std::cos(0.5), std::sin(0.5), 0.0);
const Vector3 kBeside(-std::sin(0.5), std::cos(0.5), 0.0);
constexpr double kWay = 1.5 * mm;

double segment(double R, double d) {
  return R * R * std::acos(1.0 - d / R) - (R - d) * std::sqrt(2.0 * R * d - d * d);
}

std::vector<AccuracyCase> cases() {
  using enum cutting::CutterShape;
  const auto flat = [](const Vector3& p) { return (p - kOffset).z(); };
  const auto level = [](double depth) {
    return [=](double s) -> ToolPose { return {kOffset + s * kAlong - depth * Vector3::UnitZ()}; };
  };
  const auto below = [](const Vector3& p, const Vector3&) { return (p - kOffset).z() < 0.0; };
  std::vector<AccuracyCase> all;
  const double R = 2 * mm, d = 3 * mm;
  const Vector3 low(-6.5 * mm, -5 * mm, -4 * mm), high(6.5 * mm, 5 * mm, 0.4 * mm);
  all.push_back(
      {"slot", cylindrical, R, flat, level(d), 0.0, kWay, 2.0 * R * d * kWay, below, low, high});
  all.push_back({"half immersion", cylindrical, R,
                 [=](const Vector3& p) { return std::max(flat(p), -(p - kOffset).dot(kBeside)); },
                 level(d), 0.0, kWay, R * d * kWay,
                 [=](const Vector3& p, const Vector3&) {
                   return below(p, {}) && (p - kOffset).dot(kBeside) > 0.0;
                 },
                 low, high});
  const double B = 4 * mm, shallow = 1 * mm;
  all.push_back({"ball in a flat", ball, B, flat, level(shallow), 0.0, kWay,
                 segment(B, shallow) * kWay, below, low, high});
  const Vector3 axis =
      (Eigen::AngleAxisd(0.35, kAlong) * Eigen::AngleAxisd(0.25, kBeside) * Vector3::UnitZ());
  all.push_back({"tilted ball", ball, B, flat,
                 [=](double s) -> ToolPose {
                   return {kOffset + s * kAlong + (B - shallow) * Vector3::UnitZ() - B * axis,
                           axis};
                 },
                 0.0, kWay, segment(B, shallow) * kWay, below, low, high});
  const double arc = 8 * mm;
  all.push_back({"arc slot", cylindrical, R, flat,
                 [=](double s) -> ToolPose {
                   return {kOffset +
                           arc * Vector3(std::sin(s / arc), 1.0 - std::cos(s / arc), 0.0) -
                           d * Vector3::UnitZ()};
                 },
                 0.0, kWay, 2.0 * R* d* kWay, below, low, high});
  all.push_back({"plunge",
                 ball,
                 B,
                 flat,
                 [=](double s) -> ToolPose { return {kOffset - (B + s) * Vector3::UnitZ()}; },
                 0.0,
                 kWay,
                 kPi* B* B* kWay,
                 below,
                 {-5 * mm, -5 * mm, -8 * mm},
                 {5 * mm, 5 * mm, 0.4 * mm}});
  all.push_back({"tilted slot",
                 cylindrical,
                 R,
                 [=](const Vector3& p) { return axis.dot(p - kOffset); },
                 [=](double s) -> ToolPose {
                   return {kOffset + s * axis.cross(kBeside).cross(axis).normalized() - d * axis,
                           axis};
                 },
                 0.0,
                 kWay,
                 2.0 * R* d* kWay,
                 [=](const Vector3& p, const Vector3&) { return axis.dot(p - kOffset) < 0.0; },
                 {-6.5 * mm, -6.5 * mm, -5.5 * mm},
                 {6.5 * mm, 6.5 * mm, 3 * mm}});
  return all;
}

struct Errors {
  double volume = 0.0, force = 0.0;  ///< relative
};

/// The engagement that the shape of the bone says, on the same patches: 12 × 12 points of each.
cutting::Engagement exact_engagement(const AccuracyCase& of, const cutting::Cutter& cutter,
                                     const PatchGrid& grid, const Eigen::Matrix3d& R_WT,
                                     const Vector3& tip, const Vector3& feed) {
  cutting::Engagement exact;
  exact.slices = grid.slices;
  exact.angles = grid.angles;
  exact.slice_height = grid.slice_height;
  const int n = 12;
  for (int slice = 0; slice < grid.slices; ++slice)
    for (int angle = 0; angle < grid.angles; ++angle) {
      int inside = 0;
      for (int i = 0; i < n * n; ++i) {
        const double z = (slice + (i / n + 0.5) / n) * grid.slice_height;
        const double theta = (angle + (i % n + 0.5) / n) * 2.0 * kPi / grid.angles;
        const double r = cutting::radius_at(cutter, z);
        const double kappa = cutting::axial_position_angle(cutter, z);
        const Vector3 round(std::sin(theta), std::cos(theta), 0.0);
        const Vector3 p = tip + R_WT * (r * round + z * Vector3::UnitZ());
        const Vector3 normal =
            R_WT * (std::sin(kappa) * round - std::cos(kappa) * Vector3::UnitZ());
        if (normal.dot(feed) > 0.0 && of.contact(p, normal)) ++inside;
      }
      exact.weights.push_back(static_cast<double>(inside) / (n * n));
    }
  return exact;
}

Errors errors_of(const AccuracyCase& of, double voxels_per_radius) {
  const double spacing = of.radius / voxels_per_radius;
  const cutting::Cutter cutter =
      of.shape == cutting::CutterShape::ball ? ball(2.0 * of.radius) : cylinder(2.0 * of.radius);
  Stock stock(cubes_over(of.lower, of.upper, spacing),
              [&](const Vector3& p) { return BoneSample{of.bone(p), {1900.0, 1.0}}; });
  Remover remover(stock, cutter);
  const double run_up = 2.0 * spacing + 0.4 * mm;
  for (int k = 0; k < 10; ++k)
    remover.step(of.pose(of.from - run_up * (1.0 - k / 10.0)),
                 of.pose(of.from - run_up * (1.0 - (k + 1) / 10.0)));
  const PatchGrid grid = patches_for(cutter, spacing);
  const cutting::EngagedForce model(cutter, chip_and_rubbing_law(), grid.angles, grid.slices,
                                    grid.slice_height);
  cutting::Condition condition{6000 * units::rpm, 0.03 * mm};
  const int steps = static_cast<int>(std::ceil((of.to - of.from) / (0.3 * spacing)));
  double volume = 0.0;
  Vector3 force = Vector3::Zero(), exact = Vector3::Zero();
  const auto at = [&](int k) { return of.pose(of.from + (of.to - of.from) * k / steps); };
  for (int k = 0; k < steps; ++k) {
    volume += remover.step(at(k), at(k + 1)).volume;
    const ToolPose pose = at(k + 1);
    const Vector3 feed = (pose.tip_W - at(k).tip_W).normalized();
    condition.feed_elevation = std::asin(std::clamp(feed.dot(pose.axis_W), -1.0, 1.0));
    force += model.mean(remover.engagement(), condition).force;
    if (k % (steps / 3 + 1) != 0) continue;
    exact +=
        model.mean(exact_engagement(of, cutter, grid, remover.R_WT(), pose.tip_W, feed), condition)
            .force;
  }
  exact /= (steps + steps / 3) / (steps / 3 + 1);
  return {volume / of.volume - 1.0, (force / steps - exact).norm() / exact.norm()};
}

class Accuracy : public testing::TestWithParam<std::size_t> {};

TEST_P(Accuracy, IsWithinTheMarksAtTwentyVoxelsARadiusAndConverges) {
  const AccuracyCase of = cases()[GetParam()];
  const Errors coarse = errors_of(of, 5.0), fine = errors_of(of, 20.0);
  // The platform's marks.
  EXPECT_LT(std::abs(fine.volume), 3e-3) << of.name;
  EXPECT_LT(fine.force, 1e-2) << of.name;
  // At least first order over a factor of four, down to the sampling of the walls: 1e-3 of the
  // volume, 5e-3 of the force.
  EXPECT_LT(std::abs(fine.volume), std::abs(coarse.volume) / 4.0 + 1e-3) << of.name;
  EXPECT_LT(fine.force, coarse.force / 4.0 + 5e-3) << of.name;
}

INSTANTIATE_TEST_SUITE_P(Table, Accuracy, testing::Range<std::size_t>(0, 7));

class LeaningAsItGoes : public testing::TestWithParam<double> {};

TEST_P(LeaningAsItGoes, ABallFeelsTheLeanItHas) {
  // The centre goes straight, so that the bone in front of the ball stays the same while the edges
  // come round to it: from 20 degrees backwards to 20 forwards, and some sideways, in 6 mm.
  const double R = 4 * mm, d = 1 * mm, spacing = R / 20.0, way = 6 * mm;
  AccuracyCase of;
  of.contact = [](const Vector3& p, const Vector3&) { return (p - kOffset).z() < 0.0; };
  Stock stock(cubes_over({-8 * mm, -7 * mm, -2 * mm}, {8 * mm, 7 * mm, 0.4 * mm}, spacing),
              [](const Vector3& p) { return BoneSample{(p - kOffset).z(), {1900.0, 1.0}}; });
  const cutting::Cutter cutter = ball(2.0 * R);
  Remover remover(stock, cutter);
  const auto at = [&](double s) -> ToolPose {
    const Vector3 axis = Eigen::AngleAxisd(0.7 * s / way, kBeside) *
                         Eigen::AngleAxisd(GetParam(), kAlong) * Vector3::UnitZ();
    return {kOffset + s * kAlong + (R - d) * Vector3::UnitZ() - R * axis, axis};
  };
  const PatchGrid grid = patches_for(cutter, spacing);
  const cutting::EngagedForce model(cutter, chip_and_rubbing_law(), grid.angles, grid.slices,
                                    grid.slice_height);
  cutting::Condition condition{6000 * units::rpm, 0.03 * mm};
  const int windows = 8, steps = 12;
  const double step = way / (windows * steps);
  for (int k = 32; k > 0; --k)  // ten voxels: the map has forgotten how it began
    remover.step(at(-0.5 * way - k * step), at(-0.5 * way - (k - 1) * step));
  Vector3 last = Vector3::Zero();
  for (int window = 0; window < windows; ++window) {
    Vector3 force = Vector3::Zero(), exact = Vector3::Zero();
    for (int k = 0; k < steps; ++k) {
      const double s = -0.5 * way + (window * steps + k) * step;
      remover.step(at(s), at(s + step));
      const Remover::Motion motion = remover.motion();
      EXPECT_NEAR(motion.height, R, 1e-12);
      condition.feed_elevation = motion.elevation;
      condition.turn_T = motion.turn_T;
      condition.turn_height = motion.height;
      const Vector3 now = remover.R_WT() * model.mean(remover.engagement(), condition).force;
      // Nothing jumps: 40 degrees in 96 steps change the force by a per cent or two a step.
      if (!last.isZero()) {
        EXPECT_LT((now - last).norm(), 0.04 * now.norm()) << s / mm;
      }
      last = now;
      force += now / steps;
      if (k % 4 != 1) continue;  // steps 1, 5, 9 and their ends: the window's middle on average
      exact +=
          remover.R_WT() *
          model
              .mean(exact_engagement(of, cutter, grid, remover.R_WT(), at(s + step).tip_W, kAlong),
                    condition)
              .force /
          3.0;
    }
    // The platform's mark at 20 voxels a radius; sideways the map's axes are not those of the flat,
    // whose border it blurs: up to 1.7 % at a fixed lean too.
    EXPECT_LT((force - exact).norm(), (GetParam() == 0.0 ? 0.01 : 0.02) * exact.norm()) << window;
  }
}

INSTANTIATE_TEST_SUITE_P(Sideways, LeaningAsItGoes, testing::Values(0.0, 0.16, -0.3));

}  // namespace
}  // namespace osteomill::workpiece
