// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>

#include <cstdint>
#include <vector>

#include "osteomill/base/error.hpp"
#include "osteomill/io/netft_client.hpp"
#include "osteomill/io/netft_fake.hpp"
#include "osteomill/io/netft_protocol.hpp"

namespace osteomill::io::netft {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

Sample load(double x, double y, double z, double torque = 0.0) {
  return {{x, y, z}, {0.0, 0.0, torque}, 0};
}

/// A client on a fake sensor, with a clock that the test sets.
struct Pair {
  explicit Pair(const FakeOptions& options = {}) : sensor(options) { client.start(); }
  std::vector<Sample> pass(const std::vector<Sample>& samples) {
    sensor.measure(samples);
    std::vector<Sample> arrived;
    client.receive(arrived);
    return arrived;
  }
  double now = 0.0;
  FakeSensor sensor;
  Client client{{.address = "127.0.0.1", .port = sensor.port()}, [this] { return now; }};
};

TEST(NetftProtocol, RequestsHaveTheBytesThatTheManualPrints) {
  EXPECT_THAT(encode(Request{Command::start, 0}), ElementsAre(0x12, 0x34, 0, 2, 0, 0, 0, 0));
  EXPECT_THAT(encode(Request{Command::bias, 1}), ElementsAre(0x12, 0x34, 0, 0x42, 0, 0, 0, 1));
}

TEST(NetftProtocol, RecordsComeBackAsTheyWere) {
  const Record record{
      0xfffffffeU, 7, kStatusError | kStatusSaturated, {1, -1, 2, -2, 3, INT32_MIN}};
  const auto bytes = encode(record);
  EXPECT_EQ(bytes[0], 0xff);
  EXPECT_EQ(bytes[3], 0xfe);
  const auto again = decode_record(bytes);
  ASSERT_TRUE(again);
  EXPECT_EQ(again->rdt_sequence, record.rdt_sequence);
  EXPECT_EQ(again->ft_sequence, record.ft_sequence);
  EXPECT_EQ(again->status, record.status);
  EXPECT_EQ(again->counts, record.counts);
}

TEST(NetftProtocol, RefusesWhatIsNoMessage) {
  const std::vector<std::vector<std::uint8_t>> wrong = {
      {},
      {0x12, 0x34},
      {0x12, 0x35, 0, 2, 0, 0, 0, 0},
      {0x12, 0x34, 0, 9, 0, 0, 0, 0},
      {0x12, 0x34, 0, 2, 0, 0, 0, 0, 0},
  };
  for (const auto& bytes : wrong) {
    EXPECT_FALSE(decode_request(bytes)) << bytes.size() << " bytes";
    EXPECT_FALSE(decode_record(bytes)) << bytes.size() << " bytes";
  }
  EXPECT_FALSE(decode_record(std::vector<std::uint8_t>(35)));
  EXPECT_FALSE(decode_record(std::vector<std::uint8_t>(37)));
}

TEST(NetftProtocol, SaysWhatTheStatusMeans) {
  EXPECT_EQ(describe_status(0), "healthy");
  EXPECT_THAT(describe_status(0x80020000U), HasSubstr("saturated"));
  EXPECT_THAT(describe_status(0x80000004U), HasSubstr("other"));
  EXPECT_TRUE(saturated(0x80020000U));
  EXPECT_TRUE(faulty(0x80020000U));
  EXPECT_TRUE(faulty(0x10000000U));
  // A threshold that the user set says nothing about the measurement.
  EXPECT_FALSE(faulty(kStatusError | kStatusMonitor));
}

TEST(NetftClient, ReadsTheLoadsThatTheSensorMeasures) {
  Pair pair;
  const std::vector<Sample> arrived = pair.pass({load(1.5, -2.25, 3.0, 0.125), load(-4, 5, -6)});
  ASSERT_EQ(arrived.size(), 2U);
  // Half a count of 1e-6 N.
  EXPECT_LT((arrived[0].force_S - geometry::Vector3(1.5, -2.25, 3.0)).norm(), 1e-6);
  EXPECT_NEAR(arrived[0].torque_S.z(), 0.125, 1e-6);
  EXPECT_LT((arrived[1].force_S - geometry::Vector3(-4, 5, -6)).norm(), 1e-6);
  EXPECT_EQ(pair.client.health().lost, 0U);
}

TEST(NetftClient, ReceivesNothingBeforeItAskedNorAfterItStopped) {
  FakeSensor sensor;
  Client client({.address = "127.0.0.1", .port = sensor.port()}, [] { return 0.0; });
  std::vector<Sample> arrived;
  const std::vector<Sample> one = {load(1, 2, 3)};
  sensor.measure(one);
  EXPECT_EQ(client.receive(arrived), 0U);
  client.start();
  sensor.measure(one);
  EXPECT_EQ(client.receive(arrived), 1U);
  client.stop();
  sensor.measure(one);
  EXPECT_EQ(client.receive(arrived), 0U);
}

TEST(NetftClient, TellsTheSensorToStopWhenItGoes) {
  FakeSensor sensor;
  const std::vector<Sample> one = {load(1, 2, 3)};
  {
    Client client({.address = "127.0.0.1", .port = sensor.port()}, [] { return 0.0; });
    client.start();
    sensor.measure(one);
    EXPECT_TRUE(sensor.streaming());
  }
  sensor.measure(one);
  EXPECT_FALSE(sensor.streaming());
}

TEST(NetftClient, TakesThePresentLoadForZero) {
  Pair pair;
  pair.pass({load(10, 20, 30)});
  pair.client.bias();
  const std::vector<Sample> arrived = pair.pass({load(11, 20, 30)});
  ASSERT_EQ(arrived.size(), 1U);
  EXPECT_LT((arrived[0].force_S - geometry::Vector3(1, 0, 0)).norm(), 1e-6);
}

TEST(NetftClient, CountsEveryRecordThatIsLost) {
  Pair pair;
  pair.sensor.set_fault(SensorFault::lossy);
  pair.pass(std::vector<Sample>(105, load(1, 2, 3)));
  // Records 10, 20 ... 100 of 105.
  EXPECT_EQ(pair.client.health().received, 95U);
  EXPECT_EQ(pair.client.health().lost, 10U);
}

TEST(NetftClient, BelievesADoubledRecordOnce) {
  Pair pair;
  pair.sensor.set_fault(SensorFault::doubled);
  EXPECT_EQ(pair.pass(std::vector<Sample>(20, load(1, 2, 3))).size(), 20U);
  EXPECT_EQ(pair.client.health().out_of_order, 20U);
  EXPECT_EQ(pair.client.health().lost, 0U);
}

TEST(NetftClient, DropsDatagramsThatAreNoRecords) {
  Pair pair;
  pair.sensor.set_fault(SensorFault::garbled);
  EXPECT_TRUE(pair.pass(std::vector<Sample>(5, load(1, 2, 3))).empty());
  EXPECT_EQ(pair.client.health().malformed, 5U);
}

TEST(NetftClient, KnowsHowOldTheNewestRecordIs) {
  Pair pair;
  pair.now = 1.0;
  pair.pass({load(1, 2, 3)});
  pair.sensor.set_fault(SensorFault::silent);
  pair.now = 1.25;
  EXPECT_TRUE(pair.pass({load(1, 2, 3)}).empty());
  EXPECT_DOUBLE_EQ(pair.client.age(), 0.25);
}

TEST(NetftClient, SeesASensorThatIsSaturatedOrFrozen) {
  Pair pair({.noise = 0.01});
  pair.pass(std::vector<Sample>(50, load(1, 2, 3)));
  EXPECT_EQ(pair.client.health().frozen, 0);
  EXPECT_FALSE(pair.client.health().saturated);
  pair.sensor.set_fault(SensorFault::frozen);
  pair.pass(std::vector<Sample>(50, load(4, 5, 6)));
  EXPECT_EQ(pair.client.health().frozen, 50);
  pair.sensor.set_fault(SensorFault::saturated);
  pair.pass({load(1, 2, 3)});
  EXPECT_TRUE(pair.client.health().saturated);
}

TEST(NetftClient, ALoadBeyondTheCountsSaturates) {
  Pair pair;
  pair.pass({load(3000.0, 0, 0)});  // 2147 N are 2^31 counts
  EXPECT_TRUE(pair.client.health().saturated);
}

TEST(NetftClient, NamesEveryFaultOfItsOptions) {
  try {
    Client({.address = "sensor", .port = 0, .counts_per_newton = 0.0}, [] { return 0.0; });
    FAIL() << "was taken";
  } catch (const InvalidInput& error) {
    ASSERT_EQ(error.faults().size(), 3U);
    EXPECT_EQ(error.faults()[0].field, "sensor.address");
    EXPECT_EQ(error.faults()[1].field, "sensor.port");
    EXPECT_EQ(error.faults()[2].field, "sensor.counts_per_newton");
  }
}

}  // namespace
}  // namespace osteomill::io::netft
