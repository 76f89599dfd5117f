// SPDX-License-Identifier: BSD-3-Clause
#include "documents.hpp"

#include "osteomill/base/error.hpp"
#include "osteomill/io/text_file.hpp"

namespace osteomill::cli {

void print_documents(const std::vector<std::pair<std::string, nlohmann::ordered_json>>& runs) {
  if (runs.size() == 1) return print_json(runs.front().second);
  nlohmann::ordered_json all;
  all["runs"] = nlohmann::ordered_json::array();
  for (const auto& [name, document] : runs) {
    nlohmann::ordered_json one = {{"name", name}};
    one.update(document);
    all["runs"].push_back(one);
  }
  print_json(all);
}

std::filesystem::path run_directory(const std::filesystem::path& directory,
                                    const std::string& command, const std::string& run_name,
                                    bool several, const nlohmann::ordered_json& expanded_case,
                                    const nlohmann::ordered_json& results) {
  const std::filesystem::path place = several ? directory / run_name : directory;
  std::error_code error;
  std::filesystem::create_directories(place, error);
  if (error) throw WorldError("cannot make the folder " + place.string() + ": " + error.message());
  const nlohmann::ordered_json run = {{"version", OSTEOMILL_VERSION},
                                      {"command", command},
                                      {"name", run_name},
                                      {"case", expanded_case},
                                      {"summary", results}};
  io::write_text_file(place / "run.json", run.dump(2) + "\n");
  return place;
}

}  // namespace osteomill::cli
