// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/accuracy/tool_deflection.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/cutting/flutes.hpp"
#include "osteomill/vibration/forced_response.hpp"
#include "osteomill/vibration/linearised_cut.hpp"

namespace osteomill::accuracy {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;

/// In-plane force of all edges on one slice, N per m of height.
class SliceForce {
 public:
  SliceForce(const cutting::Cutter& cutter, const cutting::CuttingLaw& law,
             const cutting::Condition& condition, const cutting::Immersion& immersion)
      : cutter_(cutter), law_(law), condition_(condition), flutes_(cutter), envelope_(cutter) {
    const auto contact =
        vibration::contact_angles(immersion.kind, 0.5 * immersion.radial_depth / cutter.radius);
    entry_ = contact.entry;
    exit_ = contact.exit;
  }

  bool equal_flutes() const { return flutes_.equal(); }

  Eigen::Vector2d operator()(double rotation, double height) const {
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    const cutting::ProfilePoint point = envelope_.at(height);
    for (int j = 0; j < cutter_.flutes; ++j) {
      const double turned = rotation - flutes_.angle(j) - point.lag;
      double theta = turned - kTurn * std::floor(turned / kTurn);
      // Both ends of the contact count as in it, as the edge that makes the wall stands there.
      constexpr double same = 1e-9;
      if (kTurn - theta < same) theta = 0.0;
      if (theta < entry_ - same || theta > exit_ + same) continue;
      // At the wall the chip is nothing, not the rounding of sin π.
      const bool nothing = theta < same || std::abs(theta - std::numbers::pi) < same;
      const double into = nothing ? 0.0 : std::max(0.0, std::sin(theta));
      const double h = flutes_.chip(j, point, condition_.feed_per_tooth, into);
      sum += cutting::edge_force(law_, std::max(0.0, h), condition_.fibre_T, cutting::motion(theta),
                                 cutting::outward_normal(theta, point.kappa), point)
                 .head<2>();
    }
    return sum;
  }

 private:
  const cutting::Cutter& cutter_;
  const cutting::CuttingLaw& law_;
  const cutting::Condition& condition_;
  cutting::Flutes flutes_;
  cutting::Envelope envelope_;
  double entry_ = 0.0, exit_ = 0.0;
};

void check_cut(const cutting::Cutter& cutter, const cutting::CuttingLaw& law,
               const cutting::Condition& condition, const cutting::Immersion& immersion) {
  check(cutter);
  check(condition, cutter);
  check(immersion, cutter);
  check(law);
  if (cutter.shape != cutting::CutterShape::cylindrical) {
    throw InvalidInput(Fault{"cutter.shape", "not cylindrical",
                             "deflection and surface error are worked out for cylindrical cutters",
                             "use shape = \"cylindrical\""});
  }
}

}  // namespace

void check_static_cut(const ToolCompliance& tool, const cutting::Cutter& cutter,
                      const cutting::CuttingLaw& law, const cutting::Condition& condition,
                      const cutting::Immersion& immersion, const DeflectionOptions& options) {
  check_cut(cutter, law, condition, immersion);
  require_positive("options.slice_height_mm", options.slice_height / units::mm, "mm");
  require_within("options.steps", options.steps, 12.0, 36000.0, "");
  if (immersion.axial_depth > tool.length() * (1.0 + 1e-12)) {
    throw InvalidInput(Fault{"tool.length_mm", "shorter than the axial depth",
                             "the tool must reach out of the cut", "lengthen the tool"});
  }
}

double largest_magnitude(const SurfaceError& error) {
  double largest = 0.0;
  for (const double e : error.error) largest = std::max(largest, std::abs(e));
  return largest;
}

double range(const SurfaceError& error) {
  if (error.error.empty()) return 0.0;
  const auto [low, high] = std::minmax_element(error.error.begin(), error.error.end());
  return *high - *low;
}

double wall_angle(const cutting::Immersion& immersion) {
  return immersion.kind == cutting::ImmersionKind::up ? 0.0 : std::numbers::pi;
}

ToolDeflection tool_deflection(const ToolCompliance& tool, const cutting::Cutter& cutter,
                               const cutting::CuttingLaw& law, const cutting::Condition& condition,
                               const cutting::Immersion& immersion,
                               const DeflectionOptions& options) {
  check_static_cut(tool, cutter, law, condition, immersion, options);
  const SliceForce force(cutter, law, condition, immersion);
  // A slice is thin enough for its forces to stand at its middle, and for its edge to lag by no
  // more than 0.1 rad.
  const double lag = std::abs(cutting::lag_angle(cutter, immersion.axial_depth));
  const int slices =
      std::max({1, static_cast<int>(std::ceil(immersion.axial_depth / options.slice_height - 1e-9)),
                static_cast<int>(std::ceil(lag / 0.1))});
  const double dz = immersion.axial_depth / slices;
  std::vector<double> middles;
  for (int s = 0; s < slices; ++s) middles.push_back((s + 0.5) * dz);

  ToolDeflection result;
  std::vector<double> to_tip;
  for (const double z : middles) to_tip.push_back(dz * tool.between(0.0, z));
  // With equal flutes the forces repeat with the pitch: one tooth period is worked out, the others
  // are copies.
  const int periods = force.equal_flutes() ? cutter.flutes : 1;
  const int per_tooth = std::max(4, options.steps / periods);
  std::vector<Eigen::Vector2d> tooth;
  for (int i = 0; i < per_tooth; ++i) {
    const double rotation = kTurn * i / (per_tooth * periods);
    Eigen::Vector2d tip = Eigen::Vector2d::Zero();
    if (cutter.helix_angle == 0.0) {
      const Eigen::Vector2d f = force(rotation, 0.0);
      for (const double c : to_tip) tip += c * f;
    } else {
      for (std::size_t s = 0; s < middles.size(); ++s) {
        tip += to_tip[s] * force(rotation, middles[s]);
      }
    }
    tooth.push_back(tip);
  }
  std::size_t largest = 0, smallest = 0;
  for (int i = 0; i < per_tooth * periods; ++i) {
    const auto k = static_cast<std::size_t>(i % per_tooth);
    result.angle.push_back(kTurn * i / (per_tooth * periods));
    result.tip_x.push_back(tooth[k].x());
    result.tip_y.push_back(tooth[k].y());
    if (tooth[k].y() > tooth[largest].y()) largest = k;
    if (tooth[k].y() < tooth[smallest].y()) smallest = k;
  }
  result.total_tip = tooth[largest].y() - tooth[smallest].y();

  const double wall = wall_angle(immersion);
  const auto deflection_y = [&](double rotation, double height) {
    double y = 0.0;
    for (const double z : middles) y += dz * tool.between(height, z) * force(rotation, z).y();
    return y;
  };
  result.tip_at_surface = deflection_y(wall, 0.0);
  const int along = 40;
  for (int i = 0; i <= along; ++i) {
    const double z = tool.length() * i / along;
    result.heights.push_back(z);
    result.at_largest.push_back(deflection_y(result.angle[largest], z));
    result.at_smallest.push_back(deflection_y(result.angle[smallest], z));
    result.at_surface.push_back(deflection_y(wall, z));
  }
  const double away = wall == 0.0 ? -1.0 : 1.0;
  std::vector<double> heights{0.0};
  heights.insert(heights.end(), middles.begin(), middles.end());
  heights.push_back(immersion.axial_depth);
  for (const double z : heights) {
    result.surface.axial_position.push_back(z);
    result.surface.error.push_back(away * deflection_y(wall + cutting::lag_angle(cutter, z), z));
  }
  return result;
}

SurfaceError dynamic_surface_error(const vibration::Receptance& receptance,
                                   const cutting::Cutter& cutter, const cutting::CuttingLaw& law,
                                   const cutting::Condition& condition,
                                   const cutting::Immersion& immersion, int points) {
  check_cut(cutter, law, condition, immersion);
  require_within("options.points", points, 2.0, 1000.0, "");
  const vibration::ForcedMotion motion =
      vibration::forced_motion(receptance, cutter, law, condition, immersion);
  const double wall = wall_angle(immersion);
  const double away = wall == 0.0 ? -1.0 : 1.0;
  const double pitch = cutting::Flutes(cutter).equal() ? kTurn / cutter.flutes : kTurn;
  const auto count = static_cast<double>(motion.y.size());
  SurfaceError error;
  for (int i = 0; i < points; ++i) {
    const double z = immersion.axial_depth * i / (points - 1);
    const double rotation = wall + cutting::lag_angle(cutter, z);
    const double place = (rotation / pitch - std::floor(rotation / pitch)) * count;
    const auto low = static_cast<std::size_t>(place) % motion.y.size();
    const double share = place - std::floor(place);
    const double y = (1.0 - share) * motion.y[low] + share * motion.y[(low + 1) % motion.y.size()];
    error.axial_position.push_back(z);
    error.error.push_back(away * y);
  }
  return error;
}

}  // namespace osteomill::accuracy
