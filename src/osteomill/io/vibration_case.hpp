// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "osteomill/io/cutting_section.hpp"
#include "osteomill/io/measured_dynamics.hpp"
#include "osteomill/vibration/beam.hpp"
#include "osteomill/vibration/beam_elements.hpp"
#include "osteomill/vibration/modal.hpp"
#include "osteomill/vibration/regeneration.hpp"
#include "osteomill/vibration/stability.hpp"

/// The cases of `osteomill modes`, `stability` and `respond`.
namespace osteomill::io {

struct CaseRun;
class Section;

/// [beam]
void bind_beam(Section& section, vibration::Beam& beam);

/// `osteomill modes`: a beam and how to solve it, or an impact test.
struct ModesCase {
  std::optional<ImpactCase> impact;
  vibration::Beam beam;
  bool exact = true;
  vibration::ElementOptions elements;
  int modes = 3;
  double spindle_speed = 0.0;  ///< rad/s; > 0: whirl frequencies too
  nlohmann::ordered_json expanded;
};
void bind_modes(Section& section);
ModesCase read_modes_case(const CaseRun& run);

/// [structure]: modes given one by one, those of a [beam] or of the [cutter] with its shank alike
/// in both directions, or what was measured at the tip.
struct StructureCase {
  std::vector<vibration::Mode> modes;
  std::vector<MeasuredTable> measured;
  vibration::Receptance receptance;  ///< of modes or measurements
  std::vector<std::string> caveats;  ///< what of it is assumed
};
void bind_structure(Section& section, StructureCase& structure,
                    const cutting::Cutter* cutter = nullptr);
/// After the whole case has been read: reads what was measured, and makes the receptance.
void complete(StructureCase& structure);

/// `osteomill stability`: the structure and either constant coefficients or a cutter in a bone.
struct StabilityCase {
  StructureCase structure;
  std::optional<vibration::Regeneration> cut;
  vibration::StabilityOptions options;
  std::vector<double> speeds;  ///< rad/s
  bool continuation = false;
  int map_depths = 0;           ///< of the margin map; 0: none
  int judge = 0;                ///< speeds at which a simulation in time judges the limit
  std::optional<double> depth;  ///< m, of the cut in a bone
  std::optional<double> speed;  ///< rad/s, of the cut in a bone
  std::vector<std::string> caveats;
  nlohmann::ordered_json expanded;
};
void bind_stability(Section& section);
StabilityCase read_stability_case(const CaseRun& run);

/// `osteomill respond`: forced vibration of a structure in a cut over speeds and feed rates.
struct RespondCase {
  StructureCase structure;
  cutting::Cutter cutter;
  BoneCase bone;
  cutting::Condition condition;
  cutting::Immersion immersion;
  std::vector<double> speeds;      ///< rad/s
  std::vector<double> feed_rates;  ///< m/s
  int harmonics = 3;
  double calm_amplification = 1.5;
  std::vector<std::string> caveats;
  nlohmann::ordered_json expanded;
};
void bind_respond(Section& section);
RespondCase read_respond_case(const CaseRun& run);

}  // namespace osteomill::io
