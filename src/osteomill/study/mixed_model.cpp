// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/study/mixed_model.hpp"

#include <algorithm>
#include <boost/math/tools/minima.hpp>
#include <cmath>
#include <functional>
#include <limits>
#include <nlopt.hpp>
#include <numbers>

#include "osteomill/base/error.hpp"
#include "osteomill/numerics/decompositions.hpp"
#include "osteomill/numerics/distributions.hpp"
#include "osteomill/study/component_intervals.hpp"

namespace osteomill::study {
namespace {

/// The criterion needs the data only through their products.
class Reml {
 public:
  explicit Reml(const MixedModelData& data)
      : n_(static_cast<double>(data.y.size())), p_(data.x.cols()) {
    Eigen::Index q = 0;
    for (const Factor& factor : data.random) {
      first_.push_back(q);
      q += static_cast<Eigen::Index>(factor.levels.size());
    }
    first_.push_back(q);
    Eigen::MatrixXd z = Eigen::MatrixXd::Zero(data.y.size(), q);
    for (size_t k = 0; k < data.random.size(); ++k) {
      for (Eigen::Index i = 0; i < data.y.size(); ++i) {
        z(i, first_[k] + data.random[k].level[i]) = 1.0;
      }
    }
    Eigen::MatrixXd xy(data.y.size(), p_ + 1);
    xy << data.x, data.y;
    zz_ = z.transpose() * z;
    zxy_ = z.transpose() * xy;
    xyxy_ = xy.transpose() * xy;
  }

  size_t terms() const { return first_.size() - 1; }

  /// Profiled over fixed effects. theta[k] = SD of factor k over that of the residual.
  struct Solution {
    double log_determinants = 0.0;  ///< log |V/s^2| + log |X' V^-1 X s^2|
    double quadratic = 0.0;         ///< r' (V/s^2)^-1 r
    Eigen::VectorXd beta;
    Eigen::MatrixXd unscaled_covariance;
  };
  Solution solve(const std::vector<double>& theta, bool coefficients = false) const {
    const Eigen::Index q = zz_.rows();
    Eigen::VectorXd scale(q);
    for (size_t k = 0; k < terms(); ++k) {
      scale.segment(first_[k], first_[k + 1] - first_[k]).setConstant(theta[k]);
    }
    Solution solution;
    Eigen::MatrixXd schur = xyxy_;
    if (q > 0) {
      Eigen::MatrixXd m = scale.asDiagonal() * zz_ * scale.asDiagonal();
      m.diagonal().array() += 1.0;
      const Eigen::LLT<Eigen::MatrixXd> llt(m);
      const Eigen::MatrixXd half = llt.matrixL().solve(scale.asDiagonal() * zxy_);
      schur -= half.transpose() * half;
      solution.log_determinants = 2.0 * llt.matrixLLT().diagonal().array().log().sum();
    }
    const Eigen::LLT<Eigen::MatrixXd> fixed(schur.topLeftCorner(p_, p_));
    const Eigen::VectorXd right = fixed.matrixL().solve(schur.topRightCorner(p_, 1));
    solution.log_determinants += 2.0 * fixed.matrixLLT().diagonal().array().log().sum();
    solution.quadratic =
        std::max(schur(p_, p_) - right.squaredNorm(), std::numeric_limits<double>::min());
    if (coefficients) {
      solution.beta = fixed.matrixU().solve(right);
      solution.unscaled_covariance = fixed.solve(Eigen::MatrixXd::Identity(p_, p_));
    }
    return solution;
  }

  double degrees_of_freedom() const { return n_ - static_cast<double>(p_); }

  /// -2 log restricted likelihood at given relative SDs, residual SD profiled out.
  double criterion(const std::vector<double>& theta) const {
    const Solution s = solve(theta);
    const double df = degrees_of_freedom();
    return s.log_determinants + df * (1.0 + std::log(2.0 * std::numbers::pi * s.quadratic / df));
  }

  /// The same at given SDs, the residual's last.
  double criterion_at(const std::vector<double>& sd) const {
    std::vector<double> theta(sd.begin(), sd.end() - 1);
    for (double& t : theta) t /= sd.back();
    const Solution s = solve(theta);
    const double variance = sd.back() * sd.back();
    return s.log_determinants + s.quadratic / variance +
           degrees_of_freedom() * std::log(2.0 * std::numbers::pi * variance);
  }

  /// Covariance of the fixed effects at given SDs.
  Eigen::MatrixXd beta_covariance(const std::vector<double>& sd) const {
    std::vector<double> theta(sd.begin(), sd.end() - 1);
    for (double& t : theta) t /= sd.back();
    return solve(theta, true).unscaled_covariance * (sd.back() * sd.back());
  }

 private:
  double n_;
  Eigen::Index p_;
  std::vector<Eigen::Index> first_;
  Eigen::MatrixXd zz_, zxy_, xyxy_;
};

struct Minimum {
  std::vector<double> at;
  double value = 0.0;
  int evaluations = 0;
  bool converged = true;
};

using Objective = std::function<double(const std::vector<double>&)>;

/// A criterion this close to the least is the least: rounding, and no likelihood ratio sees it.
constexpr double kFlat = 1e-9;

/// Least value over low <= x <= high: Brent in one dimension, BOBYQA in more.
Minimum minimise(const Objective& f, std::vector<double> start, double low, double high) {
  Minimum m;
  if (start.empty()) {
    m.value = f(start);
    m.evaluations = 1;
    return m;
  }
  if (start.size() == 1) {
    std::uintmax_t iterations = 200;
    const auto g = [&](double x) { return f({x}); };
    // Half the digits: below, the criterion is flat to rounding.
    const auto [x, value] = boost::math::tools::brent_find_minima(
        g, low, std::min(high, 4.0 * start[0] + 1.0), 26, iterations);
    m = {{x}, value, static_cast<int>(iterations), iterations < 200};
    if (const double edge = g(low); edge <= m.value + kFlat)
      m = {{low}, edge, m.evaluations + 1, true};
    return m;
  }
  struct Counted {
    const Objective* f;
    int count = 0;
  } counted{&f};
  nlopt::opt opt(nlopt::LN_BOBYQA, static_cast<unsigned>(start.size()));
  opt.set_min_objective(
      [](const std::vector<double>& x, std::vector<double>&, void* data) {
        auto* c = static_cast<Counted*>(data);
        ++c->count;
        return (*c->f)(x);
      },
      &counted);
  opt.set_lower_bounds(low);
  opt.set_upper_bounds(high);
  opt.set_xtol_rel(1e-7);
  opt.set_xtol_abs(1e-8);
  opt.set_ftol_rel(1e-13);
  opt.set_maxeval(2000);
  for (double& x : start) x = std::clamp(x, low, high);
  try {
    opt.optimize(start, m.value);
  } catch (const nlopt::roundoff_limited&) {
    m.value = f(start);  // as good as the arithmetic allows
  }
  m.evaluations = counted.count;
  m.converged = counted.count < 2000;
  m.at = start;
  // A bound is reached exactly or not at all.
  for (double& x : m.at) {
    const double kept = x;
    x = low;
    if (const double edge = f(m.at); edge <= m.value + kFlat) {
      m.value = edge;
    } else {
      x = kept;
    }
  }
  return m;
}

/// Covariance of the variances (not SDs): twice the inverse of the criterion's Hessian,
/// numerically. Components at zero are taken as known.
Eigen::MatrixXd variance_covariance(const Reml& reml, const std::vector<double>& sd,
                                    std::vector<size_t>& free) {
  free.clear();
  for (size_t k = 0; k < sd.size(); ++k) {
    if (sd[k] > 1e-4 * sd.back()) free.push_back(k);
  }
  const auto at = [&](size_t a, double da, size_t b, double db) {
    std::vector<double> moved = sd;
    moved[a] = std::sqrt(moved[a] * moved[a] * (1.0 + da));
    moved[b] = std::sqrt(moved[b] * moved[b] * (1.0 + db));
    return reml.criterion_at(moved);
  };
  // Fourth root of the arithmetic's precision balances truncation and rounding in a second
  // difference.
  constexpr double h = 1e-3;
  const Eigen::Index m = static_cast<Eigen::Index>(free.size());
  Eigen::MatrixXd hessian(m, m);
  const double centre = reml.criterion_at(sd);
  for (Eigen::Index i = 0; i < m; ++i) {
    for (Eigen::Index j = 0; j <= i; ++j) {
      const size_t a = free[i], b = free[j];
      const double scale = sd[a] * sd[a] * sd[b] * sd[b] * h * h;
      hessian(i, j) = hessian(j, i) =
          i == j ? (at(a, h, a, 0) - 2.0 * centre + at(a, -h, a, 0)) / scale
                 : (at(a, h, b, h) - at(a, h, b, -h) - at(a, -h, b, h) + at(a, -h, b, -h)) /
                       (4.0 * scale);
    }
  }
  return 2.0 * hessian.inverse();
}

std::vector<double> standard_deviations(const MixedModel& fit) {
  std::vector<double> sd;
  for (const VarianceComponent& component : fit.components) sd.push_back(component.sd);
  return sd;
}

/// Degrees of freedom of single contrasts, from how their variance changes with the components.
class Satterthwaite {
 public:
  Satterthwaite(const MixedModelData& data, const MixedModel& fit) {
    const Reml reml(data);
    const std::vector<double> sd = standard_deviations(fit);
    std::vector<size_t> free;
    covariance_ = variance_covariance(reml, sd, free);
    constexpr double h = 1e-4;
    for (const size_t k : free) {
      std::vector<double> up = sd, down = sd;
      up[k] *= std::sqrt(1.0 + h);
      down[k] *= std::sqrt(1.0 - h);
      gradient_.push_back((reml.beta_covariance(up) - reml.beta_covariance(down)) /
                          (2.0 * h * sd[k] * sd[k]));
    }
    most_ = reml.degrees_of_freedom();
  }

  double degrees_of_freedom(const Eigen::RowVectorXd& contrast, double variance) const {
    Eigen::VectorXd g(static_cast<Eigen::Index>(gradient_.size()));
    for (Eigen::Index k = 0; k < g.size(); ++k) {
      g(k) = contrast * gradient_[static_cast<size_t>(k)] * contrast.transpose();
    }
    return 2.0 * variance * variance / (g.transpose() * covariance_ * g).value();
  }

  double most() const { return most_; }

 private:
  Eigen::MatrixXd covariance_;             ///< of the variances
  std::vector<Eigen::MatrixXd> gradient_;  ///< of the coefficients' covariance, by variance
  double most_ = 0.0;
};

}  // namespace

MixedModel fit_mixed_model(const MixedModelData& data, const MixedModelOptions& options) {
  if (data.y.size() <= data.x.cols() + 1) {
    throw InvalidInput(Fault{"mixed model", std::to_string(data.y.size()) + " rows",
                             "needs more rows than fixed effects", "add cuts"});
  }
  const Reml reml(data);
  MixedModel fit;
  const Minimum best =
      minimise([&](const std::vector<double>& theta) { return reml.criterion(theta); },
               std::vector<double>(reml.terms(), 1.0), 0.0, 1e4);
  fit.converged = best.converged;
  fit.reason = best.converged ? "converged" : "no convergence in 2000 evaluations";
  fit.evaluations = best.evaluations;
  fit.criterion = best.value;
  const Reml::Solution solution = reml.solve(best.at, true);
  const double residual_variance = solution.quadratic / reml.degrees_of_freedom();
  fit.beta = solution.beta;
  fit.beta_covariance = solution.unscaled_covariance * residual_variance;

  std::vector<double> sd;
  for (const double theta : best.at) sd.push_back(theta * std::sqrt(residual_variance));
  sd.push_back(std::sqrt(residual_variance));
  double total = 0.0;
  for (const double s : sd) total += s * s;
  fit.total_sd = std::sqrt(total);
  std::vector<Interval> intervals;
  if (options.intervals) {
    intervals = component_intervals(
        data, {.confidence = options.confidence, .seed = options.seed, .draws = options.draws});
  }
  for (size_t k = 0; k < sd.size(); ++k) {
    VarianceComponent component{
        .name = k < data.random.size() ? data.random[k].name : std::string("residual"),
        .sd = sd[k],
        .sd_interval = {},
        .share = sd[k] * sd[k] / total,
        .at_zero = sd[k] <= 1e-4 * sd.back()};
    if (options.intervals) component.sd_interval = intervals[k];
    fit.components.push_back(std::move(component));
  }
  std::vector<size_t> free;
  const Eigen::MatrixXd covariance = variance_covariance(reml, sd, free);
  const double variance_of_total = covariance.sum();
  fit.total_degrees_of_freedom =
      variance_of_total > 0.0 ? 2.0 * total * total / variance_of_total : reml.degrees_of_freedom();
  fit.total_degrees_of_freedom =
      std::clamp(fit.total_degrees_of_freedom, 1.0, reml.degrees_of_freedom());
  return fit;
}

MixedModelTest test_fixed_effect(const MixedModelData& data, const MixedModel& fit,
                                 const Eigen::MatrixXd& contrast) {
  const Satterthwaite satterthwaite(data, fit);
  // Independent single contrasts, by the eigenvectors of the tested covariance.
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(contrast * fit.beta_covariance *
                                                             contrast.transpose());
  const Eigen::MatrixXd rows = eigen.eigenvectors().transpose() * contrast;
  MixedModelTest test;
  test.df1 = static_cast<double>(contrast.rows());
  double expected = 0.0;  // sum of the means of the squared t's
  bool finite = true;
  double single = 0.0;
  for (Eigen::Index i = 0; i < rows.rows(); ++i) {
    const double variance = eigen.eigenvalues()(i);
    const double estimate = rows.row(i).dot(fit.beta);
    test.f += estimate * estimate / variance / test.df1;
    const double df = satterthwaite.degrees_of_freedom(rows.row(i), variance);
    single = df;
    if (df > 2.0) {
      expected += df / (df - 2.0);
    } else {
      finite = false;
    }
  }
  if (test.df1 == 1.0) {
    test.df2 = single;
  } else {
    test.df2 = finite && expected > test.df1 ? 2.0 * expected / (expected - test.df1) : 2.0;
  }
  test.df2 = std::clamp(test.df2, 1.0, satterthwaite.most());
  test.p = numerics::f_upper_tail(test.f, test.df1, test.df2);
  return test;
}

MixedModelEstimate estimate_contrast(const MixedModelData& data, const MixedModel& fit,
                                     const Eigen::RowVectorXd& contrast, double confidence) {
  const Satterthwaite satterthwaite(data, fit);
  const double variance = (contrast * fit.beta_covariance * contrast.transpose()).value();
  MixedModelEstimate estimate;
  estimate.value = contrast.dot(fit.beta);
  estimate.standard_error = std::sqrt(variance);
  estimate.degrees_of_freedom =
      std::clamp(satterthwaite.degrees_of_freedom(contrast, variance), 1.0, satterthwaite.most());
  estimate.p = numerics::student_t_two_sided_p(estimate.value / estimate.standard_error,
                                               estimate.degrees_of_freedom);
  const double half =
      estimate.standard_error *
      numerics::student_t_quantile(0.5 + 0.5 * confidence, estimate.degrees_of_freedom);
  estimate.interval = {estimate.value - half, estimate.value + half};
  return estimate;
}

}  // namespace osteomill::study
