// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "documents.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/io/plot.hpp"
#include "osteomill/io/vibration_case.hpp"
#include "osteomill/vibration/forced_response.hpp"

namespace osteomill::cli {
namespace {

using Json = nlohmann::ordered_json;
using namespace vibration;

struct Result {
  std::vector<ForcedPoint> sweep;
  std::vector<ResonanceSpeed> resonances;
  std::vector<CalmRange> calm;  ///< for the first feed rate
  std::vector<double> natural_hz;
};

Result solve(const io::RespondCase& one) {
  Result result;
  for (const Mode& mode : one.structure.modes) {
    const auto same = [&](double f) { return std::abs(f - mode.frequency_hz) < 1e-6 * f; };
    if (std::none_of(result.natural_hz.begin(), result.natural_hz.end(), same)) {
      result.natural_hz.push_back(mode.frequency_hz);
    }
  }
  std::sort(result.natural_hz.begin(), result.natural_hz.end());
  result.sweep = forced_sweep(one.structure.receptance, one.cutter, one.bone.law, one.condition,
                              one.immersion, one.speeds, one.feed_rates, console_progress());
  const auto [low, high] = std::minmax_element(one.speeds.begin(), one.speeds.end());
  result.resonances =
      resonance_speeds(result.natural_hz, one.cutter.flutes, one.harmonics, *low, *high);
  result.calm = calm_ranges(
      {result.sweep.begin(), result.sweep.begin() + static_cast<std::ptrdiff_t>(one.speeds.size())},
      one.calm_amplification);
  return result;
}

Json document_of(const Result& result, const io::RespondCase& one) {
  Json document;
  document["natural_frequencies_hz"] = result.natural_hz;
  Json& sweep = document["sweep"] = Json::array();
  for (std::size_t k = 0; k < one.feed_rates.size(); ++k) {
    Json curve;
    curve["feed_rate_mm_per_s"] = one.feed_rates[k] / units::mm_per_s;
    for (const char* key : {"spindle_speed_rpm", "peak_deflection_mm", "static_deflection_mm",
                            "peak_normal_deflection_mm"}) {
      curve[key] = Json::array();
    }
    for (std::size_t i = 0; i < one.speeds.size(); ++i) {
      const ForcedPoint& point = result.sweep[k * one.speeds.size() + i];
      curve["spindle_speed_rpm"].push_back(point.spindle_speed / units::rpm);
      curve["peak_deflection_mm"].push_back(point.peak / units::mm);
      curve["static_deflection_mm"].push_back(point.static_peak / units::mm);
      curve["peak_normal_deflection_mm"].push_back(point.peak_normal / units::mm);
    }
    sweep.push_back(curve);
  }
  Json& resonances = document["resonance_speeds"] = Json::array();
  for (const ResonanceSpeed& r : result.resonances) {
    resonances.push_back({{"spindle_speed_rpm", r.spindle_speed / units::rpm},
                          {"mode", r.mode},
                          {"tooth_passing_harmonic", r.harmonic}});
  }
  Json& calm = document["recommended_speed_ranges"] = Json::array();
  for (const CalmRange& range : result.calm) {
    calm.push_back({{"low_rpm", range.low / units::rpm},
                    {"high_rpm", range.high / units::rpm},
                    {"calmest_rpm", range.calmest / units::rpm}});
  }
  document["warnings"] = one.caveats;
  return document;
}

void draw_sweep(const Result& result, const io::RespondCase& one,
                const std::filesystem::path& file) {
  io::Panel panel{.y = {.label = "largest tip deflection, mm", .logarithmic = true}, .series = {}};
  for (std::size_t k = 0; k < one.feed_rates.size(); ++k) {
    io::Series curve{.label = fmt::format("{:g} mm/s", one.feed_rates[k] / units::mm_per_s),
                     .x = {},
                     .y = {},
                     .colour = k};
    io::Series still{.label = k == 0 ? "without dynamics" : "",
                     .x = {},
                     .y = {},
                     .mark = io::Mark::dashed,
                     .colour = k};
    for (std::size_t i = 0; i < one.speeds.size(); ++i) {
      const ForcedPoint& point = result.sweep[k * one.speeds.size() + i];
      curve.x.push_back(1e-3 * point.spindle_speed / units::rpm);
      curve.y.push_back(point.peak / units::mm);
      still.x.push_back(1e-3 * point.spindle_speed / units::rpm);
      still.y.push_back(point.static_peak / units::mm);
    }
    panel.series.push_back(curve);
    panel.series.push_back(still);
  }
  for (const CalmRange& range : result.calm) {
    // A name needs room.
    const double span = result.sweep[one.speeds.size() - 1].spindle_speed - one.speeds.front();
    panel.intervals.push_back({1e-3 * range.low / units::rpm, 1e-3 * range.high / units::rpm,
                               range.high - range.low > 0.1 * span ? "calm" : ""});
  }
  io::draw(io::LinePlot{.title = "Forced vibration of the tip",
                        .x = {.label = "spindle speed, 1000 rpm"},
                        .panels = {panel}},
           file);
}

/// A table has room for the ends, peaks and valleys of the sweep; JSON has all.
std::vector<std::vector<std::string>> rows_of(const Result& result, const io::RespondCase& one) {
  std::vector<std::vector<std::string>> rows{
      {"spindle speed, rpm", "feed, mm/s", "peak deflection, mm", "static, mm", "amplification"}};
  for (std::size_t i = 0; i < result.sweep.size(); ++i) {
    const ForcedPoint& point = result.sweep[i];
    const std::size_t within = i % one.speeds.size();
    const bool end = within == 0 || within + 1 == one.speeds.size();
    const bool extreme =
        !end &&
        (point.peak - result.sweep[i - 1].peak) * (result.sweep[i + 1].peak - point.peak) <= 0.0;
    if (!end && !extreme) continue;
    rows.push_back({fmt::format("{:.0f}", point.spindle_speed / units::rpm),
                    fmt::format("{:g}", point.feed_rate / units::mm_per_s),
                    fmt::format("{:.4g}", point.peak / units::mm),
                    fmt::format("{:.4g}", point.static_peak / units::mm),
                    fmt::format("{:.2f}", point.amplification())});
  }
  return rows;
}

std::vector<std::string> sentences_of(const Result& result) {
  std::string resonances = "resonance speeds, rpm:";
  for (const ResonanceSpeed& r : result.resonances) {
    resonances += fmt::format(" {:.0f} (mode {}, harmonic {})", r.spindle_speed / units::rpm,
                              r.mode, r.harmonic);
  }
  std::string calm = "calm speeds, rpm:";
  for (const CalmRange& range : result.calm) {
    calm += fmt::format(" {:.0f}-{:.0f}", range.low / units::rpm, range.high / units::rpm);
  }
  return {resonances, calm};
}

Shown show(const io::CaseRun& run) {
  const io::RespondCase one = io::read_respond_case(run);
  const Result result = solve(one);
  Shown shown{.document = document_of(result, one),
              .expanded = one.expanded,
              .rows = rows_of(result, one),
              .sentences = sentences_of(result),
              .warnings = one.caveats};
  if (one.speeds.size() > 1) {
    shown.figures.push_back({"forced_vibration", "Largest tip deflection over spindle speed",
                             [=](const auto& file) { draw_sweep(result, one, file); }});
  }
  return shown;
}

}  // namespace

void add_respond(CLI::App& program) {
  auto arguments = std::make_shared<CaseArguments>();
  CLI::App* command = program.add_subcommand(
      "respond", "forced vibration of the tip over spindle speed and feed, and calm speeds");
  add_case_arguments(*command, *arguments);
  command->callback([arguments] { show_runs(*arguments, "respond", show); });
}

}  // namespace osteomill::cli
