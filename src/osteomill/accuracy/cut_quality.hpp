// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "osteomill/accuracy/heat_relation.hpp"
#include "osteomill/accuracy/tool_deflection.hpp"
#include "osteomill/vibration/modal.hpp"

namespace osteomill::accuracy {

/// A cutter to choose from, with what sticks out of its holder.
struct Candidate {
  std::string name;
  cutting::Cutter cutter;
  double tool_length = 0.0;                ///< from the tip to the holder or bearing, m
  double effective_diameter_factor = 1.0;  ///< effective over outer diameter, for bending
  double youngs_modulus = 197e9;           ///< Pa
  double density = 7850.0;                 ///< kg/m³
};

/// What may be chosen, each within [low, high]; equal ends fix it. SI.
enum class Variable { feed_per_tooth, spindle_speed, axial_depth, radial_depth };
inline constexpr int kVariables = 4;
/// "feed_per_tooth", "spindle_speed", "axial_depth", "radial_depth".
const std::array<const char*, kVariables>& variable_names();
struct Span {
  double low = 0.0, high = 0.0;
};
using Point = std::array<double, kVariables>;

/// What a condition gives. Only what a limit or the objective asks for is worked out; the rest
/// stays NaN.
struct CutQuality {
  double time = std::numeric_limits<double>::quiet_NaN();            ///< s, of the whole job
  double peak_force = std::numeric_limits<double>::quiet_NaN();      ///< N
  double deflection = std::numeric_limits<double>::quiet_NaN();      ///< total at the tip, m
  double surface_error = std::numeric_limits<double>::quiet_NaN();   ///< largest magnitude, m
  double temperature = std::numeric_limits<double>::quiet_NaN();     ///< °C, quick form
  double power = std::numeric_limits<double>::quiet_NaN();           ///< of the spindle, W
  double energy = std::numeric_limits<double>::quiet_NaN();          ///< specific, J/m³
  double chatter = std::numeric_limits<double>::quiet_NaN();         ///< spectral radius
  double feed_per_tooth = std::numeric_limits<double>::quiet_NaN();  ///< roughness, m
};

enum class Goal { time, force, heat, error };

/// Upper limits; unset: none.
struct Limits {
  std::optional<double> time, peak_force, deflection, surface_error, temperature, power, chatter;
  double feed_per_tooth = 0.3e-3;  ///< for the roughness: [sugita2009]
};

struct ChoiceProblem {
  cutting::CuttingLaw law;
  cutting::ImmersionKind immersion = cutting::ImmersionKind::slot;
  double fibre_angle = 0.0;  ///< from the feed, rad
  double volume = 0.0;       ///< of bone to remove, m³; or
  double kerf_area = 0.0;    ///< area of a planar cut as wide as the cutter, m²
  std::array<Span, kVariables> spans{};
  Limits limits;
  Goal goal = Goal::time;
  HeatRelation heat;            ///< needed for a temperature limit
  double damping_ratio = 0.02;  ///< of the tool's modes, for chatter
};

/// Throws InvalidInput that lists every fault.
void check(const ChoiceProblem& problem, const std::vector<Candidate>& candidates);

/// A candidate with what does not change from point to point.
class Evaluator {
 public:
  /// Works out only what the limits and the goal ask for, or everything.
  Evaluator(const ChoiceProblem& problem, const Candidate& candidate, bool everything = false);
  CutQuality operator()(const Point& point) const;

 private:
  const ChoiceProblem& problem_;
  const Candidate& candidate_;
  bool force_, deflection_, temperature_, power_, chatter_;
  ToolCompliance tool_;
  std::vector<vibration::Mode> modes_;
};

/// A limit and how far it is used: 1 is full, above 1 is violated.
struct LimitUse {
  std::string name;
  double use = 0.0;
};
std::vector<LimitUse> limit_uses(const ChoiceProblem& problem, const CutQuality& quality);

/// Largest share by which a limit is exceeded; <= 0 when all are met.
double excess(const std::vector<LimitUse>& uses);

/// What is minimised.
double goal_of(const ChoiceProblem& problem, const CutQuality& quality);

/// Conditions of one removal rate, deep and slow or shallow and fast; [plaskos2002] §4.3.2.
struct EqualTimePoint {
  std::string candidate;
  double axial_depth = 0.0, feed_rate = 0.0;
  CutQuality quality;
};
std::vector<EqualTimePoint> compare_at_removal_rate(const ChoiceProblem& problem,
                                                    const std::vector<Candidate>& candidates,
                                                    double removal_rate, double spindle_speed,
                                                    const std::vector<double>& axial_depths);

}  // namespace osteomill::accuracy
