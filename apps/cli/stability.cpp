// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/vibration/stability.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "documents.hpp"
#include "osteomill/base/random.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/io/plot.hpp"
#include "osteomill/io/vibration_case.hpp"
#include "osteomill/vibration/chatter_simulation.hpp"
#include "osteomill/vibration/frequency_domain.hpp"

namespace osteomill::cli {
namespace {

using Json = nlohmann::ordered_json;
using namespace vibration;

const char* name_of(Bifurcation bifurcation) {
  switch (bifurcation) {
    case Bifurcation::hopf:
      return "hopf";
    case Bifurcation::flip:
      return "flip";
    case Bifurcation::fold:
      return "fold";
    default:
      return "none";
  }
}

const char* name_of(StabilityMethod method) {
  switch (method) {
    case StabilityMethod::zero_order:
      return "zero-order";
    case StabilityMethod::multi_frequency:
      return "multi-frequency";
    case StabilityMethod::full_discretisation:
      return "full-discretisation";
    case StabilityMethod::collocation:
      return "collocation";
    default:
      return "semi-discretisation";
  }
}

/// A cut beside the boundary, simulated in time.
struct Judged {
  double spindle_speed = 0.0, depth = 0.0;
  bool above = false;  ///< of the boundary
  double growth = 0.0;
  bool agrees = false;
};

struct Result {
  std::vector<LobePoint> lobes;
  std::vector<Judged> judged;
  FrequencyDomainLimit minimum;
  std::vector<double> depths;
  std::vector<double> radii;
  std::optional<double> working_radius;
  std::optional<LobePoint> working_limit;
  std::vector<std::string> warnings;
};

/// Seeded speeds of the list, 7 % below and above the limit: what the simulation's steps blur is
/// 1 to 2 %. Edges are kept in their cut, as in the equation that the limit belongs to.
std::vector<Judged> judge(const RegenerativeSystem& system, const std::vector<LobePoint>& lobes,
                          int points) {
  std::vector<LobePoint> limited;
  for (const LobePoint& point : lobes) {
    if (point.bifurcation != Bifurcation::none) limited.push_back(point);
  }
  std::vector<Judged> judged;
  Random random(2002);
  for (int i = 0; i < points && !limited.empty(); ++i) {
    const LobePoint& point = limited[random.bits() % limited.size()];
    for (const double share : {0.93, 1.07}) {
      Judged one{.spindle_speed = point.spindle_speed,
                 .depth = share * point.limit_depth,
                 .above = share > 1.0};
      const double oscillations =
          system.highest_frequency_hz() * system.tooth_period(one.spindle_speed);
      const int steps = std::max(240, static_cast<int>(std::ceil(40.0 * oscillations)));
      one.growth = simulate_chatter(system, one.spindle_speed, one.depth, 0.1 * units::mm,
                                    {.steps = steps,
                                     .slices = system.cut().has_helix() ? 20 : 1,
                                     .edges_may_leave = false})
                       .growth;
      one.agrees = (one.growth > 1.0) == one.above;
      judged.push_back(one);
    }
  }
  return judged;
}

Result solve(const io::StabilityCase& one) {
  const RegenerativeSystem system(
      one.structure.modes, *one.cut,
      one.structure.measured.empty() ? Receptance{} : one.structure.receptance);
  Result result;
  StabilityOptions options = one.options;
  options.progress = console_progress();
  result.lobes = one.continuation ? lobes_by_continuation(system, one.speeds, options)
                                  : lobes(system, one.speeds, options);
  result.minimum = ZeroOrder(system).absolute_minimum();
  result.judged = judge(system, result.lobes, one.judge);
  for (int k = 1; k <= one.map_depths; ++k) {
    result.depths.push_back(one.options.max_depth * k / one.map_depths);
  }
  if (!result.depths.empty()) {
    result.radii = stability_map(system, one.speeds, result.depths, options);
  }
  if (one.depth && one.speed) {
    options.method = StabilityMethod::semi_discretisation;
    result.working_radius = spectral_radius(system, *one.speed, *one.depth, options);
    result.working_limit = lobes(system, {*one.speed}, options)[0];
  }
  result.warnings = one.caveats;
  if (one.options.method == StabilityMethod::zero_order &&
      one.cut->exit() - one.cut->entry() < 0.6 * std::numbers::pi) {
    result.warnings.push_back(
        "zero-order knows neither flip lobes nor stable pockets of interrupted cuts and is wrong "
        "at low immersion; compare with \"semi-discretisation\"");
  }
  return result;
}

Json number_or_null(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json document_of(const Result& result, const io::StabilityCase& one) {
  Json document;
  document["method"] = name_of(one.options.method);
  Json& modes = document["modes"] = Json::array();
  for (const Mode& mode : one.structure.modes) {
    modes.push_back(
        {{"frequency_hz", mode.frequency_hz},
         {"damping_ratio", mode.damping_ratio},
         {"stiffness_n_per_mm", modal_stiffness(mode) / units::n_per_mm},
         {"direction_deg", std::atan2(mode.direction_y, mode.direction_x) / units::deg}});
  }
  Json& list = document["lobes"] = Json::array();
  for (const LobePoint& point : result.lobes) {
    list.push_back({{"spindle_speed_rpm", point.spindle_speed / units::rpm},
                    {"limit_depth_mm", number_or_null(point.limit_depth / units::mm)},
                    {"chatter_frequency_hz", point.bifurcation == Bifurcation::none
                                                 ? Json(nullptr)
                                                 : Json(point.chatter_frequency_hz)},
                    {"bifurcation", name_of(point.bifurcation)}});
  }
  document["absolute_minimum_depth_mm"] = number_or_null(result.minimum.depth / units::mm);
  document["absolute_minimum_chatter_frequency_hz"] =
      std::isfinite(result.minimum.depth) ? Json(result.minimum.chatter_frequency_hz)
                                          : Json(nullptr);
  if (one.judge > 0) {
    Json& judged = document["simulated"] = Json::array();
    for (const Judged& point : result.judged) {
      judged.push_back({{"spindle_speed_rpm", point.spindle_speed / units::rpm},
                        {"axial_depth_mm", point.depth / units::mm},
                        {"above_limit", point.above},
                        {"growth_per_tooth", point.growth},
                        {"agrees", point.agrees}});
    }
  }
  if (result.working_radius) {
    document["working_point"] = {
        {"spindle_speed_rpm", *one.speed / units::rpm},
        {"axial_depth_mm", *one.depth / units::mm},
        {"spectral_radius", *result.working_radius},
        {"stable", *result.working_radius < 1.0},
        {"limit_depth_mm", number_or_null(result.working_limit->limit_depth / units::mm)}};
  }
  if (!result.radii.empty()) {
    Json& map = document["map"];
    map["axial_depth_mm"] = Json::array();
    for (const double depth : result.depths) map["axial_depth_mm"].push_back(depth / units::mm);
    map["spectral_radius"] = Json::array();  // one row a speed, in the order of lobes
    const std::size_t rows = result.lobes.size(), columns = result.depths.size();
    for (std::size_t i = 0; i < rows; ++i) {
      map["spectral_radius"].push_back(std::vector<double>(
          result.radii.begin() + static_cast<std::ptrdiff_t>(i * columns),
          result.radii.begin() + static_cast<std::ptrdiff_t>((i + 1) * columns)));
    }
  }
  document["warnings"] = result.warnings;
  return document;
}

std::vector<std::vector<std::string>> rows_of(const Result& result) {
  std::vector<std::vector<std::string>> rows{
      {"spindle speed, rpm", "limit depth, mm", "chatter, Hz", "loses stability by"}};
  for (const LobePoint& point : result.lobes) {
    const bool limited = point.bifurcation != Bifurcation::none;
    rows.push_back({fmt::format("{:.0f}", point.spindle_speed / units::rpm),
                    limited ? fmt::format("{:.5f}", point.limit_depth / units::mm) : "above range",
                    limited ? fmt::format("{:.1f}", point.chatter_frequency_hz) : "",
                    name_of(point.bifurcation)});
  }
  return rows;
}

void draw_lobes(const Result& result, const io::StabilityCase& one,
                const std::filesystem::path& file) {
  io::Series hopf{.label = "Hopf", .x = {}, .y = {}, .mark = io::Mark::points};
  io::Series flip{.label = "flip", .x = {}, .y = {}, .mark = io::Mark::points};
  io::Series border{.label = "stability limit", .x = {}, .y = {}};
  io::Series frequency{.label = "chatter frequency", .x = {}, .y = {}, .mark = io::Mark::points};
  const double none = std::numeric_limits<double>::quiet_NaN();
  for (const LobePoint& point : result.lobes) {
    const double n = 1e-3 * point.spindle_speed / units::rpm;
    const bool limited = point.bifurcation != Bifurcation::none;
    border.x.push_back(n);
    border.y.push_back(limited ? point.limit_depth / units::mm : none);
    if (!limited) continue;
    io::Series& kind = point.bifurcation == Bifurcation::flip ? flip : hopf;
    kind.x.push_back(n);
    kind.y.push_back(point.limit_depth / units::mm);
    frequency.x.push_back(n);
    frequency.y.push_back(point.chatter_frequency_hz);
  }
  io::Panel depth{.y = {.label = "axial depth, mm", .low = 0.0}, .series = {border}};
  if (!hopf.x.empty()) depth.series.push_back(hopf);
  if (!flip.x.empty()) depth.series.push_back(flip);
  if (std::isfinite(result.minimum.depth)) {
    depth.limits.push_back(
        {result.minimum.depth / units::mm, "zero-order minimum over all speeds"});
  }
  io::LinePlot plot{.title = fmt::format("Stability lobes, {}", name_of(one.options.method)),
                    .x = {.label = "spindle speed, 1000 rpm"},
                    .panels = {depth},
                    .height = 560};
  if (!frequency.x.empty()) {
    plot.panels.push_back(
        {.y = {.label = "chatter, Hz"}, .series = {frequency}, .share_of_height = 0.5});
  }
  io::draw(plot, file);
}

void draw_margin(const Result& result, const std::filesystem::path& file) {
  io::HeatMap map{.title = "Margin: how much a disturbance keeps from tooth to tooth",
                  .x = {.label = "spindle speed, 1000 rpm"},
                  .y = {.label = "axial depth, mm"},
                  .value_label = "spectral radius (stable below 1)",
                  .x_centres = {},
                  .y_centres = {},
                  .values = {},
                  .low = 0.0,
                  .high = 2.0};
  for (const LobePoint& point : result.lobes)
    map.x_centres.push_back(1e-3 * point.spindle_speed / units::rpm);
  for (const double d : result.depths) map.y_centres.push_back(d / units::mm);
  const std::size_t columns = result.depths.size();
  for (std::size_t k = 0; k < columns; ++k) {
    for (std::size_t i = 0; i < result.lobes.size(); ++i) {
      map.values.push_back(result.radii[i * columns + k]);
    }
  }
  map.contours = {1.0};
  io::draw(map, file);
}

bool in_frequency(StabilityMethod method) {
  return method == StabilityMethod::zero_order || method == StabilityMethod::multi_frequency;
}

std::vector<std::string> sentences_of(const Result& result, const io::StabilityCase& one) {
  std::vector<std::string> sentences;
  if (!one.structure.measured.empty()) {
    sentences.push_back(in_frequency(one.options.method)
                            ? "limits from the measured response itself"
                            : "limits from the modes fitted to the measured response:");
    for (const Mode& mode : one.structure.modes) {
      if (in_frequency(one.options.method)) break;
      sentences.push_back(fmt::format("  {:.1f} Hz, damping ratio {:.4f}, {:.4g} N/mm",
                                      mode.frequency_hz, mode.damping_ratio,
                                      modal_stiffness(mode) / units::n_per_mm));
    }
  }
  if (std::isfinite(result.minimum.depth)) {
    sentences.push_back(
        fmt::format("least limit of the zero-order method over all speeds: {:.5f} mm (chatter at "
                    "{:.1f} Hz); an interrupted cut can chatter below it",
                    result.minimum.depth / units::mm, result.minimum.chatter_frequency_hz));
  }
  if (!result.judged.empty()) {
    const auto agree = std::count_if(result.judged.begin(), result.judged.end(),
                                     [](const Judged& point) { return point.agrees; });
    sentences.push_back(
        fmt::format("simulated in time 7 % below and above the limit: {} of {} cuts agree", agree,
                    result.judged.size()));
  }
  if (result.working_radius) {
    sentences.push_back(fmt::format(
        "this cut {}: a disturbance keeps {:.3f} of itself from tooth to tooth",
        *result.working_radius < 1.0 ? "is stable" : "chatters", *result.working_radius));
  }
  return sentences;
}

Shown show(const io::CaseRun& run) {
  const io::StabilityCase one = io::read_stability_case(run);
  const Result result = solve(one);
  Shown shown{.document = document_of(result, one),
              .expanded = one.expanded,
              .rows = rows_of(result),
              .sentences = sentences_of(result, one),
              .warnings = result.warnings};
  if (result.lobes.size() > 1) {
    shown.figures.push_back({"lobes", "Stability lobes and chatter frequency",
                             [=](const auto& file) { draw_lobes(result, one, file); }});
  }
  if (result.lobes.size() > 1 && result.depths.size() > 1) {
    shown.figures.push_back({"margin", "Margin map: the spectral radius, stable below 1",
                             [=](const auto& file) { draw_margin(result, file); }});
  }
  return shown;
}

}  // namespace

void add_stability(CLI::App& program) {
  auto arguments = std::make_shared<CaseArguments>();
  CLI::App* command =
      program.add_subcommand("stability", "depth at which milling chatters, by spindle speed");
  add_case_arguments(*command, *arguments);
  command->callback([arguments] { show_runs(*arguments, "stability", show); });
}

}  // namespace osteomill::cli
