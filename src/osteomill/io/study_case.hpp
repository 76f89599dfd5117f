// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "osteomill/study/analysis.hpp"
#include "osteomill/study/plan.hpp"

namespace osteomill::io {

class Section;

/// The table of `osteomill study`.
study::Table read_study_table(const std::filesystem::path& file);

/// The keys of a design and of a plan, for the schema.
void bind_study(Section& section);
void bind_study_plan(Section& section);

struct StudyDesign {
  study::Design design;
  std::filesystem::path table;  ///< empty where the design names none
  nlohmann::ordered_json expanded;
};
/// From design.toml (empty path: defaults) with overrides "key=value".
StudyDesign read_study_design(const std::filesystem::path& file,
                              const std::vector<std::string>& overrides);

struct StudyPlanCase {
  study::PlanOptions options;
  nlohmann::ordered_json expanded;
};
StudyPlanCase read_study_plan(const std::filesystem::path& file,
                              const std::vector<std::string>& overrides);

}  // namespace osteomill::io
