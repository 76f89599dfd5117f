// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <span>

#include "osteomill/base/random.hpp"
#include "osteomill/io/netft_client.hpp"

namespace osteomill::io::netft {

/// What a fake sensor does wrong.
enum class SensorFault : std::uint8_t {
  none,
  silent,     ///< sends nothing, as one whose cable is cut
  saturated,  ///< says so in its status
  frozen,     ///< sends the last measurement again and again
  lossy,      ///< every tenth record is lost on the way
  doubled,    ///< every record comes twice
  garbled     ///< datagrams that are no records
};

struct FakeOptions {
  double counts_per_newton = 1e6;
  double counts_per_newton_metre = 1e6;
  double noise = 0.0;  ///< standard deviation of each force, N; on the torques as many mN m
  std::uint64_t seed = 1;
};

/// A Net F/T sensor that speaks RDT on loopback, on a port of its own. It measures what it is told:
/// `measure` takes loads in the order of their samples, so whoever plays the bone drives it. Faults
/// may be set from another thread.
class FakeSensor {
 public:
  explicit FakeSensor(const FakeOptions& options = {});
  ~FakeSensor();
  FakeSensor(const FakeSensor&) = delete;
  FakeSensor& operator=(const FakeSensor&) = delete;

  int port() const;
  bool streaming() const;
  /// Answers what has been asked, then sends the samples to the client that asked for them last.
  void measure(std::span<const Sample> samples);
  void set_fault(SensorFault fault);
  /// What else loads the sensor: changes each load before it is measured; `number` counts them.
  using Tamper = std::function<void(Sample& load, std::uint64_t number)>;
  void set_tamper(Tamper tamper);

 private:
  struct Socket;
  void answer();
  void send(const Record& record);

  FakeOptions options_;
  Random random_;
  std::unique_ptr<Socket> socket_;
  std::mutex mutex_;  ///< for the two below
  SensorFault fault_ = SensorFault::none;
  Tamper tamper_;
  Record last_;
  Sample load_;  ///< the newest, without bias
  Sample zero_;  ///< what bias took for zero
};

}  // namespace osteomill::io::netft
