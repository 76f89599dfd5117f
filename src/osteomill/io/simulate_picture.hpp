// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "osteomill/geometry/mesh.hpp"
#include "osteomill/io/picture.hpp"
#include "osteomill/io/report.hpp"
#include "osteomill/io/simulated_run.hpp"

namespace osteomill::io {

/// The bone of each run as a surface; empty for a run without a stock. Made once, for the pictures
/// and the report.
struct RunSurfaces {
  std::vector<geometry::Mesh> before;
  std::vector<geometry::Mesh> after;
};
RunSurfaces surfaces_of(const std::vector<SimulatedRun>& runs);

/// The bone before and after run `index`, by its density. The colours mean the same in the pictures
/// of all runs. Only for a run with a stock.
Picture picture_of(const std::vector<SimulatedRun>& runs, const RunSurfaces& surfaces,
                   std::size_t index);

/// The mean force along the path of run `index`. A path that keeps to one plane along the tool, a
/// slot, is seen in the bone cut open there; any other through the bone.
Picture force_picture_of(const std::vector<SimulatedRun>& runs, const RunSurfaces& surfaces,
                         std::size_t index);

/// The 3-D view of the report, where the runs share one stock.
void add_scene(ReportData& data, const std::vector<SimulatedRun>& runs, RunSurfaces surfaces);

}  // namespace osteomill::io
