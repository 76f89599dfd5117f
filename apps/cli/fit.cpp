// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "documents.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/io/fit_case.hpp"
#include "osteomill/io/plot.hpp"

namespace osteomill::cli {
namespace {

using Json = nlohmann::ordered_json;

struct Result {
  io::FitCase fit;
  std::vector<io::FittedSeries> fitted;
  bool log_laws = true;
  double log_aicc = 0.0, power_aicc = 0.0;  ///< sums over the series
};

Result solve(const io::CaseRun& run) {
  Result result{.fit = io::read_fit_case(run), .fitted = {}};
  for (const io::FitSeries& series : result.fit.series) {
    try {
      result.fitted.push_back(
          {series, cutting::fit_power_law(series.cuts), cutting::fit_log_law(series.cuts)});
    } catch (const InvalidInput& error) {
      Fault fault = error.faults().front();
      fault.field = fmt::format("{} force", series.component) +
                    (series.direction ? fmt::format(" at {} deg", *series.direction) : "");
      throw InvalidInput(fault);
    }
    result.log_aicc += result.fitted.back().log.quality.aicc;
    result.power_aicc += result.fitted.back().power.quality.aicc;
  }
  result.log_laws = result.fit.form == io::FitForm::automatic ? result.log_aicc <= result.power_aicc
                                                              : result.fit.form == io::FitForm::log;
  return result;
}

std::string name_of(const io::FitSeries& series) {
  return series.component +
         (series.direction ? fmt::format(", {} deg", *series.direction) : std::string());
}

Json quality_of(const cutting::FitQuality& quality) {
  Json json = {{"residual_rms_n_per_mm", quality.rms / units::n_per_mm},
               {"r_squared", quality.r_squared}};
  // Too few points for the correction of small samples.
  json["aicc"] = std::isfinite(quality.aicc) ? Json(quality.aicc) : Json(nullptr);
  return json;
}

Json law_of(const cutting::PowerFit& fit) {
  Json json = {{"k", fit.law.at_1_mm / units::n_per_mm},
               {"n", fit.law.exponent},
               {"edge_n_per_mm", fit.law.edge / units::n_per_mm}};
  json["standard_errors"] = {{"k", fit.standard_errors[0] / units::n_per_mm},
                             {"n", fit.standard_errors[1]},
                             {"edge_n_per_mm", fit.standard_errors[2] / units::n_per_mm}};
  json["edge_at_bound"] = fit.edge_at_bound;
  json["constant"] = fit.constant;
  json.update(quality_of(fit.quality));
  return json;
}

Json law_of(const cutting::LogFit& fit) {
  Json json = {{"k1", fit.law.k1}, {"k2", fit.law.k2}, {"k3", fit.law.k3}};
  json["standard_errors"] = {{"k1", fit.standard_errors[0]},
                             {"k2", fit.standard_errors[1]},
                             {"k3", fit.standard_errors[2]}};
  json.update(quality_of(fit.quality));
  return json;
}

bool log_is_better(const io::FittedSeries& one) {
  return one.log.quality.aicc <= one.power.quality.aicc;
}

Json document_of(const Result& result) {
  Json document;
  document["law"] = result.log_laws ? "log" : "power";
  Json fits = Json::array();
  for (const io::FittedSeries& one : result.fitted) {
    Json fit = {{"component", one.series.component}};
    fit["direction_deg"] = one.series.direction ? Json(*one.series.direction) : Json(nullptr);
    fit["points"] = one.series.cuts.size();
    fit["range_um"] = {one.log.law.range.low / units::um, one.log.law.range.high / units::um};
    fit["power"] = law_of(one.power);
    fit["log"] = law_of(one.log);
    fit["better"] = log_is_better(one) ? "log" : "power";
    Json effects = Json::array();
    for (const cutting::SpeedEffect& effect : one.series.speed_effects) {
      effects.push_back({{"chip_thickness_um", effect.h / units::um},
                         {"slow_mean_n_per_mm", effect.slow_mean / units::n_per_mm},
                         {"fast_mean_n_per_mm", effect.fast_mean / units::n_per_mm},
                         {"t", effect.t},
                         {"degrees_of_freedom", effect.degrees_of_freedom},
                         {"p", effect.p}});
    }
    fit["speed_effects"] = effects;
    fits.push_back(fit);
  }
  document["fits"] = fits;
  document["entry"] = io::bone_entry(result.fit, result.fitted, result.log_laws);
  return document;
}

std::vector<std::vector<std::string>> rows_of(const Result& result) {
  std::vector<std::vector<std::string>> rows = {
      {"force", "law", "constants and their standard errors", "rms, N/mm", "R2", "AICc"}};
  const auto both = [](double value, double error) {
    return fmt::format("{:.4g} +- {:.2g}", value, error);
  };
  const auto row = [&](std::string name, const char* law, std::string constants,
                       const cutting::FitQuality& quality, bool better) {
    rows.push_back({std::move(name), law, std::move(constants),
                    fmt::format("{:.3g}", quality.rms / units::n_per_mm),
                    fmt::format("{:.4f}", quality.r_squared),
                    std::isfinite(quality.aicc)
                        ? fmt::format("{:.1f}{}", quality.aicc, better ? " *" : "  ")
                        : std::string("too few points")});
  };
  for (const io::FittedSeries& one : result.fitted) {
    const auto& p = one.power;
    row(name_of(one.series), "power",
        p.constant
            ? fmt::format(
                  "a constant, {} (K would be < 0)",
                  both(p.law.edge / units::n_per_mm, p.standard_errors[2] / units::n_per_mm))
            : fmt::format(
                  "k {}, n {}, edge {}",
                  both(p.law.at_1_mm / units::n_per_mm, p.standard_errors[0] / units::n_per_mm),
                  both(p.law.exponent, p.standard_errors[1]),
                  p.edge_at_bound
                      ? std::string("0 (bound)")
                      : both(p.law.edge / units::n_per_mm, p.standard_errors[2] / units::n_per_mm)),
        p.quality, !log_is_better(one));
    const auto& l = one.log;
    row("", "log",
        fmt::format("k1 {}, k2 {}, k3 {}", both(l.law.k1, l.standard_errors[0]),
                    both(l.law.k2, l.standard_errors[1]), both(l.law.k3, l.standard_errors[2])),
        l.quality, log_is_better(one));
  }
  return rows;
}

std::vector<std::string> sentences_of(const Result& result) {
  std::vector<std::string> sentences = {
      "* the law that Akaike's criterion prefers (less is better)"};
  for (const io::FittedSeries& one : result.fitted) {
    for (const cutting::SpeedEffect& effect : one.series.speed_effects) {
      sentences.push_back(fmt::format(
          "speed, {} at {:g} um: {:+.1f} % from {:g} to {:g} m/s, t({:g}) = {:.2f}, p = {:.2g}",
          name_of(one.series), effect.h / units::um,
          100.0 * (effect.fast_mean / effect.slow_mean - 1.0), result.fit.speeds.front(),
          result.fit.speeds.back(), effect.degrees_of_freedom, effect.t, effect.p));
    }
  }
  const auto has = [&](const char* component) {
    return std::any_of(result.fitted.begin(), result.fitted.end(),
                       [&](const auto& one) { return one.series.component == component; });
  };
  sentences.push_back(
      has("tangential") && has("radial")
          ? fmt::format(
                "the {} laws make an entry: [bone] use = \"FOLDER/bone.toml\" after -o FOLDER",
                result.log_laws ? "log" : "power")
          : "a [bone] needs tangential and radial forces: this table has one of them only");
  return sentences;
}

io::Panel panel_of(const Result& result, const char* component) {
  io::Panel panel{.y = {.label = fmt::format("{} force, N/mm", component)}, .series = {}};
  std::size_t colour = 0;
  for (const io::FittedSeries& one : result.fitted) {
    if (one.series.component != component) continue;
    const std::string at =
        one.series.direction ? fmt::format(" {} deg", *one.series.direction) : std::string();
    io::Series points{
        .label = "cuts" + at, .x = {}, .y = {}, .mark = io::Mark::points, .colour = colour};
    for (const cutting::OrthogonalCut& cut : one.series.cuts) {
      points.x.push_back(cut.h / units::um);
      points.y.push_back(cut.force / units::n_per_mm);
    }
    io::Series log{.label = "log law" + at, .x = {}, .y = {}, .colour = colour};
    io::Series power{
        .label = "power law" + at, .x = {}, .y = {}, .mark = io::Mark::dashed, .colour = colour};
    const auto [low, high] = one.log.law.range;
    for (int i = 0; i <= 120; ++i) {
      const double h = low * std::pow(high / low, i / 120.0);
      log.x.push_back(h / units::um);
      power.x.push_back(h / units::um);
      log.y.push_back(cutting::force_per_width(one.log.law, h) / units::n_per_mm);
      power.y.push_back(cutting::force_per_width(one.power.law, h) / units::n_per_mm);
    }
    panel.series.insert(panel.series.end(), {points, log, power});
    ++colour;
  }
  return panel;
}

/// Whole decades around the chips, so that the axis has its numbers.
io::Axis chip_axis(const Result& result) {
  double low = result.fitted.front().log.law.range.low;
  double high = result.fitted.front().log.law.range.high;
  for (const io::FittedSeries& one : result.fitted) {
    low = std::min(low, one.log.law.range.low);
    high = std::max(high, one.log.law.range.high);
  }
  return {.label = "chip thickness, um",
          .low = std::pow(10.0, std::floor(std::log10(low / units::um))),
          .high = std::pow(10.0, std::ceil(std::log10(high / units::um))),
          .logarithmic = true};
}

std::vector<Figure> figures_of(const Result& result) {
  io::LinePlot forces;
  forces.title = "Orthogonal cuts and their laws";
  forces.x = chip_axis(result);
  for (const char* component : {"tangential", "radial", "lateral"}) {
    io::Panel panel = panel_of(result, component);
    if (!panel.series.empty()) forces.panels.push_back(std::move(panel));
  }
  forces.height = 300 * static_cast<int>(forces.panels.size()) + 60;
  io::LinePlot energy;
  energy.title = "Specific cutting energy of the laws";
  energy.x = chip_axis(result);
  io::Panel panel{.y = {.label = "F_t/h, J/mm³", .logarithmic = true}, .series = {}};
  for (const io::FittedSeries& one : result.fitted) {
    if (one.series.component != "tangential") continue;
    const cutting::EdgeForce law =
        result.log_laws ? cutting::EdgeForce(one.log.law) : cutting::EdgeForce(one.power.law);
    io::Series series{.label = name_of(one.series), .x = {}, .y = {}};
    const auto [low, high] = one.log.law.range;
    for (int i = 0; i <= 120; ++i) {
      const double h = low * std::pow(high / low, i / 120.0);
      series.x.push_back(h / units::um);
      series.y.push_back(cutting::specific_energy(law, h) * units::mm3);
    }
    panel.series.push_back(series);
  }
  std::vector<Figure> figures = {
      {"fit", "Points, log law (line) and power law (dashed).",
       [forces](const std::filesystem::path& file) { io::draw(forces, file); }}};
  if (!panel.series.empty()) {
    energy.panels = {panel};
    figures.push_back({"energy", "Specific cutting energy of the law that was taken.",
                       [energy](const std::filesystem::path& file) { io::draw(energy, file); }});
  }
  return figures;
}

Shown show_fit(const io::CaseRun& run) {
  const Result result = solve(run);
  Shown shown;
  shown.document = document_of(result);
  shown.expanded = result.fit.expanded;
  shown.rows = rows_of(result);
  shown.sentences = sentences_of(result);
  shown.figures = figures_of(result);
  shown.files = {{"bone.toml", shown.document["entry"].get<std::string>()}};
  if (result.fit.speeds.size() > 1 && result.fit.fitted_speeds.size() > 1) {
    shown.warnings.push_back(
        fmt::format("cuts of {} speeds are fitted together; cuts.speed_m_per_s takes one of them",
                    result.fit.speeds.size()));
  }
  return shown;
}

}  // namespace

void add_fit(CLI::App& program) {
  auto arguments = std::make_shared<CaseArguments>();
  CLI::App* command = program.add_subcommand("fit", "laws of edge forces from orthogonal cuts");
  add_case_arguments(*command, *arguments);
  command->callback([arguments] { show_runs(*arguments, "fit", show_fit); });
}

}  // namespace osteomill::cli
