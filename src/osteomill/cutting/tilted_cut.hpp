// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "osteomill/cutting/condition.hpp"
#include "osteomill/cutting/engagement.hpp"
#include "osteomill/cutting/prediction.hpp"

namespace osteomill::cutting {

/// A cut along a flat surface with the cutter's axis off the surface's normal. The feed runs along
/// the surface.
struct TiltedCut {
  double lead = 0.0;          ///< lean of the axis towards the feed, rad
  double tilt = 0.0;          ///< lean of the axis towards +y, rad
  double depth = 0.0;         ///< below the surface, along its normal, of the deepest point, m
  double radial_depth = 0.0;  ///< width of the bone across the feed, from the side of `kind`, m
  ImmersionKind kind = ImmersionKind::slot;
};

/// Throws InvalidInput for leans beyond 60 degrees and depths beyond the cutter.
void check(const TiltedCut& cut, const Cutter& cutter);

/// The condition in the tool frame of the leaning cutter: leaning forward by `lead`, the feed
/// points down by it, in T. Only the elevation changes.
Condition condition_of(const TiltedCut& cut, Condition condition);

/// Which part of the envelope is in bone and moves into it: each patch by points within it. What
/// the cutter has passed is gone, so behind its axis only the patches that go deeper count (n · f >
/// 0).
Engagement engagement_of(const TiltedCut& cut, const Cutter& cutter, const Condition& condition,
                         int angles = 180, int slices = 60);

/// As predict() for a nominal cut, from the engagement map of the leaning cutter.
Prediction predict(const Cutter& cutter, const CuttingLaw& law, const Condition& condition,
                   const TiltedCut& cut, const PredictionOptions& options = {});

}  // namespace osteomill::cutting
