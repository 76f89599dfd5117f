// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/netft_fake.hpp"

#include <utility>
// <utility> first: Asio 1.74 does not include all that it uses.
#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/udp.hpp>
#include <cmath>
#include <limits>
#include <optional>

#include "osteomill/base/error.hpp"

namespace osteomill::io::netft {
namespace {

using boost::asio::ip::udp;

/// Beyond the range of the counts the sensor is saturated.
bool in_counts(double load, double per_unit, std::int32_t& counts) {
  const double wanted = std::round(load * per_unit);
  constexpr double most = std::numeric_limits<std::int32_t>::max();
  counts = static_cast<std::int32_t>(std::clamp(wanted, -most, most));
  return std::abs(wanted) <= most;
}

}  // namespace

struct FakeSensor::Socket {
  boost::asio::io_context context;
  udp::socket socket{context};
  std::optional<udp::endpoint> client;
  std::uint32_t left = 0;  ///< records that are still asked for; 0: no end
};

FakeSensor::FakeSensor(const FakeOptions& options)
    : options_(options), random_(options.seed), socket_(std::make_unique<Socket>()) {
  try {
    socket_->socket.open(udp::v4());
    socket_->socket.bind({boost::asio::ip::address_v4::loopback(), 0});
    socket_->socket.non_blocking(true);
  } catch (const boost::system::system_error& error) {
    throw WorldError("no UDP port on loopback for the fake sensor (" + error.code().message() +
                     ")");
  }
}

FakeSensor::~FakeSensor() = default;

int FakeSensor::port() const { return socket_->socket.local_endpoint().port(); }

bool FakeSensor::streaming() const { return socket_->client.has_value(); }

void FakeSensor::set_fault(SensorFault fault) {
  const std::lock_guard lock(mutex_);
  fault_ = fault;
}

void FakeSensor::set_tamper(Tamper tamper) {
  const std::lock_guard lock(mutex_);
  tamper_ = std::move(tamper);
}

void FakeSensor::answer() {
  std::array<std::uint8_t, 64> bytes{};
  while (true) {
    udp::endpoint from;
    boost::system::error_code error;
    const std::size_t size =
        socket_->socket.receive_from(boost::asio::buffer(bytes), from, 0, error);
    if (error == boost::asio::error::connection_refused) continue;
    if (error) return;
    const std::optional<Request> request = decode_request({bytes.data(), size});
    if (!request) continue;
    if (request->command == Command::start) {
      socket_->client = from;
      socket_->left = request->sample_count;
      last_.rdt_sequence = 0;
    } else if (request->command == Command::stop) {
      socket_->client.reset();
    } else {
      zero_ = load_;
    }
  }
}

void FakeSensor::send(const Record& record) {
  if (!socket_->client) return;
  const auto bytes = encode(record);
  const std::size_t size = fault_ == SensorFault::garbled ? 17 : bytes.size();
  const int times = fault_ == SensorFault::doubled ? 2 : 1;
  for (int i = 0; i < times; ++i) {
    boost::system::error_code lost;  // UDP: what cannot be sent is lost
    socket_->socket.send_to(boost::asio::buffer(bytes.data(), size), *socket_->client, 0, lost);
  }
  if (socket_->left == 0) return;
  --socket_->left;
  if (socket_->left == 0) socket_->client.reset();
}

void FakeSensor::measure(std::span<const Sample> samples) {
  answer();
  const std::lock_guard lock(mutex_);
  for (const Sample& sample : samples) {
    load_ = sample;
    if (tamper_) tamper_(load_, last_.ft_sequence);
    Record record;
    record.rdt_sequence = last_.rdt_sequence + 1;
    record.ft_sequence = last_.ft_sequence + 1;
    bool measured = true;
    for (int i = 0; i < 3; ++i) {
      const double force = load_.force_S[i] - zero_.force_S[i];
      const double torque = load_.torque_S[i] - zero_.torque_S[i];
      const double noise = options_.noise > 0.0 ? options_.noise * random_.normal() : 0.0;
      measured &= in_counts(force + noise, options_.counts_per_newton, record.counts[i]);
      measured &=
          in_counts(torque + 1e-3 * noise, options_.counts_per_newton_metre, record.counts[i + 3]);
    }
    if (fault_ == SensorFault::frozen) record.counts = last_.counts;
    if (!measured || fault_ == SensorFault::saturated) {
      record.status = kStatusError | kStatusSaturated;
    }
    last_ = record;
    const bool dropped = fault_ == SensorFault::silent ||
                         (fault_ == SensorFault::lossy && record.rdt_sequence % 10 == 0);
    if (!dropped) send(record);
  }
}

}  // namespace osteomill::io::netft
