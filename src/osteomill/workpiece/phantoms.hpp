// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "osteomill/workpiece/stock.hpp"

namespace osteomill::workpiece {

/// A block of one material from lower to upper in W, with `margin` of air on every side.
Stock block(const Vector3& lower_W, const Vector3& upper_W, const BoneMaterial& material,
            double spacing, double margin = 0.0);

/// Section of a tibia as in [sugita2009]: a rectangle in x (length) and y (width) with a cortical
/// rim on all four sides and cancellous bone inside, a prism along z whose top is z = 0. x and y
/// run from 0.
struct TibiaSection {
  double length = 66e-3;  ///< along x, m
  double width = 40e-3;   ///< along y, m
  double height = 10e-3;  ///< below z = 0, m
  double rim = 5e-3;      ///< cortical thickness, m
  double graded = 0.0;    ///< width inside the rim over which the properties fall linearly, m
  BoneMaterial cortical{640.0, 1.0};
  BoneMaterial cancellous{160.0, 0.45 / 3.8};
};
Stock tibia_section(const TibiaSection& section, double spacing, double margin = 0.0);

}  // namespace osteomill::workpiece
