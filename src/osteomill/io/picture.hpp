// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "osteomill/geometry/mesh.hpp"
#include "osteomill/io/colour.hpp"

/// Shaded pictures of surfaces and paths, drawn by following rays of light: soft shadow, darker
/// hollows, colours by value with their legend. Lengths are SI.
namespace osteomill::io {

inline constexpr Colour kBoneColour{0.93F, 0.86F, 0.74F};
inline constexpr Colour kSteelColour{0.62F, 0.66F, 0.70F};

/// Its values, where it has some, are coloured by the picture's `mesh_values`.
struct PictureMesh {
  geometry::Mesh mesh;
  Colour colour = kBoneColour;  ///< where it has no values
};

/// A round tube along points.
struct PictureLine {
  std::vector<geometry::Vector3> points;  ///< m
  std::vector<double> values{};           ///< one a point, coloured by `line_values`, or empty
  double radius = 0.4e-3;                 ///< m
  Colour colour{0.84F, 0.37F, 0.0F};      ///< where it has no values
};

/// One scene; several stand side by side, seen from one place.
struct PictureView {
  std::string caption;
  std::vector<PictureMesh> meshes;
  std::vector<PictureLine> lines{};
};

struct PictureLegend {
  std::string label;  ///< with the unit
  double low = 0.0;
  double high = 1.0;
  ColourMap colours = ColourMap::viridis;
};

struct PictureCamera {
  geometry::Vector3 from{0.4, -0.75, 1.1};  ///< direction from the scene to the eye
  geometry::Vector3 up{0.0, 0.0, 1.0};
  double field_of_view_deg = 0.0;  ///< 0: parallel rays, with a bar of scale
  double zoom = 1.0;               ///< 1 shows all of it
};

struct Picture {
  std::string title;
  std::vector<PictureView> views;
  PictureCamera camera{};
  std::optional<PictureLegend> mesh_values{};
  std::optional<PictureLegend> line_values{};
  int width = 900;  ///< points, two pixels each
  int height = 0;   ///< points; 0: as much as the scene needs
};

/// Writes a PNG. InvalidInput when there is nothing to see or a mesh is broken, WorldError when the
/// file cannot be written. The same picture on any number of threads.
void draw(const Picture& picture, const std::filesystem::path& path);

}  // namespace osteomill::io
