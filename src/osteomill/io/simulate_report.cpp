// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/simulate_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <limits>
#include <set>

#include "osteomill/base/units.hpp"
#include "osteomill/io/run_record.hpp"
#include "osteomill/io/simulate_result.hpp"
#include "osteomill/thermal/thermal_dose.hpp"

namespace osteomill::io {
namespace {

using simulate::Step;

/// One number of every step.
template <class Value>
std::vector<double> each(const SimulatedRun& run, const Value& value) {
  std::vector<double> values;
  values.reserve(run.steps.size());
  for (const Step& step : run.steps) values.push_back(value(step));
  return values;
}

std::vector<double> times(const SimulatedRun& run) {
  return each(run, [&](const Step& s) { return s.time - run.summary.first_contact; });
}

std::vector<double> mean_forces(const SimulatedRun& run) {
  return each(run, [](const Step& s) { return s.mean_force; });
}

std::vector<double> peak_forces(const SimulatedRun& run) {
  return each(run, [](const Step& s) { return s.peak_force; });
}

std::vector<double> feeds(const SimulatedRun& run) {
  return each(run, [](const Step& s) { return s.feed / units::mm_per_s; });
}

std::vector<double> commands(const SimulatedRun& run) {
  return each(run, [](const Step& s) { return s.command / units::mm_per_s; });
}

std::vector<double> materials(const SimulatedRun& run) {
  return each(run, [&](const Step& s) { return s.material / run.material_unit; });
}

struct Material {
  std::string name;
  std::string unit;
};
Material material_of(const SimulatedRun& run) {
  return run.input.stock.kind == StockKind::line_profile ? Material{"cutting gain", "N/(mm/s)"}
                                                         : Material{"density", "kg/m3"};
}

/// Names of what is cut, for the strip: bone of at least this is called cortical. On a CT 1000
/// kg/m3 (about 800 HU) lies between the diploe and the tables of a skull; a profile names its own
/// halves.
double cortical_from(const SimulatedRun& run) {
  if (run.input.stock.kind != StockKind::line_profile) return 1000.0;
  double highest = 0.0;
  for (const simulate::ProfileZone& zone : run.input.stock.profile.zones) {
    if (zone.lines.empty() && zone.from == 0.0) highest = std::max(highest, zone.gain);
  }
  return 0.5 * highest;
}

/// Neighbouring steps of one label as intervals.
template <class Label>
std::vector<ReportInterval> intervals_of(const SimulatedRun& run, const Label& label) {
  std::vector<ReportInterval> intervals;
  const double zero = run.summary.first_contact;
  double start = -zero;
  for (const Step& step : run.steps) {
    const std::string name = label(step);
    const double end = step.time - zero;
    if (!intervals.empty() && intervals.back().label == name && intervals.back().to_s == start) {
      intervals.back().to_s = end;
    } else if (!name.empty()) {
      intervals.push_back({start, end, name});
    }
    start = end;
  }
  return intervals;
}

std::vector<ReportStrip> strips_of(const SimulatedRun& run) {
  const double limit = cortical_from(run);
  ReportStrip material{"material", intervals_of(run, [&](const Step& step) -> std::string {
                         if (step.samples_in_contact == 0) return "air";
                         return step.material >= limit ? "cortical" : "cancellous";
                       })};
  ReportStrip line{"line", intervals_of(run, [](const Step& step) {
                     return fmt::format("line {}", step.line + 1);
                   })};
  ReportStrip mode{"mode", intervals_of(run, [](const Step& step) {
                     return std::string(control::name(static_cast<control::Mode>(step.mode)));
                   })};
  ReportStrip saturated{"feed at its largest", {}, true};
  for (const auto& interval : run.summary.saturated_intervals) {
    saturated.intervals.push_back({interval[0], interval[1], "feed at its largest"});
  }
  ReportStrip bound{
      "limited by", intervals_of(run, [](const Step& step) -> std::string {
        return step.bound == 0 ? "" : control::name(static_cast<control::Bound>(step.bound));
      })};
  std::vector<ReportStrip> strips = {material};
  // One line, or one mode throughout, is nothing to show.
  for (const ReportStrip& strip : {line, mode, bound}) {
    if (strip.intervals.size() > 1) strips.push_back(strip);
  }
  if (!saturated.intervals.empty()) strips.push_back(saturated);
  return strips;
}

/// Removed since the start, mm³.
std::vector<double> removed_volumes(const SimulatedRun& run) {
  double removed = 0.0;
  return each(run, [&](const Step& s) { return (removed += s.removed_volume) / units::mm3; });
}

ReportPath path_of(const SimulatedRun& run) {
  ReportPath path;
  path.time_s = times(run);
  path.value = peak_forces(run);
  const bool turns = run.path && !run.path->upright();
  if (!turns) path.axis = {geometry::Vector3::UnitZ()};
  const bool profile = run.input.stock.kind == StockKind::line_profile;
  for (const Step& step : run.steps) {
    // A profile has no way from the end of a line to the start of the next one.
    const std::size_t i = path.tip.size();
    if (profile && i > 0 && step.line != run.steps[i - 1].line) {
      path.value[i] = std::numeric_limits<double>::quiet_NaN();
    }
    path.tip.push_back(step.tip_W);
    if (turns) path.axis.push_back(step.axis_W);
  }
  return path;
}

ReportRun run_of(const SimulatedRun& run) {
  ReportRun made;
  made.name = run.input.name;
  made.time_s = times(run);
  const Material material = material_of(run);
  made.signals = {
      {"mean force", "N", mean_forces(run), {}, "limit", "force"},
      {"peak force", "N", peak_forces(run), run.input.force_limit, "limit", "force"},
      {"feed", "mm/s", feeds(run), {}, "limit", "feed"},
      {"command", "mm/s", commands(run), run.input.controller.limits.highest / units::mm_per_s,
       "largest", "feed"},
      {material.name, material.unit, materials(run), {}, "limit", material.name},
      {"removed volume", "mm³", removed_volumes(run)},
  };
  if (run.input.machine.spindle) {
    made.signals.push_back({"spindle speed", "rpm",
                            each(run, [](const Step& s) { return s.spindle_speed / units::rpm; })});
  }
  if (run.after) {
    made.signals.push_back({"spindle torque", "N mm",
                            each(run, [](const Step& s) { return s.mean_torque / units::n_mm; })});
  }
  made.strips = strips_of(run);
  if (!run.steps.empty()) {
    made.events.push_back({0.0, "first contact"});
    made.events.push_back({run.summary.cutting_time, "last exit"});
  }
  made.path = path_of(run);
  return made;
}

ReportTable table_for(const std::vector<SimulatedRun>& runs) {
  ReportTable table;
  table.columns = {
      {"run"},
      {"status"},
      {"cutting time", "s", 1, true, "first contact to last exit, air between included"},
      {"mean force", "N", 2, true, "of the magnitude, over the time in contact"},
      {"peak force", "N", 1, true, "largest sample of the 8 kHz sensor"},
      {"above limit", "s", 3, true, "time with the force above the limit"},
      {"removed", "mm3", 1},
      {"largest feed", "mm/s", 2, true}};
  for (const RunRow& run : rows_of(runs, true)) {
    const simulate::Summary& s = run.summary;
    table.rows.push_back({run.name, run.status, s.cutting_time, s.mean_force, s.peak_force,
                          s.time_above_limit, s.removed_volume / units::mm3,
                          s.max_feed / units::mm_per_s});
  }
  return table;
}

/// Of the variants of a run the one with the largest force is shown; other runs all are.
bool worst_variant(const std::vector<SimulatedRun>& runs, const SimulatedRun& run) {
  if (run.input.variant_of.empty()) return true;
  const auto worse = [&](const SimulatedRun& other) {
    return other.input.variant_of == run.input.variant_of &&
           other.summary.peak_force > run.summary.peak_force;
  };
  return std::none_of(runs.begin(), runs.end(), worse);
}

ReportNote::Kind kind_of(bone::Obtained obtained) {
  return obtained == bone::Obtained::measured || obtained == bone::Obtained::digitised
             ? ReportNote::Kind::information
             : ReportNote::Kind::assumption;
}

/// What the law of a stock rests on. A profile has its note instead.
std::vector<ReportNote> grounds_of(const SimulatedRun& run) {
  if (!run.after) return {};
  const bone::Provenance& law = run.input.bone.provenance;
  std::vector<ReportNote> notes = {
      {kind_of(law.obtained),
       fmt::format("Cutting law of {}.", law.specimen.empty() ? "the case" : law.specimen),
       std::string(bone::name_of(law.obtained)), law.source}};
  if (run.input.stock.kind == StockKind::ct) {
    const bone::DensityFromCt& line = run.input.stock.bone_from_ct.density;
    notes.push_back({kind_of(line.per_hounsfield.obtained),
                     fmt::format("Apparent density = {:g} + {:g} HU kg/m³; bone from {:g} HU.",
                                 line.at_zero.value, line.per_hounsfield.value,
                                 run.input.stock.bone_from_ct.threshold_hu),
                     std::string(bone::name_of(line.per_hounsfield.obtained)),
                     std::string(line.per_hounsfield.source)});
  }
  return notes;
}

std::vector<ReportNote> notes_for(const std::vector<SimulatedRun>& runs) {
  std::vector<ReportNote> notes;
  std::set<std::string> said;
  const auto add = [&](ReportNote note) {
    if (!note.text.empty() && said.insert(note.text).second) notes.push_back(std::move(note));
  };
  for (const SimulatedRun& run : runs) {
    add({ReportNote::Kind::assumption, run.input.stock.note});
    for (const std::string& warning : run.warnings) add({ReportNote::Kind::warning, warning});
    for (ReportNote& note : grounds_of(run)) add(std::move(note));
  }
  add({ReportNote::Kind::information, "Times count from the first contact with bone."});
  return notes;
}

std::string percent(double from, double to) {
  return fmt::format("{}{:.0f}", to < from ? "−" : "+", 100.0 * std::abs(to - from) / from);
}

void compare(const SimulatedRun& adapted, const SimulatedRun& fixed, ReportData& data) {
  const simulate::Summary &a = adapted.summary, &f = fixed.summary;
  if (!(f.cutting_time > 0.0) || !(f.peak_force > 0.0)) return;
  const std::string& name = adapted.input.name;
  data.highlights.push_back(
      {percent(f.cutting_time, a.cutting_time), "%", "cutting time, " + name,
       fmt::format("{:.1f} s against {:.1f} s at constant feed", a.cutting_time, f.cutting_time)});
  data.highlights.push_back({percent(f.peak_force, a.peak_force), "%", "peak force, " + name,
                             fmt::format("{:.1f} N against {:.1f} N", a.peak_force, f.peak_force)});
  data.highlights.push_back({fmt::format("{:.2f}", a.time_above_limit), "s",
                             fmt::format("above {:g} N, {}", adapted.input.force_limit, name),
                             fmt::format("{:.2f} s at constant feed", f.time_above_limit)});
}

/// "cranium_ct" is "Cranium ct" to a reader.
std::string heading(std::string name) {
  std::replace(name.begin(), name.end(), '_', ' ');
  if (!name.empty()) name[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(name[0])));
  return name;
}

std::string subtitle_of(const SimulatedRun& run) {
  const cutting::Cutter& cutter = run.input.cutter.cutter;
  if (run.input.stock.kind == StockKind::line_profile) {
    return fmt::format("{:g} rpm along a line profile of cutting gain",
                       run.input.machine.spindle_speed / units::rpm);
  }
  const std::string shape = run.input.expanded.at("cutter").at("shape");
  const char* bone = run.input.stock.kind == StockKind::ct     ? "bone from a CT scan"
                     : run.input.stock.kind == StockKind::mesh ? "bone from a surface"
                                                               : "phantom";
  return fmt::format("{:g} mm {} cutter with {} flutes at {:.0f} rpm · {}, voxels of {:g} mm",
                     2.0 * cutter.radius / units::mm, shape, cutter.flutes,
                     run.input.machine.spindle_speed / units::rpm, bone,
                     run.input.stock.spacing / units::mm);
}

}  // namespace

SignalsFile signals_of(const std::vector<SimulatedRun>& runs) {
  SignalsFile file;
  for (const SimulatedRun& run : runs) {
    SignalRun made;
    made.name = run.input.name;
    const auto add = [&](const char* name, const char* unit, const auto& value,
                         const char* about = "") {
      made.signals.push_back({name, unit, each(run, value), about});
    };
    made.signals.push_back({"time", "s", times(run), "since the first contact, end of the period"});
    for (int axis = 0; axis < 3; ++axis) {
      const std::string name = fmt::format("position_{}", "xyz"[axis]);
      add(
          name.c_str(), "mm", [&](const Step& s) { return s.tip_W[axis] / units::mm; },
          "of the tip in the work frame");
    }
    if (run.path && !run.path->upright()) {
      for (int axis = 0; axis < 3; ++axis) {
        const std::string name = fmt::format("axis_{}", "xyz"[axis]);
        add(
            name.c_str(), "1", [&](const Step& s) { return s.axis_W[axis]; },
            "of the tool, from the tip to the spindle, in the work frame");
      }
    }
    add("path", "mm", [](const Step& s) { return s.position / units::mm; }, "along the path");
    add("line", "1", [](const Step& s) { return s.line + 1; });
    add("feed_command", "mm/s", [](const Step& s) { return s.command / units::mm_per_s; });
    add("spindle_speed", "rpm", [](const Step& s) { return s.spindle_speed / units::rpm; });
    add("feed", "mm/s", [](const Step& s) { return s.feed / units::mm_per_s; });
    for (int axis = 0; axis < 3; ++axis) {
      const std::string name = fmt::format("force_{}", "xyz"[axis]);
      add(
          name.c_str(), "N", [&](const Step& s) { return s.mean_force_W[axis]; },
          "mean over the period, on the tool, in the work frame");
    }
    add(
        "mean_force", "N", [](const Step& s) { return s.mean_force; },
        "mean of the magnitude over whole revolutions: what the controller sees");
    add("peak_force", "N", [](const Step& s) { return s.peak_force; });
    add("torque", "N mm", [](const Step& s) { return s.mean_torque / units::n_mm; });
    add(
        "removed_volume", "mm3", [](const Step& s) { return s.removed_volume / units::mm3; },
        "in the period");
    if (run.path) {
      add(
          "contact_length", "mm", [](const Step& s) { return s.contact_length / units::mm; },
          "of the edges in bone, mean over a revolution");
    }
    const Material material = material_of(run);
    made.signals.push_back({"material", material.unit, materials(run), material.name});
    add("feed_work", "J", [](const Step& s) { return s.feed_work; }, "in the period");
    add("spindle_work", "J", [](const Step& s) { return s.spindle_work; }, "in the period");
    add(
        "mode", "1", [](const Step& s) { return s.mode; },
        "0 constant, 1 adaptive, 2 predictive, 3 stopped");
    add(
        "limited_by", "1", [](const Step& s) { return s.bound; },
        "0 none, 1 largest feed, 2 force, 3 deflection, 4 feed per tooth, 5 temperature, "
        "6 chatter");
    if (run.heat) {
      add(
          "temperature", "degC",
          [](const Step& s) { return s.temperature - thermal::kZeroCelsius; },
          "of the hottest bone that stays");
    }
    add("saturated", "1", [](const Step& s) { return s.saturated ? 1.0 : 0.0; });
    made.attributes["status"] = std::string(simulate::name(run.summary.status));
    made.attributes["cutting_time_s"] = run.summary.cutting_time;
    file.runs.push_back(std::move(made));
  }
  return file;
}

LinePlot plot_of(const SimulatedRun& run) {
  const std::vector<double> time = times(run);
  const Material material = material_of(run);
  LinePlot plot;
  plot.title =
      fmt::format("{}: {:.1f} s, mean {:.1f} N, peak {:.1f} N", run.input.name,
                  run.summary.cutting_time, run.summary.mean_force, run.summary.peak_force);
  plot.x = {"time since first contact, s"};
  Panel force{{"force, N", 0.0},
              {{"peak", time, peak_forces(run)}, {"mean", time, mean_forces(run)}}};
  force.limits = {{run.input.force_limit, "limit"}};
  // Room above the largest feed for the names of the intervals there.
  Panel feed{{"feed, mm/s", 0.0, 1.15 * run.input.controller.limits.highest / units::mm_per_s},
             {{"command", time, commands(run)}, {"feed", time, feeds(run)}}};
  // The name of an interval wants a tenth of the width.
  const double named = time.empty() ? 0.0 : 0.1 * (time.back() - time.front());
  for (const auto& [from, to] : run.summary.saturated_intervals)
    feed.intervals.push_back({from, to, to - from > named ? "at its largest" : ""});
  Panel bone{{material.name + ", " + material.unit, 0.0}, {{"", time, materials(run)}}};
  bone.share_of_height = 0.6;
  plot.panels = {force, feed, bone};
  plot.width = 900;
  plot.height = 700;
  return plot;
}

ReportData report_of(const std::vector<SimulatedRun>& runs, const std::string& title,
                     const std::string& program) {
  ReportData data;
  data.title = heading(title);
  data.program = program;
  data.created = now_text();
  data.headline = comparisons_of(runs);
  data.summary = table_for(runs);
  data.notes = notes_for(runs);
  data.expanded_case = case_of(runs).dump(2);
  if (runs.empty()) return data;
  const SimulatedRun& first = runs.front();
  data.subtitle = subtitle_of(first);
  ReportScene scene;
  scene.path_value_name = "peak force";
  scene.path_value_limit = first.input.force_limit;
  scene.cutter = first.input.cutter.cutter;
  data.scene = scene;
  for (const SimulatedRun& run : runs) {
    if (!worst_variant(runs, run)) continue;
    data.runs.push_back(run_of(run));
    if (const SimulatedRun* fixed = constant_feed_beside(runs, run)) compare(run, *fixed, data);
  }
  return data;
}

}  // namespace osteomill::io
