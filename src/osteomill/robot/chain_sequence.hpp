// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "osteomill/robot/cut_sequence.hpp"
#include "osteomill/robot/planar_chain.hpp"

namespace osteomill::robot {

/// One cut of a sequence by a chain of 2 + n axes.
struct ChainStep {
  Cut cut = Cut::distal;
  ChainSolution solution;
  ChainPose pose;
  double gap = 0.0;  ///< from the guide's tip to the bone that is there at that time, m
  bool collides = false;
  bool path_found = false;
  std::vector<Eigen::VectorXd> path;  ///< way points from the cut before, first and last included
  std::string trouble;                ///< empty when nothing is wrong
};

/// As plan_sequence: joint targets with the freedom resolved, collision of all that is behind A2
/// with the bone not yet cut, and a way from cut to cut: prismatic axes go to their low ends, the
/// others turn, straight in the joints, and the prismatic ones come out again. With
/// smallest_displacement each cut starts from the one before, the first from the joints' middles.
std::vector<ChainStep> plan_chain_sequence(const PlanarChain& chain, const Profile& profile,
                                           const CutOptions& cuts, const BoneOutline& bone,
                                           const Vector2& axis_position, Redundancy redundancy,
                                           const SequenceOptions& options = {});

}  // namespace osteomill::robot
