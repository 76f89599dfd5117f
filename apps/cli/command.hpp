// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "osteomill/base/progress.hpp"
#include "osteomill/io/section.hpp"

namespace osteomill::cli {

/// One command: how it joins the program, and the case that it reads (empty when it reads none).
struct Command {
  const char* name;
  void (*add)(CLI::App& program);
  std::function<void(io::Section&)> bind;
};
const std::vector<Command>& commands();

enum class Format { table, json, csv };

/// What every command that reads a case takes.
struct CaseArguments {
  std::filesystem::path case_file;
  std::vector<std::string> overrides;
  Format format = Format::table;
  std::filesystem::path directory;  ///< of the run; empty when none is written
};
void add_case_arguments(CLI::App& command, CaseArguments& arguments);
void add_format(CLI::App& command, Format& format);

/// The one JSON document of --format json. Refuses numbers that are not finite.
void print_json(const nlohmann::ordered_json& document);

/// A plain table with a heading row; every cell but the first column is right-aligned.
void print_table(const std::vector<std::vector<std::string>>& rows);
/// The same rows as comma-separated values.
void print_csv(const std::vector<std::vector<std::string>>& rows);

/// A warning, to standard error. The same one is said once: runs of one bone share theirs.
void warn(const std::string& text);

/// Progress to standard error: a bar with the time left on a terminal, a line every tenth
/// otherwise. From its first use Ctrl-C asks to stop; a second Ctrl-C ends the program.
Progress console_progress();
/// Whether Ctrl-C was pressed.
bool interrupted();

/// The work was stopped by Ctrl-C and what was done is kept. Exit status 1.
struct Interrupted {};

}  // namespace osteomill::cli
