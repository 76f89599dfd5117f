// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/identify/axes_check.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "osteomill/identify/force_model.hpp"
#include "osteomill/numerics/bounded_least_squares.hpp"

namespace osteomill::identify {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// rms of what a plausible law leaves. Columns of `design` are Ktc Krc Kac Kte Kre Kae.
double misfit(const MatrixXd& design, const VectorXd& measured) {
  numerics::LeastSquaresProblem problem;
  VectorXd scale = design.colwise().norm();
  for (double& s : scale) s = s > 0.0 ? s : 1.0;
  const MatrixXd scaled = design * scale.cwiseInverse().asDiagonal();
  problem.residual = [&](const VectorXd& x) -> VectorXd { return scaled * x - measured; };
  problem.jacobian = [&](const VectorXd&) -> MatrixXd { return scaled; };
  problem.upper = VectorXd::Constant(6, 1e300);
  problem.lower = VectorXd{{0.0, 0.0, -1e300, 0.0, 0.0, -1e300}};
  // Five digits are plenty to compare misfits.
  const auto fit = numerics::solve_least_squares(problem, VectorXd::Zero(6),
                                                 {.most_iterations = 60, .tolerance = 1e-5});
  return fit.residual.norm() / std::sqrt(static_cast<double>(measured.size()));
}

int changes(const AxisMapping& mapping) {
  int count = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    count += (mapping.axis[i] != static_cast<int>(i) ? 2 : 0) + (mapping.sign[i] < 0 ? 1 : 0);
  }
  return count;
}

}  // namespace

std::array<std::string, 3> names_of(const AxisMapping& mapping) {
  std::array<std::string, 3> names;
  for (std::size_t i = 0; i < 3; ++i) {
    names[i] = std::string(mapping.sign[i] < 0 ? "-" : "") + "xyz"[mapping.axis[i]];
  }
  return names;
}

geometry::Vector3 mapped(const AxisMapping& mapping, const geometry::Vector3& force) {
  geometry::Vector3 result;
  for (Index i = 0; i < 3; ++i) {
    const auto k = static_cast<std::size_t>(i);
    result(i) = mapping.sign[k] * force(mapping.axis[k]);
  }
  return result;
}

AxesCheck check_axes(const std::vector<Experiment>& experiments) {
  const MatrixXd design = sensitivities(ForceModel{}, {}, experiments);
  const VectorXd given = measured_forces(experiments);
  const double size = given.norm() / std::sqrt(static_cast<double>(given.size()));
  struct Reading {
    AxisMapping mapping;
    double misfit;
  };
  std::vector<Reading> readings;
  AxisMapping mapping;
  std::sort(mapping.axis.begin(), mapping.axis.end());
  do {
    for (int signs = 0; signs < 8; ++signs) {
      for (std::size_t i = 0; i < 3; ++i) mapping.sign[i] = (signs >> i & 1) != 0 ? -1 : 1;
      VectorXd measured(given.size());
      for (Index row = 0; row < given.size(); row += 3) {
        measured.segment<3>(row) = mapped(mapping, given.segment<3>(row));
      }
      readings.push_back({mapping, misfit(design, measured) / size});
    }
  } while (std::next_permutation(mapping.axis.begin(), mapping.axis.end()));

  AxesCheck check;
  check.misfit_as_given = readings.front().misfit;
  check.misfit_best = check.misfit_as_given;
  for (const Reading& one : readings) check.misfit_best = std::min(check.misfit_best, one.misfit);
  check.suspicious = check.misfit_as_given > 0.2 && check.misfit_best < 0.5 * check.misfit_as_given;
  for (const Reading& one : readings) {
    if (one.misfit <= 1.1 * check.misfit_best) check.best.push_back(one.mapping);
  }
  std::stable_sort(
      check.best.begin(), check.best.end(),
      [](const AxisMapping& a, const AxisMapping& b) { return changes(a) < changes(b); });
  return check;
}

}  // namespace osteomill::identify
