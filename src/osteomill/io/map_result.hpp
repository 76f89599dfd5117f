// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "osteomill/geometry/mesh.hpp"
#include "osteomill/io/picture.hpp"
#include "osteomill/io/plot.hpp"
#include "osteomill/io/signals_file.hpp"
#include "osteomill/simulate/force_map.hpp"

namespace osteomill::io {

/// A force map at one feed, with what the guide may do.
struct MapResult {
  const simulate::ForceMap* map = nullptr;
  simulate::GuidePoses poses;
  double feed = 0.0;         ///< m/s
  double force_limit = 0.0;  ///< N
  simulate::PoseForces forces;
  std::vector<float> largest_feeds;  ///< m/s
};

/// One value a pose, insertion fastest, in the units that the names say; with `nodes` also what
/// makes any other feed out of it: for two nodes F = F0 + (F1 - F0) feed / feed1, otherwise cubic
/// between the nodes in ln(feed).
nlohmann::ordered_json map_document(const MapResult& result, bool nodes);

/// One line a pose.
std::string map_table(const MapResult& result);

/// HDF5: one run with one value a pose.
SignalsFile map_signals(const MapResult& result);

/// One value a pose.
enum class MapValue { normal_force, feed_force, largest_feed };

/// The poses over bone as a surface on the cutting plane, lifted by `lift`, with that value in N or
/// mm/s.
geometry::Mesh map_overlay(const MapResult& result, MapValue value, double lift = 0.0);

/// What its colours mean: one scale for figure, picture and overlay.
PictureLegend map_legend(const MapResult& result, MapValue value);

/// The value over the cutting plane, seen against its normal, forward to the top; the guide turns
/// at the origin.
HeatMap map_figure(const MapResult& result, MapValue value);

/// The overlay on the bone that stays.
Picture map_picture(const MapResult& result, const workpiece::Stock& stock);

}  // namespace osteomill::io
