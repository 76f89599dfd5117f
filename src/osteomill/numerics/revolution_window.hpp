// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

namespace osteomill::numerics {

/// The newest samples of a signal over whole revolutions of a spindle, a ring. Over whole
/// revolutions the ripple of the teeth averages out, and a line of the spectrum is one term of the
/// Fourier series.
class RevolutionWindow {
 public:
  /// The largest whole number of revolutions that `period` holds, or one where it takes longer.
  /// @param speed  of the spindle, rad/s · @param rate  of the samples, 1/s · @param period  s
  RevolutionWindow(double speed, double rate, double period);
  /// The spindle turns at another speed, rad/s, from now on: the window gets the length that fits.
  void set_speed(double speed);

  void add(double sample) {
    samples_[at_] = sample;
    at_ = (at_ + 1) % samples_.size();
  }
  double mean() const;
  /// Amplitude at so many times the frequency of the spindle.
  double line(int per_revolution) const;
  std::size_t size() const { return count_; }

  /// See base/archive.hpp.
  template <class Archive>
  void exchange(Archive& a) {
    a(samples_, at_, count_, turn_);
  }

 private:
  double newest(std::size_t ago) const {
    return samples_[(at_ + samples_.size() - 1 - ago) % samples_.size()];
  }

  std::vector<double> samples_;  ///< zero before the first
  std::size_t at_ = 0;           ///< the oldest
  double rate_ = 0.0;            ///< 1/s
  double period_ = 0.0;          ///< s
  std::size_t count_ = 0;        ///< of the newest samples that make whole revolutions
  double turn_ = 0.0;            ///< of the spindle from sample to sample, rad
};

}  // namespace osteomill::numerics
