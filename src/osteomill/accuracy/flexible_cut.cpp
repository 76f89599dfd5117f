// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/accuracy/flexible_cut.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "osteomill/accuracy/edge_balance.hpp"

namespace osteomill::accuracy {
namespace {

using Eigen::VectorXd;

constexpr double kTurn = 2.0 * std::numbers::pi;

/// How many rotations are solved together, and how finely.
struct Layout {
  bool equal_pitch = true;
  int together = 1;  ///< a tooth period apart, or the whole turn where the pitch is unequal
  int phases = 1;    ///< of a tooth period
  int slices = 1;
};

Layout layout_of(const cutting::Cutter& cutter, const cutting::Immersion& immersion,
                 const DeflectionOptions& options) {
  Layout layout;
  for (const double pitch : cutter.pitch) {
    if (std::abs(pitch - kTurn / cutter.flutes) > 1e-9) layout.equal_pitch = false;
  }
  // As for the rigid cut.
  const double lag = std::abs(cutting::lag_angle(cutter, immersion.axial_depth));
  layout.slices =
      std::max({1, static_cast<int>(std::ceil(immersion.axial_depth / options.slice_height - 1e-9)),
                static_cast<int>(std::ceil(lag / 0.1))});
  if (layout.equal_pitch) {
    layout.together = cutter.flutes;
    layout.phases = std::max(4, options.steps / cutter.flutes);
  } else {
    layout.together = (kUnequalSteps + cutter.flutes - 1) / cutter.flutes * cutter.flutes;
    layout.slices = std::min(layout.slices, kUnequalSlices);
  }
  return layout;
}

std::vector<double> rotations_from(double phase, int count) {
  std::vector<double> list;
  for (int m = 0; m < count; ++m) list.push_back(phase + kTurn * m / count);
  return list;
}

/// What the farthest of the edges leaves at each height of the wall.
class Wall {
 public:
  Wall(const EdgeBalance& balance, const ToolCompliance& tool, const cutting::Cutter& cutter,
       const cutting::Immersion& immersion, const Layout& layout)
      : balance_(balance),
        tool_(tool),
        cutter_(cutter),
        layout_(layout),
        angle_(wall_angle(immersion)) {}

  /// Bone left at a height; `turn` is the one of all rotations where the pitch is unequal, else
  /// that of the height before, which is kept where the edges pass both at once.
  double error(double height, Turn& turn) const {
    const cutting::ProfilePoint point = cutting::Envelope(cutter_).at(height);
    VectorXd influence(layout_.slices);
    for (int s = 0; s < layout_.slices; ++s) {
      influence[s] = tool_.between(height, balance_.middle(s));
    }
    const double first = angle_ + point.lag;
    if (layout_.equal_pitch && (turn.rotation.empty() || turn.rotation.front() != first)) {
      turn = balance_.solve(rotations_from(first, layout_.together), turn);
    }
    const double outward = angle_ == 0.0 ? 1.0 : -1.0;
    double farthest = -std::numeric_limits<double>::infinity();
    for (int j = 0; j < cutter_.flutes; ++j) {
      const double place =
          (first + balance_.flutes().angle(j) - turn.rotation.front()) / kTurn * layout_.together;
      const double whole = std::floor(place + 1e-9), share = std::max(0.0, place - whole);
      const auto y = [&](double at) {
        const Index m = static_cast<Index>(at) % layout_.together;
        return balance_.sum(turn, m, influence).y();
      };
      const double deflection = (1.0 - share) * y(whole) + share * y(whole + 1.0);
      farthest = std::max(farthest, balance_.flutes().deviation(j, point) + outward * deflection);
    }
    return -farthest;
  }

 private:
  const EdgeBalance& balance_;
  const ToolCompliance& tool_;
  const cutting::Cutter& cutter_;
  Layout layout_;
  double angle_;
};

}  // namespace

FlexibleCut flexible_cut(const ToolCompliance& tool, const cutting::Cutter& cutter,
                         const cutting::CuttingLaw& law, const cutting::Condition& condition,
                         const cutting::Immersion& immersion, const DeflectionOptions& options) {
  check_static_cut(tool, cutter, law, condition, immersion, options);
  const Layout layout = layout_of(cutter, immersion, options);
  const EdgeBalance balance(tool, cutter, law, condition, immersion, layout.slices);
  VectorXd to_tip(layout.slices);
  for (int s = 0; s < layout.slices; ++s) to_tip[s] = tool.between(0.0, balance.middle(s));
  const VectorXd ones = VectorXd::Ones(layout.slices);

  FlexibleCut result;
  const auto size = static_cast<std::size_t>(layout.phases * layout.together);
  result.angle.resize(size);
  result.force_x.resize(size);
  result.force_y.resize(size);
  result.tip_x.resize(size);
  result.tip_y.resize(size);
  Turn turn, middle, largest, worst;
  Index at_largest = 0;
  // From the middle of a tooth period to both of its ends, where chips are thin: each balance
  // starts from the one beside it.
  for (int k = 0; k < layout.phases; ++k) {
    const int half = layout.phases / 2;
    const int i = k < layout.phases - half ? half + k : layout.phases - 1 - k;
    const double phase = kTurn * i / (layout.phases * layout.together);
    if (i == half - 1) turn = middle;
    turn = balance.solve(rotations_from(phase, layout.together), turn);
    const double residual = turn.residual.lpNorm<Eigen::Infinity>();
    if (k == 0) middle = turn;
    result.residual = std::max(result.residual, residual);
    if (residual >= kBalanced) {
      result.worst_angle = phase;
      break;
    }
    if (const double growth = balance.growth(turn); growth > result.growth) {
      result.growth = growth;
      result.worst_angle = phase;
      worst = turn;
    }
    for (int m = 0; m < layout.together; ++m) {
      const auto at = static_cast<std::size_t>(m * layout.phases + i);
      const Eigen::Vector2d force = balance.sum(turn, m, ones), tip = balance.sum(turn, m, to_tip);
      result.angle[at] = turn.rotation[static_cast<std::size_t>(m)];
      result.force_x[at] = force.x();
      result.force_y[at] = force.y();
      result.tip_x[at] = tip.x();
      result.tip_y[at] = tip.y();
      if (force.norm() > result.peak_force) {
        result.peak_force = force.norm();
        largest = turn;
        at_largest = m;
      }
    }
  }
  if (result.residual >= kBalanced) {
    if (result.peak_force > 0.0) {
      result.cut_stiffness = balance.stiffness(largest, at_largest).over_tool;
    }
    return result;
  }
  if (result.growth > 0.0) result.growth = balance.exact_growth(worst);
  const auto [low, high] = std::minmax_element(result.tip_y.begin(), result.tip_y.end());
  result.total_tip = *high - *low;
  if (result.peak_force > 0.0) {
    const EdgeBalance::Stiffness stiffness = balance.stiffness(largest, at_largest);
    result.cut_stiffness = stiffness.over_tool;
    if (stiffness.left > 0.0 && stiffness.left < 1.0) {
      result.revolutions = std::max(1.0, std::log(0.01) / std::log(stiffness.left) / cutter.flutes);
    }
  }

  const Wall wall(balance, tool, cutter, immersion, layout);
  std::vector<double> heights{0.0};
  for (int s = 0; s < layout.slices; ++s) heights.push_back(balance.middle(s));
  heights.push_back(immersion.axial_depth);
  for (const double z : heights) {
    result.surface.axial_position.push_back(z);
    result.surface.error.push_back(wall.error(z, turn));
    result.residual = std::max(result.residual, turn.residual.lpNorm<Eigen::Infinity>());
  }
  // A disturbance that neither grows nor dies out, but for rounding, is not at rest either.
  result.rest = result.residual >= kBalanced ? Rest::unbalanced
                : result.growth > 1.0 - 1e-9 ? Rest::unstable
                                             : Rest::at_rest;
  return result;
}

}  // namespace osteomill::accuracy
