// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <memory>

#include "command.hpp"
#include "live_view.hpp"
#include "osteomill/base/error.hpp"
#include "osteomill/io/case_file.hpp"
#include "osteomill/io/control_case.hpp"
#include "osteomill/io/linuxcnc_run.hpp"
#include "osteomill/io/paced_plant.hpp"
#include "osteomill/io/recording.hpp"
#include "osteomill/io/run_directory.hpp"
#include "osteomill/io/run_record.hpp"
#include "osteomill/io/simulate_report.hpp"
#include "osteomill/io/simulate_result.hpp"
#include "osteomill/io/text_file.hpp"
#include "simulated_runs.hpp"

namespace osteomill::cli {
namespace {

struct Arguments {
  CaseArguments common;
  std::string plant = "simulate";
  std::string sensor = "fake";
  std::string name;  ///< of the only run; empty: all
  std::filesystem::path recording;
  std::filesystem::path machine;  ///< socket of a LinuxCNC that runs; empty: it is started
  std::filesystem::path program;  ///< where to write the program for LinuxCNC, and no more
  bool paced = false;
};

double now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// The runs of the case, or the one that was named.
std::vector<io::SimulateCase> chosen(const Arguments& arguments) {
  std::vector<io::CaseRun> runs =
      io::read_case(arguments.common.case_file, arguments.common.overrides);
  if (!arguments.name.empty()) {
    std::erase_if(runs, [&](const io::CaseRun& run) { return run.name != arguments.name; });
    if (runs.empty()) {
      throw InvalidInput(Fault{"--run", arguments.name, "is no run of this case", ""});
    }
  }
  return io::read_control_cases(runs);
}

/// A recording given to the controller again.
void replay(const Arguments& arguments, const io::SimulateCase& input) {
  const io::Recording recording = io::read_recording(arguments.recording);
  const io::Replay done = io::replay(recording.periods, input.controller, input.machine.start_feed);
  if (arguments.common.format == Format::json) {
    print_json({{"periods", done.periods},
                {"different_commands", done.different},
                {"force_samples", recording.samples.size()},
                {"events", recording.events.size()}});
  } else {
    fmt::print("{} periods, {} commands differ; {} force samples, {} events\n", done.periods,
               done.different, recording.samples.size(), recording.events.size());
    for (const control::LoopEvent& event : recording.events) {
      fmt::print("{:.3f} s: {}\n", event.time, control::name(event.cause));
    }
  }
  if (done.different > 0) {
    throw NoSolution(
        fmt::format("period {} has another command than the recording, which is of another case "
                    "or another version",
                    done.first_difference));
  }
}

/// The plants around the simulated one; they live as long as the runs.
struct Around {
  std::unique_ptr<io::LinuxcncRuns> linuxcnc;
  std::vector<std::unique_ptr<io::PacedPlant>> paced;
  std::unique_ptr<io::Recorder> recorder;
  std::unique_ptr<io::RecordedPlant> recorded;
  std::unique_ptr<LiveView> view;
};

void finish_recording(io::Recorder& recorder) {
  recorder.finish();
  if (recorder.dropped() > 0) {
    warn(fmt::format("the disk was too slow: {} records are missing in the recording",
                     recorder.dropped()));
  }
}

void warn_of_time() {
  warn("no real-time rights (SCHED_FIFO, locked memory): the loop runs at normal priority");
}

io::RunOptions options_of(const Arguments& arguments, Around& around) {
  io::RunOptions options;
  options.warn = warn;
  options.clock = now;
  options.real_time = arguments.paced || arguments.plant == "linuxcnc";
  if (options.real_time) around.view = std::make_unique<LiveView>();
  if (!arguments.recording.empty()) {
    around.recorder = std::make_unique<io::Recorder>(
        arguments.recording, io::RecorderOptions{.real_time = options.real_time});
    options.on_samples = [&](std::span<const io::netft::Sample> samples) {
      around.recorder->add(samples);
    };
  }
  const auto seen = [&](const control::LoopEvent& event) {
    if (around.view) around.view->event(event);
  };
  options.on_event = [&around, seen](const control::LoopEvent& event) {
    if (around.recorder) around.recorder->add(event);
    seen(event);
  };
  if (arguments.plant == "linuxcnc") {
    // Beside this program in the folder of the build.
    const auto here = std::filesystem::read_symlink("/proc/self/exe").parent_path();
    around.linuxcnc = std::make_unique<io::LinuxcncRuns>(io::LinuxcncRunOptions{
        here.parent_path() / "linuxcnc" / "osteomill_machine", arguments.machine,
        arguments.sensor == "netft", now, around.recorder.get(), seen});
    options.make = [&around](const io::SimulatedRun& run, simulate::Milling& milling) {
      io::MadePlant made = around.linuxcnc->make(run, milling);
      if (!around.linuxcnc->real_time()) warn_of_time();
      return made;
    };
  }
  if (!around.view && !around.recorder) return options;
  options.wrap = [&](control::Plant& plant, const io::SimulatedRun& run,
                     double length) -> control::Plant& {
    control::Plant* outer = &plant;
    if (arguments.paced) {
      around.paced.push_back(std::make_unique<io::PacedPlant>(*outer, run.input.controller.period));
      outer = around.paced.back().get();
      if (!around.paced.back()->real_time() && around.paced.size() == 1) {
        warn_of_time();
      }
    }
    if (around.view) {
      outer = &around.view->watch(*outer, {run.input.name, length, run.input.force_limit,
                                           run.input.controller.limits.highest});
    }
    if (around.recorder) {
      around.recorded = std::make_unique<io::RecordedPlant>(*outer, *around.recorder);
      outer = around.recorded.get();
    }
    return *outer;
  };
  return options;
}

void write_directory(const Arguments& arguments, const std::vector<io::SimulatedRun>& runs,
                     const nlohmann::ordered_json& summary, double wall_time) {
  const std::string program = "osteomill " OSTEOMILL_VERSION;
  io::RunDirectory output(arguments.common.directory);
  io::write_run_json(output.file("run.json"),
                     {program, "control", io::case_of(runs), summary, wall_time});
  io::write_signals(io::signals_of(runs), output.file("signals.h5"));
  io::ReportData report = io::report_of(runs, arguments.common.case_file.stem().string(), program);
  report.scene.reset();
  io::write_report(output.file("report.html"), report);
  output.commit();
}

/// The path of a stock is known when the run is made: it is run on a machine that is there already.
void write_program(const Arguments& arguments, const std::vector<io::SimulateCase>& cases) {
  class Arrived final : public control::Plant {
   public:
    control::Observation start() override { return advance({}); }
    control::Observation advance(const control::FeedCommand&) override {
      control::Observation seen;
      seen.finished = true;
      return seen;
    }
  };
  io::RunOptions options;
  options.make = [&](const io::SimulatedRun& run, simulate::Milling&) {
    io::write_text_file(arguments.program, io::machine_program(run));
    return io::MadePlant{std::make_unique<Arrived>(), {}};
  };
  io::run_simulations(cases, console_progress(), options);
}

/// What does not go together, all at once.
void check_options(const Arguments& arguments, const std::vector<io::SimulateCase>& cases) {
  const std::size_t runs = cases.size();
  const bool drives_spindle =
      std::any_of(cases.begin(), cases.end(),
                  [](const io::SimulateCase& one) { return one.machine.spindle.has_value(); });
  std::vector<Fault> faults;
  const bool linuxcnc = arguments.plant == "linuxcnc";
  if (arguments.plant == "replay" && arguments.recording.empty()) {
    faults.push_back({"--plant", "replay", "needs --recording FILE", ""});
  }
  if (arguments.sensor == "netft" && !linuxcnc) {
    faults.push_back({"--sensor", "netft", "measures a machine: needs --plant linuxcnc",
                      "a simulated plant has the forces of its bone: --sensor fake"});
  }
  if (linuxcnc && arguments.paced) {
    faults.push_back({"--paced", "", "does not go with --plant linuxcnc, which sets the pace", ""});
  }
  if (!linuxcnc && !arguments.machine.empty()) {
    faults.push_back({"--machine", arguments.machine.string(), "needs --plant linuxcnc", ""});
  }
  if (linuxcnc && drives_spindle) {
    faults.push_back({"machine.spindle", "",
                      "is for --plant simulate: LinuxCNC keeps the "
                      "programmed speed",
                      "--set is not enough: leave the table out"});
  }
  const std::string many = std::to_string(runs) + " runs";
  if (runs != 1 && !arguments.recording.empty()) {
    faults.push_back({"--recording", many, "takes a case with one run", "name it with --run"});
  }
  if (runs != 1 && !arguments.machine.empty()) {
    faults.push_back({"--machine", many, "takes a case with one run", "name it with --run"});
  }
  if (runs != 1 && !arguments.program.empty()) {
    faults.push_back({"--program", many, "takes a case with one run", "name it with --run"});
  }
  if (!faults.empty()) throw InvalidInput(faults);
}

void run(const Arguments& arguments) {
  const double begin = now();
  const std::vector<io::SimulateCase> cases = chosen(arguments);
  check_options(arguments, cases);
  if (arguments.plant == "replay") {
    io::SimulateCase input = cases.front();
    io::settle_law(input, console_progress());
    return replay(arguments, input);
  }
  if (!arguments.program.empty()) return write_program(arguments, cases);

  if (arguments.common.format == Format::table) {
    fmt::print("{}\n", io::supervisor_sentence(cases));
    std::fflush(stdout);  // before the view on the other stream
  }
  Around around;
  const io::RunOptions options = options_of(arguments, around);
  const Progress shown = console_progress();
  const auto progress = [&](std::string_view doing, double share) {
    // The view shows the milling; it does so outside the loop's thread.
    return around.view && doing == "milling" ? !interrupted() : shown(doing, share);
  };
  const std::vector<io::SimulatedRun> runs = io::run_simulations(cases, progress, options);
  if (around.view) around.view->end();
  if (around.recorder) finish_recording(*around.recorder);
  double lateness = -1.0;
  for (const auto& plant : around.paced) lateness = std::max(lateness, plant->largest_lateness());
  const double wall_time = now() - begin;

  const nlohmann::ordered_json document = io::control_document_of(runs, wall_time, lateness);
  print_runs(arguments.common.format, runs, document, io::variants_of(runs));
  if (!arguments.common.directory.empty()) write_directory(arguments, runs, document, wall_time);
  if (interrupted()) throw Interrupted{};
  for (const io::SimulatedRun& done : runs) {
    for (const control::LoopEvent& event : done.loop.events) {
      throw SafetyStop(fmt::format("{}: the supervisor stopped at {:.2f} s: {}", done.input.name,
                                   event.time, control::name(event.cause)));
    }
  }
}

}  // namespace

void add_control(CLI::App& program) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command = program.add_subcommand(
      "control",
      "run the controller under its supervisor on a plant; research only, no medical device");
  add_case_arguments(*command, arguments->common);
  command->add_option("--plant", arguments->plant, "what is controlled")
      ->check(CLI::IsMember({"simulate", "replay", "linuxcnc"}))
      ->capture_default_str();
  command->add_option("--sensor", arguments->sensor, "where the forces come from")
      ->check(CLI::IsMember({"fake", "netft"}))
      ->capture_default_str();
  command->add_option("--run", arguments->name, "only the run of this name");
  command->add_option("--recording", arguments->recording,
                      "every period as HDF5: written, or read with --plant replay");
  command->add_option("--machine", arguments->machine,
                      "socket of a LinuxCNC that runs; without it a simulated machine is started");
  command->add_option("--program", arguments->program, "write the program for LinuxCNC and end");
  command->add_flag("--paced", arguments->paced, "in real time rather than as fast as it goes");
  command->callback([arguments] { run(*arguments); });
}

}  // namespace osteomill::cli
