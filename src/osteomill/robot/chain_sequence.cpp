// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/robot/chain_sequence.hpp"

#include <algorithm>
#include <cmath>

namespace osteomill::robot {
namespace {

bool overlaps(const BoneOutline& bone, const ChainPose& pose) {
  for (std::size_t i = 1; i + 1 < pose.points.size(); ++i) {
    if (overlaps(bone, GuidePose{pose.points[i], pose.points[i + 1]})) return true;
  }
  return false;
}

class Way {
 public:
  Way(const PlanarChain& chain, const Vector2& axis_position, const BoneOutline& bone, double step)
      : chain_(chain), axis_position_(axis_position), bone_(bone), step_(step) {}

  /// Empty when something is in the way.
  std::vector<Eigen::VectorXd> find(const Eigen::VectorXd& from, const Eigen::VectorXd& to) const {
    const std::vector<Eigen::VectorXd> points = {from, retracted(from), retracted(to), to};
    for (std::size_t i = 0; i + 1 < points.size(); ++i) {
      if (!free(points[i], points[i + 1])) return {};
    }
    return points;
  }

 private:
  Eigen::VectorXd retracted(Eigen::VectorXd q) const {
    for (std::size_t i = 0; i < chain_.axes.size(); ++i) {
      if (chain_.axes[i].kind == AxisKind::prismatic) {
        q(static_cast<Eigen::Index>(i)) = chain_.axes[i].range.low;
      }
    }
    return q;
  }

  bool free(const Eigen::VectorXd& a, const Eigen::VectorXd& b) const {
    // A prismatic axis moves at most its link's length a step; lengths are below a radian's arm.
    const double longest = (b - a).cwiseAbs().maxCoeff();
    const int pieces = std::max(40, static_cast<int>(std::ceil(4.0 * longest / step_)));
    for (int i = 0; i <= pieces; ++i) {
      const Eigen::VectorXd q = a + (b - a) * (static_cast<double>(i) / pieces);
      if (overlaps(bone_, forward(chain_, axis_position_, q))) return false;
    }
    return true;
  }

  const PlanarChain& chain_;
  Vector2 axis_position_;
  const BoneOutline& bone_;
  double step_;
};

}  // namespace

std::vector<ChainStep> plan_chain_sequence(const PlanarChain& chain, const Profile& profile,
                                           const CutOptions& cuts, const BoneOutline& bone,
                                           const Vector2& axis_position, Redundancy redundancy,
                                           const SequenceOptions& options) {
  check(chain);
  const PerCut<CutLine> lines = cut_lines(profile, cuts);
  const PerCut<CutLine> edges = cut_lines(profile, {.distal_overhang = cuts.distal_overhang});
  ChainOptions solving{redundancy, Eigen::VectorXd(static_cast<Eigen::Index>(chain.axes.size()))};
  for (std::size_t i = 0; i < chain.axes.size(); ++i) {
    const JointRange& range = chain.axes[i].range;
    solving.from(static_cast<Eigen::Index>(i)) = 0.5 * (range.low + range.high);
  }
  std::vector<ChainStep> steps;
  BoneOutline left = bone;
  for (const Cut cut : options.order) {
    ChainStep step;
    step.cut = cut;
    const CutLine& edge = edges[index(cut)];
    step.solution = solve(chain, axis_position, lines[index(cut)], solving);
    if (!step.solution.found) {
      step.trouble = step.solution.reason;
    } else {
      step.pose = forward(chain, axis_position, step.solution.joints);
      const auto meets = first_bone(left, edge);
      step.gap = meets ? *meets - (step.pose.tip() - edge.entry).dot(edge.direction) : 0.0;
      step.collides = overlaps(left, step.pose);
      if (step.collides) step.trouble = "the guide stands in bone that is not yet cut";
      solving.from = step.solution.joints;
    }
    step.path_found = steps.empty();
    if (!steps.empty() && step.trouble.empty()) {
      const ChainStep& before = steps.back();
      if (before.solution.found && !before.collides) {
        step.path = Way(chain, axis_position, left, options.joint_step)
                        .find(before.solution.joints, step.solution.joints);
      }
      step.path_found = !step.path.empty();
      if (!step.path_found) {
        step.trouble = before.solution.found && !before.collides
                           ? "no straight way past the bone from the cut before"
                           : "the cut before has no position";
      }
    }
    steps.push_back(step);
    left = after_cut(left, edge);
  }
  return steps;
}

}  // namespace osteomill::robot
