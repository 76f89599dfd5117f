// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/geometry/mesh_repair.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <set>
#include <unordered_map>
#include <utility>

#include "osteomill/base/units.hpp"

namespace osteomill::geometry {
namespace {

using Triangle = std::array<unsigned, 3>;

/// Neighbouring vertices by a grid of cells as wide as the welding distance.
std::size_t merge_vertices(Mesh& mesh, double weld) {
  using Cell = std::array<std::int64_t, 3>;
  const auto cell_of = [&](const Eigen::Vector3f& v) {
    Cell cell{};
    for (int i = 0; i < 3; ++i) {
      // Without a distance equal numbers are one vertex; + 0 makes one of both zeros.
      const float value = v[i] + 0.0F;
      std::int32_t bits = 0;
      static_assert(sizeof bits == sizeof value);
      std::copy_n(reinterpret_cast<const char*>(&value), sizeof bits,
                  reinterpret_cast<char*>(&bits));
      cell[static_cast<std::size_t>(i)] =
          weld > 0.0 ? static_cast<std::int64_t>(std::floor(v[i] / weld)) : bits;
    }
    return cell;
  };
  std::map<Cell, std::vector<unsigned>> kept_in;
  std::vector<unsigned> to(mesh.vertices.size());
  Mesh merged;
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const Eigen::Vector3f& vertex = mesh.vertices[i];
    const Cell home = cell_of(vertex);
    const int around = weld > 0.0 ? 1 : 0;
    const unsigned none = static_cast<unsigned>(mesh.vertices.size());
    unsigned found = none;
    for (int dx = -around; dx <= around && found == none; ++dx)
      for (int dy = -around; dy <= around && found == none; ++dy)
        for (int dz = -around; dz <= around && found == none; ++dz) {
          const auto it = kept_in.find({home[0] + dx, home[1] + dy, home[2] + dz});
          if (it == kept_in.end()) continue;
          for (const unsigned other : it->second)
            if ((merged.vertices[other] - vertex).norm() <= static_cast<float>(weld)) {
              found = other;
              break;
            }
        }
    if (found == none) {
      found = static_cast<unsigned>(merged.vertices.size());
      merged.vertices.push_back(vertex);
      if (!mesh.values.empty()) merged.values.push_back(mesh.values[i]);
      kept_in[home].push_back(found);
    }
    to[i] = found;
  }
  for (Triangle& triangle : mesh.triangles)
    for (unsigned& corner : triangle) corner = to[corner];
  const std::size_t count = mesh.vertices.size() - merged.vertices.size();
  mesh.vertices = std::move(merged.vertices);
  mesh.values = std::move(merged.values);
  return count;
}

std::size_t drop_triangles(Mesh& mesh) {
  std::set<Triangle> seen;
  const std::size_t before = mesh.triangles.size();
  std::erase_if(mesh.triangles, [&](const Triangle& t) {
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) return true;
    Triangle sorted = t;
    std::sort(sorted.begin(), sorted.end());
    return !seen.insert(sorted).second;
  });
  return before - mesh.triangles.size();
}

struct Side {
  std::uint64_t edge = 0;  ///< its two vertices in order
  unsigned triangle = 0;
  bool forward = false;  ///< the triangle runs from the lower to the higher
  bool operator<(const Side& other) const {
    return edge != other.edge ? edge < other.edge : triangle < other.triangle;
  }
};

std::vector<Side> sides_of(const Mesh& mesh) {
  std::vector<Side> sides;
  sides.reserve(mesh.triangles.size() * 3);
  for (unsigned t = 0; t < mesh.triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint64_t from = mesh.triangles[t][k];
      const std::uint64_t to = mesh.triangles[t][(k + 1) % 3];
      sides.push_back({(std::min(from, to) << 32) | std::max(from, to), t, from < to});
    }
  std::sort(sides.begin(), sides.end());
  return sides;
}

/// Turns triangles against their neighbours; the part that each belongs to.
std::vector<unsigned> agree(Mesh& mesh, MeshRepair& report) {
  const std::vector<Side> sides = sides_of(mesh);
  struct Neighbour {
    unsigned triangle = 0;
    bool same_way = false;  ///< both run along the edge the same way: one must be turned
  };
  std::vector<std::vector<Neighbour>> neighbours(mesh.triangles.size());
  for (std::size_t i = 0; i + 1 < sides.size(); ++i) {
    const Side& a = sides[i];
    const Side& b = sides[i + 1];
    const bool pair = a.edge == b.edge && (i == 0 || sides[i - 1].edge != a.edge) &&
                      (i + 2 == sides.size() || sides[i + 2].edge != a.edge);
    if (!pair) continue;
    neighbours[a.triangle].push_back({b.triangle, a.forward == b.forward});
    neighbours[b.triangle].push_back({a.triangle, a.forward == b.forward});
  }
  constexpr unsigned kNone = ~0u;
  std::vector<unsigned> part(mesh.triangles.size(), kNone);
  std::vector<bool> turn(mesh.triangles.size(), false);
  for (unsigned first = 0; first < mesh.triangles.size(); ++first) {
    if (part[first] != kNone) continue;
    std::vector<unsigned> members = {first};
    part[first] = static_cast<unsigned>(report.parts);
    for (std::size_t i = 0; i < members.size(); ++i)
      for (const Neighbour& next : neighbours[members[i]]) {
        if (part[next.triangle] != kNone) continue;
        part[next.triangle] = static_cast<unsigned>(report.parts);
        turn[next.triangle] = turn[members[i]] != next.same_way;
        members.push_back(next.triangle);
      }
    // The majority is right, whichever triangle came first.
    const auto turned = static_cast<std::size_t>(
        std::count_if(members.begin(), members.end(), [&](unsigned t) { return turn[t]; }));
    const bool other_way = 2 * turned > members.size();
    for (const unsigned t : members)
      if (turn[t] != other_way) {
        std::swap(mesh.triangles[t][1], mesh.triangles[t][2]);
        ++report.turned_triangles;
      }
    ++report.parts;
  }
  return part;
}

struct Box {
  Eigen::Vector3f low = Eigen::Vector3f::Constant(std::numeric_limits<float>::max());
  Eigen::Vector3f high = -low;
  void add(const Eigen::Vector3f& p) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
};

void close_holes(Mesh& mesh, std::vector<unsigned>& part, const MeshRepairOptions& options,
                 MeshRepair& report) {
  std::vector<Box> part_box(report.parts);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (const unsigned v : mesh.triangles[t]) part_box[part[t]].add(mesh.vertices[v]);
  std::multimap<unsigned, std::pair<unsigned, unsigned>> next;  // vertex → next vertex, part
  const std::vector<Side> sides = sides_of(mesh);
  for (std::size_t i = 0; i < sides.size(); ++i) {
    if ((i > 0 && sides[i - 1].edge == sides[i].edge) ||
        (i + 1 < sides.size() && sides[i + 1].edge == sides[i].edge))
      continue;
    const auto low = static_cast<unsigned>(sides[i].edge >> 32);
    const auto high = static_cast<unsigned>(sides[i].edge & 0xFFFFFFFFu);
    // Around the hole against the way of the triangle.
    next.emplace(sides[i].forward ? high : low,
                 std::pair{sides[i].forward ? low : high, part[sides[i].triangle]});
  }
  while (!next.empty()) {
    std::vector<unsigned> rim;
    const unsigned of_part = next.begin()->second.second;
    for (auto at = next.begin(); at != next.end(); at = next.find(rim.back())) {
      if (rim.empty()) rim.push_back(at->first);
      const unsigned to = at->second.first;
      next.erase(at);
      rim.push_back(to);
      if (to == rim.front()) break;
    }
    if (rim.size() < 4 || rim.front() != rim.back()) continue;
    rim.pop_back();
    Eigen::Vector3f middle = Eigen::Vector3f::Zero();
    float value = 0.0F;
    const float share = 1.0F / static_cast<float>(rim.size());
    Box box;
    for (const unsigned v : rim) {
      box.add(mesh.vertices[v]);
      middle += share * mesh.vertices[v];
      if (!mesh.values.empty()) value += share * mesh.values[v];
    }
    const Hole hole{rim.size(), static_cast<double>((box.high - box.low).maxCoeff()), middle};
    const double around = (part_box[of_part].high - part_box[of_part].low).norm();
    if (hole.edges > options.largest_hole || hole.width > options.widest_hole * around) {
      report.open_holes.push_back(hole);
      continue;
    }
    const auto centre = static_cast<unsigned>(mesh.vertices.size());
    mesh.vertices.push_back(middle);
    if (!mesh.values.empty()) mesh.values.push_back(value);
    for (std::size_t i = 0; i < rim.size(); ++i) {
      mesh.triangles.push_back({rim[i], rim[(i + 1) % rim.size()], centre});
      part.push_back(of_part);
    }
    report.closed_holes.push_back(hole);
  }
}

/// Turns all when the part that encloses most is inside out.
bool right_way_out(Mesh& mesh, const std::vector<unsigned>& part, std::size_t parts) {
  if (mesh.triangles.empty()) return false;
  const Vector3 middle = mesh.vertices[mesh.triangles[0][0]].cast<double>();
  std::vector<double> volumes(parts, 0.0);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    std::array<Vector3, 3> p;
    for (std::size_t k = 0; k < 3; ++k)
      p[k] = mesh.vertices[mesh.triangles[t][k]].cast<double>() - middle;
    volumes[part[t]] += p[0].dot(p[1].cross(p[2])) / 6.0;
  }
  const double largest = *std::max_element(
      volumes.begin(), volumes.end(), [](double a, double b) { return std::abs(a) < std::abs(b); });
  if (!(largest < 0.0)) return false;
  for (Triangle& t : mesh.triangles) std::swap(t[1], t[2]);
  return true;
}

}  // namespace

MeshRepair repair(Mesh& mesh, const MeshRepairOptions& options) {
  MeshRepair report;
  report.merged_vertices = merge_vertices(mesh, options.weld);
  report.dropped_triangles = drop_triangles(mesh);
  std::vector<unsigned> part = agree(mesh, report);
  close_holes(mesh, part, options, report);
  report.turned_all = right_way_out(mesh, part, report.parts);
  report.left = flaws(mesh);
  return report;
}

namespace {

/// "2 holes: one of 5 edges, 2.00 mm wide, at (1.0, 20.0, 1.7) mm, ...", the widest first.
std::string list(std::vector<Hole> holes) {
  std::sort(holes.begin(), holes.end(),
            [](const Hole& a, const Hole& b) { return a.width > b.width; });
  constexpr std::size_t kNamed = 5;
  std::string text = fmt::format("{} hole{}: ", holes.size(), holes.size() == 1 ? "" : "s");
  for (std::size_t i = 0; i < std::min(holes.size(), kNamed); ++i) {
    const Hole& hole = holes[i];
    text += fmt::format("{}of {} edges, {:.2f} mm wide, at ({:.1f}, {:.1f}, {:.1f}) mm",
                        i > 0 ? ", " : "", hole.edges, hole.width / units::mm,
                        hole.middle.x() / units::mm, hole.middle.y() / units::mm,
                        hole.middle.z() / units::mm);
  }
  return text + (holes.size() > kNamed ? ", ...; " : "; ");
}

}  // namespace

std::string describe(const MeshRepair& repair) {
  std::string text;
  const auto say = [&](std::size_t count, const char* what) {
    if (count > 0) text += fmt::format(fmt::runtime(what), count) + "; ";
  };
  say(repair.merged_vertices, "merged {} equal vertices");
  say(repair.dropped_triangles, "dropped {} flat or double triangles");
  say(repair.turned_triangles, "turned {} triangles that ran against their neighbours");
  if (repair.turned_all) text += "turned all of it, which was inside out; ";
  if (!repair.closed_holes.empty()) text += "closed " + list(repair.closed_holes);
  if (!repair.open_holes.empty()) text += "too large to be closed: " + list(repair.open_holes);
  text += fmt::format("{} part{}, ", repair.parts, repair.parts == 1 ? "" : "s");
  if (repair.left.watertight()) return text + "watertight";
  return text +
         fmt::format("not watertight: {} open edges, {} of more than two triangles, {} turned",
                     repair.left.open_edges, repair.left.crowded_edges, repair.left.turned_edges);
}

}  // namespace osteomill::geometry
