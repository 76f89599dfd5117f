// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>

/// The vector code behind ComponentBatch. One translation unit an instruction set, each compiled
/// with its own flags: nothing here may be an inline function of a shared header.
namespace osteomill::cutting::kernel {

/// F = exp(a + b l + c l²) + edge in N/m, l = ln of h in µm. Log laws and power laws.
struct Curve {
  double a, b, c, edge;
};

/// Tangential, radial, lateral; along and across the fibres.
struct Curves {
  Curve along[3];
  Curve across[3];
  bool directional[3];
  double scale[3];
  int components;  ///< 2 or 3
};

using Evaluate = void (*)(const Curves& curves, const double* h, const double* cosine,
                          std::size_t count, double* const out[3]);

void evaluate_sse2(const Curves&, const double*, const double*, std::size_t, double* const[3]);
void evaluate_avx2(const Curves&, const double*, const double*, std::size_t, double* const[3]);

}  // namespace osteomill::cutting::kernel
