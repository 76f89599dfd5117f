// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "osteomill/vibration/frequency_response.hpp"
#include "osteomill/vibration/modal.hpp"

/// Measured dynamics of a tool in a case: hammer blows, a frequency response, or what `osteomill
/// modes` made of them.
namespace osteomill::io {

class Section;

/// The keys of an impact test.
struct ImpactTable {
  std::vector<std::filesystem::path> records;  ///< hammer blows; or
  std::filesystem::path frf;                   ///< a frequency response
  vibration::FrfOptions options;
  vibration::ModalFitOptions fit;
};
void bind_impact(Section& section, ImpactTable& table);

/// The response, and what of it to fit.
struct ImpactCase {
  vibration::MeasuredFrf frf;
  vibration::ModalFitOptions fit;
};
ImpactCase impact_of(const ImpactTable& table);

/// "x", "y" or an angle from the feed towards +y as a unit vector.
void bind_direction(Section& section, double& x, double& y);

/// One entry of structure.measured: the response of the tip in one direction.
struct MeasuredTable {
  ImpactTable impact;
  std::filesystem::path
      result;  ///< run folder or JSON of `osteomill modes`, in place of a response
  double direction_x = 1.0, direction_y = 0.0;
};
void bind_measured(Section& section, std::vector<MeasuredTable>& tables);

/// What the entries come to: the fitted modes of all, and the receptance of the tip from the
/// measured lines.
struct MeasuredStructure {
  std::vector<vibration::Mode> modes;
  vibration::Receptance receptance;
  std::vector<std::string> caveats;
};
/// Throws InvalidInput for files that cannot be read, NoSolution when a fit fails.
MeasuredStructure measured_structure(const std::vector<MeasuredTable>& tables);

}  // namespace osteomill::io
