// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/recording.hpp"

#include <array>
#include <atomic>
#include <bit>
#include <boost/lockfree/spsc_queue.hpp>
#include <chrono>
#include <cstdint>
#include <string>
#include <thread>

#include "osteomill/base/error.hpp"
#include "osteomill/io/hdf5_handle.hpp"

namespace osteomill::io {
namespace {

using hdf5::Handle;
using hdf5::ok;
using namespace std::chrono_literals;

constexpr auto kLook = 20ms;         // between two looks of the writer
constexpr auto kFlush = 100ms;       // between two blocks
constexpr std::size_t kChunk = 256;  // rows

constexpr std::array kPeriodColumns = {"time, s",
                                       "sample time, s",
                                       "position, m",
                                       "feed, m/s",
                                       "programmed, m/s",
                                       "mean force, N",
                                       "peak force, N",
                                       "mean torque, N m",
                                       "tooth line, N",
                                       "revolution line, N",
                                       "to contact, m",
                                       "to engagement, m",
                                       "finished",
                                       "command, m/s",
                                       "mode",
                                       "saturated",
                                       "spindle speed, rad/s",
                                       "temperature, K",
                                       "spindle command, rad/s",
                                       "rapid"};
constexpr std::array kSampleColumns = {"number",       "force x, N",    "force y, N",
                                       "force z, N",   "torque x, N m", "torque y, N m",
                                       "torque z, N m"};
constexpr std::array kEventColumns = {"time, s", "cause", "value, SI", "limit, SI"};

using Row = std::array<double, kPeriodColumns.size()>;
using SampleRow = std::array<double, kSampleColumns.size()>;
using EventRow = std::array<double, kEventColumns.size()>;

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
          seen.to_engagement,
          seen.finished ? 1.0 : 0.0,
          command.feed,
          static_cast<double>(command.mode),
          command.saturated ? 1.0 : 0.0,
          seen.spindle_speed,
          seen.temperature,
          command.spindle_speed,
          seen.rapid ? 1.0 : 0.0};
}

SampleRow row_of(const netft::Sample& sample) {
  const auto& [force_S, torque_S, number] = sample;
  return {static_cast<double>(number),
          force_S.x(),
          force_S.y(),
          force_S.z(),
          torque_S.x(),
          torque_S.y(),
          torque_S.z()};
}

EventRow row_of(const control::LoopEvent& event) {
  return {event.time, static_cast<double>(event.cause), event.value, event.limit};
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
  seen.to_engagement = row[11];
  seen.finished = row[12] != 0.0;
  period.command = {row[13], static_cast<control::Mode>(static_cast<int>(row[14])), row[15] != 0.0,
                    row[18]};
  seen.spindle_speed = row[16];
  seen.temperature = row[17];
  seen.rapid = row[19] != 0.0;
  return period;
}

netft::Sample sample_of(const double* row) {
  return {{row[1], row[2], row[3]}, {row[4], row[5], row[6]}, static_cast<std::uint32_t>(row[0])};
}

control::LoopEvent event_of(const double* row) {
  return {row[0], static_cast<control::Cause>(static_cast<int>(row[1])), row[2], row[3]};
}

Handle make_file(const std::filesystem::path& file) {
  const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose, "access");
  // What a single writer and many readers need.
  ok(H5Pset_libver_bounds(access, H5F_LIBVER_LATEST, H5F_LIBVER_LATEST), "format");
  return {H5Fcreate(file.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access), H5Fclose, "create"};
}

/// One table of the file and the way to it: whole rows in a ring without locks, one thread in, the
/// writer out.
class Track {
 public:
  Track(hid_t file, const char* name, std::span<const char* const> columns, std::size_t rows)
      : width_(columns.size()),
        ring_(rows * columns.size()),
        table_(make_table(file, name, columns)) {
    rows_.resize(rows * columns.size());
  }

  /// False when there is no place.
  bool offer(std::span<const double> row) noexcept {
    return ring_.write_available() >= row.size() &&
           ring_.push(row.data(), row.size()) == row.size();
  }
  /// Takes what waits to the file; says whether there was anything.
  bool write() {
    const std::size_t whole = ring_.read_available() / width_ * width_;
    if (whole == 0) return false;
    ring_.pop(rows_.data(), whole);
    const hsize_t rows = whole / width_;
    const std::array<hsize_t, 2> size = {written_ + rows, width_};
    const std::array<hsize_t, 2> start = {written_, 0};
    const std::array<hsize_t, 2> count = {rows, width_};
    ok(H5Dset_extent(table_, size.data()), "extend");
    const Handle space(H5Dget_space(table_), H5Sclose, "space");
    ok(H5Sselect_hyperslab(space, H5S_SELECT_SET, start.data(), nullptr, count.data(), nullptr),
       "select");
    const Handle memory(H5Screate_simple(2, count.data(), nullptr), H5Sclose, "memory");
    ok(H5Dwrite(table_, H5T_NATIVE_DOUBLE, memory, space, H5P_DEFAULT, rows_.data()), "write");
    ok(H5Dflush(table_), "flush");
    written_ += rows;
    return true;
  }

 private:
  static Handle make_table(hid_t file, const char* name, std::span<const char* const> columns) {
    const hsize_t width = columns.size();
    const std::array<hsize_t, 2> none = {0, width};
    const std::array<hsize_t, 2> most = {H5S_UNLIMITED, width};
    const std::array<hsize_t, 2> chunk = {kChunk, width};
    const Handle space(H5Screate_simple(2, none.data(), most.data()), H5Sclose, "space");
    const Handle settings(H5Pcreate(H5P_DATASET_CREATE), H5Pclose, "settings");
    ok(H5Pset_chunk(settings, 2, chunk.data()), "chunk");
    Handle table(H5Dcreate2(file, name, H5T_IEEE_F64LE, space, H5P_DEFAULT, settings, H5P_DEFAULT),
                 H5Dclose, name);
    const Handle text(H5Tcopy(H5T_C_S1), H5Tclose, "text");
    ok(H5Tset_size(text, H5T_VARIABLE), "text");
    const Handle names(H5Screate_simple(1, &width, nullptr), H5Sclose, "names");
    const Handle attribute(H5Acreate2(table, "columns", text, names, H5P_DEFAULT, H5P_DEFAULT),
                           H5Aclose, "columns");
    ok(H5Awrite(attribute, text, columns.data()), "columns");
    return table;
  }

  std::size_t width_;
  boost::lockfree::spsc_queue<double> ring_;
  std::vector<double> rows_;  ///< on the way to the file
  Handle table_;
  hsize_t written_ = 0;
};

/// Rows of a table, one after the other.
template <class Row_, class Make>
std::vector<Row_> read_table(hid_t file, const char* name, std::size_t width, Make make) {
  const Handle table(H5Dopen2(file, name, H5P_DEFAULT), H5Dclose, name);
  const Handle space(H5Dget_space(table), H5Sclose, "space");
  std::array<hsize_t, 2> size{};
  const std::string called(name);
  if (H5Sget_simple_extent_ndims(space) != 2) throw hdf5::Failure(called + " is no table");
  ok(H5Sget_simple_extent_dims(space, size.data(), nullptr), "size");
  if (size[1] != width) throw hdf5::Failure(called + " has other columns");
  std::vector<double> values(size[0] * width);
  if (!values.empty()) {
    ok(H5Dread(table, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()), "read");
  }
  std::vector<Row_> rows;
  rows.reserve(size[0]);
  for (std::size_t row = 0; row < size[0]; ++row) rows.push_back(make(&values[row * width]));
  return rows;
}

}  // namespace

struct Recorder::File {
  // Room for 2 s of samples at 8 kHz, 80 s of periods at 100 Hz.
  File(const std::filesystem::path& name, const RecorderOptions& how)
      : options(how),
        file(make_file(name)),
        periods(file, "periods", kPeriodColumns, 8192),
        samples(file, "samples", kSampleColumns, 16384),
        events(file, "events", kEventColumns, 256) {
    ok(H5Fstart_swmr_write(file), "single writer");
    writer = std::thread([this] { work(); });
  }
  ~File() { end(); }

  void end() {
    over = true;
    if (writer.joinable()) writer.join();
  }

  void work() {
    const hdf5::Quiet quiet;
    auto next = std::chrono::steady_clock::now();
    try {
      while (!over) {
        std::this_thread::sleep_for(kLook);
        if (!hurry.exchange(false) && std::chrono::steady_clock::now() < next) continue;
        next = std::chrono::steady_clock::now() + kFlush;
        write();
      }
      write();
    } catch (const hdf5::Failure& failure) {
      reason = failure.what();
      failed = true;
    }
  }
  void write() {
    periods.write();
    samples.write();
    events.write();
  }

  /// Every row finds its place, or is counted.
  void put(Track& track, std::span<const double> row) noexcept {
    while (!track.offer(row)) {
      if (options.real_time || failed) {
        ++dropped;
        return;
      }
      hurry = true;
      std::this_thread::sleep_for(1ms);
    }
  }

  RecorderOptions options;
  Handle file;
  Track periods, samples, events;
  std::atomic<bool> over{false};
  std::atomic<bool> hurry{false};   ///< somebody waits for room
  std::atomic<bool> failed{false};  ///< the disk refused; `reason` is written before
  std::atomic<std::uint64_t> dropped{0};
  std::string reason;
  std::thread writer;  ///< the file is its alone while it runs
};

Recorder::Recorder(const std::filesystem::path& file, const RecorderOptions& options) {
  const hdf5::Quiet quiet;
  try {
    file_ = std::make_unique<File>(file, options);
  } catch (const hdf5::Failure& failure) {
    throw WorldError("cannot write the recording " + file.string() + " (" + failure.what() +
                     "); check the folder");
  }
}

Recorder::~Recorder() = default;

void Recorder::add(const RecordedPeriod& period) noexcept {
  file_->put(file_->periods, row_of(period));
}

void Recorder::add(std::span<const netft::Sample> samples) noexcept {
  for (const netft::Sample& sample : samples) file_->put(file_->samples, row_of(sample));
}

void Recorder::add(const control::LoopEvent& event) noexcept {
  file_->put(file_->events, row_of(event));
}

void Recorder::finish() {
  file_->end();
  if (file_->failed) {
    throw WorldError("the recording cannot be written on (" + file_->reason +
                     "); is the disk full?");
  }
}

std::uint64_t Recorder::dropped() const noexcept { return file_->dropped; }

Recording read_recording(const std::filesystem::path& file) {
  const hdf5::Quiet quiet;
  try {
    const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose, "access");
    ok(H5Pset_libver_bounds(access, H5F_LIBVER_LATEST, H5F_LIBVER_LATEST), "format");
    // As a reader beside a writer: so a file whose writer was killed opens, too.
    const Handle opened(H5Fopen(file.c_str(), H5F_ACC_RDONLY | H5F_ACC_SWMR_READ, access), H5Fclose,
                        "open");
    Recording recording;
    recording.periods =
        read_table<RecordedPeriod>(opened, "periods", kPeriodColumns.size(), period_of);
    recording.samples =
        read_table<netft::Sample>(opened, "samples", kSampleColumns.size(), sample_of);
    recording.events =
        read_table<control::LoopEvent>(opened, "events", kEventColumns.size(), event_of);
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
                      std::bit_cast<std::uint64_t>(next.command.spindle_speed) ==
                          std::bit_cast<std::uint64_t>(period.command.spindle_speed) &&
                      next.command.mode == period.command.mode &&
                      next.command.saturated == period.command.saturated;
    if (!same && result.different++ == 0) result.first_difference = result.periods;
    ++result.periods;
  }
  return result;
}

}  // namespace osteomill::io
