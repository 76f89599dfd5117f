// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "osteomill/base/error.hpp"
#include "osteomill/vibration/frequency_response.hpp"

namespace osteomill::vibration {
namespace {

using Complex = std::complex<double>;
constexpr double kTurn = 2.0 * std::numbers::pi;

/// Lines of the band with their weights.
struct Band {
  std::vector<double> frequency;
  std::vector<Complex> value;
  std::vector<double> weight;
};

Band band_of(const MeasuredFrf& frf, const ModalFitOptions& options) {
  Band band;
  const double high = options.high_hz > 0.0 ? options.high_hz : frf.frequency_hz.back();
  for (std::size_t i = 0; i < frf.frequency_hz.size(); ++i) {
    if (frf.frequency_hz[i] < options.low_hz || frf.frequency_hz[i] > high) continue;
    band.frequency.push_back(frf.frequency_hz[i]);
    band.value.push_back(frf.receptance[i]);
    // Relative deviation of a line: √((1 − γ²)/(2 γ² blows)). One blow has no coherence: all lines
    // weigh alike. A tenth of a per cent is the least that calibration allows.
    double deviation = 1.0;
    if (frf.blows > 1) {
      const double g = std::clamp(frf.coherence[i], 1e-6, 1.0);
      deviation = std::abs(frf.receptance[i]) *
                  std::max(1e-3, std::sqrt((1.0 - g) / (2.0 * g * frf.blows)));
    }
    band.weight.push_back(1.0 / std::max(deviation, 1e-300));
  }
  return band;
}

/// Parameters per mode: ln f, ln ζ, ln k; then the residual flexibility.
Complex model(const Eigen::VectorXd& p, double frequency, double window_damping) {
  // With an exponential window every line stands at s = iω + σ.
  const Complex s(window_damping, kTurn * frequency);
  Complex sum = p[p.size() - 1];
  for (Eigen::Index m = 0; 3 * m + 2 < p.size(); ++m) {
    const double omega = kTurn * std::exp(p[3 * m]), zeta = std::exp(p[3 * m + 1]);
    const Complex r = s / omega;
    sum += std::exp(-p[3 * m + 2]) / (1.0 + r * r + 2.0 * zeta * r);
  }
  return sum;
}

Eigen::VectorXd start(const Band& band, int modes) {
  struct Peak {
    std::size_t place;
    double height;
  };
  std::vector<Peak> peaks;
  for (std::size_t i = 1; i + 1 < band.value.size(); ++i) {
    const double height = std::abs(band.value[i]);
    // The highest within 2 % on either side, so that noise on a flank makes no mode.
    bool highest = true;
    for (std::size_t k = 0; k < band.value.size() && highest; ++k) {
      if (std::abs(band.frequency[k] / band.frequency[i] - 1.0) < 0.02) {
        highest = std::abs(band.value[k]) <= height;
      }
    }
    if (highest) peaks.push_back({i, height});
  }
  std::sort(peaks.begin(), peaks.end(),
            [](const Peak& a, const Peak& b) { return a.height > b.height; });
  if (peaks.size() < static_cast<std::size_t>(modes)) return {};
  Eigen::VectorXd p(3 * modes + 1);
  for (int m = 0; m < modes; ++m) {
    const Peak& peak = peaks[static_cast<std::size_t>(m)];
    // Half-power width by walking down on both sides.
    std::size_t low = peak.place, high = peak.place;
    while (low > 0 && std::abs(band.value[low]) > peak.height / std::numbers::sqrt2) --low;
    while (high + 1 < band.value.size() &&
           std::abs(band.value[high]) > peak.height / std::numbers::sqrt2) {
      ++high;
    }
    const double f = band.frequency[peak.place];
    const double zeta =
        std::clamp(0.5 * (band.frequency[high] - band.frequency[low]) / f, 1e-4, 0.5);
    p[3 * m] = std::log(f);
    p[3 * m + 1] = std::log(zeta);
    p[3 * m + 2] = -std::log(2.0 * zeta * peak.height);
  }
  p[3 * modes] = 0.0;
  return p;
}

}  // namespace

ModalFit fit_modes(const MeasuredFrf& frf, const ModalFitOptions& options) {
  require_within("options.modes", options.modes, 1.0, 20.0, "");
  const Band band = band_of(frf, options);
  const Eigen::Index count = static_cast<Eigen::Index>(band.value.size());
  if (count < 2 * options.modes + 2) {
    throw InvalidInput(Fault{"options.low_hz", fmt::format("{} lines in the band", count),
                             "too few lines for so many modes", "widen the band"});
  }
  ModalFit fit;
  Eigen::VectorXd p = start(band, options.modes);
  if (p.size() == 0) {
    fit.status = "fewer peaks in the band than modes asked for";
    return fit;
  }
  const Eigen::Index unknowns = p.size();
  // The residual flexibility is scaled to the size of the rest.
  double scale = 0.0;
  for (const Complex& value : band.value) scale = std::max(scale, std::abs(value));
  const auto residuals = [&](const Eigen::VectorXd& q) {
    Eigen::VectorXd r(2 * count);
    Eigen::VectorXd real = q;
    real[unknowns - 1] *= scale;
    for (Eigen::Index i = 0; i < count; ++i) {
      const auto k = static_cast<std::size_t>(i);
      const Complex miss =
          band.weight[k] * (model(real, band.frequency[k], frf.window_damping) - band.value[k]);
      r[2 * i] = miss.real();
      r[2 * i + 1] = miss.imag();
    }
    return r;
  };
  const auto jacobian = [&](const Eigen::VectorXd& q) {
    Eigen::MatrixXd j(2 * count, unknowns);
    for (Eigen::Index k = 0; k < unknowns; ++k) {
      Eigen::VectorXd up = q, down = q;
      up[k] += 1e-6;
      down[k] -= 1e-6;
      j.col(k) = (residuals(up) - residuals(down)) / 2e-6;
    }
    return j;
  };
  // Levenberg and Marquardt on logarithms, which keeps every parameter positive.
  double damping = 1e-3;
  Eigen::VectorXd r = residuals(p);
  for (fit.iterations = 1; fit.iterations <= options.most_iterations; ++fit.iterations) {
    const Eigen::MatrixXd j = jacobian(p);
    Eigen::MatrixXd normal = j.transpose() * j;
    const Eigen::VectorXd gradient = j.transpose() * r;
    bool better = false;
    double step_size = 0.0;
    while (!better && damping < 1e12) {
      Eigen::MatrixXd damped = normal;
      damped.diagonal() += damping * normal.diagonal().cwiseMax(1e-300);
      const Eigen::VectorXd step = -damped.ldlt().solve(gradient);
      const Eigen::VectorXd next = residuals(p + step);
      if (next.allFinite() && next.squaredNorm() <= r.squaredNorm()) {
        better = true;
        p += step;
        step_size = step.norm();
        r = next;
        damping *= 0.2;
      } else {
        damping *= 5.0;
      }
    }
    if (!better || step_size < 1e-10) {
      fit.converged = true;
      break;
    }
  }
  fit.status = fit.converged ? "converged" : "not converged: too many iterations";
  const Eigen::MatrixXd j = jacobian(p);
  const double freedom = static_cast<double>(2 * count - unknowns);
  const Eigen::MatrixXd covariance = (j.transpose() * j).inverse() * (r.squaredNorm() / freedom);
  const auto estimate = [&](Eigen::Index k, double sign) {
    const double value = std::exp(sign * p[k]);
    return Estimate{value, value * std::sqrt(std::max(0.0, covariance(k, k)))};
  };
  for (int m = 0; m < options.modes; ++m) {
    fit.modes.push_back({.frequency_hz = estimate(3 * m, 1.0),
                         .stiffness = estimate(3 * m + 2, 1.0),
                         .damping_ratio = estimate(3 * m + 1, 1.0)});
  }
  std::sort(fit.modes.begin(), fit.modes.end(), [](const FittedMode& a, const FittedMode& b) {
    return a.frequency_hz.value < b.frequency_hz.value;
  });
  double squares = 0.0;
  for (Eigen::Index i = 0; i < count; ++i) {
    const double w = band.weight[static_cast<std::size_t>(i)];
    squares += (r[2 * i] * r[2 * i] + r[2 * i + 1] * r[2 * i + 1]) / (w * w);
  }
  fit.residual_rms = std::sqrt(squares / static_cast<double>(count));
  fit.residual_flexibility = p[unknowns - 1] * scale;
  return fit;
}

std::function<std::complex<double>(double)> receptance_of(const MeasuredFrf& frf,
                                                          const ModalFit& fit,
                                                          const ModalFitOptions& options) {
  if (!fit.converged) throw NoSolution("modal fit: " + fit.status);
  Eigen::VectorXd p(3 * static_cast<Eigen::Index>(fit.modes.size()) + 1);
  for (std::size_t m = 0; m < fit.modes.size(); ++m) {
    const auto k = static_cast<Eigen::Index>(3 * m);
    p[k] = std::log(fit.modes[m].frequency_hz.value);
    p[k + 1] = std::log(fit.modes[m].damping_ratio.value);
    p[k + 2] = std::log(fit.modes[m].stiffness.value);
  }
  p[p.size() - 1] = fit.residual_flexibility;
  Band band = band_of(frf, options);
  std::vector<Complex> beside;  // what the lines have beside the fit
  for (std::size_t i = 0; i < band.frequency.size(); ++i) {
    const Complex fitted = model(p, band.frequency[i], 0.0);
    const Complex windowed = model(p, band.frequency[i], frf.window_damping);
    beside.push_back(band.value[i] * fitted / windowed - fitted);
  }
  return [p, f = std::move(band.frequency), beside = std::move(beside)](double frequency_hz) {
    const Complex fitted = model(p, frequency_hz, 0.0);
    if (frequency_hz < f.front() || frequency_hz > f.back()) return fitted;
    const auto right = static_cast<std::size_t>(
        std::upper_bound(f.begin() + 1, f.end() - 1, frequency_hz) - f.begin());
    const double share = (frequency_hz - f[right - 1]) / (f[right] - f[right - 1]);
    return fitted + (1.0 - share) * beside[right - 1] + share * beside[right];
  };
}

}  // namespace osteomill::vibration
