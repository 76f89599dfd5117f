// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/ct_volume.hpp"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/io/ct_formats.hpp"

namespace osteomill::io {
namespace {

namespace fs = std::filesystem;
using geometry::Vector3;

// Air is -1000 by definition; scanners write -1024 for it and less for what they did not measure.
constexpr float kLowestHounsfield = -1024.0F;
// The largest value of a 12-bit scanner: what is denser, metal for one, stays at it.
constexpr float kSaturated = 3071.0F;

/// Bad pieces of a file, as faults of a case file are: all of them at once.
void check(const RawVolume& raw, const fs::path& path) {
  std::vector<Fault> faults;
  const auto fault = [&](const char* field, std::string value, const char* rule,
                         const char* remedy) {
    faults.push_back({fmt::format("{}: {}", path.string(), field), std::move(value), rule, remedy});
  };
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (raw.size[axis] < 2)
      fault("voxels", fmt::format("{} × {} × {}", raw.size[0], raw.size[1], raw.size[2]),
            "a CT has two or more voxels along each axis", "give a volume, not one picture");
  for (int axis = 0; axis < 3; ++axis)
    if (!(raw.spacing_mm[axis] > 0.0 && raw.spacing_mm[axis] <= 20.0))
      fault("spacing", fmt::format("{} mm", raw.spacing_mm[axis]), "must be > 0 and ≤ 20 mm",
            "mend the header; its unit is mm");
  const Eigen::Matrix3d product = raw.direction.transpose() * raw.direction;
  // Single-precision headers leave some 1e-6; 1e-3 is a shear of 0.06°, a tenth of a voxel in 100.
  if (!((product - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() < 1e-3) ||
      !raw.origin_mm.allFinite())
    fault("direction", "", "the axes of the grid must be perpendicular, and its origin finite",
          "resample the volume to a rectangular grid");
  if (!faults.empty()) throw InvalidInput(faults);

  const auto bad =
      std::find_if(raw.values.begin(), raw.values.end(), [](float v) { return !std::isfinite(v); });
  if (bad != raw.values.end()) {
    fault("values", "not a number", "must be finite", "export the volume again");
    throw InvalidInput(faults);
  }
  const auto [low, high] = std::minmax_element(raw.values.begin(), raw.values.end());
  const std::string range = fmt::format("{:g} … {:g}", *low, *high);
  if (*low >= 0.0F)
    fault("values", range, "are not Hounsfield units: air is near -1000, nothing here is below 0",
          "export with rescale slope and intercept applied (often 1 and -1024)");
  else if (*high > 32767.0F || *low < -32768.0F)
    fault("values", range, "are not Hounsfield units: those lie within -32768 … 32767",
          "export with rescale slope and intercept applied");
  else if (*high <= 100.0F)
    fault("values", range, "hold no bone: the densest voxel is not above 100 HU",
          "check that this is a CT and that its rescale slope was applied");
  if (!faults.empty()) throw InvalidInput(faults);
}

/// Turns one axis round when the grid is left-handed: the one that points most against its own
/// patient axis.
void make_right_handed(RawVolume& raw) {
  if (raw.direction.determinant() > 0.0) return;
  Eigen::Index axis = 0;
  raw.direction.diagonal().minCoeff(&axis);
  raw.origin_mm += raw.direction.col(axis) * raw.spacing_mm[axis] * (raw.size[axis] - 1);
  raw.direction.col(axis) *= -1.0;
  const auto plane = static_cast<std::size_t>(raw.size[0]) * static_cast<std::size_t>(raw.size[1]);
  const auto row = static_cast<std::ptrdiff_t>(raw.size[0]);
  const auto begin = raw.values.begin();
  if (axis == 2) {
    for (std::size_t z = 0; z < static_cast<std::size_t>(raw.size[2]) / 2; ++z)
      std::swap_ranges(begin + static_cast<std::ptrdiff_t>(z * plane),
                       begin + static_cast<std::ptrdiff_t>((z + 1) * plane),
                       raw.values.end() - static_cast<std::ptrdiff_t>((z + 1) * plane));
    return;
  }
  for (std::size_t z = 0; z < static_cast<std::size_t>(raw.size[2]); ++z) {
    const auto slice = begin + static_cast<std::ptrdiff_t>(z * plane);
    if (axis == 0)
      for (int y = 0; y < raw.size[1]; ++y) std::reverse(slice + y * row, slice + (y + 1) * row);
    else
      for (int y = 0; y < raw.size[1] / 2; ++y)
        std::swap_ranges(slice + y * row, slice + (y + 1) * row,
                         slice + (raw.size[1] - 1 - y) * row);
  }
}

CtVolume to_ct(RawVolume raw, const fs::path& path) {
  check(raw, path);
  make_right_handed(raw);
  CtVolume ct;
  ct.description = std::move(raw.description);
  ct.remarks = std::move(raw.remarks);
  geometry::GridShape shape;
  shape.size = raw.size;
  shape.spacing = raw.spacing_mm * units::mm;
  ct.hounsfield = geometry::VoxelGrid<std::int16_t>(shape);
  std::size_t clamped = 0;
  std::size_t saturated = 0;
  for (std::size_t i = 0; i < raw.values.size(); ++i) {
    const float value = raw.values[i];
    if (value < kLowestHounsfield) ++clamped;
    if (value >= kSaturated) ++saturated;
    ct.hounsfield.values()[i] =
        static_cast<std::int16_t>(std::lround(std::max(value, kLowestHounsfield)));
  }
  if (clamped > 0)
    ct.remarks.push_back(
        fmt::format("{} voxels below -1024 HU, outside the scanner's field, were "
                    "set to -1024",
                    clamped));
  if (saturated > 0)
    ct.remarks.push_back(
        fmt::format("{} voxels at 3071 HU or above, the end of a scanner's scale: "
                    "metal, or a saturated scan",
                    saturated));
  if (raw.spacing_mm.maxCoeff() > 3.0)
    ct.remarks.push_back(
        fmt::format("voxels of {:.2f} × {:.2f} × {:.2f} mm: cortical bone thinner "
                    "than the largest of them is blurred away",
                    raw.spacing_mm[0], raw.spacing_mm[1], raw.spacing_mm[2]));
  // Through a quaternion, so that rounded header numbers become a rotation to the last digit.
  ct.X_PG.linear() = Eigen::Quaterniond(raw.direction).normalized().toRotationMatrix();
  ct.X_PG.translation() = raw.origin_mm * units::mm;
  return ct;
}

bool has_dicom_mark(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  char start[132] = {};
  return in.read(start, sizeof start) && std::memcmp(start + 128, "DICM", 4) == 0;
}

bool ends_with(const std::string& name, std::initializer_list<const char*> suffixes) {
  return std::any_of(suffixes.begin(), suffixes.end(),
                     [&](const std::string& suffix) { return name.ends_with(suffix); });
}

RawVolume read_raw(const fs::path& path, const CtOptions& options) {
  std::error_code none;
  if (!fs::exists(path, none))
    throw InvalidInput({path.string(), "", "there is no such file or folder", "check the name"});
  std::string name = path.filename().string();
  std::transform(name.begin(), name.end(), name.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; });
  if (fs::is_directory(path) || ends_with(name, {".dcm"}) || has_dicom_mark(path))
    return read_dicom(path, options);
  if (ends_with(name, {".inv3"})) return read_invesalius(path);
  if (ends_with(name, {".nii", ".nii.gz", ".nrrd", ".nhdr", ".mha", ".mhd"}))
    return read_image_file(path);
  throw InvalidInput({path.string(), path.extension().string(), "is no CT format known here",
                      "give a DICOM folder, .nii, .nii.gz, .nrrd, .nhdr, .mha, .mhd or .inv3"});
}

}  // namespace

CtVolume read_ct(const fs::path& path, const CtOptions& options) {
  return to_ct(read_raw(path, options), path);
}

geometry::VoxelGrid<float> resample(const CtVolume& ct, const geometry::GridShape& shape,
                                    const geometry::Pose& X_PW) {
  const geometry::Pose X_GW = ct.X_PG.inverse() * X_PW;
  const geometry::GridShape& grid = ct.hounsfield.shape();
  for (int corner = 0; corner < 8; ++corner) {
    const Vector3 p_W = shape.centre((corner & 1) != 0 ? shape.size[0] - 1 : 0,
                                     (corner & 2) != 0 ? shape.size[1] - 1 : 0,
                                     (corner & 4) != 0 ? shape.size[2] - 1 : 0);
    const Vector3 p_G = X_GW * p_W;
    if ((p_G.array() < grid.lower_corner().array()).any() ||
        (p_G.array() > grid.upper_corner().array()).any()) {
      const Vector3 mm = p_W / units::mm;
      const Vector3 patient = X_PW * p_W / units::mm;
      const Vector3 extent = (grid.upper_corner() - grid.lower_corner()) / units::mm;
      throw InvalidInput(
          {"region",
           fmt::format("corner ({:.1f}, {:.1f}, {:.1f}) mm of the work frame", mm.x(), mm.y(),
                       mm.z()),
           fmt::format("reaches out of the CT of {:.1f} × {:.1f} × {:.1f} mm: it is at ({:.1f}, "
                       "{:.1f}, {:.1f}) mm of the patient frame",
                       extent.x(), extent.y(), extent.z(), patient.x(), patient.y(), patient.z()),
           "move the work frame or make the region smaller"});
    }
  }
  geometry::VoxelGrid<float> out(shape);
  tbb::parallel_for(0, shape.size[2], [&](int z) {
    for (int y = 0; y < shape.size[1]; ++y)
      for (int x = 0; x < shape.size[0]; ++x)
        out.at(x, y, z) =
            static_cast<float>(geometry::sample(ct.hounsfield, X_GW * shape.centre(x, y, z)));
  });
  return out;
}

}  // namespace osteomill::io
