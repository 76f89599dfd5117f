// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/vibration/frequency_domain.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"

namespace osteomill::vibration {
namespace {

using Complex = std::complex<double>;
constexpr double kTurn = 2.0 * std::numbers::pi;
constexpr double kNone = std::numeric_limits<double>::infinity();

double lowest_mode(const RegenerativeSystem& system) {
  double lowest = kNone;
  for (const Mode& mode : system.modes()) lowest = std::min(lowest, mode.frequency_hz);
  return lowest;
}

}  // namespace

ZeroOrder::ZeroOrder(Receptance receptance, const Regeneration& cut, double lowest_hz,
                     double highest_hz, int points)
    : receptance_(std::move(receptance)), mean_(cut.harmonic(0).real()), pitch_(cut.pitch()) {
  require_positive("lowest chatter frequency", lowest_hz, "Hz");
  require_positive("range of chatter frequencies", highest_hz - lowest_hz, "Hz");
  require_within("options.points", points, 10.0, 1e7, "");
  for (int i = 0; i < points; ++i) {
    frequencies_.push_back(lowest_hz *
                           std::pow(highest_hz / lowest_hz, static_cast<double>(i) / (points - 1)));
  }
}

ZeroOrder::ZeroOrder(const RegenerativeSystem& system, int points)
    : ZeroOrder([system](double f) { return system.receptance(f); }, system.cut(),
                0.2 * lowest_mode(system), 3.0 * system.highest_frequency_hz(), points) {}

std::vector<ZeroOrder::Branch> ZeroOrder::branches(double frequency_hz) const {
  const TipReceptance h = receptance_(frequency_hz);
  Eigen::Matrix2cd phi;
  phi << h.xx, h.xy, h.xy, h.yy;
  const Eigen::Matrix2cd m = phi * mean_.cast<Complex>();
  const Complex half_trace = 0.5 * m.trace();
  const Complex root = std::sqrt(half_trace * half_trace - m.determinant());
  std::vector<Branch> result;
  for (const Complex eigenvalue : {half_trace + root, half_trace - root}) {
    // 1/λ = a (1 − cos ωT + i sin ωT): its real part is positive, its argument π/2 − ωT/2.
    const Complex needed = 1.0 / eigenvalue;
    if (!(needed.real() > 0.0) || !std::isfinite(std::abs(needed))) {
      result.push_back({kNone, 0.0});
      continue;
    }
    result.push_back({std::norm(needed) / (2.0 * needed.real()),
                      2.0 * std::atan2(needed.real(), needed.imag())});
  }
  return result;
}

FrequencyDomainLimit ZeroOrder::absolute_minimum() const {
  FrequencyDomainLimit best{.depth = kNone};
  std::size_t at = 0;
  const auto least = [&](double f) {
    double depth = kNone;
    for (const Branch& branch : branches(f)) depth = std::min(depth, branch.depth);
    return depth;
  };
  for (std::size_t i = 0; i < frequencies_.size(); ++i) {
    const double depth = least(frequencies_[i]);
    if (depth < best.depth) {
      best = {depth, frequencies_[i], false};
      at = i;
    }
  }
  if (best.depth == kNone) return best;
  // Golden section between the neighbours of the best sample.
  double low = frequencies_[at > 0 ? at - 1 : 0];
  double high = frequencies_[std::min(at + 1, frequencies_.size() - 1)];
  const double ratio = 0.5 * (std::sqrt(5.0) - 1.0);
  while (high - low > 1e-9 * high) {
    const double a = high - ratio * (high - low), b = low + ratio * (high - low);
    (least(a) < least(b) ? high : low) = least(a) < least(b) ? b : a;
  }
  best.chatter_frequency_hz = 0.5 * (low + high);
  best.depth = least(best.chatter_frequency_hz);
  return best;
}

FrequencyDomainLimit ZeroOrder::limit(double spindle_speed) const {
  require_positive("cut.spindle_speed_rpm", spindle_speed / units::rpm, "rpm");
  const double period = pitch_ / spindle_speed;
  FrequencyDomainLimit best{.depth = kNone};
  // ωT − phase(ω) must be a whole number of turns: look for it passing one.
  const auto miss = [&](double f, std::size_t branch, double& depth) {
    const Branch b = branches(f)[branch];
    depth = b.depth;
    return b.depth == kNone ? kNone : (kTurn * f * period - b.phase) / kTurn;
  };
  for (std::size_t branch = 0; branch < 2; ++branch) {
    double depth_0 = kNone;
    double turns_0 = miss(frequencies_.front(), branch, depth_0);
    for (std::size_t i = 1; i < frequencies_.size(); ++i) {
      double depth_1 = kNone;
      const double turns_1 = miss(frequencies_[i], branch, depth_1);
      if (turns_0 != kNone && turns_1 != kNone && std::min(depth_0, depth_1) < best.depth) {
        const double whole = std::floor(std::max(turns_0, turns_1));
        if (std::min(turns_0, turns_1) <= whole && std::abs(turns_1 - turns_0) < 0.5) {
          double low = frequencies_[i - 1], high = frequencies_[i], depth = kNone;
          const bool rising = turns_1 > turns_0;
          while (high - low > 1e-12 * high) {
            const double middle = 0.5 * (low + high);
            if (middle <= low || middle >= high) break;
            const double turns = miss(middle, branch, depth);
            ((turns < whole) == rising ? low : high) = middle;
          }
          if (depth < best.depth) best = {depth, 0.5 * (low + high), false};
        }
      }
      turns_0 = turns_1;
      depth_0 = depth_1;
    }
  }
  return best;
}

namespace {

/// Frequency of the highest mode whose peak 1/(2ζk) is a twentieth of the largest at least: a
/// stiffer one cannot chatter before the depth is twenty times that of the other.
double highest_lively_mode(const RegenerativeSystem& system) {
  const auto peak = [](const Mode& m) { return 1.0 / (m.damping_ratio * modal_stiffness(m)); };
  double largest = 0.0, highest = 0.0;
  for (const Mode& mode : system.modes()) largest = std::max(largest, peak(mode));
  for (const Mode& mode : system.modes()) {
    if (peak(mode) >= 0.05 * largest) highest = std::max(highest, mode.frequency_hz);
  }
  return highest;
}

/// Hill's determinant at one spindle speed, the directional harmonics as they are at one depth.
class Hill {
 public:
  Hill(const RegenerativeSystem& system, double spindle_speed, int harmonics)
      : system_(system), period_(system.tooth_period(spindle_speed)), tooth_hz_(1.0 / period_) {
    // Lines f + r/T, r = −half … half − 1, with f in (0, 1/2T]: they reach beyond every mode that
    // may chatter on both sides of zero, and at f = 1/2T the set is its own mirror image, as flip
    // chatter needs.
    half_ = static_cast<int>(std::ceil(highest_lively_mode(system) * period_)) + harmonics;
    for (int r = 1 - lines(); r <= lines() - 1; ++r) {
      straight_.push_back(reduced(system.cut().harmonic(r)));
    }
    directional_ = straight_;
  }

  void freeze_at(double depth) {
    for (int r = 1 - lines(); r <= lines() - 1; ++r) {
      const auto k = static_cast<std::size_t>(r + lines() - 1);
      directional_[k] = system_.cut().helix_factor(r, depth) * straight_[k];
    }
  }

  /// The smallest limit depth up to max_depth.
  FrequencyDomainLimit limit(double max_depth) const;
  /// The strongest line of the motion at a limit: the frequency that is heard.
  double strongest_line(const FrequencyDomainLimit& limit) const;

 private:
  int lines() const { return 2 * half_; }

  Eigen::MatrixXcd reduced(const Eigen::Matrix2cd& full) const {
    return system_.basis().transpose().cast<Complex>() * full * system_.basis().cast<Complex>();
  }

  /// Φ(ω + r ω_T) W_{r−s}: its eigenvalues times 1 − e^{−iωT} are the gains; the limit depth is
  /// 1/gain where a gain is real and positive.
  Eigen::MatrixXcd matrix(double f) const {
    const Eigen::Index o = system_.outputs();
    Eigen::MatrixXcd m(lines() * o, lines() * o);
    for (int r = 0; r < lines(); ++r) {
      const TipReceptance h = system_.receptance(f + (r - half_) * tooth_hz_);
      Eigen::Matrix2cd phi;
      phi << h.xx, h.xy, h.xy, h.yy;
      const Eigen::MatrixXcd here = reduced(phi);
      for (int s = 0; s < lines(); ++s) {
        m.block(r * o, s * o, o, o) =
            here * directional_[static_cast<std::size_t>(r - s + lines() - 1)];
      }
    }
    return m;
  }

  Complex regeneration(double f) const { return 1.0 - std::polar(1.0, -kTurn * f * period_); }

  std::vector<Complex> gains(double f) const {
    const Eigen::ComplexEigenSolver<Eigen::MatrixXcd> solver(matrix(f), false);
    std::vector<Complex> list;
    for (const Complex& value : solver.eigenvalues()) list.push_back(value * regeneration(f));
    return list;
  }

  /// Where a gain's imaginary part passes zero between two frequencies: bisection along the nearest
  /// eigenvalue. No depth when it was a jump to another one.
  FrequencyDomainLimit crossing(double low, Complex g_low, double high, Complex g_high) const;

  const RegenerativeSystem& system_;
  double period_, tooth_hz_;
  int half_ = 0;
  std::vector<Eigen::MatrixXcd> straight_, directional_;  ///< W_r, r = −(lines − 1) … lines − 1
};

FrequencyDomainLimit Hill::crossing(double low, Complex g_low, double high, Complex g_high) const {
  for (int step = 0; step < 40; ++step) {
    const double middle = 0.5 * (low + high);
    const Complex guess = 0.5 * (g_low + g_high);
    Complex g = 0.0;
    double miss = kNone;
    for (const Complex& value : gains(middle)) {
      if (std::abs(value - guess) < miss) {
        miss = std::abs(value - guess);
        g = value;
      }
    }
    const bool same_side = (g.imag() > 0.0) == (g_low.imag() > 0.0);
    (same_side ? low : high) = middle;
    (same_side ? g_low : g_high) = g;
    if (std::abs(g_high - g_low) < 1e-10 * std::abs(g_low)) break;
  }
  if (std::abs(g_high - g_low) > 1e-3 * std::abs(g_low)) return {.depth = kNone};
  return {1.0 / g_low.real(), low, false};
}

FrequencyDomainLimit Hill::limit(double max_depth) const {
  FrequencyDomainLimit best{.depth = kNone};
  const auto offer = [&](const FrequencyDomainLimit& one) {
    if (one.depth > 0.0 && one.depth < best.depth && one.depth <= max_depth) best = one;
  };
  for (const Complex& gain : gains(0.5 * tooth_hz_)) {
    if (gain.real() > 0.0 && std::abs(gain.imag()) < 1e-8 * gain.real()) {
      offer({1.0 / gain.real(), 0.5 * tooth_hz_, true});
    }
  }
  const int samples = 200;
  const auto frequency = [&](int i) {  // the open interval (0, 1/2T)
    return 0.5 * tooth_hz_ * (1e-6 + (1.0 - 2e-6) * i / samples);
  };
  std::vector<Complex> before = gains(frequency(0));
  double f_before = frequency(0);
  for (int i = 1; i <= samples; ++i) {
    const double f = frequency(i);
    const std::vector<Complex> now = gains(f);
    std::vector<bool> taken(now.size(), false);
    for (const Complex& old : before) {
      std::size_t match = 0;
      double distance = kNone;
      for (std::size_t k = 0; k < now.size(); ++k) {
        if (!taken[k] && std::abs(now[k] - old) < distance) {
          distance = std::abs(now[k] - old);
          match = k;
        }
      }
      taken[match] = true;
      const Complex next = now[match];
      if (old.imag() * next.imag() > 0.0 || std::max(old.real(), next.real()) <= 0.0) continue;
      if (1.0 / std::max(old.real(), next.real()) > 1.05 * best.depth) continue;
      offer(crossing(f_before, old, f, next));
    }
    before = now;
    f_before = f;
  }
  return best;
}

double Hill::strongest_line(const FrequencyDomainLimit& limit) const {
  const Eigen::Index o = system_.outputs();
  const double f = limit.chatter_frequency_hz;
  const Eigen::ComplexEigenSolver<Eigen::MatrixXcd> solver(matrix(f), true);
  Eigen::Index nearest = 0, strongest = 0;
  (solver.eigenvalues().array() * regeneration(f) - 1.0 / limit.depth).abs().minCoeff(&nearest);
  const Eigen::VectorXcd motion = solver.eigenvectors().col(nearest);
  double size = -1.0;
  for (int r = 0; r < lines(); ++r) {
    if (motion.segment(r * o, o).norm() > size) {
      size = motion.segment(r * o, o).norm();
      strongest = r;
    }
  }
  return std::abs(f + static_cast<double>(strongest - half_) * tooth_hz_);
}

/// The smallest depth a that is the limit L(a) of the harmonics frozen at a.
FrequencyDomainLimit helical_limit(const RegenerativeSystem& system, Hill& hill, double max_depth) {
  const auto frozen = [&](double depth) {
    hill.freeze_at(depth);
    // Up to ten times the range: how far away the limit is tells how far to step.
    return hill.limit(10.0 * max_depth);
  };
  // The harmonics change over the helix' pitch: sixteen steps of it at least.
  const double pitch_height = system.cut().pitch() / std::abs(system.cut().lag());
  double low = 0.0;
  FrequencyDomainLimit at_low = frozen(0.0);
  while (low < max_depth) {
    const double room = std::min(at_low.depth, 10.0 * max_depth) - low;
    const double step = std::min(std::max(0.5 * room, 0.02 * max_depth), pitch_height / 16.0);
    double high = std::min(max_depth, low + step);
    FrequencyDomainLimit at_high = frozen(high);
    if (at_high.depth > high) {
      low = high;
      at_low = at_high;
      continue;
    }
    // Regula falsi with the Illinois step on the room L(a) − a.
    double f_low = std::min(at_low.depth, 10.0 * max_depth) - low, f_high = at_high.depth - high;
    for (int side = 0, i = 0; i < 60 && high - low > 1e-6 * high; ++i) {
      double middle = (low * f_high - high * f_low) / (f_high - f_low);
      if (!(middle > low && middle < high)) middle = 0.5 * (low + high);
      const FrequencyDomainLimit at_middle = frozen(middle);
      const double f = std::min(at_middle.depth, 10.0 * max_depth) - middle;
      if (f > 0.0) {
        low = middle;
        f_low = f;
        if (side == -1) f_high *= 0.5;
        side = -1;
      } else {
        high = middle;
        f_high = f;
        at_high = at_middle;
        if (side == 1) f_low *= 0.5;
        side = 1;
      }
      if (std::abs(f) < 1e-7 * high) {
        high = middle;
        at_high = at_middle;
        break;
      }
    }
    hill.freeze_at(high);
    at_high.depth = high;
    return at_high;
  }
  return {.depth = kNone};
}

}  // namespace

FrequencyDomainLimit multi_frequency_limit(const RegenerativeSystem& system, double spindle_speed,
                                           int harmonics, double max_depth) {
  require_positive("cut.spindle_speed_rpm", spindle_speed / units::rpm, "rpm");
  require_within("options.harmonics", harmonics, 0.0, 40.0, "");
  require_positive("options.max_depth_mm", max_depth / units::mm, "mm");
  Hill hill(system, spindle_speed, harmonics);
  FrequencyDomainLimit best =
      system.cut().has_helix() ? helical_limit(system, hill, max_depth) : hill.limit(max_depth);
  if (best.depth < kNone) best.chatter_frequency_hz = hill.strongest_line(best);
  return best;
}

}  // namespace osteomill::vibration
