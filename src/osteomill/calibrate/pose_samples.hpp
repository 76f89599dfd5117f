// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <optional>
#include <vector>

#include "osteomill/geometry/pose.hpp"

namespace osteomill::calibrate {

using geometry::Pose;
using geometry::Vector3;

/// One reading of a tracked body G in the reference body F.
struct PoseSample {
  bool visible = true;  ///< false: a marker was hidden, X_FG holds nothing
  Pose X_FG = Pose::Identity();
};

/// What the samples at one stop say. Deviations are those of a single reading, per coordinate.
struct StopMean {
  Pose X_FG = Pose::Identity();
  double position_sd = 0.0;  ///< m
  double rotation_sd = 0.0;  ///< rad
  int used = 0;
  int hidden = 0;
};

/// Mean pose: arithmetic mean of positions, Karcher mean of rotations. Throws InvalidInput with
/// less than two visible samples.
StopMean average(const std::vector<PoseSample>& samples);

/// Rotation vector between two poses' orientations, in the second's frame: log(R_a' R_b).
Vector3 rotation_between(const Pose& a, const Pose& b);

/// The display filter: the mean of the last `window` acceptable readings; a reading whose distance
/// from the mean of the recent ones is more than `reject_sd` times their standard deviation is not
/// acceptable. [plaskos2006] 4.3.4.
///
/// The source leaves open what is recent, and how a pose has one deviation. Here the last
/// 2 · window readings are recent, rejected ones among them: a deviation of accepted readings only
/// would shrink with every rejection. Distances are norms, of the position and of the rotation
/// apart.
class PoseFilter {
 public:
  struct Options {
    int window = 10;
    double reject_sd = 2.0;
  };
  PoseFilter() : PoseFilter(Options{}) {}
  explicit PoseFilter(const Options& options);

  /// Takes a reading; the filtered pose, empty before the first visible reading.
  std::optional<Pose> push(const PoseSample& sample);

 private:
  Options options_;
  std::deque<Pose> recent_;
};

}  // namespace osteomill::calibrate
