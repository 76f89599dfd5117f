// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/identify_figures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "osteomill/base/units.hpp"
#include "osteomill/io/plot.hpp"
#include "osteomill/numerics/bounded_least_squares.hpp"
#include "osteomill/numerics/distributions.hpp"

namespace osteomill::io {
namespace {

using namespace identify;
using Eigen::Index;
using Eigen::VectorXd;

constexpr std::array<const char*, 3> kAxes = {"Fx", "Fy", "Fz"};

template <class Plot>
IdentifyFigure figure(std::string name, std::string caption, Plot plot) {
  return {std::move(name), std::move(caption),
          [plot = std::move(plot)](const std::filesystem::path& file) { io::draw(plot, file); }};
}

Series points(std::string label, std::size_t colour) {
  return {.label = std::move(label), .x = {}, .y = {}, .mark = Mark::points, .colour = colour};
}

/// Error of prediction over the number of unknowns: where it turns, more unknowns fit noise.
IdentifyFigure models_figure(const MeanForceIdentification& result) {
  Series residual = points("residual of the fit", 5);
  Series other = points("left out and predicted", 0);
  Series tied = points("tied with the best", 1);
  Series chosen = points("chosen", 2);
  double least = 1e300, most = 0.0, lowest = 1e300;
  for (const Candidate& one : result.candidates) {
    if (!one.not_ranked.empty()) continue;
    Series& to = one.chosen ? chosen : one.tied ? tied : other;
    to.x.push_back(one.unknowns);
    to.y.push_back(one.leave_one->rms);
    residual.x.push_back(one.unknowns);
    residual.y.push_back(one.fit->residual_rms_all);
    least = std::min(least, 1.0 * one.unknowns);
    most = std::max(most, 1.0 * one.unknowns);
    lowest = std::min(lowest, one.leave_one->rms);
  }
  LinePlot plot;
  plot.title = "Models: error of the fit and of predictions";
  plot.x = {.label = "unknowns of the model", .low = least - 1.0, .high = most + 1.0};
  Panel panel{.y = {.label = "rms error, N", .low = 0.0}, .series = {}};
  for (const Series& one : {residual, other, tied, chosen}) {
    if (!one.x.empty()) panel.series.push_back(one);
  }
  panel.limits = {{lowest, "best"}};
  plot.panels = {panel};
  return figure("models",
                "Each model twice: how it fits, and how it predicts each cut from the others. The "
                "gap between the two is what it has fitted of the noise.",
                plot);
}

IdentifyFigure fit_figure(const std::vector<Experiment>& experiments, const Candidate& chosen) {
  LinePlot plot;
  plot.title = "Mean forces: " + chosen.name;
  plot.x = {.label = "measured, N"};
  Panel panel{.y = {.label = "from the model, N"}, .series = {}};
  double low = 1e300, high = -1e300;
  for (Index c = 0; c < 3; ++c) {
    Series fitted = points(kAxes[static_cast<std::size_t>(c)], static_cast<std::size_t>(c));
    for (std::size_t i = 0; i < experiments.size(); ++i) {
      const auto row = static_cast<Index>(i);
      fitted.x.push_back(experiments[i].mean_force(c));
      fitted.y.push_back(chosen.fit->predicted(row, c));
      low = std::min({low, fitted.x.back(), fitted.y.back()});
      high = std::max({high, fitted.x.back(), fitted.y.back()});
    }
    panel.series.push_back(fitted);
  }
  const double margin = 0.05 * (high - low);
  panel.series.push_back({.label = "equal",
                          .x = {low - margin, high + margin},
                          .y = {low - margin, high + margin},
                          .mark = Mark::dashed,
                          .colour = 6});
  plot.x.low = panel.y.low = low - margin;
  plot.x.high = panel.y.high = high + margin;
  plot.panels = {panel};
  plot.width = 640;
  plot.height = 560;
  return figure("fit", "Mean forces of the chosen model against the measured ones.", plot);
}

IdentifyFigure residuals_figure(const std::vector<Experiment>& experiments,
                                const Candidate& chosen) {
  LinePlot plot;
  plot.title = "Residuals, and errors of each cut predicted from the others";
  plot.x = {.label = "row of the table",
            .low = 0.5,
            .high = static_cast<double>(experiments.size()) + 0.5};
  for (Index c = 0; c < 3; ++c) {
    Series residual = points(c == 0 ? "residual" : "", 0);
    Series left_out = points(c == 0 ? "left out" : "", 1);
    for (std::size_t i = 0; i < experiments.size(); ++i) {
      const double number = static_cast<double>(i) + 1.0;
      residual.x.push_back(number - 0.1);
      residual.y.push_back(chosen.fit->residual(static_cast<Index>(i), c));
      if (!chosen.leave_one->error[i]) continue;
      left_out.x.push_back(number + 0.1);
      left_out.y.push_back((*chosen.leave_one->error[i])(c));
    }
    plot.panels.push_back({.y = {.label = fmt::format("{}, N", kAxes[static_cast<std::size_t>(c)])},
                           .series = {residual, left_out},
                           .limits = {{0.0, ""}}});
  }
  plot.height = 620;
  return figure("residuals",
                "Measured less fitted, and measured less predicted from all other cuts. A pattern "
                "over the rows is something that the model does not know.",
                plot);
}

/// Values over x with the confidence band that the covariance gives, by the delta method.
template <class Value>
void add_band(const MeanForceFit& fit, double t, const std::vector<double>& x, std::string label,
              std::size_t colour, Value value, Panel& panel) {
  Series line{.label = label, .x = x, .y = {}, .colour = colour};
  Band band{.label = "", .x = x, .low = {}, .high = {}, .colour = colour};
  const auto all = [&](const VectorXd& values) -> VectorXd {
    VectorXd y(static_cast<Index>(x.size()));
    for (std::size_t i = 0; i < x.size(); ++i) y(static_cast<Index>(i)) = value(values, x[i]);
    return y;
  };
  const VectorXd y = all(fit.values);
  const Eigen::MatrixXd slope = numerics::central_differences(all, fit.values);
  for (Index i = 0; i < y.size(); ++i) {
    const double error = std::sqrt((slope.row(i) * fit.covariance * slope.row(i).transpose())(0));
    line.y.push_back(y(i));
    band.low.push_back(y(i) - t * error);
    band.high.push_back(y(i) + t * error);
  }
  panel.series.push_back(line);
  panel.bands.push_back(band);
}

std::vector<double> steps(double from, double to, bool geometric) {
  std::vector<double> x;
  for (int i = 0; i <= 60; ++i) {
    x.push_back(geometric ? from * std::pow(to / from, i / 60.0) : from + (to - from) * i / 60.0);
  }
  return x;
}

const cutting::DirectionalLaw& component(const cutting::CuttingLaw& law, std::size_t i) {
  return i == 0 ? law.tangential : i == 1 ? law.radial : *law.lateral;
}

/// Pressures and edge forces over kappa.
LinePlot law_over_kappa(const std::vector<Experiment>& experiments, const MeanForceFit& fit,
                        double t) {
  LinePlot plot;
  plot.x = {.label = "axial position angle kappa, deg"};
  const double end = largest_kappa(experiments) / units::deg;
  const std::vector<double> x = steps(0.0, end, false);
  constexpr std::array<const char*, 3> kNames = {"tangential", "radial", "axial"};
  const auto panel_of = [&](const char* label, double h, double stretch, double unit) {
    Panel panel{.y = {.label = label}, .series = {}, .limits = {{0.0, ""}}};
    for (std::size_t c = 0; c < 3; ++c) {
      const double sign = c == 2 ? -1.0 : 1.0;  // axial is away from the tip, lateral towards it
      add_band(
          fit, t, x, plot.panels.empty() ? kNames[c] : "", c,
          [&, c, sign](const VectorXd& values, double kappa) {
            return sign / unit *
                   cutting::force_per_width(component(law_of(fit.model, values), c).at_0, h,
                                            {kappa * units::deg, stretch});
          },
          panel);
    }
    plot.panels.push_back(panel);
  };
  if (fit.model.shear_order >= 0) panel_of("pressure, N/mm²", 1.0, 0.0, units::n_per_mm2);
  if (fit.model.edge_order >= 0) panel_of("edge force, N/mm", 0.0, 1.0, units::n_per_mm);
  return plot;
}

/// Force per width over the chip.
LinePlot law_over_chip(const std::vector<Experiment>& experiments, const MeanForceFit& fit,
                       double t) {
  LinePlot plot;
  const cutting::ChipRange chips = chip_range(experiments);
  const bool straight = is_linear(fit.model);
  const double from = straight ? 0.0 : 0.2 * chips.low / units::um;
  plot.x = {.label = "chip thickness, µm", .logarithmic = !straight};
  const std::vector<double> x = steps(from, chips.high / units::um, !straight);
  constexpr std::array<const char*, 3> kNames = {"tangential", "radial", "lateral"};
  Panel panel{.y = {.label = "force per width, N/mm"}, .series = {}};
  std::size_t colour = 0;
  for (std::size_t c = 0; c < 3; ++c) {
    const bool two = fit.model.directional && c < 2;
    for (int across = 0; across <= (two ? 1 : 0); ++across) {
      const std::string label =
          kNames[c] + std::string(two ? (across != 0 ? ", across" : ", along") : "");
      add_band(
          fit, t, x, label, colour++,
          [&, c, across](const VectorXd& values, double h) {
            const cutting::CuttingLaw law = law_of(fit.model, values);
            const cutting::DirectionalLaw& one = component(law, c);
            return cutting::force_per_width(across != 0 ? *one.at_90 : one.at_0, h * units::um) /
                   units::n_per_mm;
          },
          panel);
    }
  }
  plot.panels = {panel};
  return plot;
}

IdentifyFigure law_figure(const std::vector<Experiment>& experiments, const Candidate& chosen,
                          double confidence) {
  const MeanForceFit& fit = *chosen.fit;
  const double t =
      numerics::student_t_quantile(0.5 + 0.5 * confidence, std::max(1e-3, fit.degrees_of_freedom));
  LinePlot plot = fit.model.form == LawForm::polynomial ? law_over_kappa(experiments, fit, t)
                                                        : law_over_chip(experiments, fit, t);
  plot.title = "The law: " + chosen.name;
  plot.height = plot.panels.size() > 1 ? 620 : 450;
  return figure(
      "law",
      fmt::format("The identified law with its {:g} % confidence band, over what was cut.",
                  100.0 * confidence),
      plot);
}

IdentifyFigure influence_figure(const std::vector<Experiment>& experiments,
                                const Candidate& chosen) {
  const MeanForceFit& fit = *chosen.fit;
  LinePlot plot;
  plot.title = "Influence of each cut";
  plot.x = {.label = "row of the table",
            .low = 0.5,
            .high = static_cast<double>(experiments.size()) + 0.5};
  Series cook = points("", 0), leverage = points("", 1);
  for (std::size_t i = 0; i < experiments.size(); ++i) {
    cook.x.push_back(static_cast<double>(i) + 1.0);
    cook.y.push_back(fit.cook_distance(static_cast<Index>(i)));
    leverage.y.push_back(fit.leverage(static_cast<Index>(i)));
  }
  leverage.x = cook.x;
  plot.panels = {{.y = {.label = "Cook's distance", .low = 0.0}, .series = {cook}},
                 {.y = {.label = "leverage", .low = 0.0}, .series = {leverage}}};
  plot.height = 480;
  return figure("influence",
                "How far each cut moves all predictions (above 1: much), and how many of its three "
                "forces the model spends on fitting it alone.",
                plot);
}

}  // namespace

std::vector<IdentifyFigure> identify_figures(const std::vector<Experiment>& experiments,
                                             const MeanForceIdentification& result,
                                             double confidence) {
  std::vector<IdentifyFigure> figures;
  if (result.candidates.size() > 1) figures.push_back(models_figure(result));
  figures.push_back(fit_figure(experiments, result.best()));
  figures.push_back(residuals_figure(experiments, result.best()));
  figures.push_back(law_figure(experiments, result.best(), confidence));
  figures.push_back(influence_figure(experiments, result.best()));
  return figures;
}

}  // namespace osteomill::io
