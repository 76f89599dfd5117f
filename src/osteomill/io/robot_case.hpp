// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "osteomill/io/section.hpp"
#include "osteomill/robot/chain_sequence.hpp"
#include "osteomill/robot/compliance.hpp"
#include "osteomill/robot/cut_sequence.hpp"
#include "osteomill/robot/placement_error.hpp"
#include "osteomill/robot/size_study.hpp"

/// The cases of `osteomill robot place | size | position`.
namespace osteomill::io {

/// A family of profiles: a catalogue entry of data/implants, or [implant.dimensions] of a case.
void bind_implant_family(Section& section, robot::ImplantFamily& family);

/// An entry of data/implants by name.
robot::ImplantFamily implant_family(const std::string& name);

/// The implant of a case: a family and a size, or its own profile.
struct ImplantCase {
  std::string family = {};
  std::optional<robot::ImplantFamily> dimensions = {};
  int size = 1;
  std::vector<double> profile_x = {};
  std::vector<double> profile_y = {};
  std::filesystem::path drawing = {};
  double drawing_unit = 1e-3;
};
void bind_implant(Section& section, ImplantCase& implant);

/// What the case describes, and how its dimensions were obtained ("assumed", "drawn", ...).
struct Implant {
  robot::Profile profile;
  std::string name;
  std::string obtained;
};
Implant implant_of(const ImplantCase& implant);

void bind_guide_positioner(Section& section, robot::GuidePositioner& robot);

/// Keys that place, size and position share.
struct PlacementOptionsCase {
  double distal_overhang = 0.010;
  robot::PlacementOptions placement;
};
void bind_placement_options(Section& section, PlacementOptionsCase& options);

struct RobotPlaceCase {
  ImplantCase implant;
  robot::GuidePositioner robot;
  PlacementOptionsCase options;
  double map_x_low = -0.050;  ///< [plaskos2006] fig. 4.10
  double map_x_high = 0.0;
  double map_y_low = -0.025;
  double map_y_high = 0.025;
  double map_step = 0.0005;
  std::optional<double> error_radius;  ///< to place for, m
  robot::PlacementErrors errors;       ///< of the Monte Carlo
};
void bind_robot_place(Section& section, RobotPlaceCase& c);
void bind_robot_place_keys(Section& section);

struct RobotSizeCase {
  std::vector<std::string> families;
  robot::SizeStudyOptions study;
  std::optional<robot::PlacementErrors> errors;
  double kept_share = 0.95;
};
void bind_robot_size(Section& section, RobotSizeCase& c);
void bind_robot_size_keys(Section& section);

struct RobotPositionCase {
  ImplantCase implant;
  robot::GuidePositioner robot;
  PlacementOptionsCase options;
  std::optional<double> axis_x;
  std::optional<double> axis_y;
  std::vector<std::string> order{"distal", "anterior_chamfer", "anterior", "posterior_chamfer",
                                 "posterior"};
  robot::SequenceOptions sequence;
  double bone_cover = 0.0;  ///< 0: overhang/√2
  double play1 = 0.0;       ///< rad
  double play2 = 0.0;
  double gear1 = 100.0;  ///< motor turns a joint turn
  double gear2 = 100.0;
  std::vector<robot::PlanarAxis> further;  ///< between A2's link and the slide
  bool chain = false;                      ///< solved as a chain of 2 + n axes
  robot::Redundancy redundancy = robot::Redundancy::joint_centre;
  double stiffness1 = robot::size8_secant_stiffness();  ///< of A1, N m/rad
  double stiffness2 = robot::size8_secant_stiffness();
  double slide_stiffness = 0.0;  ///< N/m; 0: rigid
  double zero1 = 0.0;            ///< Hall count at joint angle 0, rad of the motor
  double zero2 = 0.0;
};
void bind_robot_position(Section& section, RobotPositionCase& c);
void bind_robot_position_keys(Section& section);

}  // namespace osteomill::io
