// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "osteomill/cutting/cutter.hpp"
#include "osteomill/geometry/mesh.hpp"

/// How big arrays travel within a page: bytes of equal significance together, deflated, base64. And
/// what makes them small enough to travel.
namespace osteomill::io {

std::string base64(std::string_view bytes);

/// Little-endian float32.
std::string pack_floats(std::span<const double> values);

/// Little-endian uint32 differences from the value before, modulo 2^32.
std::string pack_indices(std::span<const std::uint32_t> values);

/// Steps 0...65534 of [low, high] as uint16 differences from the value before, modulo 2^16. NaN
/// becomes step 65535.
std::string pack_steps(std::span<const float> values, float low, float high);

/// Signals over one time.
struct Thinned {
  std::vector<double> time;
  std::vector<std::vector<double>> signals;
};

/// At most `most` samples (at least four) of each signal. Long signals are cut into short
/// intervals, and each gives the least and the largest value in the order in which they came, so
/// that no peak is lost and none moves by more than an interval. An interval without finite values
/// gives NaN.
Thinned thinned(std::span<const double> time, const std::vector<std::span<const double>>& signals,
                std::size_t most);

/// Merges the vertices within cells of a grid until few enough triangles are left; values of a
/// merged vertex are means. An unchanged copy when the mesh is small enough.
geometry::Mesh coarsened(const geometry::Mesh& mesh, std::size_t most_triangles);

/// Mean length of the edges, m; 0 without triangles.
double mean_edge(const geometry::Mesh& mesh);

/// When a moving cutter first came within `margin` (m) of each vertex, s; NaN where it never did.
/// The tip moves straight from place to place; axes is one for all times or one for each.
std::vector<float> reach_times(const std::vector<Eigen::Vector3f>& vertices,
                               std::span<const double> time,
                               std::span<const geometry::Vector3> tips,
                               std::span<const geometry::Vector3> axes,
                               const cutting::Cutter& cutter, double margin);

}  // namespace osteomill::io
