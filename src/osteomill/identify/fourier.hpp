// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <complex>
#include <vector>

namespace osteomill::identify {

using Spectrum = std::vector<std::complex<double>>;

/// The next length ≥ n without prime factors beyond 5, for which the transform is fast.
std::size_t fast_length(std::size_t n);

/// Σ x_k exp(−2πi jk/n), j = 0 … n − 1; the signal is continued by zeros to `length`.
Spectrum forward(const Eigen::Ref<const Eigen::VectorXd>& signal, std::size_t length);

/// Inverse of `forward`, 1/n included.
Spectrum backward(const Spectrum& spectrum);

}  // namespace osteomill::identify
