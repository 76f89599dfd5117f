// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/force_case.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <numbers>

#include "osteomill/base/units.hpp"
#include "osteomill/cutting/milling_force.hpp"
#include "osteomill/io/case_file.hpp"
#include "osteomill/io/engagement_file.hpp"
#include "osteomill/io/heat_section.hpp"
#include "osteomill/io/section.hpp"

namespace osteomill::io {
namespace {

struct Tables {
  CutterCase cutter;
  BoneCase bone;
  CutCase cut;
  std::filesystem::path map;
  double slice_height = 0.0;
  int angles = 0;
  thermal::PartitionOptions heat;
};

void bind(Section& section, Tables& tables) {
  const bool mapped = section.has("engagement");
  bind_cutter(section, tables.cutter);
  bind_bone(section, tables.bone);
  bind_cut(section, tables.cut, section.when(!mapped));
  section.table("engagement", "map of what is in bone, in place of the immersion", Need::optional,
                [&](Section& s) {
                  s.file(
                      "file", tables.map,
                      "table: height_mm, angle_deg, weight of each patch (lower end, beginning)");
                  s.number("slice_height_mm", tables.slice_height, {units::mm, "mm"},
                           non_negative(), "height of a patch; 0: from the table", Need::optional);
                  s.integer("angles", tables.angles, between(0, 3600),
                            "patches around; 0: from the table", Need::optional);
                });
  section.table("heat", "where the energy of the cut goes", Need::optional,
                [&](Section& s) { bind_partition(s, tables.heat); });
}

/// Patches that move away from the bone cut nothing, whatever the table says.
cutting::Engagement map_of(const Tables& tables, const cutting::Condition& condition,
                           const cutting::Cutter& cutter) {
  cutting::Engagement map = read_engagement(tables.map, tables.slice_height, tables.angles);
  const double top = map.slices * map.slice_height;
  if (top > cutter.cutting_length * (1.0 + 1e-9)) {
    throw InvalidInput(Fault{"engagement.file", fmt::format("up to {:g} mm", top / units::mm),
                             fmt::format("must stay below the cutter's cutting length of {:g} mm",
                                         cutter.cutting_length / units::mm),
                             "lower the map or set cutter.cutting_length_mm"});
  }
  const geometry::Vector3 feed = cutting::feed_direction(condition);
  for (int slice = 0; slice < map.slices; ++slice) {
    const double kappa = cutting::axial_position_angle(cutter, (slice + 0.5) * map.slice_height);
    for (int angle = 0; angle < map.angles; ++angle) {
      const double theta = 2.0 * std::numbers::pi * (angle + 0.5) / map.angles;
      if (!(cutting::outward_normal(theta, kappa).dot(feed) > 0.0)) map.at(slice, angle) = 0.0;
    }
  }
  return map;
}

}  // namespace

void bind_force(Section& section) {
  Tables tables;
  bind(section, tables);
}

ForceCase read_force_case(const CaseRun& run) {
  Tables tables;
  ForceCase force;
  force.expanded = Section::read(run, [&](Section& section) { bind(section, tables); });
  const bool mapped = !tables.map.empty();
  force.condition = condition_of(tables.cut, tables.cutter.cutter, !mapped);
  settle(tables.bone, tables.cutter.cutter, force.condition.spindle_speed);
  force.cutter = tables.cutter.cutter;
  force.bone = tables.bone;
  force.heat = tables.heat;
  force.immersion = tables.cut.immersion;
  if (mapped) {
    force.engagement = map_of(tables, force.condition, force.cutter);
  } else {
    force.tilted = tilted_cut_of(tables.cut);
  }
  if (force.tilted) cutting::check(*force.tilted, force.cutter);
  force.caveats = caveats_of(tables.cutter, tables.bone, tables.cut.spindle_speed);
  return force;
}

}  // namespace osteomill::io
