// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "osteomill/workpiece/stock.hpp"

namespace osteomill::workpiece {

/// Thickness of the cortical shell over the surface of a stock.
struct CorticalThickness {
  double p5 = 0.0, median = 0.0, p95 = 0.0;  ///< m; 0 where nothing was measured
  double share = 0.0;  ///< of the surface below which there is any cortical bone
  std::size_t places = 0;
};

/// From each voxel that the surface of the bone cuts, along the inward normal in steps of a quarter
/// of a voxel, until the density falls below `cortical_density` (kg/m³) or the bone ends. In a CT
/// the scanner blurs the shell's edge: within `rim` of the surface, m, the density may still be on
/// its way up. The faces of the region, where the bone was cut off and has no shell, are left out.
/// Steps make it uncertain by about half a voxel; blur widens shells that are thinner than it.
CorticalThickness cortical_thickness(const Stock& stock, double cortical_density = 1000.0,
                                     double rim = 1.5e-3);

}  // namespace osteomill::workpiece
