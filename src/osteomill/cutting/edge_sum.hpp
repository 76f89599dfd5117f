// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "osteomill/cutting/component_batch.hpp"
#include "osteomill/cutting/milling_force.hpp"

namespace osteomill::cutting {

/// Sums the loads of many edge elements, whose forces are worked out at once: name the point of the
/// meridian, push its elements, go on to the next point; then add.
class EdgeSum {
 public:
  EdgeSum(const CuttingLaw& law, const geometry::Vector3& fibre);

  /// The point that the elements pushed from here on belong to, and which of several loads they add
  /// to.
  void at(const ProfilePoint& point, std::size_t load = 0);

  /// An element at the angle with this sine and cosine, chip thickness h, width of cut and width
  /// times height.
  void push(double sine, double cosine, double h, double width, double width_z) {
    elements_.push_back({sine, cosine, width, width_z});
    h_.push_back(h);
  }

  /// Adds what was pushed to the load, or to each its own, and forgets it.
  void add_to(Load& load) { add_to(std::span<Load>(&load, 1)); }
  void add_to(std::span<Load> loads);

 private:
  struct Row {
    ProfilePoint point;
    std::size_t begin = 0;  ///< of its elements
    std::size_t load = 0;
  };
  struct Element {
    double sine, cosine, width, width_z;
  };
  struct Components {
    std::vector<double> tangential, radial, lateral;
  };
  void evaluate(const ComponentBatch& batch, Components& out);
  geometry::Vector3 force(std::size_t i, double sin_kappa, double cos_kappa) const;

  CuttingLaw law_;
  /// Of the law without ploughing; for Puw-Hocheng of its laws along the fibres and across.
  std::vector<ComponentBatch> batches_;
  geometry::Vector3 fibre_;
  std::vector<Row> rows_;
  std::vector<Element> elements_;
  std::vector<double> h_, along_;
  std::vector<Components> components_;
};

}  // namespace osteomill::cutting
