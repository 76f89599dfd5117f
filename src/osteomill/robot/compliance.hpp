// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "osteomill/geometry/pose.hpp"

/// How a chain of elastic parts gives way at the cutter. Small deflections, one frame W throughout.
namespace osteomill::robot {

using geometry::Vector3;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// (translation, m; rotation, rad) per (force, N; moment, N m), both taken at `point`.
struct Compliance {
  std::string name;
  Vector3 point = Vector3::Zero();
  Matrix6 matrix = Matrix6::Zero();
};

/// The same part with loads and motions taken at another point of the body that it carries.
Compliance moved_to(const Compliance& part, const Vector3& point);

/// Parts one behind the other: compliances add, at the first part's point.
Compliance series(const std::string& name, const std::vector<Compliance>& parts);
/// Parts side by side between the same two bodies: stiffnesses add. Every part must be regular.
Compliance parallel(const std::string& name, const std::vector<Compliance>& parts);

/// A part that only gives way in translation, with stiffnesses along x, y, z, N/m.
Compliance translation_spring(const std::string& name, const Vector3& point,
                              const Vector3& stiffness);
/// A part that only turns about an axis through the point, N m/rad.
Compliance hinge_spring(const std::string& name, const Vector3& point, const Vector3& axis,
                        double stiffness);

/// A straight cantilever from its root along `direction`; loads at its free end. Euler-Bernoulli in
/// bending, with axial and torsional compliance.
struct Beam {
  double length = 0.0;            ///< m
  double bending_inertia = 0.0;   ///< I, m⁴
  double area = 0.0;              ///< m²
  double youngs_modulus = 197e9;  ///< Pa; the steel of [plaskos2006] 5.5.3
  double poisson = 0.3;
};
Compliance cantilever(const std::string& name, const Vector3& root, const Vector3& direction,
                      const Beam& beam);
/// I = π(D⁴ − d⁴)/64 and area of a tube; a full shaft has d = 0.
double tube_inertia(double outer_diameter, double inner_diameter);

/// The attachment tube of the milling tool with the cutter's shaft inside, K = 3E(I_T + I_C)/L³.
/// [plaskos2006] 5.5.3 (unnumbered): 6/4 mm tube, 3.17 mm shaft.
Beam milling_tube(double length);
/// Bending stiffness at the free end, N/m.
double tip_stiffness(const Beam& beam);

/// A strain-wave gear: three straight pieces of wind-up against torque.
struct StrainWaveGear {
  double knee1 = 0.0;  ///< T1, N m
  double knee2 = 0.0;  ///< T2, N m
  double k1 = 0.0;     ///< N m/rad below T1
  double k2 = 0.0;     ///< between T1 and T2
  double k3 = 0.0;     ///< above T2
};
/// Size 8, ratio 100 (HFUC-8-100 of [plaskos2006] 5.4), calibrated to the thesis: 0.1° at 2 N m
/// ("~0.1° for an applied torque of 2 Nm", computed there from the maker's data). How the wind-up
/// divides among the three pieces is assumed (fig. 5.9 is not readable in numbers).
StrainWaveGear size8_gear();
/// Of that gear from rest to the nominal load of 2 N m: 2 N m / 0.1° = 1146 N m/rad.
double size8_secant_stiffness();
double wind_up(const StrainWaveGear& gear, double torque);
/// dT/dφ at that torque, N m/rad.
double gear_stiffness(const StrainWaveGear& gear, double torque);

/// What a force at the cutting edge does.
struct EdgeDeflection {
  Vector3 translation = Vector3::Zero();  ///< at the edge, m
  Vector3 rotation = Vector3::Zero();     ///< rad
  struct Share {
    std::string name;
    Vector3 translation = Vector3::Zero();
  };
  std::vector<Share> shares;  ///< of each part in the chain; they add up
};
EdgeDeflection deflection_at(const std::vector<Compliance>& chain, const Vector3& edge,
                             const Vector3& force);

}  // namespace osteomill::robot
