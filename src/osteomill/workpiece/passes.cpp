// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/workpiece/passes.hpp"

#include <fmt/format.h>

#include <cmath>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"

namespace osteomill::workpiece {

Lines directed(Lines lines, Milling milling) {
  const Vector3 right = lines.along_W.cross(Vector3::UnitZ());
  const double to_right = lines.step_over_W.dot(right);
  if (!(std::abs(to_right) > 1e-9 * right.norm() * lines.step_over_W.norm()))
    throw InvalidInput(
        Fault{"path.step_over_mm",
              fmt::format("({:g}, {:g}, {:g}) mm", lines.step_over_W.x() / units::mm,
                          lines.step_over_W.y() / units::mm, lines.step_over_W.z() / units::mm),
              "must lead to one side of path.along_mm: the side decides between up- and "
              "down-milling",
              "use kind = \"lines\" for lines one below the other"});
  if ((to_right > 0.0) != (milling == Milling::down)) {
    lines.start_W += lines.along_W;
    lines.along_W = -lines.along_W;
  }
  return lines;
}

ToolPath one_way(const Lines& lines, const CutSettings& cut, Milling milling) {
  return workpiece::lines(directed(lines, milling), cut);
}

ToolPath rough_and_finish(const RoughAndFinish& passes, const CutSettings& cut) {
  require_within("path.count", passes.lines.count, 1, 100000, "");
  require_non_negative("path.finish_feed_mm_per_s", passes.finish_feed / units::mm_per_s, "mm/s");
  const Lines lines = directed(passes.lines, Milling::down);
  const double finish_feed = passes.finish_feed > 0.0 ? passes.finish_feed : cut.feed_rate;
  std::vector<Move> moves;
  for (int n = 0; n < lines.count; ++n) {
    const Vector3 start = lines.start_W + n * lines.step_over_W;
    const Vector3 end = start + lines.along_W;
    Move rough{MoveKind::cut,
               {start + passes.allowance_W, end + passes.allowance_W},
               cut.feed_rate,
               cut.spindle_speed,
               2 * n + 1};
    if (n > 0) rough.points_W.insert(rough.points_W.begin(), moves.back().points_W.back());
    Move finish{MoveKind::cut,
                {rough.points_W.back(), end, start},
                finish_feed,
                cut.spindle_speed,
                2 * n + 2};
    moves.push_back(std::move(rough));
    moves.push_back(std::move(finish));
  }
  return ToolPath(std::move(moves));
}

}  // namespace osteomill::workpiece
