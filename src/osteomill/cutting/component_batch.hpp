// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>

#include "osteomill/cutting/component_kernel.hpp"
#include "osteomill/cutting/cutting_law.hpp"

namespace osteomill::cutting {

/// components() for many edge elements at once, with the vector instructions of the machine: log
/// and power laws, Hankinson with n = 2 or none. Other laws take the plain loop. Equal to
/// components() within 1e-12.
class ComponentBatch {
 public:
  explicit ComponentBatch(const CuttingLaw& law);

  /// out[i] of each component for h[i] and the cosine between motion and fibres. The spans have one
  /// size; `lateral` is filled with 0 when the law has none.
  void operator()(std::span<const double> h, std::span<const double> cosine, const EdgePlace& place,
                  double inclination, std::span<double> tangential, std::span<double> radial,
                  std::span<double> lateral) const;

  bool vectorised() const { return vectorised_; }
  /// For code that goes beyond components; only when vectorised().
  const kernel::Curves& curves() const { return curves_; }

 private:
  CuttingLaw law_;
  kernel::Curves curves_{};
  bool vectorised_ = false;
};

}  // namespace osteomill::cutting
