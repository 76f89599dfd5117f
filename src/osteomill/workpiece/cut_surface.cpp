// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/workpiece/cut_surface.hpp"

#include <tbb/parallel_for.h>

#include <array>
#include <cmath>

#include "osteomill/base/error.hpp"

namespace osteomill::workpiece {
namespace {

using Index = std::array<int, 3>;

/// Weights of a layer of neighbours in a gradient: Sobel's, in each of two directions.
constexpr double kBeside[3] = {1.0, 2.0, 1.0};

/// Whether all of the voxel's neighbours were bone through and through before the cut, so that what
/// they hold now is the cut's doing.
bool inside(const Stock& before, const Index& at) {
  for (int k = -1; k <= 1; ++k)
    for (int j = -1; j <= 1; ++j)
      for (int i = -1; i <= 1; ++i)
        if (before.occupancy(at[0] + i, at[1] + j, at[2] + k) < 1.0) return false;
  return true;
}

Vector3 outward(const Stock& after, const Index& at) {
  Vector3 gradient = Vector3::Zero();
  for (int k = -1; k <= 1; ++k)
    for (int j = -1; j <= 1; ++j)
      for (int i = -1; i <= 1; ++i) {
        const double share = after.occupancy(at[0] + i, at[1] + j, at[2] + k);
        gradient -= share * Vector3(i * kBeside[j + 1] * kBeside[k + 1],
                                    j * kBeside[i + 1] * kBeside[k + 1],
                                    k * kBeside[i + 1] * kBeside[j + 1]);
      }
  return gradient;
}

void add_points(const Stock& before, const Stock& after, const Index& at,
                std::vector<CutPoint>& points) {
  const double share = after.occupancy(at[0], at[1], at[2]);
  const double h = after.spacing();
  if (share > 0.0 && share < 1.0) {
    if (!(share < before.occupancy(at[0], at[1], at[2])) || !inside(before, at)) return;
    const Vector3 gradient = outward(after, at);
    const double length = gradient.norm();
    if (!(length > 0.0)) return;
    const Vector3 n = gradient / length;
    points.push_back({after.shape().centre(at[0], at[1], at[2]) - h * (0.5 - share) * n, n});
    return;
  }
  if (share < 1.0) return;
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (const int side : {-1, 1}) {
      Index beside = at;
      beside[axis] += side;
      if (after.occupancy(beside[0], beside[1], beside[2]) > 0.0) continue;
      if (!inside(before, beside)) continue;
      Vector3 n = Vector3::Zero();
      n[static_cast<Eigen::Index>(axis)] = side;
      points.push_back({after.shape().centre(at[0], at[1], at[2]) + 0.5 * h * n, n});
    }
}

}  // namespace

std::vector<CutPoint> cut_surface(const Stock& before, const Stock& after) {
  const geometry::GridShape& shape = before.shape();
  if (shape.size != after.shape().size || shape.origin != after.shape().origin)
    throw InvalidInput(Fault{"stock", "two grids", "must be the same before and after", ""});
  const Stock::Box box = before.bone_box();
  const auto layers = static_cast<std::size_t>(std::max(0, box.last[2] - box.first[2] + 1));
  std::vector<std::vector<CutPoint>> found(layers);
  tbb::parallel_for(std::size_t{0}, layers, [&](std::size_t layer) {
    const int z = box.first[2] + static_cast<int>(layer);
    for (int y = box.first[1]; y <= box.last[1]; ++y)
      for (int x = box.first[0]; x <= box.last[0]; ++x)
        add_points(before, after, {x, y, z}, found[layer]);
  });
  std::vector<CutPoint> points;
  for (const std::vector<CutPoint>& part : found)
    points.insert(points.end(), part.begin(), part.end());
  return points;
}

}  // namespace osteomill::workpiece
