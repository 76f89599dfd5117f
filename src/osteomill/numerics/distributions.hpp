// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Probability distributions for tests and intervals, a thin door to Boost.Math. Degrees of freedom
/// are real numbers > 0 (Welch, Satterthwaite and Greenhouse-Geisser make fractions of them).
namespace osteomill::numerics {

double normal_cdf(double z);
double normal_quantile(double probability);

double student_t_cdf(double t, double degrees_of_freedom);
double student_t_quantile(double probability, double degrees_of_freedom);
/// P(|T| > |t|).
double student_t_two_sided_p(double t, double degrees_of_freedom);

double chi_squared_cdf(double x, double degrees_of_freedom);
double chi_squared_upper_tail(double x, double degrees_of_freedom);
double chi_squared_quantile(double probability, double degrees_of_freedom);

double f_cdf(double f, double df1, double df2);
double f_upper_tail(double f, double df1, double df2);
double f_quantile(double probability, double df1, double df2);

/// Noncentral distributions: the power of a t-test and of an analysis of variance.
double noncentral_t_cdf(double t, double degrees_of_freedom, double noncentrality);
double noncentral_f_cdf(double f, double df1, double df2, double noncentrality);

}  // namespace osteomill::numerics
