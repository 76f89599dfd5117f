// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/workpiece/knee_phantoms.hpp"

#include <algorithm>
#include <cmath>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"

namespace osteomill::workpiece {

namespace {

/// From 0 to 1 with level ends.
double ease(double t) {
  t = std::clamp(t, 0.0, 1.0);
  return t * t * (3.0 - 2.0 * t);
}

double blend(double a, double b, double t) { return a + (b - a) * t; }

/// A distance to first order from a function that is 0 on the surface: f / |grad f|.
template <class Function>
double first_order_distance(const Function& f, const Vector3& p) {
  constexpr double step = 0.1e-3;  // m: small against the bone, large against rounding
  Vector3 gradient;
  for (int axis = 0; axis < 3; ++axis) {
    const Vector3 offset = step * Vector3::Unit(axis);
    gradient[axis] = (f(p + offset) - f(p - offset)) / (2.0 * step);
  }
  return f(p) / std::max(gradient.norm(), 30.0);  // 1/m: on the axis the gradient vanishes
}

/// Surface blended from two, rounded over `radius` where they meet.
double smooth_union(double a, double b, double radius) {
  const double t = std::clamp(0.5 + 0.5 * (b - a) / radius, 0.0, 1.0);
  return blend(b, a, t) - radius * t * (1.0 - t);
}

Stock upright(const Anatomy& anatomy, double spacing, double margin) {
  require_positive("stock.spacing_mm", spacing / units::mm, "mm");
  require_non_negative("stock.margin_mm", margin / units::mm, "mm");
  const Vector3 more = Vector3::Constant(margin + spacing);
  return stock_of(anatomy, geometry::Pose::Identity(),
                  {anatomy.lower_P - more, anatomy.upper_P + more}, spacing);
}

}  // namespace

Anatomy anatomy_of(const ProximalTibia& tibia) {
  require_positive("stock.width_mm", tibia.width / units::mm, "mm");
  require_positive("stock.depth_mm", tibia.depth / units::mm, "mm");
  require_positive("stock.length_mm", tibia.length / units::mm, "mm");
  require_within("stock.shaft_mm", tibia.shaft / units::mm, 1.0, tibia.depth / units::mm, "mm");
  require_within("stock.slope_deg", tibia.slope / units::deg, -30.0, 30.0, "deg");
  check(tibia.bone);
  // The metaphysis narrows over this share of the length.
  constexpr double narrowing = 0.7;
  const Vector3 up(0.0, -std::sin(tibia.slope), std::cos(tibia.slope));
  const auto side = [tibia](const Vector3& p) {
    const double t = ease(-p.z() / (narrowing * tibia.length));
    const double a = 0.5 * blend(tibia.width, tibia.shaft, t);
    const double b = 0.5 * blend(tibia.depth, tibia.shaft, t);
    const double power = blend(3.0, 2.0, t);  // a rounded rectangle becomes an ellipse
    return std::pow(std::pow(std::abs(p.x() / a), power) + std::pow(std::abs(p.y() / b), power),
                    1.0 / power) -
           1.0;
  };
  const Vector3 lower(-0.5 * tibia.width, -0.5 * tibia.depth, -tibia.length);
  const Vector3 upper(0.5 * tibia.width, 0.5 * tibia.depth,
                      0.5 * tibia.depth * std::abs(std::tan(tibia.slope)));
  const auto bone = [tibia, up, side](const Vector3& p_P) {
    const double to_side = -first_order_distance(side, p_P);
    const double to_joint = -p_P.dot(up);
    const double to_end = p_P.z() + tibia.length;
    BoneSample sample;
    sample.signed_distance = -std::min({to_side, to_joint, to_end});
    sample.material =
        material_at(tibia.bone, {to_joint, to_joint, to_side, -p_P.z() / tibia.length});
    return sample;
  };
  return {bone, lower, upper};
}

Stock proximal_tibia(const ProximalTibia& tibia, double spacing, double margin) {
  return upright(anatomy_of(tibia), spacing, margin);
}

Anatomy anatomy_of(const DistalFemur& femur) {
  require_positive("stock.width_mm", femur.width / units::mm, "mm");
  require_positive("stock.depth_mm", femur.depth / units::mm, "mm");
  require_positive("stock.condyle_height_mm", femur.condyle_height / units::mm, "mm");
  require_within("stock.length_mm", femur.length / units::mm, femur.condyle_height / units::mm,
                 1000.0, "mm");
  require_within("stock.shaft_mm", femur.shaft / units::mm, 1.0, femur.depth / units::mm, "mm");
  require_within("stock.notch_mm", femur.notch / units::mm, 0.0, 0.5 * femur.width / units::mm,
                 "mm");
  check(femur.bone);
  const double half_height = 0.5 * femur.condyle_height;
  const double condyle_width = 0.5 * (femur.width - femur.notch);
  const double condyle_x = 0.5 * (femur.notch + condyle_width);
  const double rounding = 6e-3;  // where condyles, trochlea and shaft meet, m
  const auto ellipsoid = [](const Vector3& p, const Vector3& centre, const Vector3& axes) {
    return first_order_distance(
        [&](const Vector3& q) { return (q - centre).cwiseQuotient(axes).norm() - 1.0; }, p);
  };
  const auto surface = [=](const Vector3& p) {
    const Vector3 mirrored(std::abs(p.x()), p.y(), p.z());
    const double condyle = ellipsoid(mirrored, {condyle_x, 0.0, half_height},
                                     {0.5 * condyle_width, 0.5 * femur.depth, half_height});
    // The trochlea joins the condyles in front and above the notch.
    const double trochlea = ellipsoid(p, {0.0, 0.15 * femur.depth, 1.2 * half_height},
                                      {0.46 * femur.width, 0.33 * femur.depth, 0.9 * half_height});
    // The shaft widens towards the condyles.
    const double t = ease((p.z() - half_height) / (0.6 * (femur.length - half_height)));
    const double a = 0.5 * blend(0.85 * femur.width, femur.shaft, t);
    const double b = 0.5 * blend(0.6 * femur.depth, femur.shaft, t);
    const double side = (std::hypot(p.x() / a, p.y() / b) - 1.0) * std::min(a, b);
    const double shaft = std::max(side, 1.2 * half_height - p.z());
    return smooth_union(smooth_union(condyle, trochlea, rounding), shaft, rounding);
  };
  const Vector3 lower(-0.5 * femur.width, -0.5 * femur.depth, 0.0);
  const Vector3 upper(0.5 * femur.width, 0.5 * femur.depth, femur.length);
  const auto bone = [femur, surface](const Vector3& p_P) {
    const double to_side = -surface(p_P);
    const double to_end = femur.length - p_P.z();
    // The joint surface ends at the top of the condyles.
    const double above = std::max(0.0, p_P.z() - femur.condyle_height);
    const double to_joint = std::max(to_side, 0.0) + above;
    BoneSample sample;
    sample.signed_distance = -std::min(to_side, to_end);
    sample.material =
        material_at(femur.bone, {to_joint, to_joint, to_side, p_P.z() / femur.length});
    return sample;
  };
  return {bone, lower, upper};
}

Stock distal_femur(const DistalFemur& femur, double spacing, double margin) {
  return upright(anatomy_of(femur), spacing, margin);
}

}  // namespace osteomill::workpiece
