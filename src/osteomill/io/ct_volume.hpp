// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "osteomill/geometry/voxel_grid.hpp"

namespace osteomill::io {

/// A CT scan. Patient frame P: x to the left, y to the back, z to the head (LPS, as DICOM has it).
/// Grid frame G: along the axes of the grid, right-handed, origin at the centre of voxel (0, 0, 0).
struct CtVolume {
  geometry::VoxelGrid<std::int16_t> hounsfield;  ///< HU, rounded to whole units
  geometry::Pose X_PG = geometry::Pose::Identity();
  std::string description;           ///< format, file, and what the file says of itself
  std::vector<std::string> remarks;  ///< what was assumed, clamped or looks doubtful
};

struct CtOptions {
  /// Which series of a DICOM folder: its UID, its number or its description. May stay empty where
  /// there is one.
  std::string series;
};

/// Reads a CT: a folder with a DICOM series (or one file of it), NIfTI (.nii, .nii.gz), NRRD
/// (.nrrd, .nhdr), MetaImage (.mha, .mhd), or an InVesalius project (.inv3). InvalidInput when the
/// file is missing, truncated, or no CT in Hounsfield units on a regular grid.
CtVolume read_ct(const std::filesystem::path& path, const CtOptions& options = {});

/// Hounsfield units on a grid of the work frame W, trilinear between the centres of the CT's
/// voxels. X_PW: pose of W in the patient frame. The same on any number of threads. InvalidInput
/// when the grid reaches out of the volume.
geometry::VoxelGrid<float> resample(const CtVolume& ct, const geometry::GridShape& shape,
                                    const geometry::Pose& X_PW);

}  // namespace osteomill::io
