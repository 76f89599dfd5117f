// SPDX-License-Identifier: BSD-3-Clause
#include "reproduce.hpp"

#include <fmt/format.h>

#include "command.hpp"
#include "osteomill/base/error.hpp"

namespace osteomill::cli {
namespace {

struct Arguments {
  std::string source;
  Format format = Format::table;
};

struct Source {
  const char* name;
  void (*add)(std::vector<Reproduced>& list);
};

const std::vector<Source>& sources() {
  static const std::vector<Source> list = {{"plaskos2002", reproduce_plaskos2002},
                                           {"plaskos2002", reproduce_cutting_study},
                                           {"plaskos2002", reproduce_plaskos2002_accuracy},
                                           {"plaskos2006", reproduce_plaskos2006},
                                           {"plaskos2006", reproduce_plaskos2006_robot},
                                           {"plaskos2006", reproduce_plaskos2006_accuracy},
                                           {"plaskos2006", reproduce_plaskos2006_identification},
                                           {"sugita2009", reproduce_sugita2009},
                                           {"tian2023", reproduce_tian2023},
                                           {"tian2023", reproduce_tian2023_identification}};
  return list;
}

void run(const Arguments& arguments) {
  std::vector<Reproduced> list;
  std::string known;
  bool found = arguments.source.empty();
  for (const Source& source : sources()) {
    if (known.find(source.name) == std::string::npos) {
      known += (known.empty() ? "" : ", ") + std::string(source.name);
    }
    if (!arguments.source.empty() && arguments.source != source.name) continue;
    found = true;
    source.add(list);
  }
  if (!found) {
    throw InvalidInput(
        Fault{"reproduce", arguments.source, "is no source with entries", "known: " + known});
  }
  nlohmann::ordered_json document;
  auto& entries = document["entries"] = nlohmann::ordered_json::array();
  std::vector<std::vector<std::string>> csv = {
      {"source", "entry", "printed", "criterion", "ours", "verdict", "reason"}};
  int passed = 0;
  for (const Reproduced& one : list) {
    const char* verdict = one.pass ? "pass" : "miss";
    passed += one.pass ? 1 : 0;
    entries.push_back({{"source", one.source},
                       {"entry", one.entry},
                       {"printed", one.printed},
                       {"criterion", one.criterion},
                       {"ours", one.ours},
                       {"pass", one.pass},
                       {"reason", one.reason}});
    csv.push_back(
        {one.source, one.entry, one.printed, one.criterion, one.ours, verdict, one.reason});
  }
  document["passed"] = passed;
  document["missed"] = static_cast<int>(list.size()) - passed;
  if (arguments.format == Format::json) return print_json(document);
  if (arguments.format == Format::csv) return print_csv(csv);
  for (const Reproduced& one : list) {
    fmt::print("{}  {} {}\n", one.pass ? "pass" : "MISS", one.source, one.entry);
    fmt::print("      printed    {}\n      criterion  {}\n      ours       {}\n", one.printed,
               one.criterion, one.ours);
    if (!one.reason.empty()) fmt::print("      because    {}\n", one.reason);
  }
  fmt::print("{} of {} reproduced\n", passed, list.size());
}

}  // namespace

void add_reproduce(CLI::App& program) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command =
      program.add_subcommand("reproduce", "what the sources printed against what comes out here");
  command->add_option("source", arguments->source, "only this source, e.g. plaskos2006");
  add_format(*command, arguments->format);
  command->callback([arguments] { run(*arguments); });
}

}  // namespace osteomill::cli
