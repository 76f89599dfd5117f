// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "osteomill/io/csv_file.hpp"
#include "osteomill/study/cut_measure.hpp"

namespace osteomill::io {

/// Tracker exports → the tidy table of `osteomill study`. One row a cut:
///
///   cut_kind   proximal-tibia | distal-femur | anterior-femur | posterior-femur
///   side       left | right
///   guide_…, guide_after_… (may be missing), cut_…: orientation in a frame fixed to the bone, as
///     _qw _qx _qy _qz        a pose whose x points to the entry and z out of the bone, or
///     _nx _ny _nz            a normal; the guide's outward, with guide_ex _ey _ez to the entry
///
/// Where guide or cut columns are missing they come from points: cut_id, surface (guide | cut),
/// x_mm, y_mm, z_mm, in the same frame; then flatness_um, roughness_um and the predicted precision
/// stand in the result too. All other columns go through as they are.
struct MeasuredCuts {
  CsvFile table;  ///< with the errors' columns behind
  std::vector<std::string> warnings;
};

/// Throws InvalidInput with the faults of all rows: mirrored or scaled poses, unknown words,
/// missing numbers, points that span no plane.
MeasuredCuts measure_cuts(const CsvFile& cuts, const std::optional<CsvFile>& points);

/// Scatter of the two errors over repeated placements of the dummy implant on one cut, rad.
struct MeasuredPrecision {
  study::PlacementPrecision varus_valgus, flexion_extension;
};
MeasuredPrecision measure_precision(const CsvFile& placements);

}  // namespace osteomill::io
