// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/numerics/revolution_window.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <numeric>

namespace osteomill::numerics {

RevolutionWindow::RevolutionWindow(double speed, double rate, double period) : turn_(speed / rate) {
  const double revolution = 2.0 * std::numbers::pi / speed;
  // A millionth, so that 10 ms at 6000 rpm hold one revolution in spite of rounding.
  const double revolutions = std::max(1.0, std::floor(period / revolution + 1e-6));
  const double count = std::max(1.0, std::round(revolutions * revolution * rate));
  samples_.assign(static_cast<std::size_t>(count), 0.0);
}

double RevolutionWindow::mean() const {
  return std::accumulate(samples_.begin(), samples_.end(), 0.0) /
         static_cast<double>(samples_.size());
}

double RevolutionWindow::line(int per_revolution) const {
  std::complex<double> sum = 0.0;
  const double turn = turn_ * per_revolution;
  for (std::size_t i = 0; i < samples_.size(); ++i) {
    sum += samples_[(at_ + i) % samples_.size()] * std::polar(1.0, -turn * static_cast<double>(i));
  }
  return 2.0 * std::abs(sum) / static_cast<double>(samples_.size());
}

}  // namespace osteomill::numerics
