// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <string>

namespace osteomill::io {

/// LinuxCNC with the simulated machine, as a process of its own: started by `osteomill_machine`,
/// which shuts all of it down when this object goes, or when this process is gone.
class MachineProcess {
 public:
  /// `configuration`: osteomill.ini (x, y, z) or seven_axis.ini. Waits until the program waits for
  /// a controller. WorldError when it does not come up.
  MachineProcess(const std::filesystem::path& launcher, const std::string& program,
                 const std::string& configuration = "osteomill.ini");
  ~MachineProcess();
  MachineProcess(const MachineProcess&) = delete;
  MachineProcess& operator=(const MachineProcess&) = delete;

  std::filesystem::path socket() const { return folder_ / "machine" / "control"; }
  pid_t id() const { return process_; }

 private:
  void shut_down() noexcept;

  std::filesystem::path folder_;
  pid_t process_ = -1;
};

}  // namespace osteomill::io
