// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Random123/philox.h>

#include <cmath>
#include <cstdint>
#include <numbers>

namespace osteomill {

/// Reproducible random numbers that do not depend on who draws when: the stream is a function of
/// (seed, stream) alone, so that sample 17 of a Monte Carlo is the same on any number of threads
/// when it draws from Random(seed, 17). Counter-based generator Philox 4x32 (Salmon et al. 2011).
class Random {
 public:
  explicit Random(std::uint64_t seed, std::uint64_t stream = 0)
      : key_{{static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32)}},
        counter_{
            {0, 0, static_cast<std::uint32_t>(stream), static_cast<std::uint32_t>(stream >> 32)}} {}

  /// 64 equally likely bits.
  std::uint64_t bits() {
    if (left_ == 0) {
      block_ = r123::Philox4x32()(counter_, key_);
      if (++counter_[0] == 0) ++counter_[1];
      left_ = 2;
    }
    --left_;
    return (std::uint64_t{block_[2 * left_]} << 32) | block_[2 * left_ + 1];
  }

  /// Uniform on the open interval (0, 1): the middle of one of 2^53 cells.
  double uniform() { return (static_cast<double>(bits() >> 11) + 0.5) * 0x1p-53; }

  double uniform(double low, double high) { return low + (high - low) * uniform(); }

  /// Standard normal deviate (Box and Muller).
  double normal() {
    if (has_spare_) {
      has_spare_ = false;
      return spare_;
    }
    const double radius = std::sqrt(-2.0 * std::log(uniform()));
    const double angle = 2.0 * std::numbers::pi * uniform();
    spare_ = radius * std::sin(angle);
    has_spare_ = true;
    return radius * std::cos(angle);
  }

  double normal(double mean, double standard_deviation) {
    return mean + standard_deviation * normal();
  }

 private:
  r123::Philox4x32::key_type key_;
  r123::Philox4x32::ctr_type counter_;
  r123::Philox4x32::ctr_type block_{};
  int left_ = 0;
  double spare_ = 0.0;
  bool has_spare_ = false;
};

}  // namespace osteomill
