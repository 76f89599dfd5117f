// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/accuracy/plate.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>

#include "osteomill/base/error.hpp"

namespace osteomill::accuracy {
namespace {

PlatePose describe(const std::vector<SurfacePoint>& points, const Eigen::Vector3d& plane) {
  PlatePose pose{.offset = plane[0], .slope_x = plane[1], .slope_y = plane[2]};
  // Rising towards +y turns the plate about x by +atan; rising towards +x about y by −atan.
  pose.varus_valgus = std::atan(plane[2]);
  pose.flexion_extension = -std::atan(plane[1]);
  for (const SurfacePoint& p : points) {
    const double gap = plane[0] + plane[1] * p.x + plane[2] * p.y - p.height;
    pose.largest_gap = std::max(pose.largest_gap, gap);
    pose.share_tight += gap <= kTightGap ? 1.0 : 0.0;
    pose.share_wide += gap <= kWideGap ? 1.0 : 0.0;
  }
  pose.share_tight /= static_cast<double>(points.size());
  pose.share_wide /= static_cast<double>(points.size());
  return pose;
}

Eigen::Matrix<double, Eigen::Dynamic, 3> rows_of(const std::vector<SurfacePoint>& points) {
  Eigen::Matrix<double, Eigen::Dynamic, 3> rows(static_cast<Eigen::Index>(points.size()), 3);
  for (std::size_t i = 0; i < points.size(); ++i) {
    rows.row(static_cast<Eigen::Index>(i)) << 1.0, points[i].x, points[i].y;
  }
  return rows;
}

void require_area(const std::vector<SurfacePoint>& points) {
  if (points.size() >= 3) {
    const auto rows = rows_of(points);
    const Eigen::Vector3d mean = rows.colwise().mean();
    const Eigen::Matrix<double, Eigen::Dynamic, 2> from_mean =
        rows.rightCols<2>().rowwise() - mean.tail<2>().transpose();
    const Eigen::Matrix2d spread = from_mean.transpose() * from_mean;
    if (spread.determinant() > 1e-12 * spread.trace() * spread.trace()) return;
  }
  throw InvalidInput(Fault{"surface", "", "at least three points that are not in one line",
                           "give points over the whole cut"});
}

}  // namespace

PlatePose resting_plate(const std::vector<SurfacePoint>& points) {
  require_area(points);
  const std::size_t n = points.size();
  const auto rows = rows_of(points);
  const Eigen::Vector3d middle = rows.colwise().mean();
  double lowest = points[0].height, highest = lowest, reach = 0.0;
  for (const SurfacePoint& p : points) {
    lowest = std::min(lowest, p.height);
    highest = std::max(highest, p.height);
    reach = std::max(reach, std::hypot(p.x - middle[1], p.y - middle[2]));
  }
  // Linear programme: least height at the middle over all planes above the points, by exchange of
  // the three touching points. It begins on three imagined points far out and far below.
  const double deep = lowest - 1e3 * (highest - lowest + 1e-9);
  Eigen::Matrix<double, Eigen::Dynamic, 3> all(static_cast<Eigen::Index>(n) + 3, 3);
  Eigen::VectorXd heights(static_cast<Eigen::Index>(n) + 3);
  all.topRows(static_cast<Eigen::Index>(n)) = rows;
  for (std::size_t i = 0; i < n; ++i) heights[static_cast<Eigen::Index>(i)] = points[i].height;
  std::array<Eigen::Index, 3> touching{};
  for (int k = 0; k < 3; ++k) {
    const Eigen::Index row = static_cast<Eigen::Index>(n) + k;
    const double angle = 2.0943951023931953 * k + 0.1234;
    all.row(row) << 1.0, middle[1] + 1e3 * reach * std::cos(angle),
        middle[2] + 1e3 * reach * std::sin(angle);
    heights[row] = deep;
    touching[static_cast<std::size_t>(k)] = row;
  }
  Eigen::Vector3d plane = Eigen::Vector3d::Zero();
  for (std::size_t round = 0; round < 50 * (n + 3); ++round) {
    Eigen::Matrix3d a;
    Eigen::Vector3d b;
    for (int k = 0; k < 3; ++k) {
      a.row(k) = all.row(touching[static_cast<std::size_t>(k)]);
      b[k] = heights[touching[static_cast<std::size_t>(k)]];
    }
    const Eigen::PartialPivLU<Eigen::Matrix3d> lu(a);
    plane = lu.solve(b);
    Eigen::Index highest_over = 0;
    const double over = (heights - all * plane).maxCoeff(&highest_over);
    if (over <= 1e-12 + 1e-9 * (highest - lowest)) break;
    // The middle and the new point as mixtures of the touching three; the exchange that keeps the
    // middle inside leaves out the one with the least ratio.
    const Eigen::PartialPivLU<Eigen::Matrix3d> mixture(a.transpose());
    const Eigen::Vector3d of_middle = mixture.solve(middle);
    const Eigen::Vector3d of_new = mixture.solve(all.row(highest_over).transpose());
    int out = -1;
    double least = 0.0;
    for (int k = 0; k < 3; ++k) {
      if (of_new[k] <= 1e-14) continue;
      const double ratio = of_middle[k] / of_new[k];
      if (out < 0 || ratio < least) {
        out = k;
        least = ratio;
      }
    }
    touching[static_cast<std::size_t>(out)] = highest_over;
  }
  return describe(points, plane);
}

PlatePose fitted_plate(const std::vector<SurfacePoint>& points) {
  require_area(points);
  const auto rows = rows_of(points);
  Eigen::VectorXd heights(rows.rows());
  for (std::size_t i = 0; i < points.size(); ++i) {
    heights[static_cast<Eigen::Index>(i)] = points[i].height;
  }
  const Eigen::Vector3d plane = rows.colPivHouseholderQr().solve(heights);
  return describe(points, plane);
}

std::vector<SurfacePoint> milled_surface(const std::vector<Pass>& passes, int points_along) {
  require_within("points along a pass", points_along, 2.0, 1000.0, "");
  std::vector<SurfacePoint> points;
  for (const Pass& pass : passes) {
    for (int i = 0; i < points_along; ++i) {
      const double y = pass.y_from + (pass.y_to - pass.y_from) * i / (points_along - 1);
      for (std::size_t k = 0; k < pass.error.error.size(); ++k) {
        points.push_back({pass.tip_x + pass.error.axial_position[k], y, pass.error.error[k]});
      }
    }
  }
  return points;
}

}  // namespace osteomill::accuracy
