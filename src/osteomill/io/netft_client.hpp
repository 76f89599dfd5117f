// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "osteomill/geometry/pose.hpp"
#include "osteomill/io/netft_protocol.hpp"

namespace osteomill::io::netft {

struct ClientOptions {
  std::string address = "192.168.1.1";  ///< of the sensor, as it leaves the factory
  int port = kPort;
  double counts_per_newton = 1e6;        ///< as its web page says (netftapi2.xml, cfgcpf)
  double counts_per_newton_metre = 1e6;  ///< cfgcpt
};

/// Throws InvalidInput that names the field.
void check(const ClientOptions& options);

/// Load on the sensor in its own frame S.
struct Sample {
  geometry::Vector3 force_S = geometry::Vector3::Zero();   ///< N
  geometry::Vector3 torque_S = geometry::Vector3::Zero();  ///< N m
  std::uint32_t number = 0;  ///< of the record since the stream began, from 1
};

/// What became of the stream since it was started.
struct Health {
  std::uint64_t received = 0;      ///< records that were believed
  std::uint64_t lost = 0;          ///< gaps in the sequence
  std::uint64_t out_of_order = 0;  ///< doubled or late: dropped
  std::uint64_t malformed = 0;     ///< datagrams that are no record: dropped
  std::uint32_t status = 0;        ///< of the newest record
  bool saturated = false;          ///< the newest record says so
  int frozen = 0;  ///< records in a row that measured nothing new: same counts or same measurement
  double newest = 0.0;  ///< arrival of the newest record by the client's clock, s
};

/// Receives the stream of one sensor. Nothing blocks: `receive` takes what has arrived. Datagrams
/// from elsewhere are not received, the socket is connected to the sensor. The sensor streams to
/// one client; it is told to stop when the client goes.
class Client {
 public:
  /// `clock`: seconds, for the age of the newest record. WorldError when there is no such network.
  Client(const ClientOptions& options, std::function<double()> clock);
  ~Client();
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;

  void start();  ///< asks for records until told to stop; the health begins anew
  void stop();
  void bias();
  /// Appends what has arrived since the last call; returns how many.
  std::size_t receive(std::vector<Sample>& samples);
  const Health& health() const { return health_; }
  /// Since the newest record, or since start() when none has come, s.
  double age() const;

 private:
  struct Socket;
  void send(Command command);
  bool accept(const Record& record);

  ClientOptions options_;
  std::function<double()> clock_;
  std::unique_ptr<Socket> socket_;
  Health health_;
  Record last_;
};

}  // namespace osteomill::io::netft
