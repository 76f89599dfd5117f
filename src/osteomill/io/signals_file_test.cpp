// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/signals_file.hpp"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <cmath>
#include <csignal>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/io/scratch_folder.hpp"
#include "osteomill/io/text_file.hpp"

namespace osteomill::io {
namespace {

namespace fs = std::filesystem;

SignalsFile two_runs() {
  SignalsFile file;
  file.attributes = {{"program", std::string("osteomill")}, {"seed", std::int64_t{42}}};
  SignalRun run;
  run.name = "adaptive";
  run.attributes = {{"limit_n", 20.0}};
  Signal time{"time", "s", {}, "since the start"};
  Signal force{"force", "N", {}, ""};
  for (int i = 0; i < 100000; ++i) {
    time.values.push_back(i * 1e-4);
    force.values.push_back(std::sin(i * 0.01) * 1e-3 + i);
  }
  run.signals = {force, time};
  run.events = {{0.5, "contact"}, {1.25, "größte Kraft"}};
  geometry::GridShape shape;
  shape.size = {3, 4, 5};
  shape.spacing = geometry::Vector3(0.2, 0.25, 0.5) * units::mm;
  shape.origin = geometry::Vector3(-1.0, 2.0, 3.0) * units::mm;
  geometry::VoxelGrid<float> density(shape);
  for (std::size_t i = 0; i < shape.count(); ++i)
    density.values()[i] = 0.1F * static_cast<float>(i);
  run.grids = {{"density", "g/cm³", density, "what is left"}};
  file.runs.push_back(run);
  file.runs.push_back({"empty", {{"time", "s", {}}}});
  return file;
}

TEST(SignalsFile, ComesBackToTheLastBit) {
  const fs::path path = scratch("signals.h5");
  const SignalsFile written = two_runs();
  write_signals(written, path);
  const SignalsFile read = read_signals(path);
  EXPECT_EQ(read.attributes, written.attributes);
  ASSERT_EQ(read.runs.size(), 2u);
  const SignalRun& run = read.runs[0];
  EXPECT_EQ(run.name, "adaptive");
  EXPECT_EQ(run.attributes, written.runs[0].attributes);
  ASSERT_EQ(run.signals.size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(run.signals[i].name, written.runs[0].signals[i].name);
    EXPECT_EQ(run.signals[i].unit, written.runs[0].signals[i].unit);
    EXPECT_EQ(run.signals[i].about, written.runs[0].signals[i].about);
    EXPECT_EQ(run.signals[i].values, written.runs[0].signals[i].values);
  }
  ASSERT_EQ(run.events.size(), 2u);
  EXPECT_EQ(run.events[1].text, "größte Kraft");
  EXPECT_EQ(run.events[1].time_s, 1.25);
  ASSERT_EQ(run.grids.size(), 1u);
  EXPECT_EQ(run.grids[0].values.values(), written.runs[0].grids[0].values.values());
  EXPECT_EQ(run.grids[0].values.shape().size, (std::array<int, 3>{3, 4, 5}));
  // mm and back: two roundings of 1e-3 in double precision.
  EXPECT_NEAR(run.grids[0].values.shape().origin.z(), 3e-3, 1e-17);
  EXPECT_TRUE(read.runs[1].signals.at(0).values.empty());
}

TEST(SignalsFile, SameContentsGiveTheSameBytes) {
  write_signals(two_runs(), scratch("one.h5"));
  write_signals(two_runs(), scratch("two.h5"));
  EXPECT_TRUE(read_text_file(scratch("one.h5")) == read_text_file(scratch("two.h5")));
}

TEST(SignalsFile, AFullDiskLeavesTheFormerFileAndNothingElse) {
  const fs::path folder = scratch("full");
  fs::create_directories(folder);
  const fs::path path = folder / "signals.h5";
  write_signals({}, path);
  const std::string before = read_text_file(path);

  // A limit on the length of files fails like a disk that is full.
  rlimit former{};
  getrlimit(RLIMIT_FSIZE, &former);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  rlimit tight = former;
  tight.rlim_cur = 20000;
  setrlimit(RLIMIT_FSIZE, &tight);
  EXPECT_THROW(write_signals(two_runs(), path), WorldError);
  setrlimit(RLIMIT_FSIZE, &former);
  std::signal(SIGXFSZ, handler);

  EXPECT_TRUE(read_text_file(path) == before);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder), fs::directory_iterator()), 1);
}

TEST(SignalsFile, RefusesNamesThatItCannotKeepApart) {
  SignalsFile slash;
  slash.runs = {{"a/b", {}}};
  SignalsFile twice;
  twice.runs = {{"a", {{"force", "N", {1.0}}, {"force", "N", {2.0}}}}};
  SignalsFile reserved;
  reserved.runs = {{"a", {{"events", "1", {1.0}}}}};
  for (const SignalsFile& file : {slash, twice, reserved})
    EXPECT_THROW(write_signals(file, scratch("names.h5")), InvalidInput);
  EXPECT_FALSE(fs::exists(scratch("names.h5")));
}

TEST(SignalsFile, RefusesWhatIsNoSignalsFile) {
  EXPECT_THROW(read_signals(scratch("absent.h5")), InvalidInput);
  write_text_file(scratch("text.h5"), "not HDF5");
  EXPECT_THROW(read_signals(scratch("text.h5")), InvalidInput);
  write_signals(two_runs(), scratch("whole.h5"));
  const std::string bytes = read_text_file(scratch("whole.h5"));
  for (const double share : {0.1, 0.5, 0.9}) {
    write_text_file(
        scratch("cut.h5"),
        bytes.substr(0, static_cast<std::size_t>(share * static_cast<double>(bytes.size()))));
    EXPECT_THROW(read_signals(scratch("cut.h5")), InvalidInput) << share;
  }
}

}  // namespace
}  // namespace osteomill::io
