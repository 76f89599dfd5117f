// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/study/intervals.hpp"

#include <algorithm>
#include <array>
#include <boost/math/tools/toms748_solve.hpp>
#include <cmath>
#include <numbers>
#include <numeric>

#include "osteomill/base/error.hpp"
#include "osteomill/numerics/distributions.hpp"

namespace osteomill::study {
namespace {

double require_confidence(double confidence) {
  if (!(confidence > 0.0 && confidence < 1.0)) {
    throw InvalidInput(Fault{"confidence", std::to_string(confidence), "must lie between 0 and 1",
                             "0.95 is usual"});
  }
  return confidence;
}

double normal_upper_tail(double z) { return 0.5 * std::erfc(z / std::numbers::sqrt2); }

TwoSampleTest t_test(double difference, double standard_error, double df, double confidence) {
  require_positive("standard error of the difference", standard_error, "");
  TwoSampleTest test;
  test.estimate = difference;
  test.statistic = difference / standard_error;
  test.df1 = df;
  test.p = numerics::student_t_two_sided_p(test.statistic, df);
  const double half =
      standard_error * numerics::student_t_quantile(0.5 + 0.5 * require_confidence(confidence), df);
  test.interval = {difference - half, difference + half};
  return test;
}

}  // namespace

Moments moments(std::span<const double> values) {
  if (values.size() < 2) {
    throw InvalidInput(Fault{"sample", std::to_string(values.size()) + " value(s)",
                             "needs two or more", "add cuts"});
  }
  const double n = static_cast<double>(values.size());
  Moments m;
  m.count = static_cast<int>(values.size());
  m.mean = std::accumulate(values.begin(), values.end(), 0.0) / n;
  double squares = 0.0;
  for (const double value : values) squares += (value - m.mean) * (value - m.mean);
  m.degrees_of_freedom = n - 1.0;
  m.sd = std::sqrt(squares / m.degrees_of_freedom);
  return m;
}

Moments pooled_within(std::span<const double> values, std::span<const int> cell) {
  Moments m;
  m.count = static_cast<int>(values.size());
  if (values.empty()) return m;
  const int cells = 1 + *std::max_element(cell.begin(), cell.end());
  std::vector<double> sum(cells, 0.0);
  std::vector<int> count(cells, 0);
  for (size_t i = 0; i < values.size(); ++i) {
    sum[cell[i]] += values[i];
    ++count[cell[i]];
  }
  m.mean = std::accumulate(values.begin(), values.end(), 0.0) / m.count;
  double squares = 0.0;
  for (size_t i = 0; i < values.size(); ++i) {
    const double residual = values[i] - sum[cell[i]] / count[cell[i]];
    squares += residual * residual;
  }
  for (const int n : count) m.degrees_of_freedom += std::max(0, n - 1);
  m.sd = m.degrees_of_freedom > 0.0 ? std::sqrt(squares / m.degrees_of_freedom) : 0.0;
  return m;
}

Interval sd_interval(double sd, double degrees_of_freedom, double confidence) {
  require_non_negative("sd", sd, "");
  require_positive("degrees of freedom", degrees_of_freedom, "");
  const double tail = 0.5 * (1.0 - require_confidence(confidence));
  return {sd * std::sqrt(degrees_of_freedom /
                         numerics::chi_squared_quantile(1.0 - tail, degrees_of_freedom)),
          sd * std::sqrt(degrees_of_freedom /
                         numerics::chi_squared_quantile(tail, degrees_of_freedom))};
}

Interval r_squared_interval(double r, int n, double confidence) {
  if (n <= 3) {
    throw InvalidInput(Fault{"n", std::to_string(n), "the interval of r needs n > 3", "add cuts"});
  }
  require_within("r", r, -1.0, 1.0, "");
  const double z = std::atanh(r);
  const double half =
      numerics::normal_quantile(0.5 + 0.5 * require_confidence(confidence)) / std::sqrt(n - 3.0);
  const double low = std::tanh(z - half), high = std::tanh(z + half);
  const double largest = std::max(low * low, high * high);
  return {low * high <= 0.0 ? 0.0 : std::min(low * low, high * high), largest};
}

double combined_sd(double sd, int cuts) { return std::sqrt(static_cast<double>(cuts)) * sd; }

double content_half_width(double offset, double content) {
  double low = 0.0, high = std::abs(offset) + 40.0;
  for (int i = 0; i < 200 && high - low > 1e-14 * high; ++i) {
    const double middle = 0.5 * (low + high);
    const double inside = normal_upper_tail(offset - middle) - normal_upper_tail(offset + middle);
    (inside < content ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

double tolerance_factor(double n, double degrees_of_freedom, double content, double confidence) {
  require_positive("n", n, "");
  require_positive("degrees of freedom", degrees_of_freedom, "");
  require_confidence(content);
  require_confidence(confidence);
  // Confidence = E over the standard normal error z of the mean of P(chi2 > df (r(z/sqrt n)/k)^2).
  // The trapezoidal rule on 0...8.5 converges faster than any power for such an integrand: halving
  // the step changes nothing in ten digits.
  constexpr double kStep = 0.25;
  constexpr int kNodes = 35;
  std::array<double, kNodes> width{};
  for (int i = 0; i < kNodes; ++i) width[i] = content_half_width(kStep * i / std::sqrt(n), content);
  const auto excess = [&](double k) {
    double sum = 0.0;
    for (int i = 0; i < kNodes; ++i) {
      const double z = kStep * i, ratio = width[i] / k;
      const double weight = (i == 0 ? 1.0 : 2.0) * std::exp(-0.5 * z * z);
      sum += weight * numerics::chi_squared_upper_tail(degrees_of_freedom * ratio * ratio,
                                                       degrees_of_freedom);
    }
    return sum * kStep / std::sqrt(2.0 * std::numbers::pi) - confidence;
  };
  // Howe's approximation is within a few per cent.
  const double guess =
      width[0] * std::sqrt((1.0 + 1.0 / n) * degrees_of_freedom /
                           numerics::chi_squared_quantile(1.0 - confidence, degrees_of_freedom));
  std::uintmax_t iterations = 100;
  const auto [low, high] = boost::math::tools::bracket_and_solve_root(
      excess, guess, 1.2, true, boost::math::tools::eps_tolerance<double>(36), iterations);
  return 0.5 * (low + high);
}

TwoSampleTest variance_ratio_test(const Moments& a, const Moments& b, double confidence) {
  require_positive("sd", a.sd, "");
  require_positive("sd", b.sd, "");
  const double tail = 0.5 * (1.0 - require_confidence(confidence));
  const double df1 = a.degrees_of_freedom, df2 = b.degrees_of_freedom;
  TwoSampleTest test;
  test.statistic = test.estimate = (a.sd * a.sd) / (b.sd * b.sd);
  test.df1 = df1;
  test.df2 = df2;
  test.p = std::min(1.0, 2.0 * std::min(numerics::f_cdf(test.statistic, df1, df2),
                                        numerics::f_upper_tail(test.statistic, df1, df2)));
  test.interval = {test.estimate / numerics::f_quantile(1.0 - tail, df1, df2),
                   test.estimate / numerics::f_quantile(tail, df1, df2)};
  return test;
}

TwoSampleTest pooled_t_test(const Moments& a, const Moments& b, double confidence) {
  const double df = a.degrees_of_freedom + b.degrees_of_freedom;
  const double variance =
      (a.degrees_of_freedom * a.sd * a.sd + b.degrees_of_freedom * b.sd * b.sd) / df;
  return t_test(a.mean - b.mean, std::sqrt(variance * (1.0 / a.count + 1.0 / b.count)), df,
                confidence);
}

TwoSampleTest welch_t_test(const Moments& a, const Moments& b, double confidence) {
  const double va = a.sd * a.sd / a.count, vb = b.sd * b.sd / b.count;
  const double df =
      (va + vb) * (va + vb) / (va * va / a.degrees_of_freedom + vb * vb / b.degrees_of_freedom);
  return t_test(a.mean - b.mean, std::sqrt(va + vb), df, confidence);
}

TwoSampleTest one_sample_t_test(const Moments& a, double value, double confidence) {
  return t_test(a.mean - value, a.sd / std::sqrt(static_cast<double>(a.count)),
                a.degrees_of_freedom, confidence);
}

std::vector<int> degrees_of_freedom_implied(const PrintedInterval& printed, double confidence,
                                            int at_most) {
  std::vector<int> implied;
  for (int df = 1; df <= at_most; ++df) {
    const Interval unit = sd_interval(1.0, df, confidence);
    const double least = std::max({printed.sd - printed.sd_half_digit,
                                   (printed.interval.low - printed.half_digit) / unit.low,
                                   (printed.interval.high - printed.half_digit) / unit.high});
    const double most = std::min({printed.sd + printed.sd_half_digit,
                                  (printed.interval.low + printed.half_digit) / unit.low,
                                  (printed.interval.high + printed.half_digit) / unit.high});
    if (least <= most) implied.push_back(df);
  }
  return implied;
}

std::vector<double> holm(std::span<const double> p) {
  std::vector<size_t> order(p.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::sort(order.begin(), order.end(), [&](size_t a, size_t b) { return p[a] < p[b]; });
  std::vector<double> adjusted(p.size());
  double running = 0.0;
  for (size_t i = 0; i < order.size(); ++i) {
    running = std::max(running, std::min(1.0, static_cast<double>(order.size() - i) * p[order[i]]));
    adjusted[order[i]] = running;
  }
  return adjusted;
}

}  // namespace osteomill::study
