// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "osteomill/cutting/cutter.hpp"
#include "osteomill/workpiece/stock.hpp"
#include "osteomill/workpiece/tool_path.hpp"

namespace osteomill::workpiece {

/// Where along a path the cutter is in bone, found once by cutting a copy of the stock: what
/// earlier passes have taken is no longer there for later ones. Queries are searches in a sorted
/// list.
class ContactMap {
 public:
  /// `step` is the resolution along the path, m; 0 means one voxel. Throws InvalidInput when the
  /// path never touches the stock, and when a rapid goes through bone (all such moves are named).
  /// `left` becomes the stock as the whole path leaves it; null: not asked for.
  ContactMap(Stock stock, const cutting::Cutter& cutter, const ToolPath& path, double step = 0.0,
             Stock* left = nullptr);

  /// A stretch of path on which bone is cut all the way, gaps of less than a cutter radius without
  /// contact counted in.
  struct Stretch {
    double begin = 0.0, end = 0.0;  ///< arc length, m
    /// From here on the cutter is as deep in bone as it gets within its first diameter of travel
    /// (the frontal area in bone reaches 95 % of the largest there).
    double engaged = 0.0;
  };
  const std::vector<Stretch>& stretches() const { return stretches_; }

  double first_contact() const { return stretches_.front().begin; }
  double last_exit() const { return stretches_.back().end; }
  bool in_contact(double arc_length) const;
  /// Way along the path until the cutter touches bone, m: 0 in contact, infinity when it won't
  /// again.
  double distance_to_contact(double arc_length) const;
  /// Way along the path until the cutter is fully engaged in the stretch that it is in or that
  /// comes next, m: 0 when it is, infinity when none comes.
  double distance_to_full_engagement(double arc_length) const;

  /// Volume that the whole path removes, m³.
  double removed_volume() const { return removed_volume_; }
  /// Frontal area in bone (removed volume over travel) at the middle of each step, m²; steps of
  /// equal length but for the ends of straight pieces.
  struct Frontal {
    double arc_length = 0.0;
    double area = 0.0;
  };
  const std::vector<Frontal>& frontal() const { return frontal_; }

 private:
  const Stretch* at_or_after(double arc_length) const;
  std::vector<Stretch> stretches_;
  std::vector<Frontal> frontal_;
  double removed_volume_ = 0.0;
};

}  // namespace osteomill::workpiece
