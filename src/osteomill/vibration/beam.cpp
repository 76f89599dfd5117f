// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/vibration/beam.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"

namespace osteomill::vibration {
namespace {

struct Ring {
  double area = 0.0;
  double inertia = 0.0;     ///< second moment of area
  double shear_area = 0.0;  ///< κ A
};

Ring ring(double outer, double inner, double nu) {
  if (outer <= 0.0) return {};
  Ring result;
  result.area = std::numbers::pi / 4.0 * (outer * outer - inner * inner);
  result.inertia = std::numbers::pi / 64.0 * (std::pow(outer, 4) - std::pow(inner, 4));
  const double m = inner / outer;
  const double a = (1.0 + m * m) * (1.0 + m * m);
  result.shear_area =
      result.area * 6.0 * (1.0 + nu) * a / ((7.0 + 6.0 * nu) * a + (20.0 + 12.0 * nu) * m * m);
  return result;
}

/// The supports hold the beam when neither translation nor rotation about any point is free.
bool is_held(const Beam& beam) {
  double first_held = 0.0;
  int positions = 0;
  for (const Support& support : beam.supports) {
    if (support.type == SupportType::clamp) return true;
    if (support.type == SupportType::spring) {
      if (support.stiffness > 0.0 && support.rotational_stiffness > 0.0) return true;
      if (support.stiffness <= 0.0) continue;
    }
    if (positions == 0) first_held = support.position;
    if (positions == 0 || support.position != first_held) ++positions;
  }
  if (positions >= 2) return true;
  const bool turning_held =
      std::any_of(beam.supports.begin(), beam.supports.end(), [](const Support& support) {
        return support.type == SupportType::spring && support.rotational_stiffness > 0.0;
      });
  return positions == 1 && turning_held;
}

}  // namespace

void check(const Beam& beam) {
  std::vector<Fault> faults;
  const auto expect = [&](bool good, std::string field, double value, const char* unit,
                          const char* rule) {
    if (!good) faults.push_back({std::move(field), fmt::format("{:g} {}", value, unit), rule, ""});
  };
  expect(beam.youngs_modulus > 0.0, "beam.youngs_modulus_gpa", beam.youngs_modulus / units::gpa,
         "GPa", "must be > 0");
  expect(beam.density > 0.0, "beam.density_kg_per_m3", beam.density, "kg/m3", "must be > 0");
  expect(beam.poissons_ratio >= 0.0 && beam.poissons_ratio < 0.5, "beam.poissons_ratio",
         beam.poissons_ratio, "", "must lie in 0 ... 0.5");
  if (beam.segments.empty()) {
    faults.push_back({"beam.segments", "", "at least one segment is needed",
                      "add segments = [ { length_mm = ..., diameter_mm = ... } ]"});
  }
  for (std::size_t i = 0; i < beam.segments.size(); ++i) {
    const BeamSegment& s = beam.segments[i];
    const std::string name = fmt::format("beam.segments[{}].", i);
    expect(s.length > 0.0, name + "length_mm", s.length / units::mm, "mm", "must be > 0");
    expect(s.diameter > 0.0, name + "diameter_mm", s.diameter / units::mm, "mm", "must be > 0");
    expect(s.inner_diameter >= 0.0 && s.inner_diameter < s.diameter * s.effective_diameter_factor,
           name + "inner_diameter_mm", s.inner_diameter / units::mm, "mm",
           "must be >= 0 and below the effective outer diameter");
    expect(s.effective_diameter_factor > 0.0 && s.effective_diameter_factor <= 1.0,
           name + "effective_diameter_factor", s.effective_diameter_factor, "",
           "must lie in 0 ... 1");
    expect(s.tube_inner_diameter >= 0.0 &&
               (s.tube_outer_diameter == 0.0 ? s.tube_inner_diameter == 0.0
                                             : s.tube_inner_diameter < s.tube_outer_diameter),
           name + "tube_inner_diameter_mm", s.tube_inner_diameter / units::mm, "mm",
           "must be >= 0 and below tube_outer_diameter_mm");
  }
  const double end = length(beam);
  for (std::size_t i = 0; i < beam.supports.size(); ++i) {
    const Support& s = beam.supports[i];
    const std::string name = fmt::format("beam.supports[{}].", i);
    expect(s.position >= 0.0 && s.position <= end * (1.0 + 1e-12), name + "at_mm",
           s.position / units::mm, "mm", "must lie on the beam");
    expect(s.stiffness >= 0.0, name + "stiffness_n_per_mm", s.stiffness * units::mm, "N/mm",
           "must be >= 0");
    expect(s.rotational_stiffness >= 0.0, name + "rotational_stiffness_nm_per_rad",
           s.rotational_stiffness, "N m/rad", "must be >= 0");
  }
  if (faults.empty() && !is_held(beam)) {
    faults.push_back({"beam.supports", "", "the supports do not hold the beam: it can move or turn",
                      "add a clamp, or two pins or springs at different places"});
  }
  if (!faults.empty()) throw InvalidInput(std::move(faults));
}

double length(const Beam& beam) {
  double sum = 0.0;
  for (const BeamSegment& segment : beam.segments) sum += segment.length;
  return sum;
}

Section section(const Beam& beam, const BeamSegment& segment) {
  const double nu = beam.poissons_ratio;
  const Ring shaft =
      ring(segment.diameter * segment.effective_diameter_factor, segment.inner_diameter, nu);
  const Ring tube = ring(segment.tube_outer_diameter, segment.tube_inner_diameter, nu);
  const double shear_modulus = beam.youngs_modulus / (2.0 * (1.0 + nu));
  return {.bending_stiffness = beam.youngs_modulus * (shaft.inertia + tube.inertia),
          .mass_per_length = beam.density * (shaft.area + tube.area),
          .rotary_inertia = beam.density * (shaft.inertia + tube.inertia),
          .shear_stiffness = shear_modulus * (shaft.shear_area + tube.shear_area)};
}

std::vector<double> stations(const Beam& beam) {
  std::vector<double> all{0.0};
  double x = 0.0;
  for (const BeamSegment& segment : beam.segments) all.push_back(x += segment.length);
  const double end = x;
  for (const Support& support : beam.supports) all.push_back(std::min(support.position, end));
  std::sort(all.begin(), all.end());
  const double same = 1e-9 * end;  // closer than this is one place: far below any manufacture
  std::vector<double> kept;
  for (const double position : all) {
    if (kept.empty() || position - kept.back() > same) kept.push_back(position);
  }
  return kept;
}

Section section_at(const Beam& beam, double x) {
  double end = 0.0;
  for (const BeamSegment& segment : beam.segments) {
    end += segment.length;
    if (x < end * (1.0 - 1e-12)) return section(beam, segment);
  }
  return section(beam, beam.segments.back());
}

}  // namespace osteomill::vibration
