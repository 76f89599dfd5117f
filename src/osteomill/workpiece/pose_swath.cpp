// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/workpiece/pose_swath.hpp"

#include <algorithm>
#include <cmath>

#include "osteomill/workpiece/lanes.hpp"

namespace osteomill::workpiece {

namespace {

constexpr double kBand = 0.5;         // half the width over which occupancy goes from 1 to 0
constexpr double kAcross = 1e-12;     // a direction cosine that is none
constexpr double kSearched = 0.3e-4;  // of the distance: a unit of occupancy
constexpr double kLevel = 1e-9;       // a way along the axis that is none
constexpr double kSame = 1e-6;        // nearer than at the start by less is no change

Stock::Occupancy occupancy_at(double distance) {
  return static_cast<Stock::Occupancy>(std::clamp(kBand + distance, 0.0, 1.0) * Stock::kFull + 0.5);
}

/// Two directions across the axis, turned along with it from one pose to the other.
void make_frames(const Vector3& a0, const Vector3& a1, Eigen::Matrix3d& frame0,
                 Eigen::Matrix3d& frame1) {
  Vector3 k = a0.cross(a1);
  if (k.norm() < 1e-12) k = a0.unitOrthogonal();
  k.normalize();
  frame0 << k.transpose(), k.cross(a0).transpose(), a0.transpose();
  frame1 << k.transpose(), k.cross(a1).transpose(), a1.transpose();
}

}  // namespace

/// Whether a point at q that goes this way has the cutter nearest where it is: the distance,
/// convex, doesn't fall at first.
bool PoseSwath::recedes(const Vector3& q, const Vector3& way) const {
  return q.z() >= upright_from_ && q.x() * way.x() + q.y() * way.y() >= 0.0;
}

double PoseSwath::above_tip(const ToolPose& pose) const {
  // Where the axis leaves the grid for good, as far from it as the tool is thick.
  const double around = cutter_.radius() + 1.0;
  double leaves = 1e30;
  for (int i = 0; i < 3; ++i) {
    const double a = pose.axis_W[i];
    const double high = shape_.size[static_cast<std::size_t>(i)] - 1.0 + around;
    if (a > kAcross) leaves = std::min(leaves, (high - pose.tip_W[i]) / a);
    if (a < -kAcross) leaves = std::min(leaves, (-around - pose.tip_W[i]) / a);
  }
  return std::max(0.0, leaves);
}

int PoseSwath::pieces(const ToolPose& from, const ToolPose& to) const {
  const double travel = (to.tip_W - from.tip_W).norm();
  const double turn = angle_between(from.axis_W, to.axis_W);
  const double reach = std::max(above_tip(from), above_tip(to)) + cutter_.radius();
  const double bent =
      turn > 1e-12 ? std::sqrt((turn * turn * reach + 2.0 * turn * travel) / (8.0 * kError)) : 0.0;
  const double most = std::max(bent, (travel + turn * reach) / std::max(1.0, cutter_.radius()));
  return std::max(1, static_cast<int>(std::ceil(most - 1e-9)));
}

void PoseSwath::begin_step(const ToolPose& from, const ToolPose& to) {
  placing_ = false;
  begin(from, to);
}

void PoseSwath::begin_placing(const ToolPose& pose) {
  placing_ = true;
  begin(pose, pose);
}

void PoseSwath::begin(const ToolPose& from, const ToolPose& to) {
  from_ = from;
  to_ = to;
  middle_ = between(from, to, 0.5);
  make_frames(from.axis_W, to.axis_W, from_frame_, to_frame_);
  Frame again;
  make_frames(middle_.axis_W, to.axis_W, middle_frame_, again);
  upright_from_ = cutter_.upright_from(kBand);
  turns_ = from_frame_ != to_frame_;
  level_ = !turns_ && std::abs((to.tip_W - from.tip_W).dot(from.axis_W)) < kLevel;
  const double half_turn = 0.5 * angle_between(from.axis_W, to.axis_W);
  height_ = std::max({above_tip(from), above_tip(to), above_tip(middle_)});
  // What lies outside this around the middle pose is outside the tool at all poses.
  const double moved =
      0.5 * (to.tip_W - from.tip_W).norm() + half_turn * (height_ + cutter_.radius());
  reach_ = cutter_.radius() + kBand + moved;
  const double disk =
      reach_ * std::sqrt(std::max(0.0, 1.0 - middle_.axis_W.z() * middle_.axis_W.z()));
  const double under = (kBand + moved) * std::abs(middle_.axis_W.z());
  const double tip = middle_.tip_W.z(), end = tip + height_ * middle_.axis_W.z();
  const double low = std::max(0.0, std::min(tip, end) - disk - under);
  const double high = std::min(shape_.size[2] - 1.0, std::max(tip, end) + disk + under);
  first_layer_ = static_cast<int>(std::ceil(std::min(low, 1e9)));
  last_layer_ = static_cast<int>(std::floor(std::max(high, -1.0)));
}

double PoseSwath::at(const Vector3& q) const {
  return cutter_.distance(std::sqrt(q.x() * q.x() + q.y() * q.y()), q.z());
}

/// The least distance on the line from q0 to q1; `first` and `last` are those of its ends.
double PoseSwath::nearest(const Vector3& q0, const Vector3& q1, double first, double last) const {
  const Vector3 way = q1 - q0;
  const double across_sq = way.x() * way.x() + way.y() * way.y();
  if (std::abs(way.z()) < kLevel) {
    // At one height the distance rises with that from the axis.
    if (across_sq < 1e-24) return std::min(first, last);
    const double t = std::clamp(-(q0.x() * way.x() + q0.y() * way.y()) / across_sq, 0.0, 1.0);
    return at(q0 + t * way);
  }
  if (cutter_.is_ball()) {
    // Squared distance from the half-line above the centre: f = r² + min(0, z - R)², convex and
    // smooth; the least of r² is it where it lies above, else that of r² + (z - R)².
    const double R = cutter_.radius(), below = q0.z() - R;
    const double rr = q0.x() * way.x() + q0.y() * way.y();
    const double upper =
        across_sq > 1e-24 ? std::clamp(-rr / across_sq, 0.0, 1.0) : (way.z() > 0.0 ? 1.0 : 0.0);
    if (below + upper * way.z() >= 0.0) return at(q0 + upper * way);
    const double lower =
        std::clamp(-(rr + below * way.z()) / (across_sq + way.z() * way.z()), 0.0, 1.0);
    if (below + lower * way.z() <= 0.0) return at(q0 + lower * way);
    return at(q0 + std::clamp(-below / way.z(), 0.0, 1.0) * way);
  }
  // The distance to a convex body is convex along a line: golden section.
  constexpr double kGolden = 0.61803398874989485;
  const double length = way.norm();
  double low = 0.0, high = 1.0;
  double left = 1.0 - kGolden, right = kGolden;
  double at_left = at(q0 + left * way), at_right = at(q0 + right * way);
  while ((high - low) * length > kSearched) {
    if (at_left < at_right) {
      high = right;
      right = left;
      at_right = at_left;
      left = high - kGolden * (high - low);
      at_left = at(q0 + left * way);
    } else {
      low = left;
      left = right;
      at_left = at_right;
      right = low + kGolden * (high - low);
      at_right = at(q0 + right * way);
    }
  }
  return std::min({first, at_left, at_right, last});
}

double PoseSwath::distance(const Vector3& p) const {
  const Vector3 q0 = from_frame_ * (p - from_.tip_W), q1 = to_frame_ * (p - to_.tip_W);
  return nearest(q0, q1, at(q0), at(q1));
}

/// What is left in a voxel that the tool sees go from q0 to q1.
PoseSwath::Voxel PoseSwath::look(const Vector3& q0, const Vector3& q1) const {
  if (!placing_ && recedes(q0, q1 - q0)) return {};
  const double d0 = at(q0);
  if (d0 <= -kBand && !placing_) return {Swath::kNothing, static_cast<int>(-kBand - d0) + 1};
  const double d1 = at(q1);
  // No distance in between is less than this, since it changes by no more than the way.
  const double least = 0.5 * (d0 + d1 - (q1 - q0).norm());
  if (least >= kBand) return {Swath::kNothing, static_cast<int>(least - kBand) + 1};
  const double d = std::min(d0, d1) <= -kBand ? -kBand : nearest(q0, q1, d0, d1);
  if (d >= kBand || (d > d0 - kSame && !placing_)) return {};
  return {occupancy_at(d), 1};
}

void PoseSwath::walk(int y, int z, int first, int last) {
  const Vector3 start(0.0, y, z);
  const Vector3 base0 = from_frame_ * (start - from_.tip_W);
  const Vector3 base1 = to_frame_ * (start - to_.tip_W);
  const Vector3 along0 = from_frame_.col(0), along1 = to_frame_.col(0);
  bool open = false;  // the last run goes on here
  for (int x = first; x <= last;) {
    const Voxel voxel = look(base0 + x * along0, base1 + x * along1);
    if (voxel.fresh == Swath::kNothing) {
      x += voxel.alike;
      open = false;
      continue;
    }
    if (!open) {
      fresh_.resize(up_to_eight(fresh_.size()), Swath::kNothing);
      runs_.push_back({y, x, x, fresh_.size()});
      fresh_.resize(fresh_.size() + static_cast<std::size_t>(x % 8), Swath::kNothing);
    }
    open = true;
    runs_.back().last = x;
    fresh_.push_back(voxel.fresh);
    ++x;
  }
}

/// Of the layer z.
kernel::View PoseSwath::view(const Frame& frame, const Vector3& tip, int z) const {
  const Vector3 base = frame * (Vector3(0.0, 0.0, z) - tip);
  return {{base.x(), base.y(), base.z()},
          {frame(0, 1), frame(1, 1), frame(2, 1)},
          {frame(0, 0), frame(1, 0), frame(2, 0)}};
}

/// The runs of a ball or a cylinder, by formula.
void PoseSwath::list_rows(int z, int first_y, int last_y, std::span<const std::int64_t> row_units) {
  const bool ball = cutter_.is_ball();
  const double radius = cutter_.radius();
  const kernel::Solid near{view(middle_frame_, middle_.tip_W, z), reach_,
                           ball ? radius : radius - reach_, ball};
  const kernel::View from = view(from_frame_, from_.tip_W, z);
  const kernel::Solid gone{from, radius - kBand, ball ? radius : kBand, ball};
  const std::size_t size = up_to_eight(static_cast<std::size_t>(last_y - first_y + 1));
  stretches_.resize(std::max(stretches_.size(), 4 * size));
  int* const out = stretches_.data();
  const kernel::Stretches stretches{
      {out, out + size}, {out + 2 * size, out + 3 * size}, nullptr, nullptr};
  // Under the end of a cylinder that comes down the tool is nearer on all sides.
  const bool same_way = !turns_ && (ball || level_);
  const Vector3 way = from_frame_ * (from_.tip_W - to_.tip_W);
  kernel::best().pose_stretches(near, placing_ ? nullptr : &gone, same_way ? way.data() : nullptr,
                                first_y, last_y, shape_.size[0] - 1.0, stretches);
  std::size_t fresh = 0;
  for (int y = first_y; y <= last_y; ++y) {
    if (row_units[static_cast<std::size_t>(y / 8)] == 0) continue;
    for (int part = 0; part < 2; ++part) {
      const int first = stretches.first[part][y - first_y],
                last = stretches.last[part][y - first_y];
      if (first > last) continue;
      runs_.push_back({y, first, last, fresh});
      fresh += static_cast<std::size_t>(kernel::lanes_of(runs_.back()));
    }
  }
  fresh_.resize(fresh);
  if (ball || level_) {
    const kernel::Pass pass{from, view(to_frame_, to_.tip_W, z), radius, ball, placing_, turns_};
    runs_.resize(kernel::best().pose_fill(pass, runs_.data(), runs_.size(), fresh_.data()));
    return;
  }
  for (const Run& run : runs_) {
    const Vector3 start(kernel::start_of(run), run.y, z);
    const Vector3 q0 = from_frame_ * (start - from_.tip_W), q1 = to_frame_ * (start - to_.tip_W);
    for (int k = 0; k < kernel::lanes_of(run); ++k)
      fresh_[run.fresh + static_cast<std::size_t>(k)] =
          look(q0 + k * from_frame_.col(0), q1 + k * to_frame_.col(0)).fresh;
  }
}

bool PoseSwath::list(int z, std::span<const std::int64_t> row_units) {
  runs_.clear();
  fresh_.clear();
  const Vector3& a = middle_.axis_W;
  const Vector3& tip = middle_.tip_W;
  // The stretch of the axis whose disks reach the layer, and its rows.
  double low = 0.0, high = height_;
  const double disk_z = reach_ * std::sqrt(std::max(0.0, 1.0 - a.z() * a.z())) + reach_ * 1e-9;
  if (std::abs(a.z()) > kAcross) {
    double enters = (z - disk_z - tip.z()) / a.z(), leaves = (z + disk_z - tip.z()) / a.z();
    if (enters > leaves) std::swap(enters, leaves);
    low = std::clamp(enters, 0.0, height_);
    high = std::clamp(leaves, 0.0, height_);
  }
  const double under = reach_ - cutter_.radius();
  const double disk_y =
      reach_ * std::sqrt(std::max(0.0, 1.0 - a.y() * a.y())) + under * std::abs(a.y());
  const double y0 = tip.y() + low * a.y(), y1 = tip.y() + high * a.y();
  const int first_y = static_cast<int>(std::ceil(std::max(0.0, std::min(y0, y1) - disk_y)));
  const int last_y =
      static_cast<int>(std::floor(std::min(shape_.size[1] - 1.0, std::max(y0, y1) + disk_y)));
  if (first_y > last_y) return true;
  if (cutter_.is_ball() || cutter_.is_cylinder()) {
    list_rows(z, first_y, last_y, row_units);
    return true;
  }
  const double across = 1.0 - a.x() * a.x();
  for (int y = first_y; y <= last_y; ++y) {
    if (row_units[static_cast<std::size_t>(y / 8)] == 0) continue;
    // x with |w + x e|² - (a·(w + x e))² <= reach² and a·(w + x e) >= -under, w to x = 0.
    const Vector3 w(-tip.x(), y - tip.y(), z - tip.z());
    const double aw = a.dot(w);
    const double rest = w.squaredNorm() - aw * aw - reach_ * reach_;
    double from = 0.0, to = shape_.size[0] - 1.0;
    const double half = w.x() - aw * a.x();
    if (across > 1e-9) {
      const double root = half * half - across * rest;
      if (root < 0.0) continue;
      from = std::max(from, (-half - std::sqrt(root)) / across);
      to = std::min(to, (-half + std::sqrt(root)) / across);
    } else if (rest > 2.0 * std::abs(half) * shape_.size[0]) {
      continue;
    }
    if (a.x() > kAcross)
      from = std::max(from, (-under - aw) / a.x());
    else if (a.x() < -kAcross)
      to = std::min(to, (-under - aw) / a.x());
    else if (aw < -under - 1e-9)
      continue;
    if (from > to) continue;
    walk(y, z, static_cast<int>(std::ceil(from)), static_cast<int>(std::floor(to)));
  }
  fresh_.resize(up_to_eight(fresh_.size()), Swath::kNothing);
  return true;
}

}  // namespace osteomill::workpiece
