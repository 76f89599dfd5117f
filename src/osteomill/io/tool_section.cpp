// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/tool_section.hpp"

#include "osteomill/base/units.hpp"

namespace osteomill::io {

bool bind_tool(Section& section, ToolCase& tool, Need need) {
  const Quantity mm{units::mm, "mm"};
  return section.table(
      "tool", "free length of the tool, held at its upper end", need, [&](Section& s) {
        s.number("length_mm", tool.length, mm, positive(), "from the tip to the holder or bearing");
        s.number("effective_diameter_mm", tool.diameter, mm, positive(),
                 "diameter of a round shaft that bends as the fluted one");
        s.number("youngs_modulus_gpa", tool.modulus, {units::gpa, "GPa"}, positive(),
                 "Young's modulus");
        s.number("support_stiffness_n_per_mm", tool.support, {units::n_per_mm, "N/mm"}, positive(),
                 "of what holds the tool; none: rigid");
      });
}

accuracy::ToolCompliance compliance_of(const ToolCase& tool) {
  return accuracy::ToolCompliance::cantilever(tool.length, tool.diameter, tool.modulus,
                                              tool.support ? 1.0 / *tool.support : 0.0);
}

}  // namespace osteomill::io
