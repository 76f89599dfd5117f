// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "documents.hpp"
#include "osteomill/accuracy/flexible_cut.hpp"
#include "osteomill/accuracy/plate.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/io/accuracy_case.hpp"
#include "osteomill/io/plot.hpp"

namespace osteomill::cli {
namespace {

using Json = nlohmann::ordered_json;
using namespace accuracy;

struct AngleBudget {
  Budget sum;
  SampledBudget sampled;
};

struct Result {
  ToolDeflection bent;
  double tip_stiffness = 0.0;
  std::optional<FlexibleCut> flexible;
  std::optional<SurfaceError> dynamic;
  std::optional<PlatePose> resting, fitted;
  std::optional<AngleBudget> varus_valgus, flexion_extension;
};

bool at_rest(const Result& result) {
  return result.flexible && result.flexible->rest == Rest::at_rest;
}

std::vector<Pass> passes_of(const SurfaceError& error, const io::SurfaceCase& surface,
                            double depth) {
  const double half = 0.5 * surface.width;
  Pass pass{.y_from = -half, .y_to = half, .error = error, .tip_x = -0.5 * depth};
  if (surface.feed == io::FeedPattern::one_way) return {pass};
  // The feed away from the middle turns round on one side, and the error with it (§4.5.2).
  Pass right = pass, left = pass;
  right.y_from = left.y_from = 0.0;
  left.y_to = -half;
  for (double& e : left.error.error) e = -e;
  return {right, left};
}

AngleBudget budget_of(std::vector<ErrorSource> sources, const io::BudgetCase& budget,
                      std::optional<double> deflection) {
  if (deflection) sources.push_back({.name = "tool deflection", .bias = *deflection});
  return {propagate(sources), sample(sources, budget.half_window, budget.samples,
                                     static_cast<std::uint64_t>(budget.seed))};
}

Result solve(const io::DeflectCase& one) {
  Result result;
  result.tip_stiffness = one.tool->tip_stiffness();
  result.bent = tool_deflection(*one.tool, one.cutter, one.bone.law, one.condition, one.immersion,
                                one.options);
  if (one.flexible) {
    result.flexible = flexible_cut(*one.tool, one.cutter, one.bone.law, one.condition,
                                   one.immersion, one.options);
  }
  if (one.structure) {
    result.dynamic = dynamic_surface_error(one.structure->receptance, one.cutter, one.bone.law,
                                           one.condition, one.immersion);
  }
  if (one.surface) {
    const SurfaceError& error = at_rest(result) ? result.flexible->surface : result.bent.surface;
    const auto points = milled_surface(passes_of(error, *one.surface, one.immersion.axial_depth));
    result.resting = resting_plate(points);
    result.fitted = fitted_plate(points);
  }
  if (one.budget) {
    const auto bias = [&](double PlatePose::* angle) -> std::optional<double> {
      if (!result.resting) return {};
      return (*result.resting).*angle;
    };
    result.varus_valgus =
        budget_of(one.budget->varus_valgus, *one.budget, bias(&PlatePose::varus_valgus));
    result.flexion_extension =
        budget_of(one.budget->flexion_extension, *one.budget, bias(&PlatePose::flexion_extension));
  }
  return result;
}

std::vector<double> in_mm(const std::vector<double>& metres) {
  std::vector<double> list;
  for (const double value : metres) list.push_back(value / units::mm);
  return list;
}

Json document_of(const SurfaceError& error) {
  return {{"axial_position_mm", in_mm(error.axial_position)}, {"error_mm", in_mm(error.error)}};
}

Json document_of(const PlatePose& pose) {
  return {{"varus_valgus_deg", pose.varus_valgus / units::deg},
          {"flexion_extension_deg", pose.flexion_extension / units::deg},
          {"offset_mm", pose.offset / units::mm},
          {"largest_gap_mm", pose.largest_gap / units::mm},
          {"share_within_0_3_mm", pose.share_tight},
          {"share_within_0_5_mm", pose.share_wide}};
}

Json document_of(const AngleBudget& budget) {
  Json document = {{"bias_deg", budget.sum.bias / units::deg},
                   {"standard_deviation_deg", budget.sum.standard_deviation / units::deg}};
  Json& shares = document["sources"] = Json::array();
  for (const BudgetShare& share : budget.sum.shares) {
    shares.push_back({{"name", share.name},
                      {"standard_deviation_deg", share.standard_deviation / units::deg},
                      {"share_of_variance", share.share_of_variance}});
  }
  document["monte_carlo"] = {
      {"mean_deg", budget.sampled.mean / units::deg},
      {"standard_deviation_deg", budget.sampled.standard_deviation / units::deg},
      {"share_within_window", budget.sampled.share_within},
      {"interval95_deg", {budget.sampled.low / units::deg, budget.sampled.high / units::deg}},
      {"samples", budget.sampled.samples}};
  return document;
}

Json document_of(const FlexibleCut& cut) {
  Json document = {{"status", cut.rest == Rest::at_rest    ? "at rest"
                              : cut.rest == Rest::unstable ? "unstable"
                                                           : "unbalanced"},
                   {"residual_nm", cut.residual / units::um * 1e3},
                   {"growth_per_revolution", cut.growth},
                   {"worst_angle_deg", cut.worst_angle / units::deg},
                   {"cut_over_tool_stiffness", cut.cut_stiffness}};
  if (cut.rest == Rest::unbalanced) return document;
  document["peak_force_n"] = cut.peak_force;
  document["total_tip_deflection_mm"] = cut.total_tip / units::mm;
  document["surface_error"] = document_of(cut.surface);
  if (cut.rest == Rest::at_rest) document["revolutions_to_rest"] = cut.revolutions;
  return document;
}

/// Why the flexible model's answer is not what a cut would come to, or what to mind about it.
std::vector<std::string> warnings_of(const FlexibleCut& cut, double radius) {
  std::vector<std::string> warnings;
  if (cut.rest == Rest::unbalanced) {
    warnings.push_back(fmt::format(
        "flexible model: no deflection found at which forces and deflections meet; at {:.0f} deg "
        "of rotation they differ by {:.3g} um with the cut {:.3g} times as stiff as the tool; its "
        "surface is not shown, read that of the rigid cut",
        cut.worst_angle / units::deg, cut.residual / units::um, cut.cut_stiffness));
  } else if (cut.rest == Rest::unstable) {
    warnings.push_back(fmt::format(
        "flexible model: forces and deflections balance, but the cut, {:.3g} times as stiff as the "
        "tool, does not stay there: at {:.3g} deg of rotation a disturbance grows {:.5g} times in "
        "a revolution (see osteomill stability); read the surface of the rigid cut",
        cut.cut_stiffness, cut.worst_angle / units::deg, cut.growth));
  }
  // A tenth: chips on the rays of the undeflected edges are then off by about as much.
  const double share = cut.total_tip / radius;
  if (share > 0.5) {
    warnings.push_back(
        fmt::format("the tip moves by {:.0f} % of the cutter's radius: too far for chips that are "
                    "reckoned on the rays of the undeflected edges, in either model; read it as a "
                    "tool that is too slender for this cut",
                    100.0 * share));
  } else if (share > 0.1) {
    warnings.push_back(fmt::format(
        "the tip moves by {:.0f} % of the cutter's radius; chips are reckoned on the rays of the "
        "undeflected edges, so that forces are uncertain by about that share, in either model",
        100.0 * share));
  }
  return warnings;
}

Json document_of(const Result& result, const io::DeflectCase& one) {
  const ToolDeflection& bent = result.bent;
  Json document;
  document["total_tip_deflection_mm"] = bent.total_tip / units::mm;
  document["tip_deflection_at_surface_mm"] = bent.tip_at_surface / units::mm;
  document["tip_stiffness_n_per_mm"] = result.tip_stiffness * units::mm;
  document["largest_surface_error_mm"] = largest_magnitude(bent.surface) / units::mm;
  document["surface_error"] = document_of(bent.surface);
  document["tool_line"] = {{"axial_position_mm", in_mm(bent.heights)},
                           {"largest_mm", in_mm(bent.at_largest)},
                           {"smallest_mm", in_mm(bent.at_smallest)},
                           {"at_surface_mm", in_mm(bent.at_surface)}};
  Json& turn = document["revolution"];
  turn["angle_deg"] = Json::array();
  for (const double angle : bent.angle) turn["angle_deg"].push_back(angle / units::deg);
  turn["tip_deflection_mm"] = {{"x", in_mm(bent.tip_x)}, {"y", in_mm(bent.tip_y)}};
  if (result.flexible) document["flexible"] = document_of(*result.flexible);
  if (result.dynamic) document["dynamic_surface_error"] = document_of(*result.dynamic);
  if (result.resting) {
    document["alignment"] = {{"resting", document_of(*result.resting)},
                             {"fitted", document_of(*result.fitted)}};
  }
  if (result.varus_valgus) {
    document["budget"] = {{"varus_valgus", document_of(*result.varus_valgus)},
                          {"flexion_extension", document_of(*result.flexion_extension)}};
  }
  document["warnings"] = one.caveats;
  return document;
}

std::vector<std::vector<std::string>> rows_of(const Result& result) {
  const auto row = [](const char* name, double value) {
    // What is left by rounding is nothing.
    return std::vector<std::string>{name,
                                    fmt::format("{:.4g}", std::abs(value) < 1e-12 ? 0.0 : value)};
  };
  const auto span = [](const SurfaceError& error) {
    const auto [low, high] = std::minmax_element(error.error.begin(), error.error.end());
    const auto cell = [](double e) { return std::abs(e) < 1e-15 ? 0.0 : e / units::mm; };
    return fmt::format("{:.4g} ... {:.4g}", cell(*low), cell(*high));
  };
  const ToolDeflection& bent = result.bent;
  std::vector<std::vector<std::string>> rows{
      {"deflection normal to the wall", ""},
      row("total at the tip in a revolution, mm", bent.total_tip / units::mm),
      row("at the tip when an edge makes the wall, mm", bent.tip_at_surface / units::mm),
      row("stiffness at the tip, N/mm", result.tip_stiffness * units::mm),
      {"surface error along the depth, mm (bone left > 0)", span(bent.surface)}};
  if (result.flexible) {
    const FlexibleCut& cut = *result.flexible;
    if (cut.rest != Rest::unbalanced) {
      rows.push_back(row("flexible model: total at the tip, mm", cut.total_tip / units::mm));
      rows.push_back(row("flexible model: peak force, N", cut.peak_force));
    }
    rows.push_back(
        {"flexible model: surface error, mm", cut.rest == Rest::at_rest    ? span(cut.surface)
                                              : cut.rest == Rest::unstable ? "does not stay"
                                                                           : "no balance"});
    rows.push_back(row("flexible model: stiffness of cut over tool", cut.cut_stiffness));
    if (cut.rest == Rest::at_rest) {
      rows.push_back(row("flexible model: revolutions to come to rest", cut.revolutions));
    }
  }
  if (result.dynamic) {
    rows.push_back({"with vibration: surface error, mm", span(*result.dynamic)});
  }
  if (result.resting) {
    rows.push_back(row("plate: varus/valgus, deg", result.resting->varus_valgus / units::deg));
    rows.push_back(
        row("plate: flexion/extension, deg", result.resting->flexion_extension / units::deg));
    rows.push_back(row("plate: largest gap, mm", result.resting->largest_gap / units::mm));
    rows.push_back(row("plate: share with a gap below 0.3 mm", result.resting->share_tight));
    rows.push_back(row("plate: share with a gap below 0.5 mm", result.resting->share_wide));
  }
  if (result.varus_valgus) {
    rows.push_back(row("budget: varus/valgus SD, deg",
                       result.varus_valgus->sum.standard_deviation / units::deg));
    rows.push_back(row("budget: flexion/extension SD, deg",
                       result.flexion_extension->sum.standard_deviation / units::deg));
    rows.push_back(
        row("budget: share within the frontal window", result.varus_valgus->sampled.share_within));
  }
  return rows;
}

void draw_tool(const Result& result, const std::filesystem::path& file) {
  const ToolDeflection& bent = result.bent;
  const auto z = in_mm(bent.heights);
  io::draw(
      io::LinePlot{.title = "Deflection of the tool normal to the wall",
                   .x = {.label = "height above the tip, mm"},
                   .panels = {{.y = {.label = "deflection, mm"},
                               .series = {{"largest", z, in_mm(bent.at_largest)},
                                          {"smallest", z, in_mm(bent.at_smallest)},
                                          {"an edge at the wall", z, in_mm(bent.at_surface)}}}}},
      file);
}

void draw_error(const Result& result, const std::filesystem::path& file) {
  io::Panel panel{.y = {.label = "surface error, mm (bone left > 0)"},
                  .series = {{"rigid cut", in_mm(result.bent.surface.axial_position),
                              in_mm(result.bent.surface.error)}}};
  if (at_rest(result)) {
    panel.series.push_back({"flexible", in_mm(result.flexible->surface.axial_position),
                            in_mm(result.flexible->surface.error)});
  }
  if (result.dynamic) {
    panel.series.push_back(
        {"with vibration", in_mm(result.dynamic->axial_position), in_mm(result.dynamic->error)});
  }
  if (largest_magnitude(result.bent.surface) > 0.5 * kTightGap) {
    panel.limits.push_back({kTightGap / units::mm, "ingrowth 0.3 mm"});
  }
  io::draw(io::LinePlot{.title = "Surface error along the depth",
                        .x = {.label = "height above the tip, mm"},
                        .panels = {panel}},
           file);
}

Shown show(const io::CaseRun& run) {
  const io::DeflectCase one = io::read_deflect_case(run);
  const Result result = solve(one);
  Shown shown{.document = document_of(result, one),
              .expanded = one.expanded,
              .rows = rows_of(result),
              .warnings = one.caveats};
  if (result.flexible) {
    for (std::string& text : warnings_of(*result.flexible, one.cutter.radius)) {
      shown.warnings.push_back(std::move(text));
    }
    shown.document["warnings"] = shown.warnings;
  }
  shown.figures = {{"tool_deflection",
                    "The tool at its largest and smallest deflection and when "
                    "an edge makes the wall",
                    [=](const auto& file) { draw_tool(result, file); }},
                   {"surface_error", "Error of the surface along the depth",
                    [=](const auto& file) { draw_error(result, file); }}};
  return shown;
}

}  // namespace

void add_deflect(CLI::App& program) {
  auto arguments = std::make_shared<CaseArguments>();
  CLI::App* command = program.add_subcommand(
      "deflect", "static deflection of the tool, surface error, alignment of a plate on it");
  add_case_arguments(*command, *arguments);
  command->callback([arguments] { show_runs(*arguments, "deflect", show); });
}

}  // namespace osteomill::cli
