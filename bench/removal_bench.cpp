// SPDX-License-Identifier: BSD-3-Clause
// Removal with the engagement map, steps a second on one core. Volumes are counted so that nothing
// is optimised away, and so that a wrong cut is seen.
#include <benchmark/benchmark.h>

#include <cmath>

#include "osteomill/base/units.hpp"
#include "osteomill/workpiece/phantoms.hpp"
#include "osteomill/workpiece/remover.hpp"

namespace {

using namespace osteomill;
using workpiece::Vector3;
constexpr double mm = units::mm;

struct Cut {
  cutting::CutterShape shape;
  double diameter, spacing, depth, step;  // m
  double heading;                         // rad
};

void removal(benchmark::State& state, const Cut& cut) {
  const double length = 40 * mm;
  const workpiece::Stock whole = workpiece::block(
      {-30 * mm, -30 * mm, -14 * mm}, {30 * mm, 30 * mm, 0.0}, {1900.0, 1.0}, cut.spacing);
  cutting::Cutter cutter;
  cutter.shape = cut.shape;
  cutter.radius = 0.5 * cut.diameter;
  cutter.cutting_length = 10 * mm;
  const Vector3 along(std::cos(cut.heading), std::sin(cut.heading), 0.0);
  const Vector3 start = Vector3(0.03 * mm, 0.02 * mm, -cut.depth) - 0.5 * length * along;
  const int steps = static_cast<int>(std::lround(length / cut.step));
  double volume = 0.0, weights = 0.0;
  for (auto _ : state) {
    state.PauseTiming();
    workpiece::Stock stock = whole;
    workpiece::Remover remover(stock, cutter);
    remover.step(start, start + 0.01 * cut.step * along);
    volume = 0.0;
    state.ResumeTiming();
    for (int k = 0; k < steps; ++k) {
      const Vector3 from = start + cut.step * (k == 0 ? 0.01 : k) * along;
      volume += remover.step(from, start + cut.step * (k + 1) * along).volume;
      weights += remover.engagement().weights.front();
    }
  }
  benchmark::DoNotOptimize(weights);
  state.counters["steps/s"] = benchmark::Counter(static_cast<double>(state.iterations()) * steps,
                                                 benchmark::Counter::kIsRate);
  state.counters["mm3"] = volume / units::mm3;
}

constexpr auto kBall = cutting::CutterShape::ball;
constexpr auto kCylinder = cutting::CutterShape::cylindrical;

// 8 mm ball in 0.1 mm voxels: a slot 1 mm deep in 0.1 mm steps, and buried to its full diameter in
// 0.5 mm steps; 3 mm cylinder 5 mm deep in 0.2 mm voxels and steps. Along the grid and across it.
BENCHMARK_CAPTURE(removal, ball_0_1mm_shallow, Cut{kBall, 8 * mm, 0.1 * mm, 1 * mm, 0.1 * mm, 0.0});
BENCHMARK_CAPTURE(removal, ball_0_1mm_shallow_oblique,
                  Cut{kBall, 8 * mm, 0.1 * mm, 1 * mm, 0.1 * mm, 0.5});
BENCHMARK_CAPTURE(removal, ball_0_1mm_buried, Cut{kBall, 8 * mm, 0.1 * mm, 8 * mm, 0.5 * mm, 0.0});
BENCHMARK_CAPTURE(removal, ball_0_1mm_buried_oblique,
                  Cut{kBall, 8 * mm, 0.1 * mm, 8 * mm, 0.5 * mm, 0.5});
BENCHMARK_CAPTURE(removal, cylinder_0_2mm, Cut{kCylinder, 3 * mm, 0.2 * mm, 5 * mm, 0.2 * mm, 0.0});
BENCHMARK_CAPTURE(removal, cylinder_0_2mm_oblique,
                  Cut{kCylinder, 3 * mm, 0.2 * mm, 5 * mm, 0.2 * mm, 0.5});

}  // namespace

BENCHMARK_MAIN();
