// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/calibrate/pose_samples.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "osteomill/base/error.hpp"

namespace osteomill::calibrate {
namespace {

Vector3 log_of(const Eigen::Matrix3d& rotation) {
  const Eigen::AngleAxisd turn(rotation);
  return turn.angle() * turn.axis();
}

Eigen::Matrix3d exp_of(const Vector3& v) {
  const double angle = v.norm();
  if (angle < 1e-300) return Eigen::Matrix3d::Identity();
  return Eigen::AngleAxisd(angle, v / angle).toRotationMatrix();
}

template <class Range>
Pose mean_of(const Range& poses) {
  Vector3 position = Vector3::Zero();
  double count = 0.0;
  for (const Pose& pose : poses) {
    position += pose.translation();
    count += 1.0;
  }
  Eigen::Matrix3d rotation = poses.front().linear();
  // Converges quadratically for readings within a few degrees; ten rounds are plenty.
  for (int round = 0; round < 10; ++round) {
    Vector3 step = Vector3::Zero();
    for (const Pose& pose : poses) step += log_of(rotation.transpose() * pose.linear());
    step /= count;
    rotation = rotation * exp_of(step);
    if (step.norm() < 1e-14) break;
  }
  Pose mean = Pose::Identity();
  mean.linear() = Eigen::Quaterniond(rotation).normalized().toRotationMatrix();
  mean.translation() = position / count;
  return mean;
}

/// Standard deviations of a single reading, per coordinate, about the mean.
template <class Range>
std::pair<double, double> deviations(const Range& poses, const Pose& mean) {
  double position = 0.0;
  double rotation = 0.0;
  double count = 0.0;
  for (const Pose& pose : poses) {
    position += (pose.translation() - mean.translation()).squaredNorm();
    rotation += rotation_between(mean, pose).squaredNorm();
    count += 1.0;
  }
  const double freedom = 3.0 * std::max(1.0, count - 1.0);
  return {std::sqrt(position / freedom), std::sqrt(rotation / freedom)};
}

}  // namespace

Vector3 rotation_between(const Pose& a, const Pose& b) {
  return log_of(a.linear().transpose() * b.linear());
}

StopMean average(const std::vector<PoseSample>& samples) {
  std::vector<Pose> poses;
  StopMean mean;
  for (const PoseSample& sample : samples) {
    if (!sample.visible) {
      ++mean.hidden;
      continue;
    }
    if (!sample.X_FG.matrix().allFinite()) {
      throw InvalidInput(Fault{"samples", "not a number", "every visible reading must be finite",
                               "mark readings without a pose as not visible"});
    }
    poses.push_back(sample.X_FG);
  }
  mean.used = static_cast<int>(poses.size());
  if (mean.used < 2) {
    throw InvalidInput(Fault{"samples", fmt::format("{} visible of {}", mean.used, samples.size()),
                             "must be at least 2 visible readings a stop",
                             "free the line of sight and record the stop again"});
  }
  mean.X_FG = mean_of(poses);
  std::tie(mean.position_sd, mean.rotation_sd) = deviations(poses, mean.X_FG);
  return mean;
}

PoseFilter::PoseFilter(const Options& options) : options_(options) {
  require_within("filter.window", options.window, 2.0, 10000.0, "");
  require_positive("filter.reject_sd", options.reject_sd, "");
}

std::optional<Pose> PoseFilter::push(const PoseSample& sample) {
  if (sample.visible) {
    recent_.push_back(sample.X_FG);
    if (static_cast<int>(recent_.size()) > 2 * options_.window) recent_.pop_front();
  }
  if (recent_.empty()) return std::nullopt;
  const Pose mean = mean_of(recent_);
  const auto [position, rotation] = deviations(recent_, mean);
  // Of vectors: three coordinates. A nanometre for readings that are all the same.
  const double far = options_.reject_sd * std::sqrt(3.0) * position + 1e-9;
  const double turned = options_.reject_sd * std::sqrt(3.0) * rotation + 1e-9;
  std::vector<Pose> accepted;
  for (auto pose = recent_.rbegin(); pose != recent_.rend(); ++pose) {
    if ((pose->translation() - mean.translation()).norm() > far ||
        rotation_between(mean, *pose).norm() > turned) {
      continue;
    }
    accepted.push_back(*pose);
    if (static_cast<int>(accepted.size()) == options_.window) break;
  }
  return mean_of(accepted);
}

}  // namespace osteomill::calibrate
