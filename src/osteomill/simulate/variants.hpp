// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>

#include "osteomill/simulate/line_profile.hpp"
#include "osteomill/simulate/milling.hpp"

namespace osteomill::simulate {

/// How a line profile and its machine are varied: what a controller has to stand.
struct VariantOptions {
  std::uint64_t seed = 1;
  double gain_sigma = 0.25;        ///< standard deviation of the factor on the gain
  double correlation = 1.5e-3;     ///< length over which the factor's correlation falls to 1/e, m
  double noise = 1.0;              ///< standard deviation on each mean force, N
  std::array<int, 2> delay{1, 3};  ///< control periods, drawn evenly
  bool hard_zones = true;          ///< one on each line, at a place drawn evenly
  double hard_width = 1.17e-3;     ///< m
  double hard_factor = 4.4;        ///< on the gain
  double map_error = 0.0;          ///< the map's offset is drawn evenly within +- this, m
};

/// Throws InvalidInput that names the field.
void check(const VariantOptions& options);

struct Variant {
  LineProfile profile;
  Machine machine;
};

/// Variant `number` of a profile and a machine: a function of the seed and the number alone. The
/// factor on the gain is 1 + sigma g(x), g of unit variance with exp(-|dx|/correlation), held to
/// 0.1 and more.
Variant vary(const LineProfile& profile, const Machine& machine, const VariantOptions& options,
             std::uint64_t number);

}  // namespace osteomill::simulate
