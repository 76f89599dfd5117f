// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/study/plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "osteomill/base/error.hpp"
#include "osteomill/numerics/distributions.hpp"
#include "osteomill/study/intervals.hpp"

namespace osteomill::study {
namespace {

double t_power(double noncentrality, double df, double alpha) {
  const double critical = numerics::student_t_quantile(1.0 - 0.5 * alpha, df);
  return 1.0 - numerics::noncentral_t_cdf(critical, df, noncentrality) +
         numerics::noncentral_t_cdf(-critical, df, noncentrality);
}

/// Fewest operators whose study can be tested at all.
int fewest_operators(const PlanOptions& o) {
  const bool means =
      o.question == PlanQuestion::kMeansPaired || o.question == PlanQuestion::kMeansGroups;
  return means ? 2 : 1;
}

void check(const PlanOptions& o) {
  require_positive("within_operator_sd", o.within_operator_sd, "");
  require_non_negative("between_operator_sd", o.between_operator_sd, "");
  require_non_negative("operator_by_technique_sd", o.operator_by_technique_sd, "");
  const auto open = [](const char* name, double value, const char* remedy) {
    if (!(value > 0.0 && value < 1.0)) {
      throw InvalidInput(
          Fault{name, fmt::format("{:g}", value), "must lie between 0 and 1", remedy});
    }
  };
  open("alpha", o.alpha, "0.05 is usual");
  open("power", o.power, "0.8 or 0.9 is usual");
  if (o.cuts_per_operator < 1) {
    throw InvalidInput(
        Fault{"cuts_per_operator", fmt::format("{}", o.cuts_per_operator), "must be >= 1", ""});
  }
  const bool means =
      o.question == PlanQuestion::kMeansPaired || o.question == PlanQuestion::kMeansGroups;
  if (means && !(std::abs(o.difference) > 0.0)) {
    throw InvalidInput(Fault{"difference", "0", "must not be 0",
                             "give the least difference of the means that would matter"});
  }
  if (!means && o.cuts_per_operator < 2) {
    throw InvalidInput(Fault{"cuts_per_operator", fmt::format("{}", o.cuts_per_operator),
                             "an SD within an operator needs >= 2 cuts", ""});
  }
  if (o.question == PlanQuestion::kSdRatio &&
      (!(o.sd_ratio > 0.0) || std::abs(std::log(o.sd_ratio)) < 1e-6)) {
    throw InvalidInput(Fault{"sd_ratio", fmt::format("{:g}", o.sd_ratio), "must be > 0 and not 1",
                             "give the SD of the new technique over that of the old"});
  }
  if (o.question == PlanQuestion::kSdPrecision) {
    require_positive("relative_half_width", o.relative_half_width, "");
  }
  if (o.question == PlanQuestion::kShareOutside) {
    require_positive("limit", o.limit, "");
    open("largest_share", o.largest_share, "");
  }
}

/// Chance that a normal sample's two-sided tolerance interval of the wanted content lies inside the
/// limits; the mean is taken as known to sd/sqrt(n).
double share_power(const PlanOptions& o, double n) {
  const double sd = std::hypot(o.within_operator_sd, o.between_operator_sd);
  const double df = n - 1.0;
  const double k = tolerance_factor(n, df, 1.0 - o.largest_share, 1.0 - o.alpha);
  // Over the error of the mean, 61 points of the normal distribution; chi squared for the SD.
  double reached = 0.0, weights = 0.0;
  for (int i = -30; i <= 30; ++i) {
    const double z = 0.2 * i, weight = std::exp(-0.5 * z * z);
    const double room = o.limit - std::abs(o.mean + z * sd / std::sqrt(n));
    weights += weight;
    if (room > 0.0) {
      const double ratio = room / (k * sd);
      reached += weight * numerics::chi_squared_cdf(df * ratio * ratio, df);
    }
  }
  return reached / weights;
}

}  // namespace

PlanPoint plan_point(const PlanOptions& o, int operators) {
  const double n = operators, m = o.cuts_per_operator;
  const double cut_variance = o.within_operator_sd * o.within_operator_sd / m;
  PlanPoint point{operators, operators * o.cuts_per_operator, 0.0};
  switch (o.question) {
    case PlanQuestion::kMeansPaired: {
      const double variance =
          2.0 * cut_variance + o.operator_by_technique_sd * o.operator_by_technique_sd;
      point.cuts *= 2;
      point.power = t_power(o.difference / std::sqrt(variance / n), n - 1.0, o.alpha);
      break;
    }
    case PlanQuestion::kMeansGroups: {
      const double variance = cut_variance + o.between_operator_sd * o.between_operator_sd;
      point.cuts *= 2;
      point.power = t_power(o.difference / std::sqrt(2.0 * variance / n), 2.0 * n - 2.0, o.alpha);
      break;
    }
    case PlanQuestion::kSdRatio: {
      const double df = n * (m - 1.0);
      const double ratio = o.sd_ratio * o.sd_ratio;
      point.cuts *= 2;
      point.power =
          numerics::f_cdf(numerics::f_quantile(0.5 * o.alpha, df, df) / ratio, df, df) +
          numerics::f_upper_tail(numerics::f_quantile(1.0 - 0.5 * o.alpha, df, df) / ratio, df, df);
      break;
    }
    case PlanQuestion::kSdPrecision: {
      const double df = n * (m - 1.0);
      // The upper end over the SD depends on the degrees of freedom alone.
      const double reached = sd_interval(1.0, df, 1.0 - o.alpha).high - 1.0;
      point.power = reached <= o.relative_half_width ? 1.0 : 0.0;
      break;
    }
    case PlanQuestion::kShareOutside:
      point.power = share_power(o, n * m);
      break;
  }
  return point;
}

Plan plan_study(const PlanOptions& options) {
  check(options);
  Plan plan;
  const int fewest = fewest_operators(options);
  const double wanted = options.question == PlanQuestion::kSdPrecision ? 1.0 : options.power;
  for (int n = fewest; n <= options.most_operators; ++n) {
    const PlanPoint point = plan_point(options, n);
    const bool reached = point.power >= wanted;
    if (n <= fewest + 40 || (reached && !plan.feasible)) plan.curve.push_back(point);
    if (reached && !plan.feasible) {
      plan.feasible = true;
      plan.least = point;
    }
    if (plan.feasible && n >= std::max(plan.least.operators + 3, fewest + 9)) break;
  }
  plan.reason = plan.feasible ? "found"
                              : fmt::format(
                                    "{} operators do not reach the power; make more cuts per "
                                    "operator or ask for a larger difference",
                                    options.most_operators);
  return plan;
}

}  // namespace osteomill::study
