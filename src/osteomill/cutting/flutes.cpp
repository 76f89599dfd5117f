// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/cutting/flutes.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace osteomill::cutting {
namespace {
constexpr double kTurn = 2.0 * std::numbers::pi;
}

Flutes::Flutes(const Cutter& cutter) : errors_(cutter.radius_error), run_out_(cutter.run_out) {
  const auto count = static_cast<std::size_t>(cutter.flutes);
  double angle = 0.0;
  for (std::size_t j = 0; j < count; ++j) {
    angles_.push_back(angle);
    angle += cutter.pitch.empty() ? kTurn / static_cast<double>(count) : cutter.pitch[j];
  }
  errors_.resize(count, 0.0);
  const auto same = [](const std::vector<double>& values) {
    return std::all_of(values.begin(), values.end(),
                       [&](double value) { return value == values.front(); });
  };
  equal_ = (cutter.pitch.empty() || same(cutter.pitch)) && same(errors_) &&
           run_out_.offset == 0.0 && run_out_.tilt == 0.0;
}

double Flutes::deviation(int flute, const ProfilePoint& point) const {
  const double at = angle(flute) + point.lag;
  return errors_[static_cast<std::size_t>(flute)] +
         run_out_.offset * std::cos(run_out_.offset_angle - at) +
         run_out_.tilt * point.z * std::cos(run_out_.tilt_angle - at);
}

double Flutes::since(int flute, int before) const {
  // A flute of larger lag passes later: the one before has the smaller lag.
  const double turn = angle(flute) - angle((flute - before + count()) % count());
  return turn > 0.0 ? turn : turn + kTurn;
}

double Flutes::chip(int flute, const ProfilePoint& point, double feed_per_tooth,
                    double into) const {
  if (equal_) return feed_per_tooth * into;
  const double feed_a_turn = feed_per_tooth * count();
  const double sin_kappa = std::sin(point.kappa);
  const double own = deviation(flute, point);
  double least = std::numeric_limits<double>::infinity();
  for (int before = 1; before <= count(); ++before) {
    const int other = (flute - before + count()) % count();
    least = std::min(least, feed_a_turn * since(flute, before) / kTurn * into +
                                (own - deviation(other, point)) * sin_kappa);
  }
  return least;
}

void Flutes::chip_pieces(int flute, const std::vector<double>& deviations, double sin_kappa,
                         double feed_per_tooth, std::vector<ChipPiece>& pieces) const {
  pieces.clear();
  constexpr double kNever = std::numeric_limits<double>::infinity();
  const auto line = [&](int before) {
    const int other = (flute - before + count()) % count();
    return ChipPiece{0.0, feed_per_tooth * count() * since(flute, before) / kTurn,
                     (deviations[static_cast<std::size_t>(flute)] -
                      deviations[static_cast<std::size_t>(other)]) *
                         sin_kappa};
  };
  // The least of rising lines is concave and rises: walk from line to line, from that which is
  // least at into = 0.
  ChipPiece here = line(1);
  for (int before = 2; before <= count(); ++before) {
    const ChipPiece other = line(before);
    if (other.start < here.start || (other.start == here.start && other.rise < here.rise)) {
      here = other;
    }
  }
  while (true) {
    ChipPiece next{kNever, 0.0, 0.0};
    for (int before = 1; before <= count(); ++before) {
      ChipPiece other = line(before);
      if (!(other.rise < here.rise)) continue;
      other.from = (other.start - here.start) / (here.rise - other.rise);
      if (other.from < next.from || (other.from == next.from && other.rise < next.rise)) {
        next = other;
      }
    }
    const double begins = here.start < 0.0 ? -here.start / here.rise : 0.0;
    here.from = std::max(here.from, begins);
    if (here.rise > 0.0 && here.from < next.from) pieces.push_back(here);
    if (next.from == kNever) return;
    here = next;
  }
}

double trochoidal_chip(double radius, double feed_per_tooth, int flutes, double theta) {
  const double a = feed_per_tooth * flutes / kTurn;
  // Near the axis teeth do not outrun the feed: there is no tooth path to speak of.
  if (radius < 2.0 * feed_per_tooth) return feed_per_tooth * std::sin(theta);
  const double cosine = std::cos(theta);
  double d = 0.0;
  // Newton on a nearly linear function: d is of the order of c/r.
  for (int i = 0; i < 8; ++i) {
    const double miss = radius * std::sin(d) - (feed_per_tooth - a * d) * cosine;
    const double step = miss / (radius * std::cos(d) + a * cosine);
    d -= step;
    if (std::abs(step) < 1e-16) break;
  }
  return 2.0 * radius * std::pow(std::sin(0.5 * d), 2) + (feed_per_tooth - a * d) * std::sin(theta);
}

}  // namespace osteomill::cutting
