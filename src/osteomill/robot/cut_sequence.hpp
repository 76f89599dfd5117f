// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "osteomill/robot/placement.hpp"

namespace osteomill::robot {

/// A region of bone in the plane of the cuts: a convex polygon, anticlockwise about z = x × y.
using BoneOutline = std::vector<Vector2>;

/// Bone around a profile, `cover` outside of each cut and ending where the anterior and posterior
/// cuts do. With cover = overhang/√2 and chamfers of 45° the plane of the distal cut leaves the
/// bone exactly `overhang` anterior of the cut. A stand-in for the patient's bone, marked as such.
BoneOutline generic_bone(const Profile& profile, double cover);

/// The bone that is left when everything on the outer side of a cut's line is removed.
BoneOutline after_cut(const BoneOutline& bone, const CutLine& line);

/// Where the line, followed in the direction of cutting, meets the bone: length from line.entry, m
/// (negative: before it). Empty when it misses.
std::optional<double> first_bone(const BoneOutline& bone, const CutLine& line);

/// Distance of a straight guide from A2 to its tip from the bone, m; 0 when they overlap.
double clearance(const BoneOutline& bone, const GuidePose& pose);

/// Whether a piece of the guide longer than a contact stands in the bone.
bool overlaps(const BoneOutline& bone, const GuidePose& pose);

struct SequenceOptions {
  std::vector<Cut> order{kCuttingOrder.begin(), kCuttingOrder.end()};
  double clearance = 0.0;     ///< to keep from the bone between cuts, m
  double joint_step = 0.035;  ///< of the search for a path, rad
};

/// One cut of a sequence: where the robot stands, and how it gets there from the cut before.
struct SequenceStep {
  Cut cut = Cut::distal;
  bool reachable = false;  ///< within workspace and joint limits
  JointAngles joints;      ///< to set
  GuidePose pose;
  double gap = 0.0;  ///< from the guide's tip to the bone that is there at that time, along the
                     ///< finished surface, m
  bool collides = false;          ///< the guide would stand in that bone
  bool path_found = false;        ///< from the cut before; true for the first
  std::vector<JointAngles> path;  ///< way points, first and last included
  std::string trouble;            ///< what is wrong; empty when nothing
};

/// Goes through the cuts in the given order: joint targets, collision of the guide with the bone
/// not yet cut, and a collision-free path in joint space between cuts (A* on a grid of joint
/// angles, complete to its step, then shortened). The guide moves with its slide retracted.
std::vector<SequenceStep> plan_sequence(const GuidePositioner& robot, const Profile& profile,
                                        const CutOptions& cuts, const BoneOutline& bone,
                                        const Vector2& axis_position,
                                        const PerCut<Branch>& branches,
                                        const SequenceOptions& options = {});

/// The joint angles along a path, with way points no farther apart than `step` in either joint.
std::vector<JointAngles> densified(const std::vector<JointAngles>& path, double step);

}  // namespace osteomill::robot
