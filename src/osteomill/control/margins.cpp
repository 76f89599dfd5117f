// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/control/margins.hpp"

#include <Eigen/LU>
#include <boost/math/tools/roots.hpp>
#include <cmath>
#include <complex>
#include <cstdint>
#include <limits>
#include <numbers>

#include "osteomill/base/error.hpp"

namespace osteomill::control {
namespace {

using Complex = std::complex<double>;

/// Frequency response of taps, accumulator, delay and servo, without gain and K_f.
class Shape {
 public:
  explicit Shape(const LinearPlant& plant) : plant_(plant) {
    if (plant.servo) {
      const numerics::HeldLag held(*plant.servo, plant.period);
      // The mean feed of a period is the integral's growth; the integral itself starts at zero.
      transition_ = held.transition().bottomRightCorner<2, 2>();
      input_ = held.input().tail<2>();
      mean_of_state_ = held.transition().row(0).tail<2>() / plant.period;
      mean_of_input_ = held.input()[0] / plant.period;
    }
  }

  Complex operator()(double angle) const {
    const Complex z = std::polar(1.0, angle);
    Complex taps = 0.0;
    for (int k = 0; k < kSugitaTaps; ++k) taps += std::pow(z, -k);
    return taps / (1.0 - 1.0 / z) * std::pow(z, -plant_.delay_updates) * servo(z);
  }

 private:
  Complex servo(Complex z) const {
    if (!plant_.servo) return 1.0;
    const Eigen::Matrix2cd resolvent = z * Eigen::Matrix2cd::Identity() - transition_;
    const Eigen::Vector2cd state = resolvent.inverse() * input_;
    return (mean_of_state_.cast<Complex>() * state).value() + mean_of_input_;
  }

  LinearPlant plant_;
  Eigen::Matrix2d transition_;
  Eigen::Vector2d input_;
  Eigen::RowVector2d mean_of_state_;
  double mean_of_input_ = 0.0;
};

/// Zeros of f between neighbours of opposite sign on a grid over (0, pi].
template <class F, class Visit>
void for_each_root(const F& f, const Visit& visit) {
  const int cells = 4096;
  double low = 1e-6;
  double f_low = f(low);
  for (int cell = 1; cell <= cells; ++cell) {
    const double high = std::numbers::pi * cell / cells;
    const double f_high = f(high);
    if (f_low * f_high < 0.0) {
      std::uintmax_t iterations = 100;
      const auto bracket = boost::math::tools::toms748_solve(
          f, low, high, f_low, f_high, boost::math::tools::eps_tolerance<double>(50), iterations);
      visit(0.5 * (bracket.first + bracket.second));
    }
    low = high;
    f_low = f_high;
  }
}

}  // namespace

Margins margins(const LinearPlant& plant, double gain) {
  require_positive("gain", gain, "m/s per N");
  require_positive("force_gain", plant.force_gain, "N/(m/s)");
  require_within("delay_updates", plant.delay_updates, 1, 100, "");
  const Shape shape(plant);
  const double loop_gain = gain * plant.force_gain;

  Margins found;
  found.critical_loop_gain = std::numeric_limits<double>::infinity();
  for_each_root([&](double angle) { return shape(angle).imag(); },
                [&](double angle) {
                  const double real = shape(angle).real();
                  if (real < 0.0 && -1.0 / real < found.critical_loop_gain) {
                    found.critical_loop_gain = -1.0 / real;
                    found.critical_frequency = angle / plant.period;
                  }
                });
  found.gain_margin = found.critical_loop_gain / loop_gain;

  found.phase_margin = std::numeric_limits<double>::infinity();
  for_each_root([&](double angle) { return std::abs(shape(angle)) * loop_gain - 1.0; },
                [&](double angle) {
                  const double margin = std::remainder(std::numbers::pi + std::arg(shape(angle)),
                                                       2.0 * std::numbers::pi);
                  if (margin < found.phase_margin) {
                    found.phase_margin = margin;
                    found.crossover_frequency = angle / plant.period;
                  }
                });
  return found;
}

std::complex<double> open_loop(const LinearPlant& plant, double gain, double frequency) {
  require_within("frequency", frequency * plant.period / std::numbers::pi, 1e-9, 1.0 + 1e-9,
                 "of the Nyquist frequency");
  return gain * plant.force_gain * Shape(plant)(frequency * plant.period);
}

}  // namespace osteomill::control
