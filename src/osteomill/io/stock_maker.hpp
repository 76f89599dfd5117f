// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "osteomill/geometry/pose.hpp"
#include "osteomill/io/cutting_section.hpp"
#include "osteomill/io/stock_section.hpp"
#include "osteomill/workpiece/stock.hpp"

namespace osteomill::io {

inline geometry::Vector3 vector_of(const std::array<double, 3>& a) { return {a[0], a[1], a[2]}; }

/// A stock as a case asks for it.
struct MadeStock {
  std::shared_ptr<const workpiece::Stock> stock;
  std::vector<std::string> remarks;  ///< what the reader of the result has to know
  nlohmann::ordered_json report;     ///< what it was made from, how much of which bone it has
  geometry::Vector3 fibre_W = geometry::Vector3::UnitX();  ///< direction of the bone's fibres
  std::function<geometry::Vector3(const geometry::Vector3& p_W)> fibre_at = {};  ///< by place
};

/// Pose of the work frame W in the frame P of the CT, the mesh or the phantom. InvalidInput when
/// the axes do not say where x is.
geometry::Pose work_frame(const StockCase& stock);

/// Throws InvalidInput: a surface that is open or inside out, a CT with metal or thick slices, a
/// region without bone, too many voxels. Not for line profiles.
MadeStock make_stock(const StockCase& stock, const BoneCase& bone);

/// Whether the cutting force follows the density by bone::ForceDensityLaw.
bool follows_density(const StockCase& stock);

}  // namespace osteomill::io
