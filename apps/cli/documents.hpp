// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "command.hpp"
#include "osteomill/io/case_file.hpp"

namespace osteomill::cli {

/// A picture of a run directory.
struct Figure {
  std::string name;     ///< of the file, without suffix
  std::string caption;  ///< what it shows
  std::function<void(const std::filesystem::path& file)> draw;
};

/// Another file of a run directory.
struct TextFile {
  std::string name;
  std::string text;
};

/// A file of a run directory in a format of its own.
struct WrittenFile {
  std::string name;
  std::function<void(const std::filesystem::path& file)> write;
};

/// What a command has to show of one run.
struct Shown {
  nlohmann::ordered_json document;
  nlohmann::ordered_json expanded;             ///< the case with its defaults
  std::vector<std::vector<std::string>> rows;  ///< with a heading row
  std::vector<std::string> sentences = {};     ///< below the table
  std::vector<std::string> warnings = {};
  std::vector<Figure> figures = {};
  std::vector<std::vector<std::vector<std::string>>> tables = {};  ///< further ones, not in csv
  std::vector<TextFile> files = {};                                ///< of the run directory
  std::vector<WrittenFile> written = {};                           ///< likewise
};

/// Solves every run of a case and shows it as the arguments ask: one JSON document (of one run, or
/// { "runs": [ { "name": …, … } ] }), a table or csv; with -o a run directory with run.json,
/// figures and report.html.
void show_runs(const CaseArguments& arguments, const std::string& command,
               const std::function<Shown(const io::CaseRun&)>& solve);

}  // namespace osteomill::cli
