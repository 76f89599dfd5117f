// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/force_case.hpp"

#include "osteomill/io/case_file.hpp"
#include "osteomill/io/section.hpp"

namespace osteomill::io {
namespace {

struct Tables {
  CutterCase cutter;
  BoneCase bone;
  CutCase cut;
};

void bind(Section& section, Tables& tables) {
  bind_cutter(section, tables.cutter);
  bind_bone(section, tables.bone);
  bind_cut(section, tables.cut);
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
  force.condition = condition_of(tables.cut, tables.cutter.cutter);
  cutting::check(tables.bone.law);
  force.cutter = tables.cutter.cutter;
  force.bone = tables.bone;
  force.immersion = tables.cut.immersion;
  force.tilted = tilted_cut_of(tables.cut);
  if (force.tilted) cutting::check(*force.tilted, force.cutter);
  force.caveats = caveats_of(tables.cutter, tables.bone, tables.cut.spindle_speed);
  return force;
}

}  // namespace osteomill::io
