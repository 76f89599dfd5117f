// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/workpiece/phantoms.hpp"

#include <algorithm>
#include <cmath>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"

namespace osteomill::workpiece {

namespace {

/// Signed distance to the box, < 0 inside.
double box_distance(const Vector3& p, const Vector3& lower, const Vector3& upper) {
  const Vector3 outside = (lower - p).cwiseMax(p - upper);
  return outside.cwiseMax(0.0).norm() + std::min(0.0, outside.maxCoeff());
}

geometry::GridShape with_margin(const Vector3& lower, const Vector3& upper, double spacing,
                                double margin) {
  // Whole voxels of margin, so that the faces of the bone stay on faces of voxels.
  require_non_negative("stock.margin_mm", margin / units::mm, "mm");
  const Vector3 around = Vector3::Constant(std::ceil(margin / spacing - 1e-6) * spacing);
  return cubes_over(lower - around, upper + around, spacing);
}

}  // namespace

Stock block(const Vector3& lower_W, const Vector3& upper_W, const BoneMaterial& material,
            double spacing, double margin) {
  return Stock(with_margin(lower_W, upper_W, spacing, margin), [&](const Vector3& p_W) {
    return BoneSample{box_distance(p_W, lower_W, upper_W), material};
  });
}

Stock tibia_section(const TibiaSection& section, double spacing, double margin) {
  require_positive("stock.length_mm", section.length / units::mm, "mm");
  require_positive("stock.width_mm", section.width / units::mm, "mm");
  require_positive("stock.height_mm", section.height / units::mm, "mm");
  require_non_negative("stock.graded_mm", section.graded / units::mm, "mm");
  require_within("stock.rim_mm", section.rim / units::mm, 0.0,
                 0.5 * std::min(section.length, section.width) / units::mm, "mm");
  const Vector3 lower(0.0, 0.0, -section.height), upper(section.length, section.width, 0.0);
  return Stock(with_margin(lower, upper, spacing, margin), [&](const Vector3& p_W) {
    BoneSample sample;
    sample.signed_distance = box_distance(p_W, lower, upper);
    const double from_side = std::min(std::min(p_W.x(), section.length - p_W.x()),
                                      std::min(p_W.y(), section.width - p_W.y()));
    const double inside_rim = from_side - section.rim;
    double cancellous = inside_rim > 0.0 ? 1.0 : 0.0;
    if (section.graded > 0.0) cancellous = std::clamp(inside_rim / section.graded, 0.0, 1.0);
    // A thousand steps across the graded zone keep the palette small.
    cancellous = std::round(1000.0 * cancellous) / 1000.0;
    const auto blend = [&](double a, double b) { return a + cancellous * (b - a); };
    sample.material.density = blend(section.cortical.density, section.cancellous.density);
    sample.material.force_scale =
        blend(section.cortical.force_scale, section.cancellous.force_scale);
    return sample;
  });
}

}  // namespace osteomill::workpiece
