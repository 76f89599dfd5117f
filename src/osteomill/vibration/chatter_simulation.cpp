// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/vibration/chatter_simulation.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/vibration/exponential.hpp"

namespace osteomill::vibration {
namespace {

/// The surface in front of each edge: where the pass before left it, along the radial direction.
class Surface {
 public:
  Surface(const RegenerativeSystem& system, double depth, double feed_per_tooth,
          const ChatterSimulationOptions& options)
      : cut_(system.cut()),
        options_(options),
        feed_per_tooth_(feed_per_tooth),
        slice_height_(depth / options.slices),
        left_(static_cast<std::size_t>(options.steps * cut_.flutes() * options.slices), 0.0) {}

  /// Force on the tool with the tip at d, phase `step` of the tooth period. `cut` leaves the
  /// surface.
  Eigen::Vector2d force(int step, const Eigen::Vector2d& d, bool cut) {
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    const double phase = cut_.pitch() * (step + 0.5) / options_.steps;
    std::size_t place =
        static_cast<std::size_t>(step) * static_cast<std::size_t>(cut_.flutes() * options_.slices);
    for (int edge = 0; edge < cut_.flutes(); ++edge) {
      for (int slice = 0; slice < options_.slices; ++slice, ++place) {
        const double turned =
            phase + edge * cut_.pitch() - cut_.lag() * slice_height_ * (slice + 0.5);
        const double turn = 2.0 * std::numbers::pi;
        const double theta = turned - turn * std::floor(turned / turn);
        if (theta < cut_.entry() || theta >= cut_.exit()) continue;
        const Eigen::Vector2d n(std::sin(theta), std::cos(theta));
        const Eigen::Vector2d t(-std::cos(theta), std::sin(theta));
        const double advance = feed_per_tooth_ * std::sin(theta);
        const double h = advance + n.dot(d) - left_[place];
        const bool in_contact = h > 0.0 || !options_.edges_may_leave;
        if (cut) {
          left_[place] = in_contact ? n.dot(d) : left_[place] - advance;
          largest_chip_ = std::max(largest_chip_, h);
        }
        if (!in_contact) continue;
        const EdgeForce f = edge_force(h, theta);
        sum += slice_height_ * (f.tangential * t - f.radial * n);
      }
    }
    return sum;
  }

  double take_largest_chip() { return std::exchange(largest_chip_, 0.0); }

 private:
  EdgeForce edge_force(double h, double theta) const {
    if (options_.law) return options_.law(h, theta);
    const EdgeStiffness k = cut_.edge(theta);
    return {k.tangential * h, k.radial * h};
  }

  const Regeneration& cut_;
  const ChatterSimulationOptions& options_;
  double feed_per_tooth_;
  double slice_height_;
  std::vector<double> left_;
  double largest_chip_ = 0.0;
};

}  // namespace

ChatterSimulation simulate_chatter(const RegenerativeSystem& system, double spindle_speed,
                                   double depth, double feed_per_tooth,
                                   const ChatterSimulationOptions& options) {
  require_positive("cut.spindle_speed_rpm", spindle_speed / units::rpm, "rpm");
  require_positive("cut.axial_depth_mm", depth / units::mm, "mm");
  require_positive("cut.feed_per_tooth_mm", feed_per_tooth / units::mm, "mm");
  require_within("options.steps", options.steps, 20.0, 100000.0, "");
  require_within("options.slices", options.slices, 1.0, 1000.0, "");
  require_within("options.most_periods", options.most_periods, 20.0, 1e6, "");

  ChatterSimulation result;
  const double period = system.tooth_period(spindle_speed);
  result.time_step = period / options.steps;
  const Eigen::MatrixXd z = system.free_motion() * result.time_step;
  const ExponentialFunctions<Eigen::MatrixXd> f = exponential_functions(z);
  const Eigen::MatrixXd b = result.time_step * system.input() * system.basis().transpose();
  const Eigen::MatrixXd late = f.phi_2 * b, early = (f.phi_1 - f.phi_2) * b;
  Eigen::MatrixXd tip = Eigen::MatrixXd::Zero(2, system.states());
  tip.leftCols(system.states() / 2) = system.basis() * system.shapes();

  Surface surface(system, depth, feed_per_tooth, options);
  Eigen::VectorXd state = Eigen::VectorXd::Zero(system.states());
  std::vector<Eigen::Vector2d> before(static_cast<std::size_t>(options.steps),
                                      Eigen::Vector2d::Zero());
  std::vector<double> deviation;  // rms of d(t) − d(t − T), one a tooth period
  for (int k = 0; k < options.most_periods; ++k) {
    double sum = 0.0;
    Eigen::Vector2d low = Eigen::Vector2d::Constant(1e300), high = -low;
    for (int i = 0; i < options.steps; ++i) {
      const Eigen::Vector2d d = tip * state;
      const Eigen::Vector2d force = surface.force(i, d, true);
      const Eigen::VectorXd base = f.phi_0 * state + early * force;
      const int next = (i + 1) % options.steps;
      const Eigen::Vector2d predicted = tip * (base + late * force);
      state = base + late * surface.force(next, predicted, false);
      sum += (d - before[static_cast<std::size_t>(i)]).squaredNorm();
      before[static_cast<std::size_t>(i)] = d;
      low = low.cwiseMin(d);
      high = high.cwiseMax(d);
      if (options.keep_motion) {
        result.x.push_back(d.x());
        result.y.push_back(d.y());
      }
    }
    if (!std::isfinite(sum)) throw NoSolution("the simulated vibration is not finite");
    result.largest_chip = surface.take_largest_chip();
    result.peak_to_peak_x = high.x() - low.x();
    result.peak_to_peak_y = high.y() - low.y();
    deviation.push_back(std::sqrt(sum / options.steps));
    result.periods = k + 1;
    // The first ten periods are the entry into the cut.
    if (k < 20) continue;
    const double grown = deviation.back() / deviation[10];
    if (grown > 1e4 || grown < 1e-4 || deviation.back() == 0.0) break;
  }
  // Growth over the second half: least squares of the logarithm would weigh the same periods. A
  // cut that has grown until edges leave the bone stands still at a large amplitude: it is unstable
  // as well, so the first half counts when it grew faster.
  const auto rate = [&](std::size_t from, std::size_t to) {
    return std::pow(std::max(deviation[to], 1e-300) / std::max(deviation[from], 1e-300),
                    1.0 / static_cast<double>(to - from));
  };
  const std::size_t last = deviation.size() - 1, middle = (10 + last) / 2;
  result.growth = rate(middle, last);
  const bool saturated =
      deviation[last] > 1e-2 * feed_per_tooth &&
      deviation[last] > 0.2 * *std::max_element(deviation.begin() + 10, deviation.end());
  if (saturated) result.growth = std::max(result.growth, rate(10, middle));
  result.unstable = result.growth > 1.0;
  return result;
}

}  // namespace osteomill::vibration
