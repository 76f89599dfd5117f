// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include "osteomill/vibration/frequency_response.hpp"

/// Measured dynamics as tables.
namespace osteomill::io {

/// A hammer blow: columns time_s, force_n, and displacement_um or acceleration_m_per_s2; equal time
/// steps. `response` says which of the two was there.
vibration::ImpactRecord read_impact_record(const std::filesystem::path& file,
                                           vibration::Response& response);

/// A frequency response: columns frequency_hz, real_um_per_n, imaginary_um_per_n and, where it was
/// measured, coherence.
vibration::MeasuredFrf read_frf(const std::filesystem::path& file);

}  // namespace osteomill::io
