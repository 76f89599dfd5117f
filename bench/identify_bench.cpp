// SPDX-License-Identifier: BSD-3-Clause
// Identification: 60 s of three-axis force at 8 kHz with noise, drift and run-out through the whole
// chain (baseline, filter, segments, rotation, mean revolution, instantaneous fit with nine
// unknowns and the baseline's three constants) on one core. SciPy's time for the same record comes
// from identify_bench.py, which adds it.
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <numbers>

#include "bench.hpp"
#include "osteomill/base/random.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/identify/revolution_fit.hpp"

namespace {

using namespace osteomill;
using namespace osteomill::identify;

constexpr double kTurn = 2.0 * std::numbers::pi;
constexpr double kRate = 8000.0;
constexpr double kSpeed = 4956.0 * units::rpm;
constexpr double kPhase = 0.9;
constexpr int kSteps = 1440;

const cutting::Cutter kCutter{
    .radius = 3.175e-3, .flutes = 4, .helix_angle = 0.52, .cutting_length = 10e-3};
const cutting::Condition kCondition{.spindle_speed = kSpeed, .feed_per_tooth = 20e-6};
const cutting::Immersion kImmersion{cutting::ImmersionKind::down, 3.175e-3, 5e-3};
const cutting::RunOut kRunOut{7e-6, 2.1, 0.0, 0.0};

ForceRecord record() {
  std::vector<double> angle;
  for (int i = 0; i < kSteps; ++i) angle.push_back(kTurn * i / kSteps);
  Eigen::VectorXd coefficients(6);
  coefficients << 60e6, 45e6, 12e6, 4e3, 6e3, -1e3;
  const Eigen::VectorXd turn =
      EdgeColumns(kCutter, kCondition, kImmersion, linear_law_units()).at(angle, kPhase, kRunOut) *
      coefficients;
  Random random(1);
  ForceRecord made;
  made.rate = kRate;
  const auto samples = static_cast<Eigen::Index>(60.0 * kRate);
  made.force.resize(samples, 3);
  made.tacho.resize(samples);
  for (Eigen::Index i = 0; i < samples; ++i) {
    const double t = static_cast<double>(i) / kRate;
    made.tacho[i] = std::sin(kSpeed * t);
    const double place = std::fmod(kSpeed * t, kTurn) / kTurn * kSteps;
    const int low = static_cast<int>(place) % kSteps;
    const double share = place - std::floor(place);
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      made.force(i, axis) = 0.02 * t + 2.0 * random.normal();
      if (t < 3.0 || t > 57.0) continue;
      made.force(i, axis) += (1.0 - share) * turn[axis * kSteps + low] +
                             share * turn[axis * kSteps + (low + 1) % kSteps];
    }
  }
  return made;
}

}  // namespace

int main(int argc, char** argv) {
  const ForceRecord made = record();
  // For the baseline: the record, rows of x y z tacho.
  if (argc > 2 && std::strcmp(argv[1], "--record") == 0) {
    Eigen::Matrix<double, Eigen::Dynamic, 4, Eigen::RowMajor> rows(made.force.rows(), 4);
    rows << made.force, made.tacho;
    std::ofstream(argv[2], std::ios::binary)
        .write(
            reinterpret_cast<const char*>(rows.data()),
            static_cast<std::streamsize>(static_cast<std::size_t>(rows.size()) * sizeof(double)));
    return 0;
  }
  const SignalChain chain{.segments = {.guard = 0.02},
                          .baseline = BaselineKind::drift,
                          .filter_order = 4,
                          .cutoff_hz = 1000.0};
  ProcessedRecord processed;
  InstantaneousFit fit;
  const auto whole = [&] {
    processed = process(made, {.spindle_speed = kSpeed, .flutes = 4}, chain);
    fit = fit_processed(processed, chain, kCutter, kCondition, kImmersion);
  };
  const double all = bench::best_time(5, whole);
  const double signals = bench::best_time(
      3, [&] { processed = process(made, {.spindle_speed = kSpeed, .flutes = 4}, chain); });
  // For the baseline: what both sides must agree on, within their standard errors.
  if (argc > 1 && std::strcmp(argv[1], "--estimates") == 0) {
    for (const Estimate& one : fit.estimates) {
      fmt::print("{} {:.10g} {:.10g}\n", one.name, one.value, one.standard_error);
    }
    return 0;
  }
  if (fit.status != FitStatus::converged) return 1;
  bench::print({{"identify-60s", all, "s", "scipy", 0.0},
                {"identify-60s-signals", signals, "s"},
                {"identify-60s-fit", all - signals, "s"}});
}
