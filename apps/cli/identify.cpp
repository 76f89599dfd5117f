// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <cmath>

#include "documents.hpp"
#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/identify/combined_records.hpp"
#include "osteomill/identify/revolution_fit.hpp"
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

/// Every record over its revolutions.
struct Instantaneous {
  std::vector<std::string> names;
  std::vector<InstantaneousFit> fits;
  CombinedRecords combined;
};

std::optional<Instantaneous> fit_records(const io::IdentifyCase& input) {
  if (input.method == io::IdentifyMethod::mean_forces) return {};
  Instantaneous result;
  InstantaneousOptions options;
  options.confidence = input.options.fit.confidence;
  for (const io::LoadedExperiment& one : input.loaded) {
    const bool able = one.processed && one.processed->rotation && !input.chain.average_flutes;
    if (!able && input.method == io::IdentifyMethod::automatic) continue;
    if (!one.processed) {
      throw InvalidInput(Fault{"model.method", "instantaneous",
                               "needs records; " + one.experiment.name + " has mean forces only",
                               "name its record in the table"});
    }
    const Experiment& cut = one.experiment;
    result.fits.push_back(fit_processed(*one.processed, input.chain, cut.cutter, cut.condition,
                                        cut.immersion, options));
    result.names.push_back(cut.name);
  }
  if (result.fits.empty()) return {};
  result.combined =
      combine_records(result.fits, result.names, options.units.size(), options.confidence);
  return result;
}

Dimension dimension_of(const Estimate& one) {
  return one.name.ends_with("c") ? Dimension::pressure : Dimension::force_per_width;
}

Rows combined_rows(const Instantaneous& records, double confidence) {
  Rows rows = {{fmt::format("instantaneous, {} records", records.combined.records), "value",
                "standard error", fmt::format("{:g} % interval", 100.0 * confidence), "unit"}};
  for (const Estimate& one : records.combined.coefficients) {
    const double factor = factor_of(dimension_of(one));
    rows.push_back({one.name, number(one.value / factor), number(one.standard_error / factor),
                    fmt::format("{:.4g} ... {:.4g}", one.low / factor, one.high / factor),
                    unit_of(dimension_of(one))});
  }
  return rows;
}

Rows record_rows(const Instantaneous& records) {
  Rows rows = {
      {"record", "run-out, um", "residual Fx, Fy, Fz, N", "explained by scatter, N", "condition"}};
  for (std::size_t i = 0; i < records.fits.size(); ++i) {
    const InstantaneousFit& fit = records.fits[i];
    rows.push_back({records.names[i], number(fit.run_out.offset / units::um),
                    fmt::format("{:.2f} {:.2f} {:.2f}", fit.residual_rms.x(), fit.residual_rms.y(),
                                fit.residual_rms.z()),
                    fmt::format("{:.2f} {:.2f} {:.2f}", fit.noise_rms.x(), fit.noise_rms.y(),
                                fit.noise_rms.z()),
                    number(fit.condition_number)});
  }
  return rows;
}

nlohmann::ordered_json estimates_json(const std::vector<Estimate>& estimates, std::size_t count) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < count; ++i) {
    const Estimate& one = estimates[i];
    const double factor = factor_of(dimension_of(one));
    list.push_back({{"name", one.name},
                    {"value", one.value / factor},
                    {"unit", unit_of(dimension_of(one))},
                    {"standard_error", one.standard_error / factor},
                    {"interval", {one.low / factor, one.high / factor}},
                    {"determined", one.determined}});
  }
  return list;
}

void add_records(const Instantaneous& records, const io::IdentifyCase& input, Shown& shown) {
  nlohmann::ordered_json& document = shown.document["instantaneous"];
  document["coefficients"] =
      estimates_json(records.combined.coefficients, records.combined.coefficients.size());
  document["birge_ratio"] = records.combined.birge_ratio;
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < records.fits.size(); ++i) {
    const InstantaneousFit& fit = records.fits[i];
    list.push_back(
        {{"name", records.names[i]},
         {"coefficients", estimates_json(fit.estimates, linear_law_units().size())},
         {"run_out_um", fit.run_out.offset / units::um},
         {"run_out_angle_deg", fit.run_out.offset_angle / units::deg},
         {"residual_rms_n",
          {{"x", fit.residual_rms.x()}, {"y", fit.residual_rms.y()}, {"z", fit.residual_rms.z()}}},
         {"condition_number", fit.condition_number},
         {"verdict", fit.verdict}});
  }
  document["records"] = list;
  shown.tables.push_back(combined_rows(records, input.options.fit.confidence));
  shown.tables.push_back(record_rows(records));
  std::string text = fmt::format(
      "Instantaneous method: {} of {} records determine all six linear "
      "coefficients with run-out and phase unknown",
      records.combined.records, records.fits.size());
  if (records.combined.records > 1) {
    text +=
        fmt::format("; the cuts differ {:.2g} times as much as their errors explain{}",
                    records.combined.birge_ratio,
                    records.combined.birge_ratio > 1.0 ? ", and the errors are widened by it" : "");
  }
  shown.sentences.push_back(text + ".");
  for (std::size_t i = 0; i < records.fits.size(); ++i) {
    for (const std::string& sentence : records.fits[i].verdict) {
      shown.sentences.push_back(records.names[i] + ": " + sentence + ".");
    }
  }
}

/// Where the two methods give linear coefficients that differ by more than their errors.
void compare_methods(const MeanForceFit& means, const Instantaneous& records, Shown& shown) {
  std::string differ;
  for (const Coefficient& one : means.coefficients) {
    for (const Estimate& other : records.combined.coefficients) {
      const double error = std::hypot(one.standard_error, other.standard_error);
      if (one.name == other.name && std::abs(one.value - other.value) > 3.0 * error) {
        differ += (differ.empty() ? "" : ", ") + one.name;
      }
    }
  }
  if (differ.empty()) return;
  shown.sentences.push_back(fmt::format(
      "The two methods differ in {} by more than three standard errors. Mean forces know only the "
      "run-out that [cutter] states: put the one found by the records there and identify again.",
      differ));
}

/// The mean-force method, with all that it says.
void add_means(const io::IdentifyCase& input, const Arguments& arguments,
               const std::optional<Instantaneous>& records, Shown& shown) {
  const MeanForceIdentification result =
      identify_mean_forces(input.experiments, input.models, input.options);
  shown.document = io::identify_document(input, result);
  shown.rows = coefficient_rows(*result.best().fit, input.options.fit.confidence);
  shown.sentences = result.verdict;
  if (records && result.best().fit->model == ForceModel{}) {
    compare_methods(*result.best().fit, *records, shown);
  }
  shown.warnings.insert(shown.warnings.end(), result.warnings.begin(), result.warnings.end());
  const std::string entry = io::catalogue_entry_of(input, result);
  if (!arguments.entry.empty()) io::write_text_file(arguments.entry, entry);
  if (result.candidates.size() > 1) shown.tables.push_back(candidate_rows(result.candidates));
  shown.tables.push_back(experiment_rows(input.experiments, result.best()));
  shown.files = {{"bone.toml", entry}};
  for (io::IdentifyFigure& figure :
       io::identify_figures(input.experiments, result, input.options.fit.confidence)) {
    shown.figures.push_back({figure.name, figure.caption, figure.draw});
  }
}

Shown show_identify(const io::CaseRun& run, const Arguments& arguments) {
  const io::IdentifyCase input = io::read_identify_case(run);
  Shown shown;
  shown.expanded = input.expanded;
  nlohmann::ordered_json notes = nlohmann::ordered_json::array();
  for (const io::LoadedExperiment& one : input.loaded) {
    shown.warnings.insert(shown.warnings.end(), one.warnings.begin(), one.warnings.end());
    if (!one.notes.empty()) notes.push_back({{"name", one.experiment.name}, {"steps", one.notes}});
  }
  const std::optional<Instantaneous> records = fit_records(input);
  if (input.method == io::IdentifyMethod::instantaneous) {
    if (!arguments.entry.empty()) {
      throw InvalidInput(Fault{"--entry", arguments.entry.string(),
                               "is written from mean forces only", "set model.method = \"auto\""});
    }
    shown.rows = combined_rows(*records, input.options.fit.confidence);
    shown.document["model"] = "linear, instantaneous";
    shown.document["coefficients"] =
        estimates_json(records->combined.coefficients, records->combined.coefficients.size());
  } else {
    add_means(input, arguments, records, shown);
  }
  if (records) add_records(*records, input, shown);
  shown.document["verdict"] = shown.sentences;
  shown.document["warnings"] = shown.warnings;
  if (!notes.empty()) shown.document["records"] = notes;
  for (const io::SignalFigure& one : input.signal_figures) {
    shown.figures.push_back(
        {"signal-" + one.name, one.caption,
         [plot = one.plot](const std::filesystem::path& file) { io::draw(plot, file); }});
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
