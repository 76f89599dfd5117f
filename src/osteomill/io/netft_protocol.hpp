// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

/// Raw Data Transfer (RDT), the UDP protocol of ATI's Net F/T force/torque sensors: one request of
/// 8 bytes to the sensor, one record of 36 bytes in each datagram back. All numbers are big-endian.
namespace osteomill::io::netft {

inline constexpr int kPort = 49152;
inline constexpr std::uint16_t kRequestHeader = 0x1234;
inline constexpr std::size_t kRequestBytes = 8;
inline constexpr std::size_t kRecordBytes = 36;

enum class Command : std::uint16_t {
  stop = 0x0000,   ///< stop streaming
  start = 0x0002,  ///< stream at the sensor's RDT rate, one record a datagram
  bias = 0x0042    ///< take the present load for zero
};

struct Request {
  Command command = Command::stop;
  std::uint32_t sample_count = 0;  ///< records to send; 0: until told to stop
};

struct Record {
  std::uint32_t rdt_sequence = 0;        ///< of the record since the stream began, from 1
  std::uint32_t ft_sequence = 0;         ///< of the measurement within the sensor
  std::uint32_t status = 0;              ///< 0: healthy
  std::array<std::int32_t, 6> counts{};  ///< Fx Fy Fz Tx Ty Tz in counts
};

std::array<std::uint8_t, kRequestBytes> encode(const Request& request);
std::array<std::uint8_t, kRecordBytes> encode(const Record& record);
/// None when the bytes are no request, or ask for something that this project does not use.
std::optional<Request> decode_request(std::span<const std::uint8_t> bytes);
/// None when the length is another one.
std::optional<Record> decode_record(std::span<const std::uint8_t> bytes);

/// Bits of the system status code that mean something to us.
inline constexpr std::uint32_t kStatusError = 0x80000000U;      ///< summary of the others
inline constexpr std::uint32_t kStatusSaturated = 0x00020000U;  ///< transducer or A/D converter
inline constexpr std::uint32_t kStatusMonitor = 0x00010000U;    ///< a user's threshold was passed

/// The load is beyond what the transducer can measure.
bool saturated(std::uint32_t status);
/// The numbers cannot be trusted: any bit but the user's own threshold.
bool faulty(std::uint32_t status);
/// "healthy", or the bits in words.
std::string describe_status(std::uint32_t status);

}  // namespace osteomill::io::netft
