// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/law_entry.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <nlohmann/json.hpp>

#include "osteomill/base/units.hpp"

namespace osteomill::io {
namespace {

using Json = nlohmann::ordered_json;

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

std::vector<double> over(std::vector<double> values, double factor) {
  for (double& one : values) one /= factor;
  return values;
}

/// The catalogue has the third component of polynomials along the meridian away from the tip.
std::string polynomial_toml(const cutting::CuttingLaw& law) {
  std::string text;
  const std::array<std::pair<const char*, const cutting::DirectionalLaw*>, 3> components = {
      {{"tangential", &law.tangential}, {"radial", &law.radial}, {"axial", &*law.lateral}}};
  const auto part = [&](const char* table, std::vector<double> cutting::PolynomialLaw::* values,
                        double unit) {
    for (const auto& [name, component] : components) {
      const auto& one = std::get<cutting::PolynomialLaw>(component->at_0);
      if ((one.*values).empty()) continue;
      const double sign = component == &*law.lateral ? -1.0 : 1.0;
      text += fmt::format("{}.{} = {}\n", table, name, exact_list(over(one.*values, sign * unit)));
    }
  };
  part("shear", &cutting::PolynomialLaw::pressure, units::n_per_mm2);
  // The catalogue asks for pressures; without them they are nought.
  if (text.empty()) text += "shear.tangential = [0.0]\nshear.radial = [0.0]\n";
  part("edge", &cutting::PolynomialLaw::edge, units::n_per_mm);
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

}  // namespace

std::vector<double> ends_of(double low, double high) {
  if (high > low * (1.0 + 1e-6)) return {low, high};
  return {low * (1.0 - 1e-3), high * (1.0 + 1e-3)};
}

std::string law_entry_text(const LawEntry& entry) {
  const cutting::CuttingLaw& law = entry.law;
  std::string text = fmt::format("# {}\n", entry.heading);
  text += fmt::format("law = \"{}\"\n", cutting::name_of(law.tangential.at_0));
  text +=
      fmt::format("orientation = \"{}\"\n",
                  law.orientation == cutting::OrientationCriterion::none ? "none" : "hankinson");
  if (!entry.range_um.empty()) text += fmt::format("range_um = {}\n", exact_list(entry.range_um));
  if (!entry.speed_range_m_per_s.empty()) {
    text += fmt::format("speed_range_m_per_s = {}\n", exact_list(entry.speed_range_m_per_s));
  }
  if (!entry.rake_deg.empty()) text += fmt::format("rake_deg = {}\n", exact(entry.rake_deg[0]));
  if (std::holds_alternative<cutting::PolynomialLaw>(law.tangential.at_0)) {
    text += polynomial_toml(law);
  } else {
    text += component_toml("tangential", law.tangential, 0.0);
    text += component_toml("radial", law.radial, 0.0);
    if (law.lateral) text += component_toml("lateral", *law.lateral, law.lateral_inclination);
  }
  const bone::Provenance& from = entry.provenance;
  text += "\n[provenance]\nobtained = \"measured\"\n";
  text += fmt::format("source = {}\nspecimen = {}\ncondition = {}\n", quoted(from.source),
                      quoted(from.specimen), quoted(from.condition));
  text += fmt::format("uncertainty = {}\nnote = {}\n", quoted(from.uncertainty), quoted(from.note));
  text += "\n[identification]\n";
  std::vector<std::string> names, with_unit;
  std::vector<double> values, errors;
  for (const EntryCoefficient& one : entry.coefficients) {
    names.push_back(quoted(one.name));
    with_unit.push_back(quoted(one.unit));
    values.push_back(one.value / one.factor);
    errors.push_back(one.standard_error / one.factor);
  }
  text += fmt::format("model = {}\nmethod = {}\n", quoted(entry.model), quoted(entry.method));
  text += fmt::format("coefficients = [{}]\nunits = [{}]\n", fmt::join(names, ", "),
                      fmt::join(with_unit, ", "));
  text +=
      fmt::format("values = {}\nstandard_errors = {}\n", exact_list(values), exact_list(errors));
  text += "covariance = [\n";
  for (std::size_t i = 0; i < values.size(); ++i) {
    std::vector<double> row;
    for (std::size_t k = 0; k < values.size(); ++k) {
      row.push_back(entry.covariance(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k)) /
                    (entry.coefficients[i].factor * entry.coefficients[k].factor));
    }
    text += fmt::format("  {},\n", exact_list(row));
  }
  text += "]\n";
  text += fmt::format("degrees_of_freedom = {}\ncondition_number = {}\n",
                      exact(entry.degrees_of_freedom), exact(entry.condition_number));
  for (const auto& [name, value] : entry.further) {
    text += fmt::format("{} = {}\n", name, exact(value));
  }
  return text;
}

}  // namespace osteomill::io
