// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/recording.hpp"

#include <array>
#include <bit>
#include <cstdint>
#include <string>

#include "osteomill/base/error.hpp"
#include "osteomill/io/hdf5_handle.hpp"

namespace osteomill::io {
namespace {

using hdf5::Handle;
using hdf5::ok;

constexpr std::array kColumns = {
    "time, s",         "sample time, s",     "position, m",   "feed, m/s",
    "programmed, m/s", "mean force, N",      "peak force, N", "mean torque, N m",
    "tooth line, N",   "revolution line, N", "to contact, m", "entering",
    "finished",        "command, m/s",       "mode",          "saturated"};
constexpr std::size_t kWidth = kColumns.size();
using Row = std::array<double, kWidth>;

Row row_of(const RecordedPeriod& period) {
  const control::Observation& seen = period.seen;
  const control::FeedCommand& command = period.command;
  return {seen.time,
          seen.sample_time,
          seen.position,
          seen.feed,
          seen.programmed_feed,
          seen.mean_force,
          seen.peak_force,
          seen.mean_torque,
          seen.tooth_line,
          seen.revolution_line,
          seen.to_contact,
          seen.entering ? 1.0 : 0.0,
          seen.finished ? 1.0 : 0.0,
          command.feed,
          static_cast<double>(command.mode),
          command.saturated ? 1.0 : 0.0};
}

RecordedPeriod period_of(const double* row) {
  RecordedPeriod period;
  control::Observation& seen = period.seen;
  seen.time = row[0];
  seen.sample_time = row[1];
  seen.position = row[2];
  seen.feed = row[3];
  seen.programmed_feed = row[4];
  seen.mean_force = row[5];
  seen.peak_force = row[6];
  seen.mean_torque = row[7];
  seen.tooth_line = row[8];
  seen.revolution_line = row[9];
  seen.to_contact = row[10];
  seen.entering = row[11] != 0.0;
  seen.finished = row[12] != 0.0;
  period.command = {row[13], static_cast<control::Mode>(static_cast<int>(row[14])), row[15] != 0.0};
  return period;
}

Handle make_file(const std::filesystem::path& file) {
  const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose, "access");
  // What a single writer and many readers need.
  ok(H5Pset_libver_bounds(access, H5F_LIBVER_LATEST, H5F_LIBVER_LATEST), "format");
  return {H5Fcreate(file.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access), H5Fclose, "create"};
}

Handle make_periods(hid_t file) {
  const std::array<hsize_t, 2> none = {0, kWidth};
  const std::array<hsize_t, 2> most = {H5S_UNLIMITED, kWidth};
  const std::array<hsize_t, 2> chunk = {Recorder::kBlock * 10, kWidth};
  const Handle space(H5Screate_simple(2, none.data(), most.data()), H5Sclose, "space");
  const Handle settings(H5Pcreate(H5P_DATASET_CREATE), H5Pclose, "settings");
  ok(H5Pset_chunk(settings, 2, chunk.data()), "chunk");
  Handle periods(
      H5Dcreate2(file, "periods", H5T_IEEE_F64LE, space, H5P_DEFAULT, settings, H5P_DEFAULT),
      H5Dclose, "periods");
  const Handle text(H5Tcopy(H5T_C_S1), H5Tclose, "text");
  ok(H5Tset_size(text, H5T_VARIABLE), "text");
  const hsize_t width = kWidth;
  const Handle names(H5Screate_simple(1, &width, nullptr), H5Sclose, "names");
  const Handle columns(H5Acreate2(periods, "columns", text, names, H5P_DEFAULT, H5P_DEFAULT),
                       H5Aclose, "columns");
  ok(H5Awrite(columns, text, kColumns.data()), "columns");
  return periods;
}

}  // namespace

struct Recorder::File {
  explicit File(const std::filesystem::path& name)
      : file(make_file(name)), periods(make_periods(file)) {
    ok(H5Fstart_swmr_write(file), "single writer");
  }
  Handle file;
  Handle periods;
  hsize_t written = 0;
};

Recorder::Recorder(const std::filesystem::path& file) {
  const hdf5::Quiet quiet;
  try {
    file_ = std::make_unique<File>(file);
  } catch (const hdf5::Failure& failure) {
    throw WorldError("cannot write the recording " + file.string() + " (" + failure.what() +
                     "); check the folder");
  }
  block_.reserve(kBlock * kWidth);
}

Recorder::~Recorder() {
  try {
    flush();
  } catch (const WorldError&) {
    // The disk refused the last block; what was flushed before stands.
    block_.clear();
  }
}

void Recorder::add(const RecordedPeriod& period) {
  const Row row = row_of(period);
  block_.insert(block_.end(), row.begin(), row.end());
  if (block_.size() >= kBlock * kWidth) flush();
}

void Recorder::flush() {
  if (block_.empty()) return;
  const hdf5::Quiet quiet;
  try {
    const hsize_t rows = block_.size() / kWidth;
    const std::array<hsize_t, 2> size = {file_->written + rows, kWidth};
    const std::array<hsize_t, 2> start = {file_->written, 0};
    const std::array<hsize_t, 2> count = {rows, kWidth};
    ok(H5Dset_extent(file_->periods, size.data()), "extend");
    const Handle space(H5Dget_space(file_->periods), H5Sclose, "space");
    ok(H5Sselect_hyperslab(space, H5S_SELECT_SET, start.data(), nullptr, count.data(), nullptr),
       "select");
    const Handle memory(H5Screate_simple(2, count.data(), nullptr), H5Sclose, "memory");
    ok(H5Dwrite(file_->periods, H5T_NATIVE_DOUBLE, memory, space, H5P_DEFAULT, block_.data()),
       "write");
    ok(H5Dflush(file_->periods), "flush");
    file_->written += rows;
  } catch (const hdf5::Failure& failure) {
    throw WorldError(std::string("the recording cannot be written on (") + failure.what() +
                     "); is the disk full?");
  }
  block_.clear();
}

std::vector<RecordedPeriod> read_recording(const std::filesystem::path& file) {
  const hdf5::Quiet quiet;
  try {
    const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose, "access");
    ok(H5Pset_libver_bounds(access, H5F_LIBVER_LATEST, H5F_LIBVER_LATEST), "format");
    // As a reader beside a writer: so a file whose writer was killed opens, too.
    const Handle opened(H5Fopen(file.c_str(), H5F_ACC_RDONLY | H5F_ACC_SWMR_READ, access), H5Fclose,
                        "open");
    const Handle periods(H5Dopen2(opened, "periods", H5P_DEFAULT), H5Dclose, "periods");
    const Handle space(H5Dget_space(periods), H5Sclose, "space");
    std::array<hsize_t, 2> size{};
    if (H5Sget_simple_extent_ndims(space) != 2) throw hdf5::Failure("periods is no table");
    ok(H5Sget_simple_extent_dims(space, size.data(), nullptr), "size");
    if (size[1] != kWidth) throw hdf5::Failure("periods has other columns");
    std::vector<double> values(size[0] * kWidth);
    if (!values.empty()) {
      ok(H5Dread(periods, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()), "read");
    }
    std::vector<RecordedPeriod> recording;
    for (std::size_t row = 0; row < size[0]; ++row) {
      recording.push_back(period_of(&values[row * kWidth]));
    }
    return recording;
  } catch (const hdf5::Failure& failure) {
    throw InvalidInput(Fault{file.string(), "",
                             std::string("is no recording (") + failure.what() + ")",
                             "name a file that osteomill control --recording wrote"});
  }
}

Replay replay(const std::vector<RecordedPeriod>& recording,
              const control::FeedController& controller, double first_feed) {
  Replay result;
  control::ControllerState state;
  state.feed = first_feed;
  for (const RecordedPeriod& period : recording) {
    if (period.command.mode == control::Mode::stopped) continue;
    const control::ControlStep next = control::step(controller, state, period.seen);
    state = next.state;
    const bool same = std::bit_cast<std::uint64_t>(next.command.feed) ==
                          std::bit_cast<std::uint64_t>(period.command.feed) &&
                      next.command.mode == period.command.mode &&
                      next.command.saturated == period.command.saturated;
    if (!same && result.different++ == 0) result.first_difference = result.periods;
    ++result.periods;
  }
  return result;
}

}  // namespace osteomill::io
