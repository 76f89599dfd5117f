// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/identify_result.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "osteomill/base/units.hpp"

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

std::string quoted(const std::string& text) { return Json(text).dump(); }

/// A TOML number: shortest text that reads back as the same double; whole ones with a point.
std::string exact(double value) {
  const std::string text = fmt::format("{}", value);
  return text.find_first_of(".en") == std::string::npos ? text + ".0" : text;
}

std::string exact_list(const std::vector<double>& values) {
  std::vector<std::string> texts;
  for (const double value : values) texts.push_back(exact(value));
  return fmt::format("[{}]", fmt::join(texts, ", "));
}

std::string polynomial_toml(const MeanForceFit& fit) {
  std::string text;
  const auto part = [&](const char* table, int order, Eigen::Index first, double factor) {
    if (order < 0) return;
    constexpr std::array<const char*, 3> kNames = {"tangential", "radial", "axial"};
    for (Eigen::Index c = 0; c < 3; ++c) {
      std::vector<double> values;
      for (int k = 0; k <= order; ++k) values.push_back(fit.values(first + 3 * k + c) / factor);
      text += fmt::format("{}.{} = {}\n", table, kNames[static_cast<std::size_t>(c)],
                          exact_list(values));
    }
  };
  part("shear", fit.model.shear_order, 0, units::n_per_mm2);
  // The catalogue asks for pressures; without them they are nought.
  if (fit.model.shear_order < 0) text += "shear.tangential = [0.0]\nshear.radial = [0.0]\n";
  part("edge", fit.model.edge_order, 3 * (fit.model.shear_order + 1), units::n_per_mm);
  return text;
}

std::string keys_of(const cutting::EdgeForce& law) {
  if (const auto* log = std::get_if<cutting::LogLaw>(&law)) {
    return fmt::format("{{ k1 = {}, k2 = {}, k3 = {} }}", exact(log->k1), exact(log->k2),
                       exact(log->k3));
  }
  if (const auto* power = std::get_if<cutting::PowerLaw>(&law)) {
    return fmt::format("{{ k = {}, n = {}, edge = {} }}", exact(power->at_1_mm / units::n_per_mm),
                       exact(power->exponent), exact(power->edge / units::n_per_mm));
  }
  const auto& linear = std::get<cutting::LinearLaw>(law);
  return fmt::format("{{ k = {}, edge = {} }}", exact(linear.pressure / units::n_per_mm2),
                     exact(linear.edge / units::n_per_mm));
}

std::string component_toml(const char* name, const cutting::DirectionalLaw& law,
                           double inclination) {
  std::string text = fmt::format("\n[{}]\n", name);
  if (law.at_90) {
    text += fmt::format("at_0_deg = {}\nat_90_deg = {}\n", keys_of(law.at_0), keys_of(*law.at_90));
  } else {
    text += fmt::format("any_deg = {}\n", keys_of(law.at_0));
  }
  if (inclination != 0.0)
    text += fmt::format("inclination_deg = {}\n", exact(inclination / units::deg));
  return text;
}

/// Two ends of a range a little apart when all experiments have the same value.
std::vector<double> ends(double low, double high) {
  if (high > low * (1.0 + 1e-6)) return {low, high};
  return {low * (1.0 - 1e-3), high * (1.0 + 1e-3)};
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
  document["verdict"] = result.verdict;
  document["warnings"] = result.warnings;
  return document;
}

std::string catalogue_entry_of(const IdentifyCase& input, const MeanForceIdentification& result) {
  const Candidate& chosen = result.best();
  const MeanForceFit& fit = *chosen.fit;
  const double inclination = common_inclination(input.experiments);
  const cutting::CuttingLaw law = law_of(fit.model, fit.values, {}, inclination);
  const bool polynomial = std::holds_alternative<cutting::PolynomialLaw>(law.tangential.at_0);
  const cutting::ChipRange chips = chip_range(input.experiments);
  double slow = 1e300, fast = 0.0;
  bool one_rake = true;
  const double rake = input.experiments.front().cutter.rake_angle;
  for (const Experiment& one : input.experiments) {
    slow = std::min(slow, one.condition.spindle_speed * one.cutter.radius);
    fast = std::max(fast, one.condition.spindle_speed * one.cutter.radius);
    one_rake = one_rake && one.cutter.rake_angle == rake;
  }
  std::string text =
      fmt::format("# {} law, identified from mean forces by osteomill.\n", chosen.name);
  text += fmt::format("law = \"{}\"\n", cutting::name_of(law.tangential.at_0));
  text += fmt::format("orientation = \"{}\"\n", fit.model.directional ? "hankinson" : "none");
  text += fmt::format("range_um = {}\n",
                      exact_list(ends(chips.low / units::um, chips.high / units::um)));
  if (fast > 0.0) text += fmt::format("speed_range_m_per_s = {}\n", exact_list(ends(slow, fast)));
  if (one_rake) text += fmt::format("rake_deg = {}\n", exact(rake / units::deg));
  if (polynomial) {
    text += polynomial_toml(fit);
  } else {
    text += component_toml("tangential", law.tangential, 0.0);
    text += component_toml("radial", law.radial, 0.0);
    text += component_toml("lateral", *law.lateral, inclination);
  }
  const auto loose = std::count_if(fit.coefficients.begin(), fit.coefficients.end(),
                                   [](const Coefficient& one) { return !one.determined; });
  text += "\n[provenance]\nobtained = \"measured\"\n";
  text +=
      fmt::format("source = {}\n",
                  quoted((input.provenance.source.empty() ? "" : input.provenance.source + ", ") +
                         input.table));
  text += fmt::format("specimen = {}\n", quoted(input.provenance.specimen));
  text += fmt::format("condition = {}\n", quoted(condition_of(input)));
  text +=
      fmt::format("uncertainty = {}\n",
                  quoted(fmt::format(
                      "residual rms {:.3g}/{:.3g}/{:.3g} N (x/y/z), leave-one-out {:.3g} N; {} of "
                      "{} coefficients have a standard error above half their value",
                      fit.residual_rms.x(), fit.residual_rms.y(), fit.residual_rms.z(),
                      chosen.leave_one->rms, loose, fit.coefficients.size())));
  text += fmt::format("note = {}\n", quoted(input.provenance.note));
  text += "\n[identification]\n";
  std::vector<std::string> names, names_with_unit;
  std::vector<double> values, errors;
  for (const Coefficient& one : fit.coefficients) {
    names.push_back(quoted(one.name));
    names_with_unit.push_back(quoted(unit_of(one.dimension)));
    values.push_back(one.value / factor_of(one.dimension));
    errors.push_back(one.standard_error / factor_of(one.dimension));
  }
  text += fmt::format("model = {}\nmethod = \"mean forces\"\n", quoted(chosen.name));
  text += fmt::format("coefficients = [{}]\nunits = [{}]\n", fmt::join(names, ", "),
                      fmt::join(names_with_unit, ", "));
  text +=
      fmt::format("values = {}\nstandard_errors = {}\n", exact_list(values), exact_list(errors));
  text += "covariance = [\n";
  for (const auto& row : covariance_of(fit)) text += fmt::format("  {},\n", exact_list(row));
  text += "]\n";
  text += fmt::format("degrees_of_freedom = {}\ncondition_number = {}\n",
                      exact(fit.degrees_of_freedom), exact(fit.condition_number));
  text += fmt::format("kappa_max_rad = {}\n", exact(largest_kappa(input.experiments)));
  text += fmt::format("leave_one_out_rms_n = {}\n", exact(chosen.leave_one->rms));
  return text;
}

}  // namespace osteomill::io
