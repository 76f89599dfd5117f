// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include "osteomill/cutting/engagement.hpp"

namespace osteomill::io {

/// An engagement map from a table: height_mm (of a patch's lower end above the tip), angle_deg (of
/// its beginning, see the tool frame), weight. Patches that are not listed are in air. Heights are
/// whole multiples of a slice's, angles of a part of 360 degrees; both are taken from the table, or
/// from the caller where one row or column alone does not tell. Throws InvalidInput with all
/// faults.
cutting::Engagement read_engagement(const std::filesystem::path& file, double slice_height = 0.0,
                                    int angles = 0);

}  // namespace osteomill::io
