// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/identify/baseline.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>

#include "osteomill/base/error.hpp"

namespace osteomill::identify {
namespace {

constexpr double kGravity = 9.80665;  // m/s², standard

Eigen::Vector3d mean_of(const ForceRecord& record, const Segment& segment) {
  return record.force.middleRows(segment.begin, segment.size()).colwise().mean().transpose();
}

double middle_of(const Segment& segment) {
  return 0.5 * static_cast<double>(segment.begin + segment.end - 1);
}

}  // namespace

Baseline remove_baseline(ForceRecord& record, const std::vector<Segment>& idle, BaselineKind kind) {
  Baseline out{.offset = Eigen::MatrixX3d::Zero(1, 3)};
  if (kind == BaselineKind::none) return out;
  const bool enough = kind == BaselineKind::tare ? !idle.empty() : idle.size() >= 2;
  if (!enough) {
    throw InvalidInput({"signals.baseline", kind == BaselineKind::tare ? "tare" : "drift",
                        kind == BaselineKind::tare
                            ? "needs a part of the record without cut"
                            : "needs parts without cut both before and behind the cut",
                        "record some idle time, or give record.tare_n"});
  }
  out.first = mean_of(record, idle.front());
  out.last = mean_of(record, idle.back());
  if (kind == BaselineKind::tare) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    Eigen::Index count = 0;
    for (const Segment& part : idle) {
      sum += mean_of(record, part) * static_cast<double>(part.size());
      count += part.size();
    }
    out.offset.row(0) = (sum / static_cast<double>(count)).transpose();
    record.force.rowwise() -= out.offset.row(0);
    return out;
  }
  std::vector<Eigen::RowVector3d> level;
  for (const Segment& part : idle) level.push_back(mean_of(record, part).transpose());
  out.offset.resize(record.force.rows(), 3);
  std::size_t next = 0;  // the first idle part whose middle is not before the sample
  for (Eigen::Index i = 0; i < record.force.rows(); ++i) {
    const auto at = static_cast<double>(i);
    while (next < idle.size() && middle_of(idle[next]) < at) ++next;
    if (next == 0 || next == idle.size()) {
      out.offset.row(i) = next == 0 ? level.front() : level.back();
      continue;
    }
    const double start = middle_of(idle[next - 1]);
    const double share = (at - start) / (middle_of(idle[next]) - start);
    out.offset.row(i) = level[next - 1] + share * (level[next] - level[next - 1]);
  }
  record.force -= out.offset;
  return out;
}

void remove_gravity(Eigen::MatrixX3d& force, double mass, const Eigen::MatrixX3d& down) {
  if (down.rows() == 1) {
    force.rowwise() -= mass * kGravity * down.row(0);
    return;
  }
  if (down.rows() != force.rows()) {
    throw InvalidInput({"record.turning", fmt::format("{} samples", down.rows()),
                        fmt::format("must have as many as the force, {}", force.rows()), ""});
  }
  force -= mass * kGravity * down;
}

Eigen::MatrixX3d turned_down(const Eigen::Vector3d& down, const Eigen::Vector3d& axis,
                             const Eigen::VectorXd& angle) {
  Eigen::MatrixX3d out(angle.size(), 3);
  const Eigen::Vector3d unit = axis.normalized();
  for (Eigen::Index i = 0; i < angle.size(); ++i) {
    out.row(i) = (Eigen::AngleAxisd(-angle[i], unit) * down).transpose();
  }
  return out;
}

}  // namespace osteomill::identify
