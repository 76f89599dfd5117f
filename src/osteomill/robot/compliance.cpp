// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/robot/compliance.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <cmath>
#include <numbers>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"

namespace osteomill::robot {
namespace {

Eigen::Matrix3d cross_matrix(const Vector3& v) {
  Eigen::Matrix3d m;
  m << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return m;
}

/// Wrench at `to` → wrench at `from`: the force gains a moment.
Matrix6 wrench_shift(const Vector3& from, const Vector3& to) {
  Matrix6 shift = Matrix6::Identity();
  shift.bottomLeftCorner<3, 3>() = cross_matrix(to - from);
  return shift;
}

void need_parts(const std::string& name, const std::vector<Compliance>& parts) {
  if (parts.empty()) throw InvalidInput(Fault{name, "", "must have at least one part", ""});
}

}  // namespace

Compliance moved_to(const Compliance& part, const Vector3& point) {
  // Work is the same at both points, so that motions go with the transposed shift.
  const Matrix6 shift = wrench_shift(part.point, point);
  return {part.name, point, shift.transpose() * part.matrix * shift};
}

Compliance series(const std::string& name, const std::vector<Compliance>& parts) {
  need_parts(name, parts);
  Compliance sum{name, parts.front().point, Matrix6::Zero()};
  for (const Compliance& part : parts) sum.matrix += moved_to(part, sum.point).matrix;
  return sum;
}

Compliance parallel(const std::string& name, const std::vector<Compliance>& parts) {
  need_parts(name, parts);
  Matrix6 stiffness = Matrix6::Zero();
  for (const Compliance& part : parts) {
    const Eigen::FullPivLU<Matrix6> lu(moved_to(part, parts.front().point).matrix);
    if (!lu.isInvertible()) {
      throw InvalidInput(Fault{part.name, "rigid in some direction",
                               "must give way in all six directions to stand beside another part",
                               "put rigid parts in series only"});
    }
    stiffness += lu.inverse();
  }
  return {name, parts.front().point, stiffness.inverse()};
}

Compliance translation_spring(const std::string& name, const Vector3& point,
                              const Vector3& stiffness) {
  Compliance part{name, point, Matrix6::Zero()};
  for (int k = 0; k < 3; ++k) {
    part.matrix(k, k) = 1.0 / (require_positive((name + ".stiffness_n_per_mm").c_str(),
                                                stiffness[k] / units::n_per_mm, "N/mm") *
                               units::n_per_mm);
  }
  return part;
}

Compliance hinge_spring(const std::string& name, const Vector3& point, const Vector3& axis,
                        double stiffness) {
  require_positive((name + ".stiffness_nm_per_rad").c_str(), stiffness, "N m/rad");
  const Vector3 a = axis.normalized();
  Compliance part{name, point, Matrix6::Zero()};
  part.matrix.bottomRightCorner<3, 3>() = a * a.transpose() / stiffness;
  return part;
}

Compliance cantilever(const std::string& name, const Vector3& root, const Vector3& direction,
                      const Beam& beam) {
  const double l =
      require_positive((name + ".length_mm").c_str(), beam.length / units::mm, "mm") * units::mm;
  require_positive((name + ".bending_inertia").c_str(), beam.bending_inertia, "m4");
  require_positive((name + ".area").c_str(), beam.area, "m2");
  require_positive((name + ".youngs_modulus_gpa").c_str(), beam.youngs_modulus / units::gpa, "GPa");
  const Vector3 d = direction.normalized();
  const Eigen::Matrix3d along = d * d.transpose();
  const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - along;
  const double ei = beam.youngs_modulus * beam.bending_inertia;
  const double shear_modulus = beam.youngs_modulus / (2.0 * (1.0 + beam.poisson));
  Compliance part{name, root + l * d, Matrix6::Zero()};
  part.matrix.topLeftCorner<3, 3>() =
      across * l * l * l / (3.0 * ei) + along * l / (beam.youngs_modulus * beam.area);
  part.matrix.bottomRightCorner<3, 3>() =
      across * l / ei + along * l / (shear_modulus * 2.0 * beam.bending_inertia);
  // A force F across bends the end by L²/2EI d × F; a moment M moves it by L²/2EI M × d.
  const Eigen::Matrix3d turn = cross_matrix(d) * (l * l / (2.0 * ei));
  part.matrix.bottomLeftCorner<3, 3>() = turn;
  part.matrix.topRightCorner<3, 3>() = turn.transpose();
  return part;
}

double tube_inertia(double outer_diameter, double inner_diameter) {
  return std::numbers::pi * (std::pow(outer_diameter, 4) - std::pow(inner_diameter, 4)) / 64.0;
}

Beam milling_tube(double length) {
  using units::mm;
  Beam beam;
  beam.length = length;
  beam.bending_inertia = tube_inertia(6.0 * mm, 4.0 * mm) + tube_inertia(3.17 * mm, 0.0);
  beam.area = std::numbers::pi / 4.0 * (36.0 - 16.0 + 3.17 * 3.17) * units::mm2;
  return beam;
}

double tip_stiffness(const Beam& beam) {
  return 3.0 * beam.youngs_modulus * beam.bending_inertia / std::pow(beam.length, 3);
}

namespace {

// [plaskos2006] 5.4.
constexpr double kNominalTorque = 2.0;               // N m
constexpr double kNominalWindUp = 0.1 * units::deg;  // rad

}  // namespace

StrainWaveGear size8_gear() {
  StrainWaveGear gear{0.29, 0.75, 910.0, 1000.0, 1200.0};
  const double scale = wind_up(gear, kNominalTorque) / kNominalWindUp;
  for (double* k : {&gear.k1, &gear.k2, &gear.k3}) *k *= scale;
  return gear;
}

double size8_secant_stiffness() { return kNominalTorque / kNominalWindUp; }

double wind_up(const StrainWaveGear& gear, double torque) {
  const double t = std::abs(torque);
  const double first = std::min(t, gear.knee1) / gear.k1;
  const double second = std::max(0.0, std::min(t, gear.knee2) - gear.knee1) / gear.k2;
  const double third = std::max(0.0, t - gear.knee2) / gear.k3;
  return std::copysign(first + second + third, torque);
}

double gear_stiffness(const StrainWaveGear& gear, double torque) {
  const double t = std::abs(torque);
  return t < gear.knee1 ? gear.k1 : t < gear.knee2 ? gear.k2 : gear.k3;
}

EdgeDeflection deflection_at(const std::vector<Compliance>& chain, const Vector3& edge,
                             const Vector3& force) {
  EdgeDeflection result;
  Eigen::Matrix<double, 6, 1> wrench;
  wrench << force, Vector3::Zero();
  for (const Compliance& part : chain) {
    const Eigen::Matrix<double, 6, 1> motion = moved_to(part, edge).matrix * wrench;
    result.translation += motion.head<3>();
    result.rotation += motion.tail<3>();
    result.shares.push_back({part.name, motion.head<3>()});
  }
  return result;
}

}  // namespace osteomill::robot
