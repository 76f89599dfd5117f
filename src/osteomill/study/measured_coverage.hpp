// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

/// How often intervals held the truth in simulated studies with errors of several shapes: numbers
/// that stand beside the intervals they qualify. Measured by ./run coverage; the tables are in
/// docs/theory/study.md.
namespace osteomill::study {

struct CoverageRange {
  double low = 0.0;
  double high = 0.0;
};

/// Of the 95 % interval of an SD without normality, over twelve shapes of errors, for so many cuts.
/// Nothing below ten cuts, where it was not measured.
std::optional<CoverageRange> coverage_without_normality(int cuts);

}  // namespace osteomill::study
