// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "osteomill/cutting/law_fit.hpp"
#include "osteomill/io/cutting_section.hpp"

namespace osteomill::io {

struct CaseRun;
class Section;

enum class FitForm { automatic, log, power };

/// The cuts of one force component in one direction to the fibres.
struct FitSeries {
  std::string component;                            ///< "tangential", "radial", "lateral"
  std::optional<int> direction;                     ///< 0 or 90 degrees to the fibres; unset: any
  std::vector<cutting::OrthogonalCut> cuts;         ///< to fit
  std::vector<cutting::SpeedEffect> speed_effects;  ///< slowest speed of the table against fastest
};

/// `osteomill fit`: orthogonal cuts to a law of edge forces.
struct FitCase {
  std::vector<FitSeries> series;
  FitForm form = FitForm::automatic;
  std::vector<double> speeds;         ///< of the table, m/s, slowest first
  std::vector<double> fitted_speeds;  ///< of the cuts that are fitted
  std::optional<double> rake_angle;   ///< rad
  double inclination = 0.0;           ///< of the edge, rad
  bone::Provenance provenance;
  nlohmann::ordered_json expanded;
};

void bind_fit(Section& section);

/// Throws InvalidInput with all faults of the case, and of the table of cuts.
FitCase read_fit_case(const CaseRun& run);

/// A series with both of its laws.
struct FittedSeries {
  FitSeries series;
  cutting::PowerFit power;
  cutting::LogFit log;
};

/// An entry of the catalogue of bones with the log laws or the power laws, as TOML.
std::string bone_entry(const FitCase& fit, const std::vector<FittedSeries>& fitted, bool log_laws);

}  // namespace osteomill::io
