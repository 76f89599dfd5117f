// SPDX-License-Identifier: BSD-3-Clause
#include "command.hpp"

namespace osteomill::cli {

void add_catalogue(CLI::App& program);
void add_schema(CLI::App& program);

const std::vector<Command>& commands() {
  static const std::vector<Command> list = {
      {"catalogue", add_catalogue, {}},
      {"schema", add_schema, {}},
  };
  return list;
}

}  // namespace osteomill::cli
