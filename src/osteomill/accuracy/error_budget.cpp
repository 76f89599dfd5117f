// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/accuracy/error_budget.hpp"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "osteomill/base/error.hpp"
#include "osteomill/base/random.hpp"
#include "osteomill/numerics/distributions.hpp"

namespace osteomill::accuracy {
namespace {

void check(const std::vector<ErrorSource>& sources) {
  std::vector<Fault> faults;
  if (sources.empty()) {
    faults.push_back({"budget.sources", "", "at least one source is needed", ""});
  }
  for (const ErrorSource& source : sources) {
    const std::string field = "budget.sources." + source.name;
    if (!(source.spread >= 0.0) || !std::isfinite(source.spread)) {
      faults.push_back({field, fmt::format("{:g}", source.spread), "spread must be >= 0", ""});
    }
    if (!std::isfinite(source.bias)) faults.push_back({field, "", "bias must be finite", ""});
    if (source.times < 1) {
      faults.push_back({field, fmt::format("{}", source.times), "must enter at least once", ""});
    }
  }
  if (!faults.empty()) throw InvalidInput(std::move(faults));
}

double variance(const ErrorSource& source) {
  const double square = source.spread * source.spread;
  switch (source.shape) {
    case ErrorShape::uniform:
      return square / 3.0;
    case ErrorShape::triangular:
      return square / 6.0;
    default:
      return square;
  }
}

double draw(const ErrorSource& source, Random& random) {
  switch (source.shape) {
    case ErrorShape::uniform:
      return random.uniform(-source.spread, source.spread);
    case ErrorShape::triangular:
      return source.spread * (random.uniform() + random.uniform() - 1.0);
    default:
      return random.normal(0.0, source.spread);
  }
}

}  // namespace

ErrorSource source_from_compliance(std::string name, double load_mean, double load_sd,
                                   double compliance) {
  require_non_negative("compliance", compliance, "");
  return {std::move(name), load_mean * compliance, load_sd * compliance};
}

Budget propagate(const std::vector<ErrorSource>& sources) {
  check(sources);
  Budget budget;
  double sum = 0.0;
  for (const ErrorSource& source : sources) {
    budget.bias += source.times * source.bias;
    const double v = source.times * variance(source);
    sum += v;
    budget.shares.push_back({source.name, std::sqrt(v), v});
  }
  budget.standard_deviation = std::sqrt(sum);
  for (BudgetShare& share : budget.shares) share.share_of_variance /= sum > 0.0 ? sum : 1.0;
  return budget;
}

double remaining_deviation(const std::vector<ErrorSource>& sources, double allowed) {
  require_positive("allowed standard deviation", allowed, "");
  const double sd = propagate(sources).standard_deviation;
  const double left = allowed * allowed - sd * sd;
  return left >= 0.0 ? std::sqrt(left) : -std::sqrt(-left);
}

double allowed_deviation(double half_window, double probability) {
  require_positive("half window", half_window, "");
  require_within("probability", probability, 0.01, 0.999999, "");
  return half_window / numerics::normal_quantile(0.5 + 0.5 * probability);
}

SampledBudget sample(const std::vector<ErrorSource>& sources, double half_window, int samples,
                     std::uint64_t seed) {
  check(sources);
  require_within("samples", samples, 100.0, 1e8, "");
  std::vector<double> totals(static_cast<std::size_t>(samples));
  tbb::parallel_for(std::size_t{0}, totals.size(), [&](std::size_t i) {
    Random random(seed, i);
    double total = 0.0;
    for (const ErrorSource& source : sources) {
      for (int k = 0; k < source.times; ++k) total += source.bias + draw(source, random);
    }
    totals[i] = total;
  });
  SampledBudget result{.samples = samples};
  const double count = samples;
  result.mean = std::accumulate(totals.begin(), totals.end(), 0.0) / count;
  double squares = 0.0;
  for (const double total : totals) {
    squares += (total - result.mean) * (total - result.mean);
    if (std::abs(total) <= half_window) result.share_within += 1.0 / count;
  }
  result.standard_deviation = std::sqrt(squares / (count - 1.0));
  std::sort(totals.begin(), totals.end());
  result.low = totals[static_cast<std::size_t>(0.025 * count)];
  result.high = totals[static_cast<std::size_t>(0.975 * count)];
  return result;
}

}  // namespace osteomill::accuracy
