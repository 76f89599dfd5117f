// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/numerics/distributions.hpp"

#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/fisher_f.hpp>
#include <boost/math/distributions/non_central_f.hpp>
#include <boost/math/distributions/non_central_t.hpp>
#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>

namespace osteomill::numerics {
namespace bm = boost::math;

double normal_cdf(double z) { return bm::cdf(bm::normal(), z); }
double normal_quantile(double probability) { return bm::quantile(bm::normal(), probability); }

double student_t_cdf(double t, double degrees_of_freedom) {
  return bm::cdf(bm::students_t(degrees_of_freedom), t);
}
double student_t_quantile(double probability, double degrees_of_freedom) {
  return bm::quantile(bm::students_t(degrees_of_freedom), probability);
}
double student_t_two_sided_p(double t, double degrees_of_freedom) {
  return 2.0 * bm::cdf(bm::students_t(degrees_of_freedom), -std::abs(t));
}

double chi_squared_cdf(double x, double degrees_of_freedom) {
  return bm::cdf(bm::chi_squared(degrees_of_freedom), x);
}
double chi_squared_upper_tail(double x, double degrees_of_freedom) {
  return bm::cdf(bm::complement(bm::chi_squared(degrees_of_freedom), x));
}
double chi_squared_quantile(double probability, double degrees_of_freedom) {
  return bm::quantile(bm::chi_squared(degrees_of_freedom), probability);
}

double f_cdf(double f, double df1, double df2) { return bm::cdf(bm::fisher_f(df1, df2), f); }
double f_upper_tail(double f, double df1, double df2) {
  return bm::cdf(bm::complement(bm::fisher_f(df1, df2), f));
}
double f_quantile(double probability, double df1, double df2) {
  return bm::quantile(bm::fisher_f(df1, df2), probability);
}

double noncentral_t_cdf(double t, double degrees_of_freedom, double noncentrality) {
  return bm::cdf(bm::non_central_t(degrees_of_freedom, noncentrality), t);
}
double noncentral_f_cdf(double f, double df1, double df2, double noncentrality) {
  return bm::cdf(bm::non_central_f(df1, df2, noncentrality), f);
}

}  // namespace osteomill::numerics
