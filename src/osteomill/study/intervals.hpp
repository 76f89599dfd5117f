// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

/// Intervals and two-sample tests of normal samples. A kernel of this room takes numbers in any one
/// unit and answers in the same unit; the unit stands in the name of the table's column.
namespace osteomill::study {

struct Interval {
  double low = 0.0;
  double high = 0.0;
};

/// Count, mean and SD of a sample. `degrees_of_freedom` belongs to the SD: n - 1, or n less the
/// number of means taken out.
struct Moments {
  int count = 0;
  double mean = 0.0;
  double sd = 0.0;
  double degrees_of_freedom = 0.0;
};

/// Needs two values or more; the sum of squares is taken about the mean.
Moments moments(std::span<const double> values);

/// Variability pooled over cells: residuals about the mean of each cell ("exclusive means" for each
/// operator, guide and cut), summed and divided by the cuts less one for each cell.
/// [plaskos2002] 2.2.3 and 3.3.3. `cell[i]` >= 0 names the cell of values[i]. Cells of one value
/// add nothing. degrees_of_freedom = 0 (and sd = 0) where no cell has two values; mean is that of
/// all.
Moments pooled_within(std::span<const double> values, std::span<const int> cell);

/// Interval of a standard deviation of a normal sample: sd sqrt(df / chi2). The theses use it.
Interval sd_interval(double sd, double degrees_of_freedom, double confidence = 0.95);

/// Fisher's interval of a squared correlation: z = ln((1+r)/(1-r))/2 is normal with variance
/// 1/(n-3), [plaskos2002] 2.2.3. Needs n > 3. An interval of r that holds zero gives low = 0.
/// (The intervals that the thesis prints are those of a standard deviation, not variance, of
/// 1/(n-3): far too narrow; see docs/theory/study.md.)
Interval r_squared_interval(double r, int n, double confidence = 0.95);

/// Alignment of an implant that rests on `cuts` independent cuts: sqrt(cuts) times the variability
/// of one, [plaskos2002] 2.4.
double combined_sd(double sd, int cuts = 2);

/// Half-width r with Phi(offset + r) - Phi(offset - r) = content.
double content_half_width(double offset, double content);

/// Two-sided factor k: mean +- k sd holds a share `content` of the population with the confidence.
/// Exact (Wald and Wolfowitz): n sets how well the mean is known, degrees_of_freedom the SD.
/// n need not be whole.
double tolerance_factor(double n, double degrees_of_freedom, double content, double confidence);

/// Test of a difference. For t the estimate is the difference of means and the interval is its;
/// for F the estimate is the ratio of variances.
struct TwoSampleTest {
  double statistic = 0.0;
  double df1 = 0.0;
  double df2 = 0.0;  ///< 0 for t
  double p = 1.0;    ///< two-sided
  double estimate = 0.0;
  Interval interval;
};

/// Ratio of two variances, a over b, two-sided. Sensitive to non-normal samples.
TwoSampleTest variance_ratio_test(const Moments& a, const Moments& b, double confidence = 0.95);
/// Difference of means a - b with one common SD.
TwoSampleTest pooled_t_test(const Moments& a, const Moments& b, double confidence = 0.95);
/// Difference of means a - b, SDs not taken as equal (Welch, Satterthwaite's degrees of freedom).
TwoSampleTest welch_t_test(const Moments& a, const Moments& b, double confidence = 0.95);
/// Mean against a value.
TwoSampleTest one_sample_t_test(const Moments& a, double value = 0.0, double confidence = 0.95);

/// The whole degrees of freedom for which sd_interval of some SD that rounds to the printed one
/// rounds to the printed ends. Empty where none does. A printed "0.4" is 0.4 with half_digit 0.05.
struct PrintedInterval {
  double sd = 0.0;
  double sd_half_digit = 0.0;  ///< half a unit of the last printed digit
  Interval interval;
  double half_digit = 0.0;
};
std::vector<int> degrees_of_freedom_implied(const PrintedInterval& printed,
                                            double confidence = 0.95, int at_most = 300);

/// p-values that keep the chance of any false alarm among the family (Holm 1979); order kept.
std::vector<double> holm(std::span<const double> p);

}  // namespace osteomill::study
