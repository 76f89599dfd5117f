// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "osteomill/accuracy/tool_compliance.hpp"
#include "osteomill/io/section.hpp"

namespace osteomill::io {

/// [tool]: the free length of the tool, which bends.
struct ToolCase {
  double length = 0.0;            ///< m
  double diameter = 0.0;          ///< of a round shaft that bends as the fluted one, m
  double modulus = 0.0;           ///< Pa
  std::optional<double> support;  ///< stiffness of what holds it, N/m; none: rigid
};

/// Returns whether the table is there.
bool bind_tool(Section& section, ToolCase& tool, Need need);

accuracy::ToolCompliance compliance_of(const ToolCase& tool);

}  // namespace osteomill::io
