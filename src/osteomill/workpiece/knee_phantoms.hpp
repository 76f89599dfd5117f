// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "osteomill/bone/density.hpp"
#include "osteomill/workpiece/stock.hpp"

namespace osteomill::workpiece {

/// Densities of a long bone's end. Values are apparent densities of the order that the literature
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
  bone::ForceDensityLaw force = {};  ///< density to force scale
};

/// Upper end of a tibia: z up, plateau at z = 0 sloping down backwards; x to the patient's right
/// (medio-lateral), y forwards. The section goes from a rounded rectangle at the plateau to the
/// shaft. Adult sizes; the shape is a phantom, assumed.
struct ProximalTibia {
  double width = 75e-3;   ///< medio-lateral at the plateau, m
  double depth = 50e-3;   ///< antero-posterior at the plateau, m
  double shaft = 27e-3;   ///< diameter at the lower end, m
  double length = 70e-3;  ///< m
  double slope = 0.0873;  ///< of the plateau, rad; 5°
  EpiphysisBone bone = {};
};
Stock proximal_tibia(const ProximalTibia& tibia, double spacing, double margin = 0.0);

/// Lower end of a femur: z up along the shaft, most distal point of the condyles at z = 0; x to the
/// patient's right, y forwards. Two condyles with a notch between them behind, joined to the shaft.
/// Adult sizes; the shape is a phantom, assumed.
struct DistalFemur {
  double width = 80e-3;           ///< medio-lateral over the condyles, m
  double depth = 62e-3;           ///< antero-posterior of the condyles, m
  double condyle_height = 40e-3;  ///< m
  double notch = 20e-3;           ///< width of the notch, m
  double shaft = 30e-3;           ///< diameter at the upper end, m
  double length = 80e-3;          ///< m
  EpiphysisBone bone = {};
};
Stock distal_femur(const DistalFemur& femur, double spacing, double margin = 0.0);

}  // namespace osteomill::workpiece
