// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include "documents.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/io/instantaneous_case.hpp"
#include "osteomill/io/plot.hpp"
#include "osteomill/io/signal_export.hpp"
#include "osteomill/io/signal_figures.hpp"
#include "osteomill/io/text_file.hpp"

namespace osteomill::cli {
namespace {

struct Arguments : CaseArguments {
  std::filesystem::path entry;
};

/// The mean revolution, the model on it, and what is left.
io::LinePlot plot_of(const io::InstantaneousResult& result) {
  io::LinePlot plot;
  plot.title = "mean revolution and fitted model";
  plot.x = {.label = "rotation angle, deg", .low = 0.0, .high = 360.0};
  plot.height = 620;
  io::Panel forces{.y = {.label = "force, N"}, .series = {}, .share_of_height = 2.0};
  io::Panel left{.y = {.label = "residual, N"}, .series = {}};
  std::vector<double> angle;
  for (const double one : result.forces.angle) angle.push_back(one / units::deg);
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const std::string name = std::string("F") + "xyz"[axis];
    const auto colour = static_cast<std::size_t>(axis);
    const Eigen::VectorXd measured = result.forces.mean.col(axis);
    const Eigen::VectorXd fitted = result.fit.fitted.col(axis);
    const Eigen::VectorXd rest = measured - fitted;
    forces.series.push_back({.label = name + " measured",
                             .x = angle,
                             .y = {measured.begin(), measured.end()},
                             .mark = io::Mark::points,
                             .colour = colour});
    forces.series.push_back({.label = name + " fitted",
                             .x = angle,
                             .y = {fitted.begin(), fitted.end()},
                             .colour = colour});
    left.series.push_back(
        {.label = name, .x = angle, .y = {rest.begin(), rest.end()}, .colour = colour});
  }
  plot.panels = {forces, left};
  return plot;
}

Shown show_instantaneous(const io::CaseRun& run, const Arguments& arguments) {
  const io::InstantaneousCase input = io::read_instantaneous_case(run);
  const io::InstantaneousResult result = io::solve(input);
  const identify::InstantaneousFit& fit = result.fit;
  Shown shown;
  shown.document = io::instantaneous_document(input, result);
  shown.expanded = input.expanded;
  shown.warnings = result.warnings;
  shown.rows = {{"unknown", "value", "standard error",
                 fmt::format("{:g} % interval", 100.0 * input.options.confidence), "unit"}};
  for (const identify::Estimate& one : fit.estimates) {
    const io::ShownEstimate unit = io::unit_of(one);
    const auto number = [&](double value) { return fmt::format("{:.4g}", value / unit.factor); };
    shown.rows.push_back({one.name, number(one.value),
                          one.determined ? number(one.standard_error) : "not determined",
                          one.determined ? number(one.low) + " ... " + number(one.high) : "",
                          unit.unit});
  }
  shown.sentences = result.processed.steps;
  shown.sentences.push_back(fmt::format(
      "run-out {:.3g} um at {:.0f} deg behind flute 0; residual rms {:.3g}/{:.3g}/{:.3g} N, noise "
      "{:.3g}/{:.3g}/{:.3g} N (x/y/z); {} values worth {:.0f} independent ones; condition number "
      "{:.3g}",
      fit.run_out.offset / units::um, fit.run_out.offset_angle / units::deg, fit.residual_rms.x(),
      fit.residual_rms.y(), fit.residual_rms.z(), fit.noise_rms.x(), fit.noise_rms.y(),
      fit.noise_rms.z(), 3 * result.forces.angle.size(), fit.effective_values,
      fit.condition_number));
  shown.sentences.insert(shown.sentences.end(), fit.verdict.begin(), fit.verdict.end());
  shown.figures.push_back(
      {"revolution", "Mean revolution, fitted model, residual",
       [plot = plot_of(result)](const std::filesystem::path& file) { io::draw(plot, file); }});
  const std::string name = input.record.stem().string();
  for (const io::SignalFigure& one :
       io::figures_of(result.raw, result.processed, input.cutter.cutter.flutes, name)) {
    shown.figures.push_back(
        {"signal-" + one.name, one.caption,
         [plot = one.plot](const std::filesystem::path& file) { io::draw(plot, file); }});
  }
  const std::string entry = io::instantaneous_entry(input, result);
  if (!arguments.entry.empty()) io::write_text_file(arguments.entry, entry);
  shown.files = {{"bone.toml", entry}};
  const identify::CutOfRecord cut{input.condition.spindle_speed, input.cutter.cutter.flutes};
  shown.written.push_back(
      {"signals.h5",
       [run = io::signals_of(result.raw, result.processed, input.signals.chain, cut, name)](
           const std::filesystem::path& file) { io::write_signals({.runs = {run}}, file); }});
  return shown;
}

}  // namespace

void add_identify_instantaneous(CLI::App& program) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command =
      program.get_subcommand("identify")
          ->add_subcommand(
              "instantaneous",
              "coefficients, run-out and phase from one record over whole revolutions");
  add_case_arguments(*command, *arguments);
  command->add_option("--entry", arguments->entry, "write the law as a catalogue entry (TOML)");
  command->callback([arguments] {
    show_runs(*arguments, "identify instantaneous",
              [&](const io::CaseRun& run) { return show_instantaneous(run, *arguments); });
  });
}

}  // namespace osteomill::cli
