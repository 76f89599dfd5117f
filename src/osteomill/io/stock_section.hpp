// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "osteomill/io/mesh_file.hpp"
#include "osteomill/simulate/line_profile.hpp"
#include "osteomill/workpiece/knee_phantoms.hpp"
#include "osteomill/workpiece/phantoms.hpp"
#include "osteomill/workpiece/stock.hpp"

namespace osteomill::io {

class Section;

enum class StockKind : std::uint8_t {
  line_profile,
  block,
  tibia_section,
  proximal_tibia,
  distal_femur,
  mesh,
  ct
};

/// The surface of a bone without a CT; its inside is painted.
struct MeshStock {
  LengthUnit unit = LengthUnit::guess;
  bool turn_inside_out = false;  ///< an inside-out surface is turned rather than refused
  std::optional<std::array<double, 3>> joint;       ///< at the joint's level, frame of the mesh, m
  std::optional<std::array<double, 3>> joint_axis;  ///< from the shaft to the joint
  double shaft = 70e-3;  ///< below the joint the shell has its full thickness, m
};

/// [stock]: the bone before the cut. The work frame W has z towards the spindle.
struct StockCase {
  StockKind kind = StockKind::block;
  std::string note;                            ///< what the reader of the result has to know
  simulate::LineProfile profile;               ///< line-profile; its path keys come from [path]
  double spacing = 0.2e-3;                     ///< of the voxels, m
  std::optional<std::array<double, 3>> lower;  ///< corners of the region in W, m;
  std::optional<std::array<double, 3>> upper;  ///< none: the whole bone
  double density = 0.0;                        ///< of a block, kg/m³
  std::optional<double> force_scale;           ///< of a block; none: by density
  workpiece::TibiaSection tibia;               ///< densities and sizes
  workpiece::ProximalTibia proximal_tibia;
  workpiece::DistalFemur distal_femur;
  workpiece::EpiphysisBone painted;  ///< of a mesh and of the knee's phantoms
  MeshStock mesh;
  std::filesystem::path file;             ///< ct, mesh
  std::string series;                     ///< ct
  std::vector<std::string> accept;        ///< ct: what would be refused: metal, thick-slices
  std::array<double, 3> origin{};         ///< of W in the patient frame, m
  std::array<double, 3> x_axis{1, 0, 0};  ///< of W in the patient frame
  std::array<double, 3> z_axis{0, 0, 1};  ///< of W in the patient frame
  workpiece::BoneFromCt bone_from_ct;
  std::optional<std::array<double, 3>> fibre;  ///< direction in W; none: see fibre_of()
  bool fibre_from_ct = false;                  ///< by the structure tensor, cell by cell
  double fibre_cell = 4e-3;                    ///< m

  bool accepts(const char* what) const;
};

/// Voxels of a region that this computer has the memory for: the stock and the copy in which the
/// path's contacts are found take four bytes each for a voxel with bone, and half of a region is
/// taken to be bone.
double most_voxels();

void bind_stock(Section& section, StockCase& stock);

}  // namespace osteomill::io
