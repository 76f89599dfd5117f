// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "osteomill/geometry/mesh.hpp"
#include "osteomill/io/picture.hpp"
#include "osteomill/io/plot.hpp"
#include "osteomill/io/region_section.hpp"
#include "osteomill/study/finished_surface.hpp"
#include "osteomill/workpiece/no_go.hpp"
#include "osteomill/workpiece/region.hpp"

/// What a run leaves: the finished surface against the plan.
namespace osteomill::io {

class Section;

/// [finish]: how it is looked at.
struct FinishCase {
  study::CutKind cut = study::CutKind::kProximalTibia;  ///< names the sides of its two angles
  bool right_knee = false;
  std::array<double, 3> entry{0, 1, 0};  ///< towards where the tool comes from, in W
  double sampling_length = 8e-3;         ///< m
  double reach = 2e-3;                   ///< m
};

void bind_finish(Section& section, std::optional<FinishCase>& finish);

struct Finish {
  study::FinishedSurface surface;
  /// Deviation per vertex where the cutter has been, m, not a number elsewhere. In W, closed.
  geometry::Mesh mesh;
  nlohmann::ordered_json report;
  double scale = 0.0;  ///< of the colours: plus and minus, mm
};

/// Measures what is left of a stock by its voxels' occupancy. Throws InvalidInput where the path
/// has left no surface near the plan.
Finish finish_of(const workpiece::Stock& before, const workpiece::Stock& after,
                 const PlanCase& planned, const workpiece::Region& plan,
                 const workpiece::ToolPath& path, const cutting::Cutter& cutter,
                 const FinishCase& options);

/// The plane of a plan that has one to finish: of a half-space, or the floor of a box or a tray.
struct PlanPlane {
  geometry::Vector3 point = geometry::Vector3::Zero();
  geometry::Vector3 normal = geometry::Vector3::UnitZ();
};
std::optional<PlanPlane> plane_of(const PlanCase& planned);

/// The bone that is left, coloured by the deviation in mm where it was cut; other surfaces beside.
Picture finish_picture(const Finish& finish, const std::string& title,
                       const std::vector<geometry::Mesh>& beside);
/// The deviation over the plan, µm.
HeatMap finish_map(const Finish& finish, const std::string& title);
/// One profile along the feed and one across it, through the middle.
LinePlot finish_profiles(const Finish& finish, const std::string& title);

/// Sentence for table and report.
std::string finish_sentence(const std::string& name, const Finish& finish);

}  // namespace osteomill::io
