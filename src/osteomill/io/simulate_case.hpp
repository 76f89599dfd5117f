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
#include "osteomill/io/netft_client.hpp"
#include "osteomill/simulate/bone_heat.hpp"
#include "osteomill/simulate/line_profile.hpp"
#include "osteomill/simulate/milling.hpp"
#include "osteomill/workpiece/phantoms.hpp"
#include "osteomill/workpiece/stock.hpp"

namespace osteomill::io {

class Section;
struct CaseRun;

enum class StockKind : std::uint8_t { line_profile, block, tibia_section, ct };

/// [stock]: the bone before the cut. The work frame W has z towards the spindle.
struct StockCase {
  StockKind kind = StockKind::block;
  std::string note;                       ///< what the reader of the result has to know
  simulate::LineProfile profile;          ///< line-profile; its path keys come from [path]
  double spacing = 0.2e-3;                ///< of the voxels, m
  std::array<double, 3> lower{};          ///< corners of block and CT region in W, m
  std::array<double, 3> upper{};          ///< m
  double density = 0.0;                   ///< of a block, kg/m³
  std::optional<double> force_scale;      ///< of a block; none: by density
  workpiece::TibiaSection tibia;          ///< densities and sizes
  std::filesystem::path file;             ///< ct
  std::string series;                     ///< ct
  std::array<double, 3> origin{};         ///< of W in the patient frame, m
  std::array<double, 3> x_axis{1, 0, 0};  ///< of W in the patient frame
  std::array<double, 3> z_axis{0, 0, 1};  ///< of W in the patient frame
  workpiece::BoneFromCt bone_from_ct;
};

enum class PathKind : std::uint8_t { lines, zigzag, points, gcode };

/// [path]: what the cutter is to do.
struct PathCase {
  PathKind kind = PathKind::lines;
  double feed = 0.0;           ///< programmed, m/s
  double spindle_speed = 0.0;  ///< rad/s
  double rapid_feed = 12e-3;   ///< m/s
  int lines = 1;
  std::array<double, 3> start{};              ///< m
  std::array<double, 3> along{};              ///< m
  std::array<double, 3> step_over{};          ///< m
  double clearance = 5e-3;                    ///< m
  std::vector<std::array<double, 3>> points;  ///< m
  std::filesystem::path file;
};

/// One run of `osteomill simulate`.
struct SimulateCase {
  std::string name;
  StockCase stock;
  PathCase path;
  CutterCase cutter;
  BoneCase bone;  ///< not with line-profile
  std::array<double, 3> fibre{1, 0, 0};
  simulate::Machine machine;
  control::FeedController controller;
  bool model_adaptive = false;  ///< the controller's law is made from these
  control::ModelAdaptiveOptions model_options;
  std::optional<control::SupervisorLimits> supervisor;  ///< with `osteomill control`
  netft::ClientOptions sensor;                          ///< with `osteomill control`: a real one
  std::string variant_of;                         ///< name of the run that it varies; or empty
  double force_limit = 30.0;                      ///< N
  std::optional<simulate::BoneHeatOptions> heat;  ///< not with line-profile
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
