// SPDX-License-Identifier: BSD-3-Clause
// Stability: spectral radii over 200 speeds x 100 depths, two directions, 40 steps of
// semi-discretisation; the boundary by scan and by continuation; a surface error. NumPy's time for
// the same map comes from stability_bench.py, which adds it.
#include <cmath>
#include <cstdio>
#include <cstring>
#include <numbers>

#include "bench.hpp"
#include "osteomill/accuracy/tool_deflection.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/vibration/stability.hpp"

namespace {

using namespace osteomill;
using namespace osteomill::vibration;

RegenerativeSystem mill() {
  return {{{922.0, 0.011, 0.03993, 1.0, 0.0}, {922.0, 0.011, 0.03993, 0.0, 1.0}},
          Regeneration(2, 0.0, 0.5 * std::numbers::pi, 0.0, EdgeStiffness{6e8, 2e8})};
}

/// One tool of [plaskos2002] figure 4.21: four flutes, 35 mm deep.
double surface_error() {
  using cutting::PowerLaw;
  const cutting::CuttingLaw law{.tangential = {PowerLaw{71.1e3, 0.684}, PowerLaw{63.1e3, 0.569}},
                                .radial = {PowerLaw{32.5e3, 0.479}, PowerLaw{18.6e3, 0.341}},
                                .lateral = {}};
  const auto tool = accuracy::ToolCompliance::cantilever(35e-3, 2.54e-3, 197e9);
  const cutting::Cutter cutter{.radius = 1.55e-3, .flutes = 4, .cutting_length = 35e-3};
  const cutting::Condition condition{.spindle_speed = 20000.0 * units::rpm,
                                     .feed_per_tooth = 0.35e-6};
  const cutting::Immersion slot{.kind = cutting::ImmersionKind::slot, .axial_depth = 35e-3};
  return accuracy::tool_deflection(tool, cutter, law, condition, slot).total_tip;
}

}  // namespace

int main(int argc, char** argv) {
  const RegenerativeSystem system = mill();
  std::vector<double> speeds, depths;
  for (int i = 0; i < 200; ++i) speeds.push_back((5000.0 + 100.0 * i) * units::rpm);
  for (int k = 1; k <= 100; ++k) depths.push_back(0.05e-3 * k);
  StabilityOptions options;
  options.steps = 40;
  options.max_depth = 5e-3;
  // For the baseline: a few radii that both sides must agree on.
  if (argc > 1 && std::strcmp(argv[1], "--radii") == 0) {
    for (const double speed : {5000.0, 12300.0, 24900.0}) {
      fmt::print("{:.10g}\n", spectral_radius(system, speed * units::rpm, 1e-3, options));
    }
    return 0;
  }
  double keep = 0.0;
  const double map =
      bench::best_time(3, [&] { keep += stability_map(system, speeds, depths, options)[7]; });
  const double scan =
      bench::best_time(3, [&] { keep += lobes(system, speeds, options)[7].chatter_frequency_hz; });
  const double followed = bench::best_time(
      3, [&] { keep += lobes_by_continuation(system, speeds, options)[7].chatter_frequency_hz; });
  const double bent = bench::best_time(50, [&] { keep += surface_error(); });
  if (!std::isfinite(keep)) return 1;
  bench::print({{"lobes-200x100", map, "s", "numpy", 0.0},
                {"lobes-scan", scan, "s", "full grid", map},
                {"lobes-continuation", followed, "s", "full grid", map},
                {"surface-error", bent * 1e3, "ms", "5 ms a condition", 5.0}});
}
