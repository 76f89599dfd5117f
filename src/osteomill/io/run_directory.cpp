// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/run_directory.hpp"

#include <set>
#include <sstream>
#include <utility>

#include "osteomill/base/error.hpp"
#include "osteomill/io/text_file.hpp"

namespace osteomill::io {
namespace {

namespace fs = std::filesystem;

constexpr const char* kMark = "run.json";
constexpr const char* kAside = ".unfinished";
constexpr const char* kList =
    ".files";  // what the run wrote, so that the next one can take it away

std::set<std::string> listed(const fs::path& folder) {
  std::set<std::string> names;
  if (!fs::exists(folder / kList)) return names;
  std::istringstream lines(read_text_file(folder / kList));
  for (std::string name; std::getline(lines, name);)
    // Only plain names: a list that somebody changed must not lead elsewhere.
    if (!name.empty() && fs::path(name).filename() == name && name != "." && name != "..")
      names.insert(name);
  return names;
}

}  // namespace

RunDirectory::RunDirectory(fs::path folder) : folder_(std::move(folder)), aside_(folder_ / kAside) {
  std::error_code error;
  if (fs::exists(folder_, error) && !fs::is_directory(folder_, error))
    throw InvalidInput({"-o", folder_.string(), "is a file", "name a folder"});
  if (fs::is_directory(folder_, error)) {
    fs::remove_all(aside_, error);
    if (!fs::exists(folder_ / kMark) && !fs::is_empty(folder_, error))
      throw InvalidInput({"-o", folder_.string(),
                          "holds other things than a run, and would be written over",
                          "name a new folder, an empty one, or that of a former run"});
  } else {
    made_ = true;
  }
  if (!fs::create_directories(aside_, error))
    throw WorldError(folder_.string() + ": cannot be written: " + error.message() +
                     "; choose a folder that you may write to");
}

RunDirectory::~RunDirectory() {
  std::error_code ignored;
  fs::remove_all(aside_, ignored);
  if (made_) fs::remove(folder_, ignored);  // only when it is empty
}

void RunDirectory::commit() {
  try {
    std::set<std::string> fresh;
    for (const auto& entry : fs::directory_iterator(aside_))
      fresh.insert(entry.path().filename().string());
    if (!fresh.contains(kMark)) throw WorldError(folder_.string() + ": the run has no run.json");
    std::string names;
    for (const std::string& name : fresh) names += name + "\n";
    write_text_file(aside_ / kList, names);
    const std::set<std::string> former = listed(folder_);
    fresh.erase(kMark);
    for (const std::string& name : fresh) {
      if (fs::is_directory(folder_ / name)) fs::remove_all(folder_ / name);
      fs::rename(aside_ / name, folder_ / name);
    }
    fs::rename(aside_ / kList, folder_ / kList);
    fs::rename(aside_ / kMark, folder_ / kMark);
    for (const std::string& name : former)
      if (!fresh.contains(name) && name != kMark) fs::remove_all(folder_ / name);
    fs::remove_all(aside_);
    made_ = false;
  } catch (const fs::filesystem_error& error) {
    throw WorldError(folder_.string() + ": cannot be written: " + error.code().message());
  }
}

}  // namespace osteomill::io
