// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/calibrate/guide_calibration.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/numerics/decompositions.hpp"

namespace osteomill::calibrate {
namespace {

using units::deg;
using units::mm;

/// Angle from a to b about an axis, both laid into the plane across it.
double angle_about(const Vector3& axis, const Vector3& a, const Vector3& b) {
  const Vector3 pa = a - axis * axis.dot(a);
  const Vector3 pb = b - axis * axis.dot(b);
  return std::atan2(axis.dot(pa.cross(pb)), pa.dot(pb));
}

double line_distance(const Axis& a, const Axis& b) {
  // Across the first axis: the axes are meant to be parallel.
  const Vector3 r = b.point - a.point;
  return (r - a.direction * a.direction.dot(r)).norm();
}

void find_faults(const std::vector<CalibrationStop>& stops, const CalibrationOptions& options,
                 GuideCalibration& result) {
  using Kind = CalibrationFault::Kind;
  const auto add = [&](Kind kind, const std::string& stop, const std::string& text) {
    result.faults.push_back({kind, stop, text});
  };
  std::vector<double> position;
  std::vector<double> rotation;
  for (const CalibrationStop& stop : stops) {
    position.push_back(stop.mean.position_sd);
    rotation.push_back(stop.mean.rotation_sd);
  }
  const auto median = [](std::vector<double> values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
  };
  const double usual_position = median(position);
  const double usual_rotation = median(rotation);
  for (const CalibrationStop& stop : stops) {
    const int total = stop.mean.used + stop.mean.hidden;
    if (stop.mean.used < options.least_samples) {
      add(Kind::hidden_marker, stop.name,
          fmt::format("{}: a marker was hidden in {} of {} readings; free the line of sight and "
                      "record the stop again",
                      stop.name, stop.mean.hidden, total));
    }
    if (stop.mean.position_sd > options.largest_spread * usual_position ||
        stop.mean.rotation_sd > options.largest_spread * usual_rotation) {
      add(Kind::unsteady_stop, stop.name,
          fmt::format("{}: readings spread {:.2f} mm and {:.2f} deg, {:.1f} and {:.1f} times the "
                      "usual; hold the leg still and check the markers",
                      stop.name, stop.mean.position_sd / mm, stop.mean.rotation_sd / deg,
                      stop.mean.position_sd / usual_position,
                      stop.mean.rotation_sd / usual_rotation));
    }
  }
  const Disturbance& what = result.fit.disturbance;
  const std::string at = stops[what.from].name;
  switch (what.kind) {
    case Disturbance::Kind::none:
      break;
    case Disturbance::Kind::slip1:
    case Disturbance::Kind::slip2:
      add(Kind::slip, at,
          fmt::format(
              "the brake of axis {} slipped by {:.2f} deg before {}; press it and calibrate "
              "again",
              what.kind == Disturbance::Kind::slip1 ? 1 : 2, what.angle / deg, at));
      break;
    case Disturbance::Kind::moved_reference:
      add(Kind::moved_reference, at,
          fmt::format("the reference body on the bone moved by {:.2f} mm and {:.2f} deg before {}; "
                      "fix it, register the bone and calibrate again",
                      what.shift / mm, what.angle / deg, at));
      break;
    case Disturbance::Kind::bad_stop:
      add(Kind::bad_stop, at,
          fmt::format("{}: its pose fits nothing else; a marker was partly hidden or the guide was "
                      "touched; record it again",
                      at));
      break;
  }
  if (result.fit.probability < options.fit.alarm) {
    add(Kind::misfit, "",
        fmt::format("residuals of {:.2f} mm and {:.2f} deg are more than the readings' noise "
                    "explains; check play, fixation and markers",
                    result.fit.position_rms / mm, result.fit.rotation_rms / deg));
  }
  if (result.skew > options.most_skew) {
    add(Kind::skewed_axes, "",
        fmt::format("the axes are {:.2f} deg from parallel; check the motor unit",
                    result.skew / deg));
  }
}

}  // namespace

GuideFrame guide_frame_from_cones(const std::vector<Vector3>& cones_G) {
  const PlaneFit plane = fit_plane(cones_G);
  GuideFrame guide;
  guide.tip_G = plane.centroid;
  Vector3 others = Vector3::Zero();
  for (std::size_t i = 1; i < cones_G.size(); ++i) {
    others += cones_G[i] / static_cast<double>(cones_G.size() - 1);
  }
  const Vector3 along = others - cones_G.front();
  guide.direction_G = (along - plane.normal * plane.normal.dot(along)).normalized();
  guide.normal_G = plane.normal;
  return guide;
}

std::vector<PlannedCut> planned_cuts(const robot::PerCut<robot::CutLine>& lines, const Pose& X_FI) {
  std::vector<PlannedCut> cuts;
  for (const robot::Cut cut : robot::kCuttingOrder) {
    const robot::CutLine& line = lines[robot::index(cut)];
    const Vector3 entry(line.entry.x(), line.entry.y(), 0.0);
    const Vector3 direction(line.direction.x(), line.direction.y(), 0.0);
    const Vector3 normal(-line.direction.y(), line.direction.x(), 0.0);
    cuts.push_back({cut, X_FI * entry, X_FI.linear() * direction, X_FI.linear() * normal});
  }
  return cuts;
}

ImplantTurn turn_implant(const Pose& X_FI, const Vector3& centre_F, const Axis& A1_F) {
  // The axis' sense does not matter to the planes: take the one nearer to the implant's.
  const Vector3 from = X_FI.linear().col(2);
  const Vector3 to = A1_F.direction.dot(from) >= 0.0 ? A1_F.direction : Vector3(-A1_F.direction);
  const Eigen::Matrix3d turn = Eigen::Quaterniond::FromTwoVectors(from, to).toRotationMatrix();
  ImplantTurn result;
  result.X_FF.linear() = turn;
  result.X_FF.translation() = centre_F - turn * centre_F;
  const Eigen::AngleAxisd vector(turn);
  result.angle = vector.angle();
  const Vector3 in_implant = X_FI.linear().transpose() * (vector.angle() * vector.axis());
  result.internal_external = in_implant.x();
  result.varus_valgus = in_implant.y();
  return result;
}

GuideCalibration calibrate_guide(const GuideRecord& record, const CalibrationOptions& options) {
  require_positive("calibration.gear1", options.gear[0], "");
  require_positive("calibration.gear2", options.gear[1], "");
  if (record.sweep1.size() < 4 || record.sweep2.size() < 4) {
    throw InvalidInput(
        Fault{"calibration.sweeps",
              fmt::format("{} and {} stops", record.sweep1.size(), record.sweep2.size()),
              "must be at least 4 stops each", "stop every 10 deg"});
  }
  std::vector<CalibrationStop> stops;
  std::vector<std::size_t> sweep1;
  std::vector<std::size_t> sweep2;
  const auto add = [&](const StopRecord& stop) {
    stops.push_back({stop.name, stop.halls, average(stop.samples)});
    return stops.size() - 1;
  };
  for (const StopRecord& stop : record.passive) add(stop);
  for (const StopRecord& stop : record.sweep1) sweep1.push_back(add(stop));
  for (const StopRecord& stop : record.sweep2) sweep2.push_back(add(stop));

  GuideCalibration result;
  result.fit = fit_guide(stops, sweep1, sweep2, options.gear, options.fit);
  const auto circle = [&](const std::vector<std::size_t>& sweep) {
    std::vector<Vector3> points;
    std::vector<double> sd;
    for (const std::size_t i : sweep) {
      points.push_back(stops[i].mean.X_FG.translation());
      sd.push_back(stops[i].mean.position_sd / std::sqrt(static_cast<double>(stops[i].mean.used)));
    }
    return fit_axis(points, sd);
  };
  result.axis1 = circle(sweep1);
  result.axis2 = circle(sweep2);
  const GuideModel& model = result.fit.model;
  result.link1 = line_distance(model.A1_F, model.A2_F);
  result.skew = std::atan2(model.A1_F.direction.cross(model.A2_F.direction).norm(),
                           std::abs(model.A1_F.direction.dot(model.A2_F.direction)));
  find_faults(stops, options, result);
  result.usable = result.fit.converged && result.faults.empty();
  return result;
}

SensorConstants sensor_constants(const GuideModel& model, const GuideFrame& guide,
                                 const GuideRecord& record, const Vector3& anterior_F) {
  SensorConstants constants;
  Halls low = Halls::Constant(std::numeric_limits<double>::infinity());
  Halls high = -low;
  for (std::size_t i = 0; i < 3; ++i) {
    const StopRecord& stop = record.passive[i];
    const Pose X_FG = average(stop.samples).X_FG;
    // A2 as the guide carries it: fixed in G, seen in F at this stop.
    const Vector3 on_A2_F = X_FG * (model.X_FG0.inverse() * model.A2_F.point);
    const Vector3& axis = model.A1_F.direction;
    const Vector3 link = on_A2_F - model.A1_F.point;
    const double theta1 = angle_about(axis, anterior_F, link);
    const double theta2 = angle_about(axis, link, X_FG.linear() * guide.direction_G);
    Halls zero = stop.halls - Halls(theta1, theta2).cwiseProduct(model.gear);
    if (i > 0) {
      // The same turn of the joint as at the first stop.
      const Halls turn = 2.0 * std::numbers::pi * model.gear;
      const Halls off = (zero - constants.each[0]).cwiseQuotient(turn);
      zero -= Halls(std::round(off[0]), std::round(off[1])).cwiseProduct(turn);
    }
    constants.each[i] = zero;
    constants.mean += zero / 3.0;
    low = low.cwiseMin(zero);
    high = high.cwiseMax(zero);
  }
  constants.spread = high - low;
  return constants;
}

PlaneError plane_error(const Pose& X_FG, const GuideFrame& guide, const PlannedCut& cut,
                       const Vector3& axis_F) {
  PlaneError error;
  const Vector3 direction = X_FG.linear() * guide.direction_G;
  error.flexion = angle_about(axis_F, cut.direction_F, direction);
  // Out of the planned plane, about the direction of cutting; the normal's sign is free.
  Vector3 normal = X_FG.linear() * guide.normal_G;
  if (normal.dot(cut.normal_F) < 0.0) normal = -normal;
  error.tilt = angle_about(cut.direction_F, cut.normal_F, normal);
  error.offset = cut.normal_F.dot(X_FG * guide.tip_G - cut.entry_F);
  return error;
}

std::vector<CutTarget> cut_targets(const GuideFit& fit, const GuideFrame& guide,
                                   const std::vector<PlannedCut>& cuts, const Halls& hall_sd,
                                   robot::Branch branch) {
  const GuideModel& model = fit.model;
  const Vector3& axis = model.A1_F.direction;
  // About the first axis the second may turn the other way.
  const double sense = model.A2_F.direction.dot(axis) >= 0.0 ? 1.0 : -1.0;
  const auto pose_at = [&](const GuideModel& m, const Eigen::Vector2d& theta) {
    return m.pose(m.reference + theta.cwiseProduct(m.gear));
  };
  std::vector<CutTarget> targets;
  for (const PlannedCut& cut : cuts) {
    CutTarget target;
    target.cut = cut.cut;
    // With the guide parallel to the cut its offset is a sin(theta1) + b cos(theta1) + c.
    const double needed = -plane_error(model.X_FG0, guide, cut, axis).flexion;
    const auto on_cut = [&](double theta1) {
      return Eigen::Vector2d(theta1, sense * (needed - theta1));
    };
    const auto offset = [&](double theta1) {
      return plane_error(pose_at(model, on_cut(theta1)), guide, cut, axis).offset;
    };
    const double at0 = offset(0.0);
    const double at90 = offset(0.5 * std::numbers::pi);
    const double at180 = offset(std::numbers::pi);
    const double c = 0.5 * (at0 + at180);
    const double b = at0 - c;
    const double a = at90 - c;
    const double amplitude = std::hypot(a, b);
    if (std::abs(c) < amplitude) {
      const double phase = std::atan2(b, a);  // a sin t + b cos t = amplitude sin(t + phase)
      const double rise = std::asin(-c / amplitude);
      Eigen::Vector2d best(0.0, 0.0);
      double best_along = 0.0;
      for (const double t : {rise - phase, std::numbers::pi - rise - phase}) {
        const Eigen::Vector2d theta = on_cut(robot::wrapped(t));
        const Pose link = turn_about(model.A1_F, theta[0]);
        const double along = cut.direction_F.dot(link * model.A2_F.point - cut.entry_F);
        const bool outer = branch == robot::Branch::outermost;
        if (!target.reachable || (outer ? along < best_along : along > best_along)) {
          best = theta;
          best_along = along;
        }
        target.reachable = true;
      }
      // Axes that are not quite parallel: Newton on flexion and offset.
      for (int round = 0; round < 20; ++round) {
        const auto both = [&](const Eigen::Vector2d& theta) {
          const PlaneError e = plane_error(pose_at(model, theta), guide, cut, axis);
          return Eigen::Vector2d(e.flexion, e.offset);
        };
        const double h = 1e-6;
        Eigen::Matrix2d slope;
        for (int k = 0; k < 2; ++k) {
          const Eigen::Vector2d d = h * Eigen::Vector2d::Unit(k);
          slope.col(k) = (both(best + d) - both(best - d)) / (2.0 * h);
        }
        const Eigen::Vector2d step = slope.fullPivLu().solve(both(best));
        best -= step;
        if (step.norm() < 1e-12) break;
      }
      best[1] = robot::wrapped(best[1]);
      target.joints = best;
      target.halls = model.reference + best.cwiseProduct(model.gear);
      target.left = plane_error(pose_at(model, best), guide, cut, axis);

      // Linear propagation of the calibration and of the sensors at the stop.
      Eigen::Matrix<double, 3, kGuideParameters + 2> slope;
      const auto three = [&](const GuideModel& m, const Halls& halls) {
        const PlaneError e = plane_error(m.pose(halls), guide, cut, axis);
        return Vector3(e.flexion, e.tilt, e.offset);
      };
      const double h = 1e-6;
      for (int k = 0; k < kGuideParameters; ++k) {
        const Eigen::Matrix<double, kGuideParameters, 1> d =
            h * Eigen::Matrix<double, kGuideParameters, 1>::Unit(k);
        slope.col(k) =
            (three(moved(model, d), target.halls) - three(moved(model, -d), target.halls)) /
            (2.0 * h);
      }
      Eigen::Matrix<double, kGuideParameters + 2, kGuideParameters + 2> covariance;
      covariance.setZero();
      covariance.topLeftCorner<kGuideParameters, kGuideParameters>() = fit.covariance;
      for (int k = 0; k < 2; ++k) {
        const Halls d = h * model.gear[k] * Halls::Unit(k);
        slope.col(kGuideParameters + k) =
            (three(model, target.halls + d) - three(model, target.halls - d)) / (2.0 * h);
        covariance(kGuideParameters + k, kGuideParameters + k) =
            std::pow(hall_sd[k] / model.gear[k], 2);
      }
      const Eigen::Matrix3d three_by_three = slope * covariance * slope.transpose();
      target.sd = {std::sqrt(three_by_three(0, 0)), std::sqrt(three_by_three(1, 1)),
                   std::sqrt(three_by_three(2, 2))};
    }
    targets.push_back(target);
  }
  return targets;
}

}  // namespace osteomill::calibrate
