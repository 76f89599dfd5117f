// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/cl_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <optional>
#include <vector>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"

namespace osteomill::io {
namespace {

using geometry::Vector3;
using workpiece::Move;
using workpiece::MoveKind;

[[noreturn]] void refuse(const std::string& field, const std::string& value,
                         const std::string& rule, const std::string& remedy = "") {
  throw InvalidInput(Fault{field, value, rule, remedy});
}

/// A statement: the word before the slash and the parts behind it, in capitals, without blanks.
struct Statement {
  std::string word;
  std::vector<std::string> parts;
};

Statement statement_of(std::string_view line) {
  Statement statement;
  std::string* to = &statement.word;
  for (char c : line) {
    if (std::isspace(static_cast<unsigned char>(c)) != 0) continue;
    if (c == '/' && statement.parts.empty()) {
      statement.parts.emplace_back();
      to = &statement.parts.back();
    } else if (c == ',' && !statement.parts.empty()) {
      statement.parts.emplace_back();
      to = &statement.parts.back();
    } else {
      to->push_back(static_cast<char>(std::toupper(static_cast<unsigned char>(c))));
    }
  }
  return statement;
}

double number(const std::string& word, const std::string& text) {
  const char* begin = text.data();
  if (!text.empty() && *begin == '+') ++begin;
  double value = 0.0;
  const auto [end, error] = std::from_chars(begin, text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || !std::isfinite(value))
    refuse(word, text, "must be a number");
  return value;
}

class Reader {
 public:
  /// Returns false at the end of the data.
  bool read(std::string_view line, int at) {
    const Statement s = statement_of(line);
    if (s.word == "FINI") return false;
    if (s.word == "GOTO" || s.word == "FROM") {
      go(s, at);
    } else if (s.word == "RAPID") {
      rapid_ = true;
    } else if (s.word == "FEDRAT") {
      feed(s);
    } else if (s.word == "SPINDL") {
      spindle(s);
    } else if (s.word == "UNITS") {
      if (s.parts.size() != 1 || (s.parts[0] != "MM" && s.parts[0] != "INCHES"))
        refuse("UNITS", s.parts.empty() ? "" : s.parts[0], "must be MM or INCHES");
      unit_ = s.parts[0] == "MM" ? units::mm : 25.4 * units::mm;
    } else if (!s.word.starts_with("PARTNO") && !s.word.starts_with("PPRINT") &&
               !s.word.starts_with("$$") && s.word != "MULTAX") {
      refuse("statement", s.word, "is not one of the subset",
             "allowed: UNITS SPINDL FEDRAT RAPID FROM GOTO MULTAX PARTNO PPRINT FINI $$");
    }
    return true;
  }
  std::vector<Move> take() { return std::move(moves_); }

 private:
  void go(const Statement& s, int at) {
    if (s.parts.size() != 3 && s.parts.size() != 6)
      refuse(s.word, fmt::format("{} numbers", s.parts.size()),
             "must have 3 numbers, or 6 with an "
             "axis");
    Vector3 to, axis = axis_;
    for (int k = 0; k < 3; ++k)
      to[k] = number(s.word, s.parts[static_cast<std::size_t>(k)]) * unit_;
    if (s.parts.size() == 6) {
      for (int k = 0; k < 3; ++k)
        axis[k] = number(s.word, s.parts[static_cast<std::size_t>(k + 3)]);
      if (!(std::abs(axis.norm() - 1.0) < 1e-3))
        refuse(s.word, fmt::format("an axis {:.4g} long", axis.norm()),
               "must have an axis of length 1, from the tip to the spindle");
      if (std::abs(axis.norm() - 1.0) > 1e-6) axis.normalize();  // what is written reads back
    }
    if (position_ && s.word == "GOTO") {
      const double turn = workpiece::angle_between(axis_, axis) / units::deg;
      if (turn > 1e-5 && to == *position_)
        refuse(s.word, fmt::format("a turn by {:.3g} deg in place", turn),
               "must move the tip while the tool turns",
               "let it turn along the move before, a RAPID above the bone for instance");
      if (turn > 179.9)
        refuse(s.word, fmt::format("an axis that flips over by {:.1f} deg", turn),
               "must turn by less than 180 deg: which way round is not said",
               "put a GOTO between them");
      Move move{rapid_ ? MoveKind::rapid : MoveKind::cut,
                {*position_, to},
                rapid_ ? 0.0 : feed_,
                spindle_,
                at,
                {}};
      if (!rapid_ && !(feed_ > 0.0)) refuse("FEDRAT", "none", "must be set before a cut");
      if (!rapid_ && !(spindle_ > 0.0)) refuse("SPINDL", "none", "must turn before a cut");
      if ((axis - Vector3::UnitZ()).norm() > 1e-12 || (axis_ - Vector3::UnitZ()).norm() > 1e-12)
        move.axes_W = {axis_, axis};
      if ((to - *position_).norm() > 0.0) moves_.push_back(std::move(move));
    }
    position_ = to;
    axis_ = axis;
    rapid_ = false;
  }
  void feed(const Statement& s) {
    if (s.parts.empty()) refuse("FEDRAT", "none", "must have a number");
    const double value = number("FEDRAT", s.parts[0]);
    if (!(value > 0.0)) refuse("FEDRAT", s.parts[0], "must be > 0");
    const std::string unit = s.parts.size() > 1 ? s.parts[1] : "MMPM";
    if (unit == "MMPM")
      feed_ = value * units::mm_per_min;
    else if (unit == "MMPS")
      feed_ = value * units::mm_per_s;
    else if (unit == "IPM")
      feed_ = value * 25.4 * units::mm_per_min;
    else
      refuse("FEDRAT", unit, "must be in MMPM, MMPS or IPM");
  }
  void spindle(const Statement& s) {
    if (s.parts.empty()) refuse("SPINDL", "none", "must have a number or OFF");
    if (s.parts[0] == "OFF") {
      spindle_ = 0.0;
      return;
    }
    spindle_ = number("SPINDL", s.parts[0]) * units::rpm;
    if (!(spindle_ >= 0.0)) refuse("SPINDL", s.parts[0], "must be >= 0");
    for (std::size_t i = 1; i < s.parts.size(); ++i)
      if (s.parts[i] != "RPM" && s.parts[i] != "CLW")
        refuse("SPINDL", s.parts[i], "must be RPM or CLW: cutters turn clockwise");
  }

  double unit_ = units::mm, feed_ = 0.0, spindle_ = 0.0;
  bool rapid_ = false;
  std::optional<Vector3> position_;
  Vector3 axis_ = Vector3::UnitZ();
  std::vector<Move> moves_;
};

}  // namespace

workpiece::ToolPath read_cl(std::string_view text, const std::string& file_name) {
  Reader reader;
  std::vector<Fault> faults;
  int at = 0;
  bool more = true;
  while (more && !text.empty()) {
    ++at;
    const std::size_t end = text.find('\n');
    const std::string_view line = text.substr(0, end);
    text = end == std::string_view::npos ? std::string_view{} : text.substr(end + 1);
    if (line.find_first_not_of(" \t\r") == std::string_view::npos) continue;
    try {
      more = reader.read(line, at);
    } catch (const InvalidInput& error) {
      for (Fault fault : error.faults()) {
        fault.location = fmt::format("{}:{}", file_name, at);
        faults.push_back(std::move(fault));
      }
    }
  }
  if (!faults.empty()) throw InvalidInput(std::move(faults));
  std::vector<Move> moves = reader.take();
  if (moves.empty())
    throw InvalidInput(
        Fault{"path", "no move", "must have two GOTO at different places", "", file_name});
  return workpiece::ToolPath(std::move(moves));
}

std::string write_cl(const workpiece::ToolPath& path) {
  const bool upright = path.upright();
  std::string text = upright ? "UNITS/MM\n" : "UNITS/MM\nMULTAX\n";
  const auto go = [&](const char* word, const Move& move, std::size_t i) {
    const Vector3 p = move.points_W[i] / units::mm;
    text += fmt::format("{}/{:.6f},{:.6f},{:.6f}", word, p.x(), p.y(), p.z());
    if (!upright) {
      Vector3 a = move.axes_W.empty() ? Vector3::UnitZ() : move.axes_W[i];
      for (double& part : a) part = std::round(part * 1e9) / 1e9 + 0.0;  // no minus before 0
      text += fmt::format(",{:.9f},{:.9f},{:.9f}", a.x(), a.y(), a.z());
    }
    text += '\n';
  };
  double feed = 0.0, spindle = 0.0;
  bool first = true;
  for (const Move& move : path.moves()) {
    if (move.spindle_speed != spindle) {
      spindle = move.spindle_speed;
      text += spindle > 0.0 ? fmt::format("SPINDL/{:.10g},RPM,CLW\n", spindle / units::rpm)
                            : "SPINDL/OFF\n";
    }
    if (move.kind == MoveKind::cut && move.feed_rate != feed) {
      feed = move.feed_rate;
      text += fmt::format("FEDRAT/{:.10g},MMPM\n", feed / units::mm_per_min);
    }
    if (first) go("FROM", move, 0);
    first = false;
    for (std::size_t i = 1; i < move.points_W.size(); ++i) {
      if (move.kind == MoveKind::rapid) text += "RAPID\n";
      go("GOTO", move, i);
    }
  }
  return text + "SPINDL/OFF\nFINI\n";
}

}  // namespace osteomill::io
