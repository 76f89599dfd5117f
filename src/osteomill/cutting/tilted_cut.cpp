// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/cutting/tilted_cut.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/cutting/envelope.hpp"

namespace osteomill::cutting {
namespace {

using geometry::Vector3;
constexpr double kTurn = 2.0 * std::numbers::pi;

Vector3 on_envelope(const ProfilePoint& point, double theta) {
  return {point.radius * std::sin(theta), point.radius * std::cos(theta), point.z};
}

/// The bone: below a plane, and within a band across the feed.
struct Bone {
  Vector3 normal_T;  ///< of the surface, out of the bone
  Vector3 across_T;  ///< in the surface, across the feed: +y when nothing leans
  double top = 0.0;  ///< normal · p of the surface
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();

  bool below_surface(const Vector3& p) const { return normal_T.dot(p) < top; }
  bool holds(const Vector3& p) const {
    const double y = across_T.dot(p);
    return below_surface(p) && y >= low && y <= high;
  }
};

template <class Visitor>
void over_envelope(const Envelope& envelope, double height, Visitor visit) {
  constexpr int kSteps = 400, kAngles = 360;
  const double whole = envelope.length_to(height);
  for (int i = 0; i <= kSteps; ++i) {
    const ProfilePoint point = envelope.at(whole * i / kSteps);
    for (int k = 0; k < kAngles; ++k) visit(on_envelope(point, kTurn * k / kAngles));
  }
}

Bone bone_of(const TiltedCut& cut, const Cutter& cutter, const Envelope& envelope) {
  Bone bone;
  const Vector3 leaning(-std::sin(cut.lead), 0.0, std::cos(cut.lead));
  bone.normal_T = std::cos(cut.tilt) * leaning - std::sin(cut.tilt) * Vector3::UnitY();
  const Vector3 feed(std::cos(cut.lead), 0.0, std::sin(cut.lead));
  bone.across_T = bone.normal_T.cross(feed);
  double deepest = std::numeric_limits<double>::infinity();
  over_envelope(envelope, cutter.cutting_length,
                [&](const Vector3& p) { deepest = std::min(deepest, bone.normal_T.dot(p)); });
  bone.top = deepest + cut.depth;
  if (cut.kind == ImmersionKind::slot) return bone;
  double least = std::numeric_limits<double>::infinity();
  double most = -least;
  over_envelope(envelope, cutter.cutting_length, [&](const Vector3& p) {
    if (!bone.below_surface(p)) return;
    least = std::min(least, bone.across_T.dot(p));
    most = std::max(most, bone.across_T.dot(p));
  });
  if (cut.kind == ImmersionKind::up) bone.low = most - cut.radial_depth;
  if (cut.kind == ImmersionKind::down) bone.high = least + cut.radial_depth;
  return bone;
}

}  // namespace

void check(const TiltedCut& cut, const Cutter& cutter) {
  require_within("cut.lead_deg", cut.lead / units::deg, -60.0, 60.0, "deg");
  require_within("cut.tilt_deg", cut.tilt / units::deg, -60.0, 60.0, "deg");
  require_positive("cut.axial_depth_mm", cut.depth / units::mm, "mm");
  if (cut.kind != ImmersionKind::slot) {
    require_positive("cut.radial_depth_mm", cut.radial_depth / units::mm, "mm");
  }
  const Envelope envelope(cutter);
  const Bone bone = bone_of(cut, cutter, envelope);
  const ProfilePoint top = envelope.at(envelope.length_to(cutter.cutting_length));
  for (int k = 0; k < 360; ++k) {
    if (bone.holds(on_envelope(top, kTurn * k / 360.0))) {
      throw InvalidInput(Fault{"cut.axial_depth_mm", std::to_string(cut.depth / units::mm) + " mm",
                               "puts the cutter deeper than its cutting length of " +
                                   std::to_string(cutter.cutting_length / units::mm) + " mm",
                               "lower the depth or the lean, or set cutter.cutting_length_mm"});
    }
  }
}

Condition condition_of(const TiltedCut& cut, Condition condition) {
  condition.feed_elevation = cut.lead;
  return condition;
}

Engagement engagement_of(const TiltedCut& cut, const Cutter& cutter, const Condition& condition,
                         int angles, int slices) {
  const Envelope envelope(cutter);
  const Bone bone = bone_of(cut, cutter, envelope);
  double height = 0.0;
  over_envelope(envelope, cutter.cutting_length, [&](const Vector3& p) {
    if (bone.holds(p)) height = std::max(height, p.z());
  });
  const Vector3 feed = feed_direction(condition);
  Engagement map{
      slices, angles, std::max(height, 1e-3 * cut.depth) * (1.0 + 1.0 / slices) / slices,
      std::vector<double>(static_cast<std::size_t>(slices) * static_cast<std::size_t>(angles))};
  constexpr int kPoints = 4;
  for (int slice = 0; slice < slices; ++slice) {
    for (int i = 0; i < kPoints; ++i) {
      const double z = map.slice_height * (slice + (i + 0.5) / kPoints);
      const ProfilePoint point = envelope.at(envelope.length_to(z));
      for (int angle = 0; angle < angles * kPoints; ++angle) {
        const double theta = kTurn * (angle + 0.5) / (angles * kPoints);
        if (bone.holds(on_envelope(point, theta)) &&
            outward_normal(theta, point.kappa).dot(feed) > 0.0) {
          map.at(slice, angle / kPoints) += 1.0 / (kPoints * kPoints);
        }
      }
    }
  }
  return map;
}

Prediction predict(const Cutter& cutter, const CuttingLaw& law, const Condition& level,
                   const TiltedCut& cut, const PredictionOptions& options) {
  const Condition condition = condition_of(cut, level);
  return predict(cutter, law, condition, engagement_of(cut, cutter, condition), options);
}

}  // namespace osteomill::cutting
