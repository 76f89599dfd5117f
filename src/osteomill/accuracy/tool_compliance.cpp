// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/accuracy/tool_compliance.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/vibration/beam_elements.hpp"

namespace osteomill::accuracy {
namespace {
constexpr int kIntervals = 120;  // of a beam's table: linear between, (1/120)²/8 of the curvature
}

ToolCompliance ToolCompliance::cantilever(double length, double effective_diameter,
                                          double youngs_modulus, double support_compliance) {
  ToolCompliance tool;
  tool.length_ = require_positive("tool.length_mm", length / units::mm, "mm") * units::mm;
  require_positive("tool.effective_diameter_mm", effective_diameter / units::mm, "mm");
  require_positive("tool.youngs_modulus_gpa", youngs_modulus / units::gpa, "GPa");
  tool.support_ = require_non_negative("support compliance", support_compliance, "m/N");
  tool.bending_stiffness_ =
      youngs_modulus * std::numbers::pi * std::pow(effective_diameter, 4) / 64.0;
  return tool;
}

ToolCompliance ToolCompliance::of_beam(const vibration::Beam& beam, double support_compliance) {
  ToolCompliance tool;
  tool.support_ = require_non_negative("support compliance", support_compliance, "m/N");
  const vibration::BeamModel model(beam, {.elements = 60});
  tool.length_ = vibration::length(beam);
  for (int i = 0; i <= kIntervals; ++i) {
    tool.stations_.push_back(tool.length_ * i / kIntervals);
  }
  // The modes of the model are complete: compliance = Σ φ(a) φ(b)/ω².
  std::vector<std::vector<double>> modes;  // φ/ω of each station
  for (const double height : tool.stations_) {
    std::vector<double> row;
    for (int i = 0; i < model.modes(); ++i) {
      const double omega =
          2.0 * std::numbers::pi * model.natural_frequencies_hz()[static_cast<std::size_t>(i)];
      row.push_back(model.normalised_deflection(i, tool.length_ - height) / omega);
    }
    modes.push_back(std::move(row));
  }
  for (const auto& at : modes) {
    for (const auto& force_at : modes) {
      tool.table_.push_back(std::inner_product(at.begin(), at.end(), force_at.begin(), 0.0));
    }
  }
  return tool;
}

double ToolCompliance::between(double height, double force_height) const {
  if (stations_.empty()) {
    const double near = length_ - std::max(height, force_height);  // v of the one nearer the clamp
    const double far = length_ - std::min(height, force_height);
    if (near <= 0.0) return support_;
    return support_ + near * near * (3.0 * far - near) / (6.0 * bending_stiffness_);
  }
  const auto place = [&](double z) {
    return std::clamp(z / length_ * kIntervals, 0.0, static_cast<double>(kIntervals));
  };
  const double a = place(height), b = place(force_height);
  const auto low_a = static_cast<std::size_t>(std::min(std::floor(a), kIntervals - 1.0));
  const auto low_b = static_cast<std::size_t>(std::min(std::floor(b), kIntervals - 1.0));
  const double s = a - static_cast<double>(low_a), t = b - static_cast<double>(low_b);
  const auto value = [&](std::size_t i, std::size_t k) { return table_[i * stations_.size() + k]; };
  return support_ + (1.0 - s) * ((1.0 - t) * value(low_a, low_b) + t * value(low_a, low_b + 1)) +
         s * ((1.0 - t) * value(low_a + 1, low_b) + t * value(low_a + 1, low_b + 1));
}

}  // namespace osteomill::accuracy
