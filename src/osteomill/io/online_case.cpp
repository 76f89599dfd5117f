// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/online_case.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/io/case_file.hpp"
#include "osteomill/io/csv_file.hpp"
#include "osteomill/io/recording.hpp"
#include "osteomill/io/section.hpp"
#include "osteomill/io/signals_file.hpp"
#include "osteomill/io/toml_text.hpp"

namespace osteomill::io {
namespace {

using namespace identify;
using Json = nlohmann::ordered_json;

const Need kOptional = Need::optional;
/// The feed may be read beyond the fastest of the recording by this much.
constexpr double kSpare = 1.05;

struct Keys {
  std::filesystem::path recording;
  std::filesystem::path table;
  std::filesystem::path signals;
  std::string run;
  std::optional<double> start;
  std::optional<double> gain;
  CutterCase cutter;
  BoneCase bone;
  CutCase cut;
  std::optional<double> noise;
  std::optional<double> contact;
  TrackOptions options;
};

void bind_estimator(Section& s, Keys& keys) {
  TrackOptions& options = keys.options;
  OnlineOptions& online = options.online;
  s.choice<OnlineMethod>("method", options.method,
                         {{"kalman", OnlineMethod::kalman},
                          {"least-squares", OnlineMethod::least_squares},
                          {"gain-slope", OnlineMethod::gain_slope}},
                         "extended Kalman filter; recursive least squares with forgetting; the "
                         "filter of the model-adaptive controller",
                         kOptional);
  s.choice<OnlineMeasure>("measure", options.measure,
                          {{"force", OnlineMeasure::force}, {"power", OnlineMeasure::power}},
                          "what the strength is found from", kOptional);
  s.number("noise", keys.noise, {}, non_negative(),
           "standard deviation of a sample that does not grow with it, N or W; else 0.5 N, 2 W");
  s.number("relative_noise", online.relative_noise, {}, between(0.0, 1.0),
           "standard deviation that grows with the sample, as a share of it", kOptional);
  s.number("wander", online.wander, {}, non_negative(),
           "standard deviation of the strength's logarithm after a second", kOptional);
  s.number("offset_wander", online.offset_wander, {}, non_negative(),
           "standard deviation of the offset after a second, N or W", kOptional);
  s.number("jump_test", online.jump_test, {}, positive(),
           "squared innovation over its variance that is taken for other bone", kOptional);
  s.number("memory_ms", online.memory, {units::ms, "ms"}, positive(),
           "time constant of forgetting; least-squares", kOptional);
  s.number("contact", keys.contact, {}, non_negative(),
           "less than this over the offset is air, N or W; else four times the noise");
  s.number("offset_n", options.offset, {}, any(), "what the force sensor shows in air", kOptional);
  s.number("offset_deviation_n", options.offset_deviation, {}, non_negative(),
           "what is not known of it", kOptional);
}

void bind(Section& section, Keys& keys) {
  section.table("replay", "what was recorded", Need::required, [&](Section& s) {
    s.file("recording", keys.recording, "HDF5 that osteomill control --recording wrote", kOptional);
    s.file("table", keys.table,
           "CSV with time_s, feed_mm_per_s (or feed_mm_per_min), and force_n or power_w",
           kOptional);
    s.file("signals", keys.signals, "signals.h5 of osteomill simulate or control", kOptional);
    s.text("run", keys.run, "of the signals; otherwise the first", kOptional);
    s.exactly_one_of({"recording", "table", "signals"});
    s.number("start_s", keys.start, {}, any(), "samples before are left out");
  });
  section.table("online", "the estimator", kOptional, [&](Section& s) { bind_estimator(s, keys); });
  section.table("power", "the spindle's drive", kOptional, [&](Section& s) {
    PowerModel& power = keys.options.power;
    s.number("idle_w", power.idle, {}, non_negative(), "electric power in air", kOptional);
    s.number("idle_deviation_w", power.idle_deviation, {}, non_negative(),
             "what is not known of it; it is learned in air", kOptional);
    s.number("efficiency", power.efficiency, {}, between(0.01, 1.0),
             "cutting power over what the drive takes for it", kOptional);
  });
  const bool by_gain =
      section.table("reference", "in place of cutter, bone and cut", kOptional, [&](Section& s) {
        s.number("gain_n_per_mm_per_s", keys.gain, {1.0 / units::mm_per_s, "N/(mm/s)"}, positive(),
                 "force over feed of bone of strength 1");
      });
  if (section.when(!by_gain)) {
    bind_cutter(section, keys.cutter);
    bind_bone(section, keys.bone);
    bind_cut(section, keys.cut);
  }
}

double number_in(const CsvFile& table, const CsvFile::Row& row, std::size_t column) {
  const std::string& cell = row.cells[column];
  double value = 0.0;
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  if (error != std::errc{} || end != cell.data() + cell.size() || !std::isfinite(value)) {
    throw InvalidInput(Fault{table.columns[column], '"' + cell + '"', "must be a number", "",
                             fmt::format("{}:{}", table.name, row.line)});
  }
  return value;
}

struct Column {
  std::size_t index = 0;
  double factor = 1.0;
};

/// The first of the named columns that is there.
Column column_of(const CsvFile& table, const std::vector<std::pair<const char*, double>>& names) {
  std::string known;
  for (const auto& [name, factor] : names) {
    for (std::size_t i = 0; i < table.columns.size(); ++i) {
      if (table.columns[i] == name) return {i, factor};
    }
    known += (known.empty() ? "" : " or ") + std::string(name);
  }
  throw InvalidInput(Fault{"replay.table", table.name, "must have a column " + known, ""});
}

std::vector<OnlinePeriod> read_table(const Keys& keys) {
  const CsvFile table = read_csv(keys.table);
  const bool power = keys.options.measure == OnlineMeasure::power;
  const Column time = column_of(table, {{"time_s", 1.0}, {"time_ms", units::ms}});
  const Column feed = column_of(
      table, {{"feed_mm_per_s", units::mm_per_s}, {"feed_mm_per_min", units::mm_per_s / 60.0}});
  const Column measured =
      power ? column_of(table, {{"power_w", 1.0}}) : column_of(table, {{"force_n", 1.0}});
  std::vector<OnlinePeriod> periods;
  FaultList faults;
  for (const CsvFile::Row& row : table.rows) {
    faults.gather([&] {
      const auto value = [&](const Column& column) {
        return column.factor * number_in(table, row, column.index);
      };
      periods.push_back({value(time), value(feed), value(measured)});
    });
  }
  faults.raise();
  return periods;
}

/// What the drive shows for a torque: idle power, and the cutting power over the efficiency.
double drive_power(const Keys& keys, double torque) {
  return keys.options.power.idle + torque * keys.cut.spindle_speed / keys.options.power.efficiency;
}

/// Periods of a simulation: feed, and mean force or the power of the torque.
std::vector<OnlinePeriod> read_simulated(const Keys& keys) {
  const SignalsFile file = read_signals(keys.signals);
  const auto run = std::find_if(file.runs.begin(), file.runs.end(), [&](const SignalRun& one) {
    return keys.run.empty() || one.name == keys.run;
  });
  if (run == file.runs.end()) {
    throw InvalidInput(Fault{"replay.run", keys.run, "is no run of " + keys.signals.string(), ""});
  }
  const auto values = [&](const char* name) -> const std::vector<double>& {
    const auto signal = std::find_if(run->signals.begin(), run->signals.end(),
                                     [&](const Signal& one) { return one.name == name; });
    if (signal == run->signals.end()) {
      throw InvalidInput(Fault{"replay.signals", keys.signals.string(),
                               std::string("must have the signal ") + name,
                               "take the signals.h5 of osteomill simulate"});
    }
    return signal->values;
  };
  const bool power = keys.options.measure == OnlineMeasure::power;
  const std::vector<double>& time = values("time");
  const std::vector<double>& feed = values("feed");
  const std::vector<double>& measured = values(power ? "torque" : "mean_force");
  std::vector<OnlinePeriod> periods;
  for (std::size_t i = 0; i < time.size(); ++i) {
    const double seen = power ? drive_power(keys, measured[i] * units::n_mm) : measured[i];
    periods.push_back({time[i], feed[i] * units::mm_per_s, seen});
  }
  return periods;
}

/// Periods of a controller's recording. A power is what the drive would have shown: idle and the
/// recorded torque times the speed over the efficiency.
std::vector<OnlinePeriod> read_periods(const Keys& keys) {
  const bool power = keys.options.measure == OnlineMeasure::power;
  std::vector<OnlinePeriod> periods;
  double position = 0.0;
  double largest_torque = 0.0;
  for (const RecordedPeriod& recorded : read_recording(keys.recording).periods) {
    const control::Observation& seen = recorded.seen;
    OnlinePeriod period{seen.time, seen.feed, seen.mean_force};
    if (power) {
      period.measured = drive_power(keys, seen.mean_torque);
    }
    if (!periods.empty() && seen.time > periods.back().time) {
      period.feed = (seen.position - position) / (seen.time - periods.back().time);
    }
    position = seen.position;
    largest_torque = std::max(largest_torque, seen.mean_torque);
    periods.push_back(period);
  }
  if (power && largest_torque <= 0.0) {
    throw InvalidInput(Fault{"online.measure", "power", "needs a recording with torque",
                             "a line profile knows none: record on a stock, or use force"});
  }
  return periods;
}

}  // namespace

void bind_online(Section& section) {
  Keys keys;
  bind(section, keys);
}

OnlineCase read_online_case(const CaseRun& run) {
  Keys keys;
  OnlineCase result;
  result.expanded = Section::read(run, [&](Section& section) { bind(section, keys); });
  const bool power = keys.options.measure == OnlineMeasure::power;
  if (power && keys.gain) {
    throw InvalidInput(Fault{"reference.gain_n_per_mm_per_s", "", "says nothing of power",
                             "state cutter, bone and cut"});
  }
  keys.options.online.noise = keys.noise.value_or(power ? 2.0 : 0.5);
  keys.options.contact = keys.contact.value_or(4.0 * keys.options.online.noise);
  const bool table = !keys.table.empty();
  const bool simulated = !keys.signals.empty();
  result.periods =
      table ? read_table(keys) : (simulated ? read_simulated(keys) : read_periods(keys));
  if (keys.start) {
    std::erase_if(result.periods, [&](const OnlinePeriod& one) { return one.time < *keys.start; });
  }
  result.source =
      (table ? keys.table : (simulated ? keys.signals : keys.recording)).filename().string();
  result.options = keys.options;
  if (keys.gain) {
    result.response = FeedResponse(*keys.gain);
    return result;
  }
  double fastest = 0.0;
  for (const OnlinePeriod& one : result.periods) fastest = std::max(fastest, one.feed);
  if (!(fastest > 0.0)) {
    throw InvalidInput(Fault{"replay", result.source, "must hold a feed > 0", ""});
  }
  const cutting::Condition condition = condition_of(keys.cut, keys.cutter.cutter);
  result.response = FeedResponse(keys.cutter.cutter, keys.bone.law, condition, keys.cut.immersion,
                                 kSpare * fastest);
  result.warnings = caveats_of(keys.cutter, keys.bone, keys.cut.spindle_speed);
  result.bone = keys.bone;
  return result;
}

Json online_document(const OnlineCase& input, const OnlineTrack& track) {
  Json document;
  document["source"] = input.source;
  document["periods"] = track.estimates.size();
  document["periods_in_bone"] = track.periods_in_bone;
  document["jumps"] = track.jumps;
  document["strength"] = {{"median", track.median}, {"low", track.low}, {"high", track.high}};
  const OnlineEstimate& last = track.estimates.back();
  document["last"] = {{"time_s", last.time},
                      {"strength", last.strength},
                      {"standard_error", last.standard_error},
                      {"offset", last.offset}};
  Json time = Json::array(), strength = Json::array(), error = Json::array(), in = Json::array();
  Json coefficient = Json::array(), force = Json::array();
  for (std::size_t i = 0; i < track.estimates.size(); ++i) {
    const OnlineEstimate& one = track.estimates[i];
    const double feed = input.periods[i].feed;
    const FeedResponse::Answer answer = input.response.at(feed);
    time.push_back(one.time);
    strength.push_back(one.strength);
    error.push_back(one.standard_error);
    in.push_back(static_cast<bool>(track.in_bone[i]));
    force.push_back(track.in_bone[i] ? one.strength * answer.force : 0.0);
    coefficient.push_back(feed > 0.0 ? one.strength * answer.force / feed * units::mm_per_s : 0.0);
  }
  document["track"] = {{"time_s", time},
                       {"strength", strength},
                       {"standard_error", error},
                       {"in_bone", in},
                       {"predicted_force_n", force},
                       {"local_coefficient_n_per_mm_per_s", coefficient}};
  document["warnings"] = input.warnings;
  return document;
}

std::string patient_entry(const OnlineCase& input, const OnlineTrack& track) {
  if (!input.bone) {
    throw InvalidInput(Fault{"--entry", "", "needs a bone to scale",
                             "state cutter, bone and cut in place of reference"});
  }
  if (track.periods_in_bone == 0) {
    throw InvalidInput(Fault{"--entry", "", "found no bone in the recording",
                             "see online.contact and the offset"});
  }
  Json entry = input.expanded.at("bone");
  const std::string reference = entry.value("use", std::string("the bone of the case"));
  entry.erase("use");
  const double before = entry.value("strength", 1.0);
  entry["strength"] = before * track.median;
  const std::string said = fmt::format(
      "strength {:.3g} of {} (5 to 95 % of the track: {:.3g} to {:.3g}) from the {} of {}",
      track.median, reference, track.low, track.high,
      input.options.measure == OnlineMeasure::power ? "spindle power" : "force", input.source);
  Json provenance = entry.contains("provenance") ? entry["provenance"] : Json::object();
  const std::string note = provenance.value("note", std::string());
  provenance["note"] = note.empty() ? said : note + "; " + said;
  entry["provenance"] = provenance;
  entry["identification"] = {
      {"method", "online"},          {"reference", reference},
      {"strength", track.median},    {"strength_low", track.low},
      {"strength_high", track.high}, {"periods_in_bone", track.periods_in_bone}};
  return fmt::format("# {}.\n", said) + toml_text(entry);
}

}  // namespace osteomill::io
