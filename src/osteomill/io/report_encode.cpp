// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/report_encode.hpp"

#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <new>
#include <type_traits>
#include <unordered_map>

namespace osteomill::io {
namespace {

static_assert(std::endian::native == std::endian::little, "the page reads little-endian arrays");

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

template <typename T>
std::string pack(const std::vector<T>& values) {
  // First all lowest bytes, then all second ones, ...: neighbours differ in the low bytes only, so
  // the high ones deflate to nearly nothing.
  std::string bytes(values.size() * sizeof(T), '\0');
  for (std::size_t i = 0; i < values.size(); ++i) {
    char raw[sizeof(T)];
    std::memcpy(raw, &values[i], sizeof(T));
    for (std::size_t b = 0; b < sizeof(T); ++b) bytes[b * values.size() + i] = raw[b];
  }
  uLongf size = compressBound(bytes.size());
  std::string small(size, '\0');
  if (compress2(reinterpret_cast<Bytef*>(small.data()), &size,
                reinterpret_cast<const Bytef*>(bytes.data()), bytes.size(), 6) != Z_OK)
    throw std::bad_alloc();  // the only way in which compress2 can fail here
  small.resize(size);
  return base64(small);
}

template <typename T>
std::string pack_differences(std::vector<T> values) {
  static_assert(std::is_unsigned_v<T>);
  for (std::size_t i = values.size(); i-- > 1;)
    values[i] = static_cast<T>(values[i] - values[i - 1]);
  return pack(values);
}

/// Cells of a grid by their integer coordinates, 21 bits each.
std::uint64_t cell_key(const Eigen::Vector3f& point, const Eigen::Vector3f& low, float size) {
  const Eigen::Vector3f place = (point - low) / size;
  std::uint64_t key = 0;
  for (int a = 0; a < 3; ++a)
    key = key << 21 | static_cast<std::uint64_t>(std::clamp(place[a], 0.0f, 2e6f));
  return key;
}

geometry::Mesh merged(const geometry::Mesh& mesh, const Eigen::Vector3f& low, float cell) {
  geometry::Mesh result;
  std::unordered_map<std::uint64_t, unsigned> vertex_of;
  std::vector<unsigned> to(mesh.vertices.size());
  std::vector<float> count;
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const auto next = static_cast<unsigned>(result.vertices.size());
    const auto [where, is_new] = vertex_of.try_emplace(cell_key(mesh.vertices[i], low, cell), next);
    to[i] = where->second;
    if (is_new) {
      result.vertices.push_back(mesh.vertices[i]);
      if (!mesh.values.empty()) result.values.push_back(mesh.values[i]);
      count.push_back(1.0f);
    } else {
      const float share = 1.0f / ++count[to[i]];
      result.vertices[to[i]] += share * (mesh.vertices[i] - result.vertices[to[i]]);
      if (!mesh.values.empty())
        result.values[to[i]] += share * (mesh.values[i] - result.values[to[i]]);
    }
  }
  for (const auto& [a, b, c] : mesh.triangles)
    if (to[a] != to[b] && to[b] != to[c] && to[c] != to[a])
      result.triangles.push_back({to[a], to[b], to[c]});
  return result;
}

}  // namespace

std::string base64(std::string_view bytes) {
  static constexpr char digits[] =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t three = 0;
    for (std::size_t k = 0; k < 3; ++k)
      three = three << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k)
      text += i + k <= bytes.size() ? digits[three >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

std::string pack_floats(std::span<const double> values) {
  std::vector<float> narrow(values.size());
  std::transform(values.begin(), values.end(), narrow.begin(),
                 [](double value) { return static_cast<float>(value); });
  return pack(narrow);
}

std::string pack_indices(std::span<const std::uint32_t> values) {
  return pack_differences(std::vector<std::uint32_t>(values.begin(), values.end()));
}

std::string pack_steps(std::span<const float> values, float low, float high) {
  const float per_step = high > low ? 65534.0f / (high - low) : 0.0f;
  std::vector<std::uint16_t> steps(values.size());
  std::transform(values.begin(), values.end(), steps.begin(), [&](float value) {
    if (std::isnan(value)) return std::uint16_t{65535};
    return static_cast<std::uint16_t>(
        std::lround(std::clamp((value - low) * per_step, 0.0f, 65534.0f)));
  });
  return pack_differences(std::move(steps));
}

Thinned thinned(std::span<const double> time, const std::vector<std::span<const double>>& signals,
                std::size_t most) {
  Thinned result;
  const std::size_t intervals = std::max<std::size_t>(most, 4) / 2;
  if (time.size() <= 2 * intervals) {
    result.time.assign(time.begin(), time.end());
    for (const auto& signal : signals) result.signals.emplace_back(signal.begin(), signal.end());
    return result;
  }
  const auto start = [&](std::size_t interval) { return interval * time.size() / intervals; };
  for (std::size_t k = 0; k < intervals; ++k) {
    const std::size_t from = start(k), to = start(k + 1);
    result.time.push_back(time[from]);
    result.time.push_back(time[std::max(from + 1, (from + to) / 2)]);
  }
  result.time.back() = time.back();
  for (const auto& signal : signals) {
    auto& values = result.signals.emplace_back();
    values.reserve(2 * intervals);
    for (std::size_t k = 0; k < intervals; ++k) {
      std::size_t least = time.size(), largest = time.size();
      for (std::size_t i = start(k); i < start(k + 1); ++i) {
        if (std::isnan(signal[i])) continue;
        if (least == time.size() || signal[i] < signal[least]) least = i;
        if (largest == time.size() || signal[i] > signal[largest]) largest = i;
      }
      for (const std::size_t i : {std::min(least, largest), std::max(least, largest)})
        values.push_back(i < time.size() ? signal[i] : kNaN);
    }
  }
  return result;
}

double mean_edge(const geometry::Mesh& mesh) {
  double sum = 0.0;
  for (const auto& t : mesh.triangles)
    for (std::size_t k = 0; k < 3; ++k)
      sum += (mesh.vertices[t[k]] - mesh.vertices[t[(k + 1) % 3]]).norm();
  return mesh.triangles.empty() ? 0.0 : sum / (3.0 * static_cast<double>(mesh.triangles.size()));
}

geometry::Mesh coarsened(const geometry::Mesh& mesh, std::size_t most_triangles) {
  if (mesh.triangles.size() <= most_triangles) return mesh;
  Eigen::Vector3f low = mesh.vertices.front();
  for (const auto& vertex : mesh.vertices) low = low.cwiseMin(vertex);
  // The number of triangles goes with the inverse square of the cells' size.
  const double excess = static_cast<double>(mesh.triangles.size()) /
                        static_cast<double>(std::max<std::size_t>(most_triangles, 1));
  auto cell = static_cast<float>(0.8 * mean_edge(mesh) * std::sqrt(excess));
  if (!(cell > 0.0f)) return {};  // every triangle is a point
  geometry::Mesh result = merged(mesh, low, cell);
  while (result.triangles.size() > most_triangles) {
    cell *= 1.15f;
    result = merged(mesh, low, cell);
  }
  return result;
}

std::vector<float> reach_times(const std::vector<Eigen::Vector3f>& vertices,
                               std::span<const double> time,
                               std::span<const geometry::Vector3> tips,
                               std::span<const geometry::Vector3> axes,
                               const cutting::Cutter& cutter, double margin) {
  std::vector<float> result(vertices.size(), std::numeric_limits<float>::quiet_NaN());
  if (vertices.empty() || tips.empty()) return result;

  Eigen::Vector3f low = vertices.front();
  for (const auto& vertex : vertices) low = low.cwiseMin(vertex);
  low.array() -= static_cast<float>(cutter.radius);
  const auto cell = static_cast<float>(cutter.radius);
  std::unordered_map<std::uint64_t, std::vector<unsigned>> waiting;
  for (unsigned i = 0; i < vertices.size(); ++i)
    waiting[cell_key(vertices[i], low, cell)].push_back(i);

  const double reach = cutter.radius + margin, length = cutter.cutting_length + margin;
  const auto visit = [&](double at, const geometry::Vector3& tip, const geometry::Vector3& axis) {
    const auto touched = [&](unsigned i) {
      const geometry::Vector3 from_tip = vertices[i].cast<double>() - tip;
      const double z = from_tip.dot(axis);
      if (z < -margin || z > length) return false;
      const double z_cutter = std::clamp(z + margin, 0.0, cutter.cutting_length);
      return (from_tip - z * axis).norm() <= cutting::radius_at(cutter, z_cutter) + margin;
    };
    // A box around the axis from the tip to the end of the edges, cell by cell.
    const geometry::Vector3 end = tip + length * axis;
    const Eigen::Vector3f from =
        (tip.cwiseMin(end) - geometry::Vector3::Constant(reach)).cast<float>();
    const Eigen::Vector3f to =
        (tip.cwiseMax(end) + geometry::Vector3::Constant(reach)).cast<float>();
    for (float x = from.x(); x < to.x() + cell; x += cell)
      for (float y = from.y(); y < to.y() + cell; y += cell)
        for (float z = from.z(); z < to.z() + cell; z += cell) {
          const auto found = waiting.find(cell_key({x, y, z}, low, cell));
          if (found == waiting.end()) continue;
          std::erase_if(found->second, [&](unsigned i) {
            if (!touched(i)) return false;
            result[i] = static_cast<float>(at);
            return true;
          });
          if (found->second.empty()) waiting.erase(found);
        }
  };

  const auto axis_at = [&](std::size_t k) -> const geometry::Vector3& {
    return axes.size() == 1 ? axes.front() : axes[k];
  };
  visit(time[0], tips[0], axis_at(0));
  std::size_t last = 0;
  const double step = cutter.radius / 8.0;
  for (std::size_t k = 1; k < tips.size() && !waiting.empty(); ++k) {
    const double distance = (tips[k] - tips[last]).norm();
    if (distance < step && k + 1 < tips.size()) continue;
    const int parts = std::max(1, static_cast<int>(std::ceil(distance / step)));
    for (int p = 1; p <= parts; ++p) {
      const double s = static_cast<double>(p) / parts;
      visit(std::lerp(time[last], time[k], s), tips[last] + s * (tips[k] - tips[last]), axis_at(k));
    }
    last = k;
  }
  return result;
}

}  // namespace osteomill::io
