// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/workpiece/thickness.hpp"

#include <algorithm>
#include <cmath>

namespace osteomill::workpiece {

namespace {

/// Outward normal from the occupancy of the 26 neighbours, with the weights of a Sobel filter; zero
/// where they balance, as around a lone voxel.
Vector3 normal_at(const Stock& stock, int x, int y, int z) {
  Vector3 inwards = Vector3::Zero();
  for (int dz = -1; dz <= 1; ++dz)
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx) {
        const double weight = (2 - std::abs(dx)) * (2 - std::abs(dy)) * (2 - std::abs(dz));
        inwards += weight * stock.occupancy(x + dx, y + dy, z + dz) * Vector3(dx, dy, dz);
      }
  return -inwards.normalized();
}

double percentile(std::vector<double>& values, double share) {
  const auto at = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + at, values.end());
  return values[static_cast<std::size_t>(at)];
}

}  // namespace

CorticalThickness cortical_thickness(const Stock& stock, double cortical_density, double rim) {
  const Stock::Box box = stock.bone_box();
  const geometry::GridShape& shape = stock.shape();
  constexpr double step = 0.25;  // voxels
  std::vector<double> thicknesses;
  double surface = 0.0;
  for (int z = box.first[2]; z <= box.last[2]; ++z)
    for (int y = box.first[1]; y <= box.last[1]; ++y)
      for (int x = box.first[0]; x <= box.last[0]; ++x) {
        const double share = stock.occupancy(x, y, z);
        if (share < 0.25 || share > 0.75) continue;
        // The region's faces.
        if (x == 0 || y == 0 || z == 0 || x == shape.size[0] - 1 || y == shape.size[1] - 1 ||
            z == shape.size[2] - 1)
          continue;
        const Vector3 outwards = normal_at(stock, x, y, z);
        if (outwards.isZero()) continue;
        surface += 1.0;
        // The surface lies `out` of the voxel's centre.
        double shell = 0.0;
        const double out = share - 0.5;
        for (double depth = step;; depth += step) {
          const Vector3 at = Vector3(x, y, z) + outwards * (out - depth);
          const double density = stock
                                     .material(static_cast<int>(std::lround(at.x())),
                                               static_cast<int>(std::lround(at.y())),
                                               static_cast<int>(std::lround(at.z())))
                                     .density;
          if (density >= cortical_density) {
            shell = depth;
          } else if (shell > 0.0 || depth * stock.spacing() > rim || !(density > 0.0)) {
            break;
          }
        }
        if (shell > 0.0) thicknesses.push_back(shell * stock.spacing());
      }
  CorticalThickness result;
  if (thicknesses.empty()) return result;
  result.places = thicknesses.size();
  result.share = static_cast<double>(thicknesses.size()) / surface;
  result.p5 = percentile(thicknesses, 0.05);
  result.median = percentile(thicknesses, 0.5);
  result.p95 = percentile(thicknesses, 0.95);
  return result;
}

}  // namespace osteomill::workpiece
