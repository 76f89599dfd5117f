// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/simulate_result.hpp"

#include <fmt/format.h>

#include <algorithm>

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
                        {"damaged_volume_mm3", heat.damaged_volume / units::mm3},
                        {"damaged_depth_mm", heat.damaged_depth / units::mm},
                        {"heat_in_bone_j", heat.heat_in_bone}};
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

std::vector<std::vector<std::string>> table_of(const std::vector<SimulatedRun>& runs) {
  std::vector<std::vector<std::string>> rows = {{"run", "status", "cutting time, s",
                                                 "mean force, N", "peak force, N", "above limit, s",
                                                 "removed, mm3", "largest feed, mm/s"}};
  for (const SimulatedRun& run : runs) {
    const simulate::Summary& s = run.summary;
    rows.push_back({run.input.name, simulate::name(s.status), fmt::format("{:.1f}", s.cutting_time),
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
