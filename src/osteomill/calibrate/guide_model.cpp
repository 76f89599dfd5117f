// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/calibrate/guide_model.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/special_functions/gamma.hpp>
#include <cmath>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/calibrate/shape_fit.hpp"
#include "osteomill/numerics/decompositions.hpp"

namespace osteomill::calibrate {
namespace {

using Vector = Eigen::VectorXd;
using Kind = Disturbance::Kind;

Eigen::Matrix3d exp_of(const Vector3& v) {
  const double angle = v.norm();
  if (angle < 1e-300) return Eigen::Matrix3d::Identity();
  return Eigen::AngleAxisd(angle, v / angle).toRotationMatrix();
}

/// Two unit vectors across a direction, the same for the same direction.
std::pair<Vector3, Vector3> across(const Vector3& direction) {
  Eigen::Index k = 0;
  direction.cwiseAbs().minCoeff(&k);
  const Vector3 first = direction.cross(Vector3::Unit(k)).normalized();
  return {first, direction.cross(first)};
}

Axis moved(const Axis& axis, const Eigen::Vector4d& step) {
  const auto [a, b] = across(axis.direction);
  return {axis.point + step[0] * a + step[1] * b,
          (axis.direction + step[2] * a + step[3] * b).normalized()};
}

int extra_parameters(Kind kind) {
  switch (kind) {
    case Kind::slip1:
    case Kind::slip2:
      return 1;
    case Kind::moved_reference:
      return 6;
    case Kind::none:
    case Kind::bad_stop:
      return 0;
  }
  return 0;
}

/// The model together with a disturbance and its parameters.
struct State {
  GuideModel model;
  Kind kind = Kind::none;
  std::size_t from = 0;
  Vector extra;

  Pose pose(std::size_t stop, const Halls& halls) const {
    Halls shifted = halls;
    if (stop >= from) {
      if (kind == Kind::slip1) shifted[0] += extra[0] * model.gear[0];
      if (kind == Kind::slip2) shifted[1] += extra[0] * model.gear[1];
    }
    Pose pose = model.pose(shifted);
    if (kind == Kind::moved_reference && stop >= from) {
      Pose shift = Pose::Identity();
      shift.linear() = exp_of(extra.tail<3>());
      shift.translation() = extra.head<3>();
      pose = shift * pose;
    }
    return pose;
  }

  State stepped(const Vector& step) const {
    State next = *this;
    next.model = calibrate::moved(model, step.head<kGuideParameters>());
    next.extra += step.tail(extra.size());
    return next;
  }
};

/// Residuals over their standard deviations, six a stop; a bad stop counts for nothing.
Vector residuals_of(const State& state, const std::vector<CalibrationStop>& stops) {
  Vector residuals(6 * static_cast<Eigen::Index>(stops.size()));
  for (std::size_t i = 0; i < stops.size(); ++i) {
    auto six = residuals.segment<6>(6 * static_cast<Eigen::Index>(i));
    if (state.kind == Kind::bad_stop && i == state.from) {
      six.setZero();
      continue;
    }
    const StopMean& mean = stops[i].mean;
    const Pose pose = state.pose(i, stops[i].halls);
    const double root = std::sqrt(static_cast<double>(mean.used));
    six.head<3>() = (mean.X_FG.translation() - pose.translation()) * root / mean.position_sd;
    six.tail<3>() = rotation_between(pose, mean.X_FG) * root / mean.rotation_sd;
  }
  return residuals;
}

struct Solved {
  State state;
  double chi_squared = 0.0;
  Eigen::MatrixXd jacobian;
  bool converged = false;
};

/// Gauss-Newton with central differences: the problem is nearly linear, its residuals are small.
Solved solve(State state, const std::vector<CalibrationStop>& stops, int max_iterations) {
  const Eigen::Index count = kGuideParameters + state.extra.size();
  const double h = 1e-6;  // m and rad: truncation h² and rounding 1e-16/h are both far below noise
  Solved solved;
  Vector residuals = residuals_of(state, stops);
  for (int round = 0; round < max_iterations; ++round) {
    solved.jacobian.resize(residuals.size(), count);
    for (Eigen::Index k = 0; k < count; ++k) {
      const Vector step = h * Vector::Unit(count, k);
      solved.jacobian.col(k) =
          (residuals_of(state.stepped(step), stops) - residuals_of(state.stepped(-step), stops)) /
          (2.0 * h);
    }
    const Vector step = -solved.jacobian.colPivHouseholderQr().solve(residuals);
    State next = state.stepped(step);
    Vector there = residuals_of(next, stops);
    // Halve the step while it makes things worse; near the solution it does not.
    double scale = 1.0;
    while (there.squaredNorm() > residuals.squaredNorm() * (1.0 + 1e-12) && scale > 1e-4) {
      scale *= 0.5;
      next = state.stepped(scale * step);
      there = residuals_of(next, stops);
    }
    const double gain = residuals.squaredNorm() - there.squaredNorm();
    state = next;
    residuals = there;
    if (gain < 1e-6) {
      solved.converged = true;
      break;
    }
  }
  solved.state = state;
  solved.chi_squared = residuals.squaredNorm();
  return solved;
}

/// Turns the fitted axis so that growing readings turn positively about it.
Axis sensed(const AxisFit& fit, const std::vector<Vector3>& points,
            const std::vector<double>& angles) {
  double sense = 0.0;
  for (std::size_t i = 1; i < points.size(); ++i) {
    const Vector3 a = points[i - 1] - fit.point;
    const Vector3 b = points[i] - fit.point;
    sense += fit.direction.dot(a.cross(b)) * (angles[i] - angles[i - 1]);
  }
  return {fit.point, sense >= 0.0 ? fit.direction : Vector3(-fit.direction)};
}

double tail_probability(double chi_squared, int freedom) {
  return freedom > 0 ? boost::math::gamma_q(0.5 * freedom, 0.5 * chi_squared) : 1.0;
}

}  // namespace

Pose turn_about(const Axis& axis, double angle) {
  Pose pose = Pose::Identity();
  pose.linear() = Eigen::AngleAxisd(angle, axis.direction).toRotationMatrix();
  pose.translation() = axis.point - pose.linear() * axis.point;
  return pose;
}

Pose GuideModel::pose(const Halls& halls) const {
  const Eigen::Vector2d theta = joints(halls);
  return turn_about(A1_F, theta[0]) * turn_about(A2_F, theta[1]) * X_FG0;
}

GuideModel moved(const GuideModel& model, const Eigen::Matrix<double, kGuideParameters, 1>& step) {
  GuideModel next = model;
  next.A1_F = moved(model.A1_F, Eigen::Vector4d(step.segment<4>(0)));
  next.A2_F = moved(model.A2_F, Eigen::Vector4d(step.segment<4>(4)));
  next.X_FG0.translation() += step.segment<3>(8);
  next.X_FG0.linear() = model.X_FG0.linear() * exp_of(step.segment<3>(11));
  return next;
}

GuideFit fit_guide(const std::vector<CalibrationStop>& stops,
                   const std::vector<std::size_t>& sweep1, const std::vector<std::size_t>& sweep2,
                   const Halls& gear, const GuideFitOptions& options) {
  if (stops.size() < 6) {
    throw InvalidInput(Fault{"stops", fmt::format("{}", stops.size()), "must be at least 6",
                             "stop every 10 deg of each axis"});
  }
  for (const CalibrationStop& stop : stops) {
    require_positive("stop.position_sd", stop.mean.position_sd, "m");
    require_positive("stop.rotation_sd", stop.mean.rotation_sd, "rad");
  }
  const auto axis_of = [&](const std::vector<std::size_t>& sweep, int joint) {
    std::vector<Vector3> points;
    std::vector<double> sd;
    std::vector<double> angles;
    for (const std::size_t i : sweep) {
      points.push_back(stops.at(i).mean.X_FG.translation());
      sd.push_back(stops[i].mean.position_sd / std::sqrt(static_cast<double>(stops[i].mean.used)));
      angles.push_back(stops[i].halls[joint] / gear[joint]);
    }
    return sensed(fit_axis(points, sd), points, angles);
  };

  State start;
  start.model.gear = gear;
  start.model.reference = stops.front().halls;
  start.model.X_FG0 = stops.front().mean.X_FG;
  start.model.A1_F = axis_of(sweep1, 0);
  // A2 was fitted with A1 at that sweep's angle; turn it back to the reference.
  const double theta1 = (stops[sweep2.front()].halls[0] - start.model.reference[0]) / gear[0];
  const Pose back = turn_about(start.model.A1_F, -theta1);
  const Axis there = axis_of(sweep2, 1);
  start.model.A2_F = {back * there.point, back.linear() * there.direction};
  start.extra.resize(0);

  const double values = 6.0 * static_cast<double>(stops.size());
  Solved best = solve(start, stops, options.max_iterations);
  const int freedom = static_cast<int>(values) - kGuideParameters;
  double best_criterion = best.chi_squared + kGuideParameters * std::log(values);
  if (tail_probability(best.chi_squared, freedom) < options.alarm) {
    const State plain = best.state;
    for (const Kind kind : {Kind::slip1, Kind::slip2, Kind::moved_reference, Kind::bad_stop}) {
      // A slip or a moved reference before the first stop would be no event.
      for (std::size_t from = kind == Kind::bad_stop ? 0 : 1; from < stops.size(); ++from) {
        State state = plain;
        state.kind = kind;
        state.from = from;
        state.extra = Vector::Zero(extra_parameters(kind));
        const Solved tried = solve(state, stops, options.max_iterations);
        // The place is a parameter too; a bad stop takes its six values out.
        const double parameters =
            kGuideParameters + 1.0 + (kind == Kind::bad_stop ? 6.0 : extra_parameters(kind));
        const double criterion = tried.chi_squared + parameters * std::log(values);
        if (criterion < best_criterion) {
          best_criterion = criterion;
          best = tried;
        }
      }
    }
  }

  GuideFit fit;
  fit.model = best.state.model;
  fit.converged = best.converged;
  fit.chi_squared = best.chi_squared;
  fit.freedom = static_cast<int>(best.jacobian.rows() - best.jacobian.cols()) -
                (best.state.kind == Kind::bad_stop ? 6 : 0);
  fit.probability = tail_probability(fit.chi_squared, fit.freedom);
  const Eigen::MatrixXd normal = best.jacobian.transpose() * best.jacobian;
  fit.covariance = normal.ldlt()
                       .solve(Eigen::MatrixXd::Identity(normal.rows(), normal.cols()))
                       .topLeftCorner<kGuideParameters, kGuideParameters>();
  double position = 0.0;
  double rotation = 0.0;
  const Vector residuals = residuals_of(best.state, stops);
  for (std::size_t i = 0; i < stops.size(); ++i) {
    const auto six = residuals.segment<6>(6 * static_cast<Eigen::Index>(i));
    fit.stop_chi_squared.push_back(six.squaredNorm());
    const double n = static_cast<double>(stops[i].mean.used);
    position += six.head<3>().squaredNorm() * std::pow(stops[i].mean.position_sd, 2) / n;
    rotation += six.tail<3>().squaredNorm() * std::pow(stops[i].mean.rotation_sd, 2) / n;
  }
  fit.position_rms = std::sqrt(position / (0.5 * values));
  fit.rotation_rms = std::sqrt(rotation / (0.5 * values));
  fit.disturbance.kind = best.state.kind;
  fit.disturbance.from = best.state.from;
  if (best.state.kind == Kind::slip1 || best.state.kind == Kind::slip2) {
    fit.disturbance.angle = best.state.extra[0];
  } else if (best.state.kind == Kind::moved_reference) {
    fit.disturbance.angle = best.state.extra.tail<3>().norm();
    fit.disturbance.shift = best.state.extra.head<3>().norm();
  }
  return fit;
}

}  // namespace osteomill::calibrate
