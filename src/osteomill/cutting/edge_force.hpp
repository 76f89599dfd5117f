// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <limits>
#include <string_view>
#include <variant>
#include <vector>

namespace osteomill::cutting {

/// Chip thicknesses a law was measured on, m. Outside it the law is an extrapolation.
struct ChipRange {
  double low = 0.0;
  double high = std::numeric_limits<double>::infinity();
};

/// log10 F = K3 L² + K2 L + K1, L = log10 h, with h in µm and F in N/mm.
/// [plaskos2006] eq. 2.3; the unit of F is that of its figures. For K3 < 0 the force falls to 0
/// with the chip; for K3 >= 0 the law has no such limit, and below `range.low` its value there is
/// used.
struct LogLaw {
  double k1 = 0.0;
  double k2 = 0.0;
  double k3 = 0.0;
  ChipRange range = {};
};

/// Whether the law grows without limit as the chip vanishes, so that `range.low` must stop it.
inline bool has_floor(const LogLaw& law) { return law.k3 > 0.0 || (law.k3 == 0.0 && law.k2 < 0.0); }

/// F = K h^n + F_e, [plaskos2002] eq. 2, [plaskos2006] eq. 2.2. The sources have h in mm and F in
/// N/mm, so `at_1_mm` is their K_c in N/m: the force per width that a chip of 1 mm would take.
/// Kienzle's law is the same with n = 1 - m and no edge force: see kienzle().
struct PowerLaw {
  double at_1_mm = 0.0;  ///< N/m
  double exponent = 1.0;
  double edge = 0.0;  ///< F_e, N/m
  ChipRange range = {};
};

/// F = K_c h + K_e: pressure times chip plus edge force; Jacobs' law in [plaskos2002] eq. 1.
struct LinearLaw {
  double pressure = 0.0;  ///< K_c, Pa
  double edge = 0.0;      ///< K_e, N/m
  ChipRange range = {};
};

/// F = h sum c_i kappa^i + S sum e_i kappa^i, [tian2023] eqs. 8 and 11: pressure and edge force are
/// polynomials in the axial position angle; the edge force acts per length of edge, S times longer
/// than the width of cut (dS = S db, eq. 3).
struct PolynomialLaw {
  std::vector<double> pressure;  ///< c_i, Pa
  std::vector<double> edge;      ///< e_i, N/m
  ChipRange range = {};
};

/// Force per width of cut on an edge. A closed set of values: the loop over edge elements asks once
/// which law it has (docs/decisions/0003-edge-force-laws-are-values.md).
using EdgeForce = std::variant<LogLaw, PowerLaw, LinearLaw, PolynomialLaw>;

/// k_c = k_c11 (h / 1 mm)^-m, F = k_c h: as a power law. `pressure_at_1_mm` is k_c11, Pa.
PowerLaw kienzle(double pressure_at_1_mm, double m, ChipRange range = {});

/// Where on the cutter an edge element is, as far as a law asks.
struct EdgePlace {
  double kappa = 1.5707963267948966;  ///< axial position angle, rad
  double stretch = 1.0;               ///< edge length over width of cut
};

/// An uncut chip thickness with its logarithm, which all components of a law share.
struct Chip {
  double h;         ///< m, >= 0
  double log_h_um;  ///< log10 of h in µm; a large negative number for h = 0
  explicit Chip(double thickness);
};

/// Force per width of cut, N/m. Zero at h = 0 but for the edge force.
double force_per_width(const EdgeForce& law, const Chip& chip, const EdgePlace& place = {});
inline double force_per_width(const EdgeForce& law, double h, const EdgePlace& place = {}) {
  return force_per_width(law, Chip(h), place);
}

/// Specific cutting energy E_c = F/h, Pa; [plaskos2002] eq. 1. h > 0.
double specific_energy(const EdgeForce& law, double h, const EdgePlace& place = {});

const ChipRange& range_of(const EdgeForce& law);

/// "log", "power", "linear", "polynomial".
std::string_view name_of(const EdgeForce& law);

/// Throws InvalidInput that names `field` and the parameter when the values make no law.
void check(const EdgeForce& law, std::string_view field);

}  // namespace osteomill::cutting
