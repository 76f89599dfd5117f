// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/cutting/cutting_law.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"

namespace osteomill::cutting {
namespace {

double component(const CuttingLaw& law, const DirectionalLaw& one, const Chip& chip, double cosine,
                 const EdgePlace& place) {
  const double along = force_per_width(one.at_0, chip, place);
  if (!one.at_90 || law.orientation == OrientationCriterion::none) return along;
  return hankinson(along, force_per_width(*one.at_90, chip, place), cosine,
                   law.orientation_exponent);
}

template <class Visitor>
void for_each_law(const CuttingLaw& law, Visitor visit) {
  const auto both = [&](const DirectionalLaw& one, const std::string& name) {
    visit(one.at_0, name + (one.at_90 ? ".at_0_deg" : ".any_deg"));
    if (one.at_90) visit(*one.at_90, name + ".at_90_deg");
  };
  both(law.tangential, "bone.tangential");
  both(law.radial, "bone.radial");
  if (law.lateral) both(*law.lateral, "bone.lateral");
}

}  // namespace

double hankinson(double along, double across, double cosine, double exponent) {
  double cos_n = cosine * cosine;
  double sin_n = std::max(0.0, 1.0 - cos_n);
  if (exponent != 2.0) {
    cos_n = std::pow(cos_n, 0.5 * exponent);
    sin_n = std::pow(sin_n, 0.5 * exponent);
  }
  const double mix = along * sin_n + across * cos_n;
  return mix > 0.0 ? along * across / mix : 0.0;
}

EdgeComponents components(const CuttingLaw& law, const Chip& chip, double cosine,
                          const EdgePlace& place, double inclination) {
  if (chip.h < law.minimum_chip) {
    CuttingLaw lifted = law;
    lifted.minimum_chip = 0.0;
    const EdgeComponents whole =
        components(lifted, Chip(law.minimum_chip), cosine, place, inclination);
    const double share = chip.h / law.minimum_chip;
    return {whole.tangential * share, whole.radial * share, whole.lateral * share};
  }
  EdgeComponents force;
  force.tangential = component(law, law.tangential, chip, cosine, place);
  force.radial = component(law, law.radial, chip, cosine, place);
  if (law.lateral) {
    const double scale =
        law.lateral_inclination == 0.0 ? 1.0 : inclination / law.lateral_inclination;
    force.lateral = scale * component(law, *law.lateral, chip, cosine, place);
  }
  return force;
}

namespace {

/// An edge never drives itself through the bone. A polynomial in kappa may, at some kappa, as one
/// that was fitted to few places does.
void check_resists(const EdgeForce& tangential, std::string_view field) {
  if (std::holds_alternative<PolynomialLaw>(tangential)) return;
  const double thickest = std::min(range_of(tangential).high, 100.0 * units::um);
  const double force = force_per_width(tangential, thickest);
  if (force >= 0.0) return;
  throw InvalidInput(
      Fault{std::string(field),
            fmt::format("{:g} N/mm at {:g} um", force * units::mm, thickest / units::um),
            "must not drive the edge on: the tangential force is against its motion",
            "check the signs of its constants"});
}

}  // namespace

void check(const CuttingLaw& law) {
  for_each_law(law, [](const EdgeForce& one, const std::string& name) { check(one, name); });
  check_resists(law.tangential.at_0, "bone.tangential");
  if (law.tangential.at_90) check_resists(*law.tangential.at_90, "bone.tangential");
  require_within("bone.orientation_exponent", law.orientation_exponent, 0.5, 6.0, "");
  require_within("bone.minimum_chip_um", law.minimum_chip / units::um, 0.0, 100.0, "um");
  require_within("bone.lateral.inclination_deg", law.lateral_inclination / units::deg, -75.0, 75.0,
                 "deg");
}

namespace {

EdgeForce edge_part_of(const EdgeForce& law) {
  if (const auto* power = std::get_if<PowerLaw>(&law)) return LinearLaw{0.0, power->edge};
  if (const auto* linear = std::get_if<LinearLaw>(&law)) return LinearLaw{0.0, linear->edge};
  if (const auto* polynomial = std::get_if<PolynomialLaw>(&law)) {
    return PolynomialLaw{{}, polynomial->edge};
  }
  return LinearLaw{};
}

}  // namespace

CuttingLaw edge_part(const CuttingLaw& law) {
  CuttingLaw edge = law;
  const auto both = [](DirectionalLaw& one) {
    one.at_0 = edge_part_of(one.at_0);
    if (one.at_90) one.at_90 = edge_part_of(*one.at_90);
  };
  both(edge.tangential);
  both(edge.radial);
  if (edge.lateral) both(*edge.lateral);
  return edge;
}

bool has_edge_force(const CuttingLaw& law) {
  bool any = false;
  for_each_law(law, [&](const EdgeForce& one, const std::string&) {
    const EdgeForce edge = edge_part_of(one);
    const auto* linear = std::get_if<LinearLaw>(&edge);
    any = any || linear == nullptr || linear->edge != 0.0;
  });
  return any;
}

ChipRange range_of(const CuttingLaw& law) {
  ChipRange all;
  for_each_law(law, [&](const EdgeForce& one, const std::string&) {
    all.low = std::max(all.low, range_of(one).low);
    all.high = std::min(all.high, range_of(one).high);
  });
  return all;
}

}  // namespace osteomill::cutting
