// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>

#include "osteomill/study/intervals.hpp"

/// What the population of such cuts will do: cuts of other operators of the same kind, not of the
/// few that were measured.
namespace osteomill::study {

/// Mean and variance with operators at random, by unweighted operator means (Thomas and Hultquist
/// 1978 for unequal counts): T = (B + (m-1) W) / m, with B = m var(operator means) on k - 1 degrees
/// of freedom, W the pooled variance within operators on N - k, m the harmonic mean of their cuts.
/// Without operators every cut is one of its own: m = 1.
struct Population {
  double mean = 0.0;
  double total_sd = 0.0;
  int operators = 0;     ///< k; the number of cuts where there are none or one
  double cuts = 1.0;     ///< m
  double between = 0.0;  ///< B
  double between_df = 0.0;
  double within = 0.0;  ///< W
  double within_df = 0.0;
};

/// `operator_of[i]` >= 0; empty: none. One operator only is taken as a population of its own.
/// Needs two values that differ.
Population estimate_population(std::span<const double> values, std::span<const int> operator_of);

struct ForecastOptions {
  double limit = 3.0;
  double content = 0.95;  ///< share that the tolerance interval holds
  double confidence = 0.95;
  std::uint64_t seed = 1;
  int draws = 10000;
};

struct OutsideShare {
  double estimate = 0.0;
  Interval interval;
};

struct Forecast {
  double mean = 0.0;
  double sd = 0.0;
  Interval tolerance;    ///< holds `content` of the population, with the confidence
  OutsideShare outside;  ///< share of the population outside +- limit
};

/// Of the sum of `cuts` independent cuts. The share outside by generalised (fiducial) draws of mean
/// and variances, Krishnamoorthy and Mathew 2009; a drawn mean's square is 2 sd^2/n too large on
/// average, and without that excess taken off (for the lower end 3, and 1/2 more for each operator
/// below eight), the interval is too high for a mean near zero. The tolerance interval by the exact
/// factor where cuts are alone, otherwise as Howe 1969 with the upper limit of T by modified large
/// samples (Graybill and Wang 1980).
Forecast forecast(const Population& population, int cuts, const ForecastOptions& options = {});

}  // namespace osteomill::study
