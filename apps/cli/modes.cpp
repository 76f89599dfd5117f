// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "documents.hpp"
#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/io/plot.hpp"
#include "osteomill/io/vibration_case.hpp"
#include "osteomill/vibration/beam_elements.hpp"
#include "osteomill/vibration/exact_beam.hpp"

namespace osteomill::cli {
namespace {

using Json = nlohmann::ordered_json;

struct Result {
  std::vector<double> frequencies_hz;
  double tip_stiffness = 0.0;  ///< N/m
  std::vector<double> positions;
  std::vector<std::vector<double>> shapes;
  std::vector<double> whirl_hz;
  std::vector<vibration::Mode> tip;
};

Result solve(const io::ModesCase& one) {
  Result result;
  const double end = vibration::length(one.beam);
  for (int i = 0; i <= 100; ++i) result.positions.push_back(end * i / 100.0);
  const vibration::BeamModel model(one.beam, one.elements);
  const int count = std::min(one.modes, one.exact ? one.modes : model.modes());
  if (one.exact) {
    result.frequencies_hz = vibration::exact_natural_frequencies(one.beam, count);
    for (const double f : result.frequencies_hz) {
      result.shapes.push_back(vibration::exact_mode_shape(one.beam, f, result.positions));
    }
    const double compliance = vibration::exact_tip_receptance(one.beam, 0.0);
    result.tip_stiffness = compliance > 0.0 ? 1.0 / compliance : 0.0;
  } else {
    const auto& all = model.natural_frequencies_hz();
    result.frequencies_hz.assign(all.begin(), all.begin() + count);
    for (int i = 0; i < count; ++i) result.shapes.push_back(model.shape(i, result.positions));
    const double compliance = model.static_compliance(end, end);
    result.tip_stiffness = compliance > 0.0 ? 1.0 / compliance : 0.0;
  }
  if (one.spindle_speed > 0.0) {
    vibration::ElementOptions stout = one.elements;
    stout.theory = vibration::BeamTheory::timoshenko;
    result.whirl_hz = vibration::BeamModel(one.beam, stout)
                          .whirl_frequencies_hz(one.spindle_speed, 2 * std::min(count, 12));
  }
  result.tip = vibration::tip_modes(model, end, count, 0.02, 1.0, 0.0);
  return result;
}

Json document_of(const Result& result, const io::ModesCase& one) {
  Json document;
  document["method"] = one.exact ? "exact" : "finite-element";
  document["natural_frequencies_hz"] = result.frequencies_hz;
  document["static_tip_stiffness_n_per_mm"] = result.tip_stiffness * units::mm;
  Json& tip = document["modal_stiffness_at_tip_n_per_mm"] = Json::array();
  for (const auto& mode : result.tip) {
    tip.push_back(vibration::modal_stiffness(mode) * units::mm);
  }
  if (!result.whirl_hz.empty()) document["whirl_frequencies_hz"] = result.whirl_hz;
  Json& shapes = document["mode_shapes"];
  shapes["position_mm"] = Json::array();
  for (const double x : result.positions) shapes["position_mm"].push_back(x / units::mm);
  shapes["deflection"] = result.shapes;
  return document;
}

std::vector<std::vector<std::string>> rows_of(const Result& result) {
  std::vector<std::vector<std::string>> rows{
      {"mode", "frequency, Hz", "stiffness at the tip, N/mm", "2-flute resonance, rpm"}};
  for (std::size_t i = 0; i < result.frequencies_hz.size(); ++i) {
    rows.push_back(
        {fmt::format("{}", i + 1), fmt::format("{:.2f}", result.frequencies_hz[i]),
         i < result.tip.size()
             ? fmt::format("{:.4g}", vibration::modal_stiffness(result.tip[i]) * units::mm)
             : "",
         fmt::format("{:.0f}", 30.0 * result.frequencies_hz[i])});
  }
  rows.push_back({"static", "", fmt::format("{:.4g}", result.tip_stiffness * units::mm), ""});
  for (std::size_t i = 0; i < result.whirl_hz.size(); ++i) {
    rows.push_back({fmt::format("whirl {}", i + 1), fmt::format("{:.2f}", result.whirl_hz[i])});
  }
  return rows;
}

void draw_shapes(const Result& result, const io::ModesCase& one,
                 const std::filesystem::path& file) {
  io::LinePlot plot{.title = "Mode shapes",
                    .x = {.label = "distance from the chuck, mm"},
                    .panels = {{.y = {.label = "deflection, largest = 1"}, .series = {}}}};
  std::vector<double> mm;
  for (const double x : result.positions) mm.push_back(x / units::mm);
  for (std::size_t i = 0; i < result.shapes.size(); ++i) {
    plot.panels[0].series.push_back(
        {.label = fmt::format("{}: {:.0f} Hz", i + 1, result.frequencies_hz[i]),
         .x = mm,
         .y = result.shapes[i]});
  }
  io::Series supports{.label = "supports", .x = {}, .y = {}, .mark = io::Mark::points};
  for (const auto& support : one.beam.supports) {
    supports.x.push_back(support.position / units::mm);
    supports.y.push_back(0.0);
  }
  plot.panels[0].series.push_back(supports);
  io::draw(plot, file);
}

Json document_of(const vibration::Estimate& estimate, double unit) {
  return {{"value", estimate.value / unit}, {"standard_error", estimate.standard_error / unit}};
}

void draw_frf(const vibration::MeasuredFrf& frf, const vibration::ModalFit& fit,
              const std::filesystem::path& file) {
  io::Series real{.label = "measured", .x = frf.frequency_hz, .y = {}, .mark = io::Mark::points};
  io::Series imaginary = real;
  io::Series real_fit{.label = "fit", .x = frf.frequency_hz, .y = {}}, imaginary_fit = real_fit;
  imaginary.label = imaginary_fit.label = "";
  std::vector<vibration::Mode> modes;
  for (const auto& mode : fit.modes) modes.push_back(mode.mode(1.0, 0.0));
  for (std::size_t i = 0; i < frf.frequency_hz.size(); ++i) {
    const auto h = vibration::tip_receptance(modes, frf.frequency_hz[i]).xx;
    real.y.push_back(frf.receptance[i].real() / units::um);
    imaginary.y.push_back(frf.receptance[i].imag() / units::um);
    real_fit.y.push_back(h.real() / units::um);
    imaginary_fit.y.push_back(h.imag() / units::um);
  }
  const double high = 2.0 * fit.modes.back().frequency_hz.value;
  io::LinePlot plot{
      .title = "Measured receptance of the tip",
      .x = {.label = "frequency, Hz", .low = 0.0, .high = std::min(high, frf.frequency_hz.back())},
      .panels = {{.y = {.label = "real, um/N"}, .series = {real, real_fit}},
                 {.y = {.label = "imaginary, um/N"}, .series = {imaginary, imaginary_fit}}},
      .height = 640};
  if (frf.blows > 1) {
    plot.panels.push_back({.y = {.label = "coherence", .low = 0.0, .high = 1.05},
                           .series = {{"", frf.frequency_hz, frf.coherence}},
                           .share_of_height = 0.5});
  }
  io::draw(plot, file);
}

/// The lines of the band, the window's damping taken off.
Json lines_of(const io::ImpactCase& impact, const vibration::ModalFit& fit) {
  const auto response = vibration::receptance_of(impact.frf, fit, impact.fit);
  Json lines;
  for (const char* key : {"frequency_hz", "real_um_per_n", "imaginary_um_per_n", "coherence"}) {
    lines[key] = Json::array();
  }
  for (std::size_t i = 0; i < impact.frf.frequency_hz.size(); ++i) {
    const double f = impact.frf.frequency_hz[i];
    if (f < impact.fit.low_hz || (impact.fit.high_hz > 0.0 && f > impact.fit.high_hz)) continue;
    lines["frequency_hz"].push_back(f);
    lines["real_um_per_n"].push_back(response(f).real() / units::um);
    lines["imaginary_um_per_n"].push_back(response(f).imag() / units::um);
    lines["coherence"].push_back(impact.frf.coherence[i]);
  }
  return lines;
}

Shown show_impact(const io::ImpactCase& impact, const nlohmann::ordered_json& expanded) {
  const vibration::ModalFit fit = vibration::fit_modes(impact.frf, impact.fit);
  if (!fit.converged) throw NoSolution("modal fit: " + fit.status);
  Shown shown{.document = {{"method", "impact-test"}}, .expanded = expanded, .rows = {}};
  Json frequencies = Json::array();
  Json modes = Json::array();
  shown.rows = {{"mode", "frequency, Hz", "stiffness, N/mm", "damping ratio"}};
  const auto cell = [](const vibration::Estimate& e, double unit) {
    return fmt::format("{:.5g} +- {:.2g}", e.value / unit, e.standard_error / unit);
  };
  for (const vibration::FittedMode& mode : fit.modes) {
    frequencies.push_back(mode.frequency_hz.value);
    modes.push_back({{"frequency_hz", document_of(mode.frequency_hz, 1.0)},
                     {"stiffness_n_per_mm", document_of(mode.stiffness, units::n_per_mm)},
                     {"damping_ratio", document_of(mode.damping_ratio, 1.0)}});
    shown.rows.push_back({fmt::format("{}", shown.rows.size()), cell(mode.frequency_hz, 1.0),
                          cell(mode.stiffness, units::n_per_mm), cell(mode.damping_ratio, 1.0)});
  }
  shown.document["natural_frequencies_hz"] = std::move(frequencies);
  shown.document["modes"] = std::move(modes);
  shown.document["residual_flexibility_um_per_n"] = fit.residual_flexibility / units::um;
  shown.document["residual_rms_um_per_n"] = fit.residual_rms / units::um;
  shown.document["receptance"] = lines_of(impact, fit);
  shown.sentences = {"+- is one standard error"};
  shown.figures = {{"receptance", "Receptance and coherence of the impact test with the fit",
                    [=](const auto& file) { draw_frf(impact.frf, fit, file); }}};
  return shown;
}

Shown show(const io::CaseRun& run) {
  const io::ModesCase one = io::read_modes_case(run);
  if (one.impact) return show_impact(*one.impact, one.expanded);
  const Result result = solve(one);
  return {.document = document_of(result, one),
          .expanded = one.expanded,
          .rows = rows_of(result),
          .figures = {{"mode_shapes", "Mode shapes and supports",
                       [=](const auto& file) { draw_shapes(result, one, file); }}}};
}

}  // namespace

void add_modes(CLI::App& program) {
  auto arguments = std::make_shared<CaseArguments>();
  CLI::App* command = program.add_subcommand(
      "modes", "natural frequencies, mode shapes and stiffness of a tool, holder and bearings");
  add_case_arguments(*command, *arguments);
  command->callback([arguments] { show_runs(*arguments, "modes", show); });
}

}  // namespace osteomill::cli
