// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/workpiece/swing.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"

namespace osteomill::workpiece {

ToolPath swing_and_advance(const Swing& swing, const CutSettings& cut) {
  FaultList faults;
  const auto require = [&](bool holds, const char* field, double value, const char* unit,
                           const char* rule) {
    if (!holds)
      faults.gather(
          [&] { throw InvalidInput(Fault{field, fmt::format("{:g} {}", value, unit), rule, ""}); });
  };
  require(swing.first_angle < swing.last_angle, "path.last_angle_deg",
          swing.last_angle / units::deg, "deg", "must be above path.first_angle_deg");
  require(swing.last_angle - swing.first_angle < 180.0 * units::deg, "path.last_angle_deg",
          swing.last_angle / units::deg, "deg", "must be less than half a turn from the first");
  require(swing.first_insertion > 0.0, "path.first_insertion_mm", swing.first_insertion / units::mm,
          "mm", "must be > 0");
  require(swing.last_insertion >= swing.first_insertion, "path.last_insertion_mm",
          swing.last_insertion / units::mm, "mm", "must not be below path.first_insertion_mm");
  require(swing.advance > 0.0, "path.advance_mm", swing.advance / units::mm, "mm", "must be > 0");
  require(swing.chord_error > 0.0, "path.chord_error_mm", swing.chord_error / units::mm, "mm",
          "must be > 0");
  const Vector3 n = swing.normal_W.normalized();
  const Vector3 f = swing.forward_W - n * n.dot(swing.forward_W);
  require(swing.normal_W.norm() > 0.0 && f.norm() > 1e-3 * swing.forward_W.norm(), "path.forward",
          0.0, "", "must not be along path.normal");
  faults.raise();

  const Vector3 x = f.normalized(), y = n.cross(x);
  const auto outwards = [&](double angle) -> Vector3 {
    return std::cos(angle) * x + std::sin(angle) * y;
  };
  std::vector<Move> moves;
  int line = 1;
  double insertion = 0.0, angle = swing.first_angle;
  const auto slide = [&](double to) {
    const Vector3 u = outwards(angle);
    moves.push_back({MoveKind::cut,
                     {swing.pivot_W + insertion * u, swing.pivot_W + to * u},
                     cut.feed_rate,
                     cut.spindle_speed,
                     line,
                     {-u, -u}});
    insertion = to;
  };
  const auto turn = [&](double to) {
    // The sagitta of a chord over the angle a is r (1 - cos(a/2)).
    const double widest = 2.0 * std::acos(1.0 - std::min(swing.chord_error / insertion, 0.5));
    const int chords = std::max(1, static_cast<int>(std::ceil(std::abs(to - angle) / widest)));
    Move move{MoveKind::cut, {}, cut.feed_rate, cut.spindle_speed, line, {}};
    for (int k = 0; k <= chords; ++k) {
      const Vector3 u = outwards(angle + (to - angle) * k / chords);
      move.points_W.push_back(swing.pivot_W + insertion * u);
      move.axes_W.push_back(-u);
    }
    moves.push_back(std::move(move));
    angle = to;
  };
  // A millionth of a groove is rounding.
  const int swings =
      1 + static_cast<int>(
              std::ceil((swing.last_insertion - swing.first_insertion) / swing.advance - 1e-6));
  require_within("path.swings", swings, 1, 10000, "");
  for (line = 1; line <= swings; ++line) {
    slide(std::min(swing.first_insertion + (line - 1) * swing.advance, swing.last_insertion));
    const double other = angle == swing.first_angle ? swing.last_angle : swing.first_angle;
    const double here = angle;
    turn(other);
    if (swing.there_and_back) turn(here);
  }
  return ToolPath(std::move(moves));
}

}  // namespace osteomill::workpiece
