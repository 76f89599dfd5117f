// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <string>
#include <vector>

namespace osteomill::io {

/// sRGB, 0...1.
using Colour = std::array<float, 3>;

/// For values: viridis from low to high; blue-white-red for deviations about a middle; bone from
/// marrow to cortical, for densities. All keep their order without colour vision.
enum class ColourMap { viridis, deviation, bone };

/// The stops of a map, evenly spaced from 0 to 1.
const std::vector<Colour>& stops(ColourMap map);

/// The colour at t; below 0 and above 1 the ends.
Colour colour_at(ColourMap map, double t);

/// For kinds: the eight colours of Okabe and Ito, told apart with any colour vision; repeats.
Colour palette(std::size_t kind);

/// "#0072b2".
std::string hex(const Colour& colour);

}  // namespace osteomill::io
