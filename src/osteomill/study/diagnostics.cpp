// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/study/diagnostics.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <numbers>
#include <numeric>

#include "osteomill/base/error.hpp"
#include "osteomill/base/random.hpp"
#include "osteomill/numerics/distributions.hpp"

namespace osteomill::study {
namespace {

double polynomial(std::initializer_list<double> coefficients, double x) {
  double value = 0.0;
  for (auto c = std::rbegin(coefficients); c != std::rend(coefficients); ++c) {
    value = value * x + *c;
  }
  return value;
}

Interval percentiles(std::vector<double> sample, double confidence) {
  std::sort(sample.begin(), sample.end());
  const double tail = 0.5 * (1.0 - confidence);
  const auto at = [&](double p) {
    return sample[static_cast<size_t>(p * static_cast<double>(sample.size() - 1) + 0.5)];
  };
  return {at(tail), at(1.0 - tail)};
}

struct LogVariance {
  double value = 0.0;
  double standard_error = 0.0;
};

/// Log of the pooled variance and its standard error: Var(log s2) = (kurtosis - 1 + 2/df) / n.
LogVariance log_variance(std::span<const double> values, std::span<const int> cell,
                         std::vector<double>& sum, std::vector<int>& count) {
  std::fill(sum.begin(), sum.end(), 0.0);
  std::fill(count.begin(), count.end(), 0);
  for (size_t i = 0; i < values.size(); ++i) {
    sum[cell[i]] += values[i];
    ++count[cell[i]];
  }
  double second = 0.0, fourth = 0.0, n = 0.0, df = 0.0;
  for (size_t i = 0; i < values.size(); ++i) {
    const int k = count[cell[i]];
    if (k < 2) continue;
    const double r = values[i] - sum[cell[i]] / k;
    second += r * r;
    // Residuals are small by (k-1)/k in variance: scaled back before the fourth power.
    const double scaled = r * r * k / (k - 1.0);
    fourth += scaled * scaled;
    n += 1.0;
    df += (k - 1.0) / k;
  }
  const double variance = second / df;
  const double kurtosis = std::max(1.05, fourth / n / (variance * variance));
  return {std::log(variance), std::sqrt((kurtosis - 1.0 + 2.0 / df) / df)};
}

/// Sums of squares and fourth powers about the centres of cells of two values or more.
struct Powers {
  double count = 0.0, cells = 0.0, second = 0.0, fourth_mean = 0.0, fourth_median = 0.0;
};

/// Cell after cell, of these sizes; values are sorted within their cells.
Powers powers_within(std::span<double> values, std::span<const size_t> sizes) {
  Powers sums;
  size_t first = 0;
  for (const size_t size : sizes) {
    const std::span<double> part = values.subspan(first, size);
    first += size;
    std::sort(part.begin(), part.end());
    const double median = 0.5 * (part[(size - 1) / 2] + part[size / 2]);
    const double k = static_cast<double>(size);
    const double mean = std::accumulate(part.begin(), part.end(), 0.0) / k;
    for (const double value : part) {
      const double about_mean = (value - mean) * (value - mean);
      const double about_median = (value - median) * (value - median);
      sums.second += about_mean;
      sums.fourth_mean += about_mean * about_mean;
      sums.fourth_median += about_median * about_median;
    }
    sums.count += k;
    sums.cells += 1.0;
  }
  return sums;
}

/// Bonett's ln(c s2) (2006), pooled over cells, and its standard error, with the excess kurtosis
/// freed of its small-sample bias (G2). Fourth powers are taken about the cells' medians where the
/// excess about the means is positive: about the mean, or a trimmed one, long tails look shorter
/// than they are; about the median, short ones look longer.
struct AdjustedLogVariance {
  double value = 0.0;
  double standard_error = 0.0;
  double widening = 1.0;  ///< c
  double degrees_of_freedom = 0.0;
};

AdjustedLogVariance adjusted_log_variance(std::span<double> values, std::span<const size_t> sizes,
                                          double confidence) {
  const Powers sums = powers_within(values, sizes);
  const double n = sums.count, df = n - sums.cells;
  const auto excess = [&](double fourth) {
    const double g2 = n * fourth / (sums.second * sums.second) - 3.0;
    return (n - 1.0) / ((n - 2.0) * (n - 3.0)) * ((n + 1.0) * g2 + 6.0);
  };
  const double about_means = excess(sums.fourth_mean);
  const double kurtosis = about_means > 0.0 ? excess(sums.fourth_median) : about_means;
  const double c = n / std::max(1.0, n - numerics::normal_quantile(0.5 + 0.5 * confidence));
  // Two equal heaps have the least kurtosis there is; sampling error stays above a tenth of normal.
  const double variance = std::max(kurtosis / n + 2.0 / df, 0.2 / df);
  return {std::log(c * sums.second / df), std::sqrt(variance), c, df};
}

/// What (ln(c s2) - ln sigma2) / standard error exceeds in half of 1 - confidence of normal samples
/// in cells of these sizes.
double upper_normal_pivot(std::span<const size_t> sizes, Random& random, int draws,
                          double confidence) {
  std::vector<double> sample(std::accumulate(sizes.begin(), sizes.end(), size_t{0})), pivot;
  for (int b = 0; b < draws; ++b) {
    for (double& value : sample) value = random.normal();
    const AdjustedLogVariance drawn = adjusted_log_variance(sample, sizes, confidence);
    pivot.push_back(drawn.value / drawn.standard_error);
  }
  return percentiles(std::move(pivot), confidence).high;
}

}  // namespace

DiagnosticTest shapiro_wilk(std::span<const double> values) {
  const int n = static_cast<int>(values.size());
  if (n < 3 || n > 5000) {
    throw InvalidInput(
        Fault{"Shapiro-Wilk test", fmt::format("{} values", n), "needs 3 to 5000 values", ""});
  }
  std::vector<double> x(values.begin(), values.end());
  std::sort(x.begin(), x.end());
  if (!(x.back() > x.front())) {
    throw InvalidInput(
        Fault{"Shapiro-Wilk test", "all values alike", "needs values that vary", ""});
  }
  // Weights a of the ordered sample, antisymmetric.
  std::vector<double> m(n), a(n, 0.0);
  for (int i = 0; i < n; ++i) m[i] = numerics::normal_quantile((i + 1 - 0.375) / (n + 0.25));
  const double norm2 = std::inner_product(m.begin(), m.end(), m.begin(), 0.0);
  const double u = 1.0 / std::sqrt(static_cast<double>(n));
  if (n == 3) {
    a = {-std::numbers::sqrt2 / 2.0, 0.0, std::numbers::sqrt2 / 2.0};
  } else {
    const double last = m[n - 1] / std::sqrt(norm2) +
                        polynomial({0.0, 0.221157, -0.147981, -2.07119, 4.434685, -2.706056}, u);
    const int ends = n > 5 ? 2 : 1;
    double rest = norm2 - 2.0 * m[n - 1] * m[n - 1];
    double left = 1.0 - 2.0 * last * last;
    if (ends == 2) {
      const double second =
          m[n - 2] / std::sqrt(norm2) +
          polynomial({0.0, 0.042981, -0.293762, -1.752461, 5.682633, -3.582633}, u);
      rest -= 2.0 * m[n - 2] * m[n - 2];
      left -= 2.0 * second * second;
      a[n - 2] = second;
      a[1] = -second;
    }
    a[n - 1] = last;
    a[0] = -last;
    const double scale = std::sqrt(rest / left);
    for (int i = ends; i < n - ends; ++i) a[i] = m[i] / scale;
  }
  const double mean = std::accumulate(x.begin(), x.end(), 0.0) / n;
  double numerator = 0.0, denominator = 0.0;
  for (int i = 0; i < n; ++i) {
    numerator += a[i] * (x[i] - mean);
    denominator += (x[i] - mean) * (x[i] - mean);
  }
  DiagnosticTest test;
  test.statistic = std::min(1.0, numerator * numerator / denominator);
  const double w = test.statistic;
  if (n == 3) {
    const double p =
        6.0 / std::numbers::pi * (std::asin(std::sqrt(w)) - std::asin(std::sqrt(0.75)));
    test.p = std::clamp(p, 0.0, 1.0);
    return test;
  }
  double z = std::log1p(-w), centre = 0.0, spread = 1.0;
  if (n <= 11) {
    const double gamma = polynomial({-2.273, 0.459}, n);
    if (z >= gamma) {
      test.p = 1e-99;
      return test;
    }
    z = -std::log(gamma - z);
    centre = polynomial({0.544, -0.39978, 0.025054, -6.714e-4}, n);
    spread = std::exp(polynomial({1.3822, -0.77857, 0.062767, -0.0020322}, n));
  } else {
    const double l = std::log(static_cast<double>(n));
    centre = polynomial({-1.5861, -0.31082, -0.083751, 0.0038915}, l);
    spread = std::exp(polynomial({-0.4803, -0.082676, 0.0030302}, l));
  }
  test.p = numerics::normal_cdf(-(z - centre) / spread);
  return test;
}

DiagnosticTest brown_forsythe(std::span<const double> values, std::span<const int> group) {
  const int groups = values.empty() ? 0 : 1 + *std::max_element(group.begin(), group.end());
  std::vector<std::vector<double>> parts(groups);
  for (size_t i = 0; i < values.size(); ++i) parts[group[i]].push_back(values[i]);
  std::erase_if(parts, [](const std::vector<double>& part) { return part.empty(); });
  double n = 0.0, all = 0.0, within = 0.0, between = 0.0;
  std::vector<double> mean(parts.size());
  for (size_t g = 0; g < parts.size(); ++g) {
    std::vector<double>& part = parts[g];
    std::sort(part.begin(), part.end());
    const size_t half = part.size() / 2;
    const double median = part.size() % 2 == 1 ? part[half] : 0.5 * (part[half - 1] + part[half]);
    for (double& value : part) value = std::abs(value - median);
    const double sum = std::accumulate(part.begin(), part.end(), 0.0);
    mean[g] = sum / static_cast<double>(part.size());
    for (const double value : part) within += (value - mean[g]) * (value - mean[g]);
    n += static_cast<double>(part.size());
    all += sum;
  }
  const double k = static_cast<double>(parts.size());
  if (parts.size() < 2 || n - k < 1.0 || !(within > 0.0)) {
    throw InvalidInput(Fault{"Brown-Forsythe test", fmt::format("{} group(s)", parts.size()),
                             "needs two groups or more, with values that vary", ""});
  }
  for (size_t g = 0; g < parts.size(); ++g) {
    between += static_cast<double>(parts[g].size()) * (mean[g] - all / n) * (mean[g] - all / n);
  }
  DiagnosticTest test{between / (k - 1.0) / (within / (n - k)), k - 1.0, n - k, 1.0};
  test.p = numerics::f_upper_tail(test.statistic, test.df1, test.df2);
  return test;
}

Interval bootstrap_sd_interval(std::span<const double> values, std::span<const int> cell,
                               std::uint64_t seed, int draws, double confidence) {
  const int cells = values.empty() ? 0 : 1 + *std::max_element(cell.begin(), cell.end());
  std::vector<double> sum(cells);
  std::vector<int> count(cells);
  const LogVariance observed = log_variance(values, cell, sum, count);
  std::vector<double> residuals, drawn;
  std::vector<int> kept;
  for (size_t i = 0; i < values.size(); ++i) {
    const int k = count[cell[i]];
    if (k < 2) continue;
    kept.push_back(cell[i]);
    residuals.push_back((values[i] - sum[cell[i]] / k) * std::sqrt(k / (k - 1.0)));
  }
  if (residuals.size() < 5 || !std::isfinite(observed.value)) {
    throw InvalidInput(Fault{"bootstrap of the SD", fmt::format("{} cuts", residuals.size()),
                             "needs five or more that vary, in cells of two or more", "add cuts"});
  }
  Random random(seed);
  drawn.resize(residuals.size());
  std::vector<double> t;
  t.reserve(draws);
  const double n = static_cast<double>(residuals.size());
  for (int b = 0; b < draws; ++b) {
    for (double& value : drawn) value = residuals[static_cast<size_t>(random.uniform() * n)];
    const LogVariance sample = log_variance(drawn, kept, sum, count);
    if (!std::isfinite(sample.value)) continue;  // one value drawn throughout
    t.push_back((sample.value - observed.value) / sample.standard_error);
  }
  const double raised =
      observed.value - percentiles(std::move(t), confidence).low * observed.standard_error;
  std::vector<double> by_cell;
  std::vector<size_t> sizes;
  for (int c = 0; c < cells; ++c) {
    if (count[static_cast<size_t>(c)] < 2) continue;
    sizes.push_back(static_cast<size_t>(count[static_cast<size_t>(c)]));
    for (size_t i = 0; i < values.size(); ++i) {
      if (cell[i] == c) by_cell.push_back(values[i]);
    }
  }
  const AdjustedLogVariance adjusted = adjusted_log_variance(by_cell, sizes, confidence);
  const double student =
      adjusted.widening *
      numerics::student_t_quantile(0.5 + 0.5 * confidence, adjusted.degrees_of_freedom);
  // Long tails hardly ever miss by the lower end: it need be no wider than normal errors ask.
  const double below = std::min(student, upper_normal_pivot(sizes, random, draws, confidence));
  return {std::exp(0.5 * (adjusted.value - below * adjusted.standard_error)),
          std::exp(0.5 * std::max(adjusted.value + student * adjusted.standard_error, raised))};
}

std::vector<double> bootstrap_anova_p(const RepeatedMeasures& data, const Anova& anova,
                                      SumOfSquares type, std::uint64_t seed, int draws) {
  std::vector<double> reached(anova.rows.size(), 1.0);  // the observed one counts as a draw
  RepeatedMeasures sample = data;
  Random random(seed);
  const double subjects = static_cast<double>(data.y.rows());
  for (int b = 0; b < draws; ++b) {
    for (Eigen::Index i = 0; i < data.y.rows(); ++i) {
      sample.y.row(i) = anova.residuals.row(static_cast<Eigen::Index>(random.uniform() * subjects));
    }
    try {
      const Anova drawn = analyse_variance(sample, type);
      for (size_t r = 0; r < reached.size(); ++r) reached[r] += drawn.rows[r].f >= anova.rows[r].f;
    } catch (const InvalidInput&) {
      // One subject drawn throughout leaves no error to divide by: F is without bound.
      for (double& count : reached) count += 1.0;
    }
  }
  for (double& share : reached) share /= draws + 1.0;
  return reached;
}

}  // namespace osteomill::study
