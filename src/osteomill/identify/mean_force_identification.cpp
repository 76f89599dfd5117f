// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/identify/mean_force_identification.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"

namespace osteomill::identify {
namespace {

using Eigen::Index;
using Verdict = std::vector<std::string>;

std::string with_error(const Coefficient& one) {
  const double factor = factor_of(one.dimension);
  const std::string unit =
      one.dimension == Dimension::number ? "" : std::string(" ") + unit_of(one.dimension);
  return fmt::format("{} {:.3g} ± {:.2g}{}", one.name, one.value / factor,
                     one.standard_error / factor, unit);
}

void say_ranking(const MeanForceIdentification& result, RankBy rank_by, Verdict& verdict) {
  const Candidate& chosen = result.best();
  const auto rms = [&](const Candidate& one) {
    return rank_by == RankBy::leave_one_out ? one.leave_one->rms : one.leave_group->rms;
  };
  const char* what = rank_by == RankBy::leave_one_out ? "cuts" : "groups";
  std::vector<std::string> tied;
  const Candidate& first = result.candidates.front();
  for (const Candidate& one : result.candidates) {
    if (one.tied || (&one == &first && &first != &chosen)) {
      if (&one != &chosen) tied.push_back(fmt::format("\"{}\" ({:.3g} N)", one.name, rms(one)));
    }
  }
  const auto ranked = std::count_if(result.candidates.begin(), result.candidates.end(),
                                    [](const Candidate& one) { return one.not_ranked.empty(); });
  std::string text = fmt::format("\"{}\" predicts {} that it has not seen to {:.3g} N rms",
                                 chosen.name, what, rms(chosen));
  if (ranked > 1) text += fmt::format("; it is the choice among {} models", ranked);
  if (!tied.empty()) {
    text += fmt::format(". These data do not tell it from {}; it has the fewest unknowns ({})",
                        fmt::join(tied, ", "), chosen.unknowns);
  }
  verdict.push_back(text + ".");
}

void say_coefficients(const Candidate& candidate, const std::string& of, Verdict& verdict) {
  const MeanForceFit& fit = *candidate.fit;
  std::vector<std::string> loose, held;
  for (const Coefficient& one : fit.coefficients) {
    if (one.at_bound) {
      held.push_back(one.name);
    } else if (!one.determined) {
      loose.push_back(with_error(one));
    }
  }
  if (loose.empty() && held.empty()) {
    verdict.push_back(
        fmt::format("All {} coefficients{} are determined: every standard error is "
                    "below half the value (condition number {:.3g}).",
                    fit.coefficients.size(), of, fit.condition_number));
  }
  if (!loose.empty()) {
    verdict.push_back(
        fmt::format("{} of the {} coefficients{} {} not determined by these data (standard error "
                    "above half the value; condition number {:.3g}): {}.",
                    loose.size(), fit.coefficients.size(), of, loose.size() == 1 ? "is" : "are",
                    fit.condition_number, fmt::join(loose, ", ")));
  }
  if (!held.empty()) {
    verdict.push_back(fmt::format("{} {} held by {} bound{}: the data would go beyond.",
                                  fmt::join(held, ", "), held.size() == 1 ? "is" : "are",
                                  held.size() == 1 ? "its" : "their", held.size() == 1 ? "" : "s"));
  }
  if (!fit.weak.empty()) {
    const WeakDirection& weak = fit.weak.front();
    std::vector<std::string> names;
    for (const auto& [name, share] : weak.shares) names.push_back((share < 0.0 ? "-" : "+") + name);
    verdict.push_back(
        fmt::format("{} can change together while the forces change {:.2g} times as much as they "
                    "would by the best determined combination: quote none of them alone.",
                    fmt::join(names, " "), weak.relative_singular_value));
  }
}

/// Where a polynomial that should not be negative is, over the angles that were in the cut.
void say_signs(const MeanForceFit& fit, double largest_kappa, Verdict& verdict) {
  if (!is_linear(fit.model)) return;
  const auto scan = [&](int order, Index first, const char* name) {
    std::vector<double> at;
    for (int i = 0; i <= 100; ++i) {
      const double kappa = largest_kappa * i / 100;
      double value = 0.0;
      for (int k = order; k >= 0; --k) value = value * kappa + fit.values(first + 3 * k);
      if (value < 0.0) at.push_back(kappa);
    }
    if (at.empty()) return;
    const std::string where =
        order == 0 ? "" : fmt::format(" at kappa {:.2g} ... {:.2g} rad", at.front(), at.back());
    verdict.push_back(
        fmt::format("{} is negative{}: no edge pulls, so take the law as an "
                    "interpolation of these cuts, not as the mechanics of the edge.",
                    name, where));
  };
  if (fit.model.shear_order >= 0) scan(fit.model.shear_order, 0, "The tangential pressure Ktc");
  if (fit.model.edge_order >= 0) {
    scan(fit.model.edge_order, 3 * (fit.model.shear_order + 1), "The tangential edge force Kte");
  }
}

void say_influence(const std::vector<Experiment>& experiments, const MeanForceFit& fit,
                   Verdict& verdict) {
  std::vector<std::string> strong;
  for (Index i = 0; i < fit.cook_distance.size(); ++i) {
    // Cook 1977: a distance of 1 moves the estimate to the edge of its 50 % region.
    if (fit.cook_distance(i) > 1.0) {
      strong.push_back(fmt::format("{} (Cook's distance {:.2g})",
                                   experiments[static_cast<std::size_t>(i)].name,
                                   fit.cook_distance(i)));
    }
  }
  if (!strong.empty()) {
    verdict.push_back(fmt::format("The coefficients rest on {}: repeat {}.",
                                  fmt::join(strong, ", "),
                                  strong.size() == 1 ? "this cut" : "these cuts"));
  }
  std::vector<std::string> out;
  for (Index i = 0; i < fit.robust_weight.rows(); ++i) {
    if (fit.robust_weight.row(i).minCoeff() < 0.5) {
      out.push_back(experiments[static_cast<std::size_t>(i)].name);
    }
  }
  if (!out.empty()) {
    verdict.push_back(
        fmt::format("The robust loss counts {} less than half: look for what went wrong there.",
                    fmt::join(out, ", ")));
  }
}

void say_suggestions(const std::vector<SuggestedExperiment>& suggested, const MeanForceFit& fit,
                     Verdict& verdict) {
  if (suggested.empty()) return;
  std::vector<std::string> cuts;
  for (const SuggestedExperiment& one : suggested) {
    const std::string text = describe_cut(one.experiment);
    if (!cuts.empty() && cuts.back().starts_with(text)) {
      cuts.back() = text + ", more than once";
    } else {
      cuts.push_back(text);
    }
  }
  const SuggestedExperiment& last = suggested.back();
  const auto one = std::find_if(fit.coefficients.begin(), fit.coefficients.end(),
                                [&](const Coefficient& c) { return c.name == last.coefficient; });
  const double factor = factor_of(one->dimension);
  verdict.push_back(fmt::format(
      "What would help most: {}. Measured as well as the present cuts, they bring the standard "
      "error of {} from {:.2g} to {:.2g} {}.",
      fmt::join(cuts, "; "), last.coefficient, last.standard_error / factor,
      last.standard_error_after / factor,
      one->dimension == Dimension::number ? "" : unit_of(one->dimension)));
}

/// What was cut; the law says nothing beyond.
void say_range(const std::vector<Experiment>& experiments, Verdict& verdict) {
  const cutting::ChipRange chips = chip_range(experiments);
  double low = 1e300, high = 0.0;
  bool slots = true;
  for (const Experiment& one : experiments) {
    low = std::min(low, one.immersion.axial_depth);
    high = std::max(high, one.immersion.axial_depth);
    slots = slots && one.immersion.kind == cutting::ImmersionKind::slot;
  }
  const auto range = [](double from, double to) {
    return to > from * (1.0 + 1e-9) ? fmt::format("{:.3g} ... {:.3g}", from, to)
                                    : fmt::format("{:.3g}", to);
  };
  verdict.push_back(fmt::format(
      "Cuts were {} mm of depth with largest chips of {} um{}: anything else is an extrapolation, "
      "and cross-validation has not tested it.",
      range(low / units::mm, high / units::mm),
      range(chips.low / units::um, chips.high / units::um), slots ? ", slots only" : ""));
}

/// A change of each coefficient that is worth a word, against its value.
std::vector<std::string> shifts_of(const MeanForceFit& fit) {
  std::vector<std::string> shifts;
  for (const Coefficient& one : fit.coefficients) {
    const double larger = one.shift_high > -one.shift_low ? one.shift_high : one.shift_low;
    if (std::abs(larger) < 0.01 * std::abs(one.value) || one.value == 0.0) continue;
    const double share = 100.0 * larger / std::abs(one.value);
    const double factor = factor_of(one.dimension);
    if (std::abs(share) <= 100.0 && one.dimension != Dimension::number) {
      shifts.push_back(fmt::format("{} by {:+.2g} %", one.name, share));
    } else {
      shifts.push_back(fmt::format("{} by {:+.2g}{}", one.name, larger / factor,
                                   one.dimension == Dimension::number
                                       ? std::string()
                                       : std::string(" ") + unit_of(one.dimension)));
    }
  }
  return shifts;
}

void say_unknown_run_out(const MeanForceFit& fit, const RunOutKnowledge& known, Verdict& verdict) {
  const std::vector<std::string> shifts = shifts_of(fit);
  std::string text =
      "The run-out of the cutter is not known: the coefficients hold only for a cutter that runs "
      "true. ";
  const double offset = known.bound > 0.0 ? known.bound : kReferenceRunOut;
  if (shifts.empty()) {
    text += fmt::format("Run-out of {:.3g} um would change none of them by more than 1 %",
                        offset / units::um);
  } else {
    text += fmt::format("Run-out of {:.3g} um would change {}", offset / units::um,
                        fmt::join(shifts, ", "));
  }
  text += known.bound > 0.0
              ? "; the intervals, not the standard errors, hold that."
              : ". Give records, whose revolutions tell it, or state run_out.bound_um, which goes "
                "into the intervals.";
  verdict.push_back(text);
}

/// What the coefficients owe to run-out.
void say_run_out(const std::vector<Experiment>& experiments, const MeanForceFit& fit,
                 const SelectionOptions& options, Verdict& verdict) {
  const RunOutKnowledge& known = options.run_out;
  if (known.source == RunOutSource::unknown) {
    const bool several = std::any_of(experiments.begin(), experiments.end(),
                                     [](const Experiment& one) { return one.cutter.flutes > 1; });
    if (several) say_unknown_run_out(fit, known, verdict);
    return;
  }
  if (known.offset <= 0.0) return;
  std::string text = fmt::format("Run-out of {:.3g}", known.offset / units::um);
  if (known.standard_error > 0.0) {
    text += fmt::format(" ± {:.2g}", known.standard_error / units::um);
  }
  text += " um";
  if (known.source == RunOutSource::stated) {
    text += known.standard_error > 0.0 ? ", as stated," : ", as stated and taken as exact,";
  } else if (known.one_clamping) {
    text += ", one for all cuts, from the revolutions of their records,";
  } else {
    text +=
        ", from the revolutions of each record (they differ by more than their errors: the "
        "cutter was not in one clamping, or the bone not one),";
  }
  text += " is in the forces and, with its error, in the standard errors";
  std::vector<std::string> without;
  try {
    const MeanForceFit true_running = without_run_out(experiments, fit.model, options.fit);
    for (std::size_t i = 0; i < fit.coefficients.size(); ++i) {
      const Coefficient& one = fit.coefficients[i];
      const double change = true_running.coefficients[i].value - one.value;
      if (one.dimension == Dimension::number || one.value == 0.0) continue;
      if (std::abs(change) < 0.01 * std::abs(one.value)) continue;
      without.push_back(
          fmt::format("{} by {:+.2g} %", one.name, 100.0 * change / std::abs(one.value)));
    }
  } catch (const InvalidInput&) {
    // A bound may leave no such fit; then there is nothing to compare with.
  }
  if (!without.empty()) {
    text += fmt::format("; a fit that does not know of it changes {}", fmt::join(without, ", "));
  }
  verdict.push_back(text + ".");
}

/// The reference of the options, or the published cubic where it took part.
std::optional<Candidate> reference_of(const std::vector<Experiment>& experiments,
                                      const MeanForceIdentification& result,
                                      const SelectionOptions& options) {
  const ForceModel wanted = options.reference.value_or(
      ForceModel{.form = LawForm::polynomial, .shear_order = 3, .edge_order = 0});
  for (const Candidate& one : result.candidates) {
    if (one.model == wanted && !one.chosen) return one;
  }
  if (!options.reference || result.best().model == wanted) return {};
  SelectionOptions alone = options;
  alone.rank_by = RankBy::leave_one_out;
  return rank_models(experiments, {wanted}, alone).front();
}

void say_reference(const Candidate& reference, const Candidate& chosen, Verdict& verdict) {
  if (!reference.fit) {
    verdict.push_back(
        fmt::format("\"{}\" could not be fitted: {}.", reference.name, reference.not_ranked));
    return;
  }
  if (reference.leave_one->complete) {
    verdict.push_back(
        fmt::format("\"{}\" predicts cuts that it has not seen to {:.3g} N rms "
                    "where it fits them to {:.3g} N; the choice has {:.3g} and {:.3g} N.",
                    reference.name, reference.leave_one->rms, reference.fit->residual_rms_all,
                    chosen.leave_one->rms, chosen.fit->residual_rms_all));
  }
  say_coefficients(reference, fmt::format(" of \"{}\"", reference.name), verdict);
}

void say_axes(const AxesCheck& axes, std::vector<std::string>& warnings) {
  if (!axes.suspicious) return;
  std::vector<std::string> readings;
  for (std::size_t i = 0; i < std::min<std::size_t>(3, axes.best.size()); ++i) {
    const auto names = names_of(axes.best[i]);
    readings.push_back(fmt::format("[\"{}\", \"{}\", \"{}\"]", names[0], names[1], names[2]));
  }
  warnings.push_back(fmt::format(
      "the axes look swapped or reversed: an edge that is pushed back and out leaves {:.0f} % of "
      "the force as given and {:.0f} % with axes = {}; check the mounting and the sign convention",
      100.0 * axes.misfit_as_given, 100.0 * axes.misfit_best, fmt::join(readings, " or ")));
}

}  // namespace

MeanForceIdentification identify_mean_forces(const std::vector<Experiment>& experiments,
                                             const std::vector<ForceModel>& models,
                                             const SelectionOptions& options) {
  MeanForceIdentification result;
  result.candidates = rank_models(experiments, models, options);
  for (std::size_t i = 0; i < result.candidates.size(); ++i) {
    if (result.candidates[i].chosen) result.chosen = i;
  }
  result.run_out = options.run_out;
  Candidate& chosen = result.candidates[result.chosen];
  allow_for_run_out(experiments, options.fit, options.run_out, *chosen.fit);
  const MeanForceFit& fit = *chosen.fit;
  result.axes = check_axes(experiments);
  result.suggested = suggest_experiments(experiments, fit);
  say_ranking(result, options.rank_by, result.verdict);
  say_coefficients(result.best(), "", result.verdict);
  say_run_out(experiments, fit, options, result.verdict);
  say_signs(fit, largest_kappa(experiments), result.verdict);
  say_influence(experiments, fit, result.verdict);
  say_suggestions(result.suggested, fit, result.verdict);
  say_range(experiments, result.verdict);
  result.reference = reference_of(experiments, result, options);
  if (result.reference && result.reference->fit) {
    allow_for_run_out(experiments, options.fit, options.run_out, *result.reference->fit);
  }
  if (result.reference) say_reference(*result.reference, result.best(), result.verdict);
  say_axes(result.axes, result.warnings);
  return result;
}

}  // namespace osteomill::identify
