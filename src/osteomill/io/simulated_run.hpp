// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "osteomill/base/progress.hpp"
#include "osteomill/control/loop.hpp"
#include "osteomill/io/checkpoint.hpp"
#include "osteomill/io/machine_summary.hpp"
#include "osteomill/io/netft_client.hpp"
#include "osteomill/io/simulate_case.hpp"
#include "osteomill/io/supervised_plant.hpp"
#include "osteomill/simulate/summary.hpp"
#include "osteomill/workpiece/stock.hpp"
#include "osteomill/workpiece/tool_path.hpp"

namespace osteomill::io {

struct SimulatedRun;

/// A plant in the place of the simulated one, and what it has to say when the run is over.
struct MadePlant {
  std::unique_ptr<control::Plant> plant;
  std::function<void(SimulatedRun& run)> finish;
};

/// How runs are run.
struct RunOptions {
  std::function<double()> clock;  ///< s, for the compute times; none: not measured
  /// The plant that the loop sees in place of the simulated one: that one in real time or recorded.
  /// It must outlive the run. `length`: of the path, m. None: the simulated one.
  std::function<control::Plant&(control::Plant& plant, const SimulatedRun& run, double length)>
      wrap;
  /// Makes the plant of a run that plays its bone with `milling`. It has a supervisor of its own.
  /// `run` has its input and, but for a line profile, its path. None: the simulated one, with the
  /// case's supervisor in the loop.
  std::function<MadePlant(const SimulatedRun& run, simulate::Milling& milling)> make;
  /// The wrapped plant is: see control::LoopOptions; the case's supervisor gets its own thread.
  bool real_time = false;
  // Of the simulated plant; one of `make` has its own. None: nobody is told.
  std::function<void(std::span<const netft::Sample>)> on_samples = {};
  std::function<void(const control::LoopEvent&)> on_event = {};
  /// Told every warning as soon as it is known. None: they are in the runs only.
  std::function<void(const std::string&)> warn = {};
  /// Keeps the state of simulated runs on disk; not of line profiles, which take no time.
  std::optional<CheckpointOptions> checkpoint = {};
};

/// A run that is over, whole or as far as it came.
struct SimulatedRun {
  SimulateCase input;
  simulate::Summary summary;
  std::vector<simulate::Step> steps;
  std::string material_key;    ///< what Step::material is, with its unit
  double material_unit = 1.0;  ///< of material_key in SI
  /// The bone before and after; none for a line profile. Runs of one stock share the first.
  std::shared_ptr<const workpiece::Stock> before;
  std::shared_ptr<const workpiece::Stock> after;
  // Null for a line profile: what the bone was made from, the path with its margins, and what was
  // done of the plan (null also without one).
  nlohmann::ordered_json stock, path_report, plan;
  std::optional<workpiece::ToolPath> path;
  std::vector<geometry::Mesh> no_go;  ///< surfaces that the tool kept away from, in W
  control::LoopSummary loop;
  std::shared_ptr<const Finish> finish;           ///< none: not asked for, or not finished
  std::optional<MachineSummary> machine;          ///< with a machine that moved
  std::optional<SupervisedStop> stop;             ///< by a supervisor with a thread of its own
  std::optional<simulate::BoneHeatSummary> heat;  ///< none: not asked for
  std::vector<std::string> warnings;              ///< what the reader of the result has to know
};

/// Makes the law of controller.kind = "model-predictive" from the map of its bone, as
/// run_simulations does; other cases are left alone.
void settle_law(SimulateCase& input, const Progress& progress = {});

/// Runs the cases one after the other. When `progress` asks to stop, the run that was at work is
/// kept as far as it came, with status `stopped`, and the rest is not begun.
std::vector<SimulatedRun> run_simulations(const std::vector<SimulateCase>& cases,
                                          const Progress& progress = {},
                                          const RunOptions& options = {});

}  // namespace osteomill::io
