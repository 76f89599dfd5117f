// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <memory>
#include <set>

#include "command.hpp"

namespace osteomill::cli {
namespace {

std::atomic<bool> stop_asked{false};
static_assert(std::atomic<bool>::is_always_lock_free);

void ask_to_stop(int) {
  stop_asked = true;
  std::signal(SIGINT, SIG_DFL);  // the second one ends the program
}

using Clock = std::chrono::steady_clock;

class Bar {
 public:
  Bar() : terminal_(::isatty(STDERR_FILENO) == 1) {}
  ~Bar() { clear(); }
  Bar(const Bar&) = delete;
  Bar& operator=(const Bar&) = delete;

  void show(std::string_view doing, double share) {
    if (doing != doing_) {
      clear();
      doing_ = doing;
      begin_ = Clock::now();
      tenth_ = 0;
    }
    const double spent = std::chrono::duration<double>(Clock::now() - begin_).count();
    if (terminal_) {
      if (spent - drawn_ < 0.05 && spent >= drawn_ && share < 1.0) return;
      drawn_ = spent;
      draw(share, spent);
    } else if (share >= 0.1 * (tenth_ + 1)) {
      tenth_ = static_cast<int>(share * 10.0);
      fmt::print(stderr, "{}: {:.0f} %\n", doing_, 100.0 * share);
    }
  }

 private:
  void draw(double share, double spent) {
    constexpr int kWidth = 30;
    const int full = static_cast<int>(std::clamp(share, 0.0, 1.0) * kWidth);
    std::string bar(static_cast<std::size_t>(full), '#');
    bar.resize(kWidth, '.');
    const std::string left = share > 0.02 && spent > 0.3
                                 ? fmt::format("{:.0f} s left", spent / share * (1.0 - share))
                                 : "";
    fmt::print(stderr, "\r\033[K{} [{}] {:3.0f} %  {}", doing_, bar, 100.0 * share, left);
    std::fflush(stderr);
    shown_ = true;
  }
  void clear() {
    if (shown_) fmt::print(stderr, "\r\033[K");
    shown_ = false;
    drawn_ = 0.0;
  }

  bool terminal_;
  bool shown_ = false;
  std::string doing_;
  Clock::time_point begin_ = Clock::now();
  double drawn_ = 0.0;
  int tenth_ = 0;
};

std::string quoted(const std::string& cell) {
  if (cell.find_first_of(",\"\n") == std::string::npos) return cell;
  std::string text = "\"";
  for (const char c : cell) text += c == '"' ? std::string("\"\"") : std::string(1, c);
  return text + '"';
}

/// Characters that a terminal shows, not bytes: continuation bytes of UTF-8 take no place.
std::size_t width(const std::string& text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xC0) != 0x80; }));
}

void refuse_not_finite(const nlohmann::ordered_json& value) {
  if (value.is_number_float() && !std::isfinite(value.get<double>())) {
    throw std::logic_error("a result is not a finite number");
  }
  if (value.is_structured()) {
    for (const auto& item : value) refuse_not_finite(item);
  }
}

}  // namespace

Progress console_progress() {
  std::signal(SIGINT, ask_to_stop);
  return [bar = std::make_shared<Bar>()](std::string_view doing, double share) {
    bar->show(doing, share);
    return !stop_asked;
  };
}

bool interrupted() { return stop_asked; }

void warn(const std::string& text) {
  static std::set<std::string> said;
  if (said.insert(text).second) fmt::print(stderr, "warning: {}\n", text);
}

void print_json(const nlohmann::ordered_json& document) {
  refuse_not_finite(document);
  fmt::print("{}\n", document.dump(2));
}

void print_table(const std::vector<std::vector<std::string>>& rows) {
  std::vector<std::size_t> widths;
  for (const auto& row : rows) {
    widths.resize(std::max(widths.size(), row.size()));
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], width(row[i]));
  }
  for (const auto& row : rows) {
    std::string line;
    for (std::size_t i = 0; i < row.size(); ++i) {
      const std::string space(widths[i] - width(row[i]), ' ');
      line += i == 0 ? row[i] + space : "  " + space + row[i];
    }
    line.erase(line.find_last_not_of(' ') + 1);
    fmt::print("{}\n", line);
  }
}

void print_csv(const std::vector<std::vector<std::string>>& rows) {
  for (const auto& row : rows) {
    for (std::size_t i = 0; i < row.size(); ++i)
      fmt::print("{}{}", i == 0 ? "" : ",", quoted(row[i]));
    fmt::print("\n");
  }
}

void add_format(CLI::App& command, Format& format) {
  command.add_option("--format", format, "table, json or csv")
      ->transform(CLI::CheckedTransformer(std::map<std::string, Format>{
          {"table", Format::table}, {"json", Format::json}, {"csv", Format::csv}}))
      ->default_str("table");
}

void add_case_arguments(CLI::App& command, CaseArguments& arguments) {
  command.add_option("case", arguments.case_file, "the case, a TOML file or the run.json of a run")
      ->required();
  command.add_option("--set", arguments.overrides, "replace a key: section.key=value")
      ->allow_extra_args(false);
  add_format(command, arguments.format);
  command.add_option("-o,--output", arguments.directory, "write a run directory");
}

}  // namespace osteomill::cli
