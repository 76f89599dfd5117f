// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "osteomill/geometry/mesh.hpp"
#include "osteomill/geometry/mesh_repair.hpp"
#include "osteomill/io/colour.hpp"

namespace osteomill::io {

/// The unit of the numbers in a mesh file, which STL, PLY and OBJ do not say.
enum class LengthUnit { guess, millimetre, centimetre, metre, inch };

struct MeshOptions {
  LengthUnit unit = LengthUnit::guess;
  std::size_t largest_hole = 60;  ///< edges; larger holes are left open
  double widest_hole = 0.25;      ///< share of the diagonal; wider holes are left open
};

/// A surface that was read, mended as far as it goes.
struct MeshFile {
  geometry::Mesh mesh;      ///< m
  LengthUnit unit{};        ///< of the file, given or guessed
  std::string unit_reason;  ///< why, for the report
  geometry::MeshRepair repair;
  std::string description;  ///< file, triangles, size, unit, what was mended
};

/// Reads STL, PLY or OBJ. InvalidInput when the file is missing, broken or empty, or when no unit
/// makes it the size of a bone.
MeshFile read_mesh(const std::filesystem::path& path, const MeshOptions& options = {});

/// As read_mesh, and InvalidInput when the surface is not watertight after all.
MeshFile read_solid(const std::filesystem::path& path, const MeshOptions& options = {});

/// How values become colours: the ends of the map stand for low and high.
struct ValueColours {
  ColourMap map = ColourMap::viridis;
  double low = 0.0;
  double high = 1.0;
};

/// Writes binary STL or PLY by the suffix, in mm; values go into PLY as a property "value", and as
/// red, green and blue where it is said how. WorldError when the disk refuses.
void write_mesh(const geometry::Mesh& mesh, const std::filesystem::path& path,
                const std::optional<ValueColours>& colours = {});

}  // namespace osteomill::io
