// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/colour.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace osteomill::io {
namespace {

Colour from_hex(unsigned rgb) {
  return {static_cast<float>((rgb >> 16) & 255u) / 255.0F,
          static_cast<float>((rgb >> 8) & 255u) / 255.0F, static_cast<float>(rgb & 255u) / 255.0F};
}

std::vector<Colour> from_hex(std::initializer_list<unsigned> list) {
  std::vector<Colour> colours;
  for (const unsigned rgb : list) colours.push_back(from_hex(rgb));
  return colours;
}

}  // namespace

const std::vector<Colour>& stops(ColourMap map) {
  static const std::vector<Colour> viridis = from_hex(
      {0x440154, 0x472d7b, 0x3b528b, 0x2c728e, 0x21918c, 0x28ae80, 0x5ec962, 0xaddc30, 0xfde725});
  static const std::vector<Colour> deviation = from_hex(
      {0x2166ac, 0x4393c3, 0x92c5de, 0xd1e5f0, 0xf7f7f7, 0xfddbc7, 0xf4a582, 0xd6604d, 0xb2182b});
  static const std::vector<Colour> bone =
      from_hex({0xa0654e, 0xc08c66, 0xdcb88d, 0xeed9b7, 0xfaf3e4});
  switch (map) {
    case ColourMap::deviation:
      return deviation;
    case ColourMap::bone:
      return bone;
    case ColourMap::viridis:
      break;
  }
  return viridis;
}

Colour colour_at(ColourMap map, double t) {
  const std::vector<Colour>& list = stops(map);
  const double last = static_cast<double>(list.size() - 1);
  const double at = std::isfinite(t) ? std::clamp(t, 0.0, 1.0) * last : 0.0;
  const std::size_t low = std::min(static_cast<std::size_t>(at), list.size() - 2);
  const float part = static_cast<float>(at - static_cast<double>(low));
  Colour colour;
  for (std::size_t i = 0; i < 3; ++i)
    colour[i] = (1.0F - part) * list[low][i] + part * list[low + 1][i];
  return colour;
}

Colour palette(std::size_t kind) {
  static const std::vector<Colour> list =
      from_hex({0x0072b2, 0xd55e00, 0x009e73, 0xcc79a7, 0xe69f00, 0x56b4e9, 0x000000, 0xb8a800});
  return list[kind % list.size()];
}

std::string hex(const Colour& colour) {
  const auto byte = [](float v) { return std::lround(std::clamp(v, 0.0F, 1.0F) * 255.0F); };
  return fmt::format("#{:02x}{:02x}{:02x}", byte(colour[0]), byte(colour[1]), byte(colour[2]));
}

}  // namespace osteomill::io
