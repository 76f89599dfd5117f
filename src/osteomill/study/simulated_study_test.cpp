// SPDX-License-Identifier: BSD-3-Clause
// Studies simulated with known components, 1 000 seeded repetitions each: what the estimators give
// back, and how often the intervals hold the truth.
#include <gtest/gtest.h>

#include <cmath>
#include <span>

#include "osteomill/base/random.hpp"
#include "osteomill/study/anova.hpp"
#include "osteomill/study/diagnostics.hpp"
#include "osteomill/study/forecast.hpp"
#include "osteomill/study/intervals.hpp"
#include "osteomill/study/mixed_model.hpp"

namespace osteomill::study {
namespace {

constexpr int kRepetitions = 1000;
constexpr std::uint64_t kSeed = 20021;

// A nominal 95 % interval over 1 000 repetitions counts 95 +- 0.7 % (one sigma): what is asked for,
// 93 to 97 %, is three sigma of the count.
void expect_nominal(int held, int of = kRepetitions) {
  EXPECT_GE(held, 0.93 * of);
  EXPECT_LE(held, 0.97 * of);
}

/// Eight operators, unbalanced, on 19 specimens that several share: the shape of [plaskos2002]
/// ch. 2.
struct Study {
  MixedModelData data;
};

constexpr double kMean = 0.4, kOperatorSd = 0.5, kSpecimenSd = 0.35, kCutSd = 1.0;

Study simulate(Random& random, int operators, bool specimens) {
  const int cuts[] = {9, 14, 12, 8, 11, 13, 10, 8};
  Study study;
  std::vector<int> who, what;
  for (int o = 0; o < operators; ++o) {
    for (int c = 0; c < cuts[o % 8]; ++c) {
      who.push_back(o);
      what.push_back((5 * o + 3 * c) % 19);
    }
  }
  const auto n = static_cast<Eigen::Index>(who.size());
  std::vector<double> of_operator(operators), of_specimen(19);
  for (double& u : of_operator) u = random.normal(0.0, kOperatorSd);
  for (double& u : of_specimen) u = random.normal(0.0, specimens ? kSpecimenSd : 0.0);
  study.data.y.resize(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    study.data.y(i) =
        kMean + of_operator[who[i]] + of_specimen[what[i]] + random.normal(0.0, kCutSd);
  }
  study.data.x = Eigen::MatrixXd::Ones(n, 1);
  study.data.random.push_back({"operator", std::vector<std::string>(operators, "o"), who});
  if (specimens) {
    study.data.random.push_back({"specimen", std::vector<std::string>(19, "s"), what});
  }
  return study;
}

bool holds(const Interval& interval, double truth) {
  return interval.low <= truth && truth <= interval.high;
}

std::span<const double> values(const Study& study) {
  return {study.data.y.data(), static_cast<size_t>(study.data.y.size())};
}

TEST(SimulatedStudy, GivesItsComponentsBackWithoutBias) {
  double sum[3] = {}, squares[3] = {}, mean_sum = 0.0, mean_squares = 0.0;
  const double truth[3] = {kOperatorSd * kOperatorSd, kSpecimenSd * kSpecimenSd, kCutSd * kCutSd};
  for (int r = 0; r < kRepetitions; ++r) {
    Random random(kSeed, r);
    const MixedModel fit = fit_mixed_model(simulate(random, 8, true).data, {.intervals = false});
    ASSERT_TRUE(fit.converged);
    for (int k = 0; k < 3; ++k) {
      const double variance = fit.components[k].sd * fit.components[k].sd;
      sum[k] += variance;
      squares[k] += variance * variance;
    }
    mean_sum += fit.beta(0);
    mean_squares += fit.beta(0) * fit.beta(0);
  }
  // Three standard errors of the mean over the repetitions.
  const auto expect_unbiased = [](double total, double total_squares, double expected) {
    const double mean = total / kRepetitions;
    const double error = std::sqrt((total_squares / kRepetitions - mean * mean) / kRepetitions);
    EXPECT_NEAR(mean, expected, 3.0 * error);
  };
  for (int k = 0; k < 3; ++k) expect_unbiased(sum[k], squares[k], truth[k]);
  expect_unbiased(mean_sum, mean_squares, kMean);
}

TEST(SimulatedStudy, ProfileIntervalsOfComponentsHoldTheTruth) {
  int operators = 0, cuts = 0;
  for (int r = 0; r < kRepetitions; ++r) {
    Random random(kSeed + 1, r);
    const MixedModel fit = fit_mixed_model(simulate(random, 8, false).data);
    operators += holds(fit.components[0].sd_interval, kOperatorSd);
    cuts += holds(fit.components[1].sd_interval, kCutSd);
  }
  expect_nominal(operators);
  expect_nominal(cuts);
}

TEST(SimulatedStudy, ProfileIntervalsHoldTheTruthWithCrossedSpecimensToo) {
  int held[3] = {};
  const double truth[3] = {kOperatorSd, kSpecimenSd, kCutSd};
  for (int r = 0; r < kRepetitions; ++r) {
    Random random(kSeed + 6, r);
    const MixedModel fit = fit_mixed_model(simulate(random, 8, true).data);
    for (int k = 0; k < 3; ++k) held[k] += holds(fit.components[k].sd_interval, truth[k]);
  }
  for (const int count : held) expect_nominal(count);
}

// Two techniques, operators with differences of their own, cells of unequal size: no difference of
// the means is there to be found.
TEST(SimulatedStudy, MixedModelRejectsAsOftenAsItSays) {
  int rejected = 0;
  for (int r = 0; r < kRepetitions; ++r) {
    Random random(kSeed + 7, r);
    MixedModelData data;
    std::vector<double> y, technique;
    Factor who{"operator", {}, {}}, crossed{"operator x technique", {}, {}};
    for (int o = 0; o < 8; ++o) {
      const double own = random.normal(0.0, kOperatorSd);
      who.levels.emplace_back("o");
      for (int t = 0; t < 2; ++t) {
        const double with = random.normal(0.0, 0.3);
        crossed.levels.emplace_back("c");
        for (int c = 0; c < 4 + (3 * o + 5 * t) % 5; ++c) {
          y.push_back(own + with + random.normal());
          technique.push_back(t == 0 ? -1.0 : 1.0);
          who.level.push_back(o);
          crossed.level.push_back(2 * o + t);
        }
      }
    }
    const auto n = static_cast<Eigen::Index>(y.size());
    data.y = Eigen::Map<Eigen::VectorXd>(y.data(), n);
    data.x = Eigen::MatrixXd::Ones(n, 2);
    data.x.col(1) = Eigen::Map<Eigen::VectorXd>(technique.data(), n);
    data.random = {who, crossed};
    const MixedModel fit = fit_mixed_model(data, {.intervals = false});
    rejected += test_fixed_effect(data, fit, Eigen::RowVector2d(0.0, 1.0)).p < 0.05;
  }
  expect_nominal(kRepetitions - rejected);
}

TEST(SimulatedStudy, AdjustedMeansHoldTheTruth) {
  int held = 0;
  for (int r = 0; r < kRepetitions; ++r) {
    Random random(kSeed + 8, r);
    Eigen::VectorXd y(30), x(30);
    Factor group{"g", {"a", "b"}, {}};
    for (int i = 0; i < 30; ++i) {
      group.level.push_back(i % 3 == 0);
      x(i) = random.normal();
      y(i) = 0.5 * x(i) + random.normal();
    }
    const Ancova ancova = analyse_covariance(y, {group}, {{"x", x}});
    // At the covariate's mean of this study the truth is the line there.
    held += holds(ancova.adjusted_means[0].interval, 0.5 * x.mean());
  }
  expect_nominal(held);
}

TEST(SimulatedStudy, IntervalsOfSdMeanRatioAndCorrelationHoldTheTruth) {
  int sd = 0, mean = 0, ratio = 0, difference = 0, correlation = 0, pooled = 0;
  const double rho = 0.45;
  for (int r = 0; r < kRepetitions; ++r) {
    Random random(kSeed + 2, r);
    std::vector<double> a, b;
    std::vector<int> cell;
    for (int i = 0; i < 25; ++i) {
      a.push_back(0.3 + 0.4 * random.normal() + 0.2 * (i % 3));
      cell.push_back(i % 3);
    }
    for (int i = 0; i < 38; ++i) b.push_back(0.8 * random.normal());
    const Moments within = pooled_within(a, cell), mb = moments(b);
    sd += holds(sd_interval(within.sd, within.degrees_of_freedom), 0.4);
    ratio += holds(variance_ratio_test(within, mb).interval, 0.25);
    mean += holds(one_sample_t_test(mb).interval, 0.0);
    std::vector<double> c, d;
    for (int i = 0; i < 12; ++i) c.push_back(1.0 + 0.4 * random.normal());
    for (int i = 0; i < 20; ++i) d.push_back(0.4 * random.normal());
    difference += holds(welch_t_test(moments(c), mb).interval, 1.0);
    pooled += holds(pooled_t_test(moments(c), moments(d)).interval, 1.0);
    double xx = 0.0, yy = 0.0, xy = 0.0, mx = 0.0, my = 0.0;
    std::vector<double> x(60), y(60);
    for (int i = 0; i < 60; ++i) {
      x[i] = random.normal();
      y[i] = rho * x[i] + std::sqrt(1.0 - rho * rho) * random.normal();
      mx += x[i] / 60.0;
      my += y[i] / 60.0;
    }
    for (int i = 0; i < 60; ++i) {
      xx += (x[i] - mx) * (x[i] - mx);
      yy += (y[i] - my) * (y[i] - my);
      xy += (x[i] - mx) * (y[i] - my);
    }
    correlation += holds(r_squared_interval(xy / std::sqrt(xx * yy), 60), rho * rho);
  }
  for (const int held : {sd, mean, ratio, difference, pooled, correlation}) expect_nominal(held);
}

TEST(SimulatedStudy, ForecastsOfOtherOperatorsHoldTheTruth) {
  const auto upper = [](double z) { return 0.5 * std::erfc(z / std::sqrt(2.0)); };
  const auto outside = [&](double mean, double sd) {
    return upper((3.0 - mean) / sd) + upper((3.0 + mean) / sd);
  };
  const double sd = std::hypot(kOperatorSd, kCutSd);
  int one_cut = 0, alignment = 0, tolerance = 0, plain = 0, plain_tolerance = 0;
  for (int r = 0; r < kRepetitions; ++r) {
    Random random(kSeed + 3, r);
    const ForecastOptions options{.seed = static_cast<std::uint64_t>(r), .draws = 1000};
    const Study study = simulate(random, 8, false);
    const Population p = estimate_population(values(study), study.data.random[0].level);
    const Forecast one = forecast(p, 1, options);
    one_cut += holds(one.outside.interval, outside(kMean, sd));
    alignment +=
        holds(forecast(p, 2, options).outside.interval, outside(2.0 * kMean, std::sqrt(2.0) * sd));
    const auto content = [&](const Interval& i, double mean, double spread) {
      return 1.0 - upper((i.high - mean) / spread) - upper((mean - i.low) / spread);
    };
    tolerance += content(one.tolerance, kMean, sd) >= 0.95;
    std::vector<double> cuts(25);
    for (double& cut : cuts) cut = random.normal(kMean, kCutSd);
    const Forecast own = forecast(estimate_population(cuts, {}), 1, options);
    plain += holds(own.outside.interval, outside(kMean, kCutSd));
    plain_tolerance += content(own.tolerance, kMean, kCutSd) >= 0.95;
  }
  for (const int held : {one_cut, alignment, tolerance, plain, plain_tolerance}) {
    expect_nominal(held);
  }
}

enum class Shape { kNormal, kUniform, kExponential, kLaplace, kStudent5, kGamma4 };

/// Mean 0, SD 1.
double draw(Random& random, Shape shape) {
  switch (shape) {
    case Shape::kNormal:
      break;
    case Shape::kUniform:
      return (random.uniform() - 0.5) * std::sqrt(12.0);
    case Shape::kExponential:
      return -std::log(random.uniform()) - 1.0;
    case Shape::kStudent5: {
      double chi_squared = 0.0;
      for (int i = 0; i < 5; ++i) chi_squared += std::pow(random.normal(), 2);
      return random.normal() * std::sqrt(3.0 / chi_squared);
    }
    case Shape::kGamma4: {  // skewness 1
      double sum = 0.0;
      for (int i = 0; i < 4; ++i) sum -= std::log(random.uniform());
      return 0.5 * (sum - 4.0);
    }
    case Shape::kLaplace:
      return std::copysign(std::log(random.uniform()) / std::sqrt(2.0), random.uniform() - 0.5);
  }
  return random.normal();
}

struct Coverage {
  int bootstrap_sd = 0, bootstrap_mean = 0, chi_squared = 0;
};
Coverage coverage(Shape shape, int n) {
  Coverage held;
  for (int r = 0; r < kRepetitions; ++r) {
    Random random(kSeed + 4, r);
    std::vector<double> y(n);
    std::vector<int> cell(n);
    for (int i = 0; i < n; ++i) {
      y[i] = draw(random, shape);
      cell[i] = i % 3;
    }
    held.bootstrap_sd += holds(bootstrap_sd_interval(y, cell, r, 299), 1.0);
    held.bootstrap_mean += holds(bootstrap_mean_interval(y, r, 299), 0.0);
    const Moments m = pooled_within(y, cell);
    held.chi_squared += holds(sd_interval(m.sd, m.degrees_of_freedom), 1.0);
  }
  return held;
}

TEST(SimulatedStudy, BootstrapIntervalsHoldTheTruthForNormalAndShortTails) {
  for (const Shape shape : {Shape::kNormal, Shape::kUniform}) {
    const Coverage held = coverage(shape, 60);
    expect_nominal(held.bootstrap_sd);
    expect_nominal(held.bootstrap_mean);
  }
}

// What the interval of an SD claims: 93 to 97 % for these shapes, cuts in three cells.
TEST(SimulatedStudy, KurtosisAdjustedIntervalsOfAnSdHoldTheTruthForLongTailsAndSkewness) {
  for (const int n : {30, 60, 99}) {
    for (const Shape shape : {Shape::kNormal, Shape::kUniform, Shape::kLaplace, Shape::kGamma4}) {
      SCOPED_TRACE(testing::Message() << "shape " << static_cast<int>(shape) << ", n " << n);
      expect_nominal(coverage(shape, n).bootstrap_sd);
    }
  }
}

// Beyond the claim: Student's t with 5 df, whose sample kurtosis has no finite variance, holds at
// 93.0 to 93.2 %, the exponential at 92.0 % with 30 cuts (2 000 repetitions): less three sigma of
// the count, 89.4 %. The guide prints these numbers.
TEST(SimulatedStudy, IntervalsOfAnSdAreNearerThanChiSquaredForTheLongestTails) {
  for (const int n : {30, 60, 99}) {
    for (const Shape shape : {Shape::kExponential, Shape::kStudent5}) {
      const Coverage held = coverage(shape, n);
      EXPECT_GT(held.bootstrap_sd, 0.894 * kRepetitions);
      EXPECT_GT(held.bootstrap_sd, held.chi_squared);
    }
  }
}

TEST(SimulatedStudy, BootstrapIntervalsOfTheMeanStayUsableForLongTails) {
  for (const Shape shape : {Shape::kExponential, Shape::kLaplace}) {
    EXPECT_GT(coverage(shape, 60).bootstrap_mean, 0.91 * kRepetitions);
  }
}

}  // namespace
}  // namespace osteomill::study
