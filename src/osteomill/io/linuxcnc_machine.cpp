// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/linuxcnc_machine.hpp"

#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <cmath>
#include <cstring>

#include "osteomill/base/error.hpp"

namespace osteomill::io::linuxcnc {
namespace {

bool readable(int socket, double patience) noexcept {
  pollfd what{socket, POLLIN, 0};
  const auto whole = static_cast<time_t>(patience);
  const timespec wait{whole, static_cast<long>((patience - static_cast<double>(whole)) * 1e9)};
  return ppoll(&what, 1, &wait, nullptr) == 1;
}

int connect_to(const std::filesystem::path& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  const std::string name = path.string();
  if (name.empty() || name.size() >= sizeof(address.sun_path)) {
    throw InvalidInput(Fault{"--machine", name, "must be the name of a socket", ""});
  }
  std::memcpy(address.sun_path, name.c_str(), name.size() + 1);
  const int made = socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0);
  if (made < 0 ||
      connect(made, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) != 0) {
    const std::string reason = std::strerror(errno);
    if (made >= 0) close(made);
    throw WorldError("no machine at " + name + " (" + reason +
                     "); is LinuxCNC running with osteomill.hal?");
  }
  return made;
}

}  // namespace

Machine::Machine(const std::filesystem::path& socket) : socket_(connect_to(socket)) {
  Hello hello;
  // A second: the component looks two thousand times a second.
  const bool answered = readable(socket_, 1.0) &&
                        recv(socket_, &hello, sizeof(hello), 0) == sizeof(hello) &&
                        hello.magic == kMagic && hello.cycle_bytes == sizeof(Cycle);
  if (!answered) {
    close(socket_);
    throw WorldError("the machine at " + socket.string() +
                     " does not answer as this build expects; another controller may have it, or "
                     "osteomill_hal is of another version");
  }
}

Machine::~Machine() { close(socket_); }

bool Machine::receive(std::vector<Cycle>& cycles, double patience) noexcept {
  const std::size_t before = cycles.size();
  bool wait = true;
  while (cycles.size() < cycles.capacity()) {
    if (wait && !readable(socket_, patience)) return false;
    Cycle cycle;
    const ssize_t size = recv(socket_, &cycle, sizeof(cycle), wait ? 0 : MSG_DONTWAIT);
    if (size < 0 && errno == EINTR) continue;
    if (size != static_cast<ssize_t>(sizeof(cycle))) break;
    cycles.push_back(cycle);
    wait = false;
  }
  return cycles.size() > before;
}

bool Machine::send(Order order) noexcept {
  order.number = ++number_;
  order.arm = number_ == 1 ? 1 : 0;
  return ::send(socket_, &order, sizeof(order), MSG_NOSIGNAL | MSG_DONTWAIT) ==
         static_cast<ssize_t>(sizeof(order));
}

}  // namespace osteomill::io::linuxcnc
