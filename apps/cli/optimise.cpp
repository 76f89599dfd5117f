// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "documents.hpp"
#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/io/accuracy_case.hpp"
#include "osteomill/io/plot.hpp"

namespace osteomill::cli {
namespace {

using Json = nlohmann::ordered_json;
using namespace accuracy;

struct Result {
  Choice choice;
  std::vector<ParetoPoint> front;
  std::vector<EqualTimePoint> equal;
};

Result solve(const io::OptimiseCase& one) {
  Result result;
  const Progress progress = console_progress();
  result.choice = choose(one.problem, one.candidates, progress);
  // Without its limit of the surface error an infeasible problem may have a front; nothing else
  // can.
  if (one.pareto_points > 0 && (result.choice.feasible || one.problem.limits.surface_error)) {
    result.front = pareto_front(one.problem, one.candidates, one.pareto_points, progress);
  }
  if (one.removal_rate > 0.0) {
    result.equal = compare_at_removal_rate(one.problem, one.candidates, one.removal_rate,
                                           one.compare_speed, one.compare_depths);
  }
  return result;
}

const cutting::Cutter& cutter_of(const io::OptimiseCase& one, const std::string& name) {
  std::size_t i = 0;
  while (one.candidates[i].name != name) ++i;
  return one.candidates[i].cutter;
}

Json point_document(const io::OptimiseCase& one, const std::string& name, const Point& point) {
  const cutting::Cutter& cutter = cutter_of(one, name);
  const cutting::Condition condition{.spindle_speed = point[1], .feed_per_tooth = point[0]};
  Json document = {
      {"cutter", name},
      {"flutes", cutter.flutes},
      {"diameter_mm", 2.0 * cutter.radius / units::mm},
      {"feed_per_tooth_mm", point[0] / units::mm},
      {"feed_rate_mm_per_s", cutting::feed_rate(condition, cutter.flutes) / units::mm_per_s},
      {"spindle_speed_rpm", point[1] / units::rpm},
      {"axial_depth_mm", point[2] / units::mm}};
  if (one.problem.immersion != cutting::ImmersionKind::slot) {
    document["radial_depth_mm"] = point[3] / units::mm;
  }
  return document;
}

Json document_of(const CutQuality& q) {
  const auto add = [](double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); };
  return {{"time_s", add(q.time)},
          {"peak_force_n", add(q.peak_force)},
          {"total_tip_deflection_mm", add(q.deflection / units::mm)},
          {"largest_surface_error_mm", add(q.surface_error / units::mm)},
          {"temperature_c", add(q.temperature)},
          {"mean_power_w", add(q.power)},
          {"specific_energy_j_per_mm3", add(q.energy * units::mm3)},
          {"spectral_radius", add(q.chatter)}};
}

Json document_of(const Result& result, const io::OptimiseCase& one) {
  const Choice& choice = result.choice;
  Json document;
  document["status"] = choice.status;
  document[choice.feasible ? "optimum" : "closest"] =
      point_document(one, choice.candidate, choice.point);
  document["quality"] = document_of(choice.quality);
  document["limits_used"] = Json::object();
  for (const LimitUse& use : limit_uses(one.problem, choice.quality)) {
    document["limits_used"][use.name] = use.use;
  }
  document["binding"] = choice.binding;
  Json& relaxed = document["relaxing_by_10_percent"] = Json::array();
  for (const Relaxation& r : choice.relaxations) {
    relaxed.push_back({{"limit", r.limit}, {"gain", r.gain}});
  }
  Json& violated = document["violated"] = Json::array();
  for (const LimitUse& use : choice.violated) {
    violated.push_back({{"limit", use.name}, {"share_of_limit", use.use}});
  }
  document["evaluations"] = choice.evaluations;
  if (one.problem.heat.coefficient > 0.0) {
    document["heat_relation"] = {{"coefficient_k", one.problem.heat.coefficient},
                                 {"start_c", one.problem.heat.start}};
    if (one.heat_fit) {
      document["heat_relation"]["coefficient_standard_error_k"] = one.heat_fit->coefficient_error;
      document["heat_relation"]["residual_rms_k"] = one.heat_fit->residual_rms;
    }
  }
  Json& front = document["pareto_front"] = Json::array();
  for (const ParetoPoint& p : result.front) {
    Json point = {{"time_s", p.time}, {"largest_surface_error_mm", p.error / units::mm}};
    point.update(point_document(one, p.candidate, p.point));
    front.push_back(point);
  }
  Json& equal = document["equal_removal_rate"] = Json::array();
  for (const EqualTimePoint& p : result.equal) {
    Json point = {{"cutter", p.candidate},
                  {"axial_depth_mm", p.axial_depth / units::mm},
                  {"feed_rate_mm_per_s", p.feed_rate / units::mm_per_s}};
    point.update(document_of(p.quality));
    equal.push_back(point);
  }
  document["warnings"] = one.caveats;
  return document;
}

std::vector<std::vector<std::string>> rows_of(const Result& result, const io::OptimiseCase& one) {
  const Choice& choice = result.choice;
  const CutQuality& q = choice.quality;
  const cutting::Cutter& cutter = cutter_of(one, choice.candidate);
  const cutting::Condition condition{.spindle_speed = choice.point[1],
                                     .feed_per_tooth = choice.point[0]};
  std::vector<std::vector<std::string>> rows{
      {choice.feasible ? "best condition" : "closest condition", ""},
      {"cutter", choice.candidate},
      {"feed, mm/s",
       fmt::format("{:.4g}", cutting::feed_rate(condition, cutter.flutes) / units::mm_per_s)},
      {"feed per tooth, um", fmt::format("{:.4g}", choice.point[0] / units::um)},
      {"spindle speed, rpm", fmt::format("{:.0f}", choice.point[1] / units::rpm)},
      {"axial depth, mm", fmt::format("{:.4g}", choice.point[2] / units::mm)},
      {"radial depth, mm", one.problem.immersion == cutting::ImmersionKind::slot
                               ? "slot"
                               : fmt::format("{:.4g}", choice.point[3] / units::mm)},
      {"time, s", fmt::format("{:.4g}", q.time)},
      {"peak force, N", fmt::format("{:.4g}", q.peak_force)},
      {"total tip deflection, mm", fmt::format("{:.4g}", q.deflection / units::mm)},
      {"largest surface error, mm", fmt::format("{:.4g}", q.surface_error / units::mm)},
      {"mean power, W", fmt::format("{:.4g}", q.power)},
      {"specific energy, J/mm3", fmt::format("{:.4g}", q.energy * units::mm3)},
      {"spectral radius (chatter)", fmt::format("{:.4g}", q.chatter)}};
  if (std::isfinite(q.temperature)) {
    rows.push_back({"temperature, degC", fmt::format("{:.3g}", q.temperature)});
  }
  return rows;
}

std::vector<std::string> sentences_of(const Result& result, const io::OptimiseCase& one) {
  const Choice& choice = result.choice;
  std::vector<std::string> sentences;
  if (!choice.binding.empty()) {
    sentences.push_back(fmt::format("held by: {}", fmt::join(choice.binding, ", ")));
  }
  for (const Relaxation& r : choice.relaxations) {
    sentences.push_back(
        fmt::format("10 % more {} would save {:.1f} % of the goal", r.limit, 100.0 * r.gain));
  }
  for (const LimitUse& use : choice.violated) {
    sentences.push_back(
        fmt::format("{} is exceeded by {:.1f} %", use.name, 100.0 * (use.use - 1.0)));
  }
  if (one.heat_fit && one.heat_fit->coefficient_error > 0.0) {
    sentences.push_back(fmt::format(
        "temperature by K = {:.4g} +- {:.2g} K over {:g} degC, fitted to the observations within "
        "{:.2g} K",
        one.problem.heat.coefficient, one.heat_fit->coefficient_error, one.problem.heat.start,
        one.heat_fit->residual_rms));
  } else if (one.heat_fit) {
    sentences.push_back(
        fmt::format("temperature by K = {:.4g} K over {:g} degC, from one observation: without a "
                    "measure of its error",
                    one.problem.heat.coefficient, one.problem.heat.start));
  }
  for (const EqualTimePoint& p : result.equal) {
    sentences.push_back(fmt::format(
        "at equal removal rate, {}: {:.3g} mm deep at {:.3g} mm/s bends {:.3g} mm under {:.3g} N",
        p.candidate, p.axial_depth / units::mm, p.feed_rate / units::mm_per_s,
        p.quality.deflection / units::mm, p.quality.peak_force));
  }
  return sentences;
}

void draw_front(const Result& result, const std::filesystem::path& file) {
  // One colour a cutter; between the points lie other optima, which a line would only guess.
  std::vector<io::Series> list;
  for (const ParetoPoint& p : result.front) {
    auto at = std::find_if(list.begin(), list.end(),
                           [&](const io::Series& s) { return s.label == p.candidate; });
    if (at == list.end()) {
      list.push_back({.label = p.candidate, .x = {}, .y = {}, .mark = io::Mark::points});
      at = list.end() - 1;
    }
    at->x.push_back(p.time);
    at->y.push_back(p.error / units::mm);
  }
  io::draw(
      io::LinePlot{
          .title = "Time against surface error: no cut is better in both",
          .x = {.label = "time, s", .low = 0.0, .high = 1.05 * result.front.back().time},
          .panels = {{.y = {.label = "largest surface error, mm", .low = 0.0}, .series = list}}},
      file);
}

void run(const CaseArguments& arguments) {
  std::string infeasible;
  show_runs(arguments, "optimise", [&](const io::CaseRun& run) {
    const io::OptimiseCase one = io::read_optimise_case(run);
    const Result result = solve(one);
    if (!result.choice.feasible) infeasible = run.name;
    Shown shown{.document = document_of(result, one),
                .expanded = one.expanded,
                .rows = rows_of(result, one),
                .sentences = sentences_of(result, one),
                .warnings = one.caveats};
    if (!one.problem.limits.chatter && result.choice.quality.chatter >= 1.0) {
      shown.warnings.push_back(
          "without process damping the tool chatters at this condition; limits.spectral_radius "
          "keeps away from chatter");
      shown.document["warnings"] = shown.warnings;
    }
    if (result.front.size() > 1) {
      shown.figures.push_back({"pareto_front", "Time against surface error",
                               [=](const auto& file) { draw_front(result, file); }});
    }
    return shown;
  });
  if (!infeasible.empty()) {
    throw NoSolution(fmt::format(
        "{}: no condition meets all limits; the closest one and what it exceeds are shown",
        infeasible));
  }
}

}  // namespace

void add_optimise(CLI::App& program) {
  auto arguments = std::make_shared<CaseArguments>();
  CLI::App* command = program.add_subcommand(
      "optimise", "best feed, speed, depth and cutter under limits on force, accuracy and heat");
  add_case_arguments(*command, *arguments);
  command->callback([arguments] { run(*arguments); });
}

}  // namespace osteomill::cli
