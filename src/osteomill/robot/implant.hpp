// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "osteomill/base/units.hpp"

namespace osteomill::robot {

using Vector2 = Eigen::Vector2d;

/// The five planar cuts of a femoral component, in the default cutting order of [plaskos2006] 5.8.
enum class Cut { distal, anterior_chamfer, anterior, posterior_chamfer, posterior };

inline constexpr std::array<Cut, 5> kCuttingOrder = {
    Cut::distal, Cut::anterior_chamfer, Cut::anterior, Cut::posterior_chamfer, Cut::posterior};

/// "distal", "anterior_chamfer", ...
const char* name(Cut cut);

inline std::size_t index(Cut cut) { return static_cast<std::size_t>(cut); }

/// One value for each cut, by index(cut).
template <class T>
using PerCut = std::array<T, 5>;

/// The inner surface of a femoral component in the plane of the cuts, frame I: origin at the middle
/// of the distal cut, x distal, y anterior, z = x × y; metres. [plaskos2006] fig. 4.5.
///
/// Corners run from the proximal end of the anterior cut around the bone to the proximal end of the
/// posterior cut: anterior, anterior chamfer, distal, posterior chamfer, posterior.
struct Profile {
  std::array<Vector2, 6> corners;
};

/// The profile with its distal cut turned onto the y axis and its middle moved to the origin.
/// A drawing may be turned, shifted or mirrored, but its corners run from anterior to posterior.
/// Throws InvalidInput when the six points do not make a convex profile of five cuts.
Profile make_profile(const std::vector<Vector2>& corners);

/// A family of profiles that grow with the anteroposterior dimension AP; lengths are shares of AP.
///
/// The generic family stands in for the ten commercial shapes of [plaskos2006] 4.4.1.1, whose
/// dimensions are not printed: it is no product.
struct ImplantFamily {
  std::string name = "generic";
  std::vector<double> anteroposterior;  ///< AP of each size, m, growing
  double distal_half_length = 0.25;     ///< of the distal cut, to each side of the origin
  double anterior = 0.52;               ///< y of the chamfer/anterior junction
  double posterior = 0.48;              ///< −y of the chamfer/posterior junction
  double anterior_chamfer_angle = 45.0 * units::deg;  ///< between distal cut and chamfer, rad
  double posterior_chamfer_angle = 45.0 * units::deg;
  double anterior_tilt = 5.0 * units::deg;  ///< from −x, opening proximally, rad
  double posterior_tilt = 0.0;              ///< from −x, opening proximally, rad
  double anterior_length = 0.55;            ///< of the anterior cut, along it
  double posterior_length = 0.30;           ///< of the posterior cut, along it
};

/// The generic family: AP = 45...65 mm in seven equal steps, chamfers 45°, anterior cut tilted 5°.
ImplantFamily generic_family();

/// Throws InvalidInput naming the field.
void check(const ImplantFamily& family);

/// Profile of one size, counted from 1.
Profile profile_of(const ImplantFamily& family, int size);

/// A cut as the robot sees it: the guide comes along the line from outside, its tip stops at the
/// entry or before it, the tool goes on in the direction of the cut. [plaskos2006] 4.4.1.2.
struct CutLine {
  Vector2 entry;      ///< s: where bone begins on the line when the cuts before it are made, m
  Vector2 direction;  ///< c/|c|: unit vector of cutting
  double length = 0;  ///< from the entry to the far end of the cut, m
};

struct CutOptions {
  double distal_overhang = 0.010;  ///< b: bone anterior of the distal cut's anterior end, m
  double tool_thickness = 0.0;     ///< of blade or mill: lines are moved outward by half of it, m
};

/// The five lines, by index(cut). The distal cut runs from anterior to posterior and enters at its
/// anterior end plus the overhang; each chamfer from its distal end, after the distal cut; anterior
/// and posterior cut proximally from their chamfer's far end, after the chamfer.
PerCut<CutLine> cut_lines(const Profile& profile, const CutOptions& options = {});

}  // namespace osteomill::robot
