// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/gcode_writer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"

namespace osteomill::io {
namespace {

using geometry::Vector3;
using workpiece::Move;
using workpiece::MoveKind;

// Points that an arc was made of lie on it to rounding; those of another curve do not.
constexpr double kOnCircle = 2e-8;        // m
constexpr double kWidest = 10.0;          // m: beyond, it is a straight line
constexpr std::size_t kFewestChords = 3;  // of an arc

struct Arc {
  std::size_t last = 0;  ///< index of its last point
  int plane = 17;
  Vector3 centre = Vector3::Zero();
  bool counter_clockwise = true;
};

/// The longest arc of one plane that begins at a point.
std::optional<Arc> arc_in(const std::vector<Vector3>& points, std::size_t first, int plane,
                          double longest_sagitta) {
  if (first + kFewestChords >= points.size()) return {};
  // The plane's axes and the third, right-handed: G17 X Y Z, G18 Z X Y, G19 Y Z X.
  const int u = plane == 17 ? 0 : plane == 18 ? 2 : 1;
  const int v = (u + 1) % 3, w = (u + 2) % 3;
  const auto flat = [&](std::size_t i) { return Eigen::Vector2d(points[i][u], points[i][v]); };
  const auto cross = [](const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
    return a.x() * b.y() - a.y() * b.x();
  };
  const Eigen::Vector2d a = flat(first), b = flat(first + 1) - a, c = flat(first + 2) - a;
  const double twice = 2.0 * cross(b, c);
  if (std::abs(twice) < 1e-3 * kOnCircle * (b.norm() + c.norm())) return {};
  const Eigen::Vector2d from_a((c.y() * b.squaredNorm() - b.y() * c.squaredNorm()) / twice,
                               (b.x() * c.squaredNorm() - c.x() * b.squaredNorm()) / twice);
  const double r = from_a.norm();
  if (!(r < kWidest)) return {};
  const Eigen::Vector2d centre = a + from_a;
  const auto turn = [&](std::size_t i) {
    const Eigen::Vector2d p = flat(i) - centre, q = flat(i + 1) - centre;
    return std::atan2(cross(p, q), p.dot(q));
  };
  const double first_turn = turn(first);
  const double rise = (points[first + 1][w] - points[first][w]) / first_turn;
  Arc arc;
  arc.plane = plane;
  arc.counter_clockwise = first_turn > 0.0;
  double angle = 0.0;
  std::size_t i = first;
  while (i + 1 < points.size()) {
    const double step = turn(i);
    if (step * first_turn <= 0.0 || r * (1.0 - std::cos(0.5 * step)) > longest_sagitta ||
        std::abs((flat(i + 1) - centre).norm() - r) > kOnCircle ||
        std::abs(angle + step) > 2.0 * std::numbers::pi + 1e-9 ||
        std::abs(points[first][w] + rise * (angle + step) - points[i + 1][w]) > kOnCircle)
      break;
    angle += step;
    ++i;
  }
  if (i < first + kFewestChords) return {};
  // Almost all the way round: start and end would be taken as one point, or as none.
  const double open = 2.0 * std::numbers::pi - std::abs(angle);
  if (open > 1e-9 && open * r < 1e-6) return {};
  arc.last = i;
  arc.centre[u] = centre.x();
  arc.centre[v] = centre.y();
  arc.centre[w] = points[first][w];
  return arc;
}

std::optional<Arc> longest_arc(const std::vector<Vector3>& points, std::size_t first,
                               double longest_sagitta) {
  std::optional<Arc> longest;
  for (int plane : {17, 18, 19}) {
    const std::optional<Arc> arc = arc_in(points, first, plane, longest_sagitta);
    if (arc && (!longest || arc->last > longest->last)) longest = arc;
  }
  return longest;
}

class Writer {
 public:
  explicit Writer(const GcodeWriterOptions& options) : options_(options) {
    if (!options.comment.empty()) text_ = "(" + options.comment + ")\n";
    text_ += "G21 G90 G17 G94\n";
  }

  void add(const Move& move) {
    settings(move);
    if (first_) text_ += "G0" + place(move.points_W.front()) + "\n";
    first_ = false;
    const std::vector<Vector3>& points = move.points_W;
    std::size_t i = 0;
    while (i + 1 < points.size()) {
      const std::optional<Arc> arc = move.kind == MoveKind::cut && options_.arcs
                                         ? longest_arc(points, i, options_.longest_sagitta)
                                         : std::nullopt;
      if (arc) {
        turn(*arc, points[i], points[arc->last]);
        i = arc->last;
      } else {
        text_ += (move.kind == MoveKind::rapid ? "G0" : "G1") + place(points[++i]) + "\n";
      }
    }
  }
  std::string finish() { return text_ + "M5\nM2\n"; }

 private:
  void settings(const Move& move) {
    if (move.spindle_speed != spindle_) {
      spindle_ = move.spindle_speed;
      text_ += spindle_ > 0.0 ? fmt::format("S{:.10g} M3\n", spindle_ / units::rpm) : "M5\n";
    }
    if (move.kind == MoveKind::cut && move.feed_rate != feed_) {
      feed_ = move.feed_rate;
      text_ += fmt::format("F{:.10g}\n", feed_ / units::mm_per_min);
    }
  }
  static std::string place(const Vector3& p) {
    return fmt::format(" X{:.6f} Y{:.6f} Z{:.6f}", p.x() / units::mm, p.y() / units::mm,
                       p.z() / units::mm);
  }
  void turn(const Arc& arc, const Vector3& from, const Vector3& to) {
    if (arc.plane != plane_) text_ += fmt::format("G{}\n", arc.plane);
    plane_ = arc.plane;
    text_ += (arc.counter_clockwise ? "G3" : "G2") + place(to);
    const int w = arc.plane == 17 ? 2 : arc.plane == 18 ? 1 : 0;
    for (int k = 0; k < 3; ++k)
      if (k != w)
        text_ += fmt::format(" {}{:.6f}", static_cast<char>('I' + k),
                             (arc.centre[k] - from[k]) / units::mm);
    text_ += "\n";
  }

  GcodeWriterOptions options_;
  std::string text_;
  bool first_ = true;
  int plane_ = 17;
  double spindle_ = 0.0, feed_ = 0.0;
};

}  // namespace

std::string write_gcode(const workpiece::ToolPath& path, const GcodeWriterOptions& options) {
  if (!path.upright())
    throw InvalidInput(Fault{"path", "an axis that is not +z",
                             "must keep the tool's axis at +z for G-code of three axes",
                             "write it as CL data"});
  Writer writer(options);
  for (const Move& move : path.moves()) writer.add(move);
  return writer.finish();
}

}  // namespace osteomill::io
