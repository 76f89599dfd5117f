// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "osteomill/robot/placement_error.hpp"
#include "osteomill/robot/size_study.hpp"

namespace osteomill::robot {

/// The radius that a share of the samples' displacements of A1 stay within, on the worse side of
/// the bone: manual adjustment and tilt of the axis together. A position with that margin stays
/// allowed in at least this share of samples, for the allowed region is convex. m
double error_margin(const PlacementErrors& errors, double share);

/// What the errors do to one pair of link lengths over all implants, each placed at its best with
/// the margin given.
struct LengthRisk {
  bool exists = false;           ///< every implant has a place
  double share_forbidden = 0.0;  ///< of samples, mean over the implants
  double worst_share = 0.0;      ///< and that of the worst implant
  double mean_gap = 0.0;         ///< largest gap, mean over the samples: of the worst implant, m
  double gap_95 = 0.0;           ///< its 95th percentile: of the worst implant, m
};
LengthRisk length_risk(const std::vector<ImplantFamily>& families, const SizeStudyOptions& options,
                       double l1, double l2, const PlacementErrors& errors);

/// The size study again with every placement keeping the margin, and the Monte Carlo at the chosen
/// lengths. [plaskos2006] 4.4.3: the nominal optimum is "a dangerous target", and a safe zone costs
/// "~1mm for each 1mm of malplacement".
struct SizeErrorStudy {
  double margin = 0.0;    ///< that keeps the wanted share of samples allowed, m
  LengthRisk nominal;     ///< lengths of the nominal study's best_largest, placed without margin
  SizeStudy with_margin;  ///< surfaces and choices with the margin
  LengthRisk largest;     ///< at with_margin.best_largest
  LengthRisk mean;        ///< at with_margin.best_mean
  double added_per_margin = 0.0;  ///< mean rise of the surface of the largest gap over the margin
};
SizeErrorStudy study_size_errors(const std::vector<ImplantFamily>& families,
                                 const SizeStudyOptions& options, const SizeStudy& nominal,
                                 const PlacementErrors& errors, double share,
                                 const Progress& progress = {});

}  // namespace osteomill::robot
