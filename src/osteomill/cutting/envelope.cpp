// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/cutting/envelope.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace osteomill::cutting {
namespace {

constexpr double kQuarter = std::numbers::pi / 2.0;

}  // namespace

Envelope::Envelope(const Cutter& cutter) : tan_helix_(std::tan(cutter.helix_angle)) {
  // Each part is written with its lower end; the next part's lower end is its upper one. The last
  // entry of the list is where the next part will begin.
  parts_.push_back({});
  const double full = cutter.radius;
  switch (cutter.shape) {
    case CutterShape::cylindrical:
      parts_.back().radius = full;
      break;
    case CutterShape::ball:
      add_arc(full, 0.0, kQuarter);
      break;
    case CutterShape::bull:
      parts_.back().radius = full - cutter.corner_radius;
      add_arc(cutter.corner_radius, 0.0, kQuarter);
      break;
    case CutterShape::tapered: {
      add_arc(cutter.corner_radius, 0.0, kQuarter - cutter.taper_angle);
      const Part& end = parts_.back();
      if (full > end.radius && cutter.taper_angle > 0.0) {
        add_line(full, end.z + (full - end.radius) / std::tan(cutter.taper_angle));
      }
      break;
    }
    case CutterShape::apt:
      add_apt(cutter);
      break;
    case CutterShape::profile:
      parts_.back().radius = cutter.profile.front().radius;
      for (std::size_t i = 1; i < cutter.profile.size(); ++i) {
        if (cutter.profile[i].z == 0.0) {
          parts_.back().radius = cutter.profile[i].radius;  // a flat bottom has no edges
        } else {
          add_line(cutter.profile[i].radius, cutter.profile[i].z);
        }
      }
      break;
  }
  close(cutter);
}

void Envelope::add_line(double radius, double z) {
  Part& from = parts_.back();
  from.kappa = std::atan2(z - from.z, radius - from.radius);
  const double length = std::hypot(z - from.z, radius - from.radius);
  Part next;
  next.begin = from.begin + length;
  next.radius = radius;
  next.z = z;
  parts_.push_back(next);
}

void Envelope::add_arc(double corner_radius, double from_kappa, double to_kappa) {
  Part& from = parts_.back();
  from.kappa = from_kappa;
  from.curvature = 1.0 / corner_radius;
  Part next;
  next.begin = from.begin + corner_radius * (to_kappa - from_kappa);
  next.radius = from.radius + corner_radius * (std::sin(to_kappa) - std::sin(from_kappa));
  next.z = from.z + corner_radius * (std::cos(from_kappa) - std::cos(to_kappa));
  parts_.push_back(next);
}

void Envelope::add_apt(const Cutter& cutter) {
  const AptJoints joints = apt_joints(cutter.apt, cutter.corner_radius, cutter.cutting_length);
  if (joints.lower.z > 0.0) {
    add_line(joints.lower.radius, joints.lower.z);
  } else {
    parts_.back().radius = joints.lower.radius;  // a flat bottom has no edges
  }
  if (joints.upper_kappa > joints.lower_kappa) {
    add_arc(cutter.corner_radius, joints.lower_kappa, joints.upper_kappa);
  }
  // What rounding leaves open at the joint goes to the upper line.
  if (cutter.apt.side_angle > 0.0 && cutter.cutting_length > parts_.back().z) {
    add_line(joints.top_radius, cutter.cutting_length);
  }
}

void Envelope::close(const Cutter& cutter) {
  parts_.back().kappa = kQuarter;  // the shank
  const double lead = tan_helix_ / cutter.radius;
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    Part& here = parts_[i];
    const bool last = i + 1 == parts_.size();
    const double end_radius = last ? here.radius : parts_[i + 1].radius;
    here.constant_angle =
        cutter.lead == Lead::constant_angle && here.curvature == 0.0 && here.radius > 0.0;
    here.lead = cutter.lead == Lead::constant_angle ? tan_helix_ / end_radius : lead;
    if (!last) parts_[i + 1].lag = at(std::nextafter(parts_[i + 1].begin, 0.0)).lag;
  }
}

const Envelope::Part& Envelope::part(double length) const {
  const auto above = std::upper_bound(parts_.begin() + 1, parts_.end(), length,
                                      [](double s, const Part& one) { return s < one.begin; });
  return *(above - 1);
}

ProfilePoint Envelope::at(double length) const {
  const Part& here = part(length);
  const double ds = length - here.begin;
  ProfilePoint point;
  point.kappa = here.kappa + here.curvature * ds;
  if (here.curvature == 0.0) {
    const bool upright = here.kappa == kQuarter;
    point.radius = here.radius + (upright ? 0.0 : ds * std::cos(here.kappa));
    point.z = here.z + (upright ? ds : ds * std::sin(here.kappa));
  } else {
    point.radius = here.radius + (std::sin(point.kappa) - std::sin(here.kappa)) / here.curvature;
    point.z = here.z + (std::cos(here.kappa) - std::cos(point.kappa)) / here.curvature;
  }
  double slope = tan_helix_;  // of the edge against the meridian
  if (here.constant_angle) {
    point.lag =
        here.lag + (here.kappa == kQuarter
                        ? tan_helix_ * ds / here.radius
                        : tan_helix_ * std::log(point.radius / here.radius) / std::cos(here.kappa));
  } else {
    // Along the meridian dz = sin kappa ds, and the edge turns by r dlag.
    point.lag = here.lag + here.lead * (point.z - here.z);
    slope = here.lead * point.radius * std::sin(point.kappa);
  }
  point.inclination = std::atan(slope);
  point.stretch = std::sqrt(1.0 + slope * slope);
  return point;
}

double Envelope::length_to(double z) const {
  auto above = std::upper_bound(parts_.begin() + 1, parts_.end(), z,
                                [](double height, const Part& one) { return height < one.z; });
  const Part& here = *(above - 1);
  const double dz = std::max(0.0, z - here.z);
  if (here.curvature == 0.0) return here.begin + dz / std::sin(here.kappa);
  const double cos_kappa = std::cos(here.kappa) - dz * here.curvature;
  return here.begin + (std::acos(std::clamp(cos_kappa, -1.0, 1.0)) - here.kappa) / here.curvature;
}

bool Envelope::is_cylinder(double length) const {
  const Part& here = part(length);
  return here.curvature == 0.0 && here.kappa == kQuarter;
}

std::vector<double> Envelope::joints() const {
  std::vector<double> lengths;
  for (std::size_t i = 1; i < parts_.size(); ++i) lengths.push_back(parts_[i].begin);
  return lengths;
}

std::vector<double> Envelope::where_radius_is(double radius) const {
  std::vector<double> lengths;
  for (std::size_t i = 0; i + 1 < parts_.size(); ++i) {
    const Part& here = parts_[i];
    double ds = 0.0;
    if (here.curvature == 0.0) {
      ds = (radius - here.radius) / std::cos(here.kappa);
    } else {
      const double sine = std::sin(here.kappa) + (radius - here.radius) * here.curvature;
      if (!(std::abs(sine) < 1.0)) continue;
      ds = (std::asin(sine) - here.kappa) / here.curvature;
    }
    if (ds > 0.0 && here.begin + ds < parts_[i + 1].begin) lengths.push_back(here.begin + ds);
  }
  return lengths;
}

std::vector<double> Envelope::where_kappa_is(double kappa) const {
  std::vector<double> lengths;
  for (std::size_t i = 0; i + 1 < parts_.size(); ++i) {
    const Part& here = parts_[i];
    if (here.curvature == 0.0) continue;
    const double ds = (kappa - here.kappa) / here.curvature;
    if (ds > 0.0 && here.begin + ds < parts_[i + 1].begin) lengths.push_back(here.begin + ds);
  }
  return lengths;
}

}  // namespace osteomill::cutting
