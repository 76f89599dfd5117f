// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <vector>

#include "osteomill/cutting/condition.hpp"
#include "osteomill/cutting/envelope.hpp"

namespace osteomill::cutting {

/// Arcs of rotation angle, rad, within (-pi/2, 3 pi/2).
struct Arcs {
  std::array<std::array<double, 2>, 4> ends{};
  int count = 0;
  void add(double from, double to) {
    if (to > from) ends[static_cast<std::size_t>(count++)] = {from, to};
  }
};

/// Where the envelope at a point of its meridian moves into the bone of a band: n · f > 0 and
/// r cos theta within the band. Exact.
Arcs contact_arcs(const ProfilePoint& point, const Condition& condition, const LateralBand& band);

/// The same as a margin that is > 0 in contact and changes continuously along an edge.
double contact_margin(const ProfilePoint& point, double theta, const Condition& condition,
                      const LateralBand& band, double full_radius);

/// Lengths along the meridian, from 0 to that of the axial depth, between which entry and exit vary
/// smoothly: joints of the envelope, where the band begins to be reached, where the normal turns
/// away from the feed, and where these two meet.
std::vector<double> smooth_pieces(const Envelope& envelope, const Condition& condition,
                                  const LateralBand& band, double axial_depth);

}  // namespace osteomill::cutting
