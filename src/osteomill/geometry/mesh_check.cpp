// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/geometry/mesh_check.hpp"

#include <algorithm>
#include <cstdint>
#include <utility>

namespace osteomill::geometry {
namespace {

std::array<Vector3, 3> corners(const Mesh& mesh, const std::array<unsigned, 3>& triangle) {
  return {mesh.vertices[triangle[0]].cast<double>(), mesh.vertices[triangle[1]].cast<double>(),
          mesh.vertices[triangle[2]].cast<double>()};
}

}  // namespace

double volume(const Mesh& mesh) {
  if (mesh.vertices.empty()) return 0.0;
  // About a point of the mesh, so that a far origin costs no digits.
  const Vector3 middle = mesh.vertices.front().cast<double>();
  double sum = 0.0;
  for (const auto& triangle : mesh.triangles) {
    const auto [a, b, c] = corners(mesh, triangle);
    sum += (a - middle).dot((b - middle).cross(c - middle));
  }
  return sum / 6.0;
}

double area(const Mesh& mesh) {
  double sum = 0.0;
  for (const auto& triangle : mesh.triangles) {
    const auto [a, b, c] = corners(mesh, triangle);
    sum += 0.5 * (b - a).cross(c - a).norm();
  }
  return sum;
}

MeshFlaws flaws(const Mesh& mesh) {
  MeshFlaws found;
  // An edge is its two vertices in order, and whether the triangle runs along it that way.
  std::vector<std::pair<std::uint64_t, bool>> edges;
  edges.reserve(mesh.triangles.size() * 3);
  for (const auto& triangle : mesh.triangles) {
    const auto [a, b, c] = corners(mesh, triangle);
    if ((b - a).cross(c - a).isZero(0.0)) ++found.flat_triangles;
    for (std::size_t k = 0; k < 3; ++k) {
      const unsigned from = triangle[k];
      const unsigned to = triangle[(k + 1) % 3];
      const std::uint64_t low = std::min(from, to);
      const std::uint64_t high = std::max(from, to);
      edges.emplace_back((low << 32) | high, from < to);
    }
  }
  std::sort(edges.begin(), edges.end());
  for (std::size_t begin = 0; begin < edges.size();) {
    std::size_t end = begin;
    std::size_t forward = 0;
    while (end < edges.size() && edges[end].first == edges[begin].first)
      forward += edges[end++].second ? 1 : 0;
    const std::size_t count = end - begin;
    if (count == 1)
      ++found.open_edges;
    else if (count > 2)
      ++found.crowded_edges;
    else if (forward != 1)
      ++found.turned_edges;
    begin = end;
  }
  return found;
}

}  // namespace osteomill::geometry
