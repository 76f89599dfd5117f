// SPDX-License-Identifier: BSD-3-Clause
#include "command.hpp"
#include "osteomill/io/force_case.hpp"

namespace osteomill::cli {

void add_catalogue(CLI::App& program);
void add_force(CLI::App& program);
void add_schema(CLI::App& program);

const std::vector<Command>& commands() {
  static const std::vector<Command> list = {
      {"catalogue", add_catalogue, {}},
      {"force", add_force, io::bind_force},
      {"schema", add_schema, {}},
  };
  return list;
}

}  // namespace osteomill::cli
