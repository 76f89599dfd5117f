// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/simulate/stock_job.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"

namespace osteomill::simulate {
namespace {

using geometry::Vector3;
constexpr double kTurn = 2.0 * std::numbers::pi;
// A trace of occupancy is no contact: a thousandth of a voxel in a period.
constexpr double kLeastContact = 1e-3;
constexpr double kShank = 0.2;  // m of tool that counts when a turn brings it near a region
// How a rapid slows down before a cut: by this much of the feed a metre of way that is left, 1/s.
// Its time constant of 67 ms is longer than the lag of servo and control, some 25 ms.
constexpr double kBraking = 15.0;

std::vector<int> lines_of(const workpiece::ToolPath& path) {
  std::vector<int> lines;
  for (const workpiece::Move& move : path.moves()) {
    if (move.kind == workpiece::MoveKind::cut) lines.push_back(move.line);
  }
  std::sort(lines.begin(), lines.end());
  lines.erase(std::unique(lines.begin(), lines.end()), lines.end());
  return lines;
}

StockJob checked(StockJob job) {
  cutting::check(job.cutter);
  cutting::check(job.law);
  require_positive("path.rapid_mm_per_s", job.rapid_feed / units::mm_per_s, "mm/s");
  require_positive("machine.sample_rate_hz", job.sample_rate, "Hz");
  job.fibre_W.normalize();
  return job;
}

/// The load between two steps of a revolution.
cutting::Load at_angle(const cutting::Revolution& revolution, double angle) {
  const double count = static_cast<double>(revolution.loads.size());
  const double place = (angle / kTurn - std::floor(angle / kTurn)) * count;
  const double low = std::floor(place);
  const double part = place - low;
  const std::size_t first = static_cast<std::size_t>(low) % revolution.loads.size();
  const std::size_t second = (first + 1) % revolution.loads.size();
  cutting::Load load;
  load.force = (1.0 - part) * revolution.loads[first].force + part * revolution.loads[second].force;
  load.moment =
      (1.0 - part) * revolution.loads[first].moment + part * revolution.loads[second].moment;
  return load;
}

}  // namespace

StockWorkpiece::StockWorkpiece(workpiece::Stock stock, StockJob job)
    : stock_(std::move(stock)),
      job_(checked(std::move(job))),
      left_(job_.heat ? std::make_unique<workpiece::Stock>(stock_) : nullptr),
      contact_(stock_, job_.cutter, job_.path, 0.0, left_.get()),
      remover_(stock_, job_.cutter),
      patches_(workpiece::patches_for(job_.cutter, stock_.spacing())),
      force_(job_.cutter, job_.law, patches_.angles, patches_.slices, patches_.slice_height),
      lines_(lines_of(job_.path)) {
  if (job_.heat) {
    heat_.emplace(stock_, job_.cutter, job_.path, *job_.heat);
    heat_->watch(*left_);
    left_.reset();
  }
  if (job_.heat && cutting::has_edge_force(job_.law)) {
    edge_force_.emplace(job_.cutter, cutting::edge_part(job_.law), patches_.angles, patches_.slices,
                        patches_.slice_height);
  }
}

Place StockWorkpiece::at(double position) const {
  const workpiece::PathPoint point = job_.path.at(position);
  const workpiece::Move& move = job_.path.moves()[point.move];
  const auto line = std::lower_bound(lines_.begin(), lines_.end(), move.line);
  Place place;
  place.line = std::min(static_cast<int>(line - lines_.begin()), lines() - 1);
  place.tip_W = point.position_W;
  place.direction_W = point.direction_W;
  place.axis_W = point.axis_W;
  place.rapid = move.kind == workpiece::MoveKind::rapid;
  place.programmed_feed = place.rapid ? rapid_feed(point.move, position) : move.feed_rate;
  return place;
}

double StockWorkpiece::rapid_feed(std::size_t move, double position) const {
  const std::vector<workpiece::Move>& moves = job_.path.moves();
  std::size_t next = move;
  while (next < moves.size() && moves[next].kind == workpiece::MoveKind::rapid) ++next;
  if (next == moves.size()) return job_.rapid_feed;
  const double left = job_.path.start_of(next) - position;
  return std::min(job_.rapid_feed, moves[next].feed_rate + kBraking * left);
}

double StockWorkpiece::to_contact(double position) const {
  return nearest_entry(position).begin - position;
}

double StockWorkpiece::to_engagement(double position) const {
  return nearest_entry(position).engaged - position;
}

const workpiece::ContactMap::Stretch& StockWorkpiece::nearest_entry(double position) const {
  const auto nearer = [&](const auto& one, const auto& other) {
    return std::abs(one.begin - position) < std::abs(other.begin - position);
  };
  const std::vector<workpiece::ContactMap::Stretch>& all = contact_.stretches();
  return *std::min_element(all.begin(), all.end(), nearer);
}

/// A distance changes by no more than the way of the tool: it is worked out anew when that has
/// become a tenth of it, and a tenth of a millimetre.
void StockWorkpiece::watch_no_go(const workpiece::ToolPose& pose) {
  if (job_.no_go.empty()) return;
  const Vector3& tip_W = pose.tip_W;
  const double way =
      (tip_W - no_go_tip_W_).norm() + kShank * workpiece::angle_between(pose.axis_W, no_go_axis_W_);
  const bool known = std::isfinite(no_go_distance_);
  if (known && way < std::max(0.1 * no_go_found_, 0.1e-3)) {
    no_go_distance_ = no_go_found_ - way;
    return;
  }
  const Vector3 up = 1e-6 * pose.axis_W;  // a path needs a length
  const workpiece::ToolPath here(
      {{workpiece::MoveKind::cut, {tip_W, tip_W + up}, 1e-3, 1.0, 1, {pose.axis_W, pose.axis_W}}});
  no_go_distance_ = std::numeric_limits<double>::infinity();
  for (const workpiece::NoGo& region : job_.no_go) {
    no_go_distance_ =
        std::min(no_go_distance_, workpiece::nearest_approach(here, job_.cutter, region).distance);
  }
  no_go_found_ = no_go_distance_;
  no_go_tip_W_ = tip_W;
  no_go_axis_W_ = pose.axis_W;
}

void StockWorkpiece::mill(const Motion& motion, Cut& cut) {
  const double to = std::min(motion.positions.back(), length());
  const double travelled = to - motion.from;
  workpiece::Removal total;
  if (travelled > 0.0) {
    std::vector<double> stops = job_.path.corners_between(motion.from, to);
    stops.push_back(to);
    workpiece::ToolPose pose = job_.path.at(motion.from).pose();
    pose.tip_W += bent_W_;
    for (const double stop : stops) {
      workpiece::ToolPose next = job_.path.at(stop).pose();
      next.tip_W += next_bent_W_;
      const workpiece::Removal part = remover_.step(pose, next);
      total.volume += part.volume;
      total.mass += part.mass;
      total.scaled_volume += part.scaled_volume;
      buried_volume_ += part.buried_volume;
      pose = next;
    }
    bent_W_ = next_bent_W_;
  }
  // The direction that the engagement belongs to: that of the last piece of path.
  const Place place = at(0.5 * (to + std::max(motion.from, to - 1e-9)));
  watch_no_go(job_.path.at(to).pose());
  cut.direction_W = place.direction_W;
  cut.removed_volume = total.volume;
  const double time = static_cast<double>(motion.positions.size()) * motion.sample_time;
  const bool touching = total.volume > kLeastContact * stock_.shape().voxel_volume();
  std::fill(cut.contacts.begin(), cut.contacts.end(), touching ? 1 : 0);
  if (!touching) {
    std::fill(cut.forces_W.begin(), cut.forces_W.end(), Vector3::Zero());
    std::fill(cut.torques.begin(), cut.torques.end(), 0.0);
    next_bent_W_.setZero();
    if (heat_) heat_->rest(time);
    return;
  }
  cut.material = total.mass / total.volume;
  if (total.scaled_volume > 0.0)
    cut.contact_length =
        force_.edge_in_bone(remover_.engagement()) * total.volume / total.scaled_volume;
  sample_forces(motion, place, travelled / time, cut);
  if (heat_) heat_bone(motion, place, travelled / time);
}

void StockWorkpiece::heat_bone(const Motion& motion, const Place& place, double feed) {
  const double time = static_cast<double>(motion.positions.size()) * motion.sample_time;
  const cutting::Condition condition = condition_of(motion, place, feed);
  const cutting::Engagement& engagement = remover_.engagement();
  patch_cuts_ = patch_cuts(force_, edge_force_ ? &*edge_force_ : nullptr, job_.cutter, engagement,
                           condition, time);
  heat_->advance(stock_, place.tip_W, remover_.R_WT(), engagement, patch_cuts_, time);
}

cutting::Condition StockWorkpiece::condition_of(const Motion& motion, const Place& place,
                                                double feed) const {
  cutting::Condition condition;
  condition.spindle_speed = motion.spindle_speed;
  const workpiece::Remover::Motion moved = remover_.motion();
  condition.feed_per_tooth =
      cutting::feed_per_tooth(moved.share * feed, motion.spindle_speed, job_.cutter.flutes);
  condition.feed_elevation = moved.elevation;
  // That of the place where the cutter is in bone, half way up what it can cut in a step.
  const Vector3 fibre_W = job_.fibre_at
                              ? job_.fibre_at(place.tip_W + 0.5 * job_.cutter.radius * place.axis_W)
                              : job_.fibre_W;
  condition.fibre_T = remover_.R_WT().transpose() * fibre_W;
  condition.turn_T = moved.turn_T;
  condition.turn_height = moved.height;
  return condition;
}

/// [plaskos2002] eq. 10 for the mean force of a revolution, at the height of its line of action:
/// M = z × F gives z = (F_x M_y - F_y M_x)/(F_x² + F_y²). Half of the change from period to period,
/// so that force and deflection settle.
void StockWorkpiece::bend(const cutting::Load& mean_T, const Eigen::Matrix3d& R_WT) {
  const Vector3& F = mean_T.force;
  const double square = F.x() * F.x() + F.y() * F.y();
  Vector3 deflection_T = Vector3::Zero();
  if (square > 0.0) {
    const double height = std::clamp(
        (F.x() * mean_T.moment.y() - F.y() * mean_T.moment.x()) / square, 0.0, job_.tool->length());
    deflection_T = job_.tool->between(height, height) * Vector3(F.x(), F.y(), 0.0);
  }
  next_bent_W_ = 0.5 * (bent_W_ + R_WT * deflection_T);
  const double size = next_bent_W_.norm();
  bent_sum_ += size;
  ++bent_periods_;
  bent_largest_ = std::max(bent_largest_, size);
}

BentTool StockWorkpiece::bent_tool() const {
  return {bent_periods_ > 0 ? bent_sum_ / static_cast<double>(bent_periods_) : 0.0, bent_largest_};
}

void StockWorkpiece::sample_forces(const Motion& motion, const Place& place, double feed,
                                   Cut& cut) {
  const Eigen::Matrix3d R_WT = remover_.R_WT();
  const cutting::Condition condition = condition_of(motion, place, feed);
  largest_chip_ = std::max(largest_chip_, condition.feed_per_tooth);

  const double samples = kTurn / motion.spindle_speed * job_.sample_rate;
  const int steps = std::clamp(static_cast<int>(std::lround(samples)), 36, 720);
  const cutting::Revolution revolution = force_.revolution(remover_.engagement(), condition, steps);
  if (job_.tool) {
    cutting::Load mean;
    for (const cutting::Load& load : revolution.loads) mean += load;
    mean.force /= static_cast<double>(revolution.loads.size());
    mean.moment /= static_cast<double>(revolution.loads.size());
    bend(mean, R_WT);
  }
  for (std::size_t i = 0; i < motion.angles.size(); ++i) {
    const cutting::Load load = at_angle(revolution, motion.angles[i]);
    cut.forces_W[i] = R_WT * load.force;
    cut.torques[i] = load.torque();
  }
}

}  // namespace osteomill::simulate
