// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string_view>

namespace osteomill::io {

/// The built page of apps/report/dist, which the program carries within itself.
std::string_view report_page();

}  // namespace osteomill::io
