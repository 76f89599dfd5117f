// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "osteomill/bone/density.hpp"
#include "osteomill/workpiece/stock.hpp"

namespace osteomill::workpiece {

/// Densities of a long bone's end by depth below its surface: a cortical shell that thickens
/// towards the shaft, a subchondral plate below the joint, cancellous bone that thins out away from
/// it, and marrow in the shaft. Values are apparent densities of the order that the literature
/// gives for adults; the set as a whole is assumed.
struct EpiphysisBone {
  double cortical = 1900.0;          ///< kg/m³
  double subchondral = 1200.0;       ///< plate below the joint surface, kg/m³
  double cancellous_joint = 450.0;   ///< just below the plate, kg/m³
  double cancellous_shaft = 150.0;   ///< `gradient_depth` below the joint and beyond, kg/m³
  double gradient_depth = 40e-3;     ///< m
  double plate = 2e-3;               ///< thickness of the subchondral plate, m
  double shell_joint = 1.0e-3;       ///< thickness of the cortical shell at the joint, m
  double shell_shaft = 4.5e-3;       ///< at the shaft, m
  double marrow = 50.0;              ///< bone in the canal of the shaft, kg/m³
  double marrow_from = 1e3;          ///< below the joint the canal begins here, m; default: none
  bone::ForceDensityLaw force = {};  ///< density to force scale
};

/// Throws InvalidInput naming the field.
void check(const EpiphysisBone& bone);

/// Where a point of bone lies; all > 0 inside.
struct BoneDepth {
  double below_joint = 0.0;  ///< along the bone from the joint's level, m
  double below_plate = 0.0;  ///< below the joint surface itself, infinite elsewhere, m
  double below_side = 0.0;   ///< below any surface, m
  double along = 0.0;        ///< 0 at the joint, 1 where the shaft begins
};
BoneMaterial material_at(const EpiphysisBone& bone, const BoneDepth& depth);

}  // namespace osteomill::workpiece
