// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "osteomill/study/cut_measure.hpp"

namespace osteomill::study {

/// A place on a cut surface against the plan.
struct SurfaceSample {
  Vector3 p = Vector3::Zero();
  Vector3 normal = Vector3::UnitZ();          ///< of the surface, out of the bone
  double deviation = 0.0;                     ///< from the plan: > 0 bone is left, m
  Vector3 planned_normal = Vector3::UnitZ();  ///< of the plan's surface there
};

struct FinishedSurfaceOptions {
  Vector3 normal = Vector3::UnitZ();  ///< out of the bone: the surface is looked at against it
  Vector3 feed = Vector3::UnitX();    ///< along which it was cut
  double cell = 0.2e-3;               ///< of the height map, m: the voxel
  /// Of a roughness profile, m: 8 mm is that of ISO 4288 for ridges 1.3 to 4 mm apart.
  double sampling_length = 8e-3;
  double reach = 2e-3;  ///< what is farther from the plan is no finished surface: ledges, m
  bool plane = true;    ///< the plan is one
};

/// Of profiles in one direction: the mean over the sampling lengths of the arithmetic mean and of
/// the largest minus the smallest height about the length's own least-squares line (Ra and Rz of
/// ISO 4287; no Gaussian filter, no ball's radius).
struct Roughness {
  double ra = 0.0;          ///< m
  double rz = 0.0;          ///< m
  std::size_t lengths = 0;  ///< sampling lengths; 0: the surface is too small for one
};

/// Ridges between passes, across the feed: the height of a ridge over the mean of the lowest places
/// on its two sides. A ridge is where the parabolas from both sides meet. None where they are less
/// than seven cells apart.
struct Scallops {
  double mean = 0.0;     ///< m
  double largest = 0.0;  ///< m
  double spacing = 0.0;  ///< from ridge to ridge, median, m
  std::size_t count = 0;
};

/// Heights over a plan, seen against the normal, on square cells: each the mean of what its points
/// say of its middle.
struct HeightMap {
  int along = 0, across = 0;       ///< cells in the feed's direction, and to its left
  double cell = 0.0;               ///< m
  double first_along = 0.0;        ///< of the middle of cell 0, m
  double first_across = 0.0;       ///< m
  std::vector<double> deviations;  ///< along runs fastest; NaN where there is none
  double at(int i, int j) const {
    return deviations[static_cast<std::size_t>(j) * static_cast<std::size_t>(along) +
                      static_cast<std::size_t>(i)];
  }
};

struct FinishedSurface {
  double area = 0.0;            ///< seen against the normal, m²
  double beyond_area = 0.0;     ///< of cut surface beyond `reach` of the plan, m²
  double mean = 0.0;            ///< of the deviation, m
  double rms = 0.0;             ///< of the deviation
  double lowest = 0.0;          ///< most over-cut
  double highest = 0.0;         ///< most bone left
  std::optional<PlaneFit> fit;  ///< least-squares plane: flatness, roughness about a quadric
  Roughness along, across;      ///< the feed
  Scallops scallops;
  HeightMap map;
};

/// Throws InvalidInput when no sample is on a finished surface.
FinishedSurface measure_surface(std::span<const SurfaceSample> samples,
                                const FinishedSurfaceOptions& options);

/// Height of the ridge between two passes of a ball: r - sqrt(r² - (s/2)²).
double ball_scallop(double radius, double spacing);

}  // namespace osteomill::study
