// SPDX-License-Identifier: BSD-3-Clause
#include "command.hpp"
#include "osteomill/io/force_case.hpp"
#include "osteomill/io/simulate_case.hpp"
#include "osteomill/io/study_case.hpp"
#include "osteomill/io/vibration_case.hpp"

namespace osteomill::cli {

void add_catalogue(CLI::App& program);
void add_force(CLI::App& program);
void add_modes(CLI::App& program);
void add_reproduce(CLI::App& program);
void add_respond(CLI::App& program);
void add_robot_place(CLI::App& program);
void add_robot_position(CLI::App& program);
void add_robot_size(CLI::App& program);
void add_schema(CLI::App& program);
void add_stability(CLI::App& program);
void add_simulate(CLI::App& program);
void bind_robot_place(io::Section& section);
void bind_robot_position(io::Section& section);
void bind_robot_size(io::Section& section);
void add_study(CLI::App& program);

const std::vector<Command>& commands() {
  static const std::vector<Command> list = {
      {"catalogue", add_catalogue, {}},
      {"force", add_force, io::bind_force},
      {"modes", add_modes, io::bind_modes},
      {"reproduce", add_reproduce, {}},
      {"respond", add_respond, io::bind_respond},
      {"robot place", add_robot_place, bind_robot_place},
      {"robot position", add_robot_position, bind_robot_position},
      {"robot size", add_robot_size, bind_robot_size},
      {"schema", add_schema, {}},
      {"stability", add_stability, io::bind_stability},
      {"study", add_study, io::bind_study},
      {"simulate", add_simulate, io::bind_simulate_keys},
  };
  return list;
}

}  // namespace osteomill::cli
