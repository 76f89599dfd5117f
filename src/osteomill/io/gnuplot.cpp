// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/gnuplot.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <iterator>

#include "osteomill/base/error.hpp"
#include "osteomill/io/pending_file.hpp"
#include "osteomill/io/text_file.hpp"

namespace osteomill::io::gnuplot {
namespace {

constexpr double kPixelsPerPoint = 2.0;

bool is_png(const std::filesystem::path& path) { return path.extension() == ".png"; }

/// A child with the pipe's reading end as standard input and a file as standard error.
pid_t spawn(int input, const std::filesystem::path& errors) {
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, input, STDIN_FILENO);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, errors.c_str(), O_WRONLY | O_TRUNC, 0);
  char program[] = "gnuplot";
  char no_user_settings[] = "-d";
  char* arguments[] = {program, no_user_settings, nullptr};
  pid_t child = -1;
  const int failed = posix_spawnp(&child, program, &actions, nullptr, arguments, environ);
  posix_spawn_file_actions_destroy(&actions);
  return failed == 0 ? child : -1;
}

}  // namespace

std::string quoted(std::string_view text) {
  std::string out = "'";
  for (const char c : text) {
    if (c == '\'') out += '\'';
    out += c == '\n' ? ' ' : c;
  }
  return out + "'";
}

std::string data_block(std::string_view name,
                       const std::vector<const std::vector<double>*>& columns) {
  fmt::memory_buffer out;
  fmt::format_to(std::back_inserter(out), "${} << EOD\n", name);
  for (std::size_t row = 0; row < columns.front()->size(); ++row) {
    for (const std::vector<double>* column : columns)
      fmt::format_to(std::back_inserter(out), "{:.7g} ", (*column)[row]);
    out.push_back('\n');
  }
  fmt::format_to(std::back_inserter(out), "EOD\n");
  return fmt::to_string(out);
}

std::string font(const std::filesystem::path& path, double points) {
  // An SVG counts in pixels of 1/96 inch, the others in points of 1/72 inch.
  const double scale = is_png(path)                 ? kPixelsPerPoint
                       : path.extension() == ".svg" ? 96.0 / 72
                                                    : 1.0;
  return fmt::format("font ',{:.1f}'", points * scale);
}

std::string prologue(const std::filesystem::path& path, int width, int height) {
  std::string terminal;
  const std::string face = "DejaVu Sans";
  if (is_png(path))
    terminal = fmt::format("pngcairo size {},{} font '{},{}' linewidth {} pointscale {} noenhanced",
                           width * kPixelsPerPoint, height * kPixelsPerPoint, face,
                           8 * kPixelsPerPoint, kPixelsPerPoint, kPixelsPerPoint);
  else if (path.extension() == ".svg")
    terminal = fmt::format("svg size {},{} font '{},11' background '#ffffff' noenhanced", width,
                           height, face);
  else if (path.extension() == ".pdf")
    terminal = fmt::format("pdfcairo size {:.3f}in,{:.3f}in font '{},8' linewidth 1.2 noenhanced",
                           width / 96.0, height / 96.0, face);
  else
    throw InvalidInput({path.string(), path.extension().string(), "must end in .png, .svg or .pdf",
                        "choose one of these formats"});
  return fmt::format(
      "set terminal {}\n"
      "set encoding utf8\n"
      "set border 3 lc rgb '#555555' lw 0.75\n"
      "set tics nomirror out scale 0.5 textcolor rgb '#333333'\n"
      "set grid back lt 1 lc rgb '#e4e4e4' lw 0.5\n"
      "set key noautotitle textcolor rgb '#222222'\n"
      "set pointintervalbox 0\n"
      "set style textbox opaque fillcolor rgb '#ffffff' noborder margins 0.4,0.3\n"
      "set style fill transparent solid 0.2 noborder\n",
      terminal);
}

void run(std::string_view script, const std::filesystem::path& path) {
  PendingFile picture(path);
  const std::string text = fmt::format("set output {}\n{}\nunset output\n",
                                       gnuplot::quoted(picture.path().string()), script);
  // The script waits in a file of no name, so that a gnuplot that ends early takes nobody with it.
  const std::filesystem::path errors_path = picture.path().string() + ".log";
  const PendingFile errors(errors_path);
  std::FILE* input = std::tmpfile();
  if (input == nullptr)
    throw WorldError(fmt::format("no temporary file: {}", std::strerror(errno)));
  const bool written = std::fwrite(text.data(), 1, text.size(), input) == text.size() &&
                       std::fflush(input) == 0 && std::fseek(input, 0, SEEK_SET) == 0;
  const pid_t child = written ? spawn(fileno(input), errors.path()) : -1;
  int status = -1;
  while (child > 0 && waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  std::fclose(input);
  if (!written) throw WorldError("no room for a temporary file; free some disk space");
  if (child < 0)
    throw WorldError(
        fmt::format("{}: gnuplot does not start; install it: apt-get install "
                    "gnuplot-nox fonts-dejavu-core",
                    path.string()));
  const std::string complaint = read_text_file(errors.path());
  if (status != 0 || std::filesystem::file_size(picture.path()) == 0)
    throw WorldError(fmt::format("{}: gnuplot failed: {}", path.string(),
                                 complaint.empty() ? "it wrote nothing" : complaint));
  picture.commit();
}

}  // namespace osteomill::io::gnuplot
