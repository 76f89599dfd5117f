// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <vector>

#include "osteomill/identify/force_record.hpp"

namespace osteomill::identify {

/// Samples begin ≤ i < end.
struct Segment {
  Eigen::Index begin = 0;
  Eigen::Index end = 0;
  Eigen::Index size() const { return end - begin; }
};

struct SegmentOptions {
  double window = 0.05;       ///< of the moving level, s; some revolutions
  double shortest_cut = 0.1;  ///< s
  double settle_band = 0.15;  ///< share of its median by which the level of the plateau may differ
  double guard = 0.0;         ///< left out at both ends of the plateau, s
  double contrast = 3.0;      ///< level in the cut over that outside; with less there is no entry
  /// The plateau from when to when, s from the first sample, where it is not to be found.
  std::optional<std::array<double, 2>> plateau = {};
};

/// Where a record is cutting.
struct Segmentation {
  std::vector<Segment> idle;  ///< before, between and after the cuts; without their edges
  std::vector<Segment> cuts;  ///< entry to exit
  Segment plateau;            ///< the steady part of the longest cut
  double idle_level = 0.0;    ///< root mean square of |F − idle mean|, N
  double cut_level = 0.0;     ///< N
  bool whole = false;         ///< no idle part was seen: the whole record is taken for the cut
  double steady = 1.0;        ///< share of the plateau whose level lies within the band
};

/// Entry and exit of the cuts and the plateau between. The moving root mean square of the force
/// about its idle value is split into two classes by Otsu's threshold [otsu1979]; a cut begins and
/// ends where the level crosses the threshold, the plateau where it settles about its median. When
/// the two classes differ by less than `contrast`, the whole record counts as cut.
/// Throws InvalidInput for a record shorter than two windows.
Segmentation segment(const ForceRecord& record, const SegmentOptions& options = {});

/// The samples of a segment as a record of their own.
ForceRecord cut_out(const ForceRecord& record, const Segment& segment);

}  // namespace osteomill::identify
