// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/linuxcnc_machine.hpp"

#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>

#include "osteomill/base/error.hpp"

namespace osteomill::io::linuxcnc {
namespace {

timespec time_of(double seconds) noexcept {
  const auto whole = static_cast<time_t>(seconds);
  return {whole, static_cast<long>((seconds - static_cast<double>(whole)) * 1e9)};
}

bool readable(int socket, double patience) noexcept {
  pollfd what{socket, POLLIN, 0};
  const timespec wait = time_of(patience);
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

Machine::Machine(const std::filesystem::path& socket)
    : socket_(connect_to(socket)), call_(eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {
  Hello hello;
  // A second: the component looks two thousand times a second.
  const bool answered = readable(socket_, 1.0) &&
                        recv(socket_, &hello, sizeof(hello), 0) == sizeof(hello) &&
                        hello.magic == kMagic && hello.cycle_bytes == sizeof(Cycle);
  if (!answered) {
    close(socket_);
    close(call_);
    throw WorldError("the machine at " + socket.string() +
                     " does not answer as this build expects; another controller may have it, or "
                     "osteomill_hal is of another version");
  }
}

Machine::~Machine() {
  close(socket_);
  close(call_);
}

Came Machine::receive(std::vector<Cycle>& cycles, double patience) noexcept {
  std::array<pollfd, 2> what{{{socket_, POLLIN, 0}, {call_, POLLIN, 0}}};
  const timespec wait = time_of(patience);
  // Interrupted by a signal: looked at again as if called.
  const int ready = ppoll(what.data(), what.size(), &wait, nullptr);
  if (ready == 0) return Came::nothing;
  std::uint64_t calls = 0;
  if (what[1].revents != 0 && read(call_, &calls, sizeof(calls)) < 0) calls = 0;
  const std::size_t before = cycles.size();
  while (cycles.size() < cycles.capacity()) {
    Cycle cycle;
    const ssize_t size = recv(socket_, &cycle, sizeof(cycle), MSG_DONTWAIT);
    if (size < 0 && errno == EINTR) continue;
    if (size == 0) return Came::nothing;  // the component is gone
    if (size != static_cast<ssize_t>(sizeof(cycle))) break;
    cycles.push_back(cycle);
  }
  return cycles.size() > before ? Came::cycles : Came::call;
}

void Machine::call() noexcept {
  const std::uint64_t one = 1;
  // It can only fail when as many calls wait as there are numbers: then it is awake anyway.
  if (write(call_, &one, sizeof(one)) < 0) return;
}

bool Machine::send(Order order) noexcept {
  order.number = ++number_;
  order.arm = number_ == 1 ? 1 : 0;
  return ::send(socket_, &order, sizeof(order), MSG_NOSIGNAL | MSG_DONTWAIT) ==
         static_cast<ssize_t>(sizeof(order));
}

}  // namespace osteomill::io::linuxcnc
