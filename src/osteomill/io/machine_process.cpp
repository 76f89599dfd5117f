// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/machine_process.hpp"

#include <signal.h>
#include <spawn.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <cstring>
#include <fstream>
#include <thread>

#include "osteomill/base/error.hpp"

namespace osteomill::io {
namespace {

using namespace std::chrono_literals;

// LinuxCNC takes three seconds to come up on an idle machine; another one of ours may have to end
// first, for which the launcher waits five minutes.
constexpr auto kPatience = 400s;

std::filesystem::path make_folder() {
  std::string name = (std::filesystem::temp_directory_path() / "osteomill-machine-XXXXXX").string();
  if (mkdtemp(name.data()) == nullptr) {
    throw WorldError("no temporary folder for the machine (" + std::string(std::strerror(errno)) +
                     ")");
  }
  // The machine's own folder, within, belongs to an unprivileged user, who has to get there.
  std::filesystem::permissions(name, std::filesystem::perms(0711));
  return name;
}

pid_t start(const std::filesystem::path& launcher, const std::filesystem::path& folder,
            const std::string& configuration) {
  const std::string name = launcher.string();
  const std::string machine = (folder / "machine").string();
  const std::string program = (folder / "program.ngc").string();
  std::array<char*, 5> arguments = {
      const_cast<char*>(name.c_str()), const_cast<char*>(machine.c_str()),
      const_cast<char*>(program.c_str()), const_cast<char*>(configuration.c_str()), nullptr};
  pid_t process = -1;
  const int error =
      posix_spawn(&process, name.c_str(), nullptr, nullptr, arguments.data(), environ);
  if (error != 0) {
    throw WorldError("cannot start " + name + " (" + std::strerror(error) +
                     "); LinuxCNC's part is built where linuxcnc-uspace-dev is installed");
  }
  return process;
}

}  // namespace

MachineProcess::MachineProcess(const std::filesystem::path& launcher, const std::string& program,
                               const std::string& configuration)
    : folder_(make_folder()) {
  std::ofstream(folder_ / "program.ngc") << program;
  try {
    process_ = start(launcher, folder_, configuration);
  } catch (const WorldError&) {
    shut_down();
    throw;
  }
  const auto begin = std::chrono::steady_clock::now();
  while (!std::filesystem::exists(folder_ / "machine" / "ready")) {
    if (waitpid(process_, nullptr, WNOHANG) == process_) {
      process_ = -1;
      break;
    }
    if (std::chrono::steady_clock::now() - begin > kPatience) break;
    std::this_thread::sleep_for(20ms);
  }
  if (std::filesystem::exists(folder_ / "machine" / "ready")) return;
  std::string log;
  std::ifstream file(folder_ / "machine" / "log");
  for (std::string line; std::getline(file, line);) log = line;
  shut_down();
  throw WorldError("the simulated machine did not come up" +
                   (log.empty() ? std::string() : "; LinuxCNC's last words: " + log));
}

MachineProcess::~MachineProcess() { shut_down(); }

void MachineProcess::shut_down() noexcept {
  if (process_ > 0) {
    kill(process_, SIGTERM);
    waitpid(process_, nullptr, 0);
  }
  process_ = -1;
  std::error_code ignored;  // a temporary folder that cannot be removed harms nobody
  std::filesystem::remove_all(folder_, ignored);
}

}  // namespace osteomill::io
