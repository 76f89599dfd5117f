// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/workpiece/tool_path.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"

namespace osteomill::workpiece {

namespace {

// Points closer than this are one point: a thousandth of a micrometre, below any machine.
constexpr double kSamePoint = 1e-9;
// Axes closer than this are one axis, rad: 10 nm at the far end of 100 mm.
constexpr double kSameAxis = 1e-7;
// A turn by more between two points has no plane that rounding leaves alone.
const double kFlip = std::numbers::pi - 1e-3;

std::string in_mm(const Vector3& p) {
  return fmt::format("({:.6g}, {:.6g}, {:.6g}) mm", p.x() / units::mm, p.y() / units::mm,
                     p.z() / units::mm);
}

void check(const Move& move, std::size_t index, FaultList& faults) {
  const std::string name = fmt::format("path.moves[{}]", index);
  const auto require = [&](bool holds, const char* field, const std::string& value,
                           const char* rule, const char* remedy = "") {
    if (!holds)
      faults.gather([&] { throw InvalidInput(Fault{name + field, value, rule, remedy}); });
  };
  require(move.points_W.size() >= 2, ".points", std::to_string(move.points_W.size()),
          "must have at least two points");
  for (const Vector3& point : move.points_W)
    require(point.allFinite(), ".points", in_mm(point), "must be finite");
  require(move.axes_W.empty() || move.axes_W.size() == move.points_W.size(), ".axes",
          std::to_string(move.axes_W.size()), "must be one for each point, or none");
  for (std::size_t i = 0; i < move.axes_W.size(); ++i) {
    const Vector3& axis = move.axes_W[i];
    const double length = axis.norm();
    require(std::abs(length - 1.0) < 1e-6, ".axes",
            length == 0.0 ? "0 long: no direction" : fmt::format("{:.6g} long", length),
            "must be of length 1");
    if (i == 0 || length == 0.0) continue;
    const double turn = angle_between(move.axes_W[i - 1], axis);
    require(turn < kFlip, ".axes",
            fmt::format("flips over by {:.1f} deg between points {} and {}", turn / units::deg, i,
                        i + 1),
            "must turn by less than 180 deg from point to point: which way round is not said",
            "put a point between them");
  }
  if (move.kind == MoveKind::rapid) return;
  require(std::isfinite(move.feed_rate) && move.feed_rate > 0.0, ".feed_rate_mm_per_s",
          fmt::format("{:.6g} mm/s", move.feed_rate / units::mm_per_s), "must be > 0");
  require(std::isfinite(move.spindle_speed) && move.spindle_speed != 0.0, ".spindle_speed_rpm",
          fmt::format("{:.6g} rpm", move.spindle_speed / units::rpm),
          "must not be 0: a cut needs a turning spindle");
}

}  // namespace

ToolPath::ToolPath(std::vector<Move> moves) : moves_(std::move(moves)) {
  FaultList faults;
  if (moves_.empty())
    throw InvalidInput(Fault{"path", "no move", "must have at least one move", ""});
  for (std::size_t m = 0; m < moves_.size(); ++m) check(moves_[m], m, faults);
  faults.raise();
  const auto axis_at = [&](std::size_t m, std::size_t i) -> Vector3 {
    return moves_[m].axes_W.empty() ? Vector3::UnitZ() : moves_[m].axes_W[i];
  };
  const auto refuse_turn = [&](std::size_t m, const Vector3& from, const Vector3& to,
                               const Vector3& at) {
    const double turn = angle_between(from, to);
    if (turn <= kSameAxis) return;
    throw InvalidInput(Fault{fmt::format("path.moves[{}]", m),
                             fmt::format("line {} turns the tool by {:.3g} deg in place at {}",
                                         moves_[m].line, turn / units::deg, in_mm(at)),
                             "must move the tip while the tool turns: an arc length must say what "
                             "its axis is",
                             "let it turn along the move before, a rapid above the bone for "
                             "instance"});
  };
  double arc_length = 0.0;
  for (std::size_t m = 0; m < moves_.size(); ++m) {
    const std::vector<Vector3>& points = moves_[m].points_W;
    if (m > 0) {
      const Vector3& last = moves_[m - 1].points_W.back();
      if ((points.front() - last).norm() > kSamePoint)
        throw InvalidInput(Fault{fmt::format("path.moves[{}]", m), in_mm(points.front()),
                                 "must start where the move before ends, at " + in_mm(last),
                                 "put a rapid between them"});
      refuse_turn(m, axis_at(m - 1, moves_[m - 1].points_W.size() - 1), axis_at(m, 0), last);
    }
    for (std::size_t i = 1; i < points.size(); ++i) {
      const double step = (points[i] - points[i - 1]).norm();
      if (step <= kSamePoint) {
        refuse_turn(m, axis_at(m, i - 1), axis_at(m, i), points[i]);
        continue;
      }
      arc_length += step;
      segments_.push_back({points[i - 1], points[i], m, i});
      ends_.push_back(arc_length);
    }
    last_end_.push_back(arc_length);
  }
  if (segments_.empty())
    throw InvalidInput(Fault{"path", "0 mm", "must have a length", "give it different points"});
}

std::size_t ToolPath::segment_at(double arc_length) const {
  const auto end = std::upper_bound(ends_.begin(), ends_.end(), arc_length);
  return std::min(static_cast<std::size_t>(end - ends_.begin()), segments_.size() - 1);
}

PathPoint ToolPath::at(double arc_length) const {
  arc_length = std::clamp(arc_length, 0.0, length());
  const std::size_t index = segment_at(arc_length);
  const Segment& segment = segments_[index];
  const double start = index == 0 ? 0.0 : ends_[index - 1];
  const double part = std::clamp((arc_length - start) / (ends_[index] - start), 0.0, 1.0);
  PathPoint point;
  point.position_W =
      part < 1.0 ? Vector3(segment.from + part * (segment.to - segment.from)) : segment.to;
  point.direction_W = (segment.to - segment.from).normalized();
  point.move = segment.move;
  if (const std::vector<Vector3>& axes = moves_[segment.move].axes_W; !axes.empty())
    point.axis_W = turned(axes[segment.point - 1], axes[segment.point], part);
  return point;
}

bool ToolPath::upright() const {
  for (const Move& move : moves_)
    for (const Vector3& axis : move.axes_W)
      if ((axis - Vector3::UnitZ()).norm() > 1e-9) return false;
  return true;
}

std::vector<double> ToolPath::corners_between(double from, double to) const {
  const auto first = std::upper_bound(ends_.begin(), ends_.end(), from);
  const auto last = std::lower_bound(ends_.begin(), ends_.end(), to);
  return first < last ? std::vector<double>(first, last) : std::vector<double>{};
}

ToolPath line(const Vector3& from_W, const Vector3& to_W, const CutSettings& cut) {
  return ToolPath({{MoveKind::cut, {from_W, to_W}, cut.feed_rate, cut.spindle_speed, 1}});
}

ToolPath lines(const Lines& lines, const CutSettings& cut) {
  require_within("path.lines", lines.count, 1, 100000, "");
  require_positive("path.clearance_mm", lines.clearance / units::mm, "mm");
  const Vector3 up = lines.clearance * Vector3::UnitZ();
  std::vector<Move> moves;
  for (int n = 0; n < lines.count; ++n) {
    const Vector3 start = lines.start_W + n * lines.step_over_W;
    if (n > 0) {
      const Vector3 last = moves.back().points_W.back();
      moves.push_back(
          {MoveKind::rapid, {last, last + up, start + up, start}, 0.0, cut.spindle_speed, n + 1});
    }
    moves.push_back(
        {MoveKind::cut, {start, start + lines.along_W}, cut.feed_rate, cut.spindle_speed, n + 1});
  }
  return ToolPath(std::move(moves));
}

ToolPath zigzag(const Lines& lines, const CutSettings& cut) {
  require_within("path.lines", lines.count, 1, 100000, "");
  std::vector<Move> moves;
  for (int n = 0; n < lines.count; ++n) {
    Vector3 start = lines.start_W + n * lines.step_over_W;
    Vector3 end = start + lines.along_W;
    if (n % 2 == 1) std::swap(start, end);
    Move move{MoveKind::cut, {start, end}, cut.feed_rate, cut.spindle_speed, n + 1};
    if (n > 0) move.points_W.insert(move.points_W.begin(), moves.back().points_W.back());
    moves.push_back(std::move(move));
  }
  return ToolPath(std::move(moves));
}

ToolPath transformed(const ToolPath& path, const geometry::Pose& X) {
  std::vector<Move> moves = path.moves();
  for (Move& move : moves) {
    for (Vector3& point : move.points_W) point = X * point;
    if (move.axes_W.empty()) move.axes_W.assign(move.points_W.size(), Vector3::UnitZ());
    for (Vector3& axis : move.axes_W) axis = X.linear() * axis;
  }
  return ToolPath(std::move(moves));
}

std::vector<Vector3> arc(const Vector3& from, const Vector3& centre, const Vector3& axis,
                         double angle, double rise, double chord_error) {
  require_positive("path.chord_error_mm", chord_error / units::mm, "mm");
  const Vector3 n = axis.normalized();
  const Vector3 spoke = (from - centre) - n * n.dot(from - centre);
  const double radius = spoke.norm();
  require_positive("path.arc_radius_mm", radius / units::mm, "mm");
  // The sagitta of a chord over the angle a is r (1 - cos(a/2)).
  const double widest =
      chord_error < radius ? 2.0 * std::acos(1.0 - chord_error / radius) : std::numbers::pi / 2.0;
  const int chords = std::max(
      1, static_cast<int>(std::ceil(std::abs(angle) / std::min(widest, std::numbers::pi / 2.0))));
  std::vector<Vector3> points{from};
  for (int k = 1; k <= chords; ++k) {
    const double part = static_cast<double>(k) / chords;
    const Eigen::AngleAxisd turn(angle * part, n);
    points.push_back(from - spoke + turn * spoke + n * (rise * part));
  }
  return points;
}

}  // namespace osteomill::workpiece
