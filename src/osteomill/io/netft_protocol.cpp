// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/netft_protocol.hpp"

#include <boost/endian/conversion.hpp>
#include <utility>

namespace osteomill::io::netft {
namespace {

using boost::endian::load_big_u16;
using boost::endian::load_big_u32;
using boost::endian::store_big_u16;
using boost::endian::store_big_u32;

constexpr std::array<std::pair<std::uint32_t, const char*>, 13> kBits = {{
    {0x40000000U, "CPU or RAM error"},
    {0x20000000U, "digital board error"},
    {0x10000000U, "analog board error"},
    {0x08000000U, "serial link to the transducer broken"},
    {0x04000000U, "program memory error"},
    {0x02000000U, "halted by configuration errors"},
    {0x01000000U, "settings are invalid"},
    {0x00800000U, "configuration does not fit the calibration"},
    {0x00400000U, "network failure"},
    {0x00100000U, "RDT communication error"},
    {kStatusSaturated, "transducer saturated or A/D converter out of range"},
    {kStatusMonitor, "a threshold of the user was passed"},
    {0x00000010U, "no data from the transducer"},
}};

}  // namespace

std::array<std::uint8_t, kRequestBytes> encode(const Request& request) {
  std::array<std::uint8_t, kRequestBytes> bytes{};
  store_big_u16(&bytes[0], kRequestHeader);
  store_big_u16(&bytes[2], static_cast<std::uint16_t>(request.command));
  store_big_u32(&bytes[4], request.sample_count);
  return bytes;
}

std::array<std::uint8_t, kRecordBytes> encode(const Record& record) {
  std::array<std::uint8_t, kRecordBytes> bytes{};
  store_big_u32(&bytes[0], record.rdt_sequence);
  store_big_u32(&bytes[4], record.ft_sequence);
  store_big_u32(&bytes[8], record.status);
  for (std::size_t i = 0; i < record.counts.size(); ++i) {
    store_big_u32(&bytes[12 + 4 * i], static_cast<std::uint32_t>(record.counts[i]));
  }
  return bytes;
}

std::optional<Request> decode_request(std::span<const std::uint8_t> bytes) {
  if (bytes.size() != kRequestBytes || load_big_u16(&bytes[0]) != kRequestHeader) return {};
  const auto command = static_cast<Command>(load_big_u16(&bytes[2]));
  if (command != Command::stop && command != Command::start && command != Command::bias) return {};
  return Request{command, load_big_u32(&bytes[4])};
}

std::optional<Record> decode_record(std::span<const std::uint8_t> bytes) {
  if (bytes.size() != kRecordBytes) return {};
  Record record;
  record.rdt_sequence = load_big_u32(&bytes[0]);
  record.ft_sequence = load_big_u32(&bytes[4]);
  record.status = load_big_u32(&bytes[8]);
  for (std::size_t i = 0; i < record.counts.size(); ++i) {
    record.counts[i] = static_cast<std::int32_t>(load_big_u32(&bytes[12 + 4 * i]));
  }
  return record;
}

bool saturated(std::uint32_t status) { return (status & kStatusSaturated) != 0; }

bool faulty(std::uint32_t status) { return (status & ~(kStatusError | kStatusMonitor)) != 0; }

std::string describe_status(std::uint32_t status) {
  std::string words;
  std::uint32_t named = kStatusError;
  for (const auto& [bit, word] : kBits) {
    named |= bit;
    if ((status & bit) == 0) continue;
    words += (words.empty() ? "" : ", ") + std::string(word);
  }
  if ((status & ~named) != 0) words += std::string(words.empty() ? "" : ", ") + "other errors";
  if (words.empty()) words = status == 0 ? "healthy" : "error without a reason";
  return words;
}

}  // namespace osteomill::io::netft
