// SPDX-License-Identifier: BSD-3-Clause
#include "command.hpp"
#include "osteomill/io/force_case.hpp"

namespace osteomill::cli {

void add_catalogue(CLI::App& program);
void add_force(CLI::App& program);
void add_robot_place(CLI::App& program);
void add_robot_position(CLI::App& program);
void add_robot_size(CLI::App& program);
void add_schema(CLI::App& program);
void bind_robot_place(io::Section& section);
void bind_robot_position(io::Section& section);
void bind_robot_size(io::Section& section);

const std::vector<Command>& commands() {
  static const std::vector<Command> list = {
      {"catalogue", add_catalogue, {}},
      {"force", add_force, io::bind_force},
      {"robot place", add_robot_place, bind_robot_place},
      {"robot position", add_robot_position, bind_robot_position},
      {"robot size", add_robot_size, bind_robot_size},
      {"schema", add_schema, {}},
  };
  return list;
}

}  // namespace osteomill::cli
