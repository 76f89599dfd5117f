// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/cutting/contact.hpp"

#include <algorithm>
#include <boost/math/tools/toms748_solve.hpp>
#include <cmath>
#include <numbers>

#include "osteomill/cutting/milling_force.hpp"

namespace osteomill::cutting {
namespace {

constexpr double kPi = std::numbers::pi;

/// Where an edge leaves the band just as its normal turns away from the feed: a function whose
/// zeros are kinks of entry or exit. sin theta at n · f = 0, and cos theta at the edge y of the
/// band, then belong to one theta.
double meet(const ProfilePoint& point, double sin_elevation, double y) {
  const double sin_k = std::sin(point.kappa);
  const double horizontal_sq = sin_k * sin_k * (1.0 - sin_elevation * sin_elevation);
  const double vertical_sq = (1.0 - sin_k * sin_k) * sin_elevation * sin_elevation;
  return y * y * horizontal_sq + point.radius * point.radius * (vertical_sq - horizontal_sq);
}

/// Roots of a smooth function that has few.
template <class Function>
void add_roots(const Function& function, double from, double to, std::vector<double>& roots) {
  constexpr int kSteps = 12;
  double low = from;
  double at_low = function(low);
  for (int step = 1; step <= kSteps; ++step) {
    const double high = from + (to - from) * step / kSteps;
    const double at_high = function(high);
    if ((at_low < 0.0) != (at_high < 0.0)) {
      std::uintmax_t iterations = 30;
      const auto [left, right] = boost::math::tools::toms748_solve(
          function, low, high, at_low, at_high, boost::math::tools::eps_tolerance<double>(40),
          iterations);
      roots.push_back(0.5 * (left + right));
    }
    low = high;
    at_low = at_high;
  }
}

}  // namespace

Arcs contact_arcs(const ProfilePoint& point, const Condition& condition, const LateralBand& band) {
  Arcs arcs;
  // n · f > 0: sin kappa sin theta cos elevation > cos kappa sin elevation.
  const double horizontal = std::sin(point.kappa) * std::cos(condition.feed_elevation);
  const double vertical = std::cos(point.kappa) * std::sin(condition.feed_elevation);
  if (horizontal < 1e-12) {
    // Straight up or down: all around or not at all.
    if (vertical >= 0.0) return arcs;
  } else if (vertical >= horizontal) {
    return arcs;
  }
  const double rise =
      horizontal < 1e-12 || vertical <= -horizontal ? -kPi / 2.0 : std::asin(vertical / horizontal);
  // The band holds r cos theta in low ... high on theta in 0 ... pi, and mirrored on -pi ... 0.
  const double from = std::acos(std::clamp(band.high / point.radius, -1.0, 1.0));
  const double to = std::acos(std::clamp(band.low / point.radius, -1.0, 1.0));
  arcs.add(std::max(from, rise), std::min(to, kPi - rise));
  if (rise < 0.0) {
    arcs.add(std::max(-to, rise), std::min(-from, kPi - rise));
    arcs.add(std::max(2.0 * kPi - to, rise), std::min(2.0 * kPi - from, kPi - rise));
  }
  return arcs;
}

double contact_margin(const ProfilePoint& point, double theta, const Condition& condition,
                      const LateralBand& band, double full_radius) {
  const double into = outward_normal(theta, point.kappa).dot(feed_direction(condition));
  const double y = point.radius * std::cos(theta) / full_radius;
  // A slot's band ends where the cutter does and must not cut off its sides.
  const double inside = std::min(band.low <= -full_radius ? 2.0 : y - band.low / full_radius,
                                 band.high >= full_radius ? 2.0 : band.high / full_radius - y);
  return std::min(into, inside);
}

std::vector<double> smooth_pieces(const Envelope& envelope, const Condition& condition,
                                  const LateralBand& band, double axial_depth) {
  const double whole = envelope.length_to(axial_depth);
  std::vector<double> ends{0.0};
  for (const double joint : envelope.joints()) {
    if (joint < whole) ends.push_back(joint);
  }
  ends.push_back(whole);
  const double shank = envelope.at(whole + envelope.length_to(1.0)).radius;
  if (condition.feed_elevation == 0.0 && band.low <= -shank && band.high >= shank) {
    return ends;  // a level slot: every contact is half a turn
  }
  std::vector<double> kinks;
  const double sides[] = {std::abs(band.low), std::abs(band.high)};
  for (const double y : sides) {
    const std::vector<double> reached = envelope.where_radius_is(y);
    kinks.insert(kinks.end(), reached.begin(), reached.end());
  }
  if (condition.feed_elevation != 0.0) {
    const std::vector<double> turned = envelope.where_kappa_is(std::abs(condition.feed_elevation));
    kinks.insert(kinks.end(), turned.begin(), turned.end());
    const double sin_elevation = std::sin(condition.feed_elevation);
    for (std::size_t part = 0; part + 1 < ends.size(); ++part) {
      if (envelope.is_cylinder(ends[part])) continue;
      for (const double y : sides) {
        if (y >= shank) continue;  // the whole cutter is on this side
        const auto function = [&](double s) { return meet(envelope.at(s), sin_elevation, y); };
        add_roots(function, ends[part], ends[part + 1] - 1e-12 * whole, kinks);
      }
    }
  }
  for (const double kink : kinks) {
    if (kink < whole) ends.push_back(kink);
  }
  std::sort(ends.begin(), ends.end());
  ends.erase(std::unique(ends.begin(), ends.end(),
                         [&](double one, double two) { return two - one < 1e-9 * whole; }),
             ends.end());
  ends.back() = whole;
  return ends;
}

}  // namespace osteomill::cutting
