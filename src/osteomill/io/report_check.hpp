// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "osteomill/io/report.hpp"

namespace osteomill::io {

/// Throws InvalidInput with everything that keeps the data from being shown.
void check(const ReportData& data);

/// image/png or image/svg+xml; empty when it is neither.
std::string media_type(const std::string& image);

}  // namespace osteomill::io
