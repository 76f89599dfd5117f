// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json.hpp>

#include "osteomill/study/analysis.hpp"
#include "osteomill/study/plan.hpp"

namespace osteomill::io {

/// The documents of `osteomill study` and `osteomill study plan`. A number in the unit of a column
/// has that unit in its key: sd_deg for varus_valgus_deg, sd_s for time_s.
nlohmann::ordered_json study_document(const study::StudyReport& report);
nlohmann::ordered_json plan_document(const study::Plan& plan);

}  // namespace osteomill::io
