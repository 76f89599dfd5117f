// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/cutting/edge_force.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"

namespace osteomill::cutting {
namespace {

constexpr double kLn10 = std::numbers::ln10;

double polynomial(const std::vector<double>& coefficients, double x) {
  double value = 0.0;
  for (auto c = coefficients.rbegin(); c != coefficients.rend(); ++c) value = value * x + *c;
  return value;
}

double value(const LogLaw& law, const Chip& chip, const EdgePlace&) {
  double l = chip.log_h_um;
  if (has_floor(law) && chip.h < law.range.low)
    l = std::log10(law.range.low / units::um);
  else if (!(chip.h > 0.0))
    return 0.0;
  return units::n_per_mm * std::exp(kLn10 * ((law.k3 * l + law.k2) * l + law.k1));
}

double value(const PowerLaw& law, const Chip& chip, const EdgePlace&) {
  if (!(chip.h > 0.0)) return law.edge;
  // log10 of h in mm is that in µm less 3.
  return law.at_1_mm * std::exp(kLn10 * law.exponent * (chip.log_h_um - 3.0)) + law.edge;
}

double value(const LinearLaw& law, const Chip& chip, const EdgePlace&) {
  return law.pressure * chip.h + law.edge;
}

double value(const PolynomialLaw& law, const Chip& chip, const EdgePlace& place) {
  return polynomial(law.pressure, place.kappa) * chip.h +
         polynomial(law.edge, place.kappa) * place.stretch;
}

[[noreturn]] void refuse(std::string_view field, const char* parameter, const std::string& held,
                         const char* rule, const char* remedy) {
  throw InvalidInput(Fault{std::string(field) + "." + parameter, held, rule, remedy});
}

void require_number(std::string_view field, const char* parameter, double number) {
  if (!std::isfinite(number))
    refuse(field, parameter, std::to_string(number), "must be a finite number", "");
}

void check_law(const LogLaw& law, std::string_view field) {
  require_number(field, "k1", law.k1);
  require_number(field, "k2", law.k2);
  require_number(field, "k3", law.k3);
  if (has_floor(law) && law.range.low <= 0.0) {
    refuse(field, "k3", std::to_string(law.k3),
           "must be < 0 when the law states no least chip thickness",
           "the force would grow without limit as the chip vanishes; state the law's range");
  }
}

void check_law(const PowerLaw& law, std::string_view field) {
  require_number(field, "k", law.at_1_mm);
  require_number(field, "n", law.exponent);
  require_number(field, "edge", law.edge);
  if (law.at_1_mm < 0.0)
    refuse(field, "k", std::to_string(law.at_1_mm * units::mm) + " N/mm", "must be >= 0", "");
  if (!(law.exponent > 0.0 && law.exponent <= 2.0)) {
    refuse(field, "n", std::to_string(law.exponent), "must lie in 0 ... 2", "");
  }
}

void check_law(const LinearLaw& law, std::string_view field) {
  require_number(field, "k", law.pressure);
  require_number(field, "edge", law.edge);
}

void check_law(const PolynomialLaw& law, std::string_view field) {
  if (law.pressure.empty() && law.edge.empty()) {
    refuse(field, "shear", "", "must hold at least one coefficient", "");
  }
  for (const double c : law.pressure) require_number(field, "shear", c);
  for (const double e : law.edge) require_number(field, "edge", e);
}

}  // namespace

PowerLaw kienzle(double pressure_at_1_mm, double m, ChipRange range) {
  return {pressure_at_1_mm * units::mm, 1.0 - m, 0.0, range};
}

Chip::Chip(double thickness)
    : h(thickness), log_h_um(thickness > 0.0 ? std::log(thickness / units::um) / kLn10 : -300.0) {}

double force_per_width(const EdgeForce& law, const Chip& chip, const EdgePlace& place) {
  return std::visit([&](const auto& one) { return value(one, chip, place); }, law);
}

double specific_energy(const EdgeForce& law, double h, const EdgePlace& place) {
  return force_per_width(
             law, require_positive("chip_thickness_um", h / units::um, "um") * units::um, place) /
         h;
}

const ChipRange& range_of(const EdgeForce& law) {
  return std::visit([](const auto& one) -> const ChipRange& { return one.range; }, law);
}

std::string_view name_of(const EdgeForce& law) {
  constexpr std::string_view names[] = {"log", "power", "linear", "polynomial"};
  return names[law.index()];
}

void check(const EdgeForce& law, std::string_view field) {
  std::visit([&](const auto& one) { check_law(one, field); }, law);
  const ChipRange& range = range_of(law);
  if (!(range.low >= 0.0 && range.high > range.low)) {
    refuse(field, "range_um",
           std::to_string(range.low / units::um) + " ... " + std::to_string(range.high / units::um),
           "must be two chip thicknesses, the smaller first, none negative", "");
  }
}

}  // namespace osteomill::cutting
