// SPDX-License-Identifier: BSD-3-Clause
// Forces: one revolution of 360 x 100 x 4 edge elements, means, and means of an engagement map. The
// case is the last one of [plaskos2006] table 3.5 (four flutes, slot, 6.5 um). NumPy's time for the
// same revolution is measured by force_bench.py, which adds it.
#include <cmath>

#include "bench.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/cutting/component_kernel.hpp"
#include "osteomill/cutting/engaged_force.hpp"
#include "osteomill/cutting/sliced_revolution.hpp"

namespace {

using namespace osteomill;
using namespace osteomill::cutting;

CuttingLaw bovine() {
  CuttingLaw law;
  law.tangential = {LogLaw{0.42083, 0.58122, -0.06584}, LogLaw{0.27242, 0.66537, -0.08710}};
  law.radial = {LogLaw{0.62379, 0.43160, -0.20553}, LogLaw{0.64731, 0.17764, -0.06681}};
  law.lateral = DirectionalLaw{LogLaw{-0.19495, 0.61971, -0.07352}, {}};
  return law;
}

/// Time that the exp and ln of a revolution alone would take at the kernel's own throughput, s:
/// four log laws of Hankinson, one for the lateral force, one ln, for each element in contact.
double time_of_exp_and_ln(std::size_t elements) {
  std::vector<double> in(4096, 0.7);
  std::vector<double> out(in.size());
  const auto& kernel = kernel::best();
  const double exp_time =
      bench::best_time(400, [&] { kernel.exponential(in.data(), in.size(), out.data()); });
  const double ln_time =
      bench::best_time(400, [&] { kernel.logarithm(in.data(), in.size(), out.data()); });
  const double size = static_cast<double>(in.size());
  return static_cast<double>(elements) * (5.0 * exp_time + ln_time) / size;
}

}  // namespace

int main() {
  const Cutter cutter{CutterShape::cylindrical, 3.175e-3, 4, 30.0 * units::deg, 0.0, 20e-3};
  const Cutter ball{CutterShape::ball, 4e-3, 2, 30.0 * units::deg, 0.0, 20e-3};
  const Condition condition{5000.0 * units::rpm, 6.5e-6};
  const Immersion slot{ImmersionKind::slot, 0.0, 8e-3};
  const CuttingLaw law = bovine();

  double keep = 0.0;
  const double fast =
      bench::best_time(200, [&] { keep += sliced_revolution(cutter, law, condition, slot).x[7]; });
  const double scalar = bench::best_time(
      10, [&] { keep += sliced_revolution(cutter, law, condition, slot, {360, 100, false}).x[7]; });
  const double floor = time_of_exp_and_ln(360 * 100 * 4 / 2);
  const double mean =
      bench::best_time(2000, [&] { keep += mean_load(cutter, law, condition, slot).force.x(); });
  const double mean_ball =
      bench::best_time(500, [&] { keep += mean_load(ball, law, condition, slot).force.x(); });

  const EngagedForce engaged(ball, law, 72, 25, 0.2e-3);
  Engagement map{25, 72, 0.2e-3, std::vector<double>(72 * 25, 0.0)};
  for (int slice = 0; slice < map.slices; ++slice) {
    for (int angle = 0; angle < map.angles / 2; ++angle) map.at(slice, angle) = 1.0;
  }
  const double mapped =
      bench::best_time(2000, [&] { keep += engaged.mean(map, condition).force.x(); });
  if (!std::isfinite(keep)) return 1;

  bench::print({{"revolution", fast * 1e3, "ms", "numpy", 0.0},
                {"revolution-against-scalar", fast * 1e3, "ms", "scalar loop", scalar * 1e3},
                {"revolution-share-of-exp-and-ln", floor / fast, "1"},
                {"mean-force", mean * 1e6, "us", "50000 a second", 20.0},
                {"mean-force-ball", mean_ball * 1e6, "us", "50000 a second", 20.0},
                {"mean-force-map", mapped * 1e6, "us", "50 us a step", 50.0}});
}
