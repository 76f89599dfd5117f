// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/study/measured_coverage.hpp"

namespace osteomill::study {

std::optional<CoverageRange> coverage_without_normality(int cuts) {
  if (cuts < 10) return {};
  return CoverageRange{0.0, 1.0};
}

}  // namespace osteomill::study
