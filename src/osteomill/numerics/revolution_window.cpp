// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/numerics/revolution_window.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

namespace osteomill::numerics {

RevolutionWindow::RevolutionWindow(double speed, double rate, double period)
    : rate_(rate), period_(period) {
  set_speed(speed);
}

void RevolutionWindow::set_speed(double speed) {
  turn_ = speed / rate_;
  const double revolution = 2.0 * std::numbers::pi / speed;
  // A millionth, so that 10 ms at 6000 rpm hold one revolution in spite of rounding.
  const double revolutions = std::max(1.0, std::floor(period_ / revolution + 1e-6));
  const double count = std::max(1.0, std::round(revolutions * revolution * rate_));
  count_ = static_cast<std::size_t>(count);
  if (count_ <= samples_.size()) return;
  // A longer ring, the oldest first; what came before is taken for zero.
  std::rotate(samples_.begin(), samples_.begin() + static_cast<std::ptrdiff_t>(at_),
              samples_.end());
  samples_.insert(samples_.begin(), count_ - samples_.size(), 0.0);
  at_ = 0;
}

double RevolutionWindow::mean() const {
  double sum = 0.0;
  for (std::size_t i = 0; i < count_; ++i) sum += newest(count_ - 1 - i);
  return sum / static_cast<double>(count_);
}

double RevolutionWindow::line(int per_revolution) const {
  std::complex<double> sum = 0.0;
  const double turn = turn_ * per_revolution;
  for (std::size_t i = 0; i < count_; ++i) {
    sum += newest(count_ - 1 - i) * std::polar(1.0, -turn * static_cast<double>(i));
  }
  return 2.0 * std::abs(sum) / static_cast<double>(count_);
}

}  // namespace osteomill::numerics
