// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "documents.hpp"

namespace osteomill::cli {

/// One case of `osteomill force`, solved.
Shown show_force(const io::CaseRun& run);

}  // namespace osteomill::cli
