// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/identify/model_selection.hpp"

#include <algorithm>
#include <cmath>

#include "osteomill/base/error.hpp"

namespace osteomill::identify {
namespace {

/// Squared error summed over x, y, z: one value a fold, the mean over its experiments.
std::vector<double> squares_of(const CrossValidation& validation, const std::vector<Fold>& folds) {
  std::vector<double> squares;
  for (const Fold& fold : folds) {
    double sum = 0.0;
    for (const std::size_t i : fold) sum += validation.error[i]->squaredNorm();
    squares.push_back(sum / static_cast<double>(fold.size()));
  }
  return squares;
}

const CrossValidation& ranked_by(const Candidate& candidate, RankBy rank_by) {
  return rank_by == RankBy::leave_one_out ? *candidate.leave_one : *candidate.leave_group;
}

/// Of several models each takes the bounds of its own coefficients.
FitOptions options_for(const ForceModel& model, const FitOptions& options) {
  FitOptions own = options;
  const std::vector<CoefficientKey> keys = coefficients_of(model);
  std::erase_if(own.bounds, [&](const Bound& bound) {
    return std::none_of(keys.begin(), keys.end(),
                        [&](const CoefficientKey& key) { return key.name == bound.coefficient; });
  });
  return own;
}

Candidate try_model(const std::vector<Experiment>& experiments, const ForceModel& model,
                    const SelectionOptions& options, const std::vector<Fold>& groups) {
  const FitOptions fit = options_for(model, options.fit);
  Candidate one;
  one.model = model;
  one.name = name_of(model);
  one.unknowns = static_cast<int>(coefficients_of(model).size());
  try {
    one.fit = fit_mean_forces(experiments, model, fit);
  } catch (const InvalidInput& error) {
    one.not_ranked = error.faults().front().rule;
    one.remedy = error.faults().front().remedy;
    return one;
  }
  if (one.fit->status != "fitted") {
    one.not_ranked = "the fit did not converge";
    return one;
  }
  one.leave_one = cross_validate(experiments, *one.fit, fit, leave_one_out(experiments));
  if (!groups.empty()) {
    one.leave_group = cross_validate(experiments, *one.fit, fit, groups);
  }
  const CrossValidation& decides = ranked_by(one, options.rank_by);
  if (!decides.complete) {
    one.not_ranked = "not determined without " + decides.undetermined.front();
  }
  return one;
}

}  // namespace

std::vector<ForceModel> models_to_try(const std::vector<Experiment>& experiments,
                                      const SelectionOptions& options) {
  const bool round = std::any_of(experiments.begin(), experiments.end(), [](const auto& one) {
    return one.cutter.shape != cutting::CutterShape::cylindrical;
  });
  const int shear = round ? options.largest_shear_order : 0;
  const int edge = round ? options.largest_edge_order : 0;
  std::vector<ForceModel> models;
  for (int e = -1; e <= edge; ++e) {
    for (int s = -1; s <= shear; ++s) {
      if (s < 0 && e < 0) continue;
      models.push_back({.form = round ? LawForm::polynomial : LawForm::linear,
                        .shear_order = s,
                        .edge_order = e});
    }
  }
  models.push_back({.form = LawForm::power});
  models.push_back({.form = LawForm::power, .edge_force = true});
  models.push_back({.form = LawForm::log});
  if (!round) {
    models.push_back({.form = LawForm::power, .directional = true});
    models.push_back({.form = LawForm::log, .directional = true});
  }
  return models;
}

std::vector<Candidate> rank_models(const std::vector<Experiment>& experiments,
                                   const std::vector<ForceModel>& models,
                                   const SelectionOptions& options) {
  check(experiments, options.fit);
  const std::vector<Fold> groups = leave_one_group_out(experiments);
  if (options.rank_by == RankBy::leave_one_group_out && groups.empty()) {
    throw InvalidInput(Fault{"model.rank_by", "leave-one-group-out",
                             "needs two groups or more in the table",
                             "add the column group, or rank by leave-one-out"});
  }
  std::vector<Candidate> all;
  for (const ForceModel& model : models) {
    all.push_back(try_model(experiments, model, options, groups));
  }
  const auto middle = std::stable_partition(
      all.begin(), all.end(), [](const Candidate& one) { return one.not_ranked.empty(); });
  if (middle == all.begin()) {
    std::vector<Fault> faults;
    for (const Candidate& one : all) {
      faults.push_back({"model." + one.name, std::to_string(one.unknowns) + " unknowns",
                        one.not_ranked, one.remedy});
    }
    throw InvalidInput(faults);
  }
  std::stable_sort(all.begin(), middle, [&](const Candidate& a, const Candidate& b) {
    return ranked_by(a, options.rank_by).rms < ranked_by(b, options.rank_by).rms;
  });
  const std::vector<Fold> folds =
      options.rank_by == RankBy::leave_one_out ? leave_one_out(experiments) : groups;
  const std::vector<double> best = squares_of(ranked_by(all.front(), options.rank_by), folds);
  auto chosen = all.begin();
  for (auto one = all.begin(); one != middle; ++one) {
    const std::vector<double> squares = squares_of(ranked_by(*one, options.rank_by), folds);
    const auto n = static_cast<double>(folds.size());
    double sum = 0.0, square = 0.0;
    for (std::size_t i = 0; i < folds.size(); ++i) sum += squares[i] - best[i];
    one->excess = sum / n;
    for (std::size_t i = 0; i < folds.size(); ++i) {
      square += std::pow(squares[i] - best[i] - one->excess, 2.0);
    }
    one->excess_error = std::sqrt(square / (n * (n - 1.0)));
    one->tied = one != all.begin() && one->excess <= one->excess_error;
    if (one->tied && one->unknowns < chosen->unknowns) chosen = one;
  }
  chosen->chosen = true;
  return all;
}

}  // namespace osteomill::identify
