// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/identify_result.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "osteomill/base/units.hpp"
#include "osteomill/cutting/milling_force.hpp"
#include "osteomill/io/instantaneous_case.hpp"
#include "osteomill/io/law_entry.hpp"

namespace osteomill::io {
namespace {

using namespace identify;
using Json = nlohmann::ordered_json;

Json xyz(const geometry::Vector3& v) { return {{"x", v.x()}, {"y", v.y()}, {"z", v.z()}}; }

std::vector<double> factors_of(const MeanForceFit& fit) {
  std::vector<double> factors;
  for (const Coefficient& one : fit.coefficients) factors.push_back(factor_of(one.dimension));
  return factors;
}

/// Covariance in the units of the coefficients.
std::vector<std::vector<double>> covariance_of(const MeanForceFit& fit) {
  const std::vector<double> factors = factors_of(fit);
  std::vector<std::vector<double>> rows;
  for (std::size_t i = 0; i < factors.size(); ++i) {
    auto& row = rows.emplace_back();
    for (std::size_t k = 0; k < factors.size(); ++k) {
      row.push_back(fit.covariance(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k)) /
                    factors[i] / factors[k]);
    }
  }
  return rows;
}

Json coefficients_json(const MeanForceFit& fit) {
  Json list = Json::array();
  for (const Coefficient& one : fit.coefficients) {
    const double factor = factor_of(one.dimension);
    list.push_back({{"name", one.name},
                    {"value", one.value / factor},
                    {"unit", unit_of(one.dimension)},
                    {"standard_error", one.standard_error / factor},
                    {"interval", {one.low / factor, one.high / factor}},
                    {"run_out_shift", {one.shift_low / factor, one.shift_high / factor}},
                    {"determined", one.determined},
                    {"at_bound", one.at_bound}});
  }
  return list;
}

Json validation_json(const CrossValidation& validation,
                     const std::vector<Experiment>& experiments) {
  Json document = {{"rms_n", validation.rms}, {"rms_xyz_n", xyz(validation.rms_xyz)}};
  Json errors = Json::array();
  for (std::size_t i = 0; i < experiments.size(); ++i) {
    if (validation.error[i]) {
      errors.push_back({{"name", experiments[i].name}, {"error_n", xyz(*validation.error[i])}});
    }
  }
  document["errors"] = errors;
  document["undetermined"] = validation.undetermined;
  return document;
}

Json candidate_json(const Candidate& one) {
  Json c;
  c["model"] = one.name;
  c["unknowns"] = one.unknowns;
  c["leave_one_out_rms_n"] =
      one.leave_one && one.leave_one->complete ? Json(one.leave_one->rms) : Json();
  c["leave_one_group_out_rms_n"] =
      one.leave_group && one.leave_group->complete ? Json(one.leave_group->rms) : Json();
  c["residual_rms_n"] = one.fit ? Json(one.fit->residual_rms_all) : Json();
  c["condition_number"] = one.fit ? Json(one.fit->condition_number) : Json();
  c["coefficients_determined"] =
      one.fit ? Json(std::count_if(one.fit->coefficients.begin(), one.fit->coefficients.end(),
                                   [](const Coefficient& k) { return k.determined; }))
              : Json();
  c["chosen"] = one.chosen;
  c["tied_with_best"] = one.tied;
  c["not_ranked"] = one.not_ranked;
  return c;
}

Json experiments_json(const std::vector<Experiment>& experiments, const MeanForceFit& fit) {
  Json list = Json::array();
  for (std::size_t i = 0; i < experiments.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    const Experiment& one = experiments[i];
    list.push_back({{"name", one.name},
                    {"group", one.group},
                    {"axial_depth_mm", one.immersion.axial_depth / units::mm},
                    {"feed_per_tooth_mm", one.condition.feed_per_tooth / units::mm},
                    {"measured_n", xyz(one.mean_force)},
                    {"fitted_n", xyz(fit.predicted.row(row).transpose())},
                    {"leverage", fit.leverage(row)},
                    {"cook_distance", fit.cook_distance(row)}});
  }
  return list;
}

std::string condition_of(const IdentifyCase& input) {
  double speed = 0.0, low = 1e300, high = 0.0;
  for (const Experiment& one : input.experiments) {
    speed = one.condition.spindle_speed;
    low = std::min(low, one.immersion.axial_depth);
    high = std::max(high, one.immersion.axial_depth);
  }
  return fmt::format("{}{} cuts {:.3g} ... {:.3g} mm deep, {:.4g} rpm, {:.4g} mm cutter",
                     input.provenance.condition.empty() ? "" : input.provenance.condition + "; ",
                     input.experiments.size(), low / units::mm, high / units::mm,
                     speed / units::rpm, 2.0 * input.experiments.front().cutter.radius / units::mm);
}

Json run_out_json(const RunOutKnowledge& known) {
  static constexpr const char* kSources[] = {"unknown", "stated", "records"};
  return {{"source", kSources[static_cast<int>(known.source)]},
          {"offset_um", known.offset / units::um},
          {"standard_error_um", known.standard_error / units::um},
          {"one_clamping", known.one_clamping},
          {"bound_um", known.bound / units::um}};
}

/// What an entry says of the cuts, whatever the method.
LawEntry entry_of_cuts(const IdentifyCase& input) {
  LawEntry entry;
  double slow = 1e300, fast = 0.0;
  bool one_rake = true;
  const double rake = input.experiments.front().cutter.rake_angle;
  for (const Experiment& one : input.experiments) {
    slow = std::min(slow, one.condition.spindle_speed * one.cutter.radius);
    fast = std::max(fast, one.condition.spindle_speed * one.cutter.radius);
    one_rake = one_rake && one.cutter.rake_angle == rake;
  }
  if (fast > 0.0) entry.speed_range_m_per_s = ends_of(slow, fast);
  if (one_rake) entry.rake_deg = {rake / units::deg};
  entry.provenance = input.provenance;
  entry.provenance.obtained = bone::Obtained::measured;
  entry.provenance.source =
      (input.provenance.source.empty() ? "" : input.provenance.source + ", ") + input.table;
  entry.provenance.condition = condition_of(input);
  return entry;
}

}  // namespace

Json identify_document(const IdentifyCase& input, const MeanForceIdentification& result) {
  const Candidate& chosen = result.best();
  const MeanForceFit& fit = *chosen.fit;
  Json document;
  document["model"] = chosen.name;
  document["coefficients"] = coefficients_json(fit);
  document["covariance"] = covariance_of(fit);
  document["residual_rms_n"] = xyz(fit.residual_rms);
  document["degrees_of_freedom"] = fit.degrees_of_freedom;
  document["condition_number"] = fit.condition_number;
  document["condition_number_unscaled"] = fit.condition_number_unscaled;
  document["leave_one_out_rms_n"] = chosen.leave_one->rms;
  document["leave_one_out"] = validation_json(*chosen.leave_one, input.experiments);
  if (chosen.leave_group) {
    document["leave_one_group_out"] = validation_json(*chosen.leave_group, input.experiments);
  }
  Json& candidates = document["candidates"] = Json::array();
  for (const Candidate& one : result.candidates) candidates.push_back(candidate_json(one));
  if (result.reference && result.reference->fit) {
    document["reference"] = candidate_json(*result.reference);
    document["reference"]["coefficients"] = coefficients_json(*result.reference->fit);
  }
  document["experiments"] = experiments_json(input.experiments, fit);
  Json suggested = Json::array();
  for (const SuggestedExperiment& one : result.suggested) {
    suggested.push_back(
        {{"cut", describe_cut(one.experiment)},
         {"axial_depth_mm", one.experiment.immersion.axial_depth / units::mm},
         {"feed_per_tooth_mm", one.experiment.condition.feed_per_tooth / units::mm}});
  }
  document["suggested_experiments"] = suggested;
  document["axes"] = {{"misfit_as_given", result.axes.misfit_as_given},
                      {"misfit_best", result.axes.misfit_best},
                      {"suspicious", result.axes.suspicious}};
  if (result.axes.suspicious) document["axes"]["suggested"] = names_of(result.axes.best.front());
  document["run_out"] = run_out_json(result.run_out);
  document["verdict"] = result.verdict;
  document["warnings"] = result.warnings;
  return document;
}

Json records_json(const std::vector<LoadedExperiment>& loaded) {
  Json list = Json::array();
  for (const LoadedExperiment& one : loaded) {
    if (!one.processed) continue;
    const ProcessedRecord& done = *one.processed;
    const double rate = done.record.rate;
    const double speed =
        done.rotation ? done.rotation->spindle_speed : one.experiment.condition.spindle_speed;
    const bool lines = done.rotation && one.experiment.cutter.flutes > 1;
    list.push_back({{"name", one.experiment.name},
                    {"file", one.record_file.filename().string()},
                    {"rate_hz", rate},
                    {"plateau_s",
                     {static_cast<double>(done.segments.plateau.begin) / rate,
                      static_cast<double>(done.segments.plateau.end) / rate}},
                    {"spindle_speed_rpm", speed / units::rpm},
                    {"run_out_ratio", lines ? Json(done.run_out_ratio) : Json()},
                    {"mean_force_n", xyz(one.experiment.mean_force)},
                    {"standard_error_n", xyz(one.experiment.standard_error)},
                    {"steps", one.notes},
                    {"warnings", one.warnings}});
  }
  return list;
}

std::string catalogue_entry_of(const IdentifyCase& input, const MeanForceIdentification& result) {
  const Candidate& chosen = result.best();
  const MeanForceFit& fit = *chosen.fit;
  const cutting::ChipRange chips = chip_range(input.experiments);
  const auto loose = std::count_if(fit.coefficients.begin(), fit.coefficients.end(),
                                   [](const Coefficient& one) { return !one.determined; });
  LawEntry entry = entry_of_cuts(input);
  entry.heading = fmt::format("{} law, identified from mean forces by osteomill.", chosen.name);
  entry.law = law_of(fit.model, fit.values, {}, common_inclination(input.experiments));
  entry.range_um = ends_of(chips.low / units::um, chips.high / units::um);
  entry.provenance.uncertainty = fmt::format(
      "residual rms {:.3g}/{:.3g}/{:.3g} N (x/y/z), leave-one-out {:.3g} N; {} of "
      "{} coefficients have a standard error above half their value",
      fit.residual_rms.x(), fit.residual_rms.y(), fit.residual_rms.z(), chosen.leave_one->rms,
      loose, fit.coefficients.size());
  entry.model = chosen.name;
  entry.method = "mean forces";
  for (const Coefficient& one : fit.coefficients) {
    entry.coefficients.push_back({one.name, unit_of(one.dimension), factor_of(one.dimension),
                                  one.value, one.standard_error});
  }
  entry.covariance = fit.covariance;
  entry.degrees_of_freedom = fit.degrees_of_freedom;
  entry.condition_number = fit.condition_number;
  entry.further = {{"kappa_max_rad", largest_kappa(input.experiments)},
                   {"leave_one_out_rms_n", chosen.leave_one->rms}};
  return law_entry_text(entry);
}

std::string catalogue_entry_of(const IdentifyCase& input, const CombinedRecords& records) {
  double largest = 0.0;
  for (const Experiment& one : input.experiments) {
    largest = std::max(largest, cutting::largest_chip(one.cutter, one.condition, one.immersion));
  }
  const auto count = static_cast<Eigen::Index>(records.coefficients.size());
  Eigen::VectorXd values(count);
  LawEntry entry = entry_of_cuts(input);
  for (Eigen::Index i = 0; i < count; ++i) {
    const Estimate& one = records.coefficients[static_cast<std::size_t>(i)];
    const ShownEstimate shown = unit_of(one);
    values(i) = one.value;
    entry.coefficients.push_back(
        {one.name, shown.unit, shown.factor, one.value, one.standard_error});
  }
  entry.heading =
      fmt::format("Identified from {} record{} by the instantaneous method of osteomill.",
                  records.records, records.records == 1 ? "" : "s");
  entry.law = law_of(records.units, values, common_inclination(input.experiments));
  // Every chip from none to the largest passes in each turn.
  entry.range_um = {0.0, largest / units::um};
  entry.provenance.uncertainty =
      records.records > 1
          ? fmt::format("the cuts differ {:.3g} times as much as their errors explain",
                        records.birge_ratio)
          : std::string("one record: nothing is known of how cuts differ");
  entry.model = std::string(cutting::name_of(entry.law.tangential.at_0));
  entry.method = "instantaneous";
  entry.covariance = records.covariance;
  entry.degrees_of_freedom = records.degrees_of_freedom;
  entry.condition_number = records.condition_number;
  entry.further = {{"records", static_cast<double>(records.records)},
                   {"birge_ratio", records.birge_ratio}};
  return law_entry_text(entry);
}

}  // namespace osteomill::io
