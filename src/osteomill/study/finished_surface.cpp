// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/study/finished_surface.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"

namespace osteomill::study {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
// Walls of levels and of the rim are no finished surface: within 60° of the normal, so that the
// usual chamfers of 45° are.
constexpr double kFacing = 0.5;
// Ridges lower than that are the grain of the voxels, in cells.
constexpr double kGrain = 0.005;
constexpr double kRidgeCells = 7.0;  // from ridge to ridge: three on each side, and its own

struct Profile {
  std::vector<double> heights;  ///< evenly spaced, no gaps
};

/// Stretches without gaps of all lines in one direction.
std::vector<Profile> profiles(const HeightMap& map, bool along) {
  std::vector<Profile> all;
  const int lines = along ? map.across : map.along, length = along ? map.along : map.across;
  for (int line = 0; line < lines; ++line) {
    Profile open;
    for (int k = 0; k <= length; ++k) {
      const double height = k == length ? kNone : along ? map.at(k, line) : map.at(line, k);
      if (std::isfinite(height)) {
        open.heights.push_back(height);
      } else if (!open.heights.empty()) {
        all.push_back(std::move(open));
        open = {};
      }
    }
  }
  return all;
}

Roughness roughness(const std::vector<Profile>& all, double cell, double sampling_length) {
  const auto n = static_cast<std::size_t>(std::lround(sampling_length / cell));
  Roughness result;
  if (n < 8) return result;
  std::vector<double> about(n);
  for (const Profile& profile : all)
    for (std::size_t begin = 0; begin + n <= profile.heights.size(); begin += n) {
      const double middle = 0.5 * static_cast<double>(n - 1);
      double sum = 0.0, moment = 0.0, spread = 0.0;
      for (std::size_t k = 0; k < n; ++k) {
        const double x = static_cast<double>(k) - middle;
        sum += profile.heights[begin + k];
        moment += x * profile.heights[begin + k];
        spread += x * x;
      }
      double low = std::numeric_limits<double>::infinity(), high = -low, size = 0.0;
      for (std::size_t k = 0; k < n; ++k) {
        const double x = static_cast<double>(k) - middle;
        about[k] = profile.heights[begin + k] - sum / static_cast<double>(n) - x * moment / spread;
        low = std::min(low, about[k]);
        high = std::max(high, about[k]);
        size += std::abs(about[k]) / static_cast<double>(n);
      }
      result.ra += size;
      result.rz += high - low;
      ++result.lengths;
    }
  if (result.lengths > 0) {
    result.ra /= static_cast<double>(result.lengths);
    result.rz /= static_cast<double>(result.lengths);
  }
  return result;
}

/// Where the parabolas through three heights on each side of a ridge, continued over it, meet; k is
/// its highest cell.
double ridge_height(const std::vector<double>& z, std::size_t k) {
  const auto continued = [&](std::size_t a, std::size_t b, std::size_t c, double t) {
    // Lagrange through t = 0, -1, -2 for a, b, c: t counts away from them.
    return z[a] * (t + 1) * (t + 2) / 2 - z[b] * t * (t + 2) + z[c] * t * (t + 1) / 2;
  };
  double best = z[k];
  constexpr int kSteps = 40;
  for (int s = 0; s <= kSteps; ++s) {
    const double x = -1.0 + 2.0 * s / kSteps;  // from cell k
    const double left = continued(k - 1, k - 2, k - 3, x + 1.0);
    const double right = continued(k + 1, k + 2, k + 3, 1.0 - x);
    best = std::max(best, std::min(left, right));
  }
  return best;
}

Scallops scallops(const std::vector<Profile>& all, double cell) {
  std::vector<double> heights, spacings;
  for (const Profile& profile : all) {
    const std::vector<double>& z = profile.heights;
    std::vector<std::size_t> ridges;
    for (std::size_t k = 3; k + 3 < z.size(); ++k) {
      bool highest = true;
      for (std::size_t d = 1; d <= 3; ++d)
        highest = highest && z[k] >= z[k - d] && z[k] >= z[k + d];
      if (!highest) continue;
      if (!ridges.empty() && k - ridges.back() <= 3) continue;  // one flat top
      ridges.push_back(k);
    }
    for (std::size_t r = 0; r < ridges.size(); ++r) {
      // Whole ridges have another one, or at least a valley that rises again, on both sides.
      if (r == 0 || r + 1 == ridges.size()) continue;
      const auto lowest = [&](std::size_t from, std::size_t to) {
        return *std::min_element(z.begin() + static_cast<std::ptrdiff_t>(from),
                                 z.begin() + static_cast<std::ptrdiff_t>(to));
      };
      const double valley =
          0.5 * (lowest(ridges[r - 1], ridges[r]) + lowest(ridges[r], ridges[r + 1]));
      const double height = ridge_height(z, ridges[r]) - valley;
      if (height < kGrain * cell) continue;
      heights.push_back(height);
      spacings.push_back(0.5 * cell * static_cast<double>(ridges[r + 1] - ridges[r - 1]));
    }
  }
  Scallops result;
  result.count = heights.size();
  if (heights.empty()) return result;
  for (const double height : heights) {
    result.mean += height / static_cast<double>(heights.size());
    result.largest = std::max(result.largest, height);
  }
  const auto middle = spacings.begin() + static_cast<std::ptrdiff_t>(spacings.size() / 2);
  std::nth_element(spacings.begin(), middle, spacings.end());
  result.spacing = *middle;
  // Nearer to each other they are found only in part.
  if (result.spacing < kRidgeCells * cell) return {};
  return result;
}

/// Cells that are askew to the voxels may miss their point: single ones take the mean of the two
/// beside them.
void close_gaps(HeightMap& map) {
  const std::vector<double> was = map.deviations;
  const auto at = [&](int i, int j) {
    return i < 0 || j < 0 || i >= map.along || j >= map.across
               ? kNone
               : was[static_cast<std::size_t>(j) * static_cast<std::size_t>(map.along) +
                     static_cast<std::size_t>(i)];
  };
  for (int j = 0; j < map.across; ++j)
    for (int i = 0; i < map.along; ++i) {
      if (std::isfinite(at(i, j))) continue;
      const double x = 0.5 * (at(i - 1, j) + at(i + 1, j)), y = 0.5 * (at(i, j - 1) + at(i, j + 1));
      double& to =
          map.deviations[static_cast<std::size_t>(j) * static_cast<std::size_t>(map.along) +
                         static_cast<std::size_t>(i)];
      to = std::isfinite(x) && std::isfinite(y) ? 0.5 * (x + y) : std::isfinite(x) ? x : y;
    }
}

}  // namespace

FinishedSurface measure_surface(std::span<const SurfaceSample> samples,
                                const FinishedSurfaceOptions& options) {
  require_positive("surface.cell_mm", options.cell / units::mm, "mm");
  const Vector3 n = options.normal.normalized();
  const Vector3 feed = options.feed - n * n.dot(options.feed);
  if (!(feed.norm() > 1e-9))
    throw InvalidInput(Fault{"surface.feed", "along the normal", "must lie in the surface", ""});
  const Vector3 x = feed.normalized(), y = n.cross(x);
  FinishedSurface result;
  HeightMap& map = result.map;
  map.cell = options.cell;
  double low_x = std::numeric_limits<double>::infinity(), low_y = low_x, high_x = -low_x,
         high_y = -low_x;
  double beyond = 0.0;
  std::vector<const SurfaceSample*> kept;
  for (const SurfaceSample& one : samples) {
    if (one.normal.dot(n) < kFacing || one.planned_normal.dot(n) < 0.1) continue;
    if (std::abs(one.deviation) > options.reach) {
      beyond += one.normal.dot(n) * options.cell * options.cell;
      continue;
    }
    kept.push_back(&one);
    low_x = std::min(low_x, x.dot(one.p));
    high_x = std::max(high_x, x.dot(one.p));
    low_y = std::min(low_y, y.dot(one.p));
    high_y = std::max(high_y, y.dot(one.p));
  }
  if (kept.size() < 4)
    throw InvalidInput(Fault{"surface", std::to_string(kept.size()) + " places",
                             "must have a cut within finish.reach_mm of the plan",
                             "check the plan against the path, or raise finish.reach_mm"});
  result.beyond_area = beyond;
  // Points of a level plane lie over the middles of voxels: those become the middles of cells.
  low_x -= 0.5 * map.cell;
  low_y -= 0.5 * map.cell;
  map.along = 1 + static_cast<int>((high_x - low_x) / map.cell);
  map.across = 1 + static_cast<int>((high_y - low_y) / map.cell);
  map.first_along = low_x + 0.5 * map.cell;
  map.first_across = low_y + 0.5 * map.cell;
  const std::size_t cells =
      static_cast<std::size_t>(map.along) * static_cast<std::size_t>(map.across);
  // Where a wall rises, the normals of the floor beside it are bent: they come from three voxels.
  std::vector<char> beside_wall(cells, 0);
  for (const SurfaceSample& one : samples) {
    if (one.normal.dot(n) >= kFacing || std::abs(one.deviation) > options.reach) continue;
    const int i = static_cast<int>(std::floor((x.dot(one.p) - low_x) / map.cell));
    const int j = static_cast<int>(std::floor((y.dot(one.p) - low_y) / map.cell));
    for (int v = std::max(0, j - 2); v <= std::min(map.across - 1, j + 2); ++v)
      for (int u = std::max(0, i - 2); u <= std::min(map.along - 1, i + 2); ++u)
        beside_wall[static_cast<std::size_t>(v) * static_cast<std::size_t>(map.along) +
                    static_cast<std::size_t>(u)] = 1;
  }
  std::vector<double> count(cells, 0.0);
  map.deviations.assign(cells, 0.0);
  for (const SurfaceSample* one : kept) {
    const double a = x.dot(one->p), b = y.dot(one->p);
    const int i = std::min(map.along - 1, static_cast<int>((a - low_x) / map.cell));
    const int j = std::min(map.across - 1, static_cast<int>((b - low_y) / map.cell));
    // On the tangents of surface and plan to the middle of the cell.
    const auto slope = [&](const Vector3& axis) {
      return one->planned_normal.dot(axis) / one->planned_normal.dot(n) -
             one->normal.dot(axis) / one->normal.dot(n);
    };
    const double to_x = map.first_along + i * map.cell - a,
                 to_y = map.first_across + j * map.cell - b;
    const std::size_t at = static_cast<std::size_t>(j) * static_cast<std::size_t>(map.along) +
                           static_cast<std::size_t>(i);
    if (beside_wall[at] != 0) continue;
    map.deviations[at] += one->deviation + slope(x) * to_x + slope(y) * to_y;
    count[at] += 1.0;
  }
  std::vector<Vector3> points;
  double filled = 0.0;
  result.lowest = std::numeric_limits<double>::infinity();
  result.highest = -result.lowest;
  for (std::size_t at = 0; at < cells; ++at) {
    if (count[at] == 0.0) {
      map.deviations[at] = kNone;
      continue;
    }
    const double d = map.deviations[at] /= count[at];
    filled += 1.0;
    result.mean += d;
    result.rms += d * d;
    result.lowest = std::min(result.lowest, d);
    result.highest = std::max(result.highest, d);
    const auto i = static_cast<double>(at % static_cast<std::size_t>(map.along));
    const auto j = static_cast<double>(at / static_cast<std::size_t>(map.along));
    points.push_back((map.first_along + i * map.cell) * x + (map.first_across + j * map.cell) * y +
                     d * n);
  }
  result.mean /= filled;
  result.rms = std::sqrt(result.rms / filled);
  result.area = filled * map.cell * map.cell;
  if (options.plane && points.size() >= 4) result.fit = fit_plane(points, n);
  close_gaps(map);
  const std::vector<Profile> lines_along = profiles(map, true), lines_across = profiles(map, false);
  result.along = roughness(lines_along, map.cell, options.sampling_length);
  result.across = roughness(lines_across, map.cell, options.sampling_length);
  result.scallops = scallops(lines_across, map.cell);
  return result;
}

double ball_scallop(double radius, double spacing) {
  const double half = std::min(0.5 * spacing, radius);
  return radius - std::sqrt(radius * radius - half * half);
}

}  // namespace osteomill::study
