// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "osteomill/cutting/cutter.hpp"
#include "osteomill/geometry/mesh.hpp"
#include "osteomill/workpiece/outline.hpp"
#include "osteomill/workpiece/tool_path.hpp"

namespace osteomill::workpiece {

/// Something that the tool must not come near: a ligament, a vessel, an instrument.
struct NoGo {
  std::string name;
  geometry::Mesh surface_W;  ///< any triangles in W, m; need not be closed
  double thickness = 0.0;    ///< of what lies around the surface, m: 0, or the radius of a ball
  double margin = 2e-3;      ///< that has to stay between it and the tool, m
};

NoGo no_go_box(const std::string& name, const Vector3& lower, const Vector3& upper, double margin);
/// What lies beyond the plane on the side to which `normal` points, a metre around `point`.
NoGo no_go_half_space(const std::string& name, const Vector3& point, const Vector3& normal,
                      double margin);
NoGo no_go_ball(const std::string& name, const Vector3& centre, double radius, double margin);

/// How near the tool comes.
struct Approach {
  double distance = 0.0;              ///< m; 0 and below: it touches
  Vector3 tip_W = Vector3::Zero();    ///< on the path, beside the place
  Vector3 place_W = Vector3::Zero();  ///< of the region
  std::size_t move = 0;               ///< of the path
};

/// The least distance between a region and the tool on its way, rapids included. The tool is the
/// envelope of the cutter and a shank of its full radius that goes on without end. With the axis at
/// +z the sweep of each straight piece is taken as it is; where the axis turns, poses along it no
/// more than a quarter of a millimetre apart. Triangles are divided until the least distance is
/// known to 10 µm.
Approach nearest_approach(const ToolPath& path, const cutting::Cutter& cutter, const NoGo& region);

/// Approaches of all regions, in their order. Throws InvalidInput that names every region whose
/// margin the tool enters, where, and by how much.
std::vector<Approach> check_no_go(const ToolPath& path, const cutting::Cutter& cutter,
                                  const std::vector<NoGo>& regions);

/// Where the axis of an upright tool must not be with its tip at a height or above: the shadow of
/// what the region has above the tip, grown by the cutter's radius and the margin.
Outline forbidden(const NoGo& region, const cutting::Cutter& cutter, double tip_z);

/// An opening through which the tool has to pass: at its height the tool must stay within.
struct AccessWindow {
  Outline outline;
  double height = 0.0;  ///< z of W, m
};
/// The least distance from the tool to the border of the opening, m, while any of it is in the
/// plane of the opening; infinite when none ever is. The tool is that of nearest_approach(), at any
/// axis: where it leans, what is asked for is the border of its section with that plane, at every
/// five degrees. Throws InvalidInput when the tool does not fit through on its path.
double check_access(const ToolPath& path, const cutting::Cutter& cutter,
                    const AccessWindow& window);

}  // namespace osteomill::workpiece
