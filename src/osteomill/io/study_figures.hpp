// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "osteomill/study/analysis.hpp"

namespace osteomill::io {

/// A figure of a study as the theses draw it: [plaskos2002] figures 2.2 to 2.5 and 3.5 to 3.8.
struct StudyFigure {
  std::string name;     ///< of the file, without suffix
  std::string caption;  ///< what is drawn, and how to read it
  std::function<void(const std::filesystem::path& file)> draw;  ///< .png, .svg or .pdf
};

/// Boxes of each operator, variability with its interval, error against guide movement with its
/// lines, variance contributions; those for which the report has data. The report must outlive
/// them.
std::vector<StudyFigure> study_figures(const study::StudyReport& report);

}  // namespace osteomill::io
