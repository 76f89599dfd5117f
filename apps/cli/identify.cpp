// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "documents.hpp"
#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/identify/combined_records.hpp"
#include "osteomill/identify/revolution_fit.hpp"
#include "osteomill/io/identify_case.hpp"
#include "osteomill/io/identify_figures.hpp"
#include "osteomill/io/identify_result.hpp"
#include "osteomill/io/instantaneous_case.hpp"
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
  std::vector<std::string> groups;
  std::vector<std::size_t> of;  ///< index of the experiment
  std::vector<InstantaneousFit> fits;
  CombinedRecords combined;
};

std::optional<Instantaneous> fit_records(const io::IdentifyCase& input) {
  if (input.method == io::IdentifyMethod::mean_forces &&
      input.run_out.from != io::RunOutFrom::records) {
    return {};
  }
  Instantaneous result;
  InstantaneousOptions options;
  options.units = input.units;
  options.confidence = input.options.fit.confidence;
  for (std::size_t i = 0; i < input.loaded.size(); ++i) {
    const io::LoadedExperiment& one = input.loaded[i];
    const bool able = one.processed && one.processed->rotation && !input.chain.average_flutes;
    if (!able && input.method != io::IdentifyMethod::instantaneous) continue;
    if (!one.processed) {
      throw InvalidInput(Fault{"model.method", "instantaneous",
                               "needs records; " + one.experiment.name + " has mean forces only",
                               "name its record in the table"});
    }
    const Experiment& cut = one.experiment;
    result.fits.push_back(fit_processed(*one.processed, input.chain, cut.cutter, cut.condition,
                                        cut.immersion, options));
    result.names.push_back(cut.name);
    result.groups.push_back(cut.group);
    result.of.push_back(i);
    // The pulse is the same place of the spindle in every record.
    if (one.processed->rotation->absolute) {
      options.start = InstantaneousStart{result.fits.back().run_out, result.fits.back().phase};
    }
  }
  if (result.fits.empty()) return {};
  result.combined =
      combine_records(result.fits, result.names, options.units, options.confidence, result.groups);
  return result;
}

/// What is known of the run-out in the mean forces; that of records is put into the cutters.
RunOutKnowledge run_out_of(const io::IdentifyCase& input,
                           const std::optional<Instantaneous>& records,
                           std::vector<Experiment>& experiments) {
  const RunOutKnowledge stated =
      stated_run_out(experiments, input.run_out.standard_error, input.run_out.bound);
  const bool asked = input.run_out.from == io::RunOutFrom::records;
  if (asked || (input.run_out.from == io::RunOutFrom::automatic &&
                stated.source == RunOutSource::unknown && records)) {
    if (records) {
      RunOutKnowledge found = run_out_of_records(records->fits, records->of, experiments);
      if (found.source == RunOutSource::records) return found;
    }
    if (asked) {
      throw InvalidInput(Fault{"run_out.from", "records", "no record tells a run-out",
                               "give records with their rotation and without average_flutes, or "
                               "state cutter.run_out"});
    }
  }
  return stated;
}

Rows combined_rows(const Instantaneous& records, double confidence) {
  Rows rows = {{fmt::format("instantaneous, {} records", records.combined.records), "value",
                "standard error", fmt::format("{:g} % interval", 100.0 * confidence), "unit"}};
  for (const Estimate& one : records.combined.coefficients) {
    const double factor = io::unit_of(one).factor;
    rows.push_back({one.name, number(one.value / factor), number(one.standard_error / factor),
                    fmt::format("{:.4g} ... {:.4g}", one.low / factor, one.high / factor),
                    io::unit_of(one).unit});
  }
  return rows;
}

/// What the others say of a record; none where it did not go in, or alone.
const LeftOutRecord* left_out(const Instantaneous& records, const std::string& name) {
  const auto& all = records.combined.leave_one;
  const auto one = std::find_if(all.begin(), all.end(),
                                [&](const LeftOutRecord& out) { return out.name == name; });
  return one == all.end() ? nullptr : &*one;
}

Rows record_rows(const Instantaneous& records) {
  Rows rows = {{"record", "run-out, um", "residual Fx, Fy, Fz, N", "explained by scatter, N",
                "condition", "off the others", "influence"}};
  for (std::size_t i = 0; i < records.fits.size(); ++i) {
    const InstantaneousFit& fit = records.fits[i];
    rows.push_back({records.names[i], number(fit.run_out.offset / units::um),
                    fmt::format("{:.2f} {:.2f} {:.2f}", fit.residual_rms.x(), fit.residual_rms.y(),
                                fit.residual_rms.z()),
                    fmt::format("{:.2f} {:.2f} {:.2f}", fit.noise_rms.x(), fit.noise_rms.y(),
                                fit.noise_rms.z()),
                    number(fit.condition_number)});
    const LeftOutRecord* out = left_out(records, records.names[i]);
    rows.back().push_back(out == nullptr ? "" : fmt::format("{:.2g} errors", out->ratio));
    rows.back().push_back(out == nullptr ? "" : fmt::format("{:.2f}", out->influence));
  }
  return rows;
}

nlohmann::ordered_json estimates_json(const std::vector<Estimate>& estimates, std::size_t count) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < count; ++i) {
    const Estimate& one = estimates[i];
    const double factor = io::unit_of(one).factor;
    list.push_back({{"name", one.name},
                    {"value", one.value / factor},
                    {"unit", io::unit_of(one).unit},
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
  document["condition_number"] = records.combined.condition_number;
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < records.fits.size(); ++i) {
    const InstantaneousFit& fit = records.fits[i];
    list.push_back(
        {{"name", records.names[i]},
         {"coefficients",
          estimates_json(fit.estimates,
                         fit.units.size() + static_cast<std::size_t>(exponents_of(fit.units)))},
         {"run_out_um", fit.run_out.offset / units::um},
         {"run_out_angle_deg", fit.run_out.offset_angle / units::deg},
         {"residual_rms_n",
          {{"x", fit.residual_rms.x()}, {"y", fit.residual_rms.y()}, {"z", fit.residual_rms.z()}}},
         {"condition_number", fit.condition_number},
         {"verdict", fit.verdict}});
  }
  document["records"] = list;
  for (const LeftOutRecord& one : records.combined.leave_one) {
    document["leave_one_out"].push_back(
        {{"name", one.name}, {"ratio", one.ratio}, {"influence", one.influence}});
  }
  for (const LeftOutRecord& one : records.combined.leave_group) {
    document["leave_one_group_out"].push_back(
        {{"name", one.name}, {"ratio", one.ratio}, {"influence", one.influence}});
  }
  const Rows combined = combined_rows(records, input.options.fit.confidence);
  if (shown.rows != combined) shown.tables.push_back(combined);
  shown.tables.push_back(record_rows(records));
  if (!records.combined.leave_group.empty()) {
    Rows rows = {{"group left out", "off the others", "influence"}};
    for (const LeftOutRecord& one : records.combined.leave_group) {
      rows.push_back({one.name, fmt::format("{:.2g} errors", one.ratio),
                      fmt::format("{:.2f}", one.influence)});
    }
    shown.tables.push_back(rows);
  }
  std::string text = fmt::format(
      "Instantaneous method: {} of {} records determine all coefficients of its law "
      "with run-out and phase unknown",
      records.combined.records, records.fits.size());
  if (records.combined.records > 1) {
    text +=
        fmt::format("; the cuts differ {:.2g} times as much as their errors explain{}",
                    records.combined.birge_ratio,
                    records.combined.birge_ratio > 1.0 ? ", and the errors are widened by it" : "");
  }
  shown.sentences.push_back(text + ".");
  for (const LeftOutRecord& one : records.combined.leave_one) {
    if (one.ratio <= 3.0) continue;
    shown.sentences.push_back(
        fmt::format("{}: its coefficients are {:.2g} errors off those of the other cuts together.",
                    one.name, one.ratio));
  }
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
  shown.sentences.push_back(
      fmt::format("The two methods differ in {} by more than three standard errors: where bone "
                  "changes along the "
                  "cut or the law lacks something, means and revolutions weigh it differently.",
                  differ));
}

/// The mean-force method, with all that it says.
void add_means(const io::IdentifyCase& given, const Arguments& arguments,
               const std::optional<Instantaneous>& records, Shown& shown) {
  io::IdentifyCase input = given;
  input.options.run_out = run_out_of(given, records, input.experiments);
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

/// What became of the records: a table, and all of it as signals.
void show_signals(const io::IdentifyCase& input, Shown& shown) {
  const nlohmann::ordered_json records = io::records_json(input.loaded);
  if (records.empty()) return;
  shown.document["records"] = records;
  Rows rows = {{"record", "file", "speed, rpm", "plateau, s", "lines of run-out, %",
                "mean Fx, Fy, Fz, N", "standard error, N"}};
  for (const auto& one : records) {
    const auto three = [&](const char* key, const char* format) {
      const auto& v = one.at(key);
      return fmt::format(fmt::runtime(format), v.at("x").get<double>(), v.at("y").get<double>(),
                         v.at("z").get<double>());
    };
    rows.push_back({one.at("name"), one.at("file"),
                    fmt::format("{:.1f}", one.at("spindle_speed_rpm").get<double>()),
                    fmt::format("{:.3f} ... {:.3f}", one.at("plateau_s").at(0).get<double>(),
                                one.at("plateau_s").at(1).get<double>()),
                    one.at("run_out_ratio").is_null()
                        ? ""
                        : fmt::format("{:.1f}", 100.0 * one.at("run_out_ratio").get<double>()),
                    three("mean_force_n", "{:.2f} {:.2f} {:.2f}"),
                    three("standard_error_n", "{:.3f} {:.3f} {:.3f}")});
  }
  shown.tables.push_back(std::move(rows));
  shown.written.push_back({"signals.h5", [input](const std::filesystem::path& file) {
                             io::write_signals(io::record_signals(input), file);
                           }});
}

Shown show_identify(const io::CaseRun& run, const Arguments& arguments) {
  const io::IdentifyCase input = io::read_identify_case(run);
  Shown shown;
  shown.expanded = input.expanded;
  for (const io::LoadedExperiment& one : input.loaded) {
    shown.warnings.insert(shown.warnings.end(), one.warnings.begin(), one.warnings.end());
  }
  const std::optional<Instantaneous> records = fit_records(input);
  if (input.method == io::IdentifyMethod::instantaneous) {
    if (records->combined.coefficients.empty()) {
      throw NoSolution(fmt::format(
          "no record determines every coefficient of the law ({}). {}: {}. Give a law with fewer "
          "unknowns, other feeds, or more revolutions",
          fmt::join(records->combined.left_out, ", "), records->names.front(),
          fmt::join(records->fits.front().verdict, "; ")));
    }
    const std::string entry = io::catalogue_entry_of(input, records->combined);
    if (!arguments.entry.empty()) io::write_text_file(arguments.entry, entry);
    shown.files = {{"bone.toml", entry}};
    shown.rows = combined_rows(*records, input.options.fit.confidence);
    shown.document["model"] =
        name_of(input.models.size() == 1 ? input.models.front() : ForceModel{}) + ", instantaneous";
    shown.document["coefficients"] =
        estimates_json(records->combined.coefficients, records->combined.coefficients.size());
  } else {
    add_means(input, arguments, records, shown);
  }
  if (records) add_records(*records, input, shown);
  shown.document["verdict"] = shown.sentences;
  shown.document["warnings"] = shown.warnings;
  show_signals(input, shown);
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
