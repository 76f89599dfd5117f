// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "osteomill/workpiece/tool_pose.hpp"

namespace osteomill::workpiece {

using geometry::Vector3;

enum class MoveKind {
  rapid,  ///< positioning at the machine's own speed; no bone may be in the way
  cut,    ///< at the programmed feed
};

/// One programmed move: the polyline that the tip follows.
struct Move {
  MoveKind kind = MoveKind::cut;
  std::vector<Vector3> points_W;  ///< two or more, m
  double feed_rate = 0.0;         ///< programmed, m/s; cuts only
  double spindle_speed = 0.0;     ///< rad/s, > 0 clockwise seen from the spindle
  int line = 0;                   ///< of the path that the move belongs to: see ToolPath
  /// Direction of the tool's axis from the tip to the spindle, a unit vector for each point,
  /// turning evenly with the way between them (see turned()); empty: +z of W all along.
  std::vector<Vector3> axes_W = {};
};

/// Where a path is at an arc length.
struct PathPoint {
  Vector3 position_W = Vector3::Zero();
  Vector3 direction_W = Vector3::Zero();  ///< unit vector along the path
  std::size_t move = 0;                   ///< index into moves()
  Vector3 axis_W = Vector3::UnitZ();      ///< from the tip to the spindle, unit
  ToolPose pose() const { return {position_W, axis_W}; }
};

/// Moves of the tip in the work frame W, one after the other, by arc length. `line` of a move is a
/// number that reports group by: the pass of a zigzag, the line of a G-code file.
class ToolPath {
 public:
  /// Throws InvalidInput: no move, a move of fewer than two points, points that are not finite, a
  /// cut with no feed or no spindle speed, axes that are not one unit vector a point, an axis that
  /// flips over between two points or turns in place, a move that does not start where the last one
  /// ended.
  explicit ToolPath(std::vector<Move> moves);

  const std::vector<Move>& moves() const { return moves_; }
  double length() const { return ends_.back(); }  ///< m
  /// Arc length at which a move ends, m.
  double end_of(std::size_t move) const { return last_end_[move]; }
  double start_of(std::size_t move) const { return move == 0 ? 0.0 : last_end_[move - 1]; }

  /// Whether the tool's axis is +z of W all along.
  bool upright() const;

  /// The point at an arc length, which is held to 0...length().
  PathPoint at(double arc_length) const;
  /// Corners of the path strictly between two arc lengths, in order: a step from one point to the
  /// other follows the path when it goes through them.
  std::vector<double> corners_between(double from, double to) const;

 private:
  struct Segment {
    Vector3 from, to;
    std::size_t move;
    std::size_t point;  ///< of the move, at the end
  };
  std::size_t segment_at(double arc_length) const;

  std::vector<Move> moves_;
  std::vector<Segment> segments_;
  std::vector<double> ends_;      ///< arc length at the end of each segment
  std::vector<double> last_end_;  ///< arc length at the end of each move
};

struct CutSettings {
  double feed_rate = 0.0;      ///< m/s
  double spindle_speed = 0.0;  ///< rad/s
};

/// One straight cut.
ToolPath line(const Vector3& from_W, const Vector3& to_W, const CutSettings& cut);

/// Straight cuts of one direction, each `step_over` beside the last, with the way back between them
/// as a rapid at `clearance` above. Lines are numbered from 1.
struct Lines {
  Vector3 start_W = Vector3::Zero();              ///< of the first line
  Vector3 along_W = Vector3::UnitX() * 10e-3;     ///< direction and length of a line, m
  Vector3 step_over_W = Vector3::UnitY() * 1e-3;  ///< from one line to the next, m
  int count = 1;
  double clearance = 5e-3;  ///< m
};
ToolPath lines(const Lines& lines, const CutSettings& cut);

/// The same lines cut to and fro, with the step between them as a cut.
ToolPath zigzag(const Lines& lines, const CutSettings& cut);

/// The path moved rigidly: p_W' = X * p_W, axes turned along.
ToolPath transformed(const ToolPath& path, const geometry::Pose& X);

/// Points of an arc about an axis through `centre`, from `from`, turning by `angle` (rad,
/// right-hand about `axis`) while it advances by `rise` along the axis; chords stay within
/// `chord_error` of the arc. The first point is `from`.
std::vector<Vector3> arc(const Vector3& from, const Vector3& centre, const Vector3& axis,
                         double angle, double rise, double chord_error);

}  // namespace osteomill::workpiece
