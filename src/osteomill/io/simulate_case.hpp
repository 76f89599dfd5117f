// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "osteomill/control/feed_controller.hpp"
#include "osteomill/control/supervisor.hpp"
#include "osteomill/io/cutting_section.hpp"
#include "osteomill/io/finish.hpp"
#include "osteomill/io/joint_program.hpp"
#include "osteomill/io/netft_client.hpp"
#include "osteomill/io/path_section.hpp"
#include "osteomill/io/region_section.hpp"
#include "osteomill/io/stock_section.hpp"
#include "osteomill/io/tool_section.hpp"
#include "osteomill/simulate/bone_heat.hpp"
#include "osteomill/simulate/milling.hpp"

namespace osteomill::io {

class Section;
struct CaseRun;

/// [map]: what is known of the bone before it is cut.
struct BoneMapCase {
  /// Of the bone of a variant: itself, or the one that it varies.
  enum class Shows : std::uint8_t { stock, plan };
  Shows shows = Shows::stock;
  control::MapTrust trust;
  double offset = 0.0;  ///< how far along the path it really lies from the bone, m
};

/// One run of `osteomill simulate`.
struct SimulateCase {
  std::string name;
  StockCase stock;
  PathCase path;
  RegionCase regions;  ///< not with line-profile
  CutterCase cutter;
  BoneCase bone;  ///< not with line-profile
  simulate::Machine machine;
  control::FeedController controller;
  bool model_adaptive = false;  ///< the controller's law is made from these
  control::ModelAdaptiveOptions model_options;
  bool model_predictive = false;  ///< the law is made from these and the map, see law_of()
  control::ModelPredictiveOptions predictive_options;
  std::optional<double> temperature_limit;  ///< kept by the speed of the spindle, K
  BoneMapCase map;
  std::optional<control::SupervisorLimits> supervisor;  ///< with `osteomill control`
  netft::ClientOptions sensor;                          ///< with `osteomill control`: a real one
  std::optional<CarryingRobot> robot;                   ///< on LinuxCNC; none: x, y, z
  std::string variant_of;                         ///< name of the run that it varies; or empty
  double force_limit = 30.0;                      ///< N
  std::optional<simulate::BoneHeatOptions> heat;  ///< not with line-profile
  std::optional<FinishCase> finish;               ///< with a plan
  std::optional<ToolCase> tool;                   ///< none: rigid
  nlohmann::ordered_json expanded;                ///< as read, with the defaults filled in
};

/// The tables [stock] [path] [controller] [limits] [machine] [cutter] [bone] of a case.
void bind_simulate(Section& section, SimulateCase& to);

/// What a case has before its tables are read, and what follows from them together afterwards.
void prepare(SimulateCase& to, const CaseRun& run);
void complete(SimulateCase& made);

/// The same for `osteomill schema`.
void bind_simulate_keys(Section& section);

/// Reads every run of a case; throws InvalidInput with the faults of all of them.
std::vector<SimulateCase> read_simulate_cases(const std::vector<CaseRun>& runs);

}  // namespace osteomill::io
