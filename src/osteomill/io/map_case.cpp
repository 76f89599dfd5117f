// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/map_case.hpp"

#include <fmt/format.h>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/io/case_file.hpp"
#include "osteomill/io/section.hpp"
#include "osteomill/io/stock_maker.hpp"

namespace osteomill::io {
namespace {

constexpr Quantity kMm{units::mm, "mm"};
constexpr Quantity kDeg{units::deg, "deg"};
constexpr Quantity kMmPerS{units::mm_per_s, "mm/s"};

void bind_guide(Section& section, MapCase& to) {
  using workpiece::Milling;
  section.table("map", "the guide over the cutting plane", Need::required, [&](Section& s) {
    simulate::ForceMapOptions& map = to.map;
    simulate::GuidePoses& poses = map.poses;
    std::array<double, 3> pivot{}, normal{0, 0, 1}, forward{1, 0, 0};
    s.triple("pivot_mm", pivot, kMm, any(),
             "where the guide turns, on the cutting plane, in the work frame");
    s.triple("normal", normal, {}, any(), "of the cutting plane, into the bone that goes",
             Need::optional);
    s.triple("forward", forward, {}, any(), "direction of insertion at angle 0", Need::optional);
    poses.pivot_W = vector_of(pivot);
    poses.normal_W = vector_of(normal);
    poses.forward_W = vector_of(forward);
    s.number("first_angle_deg", poses.first_angle, kDeg, between(-180, 180), "of the poses");
    s.number("last_angle_deg", poses.last_angle, kDeg, between(-180, 180), "of the poses");
    s.number("angle_step_deg", poses.angle_step, kDeg, up_to(45.0), "between poses, at most",
             Need::optional);
    s.number("first_insertion_mm", poses.first_insertion, kMm, positive(),
             "of the tip beyond the pivot");
    s.number("last_insertion_mm", poses.last_insertion, kMm, positive(), "of the poses");
    s.number("insertion_step_mm", poses.insertion_step, kMm, positive(), "between poses, at most",
             Need::optional);
    s.number("advance_mm", map.axial_depth, kMm, positive(),
             "length of cutter in uncut bone: from swing to swing, a groove of the guide",
             Need::optional);
    s.choice<Milling>("milling", map.milling, {{"down", Milling::down}, {"up", Milling::up}},
                      "which way the tool is swung over the plane", Need::optional);
    s.number("feed_mm_per_s", to.feed, kMmPerS, positive(), "of the tip");
    double speed = 0.0;
    s.number("spindle_speed_rpm", speed, {units::rpm, "rpm"}, positive(), "of the spindle");
    map.spindle_speed = speed;
    s.number("slice_height_mm", map.slice_height, kMm, positive(),
             "of the slices of the cutter, at most", Need::optional);
  });
}

void bind(Section& section, MapCase& to) {
  using simulate::LimitedForce;
  bind_stock(section, to.stock);
  bind_cutter(section, to.cutter);
  bind_bone(section, to.bone);
  bind_guide(section, to);
  section.table("limits", "what must hold", Need::optional, [&](Section& s) {
    s.number("force_n", to.force_limit, {1.0, "N"}, positive(), "largest mean force",
             Need::optional);
    s.choice<LimitedForce>("on", to.limited,
                           {{"resultant", LimitedForce::resultant},
                            {"normal", LimitedForce::normal},
                            {"feed", LimitedForce::feed}},
                           "the force that is limited", Need::optional);
    s.number("max_feed_mm_per_s", to.map.largest_feed, kMmPerS, positive(),
             "largest feed of the map", Need::optional);
  });
}

}  // namespace

void bind_map(Section& section) {
  MapCase unused;
  bind(section, unused);
}

MapCase read_map_case(const CaseRun& run) {
  MapCase made;
  made.expanded = Section::read(run, [&](Section& section) { bind(section, made); });
  FaultList faults;
  if (made.stock.kind == StockKind::line_profile)
    faults.gather([] {
      throw InvalidInput(Fault{"stock.kind", "line-profile", "must have a shape",
                               "choose a block, a phantom, a mesh or a CT"});
    });
  if (made.feed > made.map.largest_feed)
    faults.gather([&] {
      throw InvalidInput(Fault{"map.feed_mm_per_s",
                               fmt::format("{:g} mm/s", made.feed / units::mm_per_s),
                               fmt::format("must not be above limits.max_feed_mm_per_s = {:g} mm/s",
                                           made.map.largest_feed / units::mm_per_s),
                               "lower the feed or raise the limit: the map ends there"});
    });
  faults.raise();
  settle(made.bone, made.cutter.cutter, made.map.spindle_speed);
  made.map.cutter = made.cutter.cutter;
  made.map.law = made.bone.law;
  made.caveats = caveats_of(made.cutter, made.bone, made.map.spindle_speed);
  return made;
}

}  // namespace osteomill::io
