// SPDX-License-Identifier: BSD-3-Clause
// Force map of a plane of 60 x 60 mm at poses of 1° x 1 mm in bone of graded density, log law with
// fibres, on all cores: the map itself; a new feed (forces and largest feeds) when the slider
// moves.
#include "bench.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/simulate/force_map.hpp"

namespace {

using namespace osteomill;
using units::mm;
using workpiece::Vector3;

workpiece::Stock plane_of_bone() {
  return workpiece::Stock(
      workpiece::cubes_over({0.0, -31 * mm, -2 * mm}, {62 * mm, 31 * mm, 9 * mm}, 0.3 * mm),
      [](const Vector3& p) {
        const double outside =
            std::max({-p.x() + 1 * mm, p.x() - 61 * mm, std::abs(p.y()) - 30 * mm, p.z() - 8 * mm});
        return workpiece::BoneSample{outside, {1900.0, outside > -2 * mm ? 1.0 : 0.15}};
      });
}

}  // namespace

int main() {
  const workpiece::Stock stock = plane_of_bone();
  simulate::ForceMapOptions o;
  // From 10 mm before the middle of a side all of the plane is reached.
  o.poses.pivot_W = {-9 * mm, 0.0, 0.0};
  o.poses.first_angle = -72 * units::deg;
  o.poses.last_angle = 72 * units::deg;
  o.poses.first_insertion = 10 * mm;
  o.poses.last_insertion = 77 * mm;
  o.cutter = {cutting::CutterShape::cylindrical, 3.175 * mm, 4, 30 * units::deg, 0.0, 20 * mm};
  o.law.tangential = {cutting::LogLaw{0.42083, 0.58122, -0.06584},
                      cutting::LogLaw{0.27242, 0.66537, -0.08710}};
  o.law.radial = {cutting::LogLaw{0.62379, 0.43160, -0.20553},
                  cutting::LogLaw{0.64731, 0.17764, -0.06681}};
  o.spindle_speed = 5000 * units::rpm;
  double keep = 0.0;
  const double made =
      bench::best_time(5, [&] { keep += simulate::ForceMap(stock, o).contact().back(); });
  const simulate::ForceMap map(stock, o);
  double feed = 1e-3;
  const double forces = bench::best_time(50, [&] {
    feed += 0.1e-3;
    keep += map.at(feed).normal[map.poses() / 2];
  });
  const double limits = bench::best_time(20, [&] {
    keep += map.largest_feeds(simulate::LimitedForce::resultant, 20.0)[map.poses() / 2];
  });
  if (!(keep > 0.0)) return 1;
  bench::print({{"force-map", made, "s"},
                {"force-map-poses", static_cast<double>(map.poses()), "1"},
                {"new-feed-forces", 1e3 * forces, "ms"},
                {"new-limit-largest-feeds", 1e3 * limits, "ms"}});
  return 0;
}
