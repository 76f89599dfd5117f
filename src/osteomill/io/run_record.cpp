// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/run_record.hpp"

#include <fmt/chrono.h>
#include <unistd.h>

#include <array>
#include <chrono>

#include "osteomill/io/text_file.hpp"

namespace osteomill::io {

std::string now_text() {
  const auto now = std::chrono::floor<std::chrono::seconds>(std::chrono::system_clock::now());
  return fmt::format("{:%Y-%m-%d %H:%M:%S} UTC",
                     fmt::gmtime(std::chrono::system_clock::to_time_t(now)));
}

void write_run_json(const std::filesystem::path& file, const RunRecord& record) {
  std::array<char, 256> host{};
  if (::gethostname(host.data(), host.size() - 1) != 0) host[0] = '\0';
  const nlohmann::ordered_json document = {
      {"program", record.program}, {"command", record.command},       {"created", now_text()},
      {"host", host.data()},       {"wall_time_s", record.wall_time}, {"summary", record.summary},
      {"case", record.input}};
  write_text_file(file, document.dump(2) + "\n");
}

}  // namespace osteomill::io
