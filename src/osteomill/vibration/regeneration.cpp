// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/vibration/regeneration.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"

namespace osteomill::vibration {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;

/// ∫₀^θ W dθ for constant coefficients.
Eigen::Matrix2d antiderivative(const EdgeStiffness& k, double theta) {
  const double sin_cos = 0.5 * std::sin(theta) * std::sin(theta);
  const double sin_sin = 0.5 * theta - 0.25 * std::sin(2.0 * theta);
  const double cos_cos = 0.5 * theta + 0.25 * std::sin(2.0 * theta);
  Eigen::Matrix2d w;
  w << -k.tangential * sin_cos - k.radial * sin_sin, -k.tangential * cos_cos - k.radial * sin_cos,
      k.tangential * sin_sin - k.radial * sin_cos, k.tangential * sin_cos - k.radial * cos_cos;
  return w;
}

Eigen::Matrix2d directional(const EdgeStiffness& k, double theta) {
  const Eigen::Vector2d n(std::sin(theta), std::cos(theta));
  const Eigen::Vector2d t(-std::cos(theta), std::sin(theta));
  return (k.tangential * t - k.radial * n) * n.transpose();
}

}  // namespace

Regeneration::Regeneration(int flutes, double entry, double exit, double lag,
                           EdgeStiffness stiffness)
    : Regeneration(flutes, entry, exit, lag, [&](double) { return stiffness; }, 1) {}

Regeneration::Regeneration(int flutes, double entry, double exit, double lag,
                           const std::function<EdgeStiffness(double theta)>& stiffness, int cells)
    : flutes_(flutes), entry_(entry), exit_(exit), lag_(lag) {
  require_within("cut.flutes", flutes, 1.0, 64.0, "");
  require_within("entry angle", entry / units::deg, 0.0, 360.0, "deg");
  require_within("exit angle", exit / units::deg, entry / units::deg, 360.0, "deg");
  require_positive("angle of the cut", (exit - entry) / units::deg, "deg");
  require_finite("helix lag", lag, "rad/m");
  const double width = (exit - entry) / cells;
  Eigen::Matrix2d sum = Eigen::Matrix2d::Zero();
  cumulative_.push_back(sum);
  for (int i = 0; i < cells; ++i) {
    const double low = entry + width * i;
    const EdgeStiffness k = stiffness(low + 0.5 * width);
    require_finite("slope of the tangential force", k.tangential, "N/m2");
    require_finite("slope of the radial force", k.radial, "N/m2");
    cells_.push_back(k);
    sum += antiderivative(k, low + width) - antiderivative(k, low);
    cumulative_.push_back(sum);
  }
}

double Regeneration::pitch() const { return kTurn / flutes_; }

EdgeStiffness Regeneration::edge(double theta) const {
  const double inside = theta - kTurn * std::floor(theta / kTurn);
  if (inside < entry_ || inside >= exit_) return {};
  const double place = (inside - entry_) / (exit_ - entry_) * static_cast<double>(cells_.size());
  return cells_[std::min(cells_.size() - 1, static_cast<std::size_t>(place))];
}

Eigen::Matrix2d Regeneration::integral(double theta) const {
  const double turns = std::floor(theta / kTurn);
  const double inside = std::clamp(theta - kTurn * turns, entry_, exit_);
  const double width = (exit_ - entry_) / static_cast<double>(cells_.size());
  const std::size_t cell =
      std::min(cells_.size() - 1, static_cast<std::size_t>((inside - entry_) / width));
  const double low = entry_ + width * static_cast<double>(cell);
  return turns * cumulative_.back() + cumulative_[cell] + antiderivative(cells_[cell], inside) -
         antiderivative(cells_[cell], low);
}

Eigen::Matrix2d Regeneration::integral_over_edges(double theta) const {
  Eigen::Matrix2d sum = Eigen::Matrix2d::Zero();
  for (int j = 0; j < flutes_; ++j) sum += integral(theta - j * pitch());
  return sum;
}

Eigen::Matrix2d Regeneration::at(double theta, double depth) const {
  if (has_helix()) {
    // ∫₀^a W(θ − lag z) dz by substitution.
    return (integral_over_edges(theta) - integral_over_edges(theta - lag_ * depth)) / lag_;
  }
  Eigen::Matrix2d sum = Eigen::Matrix2d::Zero();
  for (int j = 0; j < flutes_; ++j) {
    const double angle = theta - j * pitch();
    sum += directional(edge(angle), angle);
  }
  return depth * sum;
}

Eigen::Matrix2d Regeneration::mean(double theta_0, double theta_1, double depth) const {
  const double width = theta_1 - theta_0;
  if (!has_helix()) {
    return depth / width * (integral_over_edges(theta_1) - integral_over_edges(theta_0));
  }
  // The helix makes W continuous; four Gauss points leave only its kinks, of second order.
  constexpr std::array<double, 4> points = {0.06943184420297371, 0.33000947820757187,
                                            0.66999052179242813, 0.93056815579702629};
  constexpr std::array<double, 4> weights = {0.17392742256872693, 0.32607257743127307,
                                             0.32607257743127307, 0.17392742256872693};
  Eigen::Matrix2d sum = Eigen::Matrix2d::Zero();
  for (std::size_t q = 0; q < points.size(); ++q) {
    sum += weights[q] * at(theta_0 + points[q] * width, depth);
  }
  return sum;
}

Eigen::Matrix2cd Regeneration::harmonic(int r) const {
  // All N edges contribute alike to a harmonic of the pitch: N/2π ∫ W e^{−i r N θ} over the cut.
  // Midpoint rule, fine enough that a period of the highest harmonic has a hundred points.
  const double per_turn = 100.0 * std::max(20, std::abs(r) * flutes_);
  const int count = static_cast<int>(std::ceil(per_turn * (exit_ - entry_) / kTurn)) + 1;
  const double width = (exit_ - entry_) / count;
  Eigen::Matrix2cd sum = Eigen::Matrix2cd::Zero();
  for (int i = 0; i < count; ++i) {
    const double theta = entry_ + width * (i + 0.5);
    const Eigen::Matrix2d w =
        r == 0 ? Eigen::Matrix2d::Zero().eval() : directional(edge(theta), theta);
    sum += w * std::polar(width, -r * flutes_ * theta);
  }
  if (r == 0) sum = cumulative_.back().cast<std::complex<double>>();
  return sum * (flutes_ / kTurn);
}

std::complex<double> Regeneration::helix_factor(int r, double depth) const {
  const double angle = r * flutes_ * lag_ * depth;
  // Below 1e-8 the series' next term is beyond the last digit.
  if (std::abs(angle) < 1e-8) return {1.0, -0.5 * angle};
  return (1.0 - std::polar(1.0, -angle)) / std::complex<double>(0.0, angle);
}

std::vector<double> Regeneration::breaks(double depth) const {
  std::vector<double> angles;
  for (const double edge_angle : {entry_, exit_}) {
    for (const double lagged : {edge_angle, edge_angle + lag_ * depth}) {
      angles.push_back(lagged - pitch() * std::floor(lagged / pitch()));
    }
  }
  std::sort(angles.begin(), angles.end());
  std::vector<double> kept;
  for (const double angle : angles) {
    if (pitch() - angle < 1e-9) continue;  // the same as 0
    if (kept.empty() || angle - kept.back() > 1e-9) kept.push_back(angle);
  }
  return kept;
}

RegenerativeSystem::RegenerativeSystem(std::vector<Mode> modes, Regeneration cut,
                                       Receptance measured)
    : modes_(std::move(modes)), cut_(std::move(cut)), measured_(std::move(measured)) {
  check(modes_);
  const Mode& first = modes_.front();
  const bool one_line = std::all_of(modes_.begin(), modes_.end(), [&](const Mode& mode) {
    return std::abs(mode.direction_x * first.direction_y - mode.direction_y * first.direction_x) <
           1e-12;
  });
  if (one_line) {
    basis_ = Eigen::Vector2d(first.direction_x, first.direction_y);
  } else {
    basis_ = Eigen::Matrix2d::Identity();
  }
  const Eigen::Index n = static_cast<Eigen::Index>(modes_.size());
  shapes_.resize(basis_.cols(), n);
  input_ = Eigen::MatrixXd::Zero(2 * n, basis_.cols());
  free_motion_ = Eigen::MatrixXd::Zero(2 * n, 2 * n);
  for (const Mode& mode : modes_) {
    reference_omega_ = std::max(reference_omega_, kTurn * mode.frequency_hz);
  }
  for (Eigen::Index i = 0; i < n; ++i) {
    const Mode& mode = modes_[static_cast<std::size_t>(i)];
    shapes_.col(i) = basis_.transpose() * Eigen::Vector2d(mode.direction_x, mode.direction_y);
    const double omega = kTurn * mode.frequency_hz;
    free_motion_(i, n + i) = reference_omega_;
    free_motion_(n + i, i) = -omega * omega / reference_omega_;
    free_motion_(n + i, n + i) = -2.0 * mode.damping_ratio * omega;
    input_.row(n + i) = shapes_.col(i).transpose() / (mode.modal_mass * reference_omega_);
  }
}

TipReceptance RegenerativeSystem::receptance(double frequency_hz) const {
  if (!measured_) return tip_receptance(modes_, frequency_hz);
  const TipReceptance h = measured_(std::abs(frequency_hz));
  if (frequency_hz >= 0.0) return h;
  return {std::conj(h.xx), std::conj(h.xy), std::conj(h.yy)};
}

double RegenerativeSystem::highest_frequency_hz() const { return reference_omega_ / kTurn; }

}  // namespace osteomill::vibration
