// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <complex>
#include <vector>

#include "osteomill/identify/force_record.hpp"

namespace osteomill::identify {

/// What a dynamometer shows of a force, over frequency: shown = H(f) × applied, one H an axis of T.
struct DynamometerResponse {
  std::vector<double> frequency_hz;                                 ///< growing, > 0
  Eigen::Matrix<std::complex<double>, Eigen::Dynamic, 3> response;  ///< lines × 3, 1 at rest
};

struct CompensationOptions {
  /// |H| below which the sensor shows more noise than force: the inverse is H*/max(|H|², floor²),
  /// so no frequency is amplified more than 1/floor times.
  double noise_floor = 0.2;
  /// Beyond this nothing is compensated and the force is taken away, half a cosine before it;
  /// 0: the end of the measured response.
  double highest_hz = 0.0;
};

/// The force that was applied, by the inverse of the measured response in the frequency domain, as
/// [castro2006] corrects piezoelectric dynamometers; the floor is ours. Below the first measured
/// line the response goes straight to 1 at rest. The ends are extended as in `zero_phase`. Throws
/// InvalidInput for lines that do not grow or a highest frequency beyond them.
ForceRecord compensate(const ForceRecord& record, const DynamometerResponse& dynamometer,
                       const CompensationOptions& options = {});

}  // namespace osteomill::identify
