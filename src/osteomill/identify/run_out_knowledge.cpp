// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/identify/run_out_knowledge.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <optional>

#include "osteomill/numerics/distributions.hpp"

namespace osteomill::identify {
namespace {

using Eigen::Index;
using Eigen::Matrix2d;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::VectorXd;

constexpr double kTurn = 2.0 * std::numbers::pi;
/// Run-outs that differ by more than their errors would by chance once in a hundred series are not
/// of one clamping.
constexpr double kOneClamping = 0.01;
/// Directions over a pitch that a run-out of unknown direction is tried in.
constexpr int kDirections = 8;

Vector2d components_of(const cutting::RunOut& run_out) {
  return run_out.offset * Vector2d(std::cos(run_out.offset_angle), std::sin(run_out.offset_angle));
}

void set_run_out(const Vector2d& components, cutting::Cutter& cutter) {
  cutter.run_out.offset = components.norm();
  cutter.run_out.offset_angle = std::atan2(components.y(), components.x());
}

struct Found {
  std::size_t experiment = 0;
  Vector2d run_out = Vector2d::Zero();
  Matrix2d covariance = Matrix2d::Zero();
};

/// What a fit says of its run-out. A component that it does not determine (two straight flutes feel
/// one only) is known to be less than a feed.
std::optional<Found> found_by(const InstantaneousFit& fit, std::size_t experiment, double feed) {
  const auto at = std::find_if(fit.estimates.begin(), fit.estimates.end(),
                               [](const Estimate& one) { return one.name == "run_out_x"; });
  if (at == fit.estimates.end()) return {};
  const auto x = static_cast<Index>(at - fit.estimates.begin());
  Found found{experiment, {at->value, (at + 1)->value}, fit.covariance.block<2, 2>(x, x)};
  if (!at->determined && !(at + 1)->determined) return {};
  for (Index i = 0; i < 2; ++i) {
    if ((at + i)->determined) continue;
    found.covariance.row(i).setZero();
    found.covariance.col(i).setZero();
    found.covariance(i, i) = feed * feed;
  }
  return found;
}

bool same_cutter(const cutting::Cutter& a, const cutting::Cutter& b) {
  return a.shape == b.shape && a.radius == b.radius && a.flutes == b.flutes &&
         a.helix_angle == b.helix_angle;
}

bool flutes_alike(const cutting::Cutter& cutter) {
  return cutter.pitch.empty() && cutter.radius_error.empty();
}

double distance2(const Found& a, const Found& b) {
  const Vector2d off = a.run_out - b.run_out;
  return off.dot(Matrix2d(a.covariance + b.covariance).ldlt().solve(off));
}

/// Counts the flutes of each from the one that brings its run-out next to the best known one's.
void align(std::vector<Found>& found, const std::vector<Experiment>& experiments) {
  const Found best = *std::min_element(
      found.begin(), found.end(),
      [](const Found& a, const Found& b) { return a.covariance.trace() < b.covariance.trace(); });
  for (Found& one : found) {
    const cutting::Cutter& cutter = experiments[one.experiment].cutter;
    if (!flutes_alike(cutter)) continue;
    const Found as_found = one;
    for (int flute = 1; flute < cutter.flutes; ++flute) {
      const Eigen::Rotation2Dd turn(-kTurn * flute / cutter.flutes);
      Found turned{one.experiment, turn * as_found.run_out,
                   turn * as_found.covariance * turn.inverse()};
      if (distance2(turned, best) < distance2(one, best)) one = turned;
    }
  }
}

/// Standard deviations along the principal axes.
void add_errors(const Matrix2d& covariance, const std::vector<std::size_t>& experiments,
                std::vector<RunOutError>& errors) {
  const Eigen::SelfAdjointEigenSolver<Matrix2d> axes(covariance);
  for (Index i = 0; i < 2; ++i) {
    const double deviation = std::sqrt(std::max(0.0, axes.eigenvalues()[i]));
    if (deviation > 0.0) errors.push_back({experiments, deviation * axes.eigenvectors().col(i)});
  }
}

/// Standard error of the offset: of the component along it.
double error_along(const Vector2d& run_out, const Matrix2d& covariance) {
  const double offset = run_out.norm();
  if (offset <= 0.0) return std::sqrt(0.5 * covariance.trace());
  return std::sqrt(run_out.dot(covariance * run_out)) / offset;
}

/// Coefficients with some cutters' run-out changed.
VectorXd values_with(std::vector<Experiment> experiments, const FitOptions& options,
                     const RunOutError& change, const MeanForceFit& fit) {
  for (const std::size_t i : change.experiments) {
    cutting::Cutter& cutter = experiments[i].cutter;
    set_run_out(components_of(cutter.run_out) + change.step, cutter);
  }
  return detail::solve(detail::task_of(experiments, fit.model, options), fit.values).values;
}

void add_covariance(const std::vector<Experiment>& experiments, const FitOptions& options,
                    const RunOutKnowledge& known, MeanForceFit& fit) {
  for (const RunOutError& error : known.errors) {
    const VectorXd up = values_with(experiments, options, error, fit) - fit.values;
    const VectorXd down =
        values_with(experiments, options, {error.experiments, -error.step}, fit) - fit.values;
    // About no run-out the forces have a corner: they feel either sign alike, and a central
    // difference would see nothing.
    VectorXd shift = (0.5 * (up - down)).eval();
    for (Index i = 0; i < shift.size(); ++i) {
      const double largest = std::max(std::abs(up[i]), std::abs(down[i]));
      shift[i] = std::copysign(largest, shift[i]);
      if (fit.coefficients[static_cast<std::size_t>(i)].at_bound) shift[i] = 0.0;
    }
    fit.covariance += shift * shift.transpose();
  }
}

void add_shifts(const std::vector<Experiment>& experiments, const FitOptions& options,
                double offset, MeanForceFit& fit) {
  RunOutError change;
  change.experiments.resize(experiments.size());
  std::iota(change.experiments.begin(), change.experiments.end(), std::size_t{0});
  const bool alike = std::all_of(experiments.begin(), experiments.end(),
                                 [](const Experiment& one) { return flutes_alike(one.cutter); });
  const double period = alike ? kTurn / experiments.front().cutter.flutes : kTurn;
  for (int direction = 0; direction < kDirections; ++direction) {
    const double angle = period * direction / kDirections;
    change.step = offset * Vector2d(std::cos(angle), std::sin(angle));
    const VectorXd shift = values_with(experiments, options, change, fit) - fit.values;
    for (std::size_t i = 0; i < fit.coefficients.size(); ++i) {
      Coefficient& one = fit.coefficients[i];
      if (one.at_bound) continue;
      one.shift_low = std::min(one.shift_low, shift[static_cast<Index>(i)]);
      one.shift_high = std::max(one.shift_high, shift[static_cast<Index>(i)]);
    }
  }
}

bool can_run_out(const std::vector<Experiment>& experiments) {
  return std::any_of(experiments.begin(), experiments.end(),
                     [](const Experiment& one) { return one.cutter.flutes > 1; });
}

}  // namespace

RunOutKnowledge stated_run_out(const std::vector<Experiment>& experiments, double standard_error,
                               double bound) {
  RunOutKnowledge known;
  known.bound = bound;
  std::vector<std::size_t> all;
  for (std::size_t i = 0; i < experiments.size(); ++i) {
    all.push_back(i);
    known.offset += experiments[i].cutter.run_out.offset / static_cast<double>(experiments.size());
  }
  const bool given = known.offset > 0.0 || standard_error > 0.0 || !can_run_out(experiments);
  if (!given) return known;
  known.source = RunOutSource::stated;
  known.standard_error = standard_error;
  if (standard_error > 0.0) {
    add_errors(Matrix2d::Identity() * standard_error * standard_error, all, known.errors);
  }
  return known;
}

RunOutKnowledge run_out_of_records(const std::vector<InstantaneousFit>& fits,
                                   const std::vector<std::size_t>& of,
                                   std::vector<Experiment>& experiments) {
  RunOutKnowledge known;
  std::vector<Found> found;
  for (std::size_t i = 0; i < fits.size(); ++i) {
    const Experiment& cut = experiments[of[i]];
    if (auto one = found_by(fits[i], of[i], cut.condition.feed_per_tooth)) {
      found.push_back(*one);
    } else {
      known.left_out.push_back(cut.name);
    }
  }
  if (found.empty()) return known;
  known.source = RunOutSource::records;
  align(found, experiments);
  Matrix2d weight = Matrix2d::Zero();
  Vector2d sum = Vector2d::Zero();
  for (const Found& one : found) {
    const Matrix2d inverse = one.covariance.inverse();
    weight += inverse;
    sum += inverse * one.run_out;
  }
  const Vector2d mean = weight.ldlt().solve(sum);
  double chi2 = 0.0;
  bool one_cutter = true;
  for (const Found& one : found) {
    const Vector2d off = one.run_out - mean;
    chi2 += off.dot(one.covariance.ldlt().solve(off));
  }
  for (const Experiment& one : experiments) {
    one_cutter = one_cutter && same_cutter(one.cutter, experiments.front().cutter);
  }
  const double degrees = 2.0 * static_cast<double>(found.size() - 1);
  known.one_clamping = one_cutter && (degrees == 0.0 || numerics::chi_squared_upper_tail(
                                                            chi2, degrees) > kOneClamping);
  if (known.one_clamping) {
    const double widening = degrees > 0.0 ? std::max(1.0, chi2 / degrees) : 1.0;
    const Matrix2d covariance = widening * weight.inverse();
    std::vector<std::size_t> all(experiments.size());
    std::iota(all.begin(), all.end(), std::size_t{0});
    for (Experiment& one : experiments) set_run_out(mean, one.cutter);
    add_errors(covariance, all, known.errors);
    known.offset = mean.norm();
    known.standard_error = error_along(mean, covariance);
    return known;
  }
  for (const Found& one : found) {
    set_run_out(one.run_out, experiments[one.experiment].cutter);
    add_errors(one.covariance, {one.experiment}, known.errors);
    known.offset += one.run_out.norm() / static_cast<double>(found.size());
    known.standard_error +=
        error_along(one.run_out, one.covariance) / static_cast<double>(found.size());
  }
  return known;
}

void allow_for_run_out(const std::vector<Experiment>& experiments, const FitOptions& options,
                       const RunOutKnowledge& known, MeanForceFit& fit) {
  if (!can_run_out(experiments)) return;
  const bool unknown = known.source == RunOutSource::unknown;
  if (unknown) {
    add_shifts(experiments, options, known.bound > 0.0 ? known.bound : kReferenceRunOut, fit);
  } else {
    add_covariance(experiments, options, known, fit);
  }
  const double t = numerics::student_t_quantile(0.5 + 0.5 * options.confidence,
                                                std::max(1e-3, fit.degrees_of_freedom));
  for (std::size_t i = 0; i < fit.coefficients.size(); ++i) {
    Coefficient& one = fit.coefficients[i];
    if (one.at_bound) continue;
    const auto k = static_cast<Index>(i);
    one.standard_error = std::sqrt(fit.covariance(k, k));
    const bool allowed = unknown && known.bound > 0.0;
    one.low = one.value - t * one.standard_error + (allowed ? one.shift_low : 0.0);
    one.high = one.value + t * one.standard_error + (allowed ? one.shift_high : 0.0);
    one.determined = one.standard_error <= 0.5 * std::abs(one.value);
  }
}

MeanForceFit without_run_out(std::vector<Experiment> experiments, const ForceModel& model,
                             const FitOptions& options) {
  for (Experiment& one : experiments) one.cutter.run_out = {};
  return fit_mean_forces(experiments, model, options);
}

}  // namespace osteomill::identify
