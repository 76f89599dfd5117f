// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/study/component_intervals.hpp"

#include <algorithm>
#include <boost/math/tools/toms748_solve.hpp>
#include <cmath>
#include <limits>
#include <optional>

#include "osteomill/base/random.hpp"
#include "osteomill/numerics/decompositions.hpp"
#include "osteomill/numerics/distributions.hpp"

namespace osteomill::study {
namespace {

/// What a study tells of its components: the part of y that random factors reach and fixed effects
/// do not, on an orthonormal basis, and the sum of squares that is left.
struct Contrasts {
  Eigen::VectorXd z;
  double rest = 0.0;
};

/// Variances of the components, the residual's last.
using Variances = Eigen::VectorXd;

/// A component that is held at a value.
struct Held {
  Eigen::Index component;
  double variance;
};

struct Fit {
  Variances at;
  double criterion = 0.0;  ///< -2 log restricted likelihood, up to a constant of the design
};

/// The restricted likelihood of a design: z ~ N(0, sum_k v_k A_k + v_e I), rest ~ v_e chi2.
class RestrictedLikelihood {
 public:
  explicit RestrictedLikelihood(const MixedModelData& data) {
    const Eigen::Index n = data.y.size();
    const Eigen::MatrixXd fixed = orthonormal(data.x);
    const auto without_fixed = [&](Eigen::MatrixXd m) {
      m -= fixed * (fixed.transpose() * m);
      return m;
    };
    std::vector<Eigen::MatrixXd> indicators;
    Eigen::Index q = 0;
    for (const Factor& factor : data.random) {
      Eigen::MatrixXd z = Eigen::MatrixXd::Zero(n, static_cast<Eigen::Index>(factor.levels.size()));
      for (Eigen::Index i = 0; i < n; ++i) z(i, factor.level[static_cast<size_t>(i)]) = 1.0;
      q += z.cols();
      indicators.push_back(std::move(z));
    }
    Eigen::MatrixXd all(n, q);
    Eigen::Index first = 0;
    for (const Eigen::MatrixXd& z : indicators) {
      all.middleCols(first, z.cols()) = z;
      first += z.cols();
    }
    const Eigen::MatrixXd basis = orthonormal(without_fixed(all));
    for (const Eigen::MatrixXd& z : indicators) {
      const Eigen::MatrixXd half = basis.transpose() * z;
      a_.emplace_back(half * half.transpose());
    }
    const Eigen::VectorXd y = without_fixed(data.y);
    observed_.z = basis.transpose() * y;
    observed_.rest = std::max(0.0, y.squaredNorm() - observed_.z.squaredNorm());
    rest_df_ = static_cast<double>(n - fixed.cols() - basis.cols());
    scale_ = y.squaredNorm() / static_cast<double>(n - fixed.cols());
    if (rest_df_ == 0.0) observed_.rest = 0.0;
  }

  const Contrasts& observed() const { return observed_; }
  Eigen::Index components() const { return static_cast<Eigen::Index>(a_.size()) + 1; }
  Eigen::Index dimension() const { return observed_.z.size(); }
  double rest_df() const { return rest_df_; }
  double scale() const { return scale_; }  ///< variance of y about the fixed effects

  Eigen::MatrixXd covariance(const Variances& v) const {
    Eigen::MatrixXd d = v(components() - 1) * Eigen::MatrixXd::Identity(dimension(), dimension());
    for (size_t k = 0; k < a_.size(); ++k) d += v(static_cast<Eigen::Index>(k)) * a_[k];
    return d;
  }

  /// Least criterion over variances >= 0 by Fisher's scoring, until a step promises no more than
  /// `precision`.
  Fit fit(const Contrasts& data, Variances start, const std::optional<Held>& held,
          double precision) const {
    const double floor = 1e-8 * scale_;
    Fit fit{std::move(start), 0.0};
    if (held) fit.at(held->component) = held->variance;
    fit.at(components() - 1) = std::max(fit.at(components() - 1), floor);
    Slope slope = slope_at(data, fit.at);
    fit.criterion = slope.criterion;
    constexpr int kSteps = 60;
    for (int i = 0; i < kSteps; ++i) {
      const Eigen::VectorXd step = bounded_step(slope, fit.at, held, floor);
      const double promised = -slope.gradient.dot(step);
      if (!(promised > precision)) break;
      double length = 1.0;
      Variances next;
      double value = 0.0;
      for (; length > 1e-6; length *= 0.5) {
        next = (fit.at + length * step).cwiseMax(0.0);
        value = criterion(data, next);
        if (value <= fit.criterion - 1e-4 * length * promised) break;
      }
      if (length <= 1e-6) break;
      fit.at = next;
      slope = slope_at(data, fit.at);
      fit.criterion = slope.criterion;
    }
    return fit;
  }

 private:
  struct Slope {
    double criterion = 0.0;
    Eigen::VectorXd gradient;
    Eigen::MatrixXd information;  ///< expected second derivatives of the criterion
  };

  static Eigen::MatrixXd orthonormal(const Eigen::MatrixXd& m) {
    if (m.cols() == 0) return m;
    Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr;
    qr.setThreshold(1e-9);
    qr.compute(m);
    return qr.householderQ() * Eigen::MatrixXd::Identity(m.rows(), qr.rank());
  }

  double criterion(const Contrasts& data, const Variances& v) const {
    const Eigen::LLT<Eigen::MatrixXd> llt(covariance(v));
    if (llt.info() != Eigen::Success) return std::numeric_limits<double>::infinity();
    const double residual = v(components() - 1);
    return 2.0 * llt.matrixLLT().diagonal().array().log().sum() +
           llt.matrixL().solve(data.z).squaredNorm() + rest_df_ * std::log(residual) +
           data.rest / residual;
  }

  Slope slope_at(const Contrasts& data, const Variances& v) const {
    const Eigen::Index last = components() - 1, r = dimension();
    const Eigen::LLT<Eigen::MatrixXd> llt(covariance(v));
    const Eigen::MatrixXd inverse = llt.solve(Eigen::MatrixXd::Identity(r, r));
    const Eigen::VectorXd w = inverse * data.z;
    const double e = v(last);
    Slope slope;
    slope.criterion = 2.0 * llt.matrixLLT().diagonal().array().log().sum() + data.z.dot(w) +
                      rest_df_ * std::log(e) + data.rest / e;
    slope.gradient.resize(last + 1);
    slope.information.resize(last + 1, last + 1);
    std::vector<Eigen::MatrixXd> product;
    for (const Eigen::MatrixXd& a : a_) product.emplace_back(inverse * a);
    product.push_back(inverse);
    for (Eigen::Index i = 0; i <= last; ++i) {
      const Eigen::MatrixXd& p = product[static_cast<size_t>(i)];
      const double square = i < last ? w.dot(a_[static_cast<size_t>(i)] * w) : w.squaredNorm();
      slope.gradient(i) = p.trace() - square;
      for (Eigen::Index j = 0; j <= i; ++j) {
        slope.information(i, j) = slope.information(j, i) =
            p.cwiseProduct(product[static_cast<size_t>(j)].transpose()).sum();
      }
    }
    slope.gradient(last) += rest_df_ / e - data.rest / (e * e);
    slope.information(last, last) += rest_df_ / (e * e);
    return slope;
  }

  /// Least value of the quadratic model over variances >= 0: what would become negative is put at
  /// its bound, one after the other.
  Eigen::VectorXd bounded_step(const Slope& slope, const Variances& at,
                               const std::optional<Held>& held, double floor) const {
    const Eigen::Index m = components();
    Eigen::VectorXd step = Eigen::VectorXd::Zero(m);
    std::vector<bool> is_free(static_cast<size_t>(m), true);
    if (held) is_free[static_cast<size_t>(held->component)] = false;
    const auto bound = [&](Eigen::Index k) { return k + 1 == m ? floor : 0.0; };
    for (;;) {
      std::vector<Eigen::Index> free;
      for (Eigen::Index k = 0; k < m; ++k) {
        if (is_free[static_cast<size_t>(k)]) free.push_back(k);
      }
      if (free.empty()) return step;
      Eigen::VectorXd fixed_part = step;
      for (const Eigen::Index k : free) fixed_part(k) = 0.0;
      const Eigen::VectorXd right = -(slope.gradient + slope.information * fixed_part);
      const Eigen::MatrixXd block = slope.information(free, free);
      const Eigen::VectorXd solved = block.ldlt().solve(right(free));
      Eigen::Index worst = -1;
      double most = 0.0;
      for (size_t i = 0; i < free.size(); ++i) {
        const Eigen::Index k = free[i];
        step(k) = solved(static_cast<Eigen::Index>(i));
        const double short_of = bound(k) - (at(k) + step(k));
        if (short_of > most) {
          most = short_of;
          worst = k;
        }
      }
      if (worst < 0) return step;
      step(worst) = bound(worst) - at(worst);
      is_free[static_cast<size_t>(worst)] = false;
    }
  }

  std::vector<Eigen::MatrixXd> a_;
  Contrasts observed_;
  double rest_df_ = 0.0;
  double scale_ = 0.0;
};

/// The test of one value of one component.
class ComponentTest {
 public:
  ComponentTest(const RestrictedLikelihood& likelihood, const ComponentIntervalOptions& options)
      : likelihood_(likelihood), confidence_(options.confidence) {
    // The same deviates for every value, so that the quantile changes with the value alone.
    normal_.resize(likelihood.dimension(), options.draws);
    for (int b = 0; b < options.draws; ++b) {
      Random random(options.seed, static_cast<std::uint64_t>(b));
      for (double& z : normal_.col(b)) z = random.normal();
      double squares = 0.0;
      for (int i = 0; i < static_cast<int>(likelihood.rest_df()); ++i) {
        const double z = random.normal();
        squares += z * z;
      }
      chi_squared_.push_back(squares);
    }
    const Variances equal = Variances::Constant(likelihood.components(), 0.5 * likelihood.scale());
    best_ = likelihood.fit(likelihood.observed(), equal, {}, kPrecise);
  }

  const Variances& estimate() const { return best_.at; }

  /// Restricted likelihood ratio of the value less its quantile: positive outside the interval.
  double excess(const Held& held) const {
    const Fit null = likelihood_.fit(likelihood_.observed(), best_.at, held, kPrecise);
    const double ratio = std::max(0.0, null.criterion - best_.criterion);
    const bool residual = held.component + 1 == likelihood_.components();
    return ratio - (residual && likelihood_.rest_df() > 0.0 ? residual_quantile()
                                                            : quantile(held, null.at));
  }

 private:
  static constexpr double kPrecise = 1e-8;
  // An error of the ratio that no quantile from some hundred draws can see.
  static constexpr double kOfDraws = 1e-3;

  /// The residual's variance is never near a bound: chi2_1, with Bartlett's factor of the ratio of
  /// a variance on so many degrees of freedom.
  double residual_quantile() const {
    return numerics::chi_squared_quantile(confidence_, 1.0) *
           (1.0 + 1.0 / (3.0 * likelihood_.rest_df()));
  }

  double quantile(const Held& held, const Variances& truth) const {
    const Eigen::LLT<Eigen::MatrixXd> llt(likelihood_.covariance(truth));
    std::vector<double> ratios;
    for (Eigen::Index b = 0; b < normal_.cols(); ++b) {
      const Contrasts drawn{llt.matrixL() * normal_.col(b),
                            truth(truth.size() - 1) * chi_squared_[static_cast<size_t>(b)]};
      const Fit null = likelihood_.fit(drawn, truth, held, kOfDraws);
      const Fit best = likelihood_.fit(drawn, null.at, {}, kOfDraws);
      ratios.push_back(null.criterion - best.criterion);
    }
    // The observed ratio counts as one of the draws: a value is out where at most a share of
    // 1 - confidence of all reach it.
    const double out =
        std::floor((1.0 - confidence_) * (1.0 + static_cast<double>(ratios.size())) + 1e-9);
    const auto at = static_cast<std::ptrdiff_t>(static_cast<double>(ratios.size()) - out);
    std::nth_element(ratios.begin(), ratios.begin() + at, ratios.end());
    return ratios[static_cast<size_t>(at)];
  }

  const RestrictedLikelihood& likelihood_;
  double confidence_;
  Eigen::MatrixXd normal_;
  std::vector<double> chi_squared_;
  Fit best_;
};

}  // namespace

std::vector<Interval> component_intervals(const MixedModelData& data,
                                          const ComponentIntervalOptions& options) {
  const RestrictedLikelihood likelihood(data);
  const ComponentTest test(likelihood, options);
  const double scale = std::sqrt(likelihood.scale());
  std::vector<Interval> intervals;
  for (Eigen::Index k = 0; k < likelihood.components(); ++k) {
    const auto excess = [&](double sd) { return test.excess({k, sd * sd}); };
    const auto root = [&](double low, double at_low, double high, double at_high) {
      std::uintmax_t iterations = 10;
      const auto close = [&](double x, double y) { return std::abs(x - y) < 5e-3 * scale; };
      const auto [x, y] =
          boost::math::tools::toms748_solve(excess, low, high, at_low, at_high, close, iterations);
      return 0.5 * (x + y);
    };
    const double estimate = std::sqrt(test.estimate()(k));
    const double floor = k + 1 < likelihood.components() ? 0.0 : 1e-3 * estimate;
    Interval interval{0.0, 0.0};
    if (estimate > floor) {
      if (const double at_floor = excess(floor); at_floor > 0.0) {
        interval.low = root(floor, at_floor, estimate, excess(estimate));
      }
    }
    double inside = estimate, at_inside = excess(estimate);
    double outside = std::max(2.0 * estimate, 0.2 * scale), at_outside = excess(outside);
    while (at_outside <= 0.0 && outside < 1e3 * scale) {
      inside = outside;
      at_inside = at_outside;
      outside *= 2.0;
      at_outside = excess(outside);
    }
    interval.high = at_outside > 0.0 ? root(inside, at_inside, outside, at_outside) : outside;
    intervals.push_back(interval);
  }
  return intervals;
}

std::vector<bool> component_intervals_hold(const MixedModelData& data,
                                           const std::vector<double>& sd,
                                           const ComponentIntervalOptions& options) {
  const RestrictedLikelihood likelihood(data);
  const ComponentTest test(likelihood, options);
  std::vector<bool> holds;
  for (Eigen::Index k = 0; k < likelihood.components(); ++k) {
    const double of = sd[static_cast<size_t>(k)];
    holds.push_back(test.excess({k, of * of}) <= 0.0);
  }
  return holds;
}

}  // namespace osteomill::study
