// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <emmintrin.h>

#include <cstdint>
#include <cstring>

/// A few values side by side, for the loops over voxels and cells: vectors of 16 bytes, which all
/// processors that the program runs on have, so that every one gives the same bits.
namespace osteomill::workpiece {

inline constexpr int kFour = 4, kEight = 8;  // of how many
using FourFloats = float __attribute__((vector_size(16)));
using FourInts = std::int32_t __attribute__((vector_size(16)));

template <class Vector, class T>
Vector load(const T* from) {
  Vector lanes;
  std::memcpy(&lanes, from, sizeof lanes);
  return lanes;
}
template <class Vector, class T>
void store(const Vector& lanes, T* to) {
  std::memcpy(to, &lanes, sizeof lanes);
}

inline float sum_of(const FourFloats& v) { return (v[0] + v[2]) + (v[1] + v[3]); }

/// Of each.
inline FourFloats sums_of(const FourFloats& a, const FourFloats& b, const FourFloats& c,
                          const FourFloats& d) {
  const FourFloats ab = _mm_unpacklo_ps(a, b) + _mm_unpackhi_ps(a, b);
  const FourFloats cd = _mm_unpacklo_ps(c, d) + _mm_unpackhi_ps(c, d);
  return FourFloats(_mm_movelh_ps(ab, cd)) + FourFloats(_mm_movehl_ps(cd, ab));
}

/// Least multiple of four that is not smaller.
inline int up_to_four(int count) { return (count + kFour - 1) / kFour * kFour; }
inline std::size_t up_to_eight(std::size_t count) { return (count + 7) / 8 * 8; }

}  // namespace osteomill::workpiece
