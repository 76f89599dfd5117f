// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/study/measured_coverage.hpp"

#include <array>

namespace osteomill::study {
namespace {

struct Measured {
  int cuts;
  CoverageRange chi_squared;
  CoverageRange without_normality;
};

// Least and greatest of the twelve shapes: chi-squared from 2 000 (held-out) and 4 000 studies
// each, without normality from 2 000 each.
constexpr std::array<Measured, 5> kMeasured = {{{10, {0.795, 0.980}, {0.918, 0.962}},
                                                {20, {0.744, 0.993}, {0.908, 0.960}},
                                                {30, {0.712, 0.995}, {0.892, 0.960}},
                                                {60, {0.692, 0.997}, {0.889, 0.963}},
                                                {99, {0.693, 0.999}, {0.912, 0.960}}}};

/// The largest study measured that is no larger.
const Measured* measured(int cuts) {
  const Measured* found = nullptr;
  for (const Measured& m : kMeasured) {
    if (m.cuts <= cuts) found = &m;
  }
  return found;
}

}  // namespace

std::optional<CoverageRange> coverage_without_normality(int cuts) {
  const Measured* m = measured(cuts);
  return m ? std::optional(m->without_normality) : std::nullopt;
}

std::optional<CoverageRange> coverage_of_chi_squared(int cuts) {
  const Measured* m = measured(cuts);
  return m ? std::optional(m->chi_squared) : std::nullopt;
}

}  // namespace osteomill::study
