// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/identify/law_units.hpp"

#include <algorithm>
#include <optional>

#include "osteomill/base/error.hpp"

namespace osteomill::identify {

std::string UnitForce::name(bool numbered) const {
  static constexpr const char* kLetters = "tra";
  std::string text = "K";
  text += kLetters[static_cast<int>(component)];
  text += kind == Kind::shear ? 'c' : 'e';
  if (numbered) text += std::to_string(power);
  return text;
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

bool numbered(const std::vector<UnitForce>& units) {
  return std::any_of(units.begin(), units.end(), [](const UnitForce& unit) {
    return unit.power > 0 || unit.kind == UnitForce::Kind::edge_along_length;
  });
}

cutting::CuttingLaw law_of(const std::vector<UnitForce>& units, const Eigen::VectorXd& values) {
  if (static_cast<Eigen::Index>(units.size()) != values.size()) {
    throw InvalidInput(
        Fault{"coefficients", std::to_string(values.size()), "must be as many as the units", ""});
  }
  const auto component = [&](ForceComponent wanted,
                             double sign) -> std::optional<cutting::DirectionalLaw> {
    cutting::LinearLaw linear;
    cutting::PolynomialLaw polynomial;
    bool any = false;
    for (std::size_t i = 0; i < units.size(); ++i) {
      if (units[i].component != wanted) continue;
      any = true;
      const double value = sign * values[static_cast<Eigen::Index>(i)];
      const bool shear = units[i].kind == UnitForce::Kind::shear;
      (shear ? linear.pressure : linear.edge) += value;
      std::vector<double>& powers = shear ? polynomial.pressure : polynomial.edge;
      const auto power = static_cast<std::size_t>(units[i].power);
      powers.resize(std::max(powers.size(), power + 1), 0.0);
      powers[power] += value;
    }
    if (!any) return std::nullopt;
    if (numbered(units)) return cutting::DirectionalLaw{polynomial, std::nullopt};
    return cutting::DirectionalLaw{linear, std::nullopt};
  };
  const cutting::DirectionalLaw none{cutting::LinearLaw{}, std::nullopt};
  return {.tangential = component(ForceComponent::tangential, 1.0).value_or(none),
          .radial = component(ForceComponent::radial, 1.0).value_or(none),
          .lateral = component(ForceComponent::axial, -1.0),
          .orientation = cutting::OrientationCriterion::none};
}

}  // namespace osteomill::identify
