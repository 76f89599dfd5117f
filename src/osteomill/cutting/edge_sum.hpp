// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "osteomill/cutting/component_batch.hpp"
#include "osteomill/cutting/milling_force.hpp"

namespace osteomill::cutting {

/// Sums the loads of many edge elements at one point of the meridian: push the elements, then add.
class EdgeSum {
 public:
  EdgeSum(const CuttingLaw& law, const geometry::Vector3& fibre);

  /// An element at the angle with this sine and cosine, chip thickness h, width of cut and width
  /// times height.
  void push(double sine, double cosine, double h, double width, double width_z);

  /// Adds what was pushed to the load and forgets it.
  void add_to(Load& load, const ProfilePoint& point);

 private:
  CuttingLaw law_;
  ComponentBatch batch_;
  geometry::Vector3 fibre_;
  std::vector<double> sine_, cosine_, h_, width_, width_z_;
  std::vector<double> along_, tangential_, radial_, lateral_;
};

}  // namespace osteomill::cutting
