// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <emmintrin.h>

#include <cstdint>
#include <cstring>

/// A few values side by side, for the loops over voxels and cells: vectors of 16 bytes, which all
/// processors that the program runs on have, so that every one gives the same bits.
namespace osteomill::workpiece {

inline constexpr int kFour = 4, kEight = 8;  // of how many
using TwoDoubles = double __attribute__((vector_size(16)));
using FourFloats = float __attribute__((vector_size(16)));
using FourInts = std::int32_t __attribute__((vector_size(16)));
using EightShorts = std::uint16_t __attribute__((vector_size(16)));

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

inline int sum_of(const FourInts& v) { return (v[0] + v[2]) + (v[1] + v[3]); }
inline bool all_zero(const FourFloats& v) {
  return _mm_movemask_ps(_mm_cmpneq_ps(v, _mm_setzero_ps())) == 0;
}
inline TwoDoubles root(const TwoDoubles& v) { return _mm_sqrt_pd(v); }
inline TwoDoubles least(const TwoDoubles& a, const TwoDoubles& b) { return _mm_min_pd(a, b); }
inline TwoDoubles most(const TwoDoubles& a, const TwoDoubles& b) { return _mm_max_pd(a, b); }
/// Whole parts of 0 to 65535.
inline EightShorts as_shorts(const TwoDoubles v[4]) {
  const auto four = [&](int i) {  // signed, as the packing wants them
    const __m128i whole = _mm_unpacklo_epi64(_mm_cvttpd_epi32(v[i]), _mm_cvttpd_epi32(v[i + 1]));
    return _mm_sub_epi32(whole, _mm_set1_epi32(0x8000));
  };
  const __m128i shorts = _mm_packs_epi32(four(0), four(2));
  return reinterpret_cast<EightShorts>(shorts) ^ std::uint16_t{0x8000};
}
/// a - b, 0 where b is the larger.
inline EightShorts less(const EightShorts& a, const EightShorts& b) {
  return reinterpret_cast<EightShorts>(
      _mm_subs_epu16(reinterpret_cast<__m128i>(a), reinterpret_cast<__m128i>(b)));
}
inline FourInts first_four(const EightShorts& v) {
  return reinterpret_cast<FourInts>(
      _mm_unpacklo_epi16(reinterpret_cast<__m128i>(v), _mm_setzero_si128()));
}
inline FourInts last_four(const EightShorts& v) {
  return reinterpret_cast<FourInts>(
      _mm_unpackhi_epi16(reinterpret_cast<__m128i>(v), _mm_setzero_si128()));
}
inline FourFloats as_floats(const FourInts& v) { return __builtin_convertvector(v, FourFloats); }

/// Least multiple of four that is not smaller.
inline int up_to_four(int count) { return (count + kFour - 1) / kFour * kFour; }
inline std::size_t up_to_eight(std::size_t count) { return (count + 7) / 8 * 8; }

}  // namespace osteomill::workpiece
