// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/simulated_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/control/loop.hpp"
#include "osteomill/io/path_maker.hpp"
#include "osteomill/io/simulated_plant.hpp"
#include "osteomill/io/stock_maker.hpp"
#include "osteomill/io/supervised_plant.hpp"
#include "osteomill/simulate/foresight.hpp"
#include "osteomill/simulate/stock_job.hpp"
#include "osteomill/thermal/thermal_dose.hpp"

namespace osteomill::io {
namespace {

/// m: root of the diffusivity of cortical bone (thermal::kCorticalBone) times a second.
constexpr double kHotLayer = 0.5e-3;

using geometry::Vector3;

constexpr numerics::SecondOrderLag kVeryFastServo{5000.0, 1.0};  // as good as an ideal one

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

using Fresh = std::function<std::unique_ptr<simulate::Workpiece>()>;

/// Finds the map by milling copies of what it shows, and makes the law that looks ahead in it.
control::ModelPredictive law_of(const SimulateCase& input, const Fresh& fresh,
                                const Progress& progress) {
  simulate::ForesightOptions options;
  options.fast_feed = input.controller.limits.highest;
  options.slow_feed = options.fast_feed / 6.0;
  if (input.temperature_limit) {
    options.body_temperature = input.heat->field.initial_temperature;
    if (input.machine.spindle) {
      // The end of the range that is farther away says more.
      const simulate::SpindleDrive& drive = *input.machine.spindle;
      const double now = input.machine.spindle_speed;
      options.other_speed = drive.highest / now > now / drive.lowest ? drive.highest : drive.lowest;
    }
  }
  const simulate::Foresight found = simulate::foresee(fresh, input.machine, options, progress);
  // Displaced as the contacts are that the plant predicts.
  const auto shift =
      static_cast<std::ptrdiff_t>(std::lround(input.machine.map_offset / found.spacing));
  const auto displaced = [&](const std::vector<double>& values) {
    std::vector<double> moved(values.size());
    const auto last = static_cast<std::ptrdiff_t>(values.size()) - 1;
    for (std::ptrdiff_t i = 0; i <= last; ++i) {
      moved[static_cast<std::size_t>(i)] =
          values[static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(i - shift, 0, last))];
    }
    return moved;
  };
  const control::Forecast forecast{
      found.spacing,
      displaced(found.gains),
      displaced(found.edges),
      displaced(found.peak_gains),
      displaced(found.peak_edges),
      {options.slow_feed, options.fast_feed, options.other_speed, displaced(found.slow_rises),
       displaced(found.fast_rises), displaced(found.other_rises)}};
  control::ModelPredictiveOptions law = input.predictive_options;
  law.limits.force = input.force_limit;
  law.map = input.map.trust;
  law.servo = input.machine.servo.value_or(kVeryFastServo);
  law.period = input.controller.period;
  law.flutes = input.machine.flutes;
  law.spindle_speed = input.machine.spindle_speed;
  if (input.machine.spindle) {
    const simulate::SpindleDrive& drive = *input.machine.spindle;
    law.spindle = control::SpindleHandle{drive.lowest, drive.highest, drive.time_constant};
  }
  if (input.temperature_limit) {
    law.limits.temperature = *input.temperature_limit;
    law.limits.body_temperature = options.body_temperature;
  }
  return {law, forecast};
}

void tell(const RunOptions& how, std::string text, SimulatedRun& run) {
  if (how.warn) how.warn(text);
  run.warnings.push_back(std::move(text));
}

/// Bone that goes under the flat end or at the shank, where the models have no edges.
void warn_of_bone_without_force(const RunOptions& how, SimulatedRun& run) {
  constexpr double kWorthSaying = 0.01;
  double all = 0.0, without = 0.0;
  for (const simulate::Step& step : run.steps) {
    all += step.removed_volume;
    if (step.mean_force == 0.0) without += step.removed_volume;
  }
  if (without <= kWorthSaying * all) return;
  tell(how,
       fmt::format("{}: {:.3g} mm³ of bone, {:.0f} % of what goes, go without force or heat: in a "
                   "plunge under the flat end of the cutter, or at its shank, where no edge is "
                   "modelled; plunge with a ball, or beside the bone",
                   run.input.name, without / units::mm3, 100.0 * without / all),
       run);
}

/// `stock`: the workpiece again, where there is one to be kept in checkpoints.
void mill(simulate::Workpiece& workpiece, simulate::StockWorkpiece* stock, const Progress& progress,
          const RunOptions& how, SimulatedRun& run) {
  const SimulateCase& input = run.input;
  simulate::Milling milling(workpiece, input.machine, input.force_limit);
  MadePlant made;
  if (how.make) {
    made = how.make(run, milling);
  } else {
    made.plant = std::make_unique<SimulatedPlant>(milling, how.on_samples);
  }
  control::LoopOptions options;
  options.first_feed = input.machine.start_feed;
  options.path_length = workpiece.length();
  if (!how.make) options.supervisor = input.supervisor;
  options.clock = how.clock;
  options.real_time = how.real_time;
  options.on_event = how.on_event;
  std::unique_ptr<CheckpointedPlant> kept;
  if (how.checkpoint && stock != nullptr) {
    kept = std::make_unique<CheckpointedPlant>(*made.plant, milling, *stock, input.name,
                                               input.expanded.dump(), *how.checkpoint);
    if (kept->resumed() > 0)
      how.checkpoint->say(fmt::format("{}: goes on from its checkpoint at {:.2f} s of the run",
                                      input.name, milling.steps().back().time));
  }
  control::Plant& plant = kept ? *kept : *made.plant;
  control::Plant* seen = how.wrap ? &how.wrap(plant, run, workpiece.length()) : &plant;
  std::optional<SupervisedPlant> supervised;
  if (how.real_time && options.supervisor) {
    SupervisedOptions watch;
    watch.limits = *options.supervisor;
    watch.clock = how.clock;
    watch.on_event = how.on_event;
    supervised.emplace(*seen, watch);
    seen = &*supervised;
    options.supervisor.reset();
  }
  run.loop = control::run(*seen, input.controller, options, progress);
  if (supervised) {
    supervised->finish(run.loop);
    run.stop = supervised->stop();
  }
  if (kept) kept->save();
  if (input.robot && !how.make) {
    tell(how,
         input.name +
             ": [robot] moves the tool with --plant linuxcnc; here the tool is where its "
             "path has it",
         run);
  }
  run.steps = milling.steps();
  warn_of_bone_without_force(how, run);
  if (made.finish) made.finish(run);
  run.summary = simulate::summarise(run.steps, workpiece.lines(), status_of(run.loop.end));
  run.material_key = workpiece.material_key();
  run.material_unit = workpiece.material_unit();
  if (run.summary.status == simulate::Status::stalled) {
    tell(how,
         fmt::format("{}: the controller asked for no feed any more at {:.1f} mm along the path; a "
                     "limits.min_feed_mm_per_s above 0 keeps it moving",
                     input.name, run.steps.back().position / units::mm),
         run);
  }
}

/// What is milled, and how, in a stock.
struct StockSetup {
  MadeRegions regions;
  MadePath path;
  simulate::StockJob job;
};

/// Makes path and job, and the law where it looks ahead in the stock.
StockSetup set_up(const MadeStock& made, const Progress& progress, SimulateCase& input) {
  MadeRegions regions = make_regions(input.regions, input.stock);
  MadePath path = make_path(input.path, input.cutter.cutter, *made.stock, regions);
  const workpiece::ToolPath tool_path = path.path;
  StockSetup setup{
      std::move(regions), std::move(path), {input.cutter.cutter, input.bone.law, tool_path}};
  simulate::StockJob& job = setup.job;
  for (const workpiece::Move& move : job.path.moves()) {
    if (move.kind == workpiece::MoveKind::cut) input.machine.spindle_speed = move.spindle_speed;
  }
  job.rapid_feed = input.path.rapid_feed;
  job.fibre_W = made.fibre_W;
  job.fibre_at = made.fibre_at;
  job.sample_rate = input.machine.sample_rate;
  job.heat = input.heat;
  job.no_go = setup.regions.no_go;
  if (input.model_predictive) {
    simulate::StockJob copy = job;
    if (!input.temperature_limit) copy.heat.reset();
    copy.no_go.clear();
    input.controller.law = law_of(
        input, [&] { return std::make_unique<simulate::StockWorkpiece>(*made.stock, copy); },
        progress);
  }
  if (input.tool) job.tool = compliance_of(*input.tool);
  return setup;
}

/// When the bone that stays got hotter than the limit, and what could not help it.
void warn_of_limit(double limit, const RunOptions& how, SimulatedRun& run) {
  double hottest = 0.0, first = -1.0;
  for (const simulate::Step& step : run.steps) {
    hottest = std::max(hottest, step.temperature);
    if (first < 0.0 && step.temperature > limit) first = step.time;
  }
  if (first < 0.0) return;
  tell(how,
       fmt::format(
           "{}: bone that stays reached {:.0f} °C, above limits.temperature_c = {:g} from {:.2f} s "
           "on: no feed{} within the other limits keeps it; a larger force or feed limit, a slower "
           "spindle or irrigation would",
           run.input.name, hottest - thermal::kZeroCelsius, limit - thermal::kZeroCelsius, first,
           run.input.machine.spindle ? " and no speed of the spindle" : ""),
       run);
}

void mill_stock(const MadeStock& made, const Progress& progress, const RunOptions& how,
                SimulatedRun& run) {
  SimulateCase& input = run.input;
  // What is known of the bone is said before anything can fail.
  for (std::string& caveat : caveats_of(input.cutter, input.bone))
    tell(how, std::move(caveat), run);
  const bone::ForceDensityLaw& by_density = input.bone.density;
  if (follows_density(input.stock)) {
    tell(how,
         fmt::format("the force follows the local density as (density / {:g} kg/m3)^{:g}: an "
                     "assumption, as compressive strength does; no measured law of cutting force "
                     "against density was found",
                     by_density.reference.value, by_density.exponent.value),
         run);
  }
  const cutting::RunOut& run_out = input.cutter.cutter.run_out;
  if (run_out.offset != 0.0 || run_out.tilt != 0.0) {
    tell(how,
         "the run-out of the cutter counts in the forces only: bone is removed as if it ran true",
         run);
  }
  for (const std::string& remark : made.remarks) tell(how, remark, run);
  if (input.heat) {
    tell(how,
         "heat: shear strain, friction and rubbing shares, the least chip, and the conductivity "
         "between cancellous and cortical bone are assumed; rubbing counts apart where the law has "
         "an edge force",
         run);
    if (input.cutter.cutter.shape != cutting::CutterShape::ball)
      tell(how,
           "heat: the flat end of a cutter heats nothing here: a floor that it mills is warmed by "
           "conduction from the walls only",
           run);
    if (input.heat->spacing > kHotLayer)
      tell(how,
           fmt::format("heat: cells of {:g} mm are wider than the layer that is hot in the first "
                       "second, about {:g} mm: the hottest bone and the depth of necrosis come out "
                       "low; give heat.spacing_mm = {:g} or less",
                       input.heat->spacing / units::mm, kHotLayer / units::mm,
                       kHotLayer / units::mm),
           run);
  }
  StockSetup setup = set_up(made, progress, input);
  const MadeRegions& regions = setup.regions;
  MadePath& path = setup.path;
  for (const std::string& remark : regions.remarks) tell(how, remark, run);
  simulate::StockWorkpiece workpiece(*made.stock, std::move(setup.job));
  run.before = made.stock;
  run.stock = made.report;
  run.path_report = std::move(path.report);
  run.path = std::move(path.path);
  for (const workpiece::NoGo& region : regions.no_go) run.no_go.push_back(region.surface_W);
  mill(workpiece, &workpiece, progress, how, run);
  if (workpiece.heat() != nullptr) {
    run.heat = workpiece.heat()->summary();
    if (input.temperature_limit) warn_of_limit(*input.temperature_limit, how, run);
    const double hottest = run.heat->hottest - thermal::kZeroCelsius;
    if (hottest > thermal::kBoilingCelsius) {
      tell(
          how,
          fmt::format(
              "{}: heat: bone at {:.0f} °C; the water in it would boil, which is not in the "
              "model: above 100 °C the temperatures are too high, and the dose counts as at 100 °C",
              input.name, hottest),
          run);
    }
  }
  run.after = std::make_shared<const workpiece::Stock>(workpiece.stock());
  if (regions.plan) run.plan = plan_report(*run.before, *run.after, regions.plan);
  if (input.finish && run.summary.status == simulate::Status::finished) {
    Finish finish = finish_of(*run.before, *run.after, *input.regions.plan, regions.plan, *run.path,
                              input.cutter.cutter, *input.finish);
    if (input.tool) {
      const simulate::BentTool bent = workpiece.bent_tool();
      finish.report["tool_deflection"] = {{"mean_um", bent.mean / units::um},
                                          {"largest_um", bent.largest / units::um}};
    }
    run.finish = std::make_shared<const Finish>(std::move(finish));
  }
}

}  // namespace

void settle_law(SimulateCase& input, const Progress& progress) {
  if (!input.model_predictive) return;
  if (input.stock.kind != StockKind::line_profile) {
    set_up(make_stock(input.stock, input.bone), progress, input);
    return;
  }
  simulate::LineProfile shown = input.stock.profile;
  if (input.map.shows == BoneMapCase::Shows::plan) shown.variation.clear();
  input.controller.law = law_of(
      input, [&] { return std::make_unique<simulate::LineProfileWorkpiece>(shown); }, progress);
}

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
      settle_law(run.input, share_of_all);
      simulate::LineProfileWorkpiece workpiece(run.input.stock.profile);
      mill(workpiece, nullptr, share_of_all, options, run);
    } else {
      const std::string key =
          run.input.expanded.at("stock").dump() + run.input.expanded.at("bone").dump();
      auto made = stocks.find(key);
      if (made == stocks.end()) {
        if (!share_of_all("making the stock", 0.0)) break;
        made = stocks.emplace(key, make_stock(run.input.stock, run.input.bone)).first;
      }
      mill_stock(made->second, share_of_all, options, run);
    }
    runs.push_back(std::move(run));
    if (runs.back().summary.status == simulate::Status::stopped) break;
  }
  return runs;
}

}  // namespace osteomill::io
