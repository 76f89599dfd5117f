// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "osteomill/cutting/component_batch.hpp"
#include "osteomill/cutting/milling_force.hpp"

namespace osteomill::cutting {

/// Sums the loads of many edge elements, whose forces are worked out at once: name the point of the
/// meridian, push its elements, go on to the next point; then add.
class EdgeSum {
 public:
  EdgeSum(const CuttingLaw& law, const geometry::Vector3& fibre);

  /// The point that the elements pushed from here on belong to.
  void at(const ProfilePoint& point);

  /// An element at the angle with this sine and cosine, chip thickness h, width of cut and width
  /// times height.
  void push(double sine, double cosine, double h, double width, double width_z) {
    elements_.push_back({sine, cosine, width, width_z});
    h_.push_back(h);
  }

  /// Adds what was pushed to the load and forgets it.
  void add_to(Load& load);

 private:
  struct Row {
    ProfilePoint point;
    std::size_t begin = 0;  ///< of its elements
  };
  void evaluate();

  CuttingLaw law_;
  ComponentBatch batch_;
  geometry::Vector3 fibre_;
  std::vector<Row> rows_;
  struct Element {
    double sine, cosine, width, width_z;
  };
  std::vector<Element> elements_;
  std::vector<double> h_;
  std::vector<double> along_, tangential_, radial_, lateral_;
};

}  // namespace osteomill::cutting
