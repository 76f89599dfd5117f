// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "osteomill/accuracy/cut_quality.hpp"
#include "osteomill/base/progress.hpp"

namespace osteomill::accuracy {

/// What 10 % more of a binding limit would buy.
struct Relaxation {
  std::string limit;
  double goal = 0.0;  ///< with the limit relaxed
  double gain = 0.0;  ///< share of the goal that is saved
};

struct Choice {
  std::string status = "not run";  ///< "optimal", "infeasible"
  bool feasible = false;
  std::string candidate;
  Point point{};
  CutQuality quality;  ///< everything worked out
  double goal = std::numeric_limits<double>::infinity();
  std::vector<std::string> binding;     ///< limits and ends of spans that hold the optimum
  std::vector<Relaxation> relaxations;  ///< of the binding limits
  std::vector<LimitUse> violated;       ///< infeasible: what the closest point exceeds
  int evaluations = 0;
};

/// Continuous by COBYLA of NLopt from four starts for each candidate, discrete by enumeration; the
/// candidates run on threads, the answer does not depend on them. When nothing is feasible, the
/// point that exceeds its limits the least is returned, and says which.
Choice choose(const ChoiceProblem& problem, const std::vector<Candidate>& candidates,
              const Progress& progress = {});

/// The best point of a grid with `points` values a free variable: slow, the reference.
Choice choose_by_grid(const ChoiceProblem& problem, const std::vector<Candidate>& candidates,
                      int points);

struct ParetoPoint {
  double time = 0.0;
  double error = 0.0;  ///< surface error, m
  std::string candidate;
  Point point{};
};
/// Least time for each of `points` limits of the surface error, between the most accurate cut and
/// the fastest; points that another beats in both are left out.
std::vector<ParetoPoint> pareto_front(const ChoiceProblem& problem,
                                      const std::vector<Candidate>& candidates, int points,
                                      const Progress& progress = {});

}  // namespace osteomill::accuracy
