// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/map_result.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "osteomill/base/units.hpp"
#include "osteomill/io/surface.hpp"

namespace osteomill::io {
namespace {

using Json = nlohmann::ordered_json;
using geometry::Vector3;
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
// Less of the cutter in bone is the grain of the voxels at its border.
constexpr float kSeen = 0.02F;

std::vector<float> values_of(const MapResult& result, MapValue value) {
  if (value == MapValue::normal_force) return result.forces.normal;
  if (value == MapValue::feed_force) return result.forces.feed;
  std::vector<float> feeds = result.largest_feeds;
  for (float& feed : feeds) feed /= static_cast<float>(units::mm_per_s);
  return feeds;
}

const char* label_of(MapValue value) {
  switch (value) {
    case MapValue::normal_force:
      return "normal force, N";
    case MapValue::feed_force:
      return "feed force, N";
    case MapValue::largest_feed:
      break;
  }
  return "largest feed, mm/s";
}

/// To five digits: what the model is good for is less.
double rounded(double value) {
  if (value == 0.0 || !std::isfinite(value)) return 0.0;
  const double scale = std::pow(10.0, 4.0 - std::floor(std::log10(std::abs(value))));
  return std::round(value * scale) / scale;
}

Json list_of(const std::vector<float>& values, double unit = 1.0) {
  Json list = Json::array();
  for (const float value : values) list.push_back(rounded(value / unit));
  return list;
}

Json list_of(const std::vector<double>& values, double unit) {
  Json list = Json::array();
  for (const double value : values) list.push_back(rounded(value / unit));
  return list;
}

std::size_t lower_index(const std::vector<double>& values, double at) {
  const auto above = std::upper_bound(values.begin(), values.end(), at);
  const auto index = static_cast<std::size_t>(std::max<std::ptrdiff_t>(above - values.begin(), 1));
  return std::min(index, values.size() - 1) - 1;
}

}  // namespace

Json map_document(const MapResult& result, bool nodes) {
  const simulate::ForceMap& map = *result.map;
  Json document = {{"angle_deg", list_of(map.angles(), units::deg)},
                   {"insertion_mm", list_of(map.insertions(), units::mm)},
                   {"feed_mm_per_s", result.feed / units::mm_per_s},
                   {"contact", list_of(map.contact())},
                   {"normal_force_n", list_of(result.forces.normal)},
                   {"feed_force_n", list_of(result.forces.feed)},
                   {"axial_force_n", list_of(result.forces.axial)},
                   {"torque_nmm", list_of(result.forces.torque, units::n_mm)},
                   {"largest_feed_mm_per_s", list_of(result.largest_feeds, units::mm_per_s)}};
  if (!nodes) return document;
  const auto triple = [](const Vector3& v, double unit) {
    return Json::array({rounded(v.x() / unit), rounded(v.y() / unit), rounded(v.z() / unit)});
  };
  document["order"] = "one value a pose: angles in turn, the insertion running fastest";
  document["pivot_mm"] = triple(result.poses.pivot_W, units::mm);
  document["normal"] = triple(result.poses.normal_W.normalized(), 1.0);
  document["forward"] = triple(result.poses.forward_W.normalized(), 1.0);
  document["linear_in_feed"] = map.linear();
  document["nodes"] = Json::array();
  for (std::size_t k = 0; k < map.feeds().size(); ++k)
    document["nodes"].push_back({{"feed_mm_per_s", map.feeds()[k] / units::mm_per_s},
                                 {"normal_force_n", list_of(map.node(k).normal)},
                                 {"feed_force_n", list_of(map.node(k).feed)},
                                 {"axial_force_n", list_of(map.node(k).axial)},
                                 {"torque_nmm", list_of(map.node(k).torque, units::n_mm)}});
  return document;
}

std::string map_table(const MapResult& result) {
  const simulate::ForceMap& map = *result.map;
  std::string text =
      "angle_deg,insertion_mm,x_mm,y_mm,z_mm,contact,normal_force_n,feed_force_n,axial_force_n,"
      "torque_nmm,largest_feed_mm_per_s\n";
  for (std::size_t i = 0; i < map.angles().size(); ++i)
    for (std::size_t j = 0; j < map.insertions().size(); ++j) {
      const std::size_t at = map.index(i, j);
      const Vector3 p = map.place_W(i, j) / units::mm;
      text += fmt::format(
          "{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.4g},{:.5g},{:.5g},{:.5g},{:.5g},"
          "{:.5g}\n",
          map.angles()[i] / units::deg, map.insertions()[j] / units::mm, p.x(), p.y(), p.z(),
          map.contact()[at], result.forces.normal[at], result.forces.feed[at],
          result.forces.axial[at], result.forces.torque[at] / units::n_mm,
          result.largest_feeds[at] / units::mm_per_s);
    }
  return text;
}

SignalsFile map_signals(const MapResult& result) {
  const simulate::ForceMap& map = *result.map;
  SignalRun run{.name = "map", .signals = {}};
  const auto add = [&](const char* name, const char* unit, const char* about,
                       const std::vector<float>& values, double factor) {
    Signal signal{name, unit, {}, about};
    for (const float value : values) signal.values.push_back(value / factor);
    run.signals.push_back(std::move(signal));
  };
  Signal angle{"angle", "deg", {}, "of the guide about the normal"};
  Signal insertion{"insertion", "mm", {}, "of the tip beyond the pivot"};
  std::array<Signal, 3> place{Signal{"x", "mm", {}, "below the tip, on the cutting plane"},
                              Signal{"y", "mm", {}, "below the tip, on the cutting plane"},
                              Signal{"z", "mm", {}, "below the tip, on the cutting plane"}};
  for (std::size_t i = 0; i < map.angles().size(); ++i)
    for (std::size_t j = 0; j < map.insertions().size(); ++j) {
      angle.values.push_back(map.angles()[i] / units::deg);
      insertion.values.push_back(map.insertions()[j] / units::mm);
      const Vector3 p = map.place_W(i, j) / units::mm;
      for (std::size_t k = 0; k < 3; ++k)
        place[k].values.push_back(p[static_cast<Eigen::Index>(k)]);
    }
  run.signals = {angle, insertion, place[0], place[1], place[2]};
  add("contact", "1", "share of the cutter's front that meets bone", map.contact(), 1.0);
  add("normal_force", "N", "on the tool, off the cut", result.forces.normal, 1.0);
  add("feed_force", "N", "that the tool is pushed with", result.forces.feed, 1.0);
  add("axial_force", "N", "on the tool, out of the bone", result.forces.axial, 1.0);
  add("torque", "N mm", "of the spindle", result.forces.torque, units::n_mm);
  add("largest_feed", "mm/s", "within the limit", result.largest_feeds, units::mm_per_s);
  for (std::size_t k = 0; k < map.feeds().size(); ++k) {
    const std::string at = fmt::format("{:.5g} mm/s", map.feeds()[k] / units::mm_per_s);
    const std::string suffix = fmt::format("_node_{}", k + 1);
    add(("normal_force" + suffix).c_str(), "N", ("at " + at).c_str(), map.node(k).normal, 1.0);
    add(("feed_force" + suffix).c_str(), "N", ("at " + at).c_str(), map.node(k).feed, 1.0);
    add(("axial_force" + suffix).c_str(), "N", ("at " + at).c_str(), map.node(k).axial, 1.0);
  }
  run.attributes = {{"feed_mm_per_s", result.feed / units::mm_per_s},
                    {"force_limit_n", result.force_limit},
                    {"angles", static_cast<std::int64_t>(map.angles().size())},
                    {"insertions", static_cast<std::int64_t>(map.insertions().size())}};
  return {{std::move(run)}, {}};
}

PictureLegend map_legend(const MapResult& result, MapValue value) {
  double low = 0.0, high = 0.0;
  for (const float one : values_of(result, value)) {
    low = std::min<double>(low, one);
    high = std::max<double>(high, one);
  }
  PictureLegend legend{label_of(value), std::floor(low), std::max(1.0, std::ceil(high)),
                       ColourMap::viridis};
  // Even about 0 where both signs occur; a twentieth of the other sign is the border of the bone.
  if (low < -0.05 * high && high > -0.05 * low) {
    legend.high = std::max(-legend.low, legend.high);
    legend.low = -legend.high;
    legend.colours = ColourMap::deviation;
  } else if (high < -low) {
    legend.high = 0.0;
  } else {
    legend.low = 0.0;
  }
  return legend;
}

geometry::Mesh map_overlay(const MapResult& result, MapValue value, double lift) {
  const simulate::ForceMap& map = *result.map;
  const std::vector<float> values = values_of(result, value);
  const Vector3 up = lift * result.poses.normal_W.normalized();
  geometry::Mesh mesh;
  constexpr unsigned kUnused = ~0U;
  std::vector<unsigned> vertex(map.poses(), kUnused);
  const auto of = [&](std::size_t i, std::size_t j) {
    unsigned& at = vertex[map.index(i, j)];
    if (at == kUnused) {
      at = static_cast<unsigned>(mesh.vertices.size());
      mesh.vertices.push_back((map.place_W(i, j) + up).cast<float>());
      mesh.values.push_back(values[map.index(i, j)]);
    }
    return at;
  };
  const auto in_bone = [&](std::size_t i, std::size_t j) {
    return map.contact()[map.index(i, j)] > kSeen;
  };
  for (std::size_t i = 0; i + 1 < map.angles().size(); ++i)
    for (std::size_t j = 0; j + 1 < map.insertions().size(); ++j) {
      if (!in_bone(i, j) || !in_bone(i + 1, j) || !in_bone(i, j + 1) || !in_bone(i + 1, j + 1))
        continue;
      // Counter-clockwise about the normal: outwards, then to larger angles.
      mesh.triangles.push_back({of(i, j), of(i, j + 1), of(i + 1, j + 1)});
      mesh.triangles.push_back({of(i, j), of(i + 1, j + 1), of(i + 1, j)});
    }
  return mesh;
}

HeatMap map_figure(const MapResult& result, MapValue value) {
  const simulate::ForceMap& map = *result.map;
  const std::vector<float> values = values_of(result, value);
  // Places as the guide sees them: forward up, smaller angles to the right. As far as there is
  // bone.
  double left = 1e300, right = -1e300, top = -1e300, bottom = 1e300;
  for (std::size_t i = 0; i < map.angles().size(); ++i)
    for (std::size_t j = 0; j < map.insertions().size(); ++j) {
      if (map.contact()[map.index(i, j)] <= kSeen) continue;
      const double x = -map.insertions()[j] * std::sin(map.angles()[i]) / units::mm;
      const double y = map.insertions()[j] * std::cos(map.angles()[i]) / units::mm;
      left = std::min(left, x - 2.0);
      right = std::max(right, x + 2.0);
      bottom = std::min(bottom, y - 2.0);
      top = std::max(top, y + 2.0);
    }
  if (!(left < right)) left = -1.0, right = 1.0, bottom = -1.0, top = 1.0;
  HeatMap figure;
  figure.x = {.label = "across the guide, mm"};
  figure.y = {.label = "forward from the pivot, mm"};
  figure.value_label = label_of(value);
  const double step = std::max(right - left, top - bottom) / 300.0;
  for (double x = left; x <= right + 0.5 * step; x += step) figure.x_centres.push_back(x);
  for (double y = bottom; y <= top + 0.5 * step; y += step) figure.y_centres.push_back(y);
  for (const double y : figure.y_centres)
    for (const double x : figure.x_centres) {
      const double angle = std::atan2(-x, y), insertion = std::hypot(x, y) * units::mm;
      double sum = kNone;
      if (map.angles().size() > 1 && map.insertions().size() > 1 && angle >= map.angles().front() &&
          angle <= map.angles().back() && insertion >= map.insertions().front() &&
          insertion <= map.insertions().back()) {
        const std::size_t i = lower_index(map.angles(), angle);
        const std::size_t j = lower_index(map.insertions(), insertion);
        const double a = (angle - map.angles()[i]) / (map.angles()[i + 1] - map.angles()[i]);
        const double b =
            (insertion - map.insertions()[j]) / (map.insertions()[j + 1] - map.insertions()[j]);
        const auto near = map.index(a < 0.5 ? i : i + 1, b < 0.5 ? j : j + 1);
        if (map.contact()[near] > kSeen)
          sum = (1 - a) * (1 - b) * values[map.index(i, j)] +
                (1 - a) * b * values[map.index(i, j + 1)] +
                a * (1 - b) * values[map.index(i + 1, j)] + a * b * values[map.index(i + 1, j + 1)];
      }
      figure.values.push_back(sum);
    }
  const PictureLegend scale = map_legend(result, value);
  figure.low = scale.low;
  figure.high = scale.high;
  figure.colours = scale.colours;
  figure.title = value == MapValue::largest_feed
                     ? fmt::format("Largest feed for {:g} N", result.force_limit)
                     : fmt::format("{} at {:g} mm/s",
                                   value == MapValue::normal_force ? "Normal force" : "Feed force",
                                   result.feed / units::mm_per_s);
  const double width = right - left, height = top - bottom;
  figure.width = 620;
  figure.height = static_cast<int>(std::clamp(80.0 + 440.0 * height / width, 320.0, 760.0));
  return figure;
}

Picture map_picture(const MapResult& result, const workpiece::Stock& stock) {
  SurfaceOptions open;
  open.cut = CutPlane{result.poses.pivot_W, result.poses.normal_W.normalized()};
  geometry::Mesh bone = surface_of(stock, open);
  bone.values.clear();
  const geometry::Mesh overlay = map_overlay(result, MapValue::normal_force, 0.15 * units::mm);
  PictureView view;
  view.meshes.push_back({std::move(bone)});
  if (!overlay.triangles.empty()) view.meshes.push_back({overlay});
  // The guide: from the pivot to its first poses.
  const Vector3 lift = 0.5 * units::mm * result.poses.normal_W.normalized();
  view.lines.push_back({{result.poses.pivot_W + lift,
                         result.map->place_W(result.map->angles().size() / 2, 0) + lift},
                        {},
                        0.8 * units::mm,
                        kSteelColour});
  Picture picture;
  picture.title = fmt::format("Normal force over the cutting plane at {:g} mm/s",
                              result.feed / units::mm_per_s);
  picture.views = {std::move(view)};
  picture.camera.from =
      result.poses.normal_W.normalized() - 0.6 * result.poses.forward_W.normalized();
  picture.camera.up = result.poses.normal_W.normalized();
  picture.mesh_values = map_legend(result, MapValue::normal_force);
  return picture;
}

}  // namespace osteomill::io
