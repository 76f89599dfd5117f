// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/simulate_result.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>

#include "osteomill/base/units.hpp"
#include "osteomill/thermal/thermal_dose.hpp"

namespace osteomill::io {
namespace {

using Json = nlohmann::ordered_json;

bool constant(const SimulatedRun& run) {
  return std::holds_alternative<control::ConstantFeed>(run.input.controller.law);
}

/// What was milled: everything of the case but controller, limits and machine.
Json job_of(const SimulatedRun& run) {
  Json job = run.input.expanded;
  for (const char* table : {"controller", "limits", "machine"}) job.erase(table);
  return job;
}

std::string change(double from, double to) {
  if (!(from > 0.0)) return "";
  return fmt::format(" ({:+.0f} %)", 100.0 * (to - from) / from);
}

/// Seconds in contact under each limit of a law that plans; empty for other laws.
std::vector<std::pair<std::string, double>> limited_by(const SimulatedRun& run) {
  std::array<int, control::kBounds> periods{};
  for (const simulate::Step& step : run.steps) {
    if (step.samples_in_contact > 0) ++periods[static_cast<std::size_t>(step.bound)];
  }
  std::vector<std::pair<std::string, double>> named;
  for (std::size_t i = 1; i < periods.size(); ++i) {
    if (periods[i] > 0)
      named.emplace_back(control::name(static_cast<control::Bound>(i)),
                         periods[i] * run.input.controller.period);
  }
  return named;
}

std::string limits_sentence(const SimulatedRun& run) {
  std::vector<std::string> parts;
  for (const auto& [name, time] : limited_by(run))
    parts.push_back(fmt::format("{} {:.1f} s", name, time));
  return fmt::format("{}: feed limited by {}", run.input.name, fmt::join(parts, ", "));
}

/// Of the bone that stays, K; 0: not known.
double hottest_that_stays(const SimulatedRun& run) {
  double hottest = 0.0;
  for (const simulate::Step& step : run.steps) hottest = std::max(hottest, step.temperature);
  return hottest;
}

Json json_of(const simulate::Damage& damage) {
  return {{"volume_mm3", damage.volume / units::mm3}, {"depth_mm", damage.depth / units::mm}};
}

Json document_of(const SimulatedRun& run) {
  const simulate::Summary& summary = run.summary;
  Json document = {{"name", run.input.name},
                   {"status", simulate::name(summary.status)},
                   {"cutting_time_s", summary.cutting_time},
                   {"mean_force_n", summary.mean_force},
                   {"peak_force_n", summary.peak_force},
                   {"time_above_limit_s", summary.time_above_limit},
                   {"force_limit_n", run.input.force_limit},
                   {"removed_volume_mm3", summary.removed_volume / units::mm3},
                   {"max_feed_mm_per_s", summary.max_feed / units::mm_per_s},
                   {"saturated_intervals_s", summary.saturated_intervals},
                   {"line_times_s", summary.line_times},
                   {"line_mean_forces_n", summary.line_mean_forces},
                   {"first_contact_s", summary.first_contact},
                   {"feed_work_j", summary.feed_work}};
  if (run.after) document["spindle_work_j"] = summary.spindle_work;
  if (!run.stock.is_null()) document["stock"] = run.stock;
  if (!run.path_report.is_null()) document["path"] = run.path_report;
  if (!run.plan.is_null()) document["plan"] = run.plan;
  if (run.finish) document["finish"] = run.finish->report;
  if (run.heat) {
    const simulate::BoneHeatSummary& heat = *run.heat;
    document["heat"] = {{"hottest_bone_c", heat.hottest - thermal::kZeroCelsius},
                        {"hottest_bone_left_c", heat.hottest_left - thermal::kZeroCelsius},
                        {"largest_dose_cem43_min", heat.largest_dose},
                        {"damaged_volume_mm3", heat.by_dose.volume / units::mm3},
                        {"damaged_depth_mm", heat.by_dose.depth / units::mm},
                        {"beyond_47c_60s", json_of(heat.by_47c_60s)},
                        {"beyond_50c_30s", json_of(heat.by_50c_30s)},
                        {"heat_in_bone_j", heat.heat_in_bone},
                        {"unplaced_heat_j", heat.unplaced_heat}};
  }
  if (const auto limits = limited_by(run); !limits.empty()) {
    Json& times = document["limited_by_s"] = Json::object();
    for (const auto& [name, time] : limits) times[name] = time;
  }
  document["steps"] = summary.steps;
  document["warnings"] = run.warnings;
  return document;
}

}  // namespace

Json document_of(const std::vector<SimulatedRun>& runs, double wall_time) {
  Json document;
  document["runs"] = Json::array();
  std::size_t steps = 0;
  for (const SimulatedRun& run : runs) {
    document["runs"].push_back(document_of(run));
    steps += run.summary.steps;
  }
  document["comparisons"] = comparisons_of(runs);
  document["wall_time_s"] = wall_time;
  document["steps"] = steps;
  return document;
}

std::vector<RunRow> rows_of(const std::vector<SimulatedRun>& runs, bool grouped) {
  std::vector<RunRow> rows;
  for (std::size_t first = 0, last = 0; first < runs.size(); first = last) {
    const std::string& group = runs[first].input.variant_of;
    last = first + 1;
    while (grouped && !group.empty() && last < runs.size() &&
           runs[last].input.variant_of == group) {
      ++last;
    }
    const double count = static_cast<double>(last - first);
    RunRow row{runs[first].input.name, simulate::name(runs[first].summary.status),
               runs[first].summary};
    if (count > 1.0) {
      row.name = fmt::format("{}, {} variants", group, last - first);
      simulate::Summary& all = row.summary;
      std::map<std::string, int> ends;
      all = {};
      for (std::size_t i = first; i < last; ++i) {
        const simulate::Summary& one = runs[i].summary;
        ++ends[simulate::name(one.status)];
        all.cutting_time += one.cutting_time / count;
        all.mean_force += one.mean_force / count;
        all.removed_volume += one.removed_volume / count;
        all.time_above_limit += one.time_above_limit;
        all.peak_force = std::max(all.peak_force, one.peak_force);
        all.max_feed = std::max(all.max_feed, one.max_feed);
      }
      row.status.clear();
      for (const auto& [end, times] : ends) {
        if (!row.status.empty()) row.status += ", ";
        row.status += ends.size() == 1 ? end : fmt::format("{} {}", times, end);
      }
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

std::vector<std::vector<std::string>> table_of(const std::vector<SimulatedRun>& runs,
                                               bool grouped) {
  std::vector<std::vector<std::string>> rows = {{"run", "status", "cutting time, s",
                                                 "mean force, N", "peak force, N", "above limit, s",
                                                 "removed, mm3", "largest feed, mm/s"}};
  for (const RunRow& run : rows_of(runs, grouped)) {
    const simulate::Summary& s = run.summary;
    rows.push_back({run.name, run.status, fmt::format("{:.1f}", s.cutting_time),
                    fmt::format("{:.2f}", s.mean_force), fmt::format("{:.1f}", s.peak_force),
                    fmt::format("{:.3f}", s.time_above_limit),
                    fmt::format("{:.1f}", s.removed_volume / units::mm3),
                    fmt::format("{:.2f}", s.max_feed / units::mm_per_s)});
  }
  return rows;
}

const SimulatedRun* constant_feed_beside(const std::vector<SimulatedRun>& runs,
                                         const SimulatedRun& run) {
  if (constant(run) || !run.input.variant_of.empty()) return nullptr;
  const auto other = std::find_if(runs.begin(), runs.end(), [&](const SimulatedRun& base) {
    return constant(base) && job_of(base) == job_of(run);
  });
  return other == runs.end() ? nullptr : &*other;
}

std::vector<std::string> comparisons_of(const std::vector<SimulatedRun>& runs) {
  std::vector<std::string> sentences;
  for (const SimulatedRun& run : runs) {
    const SimulatedRun* other = constant_feed_beside(runs, run);
    if (!other) continue;
    const simulate::Summary& fixed = other->summary;
    const simulate::Summary& adapted = run.summary;
    sentences.push_back(fmt::format(
        "{}: {:.1f} s against {:.1f} s of {}{}, peak force {:.1f} N against {:.1f} N{}, above "
        "{:g} N for {:.2f} s against {:.2f} s",
        run.input.name, adapted.cutting_time, fixed.cutting_time, other->input.name,
        change(fixed.cutting_time, adapted.cutting_time), adapted.peak_force, fixed.peak_force,
        change(fixed.peak_force, adapted.peak_force), run.input.force_limit,
        adapted.time_above_limit, fixed.time_above_limit));
  }
  for (const SimulatedRun& run : runs) {
    if (!run.input.variant_of.empty()) continue;
    if (!limited_by(run).empty()) sentences.push_back(limits_sentence(run));
    if (const double hottest = hottest_that_stays(run); hottest > 0.0) {
      sentences.push_back(fmt::format("{}: the bone that stays gets {:.1f} °C hot", run.input.name,
                                      hottest - thermal::kZeroCelsius));
    }
  }
  for (const SimulatedRun& run : runs)
    if (run.finish) sentences.push_back(finish_sentence(run.input.name, *run.finish));
  return sentences;
}

Json case_of(const std::vector<SimulatedRun>& runs) {
  Json list = Json::array();
  for (const SimulatedRun& run : runs) {
    // Variants are made again from the run that they vary.
    const std::string& name = run.input.variant_of.empty() ? run.input.name : run.input.variant_of;
    if (!list.empty() && list.back().at("name") == name) continue;
    Json one = {{"name", name}};
    one.update(run.input.expanded);
    list.push_back(std::move(one));
  }
  return {{"run", list}};
}

}  // namespace osteomill::io
