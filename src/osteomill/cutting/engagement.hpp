// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

namespace osteomill::cutting {

/// Which part of the cutter's envelope is in bone: angle × axial slice, as the stock delivers it.
///
/// Patch (slice, angle) covers heights [slice, slice + 1) × slice_height above the tip and rotation
/// angles [angle, angle + 1) × 2 pi / angles in the tool frame (see Cutter). Its weight is the
/// share of the patch that is in contact, times the local strength of the bone relative to the
/// reference that the force law was measured on: 1 where reference bone is cut with the whole
/// patch, 0 in air. Only patches that move into the bone count: outward normal · feed > 0.
struct Engagement {
  int slices = 0;
  int angles = 0;
  double slice_height = 0.0;    ///< m
  std::vector<double> weights;  ///< slices × angles, angle runs fastest

  double& at(int slice, int angle) { return weights[index(slice, angle)]; }
  double at(int slice, int angle) const { return weights[index(slice, angle)]; }

 private:
  std::size_t index(int slice, int angle) const {
    return static_cast<std::size_t>(slice) * static_cast<std::size_t>(angles) +
           static_cast<std::size_t>(angle);
  }
};

}  // namespace osteomill::cutting
