// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/netft_client.hpp"

#include <utility>
// <utility> first: Asio 1.74 does not include all that it uses.
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/udp.hpp>

#include "osteomill/base/error.hpp"

namespace osteomill::io::netft {
namespace {

using boost::asio::ip::udp;

boost::asio::ip::address address_of(const std::string& text) {
  boost::system::error_code error;
  const auto address = boost::asio::ip::make_address(text, error);
  if (error) {
    throw InvalidInput(
        Fault{"sensor.address", text, "must be an IP address", "a new sensor has 192.168.1.1"});
  }
  return address;
}

}  // namespace

void check(const ClientOptions& options) {
  FaultList faults;
  faults.gather([&] { address_of(options.address); });
  faults.gather([&] { require_within("sensor.port", options.port, 1, 65535, ""); });
  faults.gather(
      [&] { require_positive("sensor.counts_per_newton", options.counts_per_newton, "1/N"); });
  faults.gather([&] {
    require_positive("sensor.counts_per_newton_metre", options.counts_per_newton_metre, "1/(N m)");
  });
  faults.raise();
}

struct Client::Socket {
  boost::asio::io_context context;
  udp::socket socket{context};
};

Client::Client(const ClientOptions& options, std::function<double()> clock)
    : options_(options), clock_(std::move(clock)), socket_(std::make_unique<Socket>()) {
  check(options_);
  const udp::endpoint sensor(address_of(options_.address),
                             static_cast<unsigned short>(options_.port));
  try {
    socket_->socket.open(sensor.protocol());
    // A second of records at 8 kHz; the system may grant less.
    boost::system::error_code ignored;
    ignored = socket_->socket.set_option(udp::socket::receive_buffer_size(1 << 21), ignored);
    socket_->socket.connect(sensor);
    socket_->socket.non_blocking(true);
  } catch (const boost::system::system_error& error) {
    throw WorldError("the force sensor " + options_.address + " cannot be reached (" +
                     error.code().message() + "); check the network");
  }
  health_.newest = clock_();
}

Client::~Client() {
  boost::system::error_code ignored;  // a sensor that is gone needs no stop
  socket_->socket.send(boost::asio::buffer(encode(Request{Command::stop, 0})), 0, ignored);
}

void Client::send(Command command) {
  boost::system::error_code error;
  socket_->socket.send(boost::asio::buffer(encode(Request{command, 0})), 0, error);
  // Refused: what an earlier datagram met. The age of the records tells a sensor that is gone.
  if (error && error != boost::asio::error::connection_refused) {
    throw WorldError("the force sensor " + options_.address + " cannot be reached (" +
                     error.message() + "); check the network");
  }
}

void Client::start() {
  health_ = {};
  health_.newest = clock_();
  last_ = {};
  send(Command::start);
}

void Client::stop() { send(Command::stop); }

void Client::bias() { send(Command::bias); }

bool Client::accept(const Record& record) {
  const bool first = health_.received == 0;
  // Sequence numbers wrap: only their difference means something.
  const auto ahead = static_cast<std::int32_t>(record.rdt_sequence - last_.rdt_sequence);
  if (!first && ahead <= 0) {
    ++health_.out_of_order;
    return false;
  }
  // The stream begins with record 1; what is missing before the first that arrives is lost, too.
  health_.lost += static_cast<std::uint64_t>(ahead - 1);
  const bool same =
      !first && (record.counts == last_.counts || record.ft_sequence == last_.ft_sequence);
  health_.frozen = same ? health_.frozen + 1 : 0;
  health_.status = record.status;
  health_.saturated = saturated(record.status);
  ++health_.received;
  last_ = record;
  return true;
}

std::size_t Client::receive(std::vector<Sample>& samples) {
  std::array<std::uint8_t, kRecordBytes + 1> bytes{};
  std::size_t count = 0;
  while (true) {
    boost::system::error_code error;
    const std::size_t size = socket_->socket.receive(boost::asio::buffer(bytes), 0, error);
    if (error == boost::asio::error::connection_refused) continue;  // an answer to a request
    if (error) break;  // nothing more has arrived, or the network is gone: the age will tell
    const std::optional<Record> record = decode_record({bytes.data(), size});
    if (!record) {
      ++health_.malformed;
      continue;
    }
    if (!accept(*record)) continue;
    Sample sample;
    sample.number = record->rdt_sequence;
    for (int i = 0; i < 3; ++i) {
      sample.force_S[i] = record->counts[i] / options_.counts_per_newton;
      sample.torque_S[i] = record->counts[i + 3] / options_.counts_per_newton_metre;
    }
    samples.push_back(sample);
    ++count;
  }
  if (count > 0) health_.newest = clock_();
  return count;
}

double Client::age() const { return clock_() - health_.newest; }

}  // namespace osteomill::io::netft
