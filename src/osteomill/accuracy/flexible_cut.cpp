// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/accuracy/flexible_cut.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "osteomill/base/error.hpp"
#include "osteomill/cutting/flutes.hpp"
#include "osteomill/vibration/linearised_cut.hpp"

namespace osteomill::accuracy {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;

class Balance {
 public:
  Balance(const ToolCompliance& tool, const cutting::Cutter& cutter, const cutting::CuttingLaw& law,
          const cutting::Condition& condition, const cutting::Immersion& immersion,
          const FlexibleOptions& options, int steps)
      : cutter_(cutter),
        law_(law),
        condition_(condition),
        slices_(options.slices),
        steps_(steps),
        dz_(immersion.axial_depth / options.slices),
        contact_(vibration::contact_angles(immersion.kind,
                                           0.5 * immersion.radial_depth / cutter.radius)),
        point_(cutting::Envelope(cutter).at(0.0)),
        compliance_(slices_, slices_),
        to_tip_(slices_),
        left_(Eigen::MatrixXd::Zero(slices_, steps)) {
    const cutting::Flutes flutes(cutter);
    const cutting::Envelope envelope(cutter);
    for (int s = 0; s < slices_; ++s) {
      const double z = (s + 0.5) * dz_;
      to_tip_[s] = tool.between(0.0, z);
      for (int m = 0; m < slices_; ++m) compliance_(s, m) = tool.between(z, (m + 0.5) * dz_);
      const cutting::ProfilePoint point = envelope.at(envelope.length_to(z));
      for (int j = 0; j < cutter.flutes; ++j) {
        lag_.push_back(
            static_cast<int>(std::lround((flutes.angle(j) + point.lag) / kTurn * steps)));
        radius_.push_back(flutes.deviation(j, point));
      }
    }
  }

  /// Solves d = C F(d) at one step from the guess d (x of all slices, then y).
  bool solve(int step, Eigen::VectorXd& d) const {
    const Eigen::Index n = slices_;
    Eigen::VectorXd force(2 * n);
    Eigen::MatrixXd slope(2 * n, 2);  // ∂F_s/∂d_s: rows x of all slices, then y
    const auto residual = [&](const Eigen::VectorXd& at) {
      forces(step, at, force, slope);
      Eigen::VectorXd r = at;
      r.head(n) -= compliance_ * force.head(n);
      r.tail(n) -= compliance_ * force.tail(n);
      return r;
    };
    // A nanometre: a thousandth of the thinnest chips in use.
    constexpr double enough = 1e-9;
    Eigen::VectorXd r = residual(d);
    for (int i = 0; i < 60; ++i) {
      if (r.lpNorm<Eigen::Infinity>() < enough) return true;
      Eigen::MatrixXd jacobian = Eigen::MatrixXd::Identity(2 * n, 2 * n);
      for (Eigen::Index s = 0; s < n; ++s) {
        for (Eigen::Index k = 0; k < 2; ++k) {
          jacobian.block(0, k * n + s, n, 1) -= compliance_.col(s) * slope(s, k);
          jacobian.block(n, k * n + s, n, 1) -= compliance_.col(s) * slope(n + s, k);
        }
      }
      const Eigen::VectorXd change = jacobian.partialPivLu().solve(r);
      double share = 1.0;
      Eigen::VectorXd trial = d - change, r_trial = residual(trial);
      while (r_trial.norm() >= r.norm() && share > 1e-3) {
        share *= 0.5;
        trial = d - share * change;
        r_trial = residual(trial);
      }
      d = trial;
      r = r_trial;
    }
    return r.lpNorm<Eigen::Infinity>() < 1e3 * enough;
  }

  /// Leaves the surface of this step and returns the force in x and y.
  Eigen::Vector2d pass(int step, const Eigen::VectorXd& d, std::vector<double>& wall,
                       int wall_bin) {
    Eigen::VectorXd force(2 * slices_);
    Eigen::MatrixXd slope(2 * slices_, 2);
    forces(step, d, force, slope);
    for_each_edge(step, d,
                  [&](int s, int, int bin, double h, double place, double advance, auto&&...) {
                    left_(s, bin) = h > 0.0 ? place : left_(s, bin) - advance;
                    if (bin == wall_bin) {
                      auto& deepest = wall[static_cast<std::size_t>(s)];
                      deepest = std::max(deepest, left_(s, bin));
                    }
                  });
    return {force.head(slices_).sum(), force.tail(slices_).sum()};
  }

  Eigen::Vector2d tip(const Eigen::VectorXd& d, int step) const {
    Eigen::VectorXd force(2 * slices_);
    Eigen::MatrixXd slope(2 * slices_, 2);
    forces(step, d, force, slope);
    return {to_tip_.dot(force.head(slices_)), to_tip_.dot(force.tail(slices_))};
  }

  /// The bin of the last step inside the contact before the finished wall, or the first behind it.
  int wall_bin(bool at_entry) const {
    const double edge = (at_entry ? contact_.entry : contact_.exit) / kTurn * steps_;
    return at_entry ? static_cast<int>(std::ceil(edge - 0.5 + 1e-9))
                    : static_cast<int>(std::floor(edge - 0.5 - 1e-9));
  }

 private:
  template <class Visit>
  void for_each_edge(int step, const Eigen::VectorXd& d, Visit visit) const {
    for (int s = 0; s < slices_; ++s) {
      for (int j = 0; j < cutter_.flutes; ++j) {
        const auto edge = static_cast<std::size_t>(s * cutter_.flutes + j);
        const int turned = step - lag_[edge];
        const int bin = ((turned % steps_) + steps_) % steps_;
        const double theta = kTurn * (bin + 0.5) / steps_;
        if (theta < contact_.entry || theta > contact_.exit) continue;
        const double sine = std::sin(theta), cosine = std::cos(theta);
        const double place = radius_[edge] + sine * d[s] + cosine * d[slices_ + s];
        const double advance = condition_.feed_per_tooth * std::max(0.0, sine);
        visit(s, j, bin, advance + place - left_(s, bin), place, advance, theta, sine, cosine);
      }
    }
  }

  void forces(int step, const Eigen::VectorXd& d, Eigen::VectorXd& force,
              Eigen::MatrixXd& slope) const {
    force.setZero();
    slope.setZero();
    for_each_edge(
        step, d,
        [&](int s, int, int, double h, double, double, double theta, double sine, double cosine) {
          if (h <= 0.0) return;
          const geometry::Vector3 t = cutting::motion(theta);
          const geometry::Vector3 n = cutting::outward_normal(theta, point_.kappa);
          const auto at = [&](double chip) {
            return cutting::edge_force(law_, chip, condition_.fibre_T, t, n, point_);
          };
          const double small = 1e-4 * h;
          const geometry::Vector3 f = dz_ * at(h);
          const geometry::Vector3 df = dz_ / (2.0 * small) * (at(h + small) - at(h - small));
          force[s] += f.x();
          force[slices_ + s] += f.y();
          slope(s, 0) += df.x() * sine;
          slope(s, 1) += df.x() * cosine;
          slope(slices_ + s, 0) += df.y() * sine;
          slope(slices_ + s, 1) += df.y() * cosine;
        });
  }

  const cutting::Cutter& cutter_;
  const cutting::CuttingLaw& law_;
  const cutting::Condition& condition_;
  int slices_, steps_;
  double dz_;
  vibration::ContactAngles contact_;
  cutting::ProfilePoint point_;
  Eigen::MatrixXd compliance_;
  Eigen::VectorXd to_tip_;
  std::vector<int> lag_;        ///< steps by which an edge (slice, flute) lags behind flute 0's tip
  std::vector<double> radius_;  ///< of an edge over the nominal one, m
  /// Where the pass before left the surface at a slice and angle, outward of its nominal edge, m.
  Eigen::MatrixXd left_;
};

}  // namespace

FlexibleCut flexible_cut(const ToolCompliance& tool, const cutting::Cutter& cutter,
                         const cutting::CuttingLaw& law, const cutting::Condition& condition,
                         const cutting::Immersion& immersion, const FlexibleOptions& options) {
  check(cutter);
  check(condition, cutter);
  check(immersion, cutter);
  check(law);
  require_within("options.slices", options.slices, 1.0, 200.0, "");
  require_within("options.steps", options.steps, 12.0, 3600.0, "");
  if (cutter.shape != cutting::CutterShape::cylindrical) {
    throw InvalidInput(Fault{"cutter.shape", "not cylindrical",
                             "the flexible model is worked out for cylindrical cutters",
                             "use shape = \"cylindrical\""});
  }
  const int steps = (options.steps + cutter.flutes - 1) / cutter.flutes * cutter.flutes;
  Balance balance(tool, cutter, law, condition, immersion, options, steps);
  const int wall_bin = balance.wall_bin(immersion.kind == cutting::ImmersionKind::up);

  FlexibleCut result;
  Eigen::VectorXd d = Eigen::VectorXd::Zero(2 * options.slices);
  std::vector<double> tip_before;
  for (int turn = 1; turn <= options.most_revolutions && !result.repeats; ++turn) {
    result = {};
    result.revolutions = turn;
    std::vector<double> wall(static_cast<std::size_t>(options.slices), -1e300);
    for (int i = 0; i < steps; ++i) {
      if (!balance.solve(i, d)) ++result.unsolved_steps;
      const Eigen::Vector2d tip = balance.tip(d, i);
      const Eigen::Vector2d force = balance.pass(i, d, wall, wall_bin);
      result.angle.push_back(kTurn * (i + 0.5) / steps);
      result.force_x.push_back(force.x());
      result.force_y.push_back(force.y());
      result.tip_x.push_back(tip.x());
      result.tip_y.push_back(tip.y());
      result.peak_force = std::max(result.peak_force, force.norm());
    }
    const auto [low, high] = std::minmax_element(result.tip_y.begin(), result.tip_y.end());
    result.total_tip = *high - *low;
    for (int s = 0; s < options.slices; ++s) {
      result.surface.axial_position.push_back((s + 0.5) * immersion.axial_depth / options.slices);
      result.surface.error.push_back(-wall[static_cast<std::size_t>(s)]);
    }
    if (!tip_before.empty()) {
      double change = 0.0;
      for (std::size_t i = 0; i < tip_before.size(); ++i) {
        change = std::max(change, std::abs(result.tip_y[i] - tip_before[i]));
      }
      result.repeats = change <= options.tolerance * result.total_tip + 1e-12;
    }
    tip_before = result.tip_y;
  }
  return result;
}

}  // namespace osteomill::accuracy
