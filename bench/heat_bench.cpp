// SPDX-License-Identifier: BSD-3-Clause
// Conduction in a block of bone, voxel updates a second on one core, beside the memory bandwidth of
// a plain triad in the same run.
#include <benchmark/benchmark.h>
#include <tbb/global_control.h>

#include <vector>

#include "osteomill/thermal/heat_field.hpp"

namespace {

using namespace osteomill;

void heat(benchmark::State& state) {
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  geometry::GridShape shape;
  shape.size = {192, 192, 96};
  shape.spacing = geometry::Vector3::Constant(0.2e-3);
  thermal::HeatField field(
      shape, [](int, int, int) { return thermal::kCorticalBone; }, thermal::HeatOptions{});
  field.add_heat(96, 96, 48, 1.0);
  for (auto _ : state) field.advance(0.01);
  state.counters["updates/s"] = benchmark::Counter(
      static_cast<double>(state.iterations()) * static_cast<double>(shape.count()),
      benchmark::Counter::kIsRate);
  // Each of the three sweeps reads temperature, capacity, conductance and opening, and writes the
  // temperature once: 8 + 4 + 4 + 4 + 8 + 8 bytes.
  state.counters["bytes/s"] = benchmark::Counter(
      static_cast<double>(state.iterations()) * static_cast<double>(shape.count()) * 3.0 * 36.0,
      benchmark::Counter::kIsRate);
}

void stream(benchmark::State& state) {
  const std::size_t count = 8'000'000;
  std::vector<double> a(count, 1.0), b(count, 2.0), c(count, 3.0);
  for (auto _ : state) {
    for (std::size_t i = 0; i < count; ++i) a[i] = b[i] + 3.0 * c[i];
    benchmark::DoNotOptimize(a.data());
    benchmark::ClobberMemory();
  }
  state.counters["bytes/s"] = benchmark::Counter(
      static_cast<double>(state.iterations()) * static_cast<double>(count) * 24.0,
      benchmark::Counter::kIsRate);
}

BENCHMARK(heat);
BENCHMARK(stream);

}  // namespace

BENCHMARK_MAIN();
