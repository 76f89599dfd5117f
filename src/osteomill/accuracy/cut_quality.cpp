// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/accuracy/cut_quality.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/vibration/beam_elements.hpp"
#include "osteomill/vibration/linearised_cut.hpp"
#include "osteomill/vibration/stability.hpp"

namespace osteomill::accuracy {
namespace {

double& value(Point& point, Variable variable) { return point[static_cast<std::size_t>(variable)]; }
double value(const Point& point, Variable variable) {
  return point[static_cast<std::size_t>(variable)];
}

ToolCompliance tool_of(const Candidate& candidate) {
  return ToolCompliance::cantilever(
      candidate.tool_length, 2.0 * candidate.cutter.radius * candidate.effective_diameter_factor,
      candidate.youngs_modulus);
}

/// Modes of the free length, clamped where it is held, alike in both directions.
std::vector<vibration::Mode> modes_of(const Candidate& candidate, double damping_ratio) {
  const vibration::Beam beam{
      .segments = {{.length = candidate.tool_length,
                    .diameter = 2.0 * candidate.cutter.radius,
                    .effective_diameter_factor = candidate.effective_diameter_factor}},
      .supports = {{.position = 0.0, .type = vibration::SupportType::clamp}},
      .youngs_modulus = candidate.youngs_modulus,
      .density = candidate.density};
  const vibration::BeamModel model(beam, {.elements = 8});
  auto modes = vibration::tip_modes(model, candidate.tool_length, 1, damping_ratio, 1.0, 0.0);
  const auto other = vibration::tip_modes(model, candidate.tool_length, 1, damping_ratio, 0.0, 1.0);
  modes.insert(modes.end(), other.begin(), other.end());
  return modes;
}

}  // namespace

const std::array<const char*, kVariables>& variable_names() {
  static constexpr std::array<const char*, kVariables> names = {"feed_per_tooth", "spindle_speed",
                                                                "axial_depth", "radial_depth"};
  return names;
}

Evaluator::Evaluator(const ChoiceProblem& problem, const Candidate& candidate, bool everything)
    : problem_(problem),
      candidate_(candidate),
      force_(everything || problem.limits.peak_force || problem.goal == Goal::force),
      deflection_(everything || problem.limits.deflection || problem.limits.surface_error ||
                  problem.goal == Goal::error),
      temperature_(everything || problem.limits.temperature),
      power_(everything || problem.limits.power || problem.goal == Goal::heat),
      chatter_(everything || problem.limits.chatter),
      tool_(tool_of(candidate)),
      modes_(modes_of(candidate, problem.damping_ratio)) {}

CutQuality Evaluator::operator()(const Point& point) const {
  const cutting::Cutter& cutter = candidate_.cutter;
  cutting::Condition condition{.spindle_speed = value(point, Variable::spindle_speed),
                               .feed_per_tooth = value(point, Variable::feed_per_tooth),
                               .fibre_T = cutting::fibre_at_angle(problem_.fibre_angle)};
  const cutting::Immersion immersion{
      .kind = problem_.immersion,
      .radial_depth = std::min(value(point, Variable::radial_depth), 2.0 * cutter.radius),
      .axial_depth = std::min(value(point, Variable::axial_depth), candidate_.tool_length)};
  CutQuality quality;
  quality.feed_per_tooth = condition.feed_per_tooth;
  const double rate = cutting::removal_rate(cutter, condition, immersion);
  const double volume =
      problem_.volume > 0.0 ? problem_.volume : problem_.kerf_area * 2.0 * cutter.radius;
  quality.time = volume / rate;
  if (force_) {
    const auto turn =
        cutting::revolution(cutter, problem_.law, condition, immersion, 36 * cutter.flutes);
    quality.peak_force = 0.0;
    for (const cutting::Load& load : turn.loads) {
      quality.peak_force = std::max(quality.peak_force, load.force.norm());
    }
  }
  if (power_) {
    const auto mean = cutting::mean_load(cutter, problem_.law, condition, immersion);
    quality.power = cutting::spindle_power(mean, condition.spindle_speed);
    quality.energy = quality.power / rate;
  }
  if (deflection_) {
    const ToolDeflection bent = tool_deflection(tool_, cutter, problem_.law, condition, immersion,
                                                {.slice_height = 2e-3, .steps = 180});
    quality.deflection = bent.total_tip;
    quality.surface_error = largest_magnitude(bent.surface);
  }
  if (temperature_ && problem_.heat.coefficient > 0.0) {
    quality.temperature = temperature(problem_.heat, immersion.axial_depth, condition.spindle_speed,
                                      cutter.flutes, cutting::feed_rate(condition, cutter.flutes));
  }
  if (chatter_) {
    const vibration::RegenerativeSystem system(
        modes_, vibration::linearised_cut(cutter, problem_.law, condition, immersion));
    quality.chatter = vibration::spectral_radius(system, condition.spindle_speed,
                                                 immersion.axial_depth, {.max_depth = 1.0});
  }
  return quality;
}

double goal_of(const ChoiceProblem& problem, const CutQuality& quality) {
  switch (problem.goal) {
    case Goal::force:
      return quality.peak_force;
    case Goal::heat:
      return quality.energy;
    case Goal::error:
      return quality.surface_error;
    default:
      return quality.time;
  }
}

double excess(const std::vector<LimitUse>& uses) {
  double largest = -1.0;
  for (const LimitUse& use : uses) largest = std::max(largest, use.use - 1.0);
  return largest;
}

void check(const ChoiceProblem& problem, const std::vector<Candidate>& candidates) {
  std::vector<Fault> faults;
  if (candidates.empty()) {
    faults.push_back({"candidates", "", "at least one cutter is needed", "add a [[candidate]]"});
  }
  for (std::size_t i = 0; i < kVariables; ++i) {
    if (i == static_cast<std::size_t>(Variable::radial_depth) &&
        problem.immersion == cutting::ImmersionKind::slot) {
      continue;
    }
    const Span& span = problem.spans[i];
    if (!(span.low > 0.0 && span.high >= span.low)) {
      faults.push_back({fmt::format("choose.{}", variable_names()[i]),
                        fmt::format("{:g} ... {:g} (SI)", span.low, span.high),
                        "must be two values > 0, the lower first", ""});
    }
  }
  if ((problem.volume > 0.0) == (problem.kerf_area > 0.0)) {
    faults.push_back({"job", "", "needs either volume_mm3 or kerf_area_mm2", ""});
  }
  if (problem.limits.temperature && !(problem.heat.coefficient > 0.0)) {
    faults.push_back(
        {"limits.temperature_c", "", "needs a calibrated heat relation", "set heat.coefficient_k"});
  }
  for (const Candidate& candidate : candidates) {
    if (!(candidate.tool_length > 0.0)) {
      faults.push_back({"candidate." + candidate.name + ".tool_length_mm", "", "must be > 0", ""});
    } else if (problem.spans[static_cast<std::size_t>(Variable::axial_depth)].high >
               candidate.tool_length) {
      faults.push_back({"choose.axial_depth_mm", "",
                        "reaches beyond the free length of " + candidate.name,
                        "lower its upper end"});
    }
  }
  if (!faults.empty()) throw InvalidInput(std::move(faults));
  for (const Candidate& candidate : candidates) cutting::check(candidate.cutter);
  cutting::check(problem.law);
}

std::vector<LimitUse> limit_uses(const ChoiceProblem& problem, const CutQuality& quality) {
  const Limits& limits = problem.limits;
  std::vector<LimitUse> uses;
  const auto add = [&](const char* name, const std::optional<double>& limit, double got) {
    if (limit) uses.push_back({name, got / *limit});
  };
  add("time", limits.time, quality.time);
  add("peak_force", limits.peak_force, quality.peak_force);
  add("deflection", limits.deflection, quality.deflection);
  add("surface_error", limits.surface_error, quality.surface_error);
  if (limits.temperature) {
    uses.push_back({"temperature", (quality.temperature - problem.heat.start) /
                                       (*limits.temperature - problem.heat.start)});
  }
  add("power", limits.power, quality.power);
  add("chatter", limits.chatter, quality.chatter);
  uses.push_back({"feed_per_tooth", quality.feed_per_tooth / limits.feed_per_tooth});
  return uses;
}

std::vector<EqualTimePoint> compare_at_removal_rate(const ChoiceProblem& problem,
                                                    const std::vector<Candidate>& candidates,
                                                    double removal_rate, double spindle_speed,
                                                    const std::vector<double>& axial_depths) {
  require_positive("compare.removal_rate_mm3_per_s", removal_rate / units::mm3, "mm3/s");
  std::vector<EqualTimePoint> list;
  for (const Candidate& candidate : candidates) {
    for (const double depth : axial_depths) {
      EqualTimePoint one;
      one.candidate = candidate.name;
      one.axial_depth = depth;
      const double width =
          problem.immersion == cutting::ImmersionKind::slot
              ? 2.0 * candidate.cutter.radius
              : problem.spans[static_cast<std::size_t>(Variable::radial_depth)].low;
      one.feed_rate = removal_rate / (width * depth);
      Point point{};
      value(point, Variable::feed_per_tooth) =
          cutting::feed_per_tooth(one.feed_rate, spindle_speed, candidate.cutter.flutes);
      value(point, Variable::spindle_speed) = spindle_speed;
      value(point, Variable::axial_depth) = depth;
      value(point, Variable::radial_depth) = width;
      one.quality = Evaluator(problem, candidate, true)(point);
      list.push_back(one);
    }
  }
  return list;
}

}  // namespace osteomill::accuracy
