// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "osteomill/cutting/condition.hpp"
#include "osteomill/cutting/cutter.hpp"
#include "osteomill/cutting/cutting_law.hpp"

namespace osteomill::identify {

/// What bone of strength 1 answers to a feed: the reference law on a nominal cut at a constant
/// spindle speed, worked out beforehand so that a real-time step only looks it up.
class FeedResponse {
 public:
  /// @param highest_feed  m/s; beyond it the answer grows in proportion to the feed
  FeedResponse(const cutting::Cutter& cutter, const cutting::CuttingLaw& law,
               const cutting::Condition& condition, const cutting::Immersion& immersion,
               double highest_feed);
  /// Force proportional to the feed, N for each m/s: [sugita2009] eq. 7. No power.
  explicit FeedResponse(double gain);

  struct Answer {
    double force = 0.0;       ///< mean over a revolution of the magnitude of the force, N
    double power = 0.0;       ///< of the spindle, W
    double tangential = 0.0;  ///< mean over a revolution of the sum over the edges, N
    double radial = 0.0;      ///< N
  };
  /// Zero at feeds <= 0, and proportional to the feed below the first knot: what an edge rubs with
  /// there is no measure of the bone.
  Answer at(double feed) const noexcept;

 private:
  std::vector<double> feed_;  ///< growing, from 0
  std::vector<Answer> answer_;
};

}  // namespace osteomill::identify
