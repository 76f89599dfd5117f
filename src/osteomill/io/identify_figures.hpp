// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "osteomill/identify/mean_force_identification.hpp"

namespace osteomill::io {

/// A figure of an identification.
struct IdentifyFigure {
  std::string name;     ///< of the file, without suffix
  std::string caption;  ///< what is drawn, and how to read it
  std::function<void(const std::filesystem::path& file)> draw;  ///< .png, .svg or .pdf
};

/// Models against each other, fit, residuals with cross-validation, the law with its band, and
/// influence. They hold copies of what they draw.
std::vector<IdentifyFigure> identify_figures(const std::vector<identify::Experiment>& experiments,
                                             const identify::MeanForceIdentification& result,
                                             double confidence);

}  // namespace osteomill::io
