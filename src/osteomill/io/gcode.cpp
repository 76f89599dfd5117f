// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/gcode.hpp"

#include <fmt/format.h>

#include <array>
#include <cctype>
#include <charconv>
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

// Radii of an arc's start and end may differ by what a program of four decimals in inch rounds off.
constexpr double kArcMismatch = 13e-6;  // m

struct Word {
  char letter = 0;
  double value = 0.0;
  std::string text;  ///< as written
};

/// A line's words with comments taken out; throws InvalidInput without a place.
std::vector<Word> words_of(std::string_view line) {
  std::vector<Word> words;
  std::size_t at = 0;
  while (at < line.size()) {
    const char c = line[at];
    if (c == ';') break;
    if (c == '(') {
      const std::size_t end = line.find(')', at);
      if (end == std::string_view::npos)
        throw InvalidInput(Fault{"comment", std::string(line.substr(at)), "must end with )", ""});
      at = end + 1;
      continue;
    }
    if (std::isspace(static_cast<unsigned char>(c)) != 0) {
      ++at;
      continue;
    }
    const std::size_t start = at++;
    const char letter = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
    while (at < line.size() && line[at] == ' ') ++at;
    if (at < line.size() && line[at] == '+') ++at;
    double value = 0.0;
    const auto [end, error] = std::from_chars(line.data() + at, line.data() + line.size(), value,
                                              std::chars_format::fixed);
    const std::size_t length = static_cast<std::size_t>(end - line.data());
    if (letter < 'A' || letter > 'Z' || error != std::errc{} || !std::isfinite(value))
      throw InvalidInput(
          Fault{"word", std::string(line.substr(start, 20)), "must be a letter with a number", ""});
    at = length;
    words.push_back({letter, value, std::string(line.substr(start, at - start))});
  }
  return words;
}

/// The words of one line by what they set; every one at most once.
struct Block {
  std::optional<int> motion, plane, units, distance, spindle;
  bool end = false;
  std::array<std::optional<double>, 26> values;  ///< X Y Z I J K R F S
  std::optional<double>& value(char letter) {
    return values[static_cast<std::size_t>(letter - 'A')];
  }
  bool has_any(std::string_view letters) const {
    for (char letter : letters)
      if (values[static_cast<std::size_t>(letter - 'A')]) return true;
    return false;
  }
};

[[noreturn]] void refuse(const std::string& field, const std::string& value,
                         const std::string& rule, const std::string& remedy = "") {
  throw InvalidInput(Fault{field, value, rule, remedy});
}

void set_once(std::optional<int>& group, const Word& word) {
  if (group) refuse("word", word.text, "must not stand in a line with another of its group");
  group = static_cast<int>(word.value);
}

Block block_of(const std::vector<Word>& words) {
  Block block;
  for (const Word& word : words) {
    const double code = word.value;
    if (word.letter == 'N') continue;
    if (word.letter == 'G') {
      if (code == 0.0 || code == 1.0 || code == 2.0 || code == 3.0) {
        set_once(block.motion, word);
      } else if (code == 17.0 || code == 18.0 || code == 19.0) {
        set_once(block.plane, word);
      } else if (code == 20.0 || code == 21.0) {
        set_once(block.units, word);
      } else if (code == 90.0 || code == 91.0) {
        set_once(block.distance, word);
      } else if (code != 40.0 && code != 49.0 && code != 54.0 && code != 61.0 && code != 64.0 &&
                 code != 80.0 && code != 91.1 && code != 94.0) {
        refuse("word", word.text, "is not a G word of the subset",
               "allowed: G0-G3, G17-G19, G20, G21, G90, G91");
      }
    } else if (word.letter == 'M') {
      if (code == 3.0 || code == 5.0)
        set_once(block.spindle, word);
      else if (code == 2.0 || code == 30.0)
        block.end = true;
      else
        refuse("word", word.text, "is not an M word of the subset", "allowed: M3, M5, M2, M30");
    } else if (std::string_view("XYZIJKRFS").find(word.letter) != std::string_view::npos) {
      if (block.value(word.letter)) refuse("word", word.text, "must stand once in a line");
      block.value(word.letter) = word.value;
    } else {
      refuse("word", word.text, "is not a word of the subset",
             "allowed letters: G M N X Y Z I J K R F S");
    }
  }
  return block;
}

class Reader {
 public:
  explicit Reader(const GcodeOptions& options) : options_(options) {}

  /// Returns false at the end of the program.
  bool read(std::string_view line, int number) {
    const std::vector<Word> words = words_of(line);
    Block block = block_of(words);
    if (block.units) unit_ = *block.units == 20 ? 25.4 * units::mm : units::mm;
    if (block.plane) plane_ = *block.plane;
    if (block.distance) incremental_ = *block.distance == 91;
    if (block.motion) motion_ = *block.motion;
    if (const auto feed = block.value('F')) {
      if (!(*feed > 0.0)) refuse("F", fmt::format("{}", *feed), "must be > 0");
      feed_rate_ = *feed * unit_ / units::minute;
    }
    if (const auto speed = block.value('S')) {
      if (!(*speed >= 0.0)) refuse("S", fmt::format("{}", *speed), "must be >= 0");
      speed_ = *speed * units::rpm;
    }
    if (block.spindle) turning_ = *block.spindle == 3;
    if (block.has_any("XYZ") || (block.has_any("IJKR") && motion_ && *motion_ >= 2))
      move(block, number);
    else if (block.has_any("IJKR"))
      refuse("word", "I, J, K or R", "belong to G2 and G3");
    return !block.end;
  }

  std::vector<Move> take_moves() { return std::move(moves_); }

 private:
  void move(Block& block, int number) {
    if (!motion_) refuse("motion", "none", "must be set by G0, G1, G2 or G3 before a coordinate");
    if (*motion_ < 2 && block.has_any("IJKR"))
      refuse("word", "I, J, K or R", "belong to G2 and G3");
    const Vector3 start = position_;
    const std::array<bool, 3> known_before = known_;
    for (int axis = 0; axis < 3; ++axis) {
      const auto value = block.value(static_cast<char>('X' + axis));
      if (!value) continue;
      const auto a = static_cast<std::size_t>(axis);
      if (incremental_ && !known_[a])
        refuse("G91", fmt::format("{}{}", static_cast<char>('X' + axis), *value),
               "needs a position to count from", "name it with G90 first");
      position_[axis] = *value * unit_ + (incremental_ ? position_[axis] : 0.0);
      known_[a] = true;
    }
    const bool start_known = known_before[0] && known_before[1] && known_before[2];
    if (*motion_ == 0) {
      if (start_known) add({MoveKind::rapid, {start, position_}, 0.0, spindle(), number});
      return;
    }
    if (!start_known)
      refuse("motion", fmt::format("G{}", *motion_), "must start from a known place",
             "name X, Y and Z with G0 first");
    if (!(feed_rate_ > 0.0)) refuse("F", "none", "must be set before a cut");
    if (!(spindle() > 0.0))
      refuse("S", turning_ ? "0 rpm" : "spindle off", "must turn before a cut", "M3 S...");
    Move cut{MoveKind::cut, {start, position_}, feed_rate_, spindle(), number};
    if (*motion_ >= 2) cut.points_W = arc_points(block, start, position_);
    add(std::move(cut));
  }

  std::vector<Vector3> arc_points(Block& block, const Vector3& start, const Vector3& end) const {
    // The plane's axes u, v and the third, right-handed: G17 X Y Z, G18 Z X Y, G19 Y Z X.
    const int u = plane_ == 17 ? 0 : plane_ == 18 ? 2 : 1;
    const int v = (u + 1) % 3, w = (u + 2) % 3;
    const double du = end[u] - start[u], dv = end[v] - start[v];
    const double chord = std::hypot(du, dv);
    const double turn = *motion_ == 2 ? -1.0 : 1.0;
    Vector3 centre = start;
    if (const auto r = block.value('R')) {
      if (block.has_any("IJK")) refuse("R", fmt::format("{}", *r), "must not stand with I, J, K");
      const double radius = std::abs(*r) * unit_;
      if (chord < 1e-9)
        refuse("R", fmt::format("{}", *r), "cannot make a full circle", "use I, J, K");
      if (0.5 * chord > radius + kArcMismatch)
        refuse("R", fmt::format("{}", *r),
               fmt::format("must be at least half the chord, {:.6g}", 0.5 * chord / unit_));
      // The centre is left of the chord for the short way round counter-clockwise.
      const double off = std::sqrt(std::max(0.0, radius * radius - 0.25 * chord * chord)) * turn *
                         (*r > 0.0 ? 1.0 : -1.0);
      centre[u] += 0.5 * du - off * dv / chord;
      centre[v] += 0.5 * dv + off * du / chord;
    } else {
      if (!block.has_any("IJK")) refuse("arc", "no centre", "needs I, J, K or R");
      if (block.value(static_cast<char>('I' + w)))
        refuse(std::string(1, static_cast<char>('I' + w)), "set",
               fmt::format("does not lie in the plane of G{}", plane_));
      centre[u] += block.value(static_cast<char>('I' + u)).value_or(0.0) * unit_;
      centre[v] += block.value(static_cast<char>('I' + v)).value_or(0.0) * unit_;
    }
    const double r0 = std::hypot(start[u] - centre[u], start[v] - centre[v]);
    const double r1 = std::hypot(end[u] - centre[u], end[v] - centre[v]);
    if (r0 < 1e-9) refuse("arc", "radius 0", "must have a radius");
    if (std::abs(r1 - r0) > std::max(kArcMismatch, 1e-3 * r0))
      refuse("arc",
             fmt::format("radius {:.6g} at the start, {:.6g} at the end", r0 / unit_, r1 / unit_),
             "must have one radius", "check the centre and the end point");
    const double from = std::atan2(start[v] - centre[v], start[u] - centre[u]);
    const double to = std::atan2(end[v] - centre[v], end[u] - centre[u]);
    double angle = turn * (to - from);
    constexpr double circle = 2.0 * std::numbers::pi;
    // The same end point means all the way round.
    if (chord < 1e-9) angle = circle;
    while (angle <= 0.0) angle += circle;
    while (angle > circle) angle -= circle;
    std::vector<Vector3> points = workpiece::arc(start, centre, Vector3::Unit(w), turn * angle,
                                                 end[w] - start[w], options_.chord_error);
    points.back() = end;
    return points;
  }

  void add(Move move) {
    if ((move.points_W.back() - move.points_W.front()).norm() == 0.0 && move.points_W.size() == 2)
      return;
    moves_.push_back(std::move(move));
  }
  double spindle() const { return turning_ ? speed_ : 0.0; }

  GcodeOptions options_;
  double unit_ = units::mm;
  int plane_ = 17;
  bool incremental_ = false, turning_ = false;
  std::optional<int> motion_;
  double feed_rate_ = 0.0, speed_ = 0.0;
  Vector3 position_ = Vector3::Zero();
  std::array<bool, 3> known_{false, false, false};
  std::vector<Move> moves_;
};

}  // namespace

workpiece::ToolPath read_gcode(std::string_view text, const GcodeOptions& options) {
  require_positive("path.chord_error_mm", options.chord_error / units::mm, "mm");
  Reader reader(options);
  std::vector<Fault> faults;
  int number = 0;
  bool more = true;
  while (more && !text.empty()) {
    ++number;
    const std::size_t end = text.find('\n');
    std::string_view line = text.substr(0, end);
    text = end == std::string_view::npos ? std::string_view{} : text.substr(end + 1);
    if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
    if (line.find_first_not_of(" \t%") == std::string_view::npos) continue;
    try {
      more = reader.read(line, number);
    } catch (const InvalidInput& error) {
      for (Fault fault : error.faults()) {
        fault.location = fmt::format("{}:{}", options.file_name, number);
        faults.push_back(std::move(fault));
      }
    }
  }
  if (!faults.empty()) throw InvalidInput(std::move(faults));
  std::vector<Move> moves = reader.take_moves();
  if (moves.empty())
    throw InvalidInput(Fault{"path", "no move",
                             "must contain a move from one known place to "
                             "another",
                             "", options.file_name});
  return workpiece::ToolPath(std::move(moves));
}

}  // namespace osteomill::io
