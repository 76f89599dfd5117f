// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "osteomill/base/error.hpp"
#include "osteomill/identify/force_record.hpp"
#include "osteomill/identify/segments.hpp"

namespace osteomill::identify {

/// Samples at the end of the range, three or more in a row.
struct Saturation {
  int axis = 0;        ///< 0 x, 1 y, 2 z
  double level = 0.0;  ///< N
  std::vector<Segment> runs;
  Eigen::Index samples = 0;
};

/// A range limit shows as runs of exactly one value at the largest or smallest value of an axis.
/// @param range  N, of each axis; 0 where it is not known: then the extremes of the record are
///               judged: eight samples or more, in runs of three or more, at exactly one value
std::vector<Saturation> find_saturation(const ForceRecord& record,
                                        const Eigen::Vector3d& range = Eigen::Vector3d::Zero());

struct TimeCheck {
  double rate = 0.0;          ///< of the time column, Hz
  std::vector<Segment> gaps;  ///< i, i + 1 about each gap
  double missing = 0.0;       ///< samples that are missing
};

/// The rate that a time column has, and where samples are missing. Throws InvalidInput for a time
/// that does not grow.
/// @param time  s
TimeCheck check_time(const Eigen::VectorXd& time);

/// What the sampling does to the tooth-passing line; empty when it is sampled well enough:
/// fewer than ten samples a tooth, or the line above half the rate, with the frequency where it
/// then shows ([tian2023] sampled 666.7 Hz at 1 kHz).
std::vector<std::string> sampling_warnings(double rate, double spindle_speed, int flutes);

}  // namespace osteomill::identify
