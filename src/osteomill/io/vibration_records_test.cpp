// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/vibration_records.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "osteomill/base/error.hpp"
#include "osteomill/io/text_file.hpp"

namespace osteomill::io {
namespace {

std::filesystem::path write(const std::string& text) {
  const auto file = std::filesystem::path(testing::TempDir()) /
                    fmt::format("record-{}.csv", std::hash<std::string>{}(text));
  write_text_file(file, text);
  return file;
}

std::string message(const std::string& text, bool frf) {
  vibration::Response response{};
  try {
    if (frf) {
      read_frf(write(text));
    } else {
      read_impact_record(write(text), response);
    }
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "none";
}

TEST(VibrationRecords, ReadBlowsAndFrequencyResponses) {
  vibration::Response response{};
  const auto record = read_impact_record(
      write("time_s,force_n,displacement_um\n0,0,0\n0.0001,5,1\n0.0002,0,2.5\n"), response);
  EXPECT_EQ(response, vibration::Response::displacement);
  EXPECT_NEAR(record.sample_rate, 1e4, 1e-6);
  EXPECT_NEAR(record.response[2], 2.5e-6, 1e-18);
  read_impact_record(write("time_s,force_n,acceleration_m_per_s2\n0,0,0\n1,5,1\n"), response);
  EXPECT_EQ(response, vibration::Response::acceleration);
  const auto frf =
      read_frf(write("frequency_hz,real_um_per_n,imaginary_um_per_n\n100,1,-0.5\n200,2,-1\n"));
  EXPECT_NEAR(frf.receptance[1].real(), 2e-6, 1e-18);
  EXPECT_EQ(frf.blows, 1);
}

TEST(VibrationRecords, BadTablesAreNamed) {
  using testing::HasSubstr;
  EXPECT_THAT(message("time_s,displacement_um\n0,0\n1,1\n", false), HasSubstr("force_n"));
  EXPECT_THAT(message("time_s,force_n\n0,0\n1,1\n", false), HasSubstr("acceleration_m_per_s2"));
  EXPECT_THAT(message("time_s,force_n,displacement_um\n0,0,0\n1,x,1\n", false),
              HasSubstr("must be a number"));
  EXPECT_THAT(message("time_s,force_n,displacement_um\n0,0,0\n1,0,1\n3,0,1\n", false),
              HasSubstr("equal steps"));
  EXPECT_THAT(message("frequency_hz,real_um_per_n,imaginary_um_per_n\n2,1,1\n1,1,1\n", true),
              HasSubstr("must grow"));
}

}  // namespace
}  // namespace osteomill::io
