// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/mesh_file.hpp"

#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/format.h>

#include <assimp/Importer.hpp>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/io/ply_check.hpp"
#include "osteomill/io/text_file.hpp"

namespace osteomill::io {
namespace {

namespace fs = std::filesystem;

// A bone or a piece of one that is milled, and a whole body.
constexpr double kSmallest = 3.0 * units::mm;
constexpr double kLargest = 2.5;
constexpr double kSmallBone =
    15.0 * units::mm;  // a smaller one in mm may well be ten times as large

double metres(LengthUnit unit) {
  switch (unit) {
    case LengthUnit::centimetre:
      return 10.0 * units::mm;
    case LengthUnit::metre:
      return 1.0;
    case LengthUnit::inch:
      return 25.4 * units::mm;
    case LengthUnit::millimetre:
    case LengthUnit::guess:
      break;
  }
  return units::mm;
}

const char* name(LengthUnit unit) {
  switch (unit) {
    case LengthUnit::centimetre:
      return "cm";
    case LengthUnit::metre:
      return "m";
    case LengthUnit::inch:
      return "inch";
    case LengthUnit::millimetre:
    case LengthUnit::guess:
      break;
  }
  return "mm";
}

geometry::Mesh load(const fs::path& path) {
  std::error_code none;
  if (!fs::is_regular_file(path, none))
    throw InvalidInput({path.string(), "", "there is no such file", "check the name"});
  std::string suffix = path.extension().string();
  for (char& c : suffix) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c;
  if (suffix != ".stl" && suffix != ".ply" && suffix != ".obj")
    throw InvalidInput(
        {path.string(), suffix, "is no mesh format known here", "give .stl, .ply or .obj"});
  if (suffix == ".ply") check_ply_is_whole(path);
  Assimp::Importer importer;
  // Positions and triangles only; equal vertices are merged by what they are, not by normals.
  importer.SetPropertyInteger(AI_CONFIG_PP_RVC_FLAGS,
                              aiComponent_NORMALS | aiComponent_TEXCOORDS | aiComponent_COLORS |
                                  aiComponent_MATERIALS | aiComponent_TEXTURES);
  const aiScene* scene =
      importer.ReadFile(path.string(), aiProcess_RemoveComponent | aiProcess_Triangulate |
                                           aiProcess_PreTransformVertices);
  if (scene == nullptr)
    throw InvalidInput({path.string(), "",
                        std::string("cannot be read: ") + importer.GetErrorString(),
                        "the file is truncated or no mesh; export it again"});
  geometry::Mesh mesh;
  for (unsigned m = 0; m < scene->mNumMeshes; ++m) {
    const aiMesh& part = *scene->mMeshes[m];
    const auto offset = static_cast<unsigned>(mesh.vertices.size());
    for (unsigned v = 0; v < part.mNumVertices; ++v) {
      const aiVector3D& p = part.mVertices[v];
      if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z))
        throw InvalidInput(
            {path.string(), fmt::format("vertex {}", v), "is not finite", "export the mesh again"});
      mesh.vertices.emplace_back(p.x, p.y, p.z);
    }
    for (unsigned f = 0; f < part.mNumFaces; ++f)
      if (part.mFaces[f].mNumIndices == 3)
        mesh.triangles.push_back({offset + part.mFaces[f].mIndices[0],
                                  offset + part.mFaces[f].mIndices[1],
                                  offset + part.mFaces[f].mIndices[2]});
  }
  if (mesh.triangles.empty())
    throw InvalidInput({path.string(), "0 triangles", "holds no surface", "export the mesh again"});
  return mesh;
}

Eigen::Vector3f extent(const geometry::Mesh& mesh) {
  Eigen::Vector3f low = mesh.vertices.front();
  Eigen::Vector3f high = low;
  for (const Eigen::Vector3f& v : mesh.vertices) {
    low = low.cwiseMin(v);
    high = high.cwiseMax(v);
  }
  return high - low;
}

template <class T>
void put(std::string& out, T value) {
  static_assert(std::endian::native == std::endian::little);
  char bytes[sizeof value];
  std::memcpy(bytes, &value, sizeof value);
  out.append(bytes, sizeof value);
}

std::string stl_of(const geometry::Mesh& mesh) {
  std::string out = "binary STL in mm, written by osteomill";
  out.resize(80, ' ');
  put(out, static_cast<std::uint32_t>(mesh.triangles.size()));
  for (const auto& triangle : mesh.triangles) {
    const auto p = [&](std::size_t k) -> const Eigen::Vector3f& {
      return mesh.vertices[triangle[k]];
    };
    const Eigen::Vector3f normal = (p(1) - p(0)).cross(p(2) - p(0)).stableNormalized();
    for (int i = 0; i < 3; ++i) put(out, normal[i]);
    for (std::size_t k = 0; k < 3; ++k)
      for (int i = 0; i < 3; ++i) put(out, p(k)[i] / static_cast<float>(units::mm));
    put(out, std::uint16_t{0});
  }
  return out;
}

std::string ply_of(const geometry::Mesh& mesh, const std::optional<ValueColours>& colours) {
  const bool coloured = colours && !mesh.values.empty();
  std::string out = fmt::format(
      "ply\nformat binary_little_endian 1.0\ncomment lengths in mm, written by osteomill\n"
      "element vertex {}\nproperty float x\nproperty float y\nproperty float z\n{}{}"
      "element face {}\nproperty list uchar int vertex_indices\nend_header\n",
      mesh.vertices.size(), mesh.values.empty() ? "" : "property float value\n",
      coloured ? "property uchar red\nproperty uchar green\nproperty uchar blue\n" : "",
      mesh.triangles.size());
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    for (int i = 0; i < 3; ++i) put(out, mesh.vertices[v][i] / static_cast<float>(units::mm));
    if (!mesh.values.empty()) put(out, mesh.values[v]);
    if (!coloured) continue;
    constexpr Colour kNoValue{0.75F, 0.75F, 0.75F};
    const double width = colours->high > colours->low ? colours->high - colours->low : 1.0;
    const double at = (mesh.values[v] - colours->low) / width;
    for (const float part : std::isfinite(at) ? colour_at(colours->map, at) : kNoValue)
      put(out, static_cast<std::uint8_t>(std::lround(255.0F * part)));
  }
  for (const auto& triangle : mesh.triangles) {
    put(out, std::uint8_t{3});
    for (const unsigned corner : triangle) put(out, static_cast<std::int32_t>(corner));
  }
  return out;
}

}  // namespace

MeshFile read_mesh(const fs::path& path, const MeshOptions& options) {
  MeshFile file;
  file.mesh = load(path);
  const double size = extent(file.mesh).maxCoeff();
  const auto fits = [&](LengthUnit unit) {
    return size * metres(unit) >= kSmallest && size * metres(unit) <= kLargest;
  };
  file.unit = options.unit;
  file.unit_reason = "given";
  if (options.unit == LengthUnit::guess) {
    if (size > kLargest && size * units::mm < kSmallBone)
      throw InvalidInput({path.string(), fmt::format("{0:.4g} mm or {0:.4g} cm across", size),
                          "could be either", "give the unit of its lengths"});
    // Millimetres are what nearly all programs write; metres where that would be a speck.
    file.unit = fits(LengthUnit::millimetre) ? LengthUnit::millimetre : LengthUnit::metre;
    file.unit_reason = fmt::format(
        "guessed: the file does not say, and {:.4g} {} is the size of "
        "a bone",
        size, name(file.unit));
  }
  if (!fits(file.unit)) {
    const bool guessed = options.unit == LengthUnit::guess;
    throw InvalidInput(
        {path.string(),
         fmt::format("{:.4g} {} across", size, guessed ? "mm or m" : name(file.unit)),
         "is not the size of a bone: 3 mm … 2.5 m",
         guessed ? "give the unit of its lengths" : "give another unit of its lengths"});
  }
  for (Eigen::Vector3f& v : file.mesh.vertices) v *= static_cast<float>(metres(file.unit));
  geometry::MeshRepairOptions mend;
  mend.largest_hole = options.largest_hole;
  mend.widest_hole = options.widest_hole;
  const geometry::Mesh as_read = file.mesh;
  file.repair = geometry::repair(file.mesh, mend);
  if (!file.repair.left.watertight()) {
    // Once more with vertices welded that lie within a few of the last digits of each other.
    geometry::Mesh welded = as_read;
    mend.weld = 2e-6 * size * metres(file.unit);
    const geometry::MeshRepair again = geometry::repair(welded, mend);
    if (again.left.open_edges < file.repair.left.open_edges) {
      file.mesh = std::move(welded);
      file.repair = again;
    }
  }
  const Eigen::Vector3f mm = extent(file.mesh) / static_cast<float>(units::mm);
  file.description =
      fmt::format("{}: {} triangles, {:.1f} × {:.1f} × {:.1f} mm (unit {}, {}); {}",
                  path.filename().string(), file.mesh.triangles.size(), mm.x(), mm.y(), mm.z(),
                  name(file.unit), file.unit_reason, geometry::describe(file.repair));
  return file;
}

MeshFile read_solid(const fs::path& path, const MeshOptions& options) {
  MeshFile file = read_mesh(path, options);
  if (!file.repair.left.watertight())
    throw InvalidInput({path.string(), geometry::describe(file.repair),
                        "must enclose a solid: no open edges, none of more than two triangles",
                        "close it in a mesh editor (for instance MeshLab or Blender)"});
  return file;
}

void write_mesh(const geometry::Mesh& mesh, const fs::path& path,
                const std::optional<ValueColours>& colours) {
  if (path.extension() == ".stl")
    write_text_file(path, stl_of(mesh));
  else if (path.extension() == ".ply")
    write_text_file(path, ply_of(mesh, colours));
  else
    throw InvalidInput({path.string(), path.extension().string(), "must end in .stl or .ply",
                        "choose one of these formats"});
}

}  // namespace osteomill::io
