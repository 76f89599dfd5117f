// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/simulated_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/control/loop.hpp"
#include "osteomill/io/ct_volume.hpp"
#include "osteomill/io/gcode.hpp"
#include "osteomill/io/simulated_plant.hpp"
#include "osteomill/io/text_file.hpp"
#include "osteomill/simulate/stock_job.hpp"
#include "osteomill/thermal/thermal_dose.hpp"

namespace osteomill::io {
namespace {

using geometry::Vector3;

Vector3 vector_of(const std::array<double, 3>& a) { return {a[0], a[1], a[2]}; }

/// X_PW from the origin and two axes, x made normal to z.
geometry::Pose work_frame(const StockCase& stock) {
  const Vector3 z = vector_of(stock.z_axis);
  const Vector3 x = vector_of(stock.x_axis);
  const Vector3 across = z.cross(x);
  // Axes closer than a thousandth of a radian do not say where x is.
  if (!(across.norm() > 1e-3 * z.norm() * x.norm())) {
    throw InvalidInput(
        Fault{"stock.x_axis", "", "must not be zero or parallel to stock.z_axis", ""});
  }
  geometry::Pose X_PW = geometry::Pose::Identity();
  X_PW.translation() = vector_of(stock.origin);
  X_PW.linear().col(2) = z.normalized();
  X_PW.linear().col(1) = across.normalized();
  X_PW.linear().col(0) = across.cross(z).normalized();
  return X_PW;
}

struct MadeStock {
  std::shared_ptr<const workpiece::Stock> stock;
  std::vector<std::string> remarks;
};

MadeStock stock_from_ct(const SimulateCase& input) {
  const StockCase& stock = input.stock;
  const CtVolume ct = read_ct(stock.file, {stock.series});
  // The Hounsfield units are wanted as fine as the voxels, one voxel beyond the region.
  const geometry::GridShape region =
      workpiece::cubes_over(vector_of(stock.lower), vector_of(stock.upper), stock.spacing);
  workpiece::BoneFromCt options = stock.bone_from_ct;
  options.force = input.bone.density;
  MadeStock made;
  made.stock = std::make_shared<const workpiece::Stock>(workpiece::stock_from_hounsfield(
      resample(ct, region, work_frame(stock)), stock.spacing, options));
  made.remarks = ct.remarks;
  return made;
}

MadeStock make_stock(const SimulateCase& input) {
  const StockCase& stock = input.stock;
  if (stock.kind == StockKind::ct) return stock_from_ct(input);
  // Air around the bone, so that the cutter is seen to enter and leave.
  const double margin = 2.0 * stock.spacing;
  if (stock.kind == StockKind::tibia_section) {
    return {std::make_shared<const workpiece::Stock>(
                workpiece::tibia_section(stock.tibia, stock.spacing, margin)),
            {}};
  }
  const workpiece::BoneMaterial material{
      stock.density,
      stock.force_scale.value_or(bone::force_scale(stock.density, input.bone.density))};
  return {std::make_shared<const workpiece::Stock>(workpiece::block(
              vector_of(stock.lower), vector_of(stock.upper), material, stock.spacing, margin)),
          {}};
}

workpiece::ToolPath make_path(const SimulateCase& input) {
  const PathCase& path = input.path;
  const workpiece::CutSettings cut{path.feed, path.spindle_speed};
  workpiece::Lines lines;
  lines.start_W = vector_of(path.start);
  lines.along_W = vector_of(path.along);
  lines.step_over_W = vector_of(path.step_over);
  lines.count = path.lines;
  lines.clearance = path.clearance;
  switch (path.kind) {
    case PathKind::lines:
      return workpiece::lines(lines, cut);
    case PathKind::zigzag:
      return workpiece::zigzag(lines, cut);
    case PathKind::gcode:
      return read_gcode(read_text_file(path.file),
                        GcodeOptions{.file_name = path.file.filename().string()});
    case PathKind::points:
      break;
  }
  workpiece::Move move{workpiece::MoveKind::cut, {}, path.feed, path.spindle_speed, 1};
  for (const auto& point : path.points) move.points_W.push_back(vector_of(point));
  return workpiece::ToolPath({move});
}

simulate::Status status_of(control::LoopEnd end) {
  switch (end) {
    case control::LoopEnd::finished:
      return simulate::Status::finished;
    case control::LoopEnd::stopped:
      return simulate::Status::stopped;
    case control::LoopEnd::stalled:
      return simulate::Status::stalled;
    case control::LoopEnd::supervisor:
      return simulate::Status::supervisor;
    case control::LoopEnd::not_run:
      break;
  }
  return simulate::Status::not_run;
}

void mill(simulate::Workpiece& workpiece, const Progress& progress, const RunOptions& how,
          SimulatedRun& run) {
  const SimulateCase& input = run.input;
  simulate::Milling milling(workpiece, input.machine, input.force_limit);
  MadePlant made;
  if (how.make) {
    made = how.make(input, milling);
  } else {
    made.plant = std::make_unique<SimulatedPlant>(milling);
  }
  control::LoopOptions options;
  options.first_feed = input.machine.start_feed;
  options.path_length = workpiece.length();
  if (!how.make) options.supervisor = input.supervisor;
  options.clock = how.clock;
  options.real_time = how.real_time;
  control::Plant& seen = how.wrap ? how.wrap(*made.plant, input.controller.period) : *made.plant;
  run.loop = control::run(seen, input.controller, options, progress);
  run.steps = milling.steps();
  if (made.finish) made.finish(run);
  run.summary = simulate::summarise(run.steps, workpiece.lines(), status_of(run.loop.end));
  run.material_key = workpiece.material_key();
  run.material_unit = workpiece.material_unit();
  if (run.summary.status == simulate::Status::stalled) {
    run.warnings.push_back(
        fmt::format("{}: the controller asked for no feed any more at {:.1f} mm along the path; a "
                    "limits.min_feed_mm_per_s above 0 keeps it moving",
                    input.name, run.steps.back().position / units::mm));
  }
}

void mill_stock(const MadeStock& made, const Progress& progress, const RunOptions& how,
                SimulatedRun& run) {
  SimulateCase& input = run.input;
  simulate::StockJob job{input.cutter.cutter, input.bone.law, make_path(input)};
  for (const workpiece::Move& move : job.path.moves()) {
    if (move.kind == workpiece::MoveKind::cut) input.machine.spindle_speed = move.spindle_speed;
  }
  job.rapid_feed = input.path.rapid_feed;
  job.fibre_W = vector_of(input.fibre);
  job.sample_rate = input.machine.sample_rate;
  job.heat = input.heat;
  simulate::StockWorkpiece workpiece(*made.stock, std::move(job));
  run.before = made.stock;
  run.warnings = caveats_of(input.cutter, input.bone);
  // A block with a force scale of its own is the only stock whose force does not follow density.
  const bone::ForceDensityLaw& by_density = input.bone.density;
  const bool scaled = input.stock.kind == StockKind::ct ||
                      (input.stock.kind == StockKind::block && !input.stock.force_scale);
  if (scaled) {
    run.warnings.push_back(fmt::format(
        "the force follows the local density as (density / {:g} kg/m3)^{:g}: an assumption, as "
        "compressive strength does; no measured law of cutting force against density was found",
        by_density.reference.value, by_density.exponent.value));
  }
  run.warnings.insert(run.warnings.end(), made.remarks.begin(), made.remarks.end());
  if (input.heat) {
    run.warnings.push_back(
        "heat: shear strain, friction and rubbing shares, and the conductivity between cancellous "
        "and cortical bone are assumed; all work of the spindle counts as that of chips");
  }
  mill(workpiece, progress, how, run);
  if (workpiece.heat() != nullptr) {
    run.heat = workpiece.heat()->summary();
    const double hottest = run.heat->hottest - thermal::kZeroCelsius;
    if (hottest > thermal::kBoilingCelsius) {
      run.warnings.push_back(fmt::format(
          "{}: heat: bone at {:.0f} °C; the water in it would boil, which is not in the model: "
          "above 100 °C the temperatures are too high, and the dose counts as at 100 °C",
          input.name, hottest));
    }
  }
  run.after = std::make_shared<const workpiece::Stock>(workpiece.stock());
}

}  // namespace

std::vector<SimulatedRun> run_simulations(const std::vector<SimulateCase>& cases,
                                          const Progress& progress, const RunOptions& options) {
  std::vector<SimulatedRun> runs;
  std::map<std::string, MadeStock> stocks;  // by what they are made from
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const auto share_of_all = [&](std::string_view doing, double share) {
      return go_on(progress, doing,
                   (static_cast<double>(i) + share) / static_cast<double>(cases.size()));
    };
    SimulatedRun run;
    run.input = cases[i];
    if (run.input.stock.kind == StockKind::line_profile) {
      simulate::LineProfileWorkpiece workpiece(run.input.stock.profile);
      mill(workpiece, share_of_all, options, run);
    } else {
      const std::string key =
          run.input.expanded.at("stock").dump() + run.input.expanded.at("bone").dump();
      auto made = stocks.find(key);
      if (made == stocks.end()) {
        if (!share_of_all("making the stock", 0.0)) break;
        made = stocks.emplace(key, make_stock(run.input)).first;
      }
      mill_stock(made->second, share_of_all, options, run);
    }
    runs.push_back(std::move(run));
    if (runs.back().summary.status == simulate::Status::stopped) break;
  }
  return runs;
}

}  // namespace osteomill::io
