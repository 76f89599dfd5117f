// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/identify/law_units.hpp"

#include <algorithm>
#include <optional>

#include "osteomill/base/error.hpp"

namespace osteomill::identify {

const char* name_of(ForceComponent component) {
  static constexpr const char* kNames[] = {"tangential", "radial", "axial", "lateral"};
  return kNames[static_cast<int>(component)];
}

std::string UnitForce::name(bool numbered) const {
  const char letter = "tral"[static_cast<int>(component)];
  switch (kind) {
    case Kind::power:
      return std::string("K") + letter;
    case Kind::log:
      return std::string("K") + letter + '1';
    case Kind::edge_of_power:
      return std::string("F") + letter + 'e';
    case Kind::shear:
    case Kind::edge:
    case Kind::edge_along_length:
      break;
  }
  std::string text = std::string("K") + letter + (kind == Kind::shear ? 'c' : 'e');
  if (numbered) text += std::to_string(power);
  return text;
}

std::vector<std::string> UnitForce::exponent_names() const {
  const std::string letter(1, "tral"[static_cast<int>(component)]);
  if (kind == Kind::power) return {"n" + letter};
  if (kind == Kind::log) return {"K" + letter + "2", "K" + letter + "3"};
  return {};
}

int exponents_of(const std::vector<UnitForce>& units) {
  int count = 0;
  for (const UnitForce& unit : units) count += unit.exponents();
  return count;
}

std::vector<UnitForce> linear_law_units(bool axial) {
  std::vector<UnitForce> units;
  for (const UnitForce::Kind kind : {UnitForce::Kind::shear, UnitForce::Kind::edge}) {
    units.push_back({ForceComponent::tangential, kind, 0});
    units.push_back({ForceComponent::radial, kind, 0});
    if (axial) units.push_back({ForceComponent::axial, kind, 0});
  }
  return units;
}

std::vector<UnitForce> polynomial_law_units(int shear_order, int edge_order) {
  std::vector<UnitForce> units;
  const auto add = [&](UnitForce::Kind kind, int order) {
    for (const ForceComponent component :
         {ForceComponent::tangential, ForceComponent::radial, ForceComponent::axial}) {
      for (int power = 0; power <= order; ++power) units.push_back({component, kind, power});
    }
  };
  add(UnitForce::Kind::shear, shear_order);
  add(UnitForce::Kind::edge_along_length, edge_order);
  return units;
}

std::vector<UnitForce> power_law_units(bool edge_force) {
  std::vector<UnitForce> units;
  for (const ForceComponent component :
       {ForceComponent::tangential, ForceComponent::radial, ForceComponent::lateral}) {
    units.push_back({component, UnitForce::Kind::power, 0});
    if (edge_force) units.push_back({component, UnitForce::Kind::edge_of_power, 0});
  }
  return units;
}

std::vector<UnitForce> log_law_units() {
  std::vector<UnitForce> units;
  for (const ForceComponent component :
       {ForceComponent::tangential, ForceComponent::radial, ForceComponent::lateral}) {
    units.push_back({component, UnitForce::Kind::log, 0});
  }
  return units;
}

bool numbered(const std::vector<UnitForce>& units) {
  return std::any_of(units.begin(), units.end(), [](const UnitForce& unit) {
    return unit.power > 0 || unit.kind == UnitForce::Kind::edge_along_length;
  });
}

cutting::CuttingLaw law_of(const std::vector<UnitForce>& units, const Eigen::VectorXd& values,
                           double inclination) {
  const auto count = static_cast<Eigen::Index>(units.size());
  if (count + exponents_of(units) != values.size()) {
    throw InvalidInput(Fault{"coefficients", std::to_string(values.size()),
                             "must be as many as the units and their exponents", ""});
  }
  const auto component = [&](ForceComponent wanted,
                             double sign) -> std::optional<cutting::DirectionalLaw> {
    cutting::LinearLaw linear;
    cutting::PolynomialLaw polynomial;
    cutting::PowerLaw power;
    std::optional<cutting::LogLaw> log;
    bool any = false;
    bool is_power = false;
    Eigen::Index exponent = count;
    for (std::size_t i = 0; i < units.size(); ++i) {
      const UnitForce& unit = units[i];
      const Eigen::Index first = exponent;
      exponent += unit.exponents();
      if (unit.component != wanted) continue;
      any = true;
      const double value = sign * values[static_cast<Eigen::Index>(i)];
      if (unit.kind == UnitForce::Kind::log) {
        log = cutting::LogLaw{value, values[first], values[first + 1]};
        continue;
      }
      if (unit.kind == UnitForce::Kind::power) {
        is_power = true;
        power.at_1_mm = value;
        power.exponent = values[first];
        continue;
      }
      if (unit.kind == UnitForce::Kind::edge_of_power) {
        power.edge = value;
        continue;
      }
      const bool shear = unit.kind == UnitForce::Kind::shear;
      (shear ? linear.pressure : linear.edge) += value;
      std::vector<double>& powers = shear ? polynomial.pressure : polynomial.edge;
      const auto of_kappa = static_cast<std::size_t>(unit.power);
      powers.resize(std::max(powers.size(), of_kappa + 1), 0.0);
      powers[of_kappa] += value;
    }
    if (!any) return std::nullopt;
    if (log) return cutting::DirectionalLaw{*log, std::nullopt};
    if (is_power) return cutting::DirectionalLaw{power, std::nullopt};
    if (numbered(units)) return cutting::DirectionalLaw{polynomial, std::nullopt};
    return cutting::DirectionalLaw{linear, std::nullopt};
  };
  const cutting::DirectionalLaw none{cutting::LinearLaw{}, std::nullopt};
  std::optional<cutting::DirectionalLaw> lateral = component(ForceComponent::lateral, 1.0);
  if (!lateral) lateral = component(ForceComponent::axial, -1.0);
  cutting::CuttingLaw law{.tangential = component(ForceComponent::tangential, 1.0).value_or(none),
                          .radial = component(ForceComponent::radial, 1.0).value_or(none),
                          .lateral = lateral,
                          .orientation = cutting::OrientationCriterion::none};
  law.lateral_inclination = inclination;
  return law;
}

}  // namespace osteomill::identify
