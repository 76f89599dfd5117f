// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <sstream>
#include <system_error>

#include "command.hpp"
#include "osteomill/base/error.hpp"

namespace {

enum Status { done = 0, other = 1, bad_input = 2, no_solution = 3, safety = 4, world = 5 };

void complain(const std::string& text) {
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) fmt::print(stderr, "error: {}\n", line);
}

}  // namespace

int main(int argc, char** argv) {
  using namespace osteomill;
  std::signal(SIGXFSZ, SIG_IGN);  // a file that may not grow is an error of writing, not the end
  CLI::App program{
      "osteomill predicts, plans, simulates and controls the milling of bone.\n"
      "For research and engineering; it is no medical device.",
      "osteomill"};
  program.require_subcommand(1);
  program.set_version_flag("--version", std::string("osteomill " OSTEOMILL_VERSION));
  for (const cli::Command& command : cli::commands()) command.add(program);
  try {
    program.parse(argc, argv);
    if (std::fflush(stdout) != 0) throw std::system_error(errno, std::generic_category());
    return done;
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return program.exit(error);  // --help, --version
    complain(std::string(error.what()) + "; osteomill --help lists the commands");
    return bad_input;
  } catch (const InvalidInput& error) {
    complain(error.what());
    return bad_input;
  } catch (const NoSolution& error) {
    complain(error.what());
    return no_solution;
  } catch (const SafetyStop& error) {
    complain(error.what());
    return safety;
  } catch (const WorldError& error) {
    complain(error.what());
    return world;
  } catch (const cli::Interrupted&) {
    complain("stopped by Ctrl-C; what was done is kept");
    return other;
  } catch (const std::system_error& error) {
    // What prints the result throws it when there is no room.
    if (std::ferror(stdout) == 0) {
      complain(error.what());
      return other;
    }
    complain(std::string("standard output: cannot be written: ") + error.code().message());
    return world;
  } catch (const std::exception& error) {
    complain(error.what());
    return other;
  }
}
