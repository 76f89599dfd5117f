// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/robot/planar_chain.hpp"

#include <fmt/format.h>

#include <cmath>
#include <functional>
#include <nlopt.hpp>

#include "osteomill/base/error.hpp"
#include "osteomill/base/random.hpp"
#include "osteomill/base/units.hpp"

namespace osteomill::robot {
namespace {

// Two gaps that differ by less are the same gap: the tenth of a micrometre of the placement.
constexpr double kSameGap = 1e-7;
// A joint may stand so far outside of its range, and the guide so far off the line, by rounding.
constexpr double kRounding = 1e-8;

Vector2 heading_vector(double angle) { return {-std::sin(angle), std::cos(angle)}; }
Vector2 turned(const Vector2& v) { return {-v.y(), v.x()}; }

double middle(const JointRange& range) { return 0.5 * (range.low + range.high); }
double half(const JointRange& range) { return 0.5 * (range.high - range.low); }

/// The copy of an angle (mod 2π) nearest to the middle of the range.
double into(const JointRange& range, double angle) {
  const double turn = 2.0 * std::numbers::pi;
  return angle - turn * std::round((angle - middle(range)) / turn);
}

/// One cut for one chain, in joints scaled to -1...1 over their ranges.
class Problem {
 public:
  Problem(const PlanarChain& chain, const Vector2& axis_position, const CutLine& line,
          Branch branch, const ChainOptions& options)
      : chain_(chain),
        axis_position_(axis_position),
        line_(line),
        sign_(branch == Branch::outermost ? -1.0 : 1.0),
        branch_(branch),
        options_(options),
        wanted_(std::atan2(-line.direction.x(), line.direction.y())) {}

  std::size_t size() const { return chain_.axes.size(); }

  Eigen::VectorXd joints(const std::vector<double>& u) const {
    Eigen::VectorXd q(static_cast<Eigen::Index>(size()));
    for (std::size_t i = 0; i < size(); ++i) {
      const JointRange& range = chain_.axes[i].range;
      q(static_cast<Eigen::Index>(i)) = middle(range) + half(range) * u[i];
    }
    return q;
  }

  std::vector<double> scaled(const Eigen::VectorXd& q) const {
    std::vector<double> u(size());
    for (std::size_t i = 0; i < size(); ++i) {
      const JointRange& range = chain_.axes[i].range;
      u[i] = (q(static_cast<Eigen::Index>(i)) - middle(range)) / half(range);
    }
    return u;
  }

  /// Closed form of the first two joints where the others are given.
  std::optional<Eigen::VectorXd> closed_form(Eigen::VectorXd q) const {
    q(0) = q(1) = 0.0;
    const ChainPose folded = forward(chain_, Vector2::Zero(), q);
    // Behind A2, in the frame whose y axis is A2's link.
    const Vector2 behind = folded.tip() - folded.points[1];
    const double turn = wanted_ - folded.heading;
    const Vector2 across = std::cos(turn) * behind + std::sin(turn) * turned(behind);
    const GuidePositioner two{.link1 = chain_.axes[0].length, .link2 = 0.0};
    const auto solution =
        inverse(two, axis_position_, {line_.entry - across, line_.direction, 0.0}, branch_);
    if (!solution) return std::nullopt;
    q(0) = into(chain_.axes[0].range, solution->theta1);
    q(1) = into(chain_.axes[1].range, solution->theta2 - folded.heading);
    return q;
  }

  double gap(const Eigen::VectorXd& q) const {
    return (line_.entry - forward(chain_, axis_position_, q).tip()).dot(line_.direction);
  }

  double normal_compliance(const Eigen::VectorXd& q) const {
    const Eigen::RowVectorXd across =
        turned(line_.direction).transpose() * chain_jacobian(chain_, q).bottomRows<2>();
    double sum = 0.0;
    for (std::size_t i = 0; i < size(); ++i) {
      const double lever = across(static_cast<Eigen::Index>(i));
      if (chain_.axes[i].stiffness > 0.0) sum += lever * lever / chain_.axes[i].stiffness;
    }
    return sum;
  }

  double criterion(const Eigen::VectorXd& q) const {
    if (options_.redundancy == Redundancy::stiffest) return normal_compliance(q);
    double sum = 0.0;
    for (std::size_t i = 0; i < size(); ++i) {
      const auto k = static_cast<Eigen::Index>(i);
      const JointRange& range = chain_.axes[i].range;
      const double from = options_.redundancy == Redundancy::smallest_displacement
                              ? options_.from(k)
                              : middle(range);
      sum += std::pow((q(k) - from) / half(range), 2);
    }
    return sum;
  }

  /// Off the wanted heading (rad) and off the line (m).
  Vector2 off(const Eigen::VectorXd& q) const {
    const ChainPose pose = forward(chain_, axis_position_, q);
    return {wrapped(pose.heading - wanted_),
            (pose.tip() - line_.entry).dot(turned(line_.direction))};
  }

  bool allowed(const Eigen::VectorXd& q) const {
    for (std::size_t i = 0; i < size(); ++i) {
      const double at = q(static_cast<Eigen::Index>(i));
      const JointRange& range = chain_.axes[i].range;
      if (at < range.low - kRounding || at > range.high + kRounding) return false;
    }
    return off(q).cwiseAbs().maxCoeff() <= kRounding && gap(q) >= -kSameGap &&
           branch_side(q) >= -kRounding;
  }

  /// Of A2 along the line from the foot of the perpendicular, positive on the branch asked for.
  double branch_side(const Eigen::VectorXd& q) const {
    return sign_ * chain_.axes[0].length * heading_vector(q(0)).dot(line_.direction);
  }

  /// Minimises what is given; on success u holds joints that are allowed.
  bool improve(std::vector<double>& u, const std::function<double(const Eigen::VectorXd&)>& what,
               std::optional<double> largest_gap) const {
    nlopt::opt optimiser(nlopt::LD_SLSQP, static_cast<unsigned>(size()));
    optimiser.set_lower_bounds(-1.0);
    optimiser.set_upper_bounds(1.0);
    optimiser.set_xtol_abs(1e-11);
    optimiser.set_maxeval(200);
    // Lengths are scaled by the first link, so that a metre and a radian weigh alike.
    const double length = chain_.axes[0].length;
    std::vector<Function> functions = {
        {this, what},
        {this, [this](const Eigen::VectorXd& q) { return off(q).x(); }},
        {this, [this, length](const Eigen::VectorXd& q) { return off(q).y() / length; }},
        {this, [this, length](const Eigen::VectorXd& q) { return -gap(q) / length; }},
        {this, [this, length](const Eigen::VectorXd& q) { return -branch_side(q) / length; }},
        {this, [this, length, largest_gap](const Eigen::VectorXd& q) {
           return (gap(q) - largest_gap.value_or(0.0)) / length;
         }}};
    optimiser.set_min_objective(value_of, &functions[0]);
    optimiser.add_equality_constraint(value_of, &functions[1], 1e-11);
    optimiser.add_equality_constraint(value_of, &functions[2], 1e-11);
    optimiser.add_inequality_constraint(value_of, &functions[3], 1e-11);
    optimiser.add_inequality_constraint(value_of, &functions[4], 1e-11);
    if (largest_gap) optimiser.add_inequality_constraint(value_of, &functions[5], 1e-11);
    double value = 0.0;
    std::vector<double> at = u;
    for (double& x : at) x = std::clamp(x, -1.0, 1.0);
    try {
      optimiser.optimize(at, value);
    } catch (const nlopt::roundoff_limited&) {
      // NLopt leaves its best point; whether it is allowed is looked at below.
    } catch (const std::runtime_error&) {
      return false;
    }
    if (!allowed(joints(at))) return false;
    u = at;
    return true;
  }

 private:
  struct Function {
    const Problem* problem;
    std::function<double(const Eigen::VectorXd&)> value;
  };

  static double value_of(const std::vector<double>& u, std::vector<double>& gradient, void* data) {
    const Function& f = *static_cast<Function*>(data);
    // Cube root of the arithmetic's precision balances truncation and rounding.
    constexpr double h = 6e-6;
    std::vector<double> moved = u;
    for (std::size_t i = 0; i < gradient.size(); ++i) {
      moved[i] = u[i] + h;
      const double above = f.value(f.problem->joints(moved));
      moved[i] = u[i] - h;
      gradient[i] = (above - f.value(f.problem->joints(moved))) / (2.0 * h);
      moved[i] = u[i];
    }
    return f.value(f.problem->joints(u));
  }

  const PlanarChain& chain_;
  Vector2 axis_position_;
  CutLine line_;
  double sign_;
  Branch branch_;
  const ChainOptions& options_;
  double wanted_;
};

/// Values of the further joints, scaled: the middle, thirds of every axis, and seeded others.
std::vector<std::vector<double>> starts(std::size_t further) {
  std::vector<std::vector<double>> all{std::vector<double>(further, 0.0)};
  for (std::size_t i = 0; i < further; ++i) {
    for (const double at : {-0.98, -0.4, 0.4, 0.98}) {
      all.push_back(all.front());
      all.back()[i] = at;
    }
  }
  Random random(1);
  for (int k = 0; k < 12 && further > 1; ++k) {
    all.emplace_back(further);
    for (double& at : all.back()) at = random.uniform(-1.0, 1.0);
  }
  return all;
}

bool better(const ChainSolution& a, const ChainSolution& b) {
  if (!b.found || !a.found) return a.found;
  if (std::abs(a.gap - b.gap) > kSameGap) return a.gap < b.gap;
  return a.criterion < b.criterion;
}

}  // namespace

PlanarChain chain_of(const GuidePositioner& robot, const std::vector<PlanarAxis>& further) {
  PlanarChain chain{{{.length = robot.link1, .range = robot.range1},
                     {.length = robot.link2, .range = robot.range2}}};
  chain.axes.insert(chain.axes.end(), further.begin(), further.end());
  if (robot.slide_stroke > 0.0) {
    chain.axes.push_back({.kind = AxisKind::prismatic, .range = {0.0, robot.slide_stroke}});
  }
  return chain;
}

void check(const PlanarChain& chain) {
  std::vector<Fault> faults;
  const auto fault = [&](std::size_t i, const char* key, double value, const char* rule) {
    faults.push_back(
        Fault{fmt::format("axis {}, {}", i + 1, key), fmt::format("{:g}", value), rule, ""});
  };
  if (chain.axes.size() < 2 || chain.axes[0].kind != AxisKind::revolute ||
      chain.axes[1].kind != AxisKind::revolute) {
    faults.push_back(Fault{"axes", fmt::format("{}", chain.axes.size()),
                           "must begin with two revolute axes", ""});
  }
  for (std::size_t i = 0; i < chain.axes.size(); ++i) {
    const PlanarAxis& axis = chain.axes[i];
    const double least = i == 0 ? std::numeric_limits<double>::min() : 0.0;
    if (!(axis.length >= least && axis.length <= 10.0)) {
      fault(i, "length_mm", axis.length / units::mm,
            i == 0 ? "must be > 0 and at most 10000 mm" : "must be 0 ... 10000 mm");
    }
    if (!std::isfinite(axis.direction)) fault(i, "direction_deg", axis.direction, "must be finite");
    if (!(axis.range.low < axis.range.high) || !std::isfinite(half(axis.range))) {
      fault(i, "range", axis.range.low, "must be [low, high] with low < high");
    }
    if (!(axis.stiffness >= 0.0) || !std::isfinite(axis.stiffness)) {
      fault(i, "stiffness", axis.stiffness, "must be 0 (rigid) or more");
    }
  }
  if (!faults.empty()) throw InvalidInput(std::move(faults));
}

ChainPose forward(const PlanarChain& chain, const Vector2& axis_position,
                  const Eigen::VectorXd& joints) {
  ChainPose pose;
  Vector2 at = axis_position;
  for (std::size_t i = 0; i < chain.axes.size(); ++i) {
    const PlanarAxis& axis = chain.axes[i];
    const double q = joints(static_cast<Eigen::Index>(i));
    pose.points.push_back(at);
    if (axis.kind == AxisKind::revolute) {
      pose.heading += q;
      at += axis.length * heading_vector(pose.heading);
    } else {
      at += q * heading_vector(pose.heading + axis.direction);
    }
  }
  pose.points.push_back(at);
  return pose;
}

Eigen::Matrix3Xd chain_jacobian(const PlanarChain& chain, const Eigen::VectorXd& joints) {
  const ChainPose pose = forward(chain, Vector2::Zero(), joints);
  Eigen::Matrix3Xd jacobian(3, joints.size());
  double heading = 0.0;
  for (std::size_t i = 0; i < chain.axes.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    const PlanarAxis& axis = chain.axes[i];
    if (axis.kind == AxisKind::revolute) {
      heading += joints(k);
      jacobian.col(k) << 1.0, turned(pose.tip() - pose.points[i]);
    } else {
      jacobian.col(k) << 0.0, heading_vector(heading + axis.direction);
    }
  }
  return jacobian;
}

ChainSolution solve(const PlanarChain& chain, const Vector2& axis_position, const CutLine& line,
                    Branch branch, const ChainOptions& options) {
  check(chain);
  if (options.redundancy == Redundancy::smallest_displacement &&
      options.from.size() != static_cast<Eigen::Index>(chain.axes.size())) {
    throw InvalidInput(Fault{"from", fmt::format("{} joints", options.from.size()),
                             fmt::format("must be {} joints", chain.axes.size()), ""});
  }
  const Problem problem(chain, axis_position, line, branch, options);
  const std::size_t further = chain.axes.size() - 2;
  ChainSolution best;
  best.reason = "outside the workspace: A1's circle misses the line for every further joint tried";
  for (const std::vector<double>& start : starts(further)) {
    std::vector<double> u(2, 0.0);
    u.insert(u.end(), start.begin(), start.end());
    const auto closed = problem.closed_form(problem.joints(u));
    if (!closed) continue;
    ChainSolution one;
    one.joints = *closed;
    one.branch = branch;
    if (further > 0) {
      u = problem.scaled(*closed);
      const auto gap = [&](const Eigen::VectorXd& q) {
        return problem.gap(q) / chain.axes[0].length;
      };
      if (problem.improve(u, gap, {})) {
        one.joints = problem.joints(u);
        if (further > 1) {
          const double closed_gap = problem.gap(one.joints) + 0.5 * kSameGap;
          problem.improve(
              u, [&](const Eigen::VectorXd& q) { return problem.criterion(q); }, closed_gap);
          one.joints = problem.joints(u);
        }
      }
    }
    one.found = problem.allowed(one.joints);
    one.gap = problem.gap(one.joints);
    one.criterion = problem.criterion(one.joints);
    one.normal_compliance = problem.normal_compliance(one.joints);
    if (!one.found) {
      if (!best.found) best.reason = "no joints within their ranges keep the guide before the bone";
      continue;
    }
    if (better(one, best)) best = one;
  }
  return best;
}

ChainSolution solve(const PlanarChain& chain, const Vector2& axis_position, const CutLine& line,
                    const ChainOptions& options) {
  const ChainSolution out = solve(chain, axis_position, line, Branch::outermost, options);
  const ChainSolution in = solve(chain, axis_position, line, Branch::innermost, options);
  return better(in, out) ? in : out;
}

}  // namespace osteomill::robot
