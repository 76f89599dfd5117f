// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/robot/size_error.hpp"

#include <algorithm>
#include <cmath>

#include "osteomill/base/error.hpp"

namespace osteomill::robot {

double error_margin(const PlacementErrors& errors, double share) {
  require_within("errors.kept_share", share, 0.0, 1.0, "");
  const std::vector<PlacementError> drawn = draw_placement_errors(errors);
  std::vector<double> farthest;
  for (const PlacementError& error : drawn) {
    farthest.push_back(
        std::max((error.shift + error.side).norm(), (error.shift - error.side).norm()));
  }
  std::sort(farthest.begin(), farthest.end());
  const double at = std::ceil(share * static_cast<double>(farthest.size()));
  return farthest[static_cast<std::size_t>(std::max(at, 1.0)) - 1];
}

LengthRisk length_risk(const std::vector<ImplantFamily>& families, const SizeStudyOptions& options,
                       double l1, double l2, const PlacementErrors& errors) {
  const GuidePositioner robot{.link1 = l1, .link2 = l2};
  PlacementOptions placing;
  placing.branch = options.branch;
  placing.margin = options.margin;
  LengthRisk result;
  double implants = 0.0;
  for (const ImplantFamily& family : families) {
    for (std::size_t size = 1; size <= family.anteroposterior.size(); ++size) {
      const auto lines = cut_lines(profile_of(family, static_cast<int>(size)), options.cuts);
      const Placement placement = place(robot, lines, placing);
      if (!placement.feasible) return {};
      const PlacementRisk risk =
          placement_risk(robot, lines, placement.axis_position, errors, options.branch);
      result.share_forbidden += risk.share_forbidden;
      result.worst_share = std::max(result.worst_share, risk.share_forbidden);
      result.mean_gap = std::max(result.mean_gap, risk.mean_gap);
      result.gap_95 = std::max(result.gap_95, risk.gap_95);
      implants += 1.0;
    }
  }
  result.exists = implants > 0.0;
  if (result.exists) result.share_forbidden /= implants;
  return result;
}

SizeErrorStudy study_size_errors(const std::vector<ImplantFamily>& families,
                                 const SizeStudyOptions& options, const SizeStudy& nominal,
                                 const PlacementErrors& errors, double share,
                                 const Progress& progress) {
  SizeErrorStudy result;
  result.margin = error_margin(errors, share);
  SizeStudyOptions kept = options;
  kept.margin = std::max(options.margin, result.margin);
  result.with_margin = study_sizes(families, kept, progress);
  if (result.with_margin.stopped) return result;
  const auto risk = [&](const SizeStudyOptions& placing, const LinkChoice& choice) {
    return choice.exists ? length_risk(families, placing, choice.l1, choice.l2, errors)
                         : LengthRisk{};
  };
  result.nominal = risk(options, nominal.best_largest);
  result.largest = risk(kept, result.with_margin.best_largest);
  result.mean = risk(kept, result.with_margin.best_mean);
  double added = 0.0, cells = 0.0;
  for (std::size_t i = 0; i < nominal.largest.size(); ++i) {
    if (!nominal.largest[i] || !result.with_margin.largest[i]) continue;
    added += *result.with_margin.largest[i] - *nominal.largest[i];
    cells += 1.0;
  }
  if (cells > 0.0 && kept.margin > options.margin) {
    result.added_per_margin = added / cells / (kept.margin - options.margin);
  }
  return result;
}

}  // namespace osteomill::robot
