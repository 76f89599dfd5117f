// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <vector>

#include "osteomill/io/linuxcnc_link.hpp"

namespace osteomill::io::linuxcnc {

/// What ended a wait for the machine.
enum class Came : std::uint8_t { cycles, call, nothing };

/// The controller's end of the link to a LinuxCNC that runs `osteomill_hal`. When it goes, whatever
/// the reason, the component sees it and holds the feed.
class Machine {
 public:
  /// WorldError when nobody listens on the socket, or another build does.
  explicit Machine(const std::filesystem::path& socket);
  ~Machine();
  Machine(const Machine&) = delete;
  Machine& operator=(const Machine&) = delete;

  /// Appends the servo cycles that have come, as many as the vector has room for, waiting at the
  /// longest `patience` seconds for the first, or until another thread calls. `nothing`: the
  /// machine is lost.
  Came receive(std::vector<Cycle>& cycles, double patience) noexcept;
  /// From another thread: whoever waits in `receive` has something else to do.
  void call() noexcept;
  /// Sends an order under the next number; the first one arms. False when the machine is lost.
  bool send(Order order) noexcept;
  std::int32_t last_order() const { return number_; }

 private:
  int socket_ = -1;
  int call_ = -1;  ///< eventfd
  std::int32_t number_ = 0;
};

}  // namespace osteomill::io::linuxcnc
