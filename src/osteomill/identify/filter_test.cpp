// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/identify/filter.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "osteomill/base/error.hpp"

namespace osteomill::identify {
namespace {

using std::numbers::pi;

struct Reference {
  int order;
  double cutoff_hz;
  Pass pass;
  std::vector<double> filtered;
};
#include "osteomill/identify/filtfilt_reference.inc"

Eigen::VectorXd vector(const std::vector<double>& values) {
  return Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
}

TEST(ZeroPhase, AgreesWithSciPyEverywhere) {
  const Eigen::VectorXd x = vector(kSignal);
  for (const Reference& one : kReferences) {
    const auto sections = design({one.order, one.cutoff_hz, one.pass}, kRate);
    const Eigen::VectorXd y = zero_phase(sections, x);
    // The same operations in another order: rounding that the poles nearest the unit circle
    // amplify; the requirement is 1e-10.
    EXPECT_LT((y - vector(one.filtered)).cwiseAbs().maxCoeff(), 1e-10)
        << "order " << one.order << " at " << one.cutoff_hz << " Hz";
  }
}

TEST(ZeroPhase, LetsAConstantThroughUnchangedAtAnyOrder) {
  for (const int order : {1, 2, 5, 9, 16}) {
    const auto sections = design({order, 400.0}, 8000.0);
    EXPECT_NEAR(zero_phase_gain(sections, 0.0, 8000.0), 1.0, 1e-12);
    const Eigen::MatrixXd out = zero_phase(sections, Eigen::MatrixXd::Constant(300, 1, 7.25));
    EXPECT_LT((out.array() - 7.25).abs().maxCoeff(), 1e-9) << order;
  }
}

TEST(ZeroPhase, HasNoPhaseAndTheSquaredGainOfOnePass) {
  const double rate = 8000.0;
  for (const int order : {1, 4, 9}) {
    for (const double f : {50.0, 300.0, 400.0, 800.0}) {
      const auto sections = design({order, 400.0}, rate);
      const Eigen::Index n = 8000;
      Eigen::VectorXd x(n);
      for (Eigen::Index i = 0; i < n; ++i)
        x[i] = std::cos(2.0 * pi * f * static_cast<double>(i) / rate + 0.3);
      const Eigen::VectorXd y = zero_phase(sections, x);
      // A second within, which holds whole periods: one line of the transform.
      std::complex<double> in = 0.0, out = 0.0;
      for (Eigen::Index i = 2000; i < 6000; ++i) {
        const auto z = std::polar(1.0, -2.0 * pi * f * static_cast<double>(i) / rate);
        in += x[i] * z;
        out += y[i] * z;
      }
      const double gain = zero_phase_gain(sections, f, rate);
      // What the transient of the ends leaves 2000 samples away is below rounding.
      EXPECT_NEAR(std::abs(out / in - gain), 0.0, 1e-10) << order << " " << f;
    }
  }
}

TEST(ZeroPhase, LetsHalfThroughAtTheCutOff) {
  for (const int order : {1, 2, 3, 9}) {
    for (const Pass pass : {Pass::low, Pass::high})
      EXPECT_NEAR(zero_phase_gain(design({order, 700.0, pass}, 5000.0), 700.0, 5000.0), 0.5, 1e-12);
  }
}

TEST(ZeroPhase, IsTheSameWhenTimeRunsBackwards) {
  const Eigen::VectorXd x = vector(kSignal);
  const auto sections = design({4, 1000.0}, kRate);
  const Eigen::VectorXd there = zero_phase(sections, x);
  const Eigen::VectorXd back = zero_phase(sections, x.reverse().eval()).col(0).reverse();
  // The order of the two passes matters at the ends only; a hundred samples on, their transient of
  // 0.3 a sample has died away.
  EXPECT_LT((there - back).segment(100, 200).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(ZeroPhase, FiltersEachColumnByItself) {
  Eigen::MatrixXd x(400, 6);
  for (int c = 0; c < 6; ++c) x.col(c) = (c + 1.0) * vector(kSignal).array() + c;
  const auto sections = design({5, 900.0}, kRate);
  const Eigen::MatrixXd all = zero_phase(sections, x);
  for (int c = 0; c < 6; ++c) EXPECT_EQ(all.col(c), zero_phase(sections, x.col(c)).col(0));
}

TEST(ZeroPhase, RefusesWhatIsNoFilter) {
  struct Bad {
    const char* what;
    Butterworth filter;
    Eigen::Index samples;
    const char* named;
  };
  for (const Bad& bad : {Bad{"order 0", {0, 100.0}, 1000, "signals.filter_order"},
                         {"order 51", {51, 100.0}, 1000, "signals.filter_order"},
                         {"no cut-off", {4, 0.0}, 1000, "signals.cutoff_hz"},
                         {"half the rate", {4, 500.0}, 1000, "signals.cutoff_hz"},
                         {"not a number", {4, std::nan("")}, 1000, "signals.cutoff_hz"},
                         {"too short", {4, 100.0}, 15, "record"}}) {
    try {
      zero_phase(design(bad.filter, 1000.0), Eigen::VectorXd::Ones(bad.samples));
      ADD_FAILURE() << bad.what;
    } catch (const InvalidInput& error) {
      EXPECT_EQ(error.faults().front().field, bad.named) << bad.what;
    }
  }
}

}  // namespace
}  // namespace osteomill::identify
