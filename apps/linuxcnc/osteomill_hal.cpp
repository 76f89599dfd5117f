// SPDX-License-Identifier: BSD-3-Clause
// osteomill_hal SOCKET: the HAL component between LinuxCNC and `osteomill control`.
//
// It sets the pins to what the controller orders, and sends every servo cycle back. It decides one
// thing by itself: without a controller it holds, and a hold stays until a controller arms anew.
// Should it die or hang, its heartbeat pin stands still and the realtime watchdog holds the feed.

#include <fcntl.h>
#include <hal.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <string_view>

#include "osteomill/io/linuxcnc_link.hpp"

namespace {

using osteomill::io::linuxcnc::Cycle;
using osteomill::io::linuxcnc::Hello;
using osteomill::io::linuxcnc::kJoints;
using osteomill::io::linuxcnc::Order;
using osteomill::io::linuxcnc::State;

// The FIFO of sampler(9) number 0, and the pins that osteomill.hal gives it.
constexpr int kSamplerKey = 0x48534130;
constexpr int kSamplerPinCount = 15;
constexpr const char* kSamplerPins = "fffffffffssbbbb";
// From one controller to the next: looks, so that the servo thread sees the pin `armed` go down,
// which is what sets the watchdog back.
constexpr int kBetweenControllers = 40;
// Between two looks at the FIFO: half a servo cycle, so that no cycle waits longer than one.
constexpr timespec kLook = {0, 500'000};

volatile std::sig_atomic_t stop_asked = 0;

struct Pins {
  hal_float_t* adaptive_feed;
  hal_bit_t* feed_hold;
  hal_bit_t* spindle_inhibit;
  hal_bit_t* heartbeat;
  hal_bit_t* armed;
  hal_bit_t* heard;  ///< in: the watchdog hears the heartbeat
  hal_s32_t* state;
  hal_s32_t* order;
  hal_float_t* force;
};

bool make_pins(int component, Pins& pins) {
  const auto make = [&](auto create, const char* name, auto** pin) {
    return create(HAL_OUT, pin, component, "osteomill.%s", name) == 0;
  };
  return hal_pin_bit_newf(HAL_IN, &pins.heard, component, "osteomill.heard") == 0 &&
         make(hal_pin_float_newf, "adaptive-feed", &pins.adaptive_feed) &&
         make(hal_pin_bit_newf, "feed-hold", &pins.feed_hold) &&
         make(hal_pin_bit_newf, "spindle-inhibit", &pins.spindle_inhibit) &&
         make(hal_pin_bit_newf, "heartbeat", &pins.heartbeat) &&
         make(hal_pin_bit_newf, "armed", &pins.armed) &&
         make(hal_pin_s32_newf, "state", &pins.state) &&
         make(hal_pin_s32_newf, "order", &pins.order) &&
         make(hal_pin_float_newf, "force", &pins.force);
}

/// Nobody drives the machine: the feed is held. The watchdog is left to run out, because only then
/// does arming set it back; when it has, it is disarmed.
void let_go(const Pins& pins) {
  *pins.feed_hold = true;
  *pins.adaptive_feed = 0.0;
  *pins.order = 0;
  *pins.state = static_cast<int>(State::no_controller);
  if (!*pins.heard) *pins.armed = false;
}

/// Whether the order makes sense.
bool follow(const Pins& pins, const Order& order) {
  if (!(order.adaptive_feed >= 0.0 && order.adaptive_feed <= 1.0)) return false;
  if (order.arm != 0) {
    if (*pins.armed) return false;
    *pins.feed_hold = false;
    *pins.spindle_inhibit = false;
    *pins.armed = true;
  }
  if (!*pins.armed) return false;
  *pins.feed_hold = *pins.feed_hold || order.feed_hold != 0;
  *pins.spindle_inhibit = *pins.spindle_inhibit || order.spindle_inhibit != 0;
  *pins.adaptive_feed = order.adaptive_feed;
  *pins.force = order.force;
  *pins.state = static_cast<int>(order.state);
  *pins.order = order.number;
  return true;
}

class Link {
 public:
  explicit Link(const char* path) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    if (std::string_view(path).size() >= sizeof(address.sun_path)) return;
    std::strcpy(address.sun_path, path);
    unlink(path);
    umask(077);  // who may open the socket moves the machine
    listener_ = socket(AF_UNIX, SOCK_SEQPACKET | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    if (bind(listener_, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) != 0 ||
        listen(listener_, 1) != 0) {
      close(listener_);
      listener_ = -1;
    }
  }
  ~Link() {
    drop();
    if (listener_ >= 0) close(listener_);
  }
  Link(const Link&) = delete;
  Link& operator=(const Link&) = delete;

  bool listening() const { return listener_ >= 0; }
  bool connected() const { return client_ >= 0; }

  /// Sleeps until an order arrives, at the longest until the next look.
  void wait() const {
    pollfd what{client_, POLLIN, 0};  // not looked at when there is none
    ppoll(&what, 1, &kLook, nullptr);
  }

  void accept_one() {
    client_ = accept4(listener_, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
    if (connected()) send(Hello{osteomill::io::linuxcnc::kMagic, sizeof(Cycle)});
  }

  /// The next order, if one has come. A controller that is gone is dropped.
  bool receive(Order& order) {
    if (!connected()) return false;
    const ssize_t size = recv(client_, &order, sizeof(order), 0);
    if (size == static_cast<ssize_t>(sizeof(order))) return true;
    if (size < 0 && (errno == EAGAIN || errno == EINTR)) return false;
    drop();
    return false;
  }

  /// A controller that does not read loses cycles, and will see that it did.
  template <class Message>
  void send(const Message& message) {
    if (connected() && ::send(client_, &message, sizeof(message), MSG_NOSIGNAL) < 0 &&
        errno != EAGAIN) {
      drop();
    }
  }

  void drop() {
    if (connected()) close(client_);
    client_ = -1;
  }

 private:
  int listener_ = -1;
  int client_ = -1;
};

Cycle cycle_of(const std::array<hal_stream_data, kSamplerPinCount>& pins, unsigned number) {
  Cycle cycle;
  cycle.number = number;
  for (std::size_t i = 0; i < kJoints; ++i) cycle.joint[i] = pins[i].f;
  const hal_stream_data* pin = &pins[kJoints];
  cycle.feed = pin[0].f;
  cycle.adaptive_feed = pin[1].f;
  cycle.motion_type = pin[2].s;
  cycle.order = pin[3].s;
  cycle.feed_inhibited = pin[4].b;
  cycle.spindle_inhibited = pin[5].b;
  cycle.heart_beats = pin[6].b;
  cycle.motion_enabled = pin[7].b;
  return cycle;
}

void serve(const Pins& pins, hal_stream_t& cycles, Link& link) {
  std::array<hal_stream_data, kSamplerPinCount> data{};
  int alone = 0;  // looks without a controller and disarmed
  bool beat = false;
  while (stop_asked == 0) {
    link.wait();
    alone = link.connected() || *pins.armed ? 0 : alone + 1;
    if (alone > kBetweenControllers) link.accept_one();
    Order order;
    while (link.receive(order)) {
      beat = follow(pins, order);
      if (!beat) link.drop();
    }
    if (!link.connected()) let_go(pins);
    unsigned number = 0;
    while (hal_stream_readable(&cycles) && hal_stream_read(&cycles, data.data(), &number) >= 0) {
      link.send(cycle_of(data, number));
      // Once a servo cycle at most: two changes within one would look like none.
      if (beat) *pins.heartbeat = !*pins.heartbeat;
      beat = false;
    }
  }
  let_go(pins);
}

int run(int component, const char* path) {
  auto* pins = static_cast<Pins*>(hal_malloc(sizeof(Pins)));
  if (pins == nullptr || !make_pins(component, *pins)) {
    std::fprintf(stderr, "osteomill_hal: the pins cannot be made\n");
    return 1;
  }
  let_go(*pins);
  *pins->spindle_inhibit = true;
  hal_stream_t cycles{};
  if (hal_stream_attach(&cycles, component, kSamplerKey, kSamplerPins) < 0) {
    std::fprintf(stderr, "osteomill_hal: no sampler with cfg=%s; load osteomill.hal\n",
                 kSamplerPins);
    return 1;
  }
  Link link(path);
  if (!link.listening()) {
    std::fprintf(stderr, "osteomill_hal: cannot listen on %s: %s\n", path, std::strerror(errno));
    return 1;
  }
  hal_ready(component);
  serve(*pins, cycles, link);
  hal_stream_detach(&cycles);
  unlink(path);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: osteomill_hal SOCKET\n");
    return 2;
  }
  const auto stop = [](int) { stop_asked = 1; };
  std::signal(SIGTERM, stop);
  std::signal(SIGINT, stop);
  const int component = hal_init("osteomill");
  if (component < 0) {
    std::fprintf(stderr, "osteomill_hal: HAL is not running\n");
    return 1;
  }
  const int result = run(component, argv[1]);
  hal_exit(component);
  return result;
}
