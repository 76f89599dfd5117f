// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/simulate/line_profile.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"

namespace osteomill::simulate {
namespace {

constexpr int kArcPoints = 40;
constexpr double kTableSpacing = 2e-6;  // m; 1/600 of the shortest zone of the Sugita cases

/// How far ahead of the axis the midpoints of the arc of contact are.
std::array<double, kArcPoints> arc_offsets(const LineProfile& profile) {
  std::array<double, kArcPoints> offsets{};
  for (int i = 0; i < kArcPoints; ++i) {
    const double u = (i + 0.5) / kArcPoints;
    const double cosine = 1.0 - u * profile.radial_depth / profile.cutter_radius;
    offsets[i] = profile.cutter_radius * std::sqrt(1.0 - cosine * cosine);
  }
  return offsets;
}

bool holds(const ProfileZone& zone, int line, double x) {
  return x >= zone.from && x <= zone.to &&
         (zone.lines.empty() ||
          std::find(zone.lines.begin(), zone.lines.end(), line + 1) != zone.lines.end());
}

double variation_at(const LineProfile& profile, int line, double x) {
  if (profile.variation.empty()) return 1.0;
  const std::vector<double>& factors = profile.variation[line];
  const double last = static_cast<double>(factors.size() - 1);
  const double place = std::clamp(x / profile.variation_spacing, 0.0, last);
  const std::size_t low = std::min(static_cast<std::size_t>(place), factors.size() - 2);
  const double part = place - static_cast<double>(low);
  return (1.0 - part) * factors[low] + part * factors[low + 1];
}

}  // namespace

void check(const LineProfile& profile) {
  require_within("stock.lines", profile.lines, 1, 1000, "");
  require_positive("stock.line_length_mm", profile.line_length / units::mm, "mm");
  require_non_negative("stock.lead_in_mm", profile.lead_in / units::mm, "mm");
  require_non_negative("stock.lead_out_mm", profile.lead_out / units::mm, "mm");
  require_positive("cutter.diameter_mm", profile.cutter_radius / units::mm, "mm");
  require_within("stock.radial_depth_mm", profile.radial_depth / units::mm, 1e-6,
                 profile.cutter_radius / units::mm, "mm");
  require_positive("stock.axial_depth_mm", profile.axial_depth / units::mm, "mm");
  require_within("cutter.flutes", profile.flutes, 1, 64, "");
  require_within("stock.peak_to_mean", profile.peak_to_mean, 1.0, 2.0, "");
  require_non_negative("stock.edge_force_n", profile.edge_force, "N");
  require_positive("path.feed_mm_per_s", profile.programmed_feed / units::mm_per_s, "mm/s");
  if (profile.zones.empty()) {
    throw InvalidInput(Fault{"stock.zones", "", "must have at least one zone", ""});
  }
  for (std::size_t i = 0; i < profile.zones.size(); ++i) {
    const ProfileZone& zone = profile.zones[i];
    const std::string name = fmt::format("stock.zones[{}]", i);
    if (!(zone.to > zone.from)) {
      throw InvalidInput(Fault{name + ".to_mm", fmt::format("{:g} mm", zone.to / units::mm),
                               fmt::format("must be > from_mm = {:g} mm", zone.from / units::mm),
                               ""});
    }
    require_non_negative((name + ".gain_n_per_mm_per_s").c_str(), zone.gain / 1e3, "N/(mm/s)");
    if (zone.gain_end) {
      require_non_negative((name + ".gain_end_n_per_mm_per_s").c_str(), *zone.gain_end / 1e3,
                           "N/(mm/s)");
    }
    for (const int line : zone.lines) {
      require_within((name + ".lines").c_str(), line, 1, profile.lines, "");
    }
  }
  if (!profile.variation.empty() &&
      (profile.variation.size() != static_cast<std::size_t>(profile.lines) ||
       std::any_of(profile.variation.begin(), profile.variation.end(),
                   [](const auto& factors) { return factors.size() < 2; }))) {
    throw InvalidInput(
        Fault{"stock.variation", "", "must have two or more factors for each line", ""});
  }
}

double contact_lead(const LineProfile& profile) {
  const double behind = profile.cutter_radius - profile.radial_depth;
  return std::sqrt(profile.cutter_radius * profile.cutter_radius - behind * behind);
}

double cross_section(const LineProfile& profile) {
  const double radius = profile.cutter_radius;
  const double wall = radius - profile.radial_depth;  // from the axis
  const double lead = contact_lead(profile);
  // Ball: heights u = R - z below the equator, silhouette sqrt(R² - u²) beyond the wall.
  const auto integral = [&](double u) {
    return 0.5 *
               (u * std::sqrt(radius * radius - u * u) + radius * radius * std::asin(u / radius)) -
           wall * u;
  };
  const double low = std::clamp(radius - profile.axial_depth, 0.0, lead);
  const double shank = std::max(0.0, profile.axial_depth - radius);
  return integral(lead) - integral(low) + profile.radial_depth * shank;
}

double gain_at(const LineProfile& profile, int line, double x) {
  if (x < 0.0 || x > profile.line_length) return 0.0;
  for (auto zone = profile.zones.rbegin(); zone != profile.zones.rend(); ++zone) {
    if (!holds(*zone, line, x)) continue;
    const double part = (x - zone->from) / (zone->to - zone->from);
    const double end = zone->gain_end.value_or(zone->gain);
    return (zone->gain + part * (end - zone->gain)) * variation_at(profile, line, x);
  }
  return 0.0;
}

double smeared_gain(const LineProfile& profile, int line, double x) {
  double sum = 0.0;
  for (const double offset : arc_offsets(profile)) sum += gain_at(profile, line, x + offset);
  return sum / kArcPoints;
}

LineProfileWorkpiece::LineProfileWorkpiece(LineProfile profile) : profile_(std::move(profile)) {
  check(profile_);
  lead_ = contact_lead(profile_);
  section_ = cross_section(profile_);
  const std::array<double, kArcPoints> offsets = arc_offsets(profile_);
  const auto count = static_cast<std::size_t>((lead_ + profile_.line_length) / kTableSpacing) + 2;
  table_.resize(profile_.lines);
  for (int line = 0; line < profile_.lines; ++line) {
    table_[line].resize(count);
    for (std::size_t i = 0; i < count; ++i) {
      const double x = -lead_ + static_cast<double>(i) * kTableSpacing;
      Sample& sample = table_[line][i];
      for (const double offset : offsets) {
        sample.gain += gain_at(profile_, line, x + offset) / kArcPoints;
        const bool inside = x + offset >= 0.0 && x + offset <= profile_.line_length;
        sample.share += inside ? 1.0 / kArcPoints : 0.0;
      }
    }
  }
}

double LineProfileWorkpiece::pitch() const {
  return lead_ + profile_.lead_in + profile_.line_length + profile_.lead_out;
}

double LineProfileWorkpiece::length() const { return profile_.lines * pitch(); }

Place LineProfileWorkpiece::at(double position) const {
  Place place;
  // A picometre further, so that the rounded end of a line belongs to the next one.
  place.line = std::clamp(static_cast<int>((position + 1e-12) / pitch()), 0, profile_.lines - 1);
  const double x = position - place.line * pitch() - lead_ - profile_.lead_in;
  place.tip_W = geometry::Vector3(x, profile_.radial_depth - profile_.cutter_radius,
                                  -(place.line + 1) * profile_.axial_depth);
  place.direction_W = geometry::Vector3::UnitX();
  place.programmed_feed = profile_.programmed_feed;
  return place;
}

double LineProfileWorkpiece::to_contact(double position) const {
  const Place place = at(position);
  const double past = place.tip_W.x() + lead_;
  const double next = pitch() - past;
  return place.line + 1 < profile_.lines && next < past ? next : -past;
}

double LineProfileWorkpiece::to_engagement(double position) const {
  return to_contact(position) + lead_;
}

double LineProfileWorkpiece::next_start(double from, double to) const {
  const double line_end = (at(from).line + 1) * pitch();
  return std::min(to, line_end);
}

LineProfileWorkpiece::Sample LineProfileWorkpiece::sample(int line, double x) const {
  const double place = (x + lead_) / kTableSpacing;
  if (place < 0.0 || x > profile_.line_length) return {};
  return table_[line][static_cast<std::size_t>(place + 0.5)];
}

void LineProfileWorkpiece::mill(const Motion& motion, Cut& cut) {
  const Place start = at(motion.from);
  double x = start.tip_W.x();
  const double chip =
      profile_.spindle_speed > 0.0 ? profile_.spindle_speed / motion.spindle_speed : 1.0;
  double gains = 0.0;
  int touching = 0;
  for (std::size_t i = 0; i < motion.positions.size(); ++i) {
    const double travelled = motion.positions[i] - (i == 0 ? motion.from : motion.positions[i - 1]);
    x += travelled;
    const Sample here = sample(start.line, x);
    const double ripple =
        1.0 + (profile_.peak_to_mean - 1.0) * std::cos(profile_.flutes * motion.angles[i]);
    const double force =
        (here.gain * chip * motion.feeds[i] + here.share * profile_.edge_force) * ripple;
    cut.forces_W[i] = geometry::Vector3(-force, 0.0, 0.0);
    cut.torques[i] = 0.0;  // the profile knows no torque
    cut.contacts[i] = x >= -lead_ && x <= profile_.line_length ? 1 : 0;
    cut.removed_volume += section_ * here.share * travelled;
    if (here.share > 0.0) {
      gains += here.gain / here.share;
      ++touching;
    }
  }
  cut.direction_W = start.direction_W;
  cut.material = touching == 0 ? 0.0 : gains / touching;
}

}  // namespace osteomill::simulate
