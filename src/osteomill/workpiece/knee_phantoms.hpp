// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "osteomill/workpiece/anatomy.hpp"
#include "osteomill/workpiece/epiphysis.hpp"
#include "osteomill/workpiece/stock.hpp"

namespace osteomill::workpiece {

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
Anatomy anatomy_of(const ProximalTibia& tibia);
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
Anatomy anatomy_of(const DistalFemur& femur);
Stock distal_femur(const DistalFemur& femur, double spacing, double margin = 0.0);

}  // namespace osteomill::workpiece
