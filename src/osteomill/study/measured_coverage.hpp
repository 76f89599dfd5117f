// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

/// How often 95 % intervals held the truth in simulated studies with errors of twelve shapes:
/// numbers that stand beside the intervals they qualify. Measured by ./run coverage; the tables are
/// in docs/theory/study.md.
namespace osteomill::study {

struct CoverageRange {
  double low = 0.0;
  double high = 0.0;
};

/// Of the interval of an SD without normality, over the shapes, from so many cuts. Nothing below
/// ten cuts, where it was not measured.
std::optional<CoverageRange> coverage_without_normality(int cuts);

/// Of the chi-squared interval where the errors are not normal, which few cuts may hide.
std::optional<CoverageRange> coverage_of_chi_squared(int cuts);

/// What the intervals of a report held where the errors were not normal, in one sentence.
inline constexpr const char* kCoverageIfNotNormal =
    "with eleven other shapes of errors, 95 % intervals that suppose normal ones held the truth in "
    "69-100 % (SD by chi-squared), 70-99 % (component of single cuts), 73-99 % (ratio of "
    "variances), 29-97 % (share outside), 89-99 % (tolerance interval) and 88-97 % (mean of one "
    "operator's few cuts) of simulated studies; those of differences of means, slopes and adjusted "
    "means in 91-98 %";

}  // namespace osteomill::study
