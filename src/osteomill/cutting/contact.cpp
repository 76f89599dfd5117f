// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/cutting/contact.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "osteomill/cutting/milling_force.hpp"

namespace osteomill::cutting {
namespace {

constexpr double kPi = std::numbers::pi;

/// Functions whose zeros along the meridian are kinks of entry or exit.
std::array<double, 5> kinks(const ProfilePoint& point, const Condition& condition,
                            const LateralBand& band) {
  const double sin_e = std::sin(condition.feed_elevation);
  const double cos_e = std::cos(condition.feed_elevation);
  const double sin_k = std::sin(point.kappa);
  const double cos_k = std::cos(point.kappa);
  // sin theta at n · f = 0, and cos theta at the edge of the band, belong to one theta.
  const auto meet = [&](double y) {
    return y * y * sin_k * sin_k * cos_e * cos_e +
           point.radius * point.radius *
               (cos_k * cos_k * sin_e * sin_e - sin_k * sin_k * cos_e * cos_e);
  };
  return {point.radius - std::abs(band.low), point.radius - std::abs(band.high),
          point.kappa - std::abs(condition.feed_elevation), meet(band.low), meet(band.high)};
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
  const std::size_t parts = ends.size() - 1;
  constexpr int kSteps = 48;
  for (std::size_t part = 0; part < parts; ++part) {
    if (envelope.is_cylinder(ends[part])) continue;
    const auto place = [&](double share) {
      return ends[part] + (ends[part + 1] - ends[part]) * share;
    };
    auto before = kinks(envelope.at(ends[part]), condition, band);
    for (int step = 1; step <= kSteps; ++step) {
      const double upper = place(static_cast<double>(step) / kSteps);
      // Just inside the part: at its very end the next one begins.
      const auto after = kinks(envelope.at(upper - 1e-12 * whole), condition, band);
      for (std::size_t k = 0; k < after.size(); ++k) {
        if ((before[k] < 0.0) == (after[k] < 0.0)) continue;
        double low = place(static_cast<double>(step - 1) / kSteps);
        double high = upper;
        for (int i = 0; i < 48; ++i) {
          const double middle = 0.5 * (low + high);
          const bool negative = kinks(envelope.at(middle), condition, band)[k] < 0.0;
          (negative == (before[k] < 0.0) ? low : high) = middle;
        }
        ends.push_back(0.5 * (low + high));
      }
      before = after;
    }
  }
  std::sort(ends.begin(), ends.end());
  ends.erase(std::unique(ends.begin(), ends.end(),
                         [&](double one, double two) { return two - one < 1e-9 * whole; }),
             ends.end());
  ends.back() = whole;
  return ends;
}

}  // namespace osteomill::cutting
