// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/robot/placement_error.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "osteomill/base/error.hpp"
#include "osteomill/base/random.hpp"

namespace osteomill::robot {

std::vector<PlacementError> draw_placement_errors(const PlacementErrors& errors) {
  require_within("errors.samples", errors.samples, 10.0, 1e7, "");
  require_non_negative("errors.position_sd_mm", errors.position / units::mm, "mm");
  require_non_negative("errors.varus_valgus_sd_deg", errors.varus_valgus / units::deg, "deg");
  require_non_negative("errors.internal_external_sd_deg", errors.internal_external / units::deg,
                       "deg");
  require_non_negative("errors.half_width_mm", errors.half_width / units::mm, "mm");
  std::vector<PlacementError> drawn(static_cast<std::size_t>(errors.samples));
  for (std::size_t i = 0; i < drawn.size(); ++i) {
    Random random(errors.seed, i);
    const double dx = random.normal(0.0, errors.position);
    const double dy = random.normal(0.0, errors.position);
    // A turn about y (varus/valgus) moves the piercing point along x, about x along −y.
    const double along_x = errors.half_width * std::tan(random.normal(0.0, errors.varus_valgus));
    const double along_y =
        -errors.half_width * std::tan(random.normal(0.0, errors.internal_external));
    drawn[i] = {{dx, dy}, {along_x, along_y}};
  }
  return drawn;
}

PlacementRisk placement_risk(const GuidePositioner& robot, const PerCut<CutLine>& lines,
                             const Vector2& axis_position, const PlacementErrors& errors,
                             BranchRule rule) {
  check(robot);
  const std::vector<PlacementError> drawn = draw_placement_errors(errors);
  const std::size_t count = drawn.size();
  std::vector<std::array<GapReport, 2>> sides(count);
  tbb::parallel_for(std::size_t{0}, count, [&](std::size_t i) {
    const Vector2 middle = axis_position + drawn[i].shift;
    sides[i] = {gaps_at(robot, lines, middle + drawn[i].side, rule),
                gaps_at(robot, lines, middle - drawn[i].side, rule)};
  });
  PlacementRisk risk;
  std::vector<double> gaps;
  for (const auto& both : sides) {
    const GapReport& worse =
        !both[0].allowed || (both[1].allowed && both[0].largest_gap >= both[1].largest_gap)
            ? both[0]
            : both[1];
    if (worse.allowed) {
      gaps.push_back(worse.largest_gap);
    } else {
      risk.forbidden_by[index(worse.limiting_cut)] += 1.0 / static_cast<double>(count);
    }
  }
  risk.allowed = static_cast<int>(gaps.size());
  risk.share_forbidden = 1.0 - static_cast<double>(gaps.size()) / static_cast<double>(count);
  if (gaps.empty()) return risk;
  for (const double gap : gaps) risk.mean_gap += gap / static_cast<double>(gaps.size());
  const auto at =
      gaps.begin() + static_cast<std::ptrdiff_t>(0.95 * static_cast<double>(gaps.size() - 1));
  std::nth_element(gaps.begin(), at, gaps.end());
  risk.gap_95 = *at;
  return risk;
}

}  // namespace osteomill::robot
