// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>

/// The vector code behind ComponentBatch and sliced_revolution. One translation unit an instruction
/// set, each compiled with its own flags: nothing here may be an inline function of a shared
/// header.
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

/// Edge elements of one flute in one slice, at rotation angles that a table has: the element's
/// angle is that of the table less a lag.
struct Strip {
  double sin_lag, cos_lag;
  double chip_sine;  ///< h = chip_sine sin theta - chip_axial
  double chip_axial;
  double fibre_x, fibre_y;
  double sin_kappa, cos_kappa;
  double width;  ///< of cut, m
};

struct Functions {
  const char* name;
  /// out[component][i] for h[i] and the cosine between motion and fibres.
  void (*evaluate)(const Curves&, const double* h, const double* cosine, std::size_t count,
                   double* const out[3]);
  /// Adds the forces of a strip at `count` angles of the table to x, y, z.
  void (*add_strip)(const Curves&, const Strip&, const double* sine, const double* cosine,
                    std::size_t count, double* x, double* y, double* z);
  /// out[i] = exp(in[i]) and ln(in[i]), the kernel's own, to measure what it could reach.
  void (*exponential)(const double* in, std::size_t count, double* out);
  void (*logarithm)(const double* in, std::size_t count, double* out);
};

extern const Functions kSse2;
extern const Functions kAvx2;
extern const Functions kAvx512;

/// The widest that this machine has.
const Functions& best();

}  // namespace osteomill::cutting::kernel
