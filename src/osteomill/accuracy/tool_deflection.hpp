// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "osteomill/accuracy/tool_compliance.hpp"
#include "osteomill/cutting/milling_force.hpp"
#include "osteomill/vibration/frequency_domain.hpp"

namespace osteomill::accuracy {

/// What the surface keeps or loses along the tool axis, m. Positive: bone is left (under-cut).
struct SurfaceError {
  std::vector<double> axial_position;  ///< height above the tip, m
  std::vector<double> error;           ///< m
};

/// Largest of the magnitudes, and largest minus smallest.
double largest_magnitude(const SurfaceError& error);
double range(const SurfaceError& error);

/// Implants need gaps below 0.3-0.5 mm for ingrowth: [carlsson1988] in [plaskos2002] §1.1.
inline constexpr double kTightGap = 0.3e-3;
inline constexpr double kWideGap = 0.5e-3;

struct DeflectionOptions {
  double slice_height = 1e-3;  ///< at most, m; forces stand at mid-slice; less with a helix
  int steps = 360;             ///< of a revolution
};

/// Quasi-static deflection of the tool under the forces of a rigid cut.
struct ToolDeflection {
  std::vector<double> angle;         ///< rotation of flute 1's tip, rad
  std::vector<double> tip_x, tip_y;  ///< deflection of the tip, m
  double total_tip = 0.0;            ///< largest minus smallest tip_y in a revolution, m
  double tip_at_surface = 0.0;       ///< tip_y when an edge passes the finished wall at the tip, m
  std::vector<double> heights;       ///< along the whole free length, m
  std::vector<double> at_largest;    ///< y along the tool when tip_y is largest, m
  std::vector<double> at_smallest;
  std::vector<double> at_surface;  ///< y when flute 1 passes the wall
  SurfaceError surface;
};

/// Throws InvalidInput where deflection and surface of such a cut cannot be worked out.
void check_static_cut(const ToolCompliance& tool, const cutting::Cutter& cutter,
                      const cutting::CuttingLaw& law, const cutting::Condition& condition,
                      const cutting::Immersion& immersion, const DeflectionOptions& options);

/// Slice forces of [plaskos2002] eqs 8-9 on the beam of eq. 10 at every rotation angle. The
/// finished wall lies at −y (θ = π) in a slot and in down-milling, at +y (θ = 0) in up-milling;
/// each height of it is made when an edge passes there (§4.2.6), its error is the deflection away
/// from the wall at that instant. Inertia, run-out and the effect of the deflection on the chip are
/// left out: see flexible_cut and dynamic_surface_error. Cylindrical cutters.
ToolDeflection tool_deflection(const ToolCompliance& tool, const cutting::Cutter& cutter,
                               const cutting::CuttingLaw& law, const cutting::Condition& condition,
                               const cutting::Immersion& immersion,
                               const DeflectionOptions& options = {});

/// Surface location error of a vibrating tool: the steady forced motion at the instants when an
/// edge passes the wall, along the depth; [schmitz2009] ch. 7 by harmonics. The tip's receptance
/// stands for the whole depth.
SurfaceError dynamic_surface_error(const vibration::Receptance& receptance,
                                   const cutting::Cutter& cutter, const cutting::CuttingLaw& law,
                                   const cutting::Condition& condition,
                                   const cutting::Immersion& immersion, int points = 21);

/// Rotation angle at which an edge makes the finished wall: π, or 0 in up-milling.
double wall_angle(const cutting::Immersion& immersion);

}  // namespace osteomill::accuracy
