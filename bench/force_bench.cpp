// SPDX-License-Identifier: BSD-3-Clause
// Forces: one revolution of 360 x 100 x 4 edge elements, means, and means of an engagement map. The
// case is the last one of [plaskos2006] table 3.5 (four flutes, slot, 6.5 um). NumPy's time for the
// same revolution is measured by force_bench.py, which adds it.
#include <cmath>
#include <vector>

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

struct Kind {
  const char* name;
  Cutter cutter;
  CuttingLaw law;
  Condition condition;
  Immersion immersion;
};

/// What a user may ask the mean of: every shape, law, immersion and unequal flutes, with the log
/// law in both directions unless the name says another.
std::vector<Kind> kinds() {
  const Condition level{5000.0 * units::rpm, 6.5e-6};
  Condition ramp = level;
  ramp.feed_elevation = -20.0 * units::deg;
  Condition trochoid = level;
  trochoid.path = ToothPath::trochoidal;
  const Immersion slot{ImmersionKind::slot, 0.0, 8e-3};
  const Immersion half{ImmersionKind::down, 2e-3, 5e-3};
  const Cutter end_mill{CutterShape::cylindrical, 3.175e-3, 4, 30.0 * units::deg, 0.0, 20e-3};
  const Cutter ball{CutterShape::ball, 4e-3, 2, 30.0 * units::deg, 0.0, 20e-3};
  Cutter bull = ball, tapered = ball, apt = ball, uneven = end_mill, eccentric = end_mill;
  bull.shape = CutterShape::bull;
  bull.corner_radius = 1.5e-3;
  tapered.shape = CutterShape::tapered;
  tapered.corner_radius = 1.5e-3;
  tapered.taper_angle = 10.0 * units::deg;
  apt.shape = CutterShape::apt;
  apt.corner_radius = 1.5e-3;
  apt.apt = {8e-3, 2.5e-3, 1.5e-3, 0.0, 0.0};
  uneven.radius_error = {0.0, 2e-6, -3e-6, 1e-6};
  eccentric.run_out.offset = 3e-6;
  CuttingLaw puw = bovine(), power, ploughs = bovine();
  puw.orientation = OrientationCriterion::puw_hocheng;
  power.tangential = {PowerLaw{71e3, 0.684}, PowerLaw{63e3, 0.569}};
  power.radial = {PowerLaw{32e3, 0.479}, PowerLaw{18e3, 0.341}};
  ploughs.minimum_chip = 1e-6;
  CuttingLaw polynomial;
  polynomial.tangential = {PolynomialLaw{{387e6, -259e6}, {8e3}}, {}};
  polynomial.radial = {PolynomialLaw{{334e6, -150e6}, {8e3}}, {}};
  polynomial.lateral = DirectionalLaw{PolynomialLaw{{-172e6}, {1e3}}, {}};
  return {{"mean-force", end_mill, bovine(), level, slot},
          {"mean-force-half-immersion", end_mill, bovine(), level, half},
          {"mean-force-power-law", end_mill, power, level, half},
          {"mean-force-puw-hocheng", end_mill, puw, level, half},
          {"mean-force-ploughing", end_mill, ploughs, level, half},
          {"mean-force-trochoidal", end_mill, bovine(), trochoid, half},
          {"mean-force-unequal-flutes", uneven, bovine(), level, half},
          {"mean-force-run-out", eccentric, bovine(), level, half},
          {"mean-force-ball", ball, bovine(), level, slot},
          {"mean-force-ball-half-immersion", ball, bovine(), level, half},
          {"mean-force-ball-ramp", ball, bovine(), ramp, half},
          {"mean-force-ball-polynomial", ball, polynomial, level, half},
          {"mean-force-bull-ramp", bull, bovine(), ramp, half},
          {"mean-force-tapered-ramp", tapered, bovine(), ramp, half},
          {"mean-force-apt-ramp", apt, bovine(), ramp, half}};
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
  std::vector<bench::Figure> figures = {
      {"revolution", fast * 1e3, "ms", "numpy", 0.0},
      {"revolution-against-scalar", fast * 1e3, "ms", "scalar loop", scalar * 1e3},
      {"revolution-share-of-exp-and-ln", floor / fast, "1"}};
  for (const Kind& kind : kinds()) {
    const double time = bench::best_time(2000, [&] {
      keep += mean_load(kind.cutter, kind.law, kind.condition, kind.immersion, {.tolerance = 0.01})
                  .force.x();
    });
    figures.push_back({kind.name, time * 1e6, "us", "50000 a second, 1 %", 20.0});
  }
  const double closer =
      bench::best_time(2000, [&] { keep += mean_load(cutter, law, condition, slot).force.x(); });
  figures.push_back({"mean-force-to-1e-5", closer * 1e6, "us", "50000 a second", 20.0});

  const EngagedForce engaged(ball, law, 72, 25, 0.2e-3);
  Engagement map{25, 72, 0.2e-3, std::vector<double>(72 * 25, 0.0)};
  for (int slice = 0; slice < map.slices; ++slice) {
    for (int angle = 0; angle < map.angles / 2; ++angle) map.at(slice, angle) = 1.0;
  }
  const double mapped =
      bench::best_time(2000, [&] { keep += engaged.mean(map, condition).force.x(); });
  figures.push_back({"mean-force-map", mapped * 1e6, "us", "50 us a step", 50.0});
  if (!std::isfinite(keep)) return 1;
  bench::print(figures);
}
