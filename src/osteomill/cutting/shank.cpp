// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/cutting/shank.hpp"

#include <fmt/format.h>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/cutting/cutter.hpp"

namespace osteomill::cutting {

void check(const Shank& shank, const Cutter& cutter) {
  FaultList faults;
  faults.gather([&] {
    require_positive("cutter.shank.free_length_mm", shank.free_length / units::mm, "mm");
    if (shank.free_length < cutter.cutting_length * (1.0 - 1e-12)) {
      throw InvalidInput(Fault{
          "cutter.shank.free_length_mm", fmt::format("{:g} mm", shank.free_length / units::mm),
          fmt::format("must be >= the cutting length of {:g} mm",
                      cutter.cutting_length / units::mm),
          "it counts from the tip; set cutter.cutting_length_mm when the edges are shorter"});
    }
  });
  faults.gather(
      [&] { require_positive("cutter.shank.diameter_mm", shank.diameter / units::mm, "mm"); });
  // Hard plastics have 2 GPa, tungsten carbide 700.
  faults.gather([&] {
    require_within("cutter.shank.youngs_modulus_gpa", shank.youngs_modulus / units::gpa, 1.0,
                   1000.0, "GPa");
  });
  faults.gather([&] {
    require_within("cutter.shank.density_kg_per_m3", shank.density, 500.0, 25000.0, "kg/m3");
  });
  faults.gather([&] {
    require_within("cutter.shank.effective_diameter_factor", shank.effective_diameter_factor, 0.1,
                   1.0, "");
  });
  faults.gather([&] {
    require_non_negative("cutter.shank.holder_stiffness_n_per_mm",
                         shank.holder_stiffness / units::n_per_mm, "N/mm");
    require_non_negative("cutter.shank.holder_rotational_stiffness_nm_per_rad",
                         shank.holder_rotational_stiffness, "N m/rad");
    if ((shank.holder_stiffness > 0.0) != (shank.holder_rotational_stiffness > 0.0)) {
      throw InvalidInput(Fault{
          "cutter.shank.holder_stiffness_n_per_mm",
          fmt::format("{:g} N/mm beside {:g} N m/rad", shank.holder_stiffness / units::n_per_mm,
                      shank.holder_rotational_stiffness),
          "must be given with holder_rotational_stiffness_nm_per_rad",
          "give both, or none for a rigid holder"});
    }
  });
  faults.raise();
}

}  // namespace osteomill::cutting
