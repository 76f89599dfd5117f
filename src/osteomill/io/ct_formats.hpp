// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "osteomill/io/ct_volume.hpp"

/// The readers behind read_ct, one a format; each says what it found, ct_volume.cpp judges it.
namespace osteomill::io {

/// What a file holds, not yet checked.
struct RawVolume {
  std::array<int, 3> size{};
  std::vector<float> values;   ///< x runs fastest
  Eigen::Vector3d spacing_mm;  ///< between centres
  Eigen::Vector3d origin_mm;   ///< centre of the first voxel in P
  Eigen::Matrix3d direction;   ///< columns: the grid's axes in P
  std::string description;
  std::vector<std::string> remarks;
};

RawVolume read_invesalius(const std::filesystem::path& path);
RawVolume read_dicom(const std::filesystem::path& path, const CtOptions& options);
/// NIfTI, NRRD and MetaImage, by the suffix.
RawVolume read_image_file(const std::filesystem::path& path);

}  // namespace osteomill::io
