// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "osteomill/geometry/mesh.hpp"
#include "osteomill/io/picture.hpp"
#include "osteomill/io/report.hpp"
#include "osteomill/io/simulated_run.hpp"

namespace osteomill::io {

/// The bone of each run as a surface; of a line profile, its slab. Made once, for the pictures and
/// the report.
struct RunSurfaces {
  std::vector<geometry::Mesh> before;
  std::vector<geometry::Mesh> after;
};
RunSurfaces surfaces_of(const std::vector<SimulatedRun>& runs);

/// The bone before and after run `index`, by its density, or a profile's by its cutting gain. The
/// colours mean the same in the pictures of all runs.
Picture picture_of(const std::vector<SimulatedRun>& runs, const RunSurfaces& surfaces,
                   std::size_t index);

/// The mean force along the path of run `index`. A path that keeps to one plane along the tool, a
/// slot, is seen in the bone cut open there; any other through the bone.
Picture force_picture_of(const std::vector<SimulatedRun>& runs, const RunSurfaces& surfaces,
                         std::size_t index);

/// Puts the bone into the 3-D view of a report that report_of made.
void add_scene(ReportData& data, const std::vector<SimulatedRun>& runs, RunSurfaces surfaces);

}  // namespace osteomill::io
