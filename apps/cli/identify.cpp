// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include "documents.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/io/identify_case.hpp"
#include "osteomill/io/identify_figures.hpp"
#include "osteomill/io/identify_result.hpp"
#include "osteomill/io/text_file.hpp"

namespace osteomill::cli {
namespace {

using namespace identify;
using Rows = std::vector<std::vector<std::string>>;

std::string number(double value) { return fmt::format("{:.4g}", value); }

Rows coefficient_rows(const MeanForceFit& fit, double confidence) {
  Rows rows = {{"coefficient", "value", "standard error",
                fmt::format("{:g} % interval", 100.0 * confidence), "unit", "determined"}};
  for (const Coefficient& one : fit.coefficients) {
    const double factor = factor_of(one.dimension);
    rows.push_back({one.name, number(one.value / factor), number(one.standard_error / factor),
                    fmt::format("{:.4g} ... {:.4g}", one.low / factor, one.high / factor),
                    unit_of(one.dimension),
                    one.at_bound     ? "at bound"
                    : one.determined ? "yes"
                                     : "NO"});
  }
  return rows;
}

Rows candidate_rows(const std::vector<Candidate>& candidates) {
  Rows rows = {{"model", "unknowns", "leave-one-out, N", "group out, N", "residual, N", "condition",
                "determined", ""}};
  for (const Candidate& one : candidates) {
    if (!one.fit || !one.leave_one || !one.not_ranked.empty()) {
      rows.push_back({one.name, fmt::format("{}", one.unknowns), "", "", "", "", "", "not ranked"});
      continue;
    }
    int determined = 0;
    for (const Coefficient& k : one.fit->coefficients) determined += k.determined ? 1 : 0;
    rows.push_back(
        {one.name, fmt::format("{}", one.unknowns), fmt::format("{:.3f}", one.leave_one->rms),
         one.leave_group && one.leave_group->complete ? fmt::format("{:.3f}", one.leave_group->rms)
                                                      : "",
         fmt::format("{:.3f}", one.fit->residual_rms_all), number(one.fit->condition_number),
         fmt::format("{} of {}", determined, one.unknowns),
         one.chosen ? "chosen"
         : one.tied ? "tied"
                    : ""});
  }
  return rows;
}

Rows experiment_rows(const std::vector<Experiment>& experiments, const Candidate& chosen) {
  Rows rows = {{"cut", "depth, mm", "feed, um/tooth", "measured Fx, Fy, Fz, N", "residual, N",
                "left out, N", "Cook"}};
  const auto three = [](const geometry::Vector3& v) {
    return fmt::format("{:.2f} {:.2f} {:.2f}", v.x(), v.y(), v.z());
  };
  for (std::size_t i = 0; i < experiments.size(); ++i) {
    const Experiment& one = experiments[i];
    const auto row = static_cast<Eigen::Index>(i);
    const auto& error = chosen.leave_one->error[i];
    rows.push_back({one.name, number(one.immersion.axial_depth / units::mm),
                    number(one.condition.feed_per_tooth / units::um), three(one.mean_force),
                    three(chosen.fit->residual.row(row).transpose()),
                    error ? three(*error) : "not determined",
                    fmt::format("{:.2f}", chosen.fit->cook_distance(row))});
  }
  return rows;
}

struct Arguments : CaseArguments {
  std::filesystem::path entry;
};

Shown show_identify(const io::CaseRun& run, const Arguments& arguments) {
  const io::IdentifyCase input = io::read_identify_case(run);
  const MeanForceIdentification result =
      identify_mean_forces(input.experiments, input.models, input.options);
  Shown shown;
  shown.document = io::identify_document(input, result);
  shown.expanded = input.expanded;
  shown.rows = coefficient_rows(*result.best().fit, input.options.fit.confidence);
  shown.sentences = result.verdict;
  shown.warnings = result.warnings;
  if (!arguments.entry.empty()) {
    io::write_text_file(arguments.entry, io::catalogue_entry_of(input, result));
  }
  if (result.candidates.size() > 1) shown.tables.push_back(candidate_rows(result.candidates));
  shown.tables.push_back(experiment_rows(input.experiments, result.best()));
  shown.files = {{"bone.toml", io::catalogue_entry_of(input, result)}};
  for (io::IdentifyFigure& figure :
       io::identify_figures(input.experiments, result, input.options.fit.confidence)) {
    shown.figures.push_back({figure.name, figure.caption, figure.draw});
  }
  return shown;
}

}  // namespace

void add_identify(CLI::App& program) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command = program.add_subcommand(
      "identify", "cutting coefficients from measured forces, and how far to trust them");
  add_case_arguments(*command, *arguments);
  command->add_option("--entry", arguments->entry, "write the law as a catalogue entry (TOML)");
  command->callback([command, arguments] {
    if (!command->get_subcommands().empty()) return;
    if (arguments->case_file.empty()) throw CLI::RequiredError("case");
    show_runs(*arguments, "identify",
              [&](const io::CaseRun& run) { return show_identify(run, *arguments); });
  });
}

}  // namespace osteomill::cli
