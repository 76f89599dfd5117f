// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/force_record_file.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <matio.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "osteomill/base/error.hpp"
#include "osteomill/io/scratch_folder.hpp"
#include "osteomill/io/signals_file.hpp"
#include "osteomill/io/text_file.hpp"

namespace osteomill::io {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr double kRate = 2000.0;
constexpr int kSamples = 200;

double force(int axis, int sample) {
  return (axis + 1) * std::sin(0.1 * sample + axis) + 0.01 * (sample % 7);
}

class ForceRecordFile : public ::testing::Test {
 protected:
  std::filesystem::path put(const std::string& name, const std::string& text) {
    write_text_file(scratch() / name, text);
    return scratch() / name;
  }
  /// What is wrong, as the user reads it; empty when nothing is.
  static std::string fault_of(const std::filesystem::path& file, const RecordFormat& format = {}) {
    try {
      read_force_record(file, format);
    } catch (const InvalidInput& error) {
      return error.what();
    }
    return "";
  }
};

/// Rows of time and force by a separator; `change` may alter the cells of a row.
std::string rows(char separator, bool decimal_comma = false,
                 const std::function<void(int, std::vector<std::string>&)>& change = {}) {
  std::string out;
  for (int i = 0; i < kSamples; ++i) {
    std::vector<std::string> cells{fmt::format("{:.6f}", i / kRate)};
    for (int axis = 0; axis < 3; ++axis) cells.push_back(fmt::format("{:.6f}", force(axis, i)));
    if (change) change(i, cells);
    std::string line;
    for (const std::string& cell : cells)
      line += (line.empty() ? "" : std::string(1, separator)) + cell;
    if (decimal_comma) std::replace(line.begin(), line.end(), '.', ',');
    out += line + "\n";
  }
  return out;
}

void expect_forces(const LoadedRecord& loaded, double factor = 1.0, double tolerance = 1e-6) {
  ASSERT_EQ(loaded.record.force.rows(), kSamples);
  EXPECT_NEAR(loaded.record.rate, kRate, 1e-6);
  for (int i = 0; i < kSamples; ++i) {
    for (int axis = 0; axis < 3; ++axis)
      ASSERT_NEAR(loaded.record.force(i, axis), factor * force(axis, i), factor * tolerance);
  }
}

TEST_F(ForceRecordFile, ReadsTextWithAnySeparatorAndHeader) {
  struct Text {
    const char* what;
    std::string text;
    double factor;
  };
  for (const Text& one : {
           Text{"comma", "time_s,force_x_n,force_y_n,force_z_n\n" + rows(','), 1.0},
           {"semicolon and decimal comma", "t [s];Fx [N];Fy [N];Fz [N]\n" + rows(';', true), 1.0},
           {"tabs and a line of units", "Time\tFx\tFy\tFz\ns\tkN\tkN\tkN\n" + rows('\t'), 1e3},
           {"spaces", "# time_s Fx_N Fy_N Fz_N\n" + rows(' '), 1.0},
           {"spaces and decimal comma", "time Fx Fy Fz\ns N N N\n" + rows(' ', true), 1.0},
           {"header lines",
            "Operator: X, 3 cuts\nDate;2024\n\n\nTime (ms),Fx (lbf),Fy (lbf),Fz (lbf)\n" +
                rows(',', false,
                     [](int i, auto& cells) { cells[0] = fmt::format("{:.3f}", i * 0.5); }),
            4.4482216152605},
           {"line ends of Windows",
            "time_s,Fx / N,Fy / N,Fz / N\r\n" +
                rows(',', false, [](int, auto& cells) { cells[3] += "\r"; }),
            1.0},
           {"a byte order mark and quotes",
            "\xEF\xBB\xBF\"time_s\",\"Fx [N]\",\"Fy [N]\",\"Fz [N]\"\n" + rows(','), 1.0},
       }) {
    SCOPED_TRACE(one.what);
    const LoadedRecord loaded = read_force_record(put("record.csv", one.text));
    expect_forces(loaded, one.factor);
    EXPECT_THAT(loaded.warnings, IsEmpty());
  }
}

TEST_F(ForceRecordFile, TheCaseMaySayWhatTheFileDoesNot) {
  RecordFormat format;
  format.columns = {"2", "3", "4"};
  format.time = "1";
  format.unit = "mV";
  format.sensitivity_mv_per_n = {2.0, 4.0, 8.0};
  const LoadedRecord loaded = read_force_record(put("bare.txt", rows(',')), format);
  EXPECT_NEAR(loaded.record.force(50, 0), force(0, 50) / 2.0, 1e-6);
  EXPECT_NEAR(loaded.record.force(50, 2), force(2, 50) / 8.0, 1e-6);

  format.time = "none";
  format.rate = 500.0;
  EXPECT_EQ(read_force_record(put("bare.txt", rows(',')), format).record.rate, 500.0);
}

TEST_F(ForceRecordFile, AxesSignsTareAndWeightAreTakenToTheTool) {
  RecordFormat format;
  format.axes = {"y", "-x", "z"};
  format.on_workpiece = true;
  format.tare = {1.0, 2.0, 3.0};
  format.mass = 0.5;
  format.down = {0.0, 0.0, -2.0};
  const auto file = put("r.csv", "time_s,Fx_N,Fy_N,Fz_N\n" + rows(','));
  const LoadedRecord loaded = read_force_record(file, format);
  for (const int i : {0, 77, 199}) {
    EXPECT_NEAR(loaded.record.force(i, 0), -(force(1, i) - 2.0), 1e-6);
    EXPECT_NEAR(loaded.record.force(i, 1), force(0, i) - 1.0, 1e-6);
    EXPECT_NEAR(loaded.record.force(i, 2), -(force(2, i) - 3.0 + 0.5 * 9.80665), 1e-6);
  }
}

TEST_F(ForceRecordFile, TheWeightTurnsWithTheSensor) {
  const double weight = 0.8 * 9.80665;
  const auto turning = rows(',', false, [&](int i, auto& cells) {
    const double angle = 0.02 * i;
    cells[1] = fmt::format("{:.9f}", force(0, i) + weight * std::cos(angle));
    cells[2] = fmt::format("{:.9f}", force(1, i) - weight * std::sin(angle));
    cells.push_back(fmt::format("{:.9f}", angle * 180.0 / std::numbers::pi));
  });
  RecordFormat format;
  format.mass = 0.8;
  format.down = {1.0, 0.0, 0.0};
  format.turning = "wrist";
  expect_forces(
      read_force_record(put("turning.csv", "time_s,Fx_N,Fy_N,Fz_N,wrist_deg\n" + turning), format));
}

TEST_F(ForceRecordFile, ReadsPulseAndTorque) {
  const auto text = rows(',', false, [](int i, auto& cells) {
    cells.push_back(i % 20 == 0 ? "5" : "0");
    cells.push_back(std::to_string(i));
  });
  const LoadedRecord loaded =
      read_force_record(put("r.csv", "time_s,Fx_N,Fy_N,Fz_N,Tacho [V],Mz [Nmm]\n" + text));
  EXPECT_EQ(loaded.record.tacho[40], 5.0);
  EXPECT_NEAR(loaded.record.torque[120], 0.12, 1e-12);
}

TEST_F(ForceRecordFile, ReadsHdf5) {
  SignalRun run{.name = "cut", .signals = {}};
  Signal time{"time", "s", {}};
  for (int i = 0; i < kSamples; ++i) time.values.push_back(i / kRate);
  run.signals.push_back(time);
  for (int axis = 0; axis < 3; ++axis) {
    Signal signal{fmt::format("force_{}", "xyz"[axis]), "kN", {}};
    for (int i = 0; i < kSamples; ++i) signal.values.push_back(force(axis, i));
    run.signals.push_back(signal);
  }
  const auto file = scratch() / "r.h5";
  write_signals({.runs = {run}}, file);
  expect_forces(read_force_record(file), 1e3);

  run.signals.erase(run.signals.begin());
  run.attributes["rate_hz"] = 2000.0;
  write_signals({.runs = {run}}, file);
  expect_forces(read_force_record(file), 1e3);

  SignalRun second = run;
  second.name = "again";
  write_signals({.runs = {run, second}}, file);
  EXPECT_THAT(fault_of(file), HasSubstr("fits both again/force_x and cut/force_x"));
  RecordFormat format;
  format.columns = {"again/force_x", "again/force_y", "again/force_z"};
  expect_forces(read_force_record(file, format), 1e3);
}

/// A MATLAB file with a matrix "force", a vector "t" and a structure with the columns.
void write_mat(const std::filesystem::path& file, mat_ft version) {
  mat_t* out = Mat_CreateVer(file.c_str(), nullptr, version);
  ASSERT_NE(out, nullptr);
  const auto put = [&](const char* name, std::vector<double> values, std::size_t row_count,
                       std::size_t columns) {
    std::size_t size[2] = {row_count, columns};
    return Mat_VarCreate(name, MAT_C_DOUBLE, MAT_T_DOUBLE, 2, size, values.data(), 0);
  };
  std::vector<double> matrix, time, single[3];
  for (int i = 0; i < kSamples; ++i) time.push_back(i / kRate);
  for (int axis = 0; axis < 3; ++axis) {
    for (int i = 0; i < kSamples; ++i) single[axis].push_back(force(axis, i));
    matrix.insert(matrix.end(), single[axis].begin(), single[axis].end());
  }
  const char* fields[] = {"Fx", "Fy", "Fz", "fs"};
  std::size_t one[2] = {1, 1};
  matvar_t* data = Mat_VarCreateStruct("data", 2, one, fields, 4);
  for (std::size_t axis = 0; axis < 3; ++axis)
    Mat_VarSetStructFieldByName(data, fields[axis], 0,
                                put(fields[axis], single[axis], 1, kSamples));
  Mat_VarSetStructFieldByName(data, "fs", 0, put("fs", {kRate}, 1, 1));
  for (matvar_t* variable :
       {put("force", matrix, kSamples, 3), put("t", time, kSamples, 1), data}) {
    Mat_VarWrite(out, variable, MAT_COMPRESSION_ZLIB);
    Mat_VarFree(variable);
  }
  Mat_Close(out);
}

TEST_F(ForceRecordFile, ReadsMatlab5And73) {
  for (const auto version : {MAT_FT_MAT5, MAT_FT_MAT73}) {
    SCOPED_TRACE(version);
    const auto file = scratch() / "r.mat";
    write_mat(file, version);
    RecordFormat format;
    format.unit = "N";
    expect_forces(read_force_record(file, format), 1.0, 1e-12);  // data.Fx … by their usual names
    format.columns = {"force"};
    expect_forces(read_force_record(file, format), 1.0, 1e-12);
    format.columns = {"load"};
    EXPECT_THAT(fault_of(file, format), AllOf(HasSubstr("data.Fx, data.Fy, data.Fz"),
                                              HasSubstr("force(1), force(2), force(3), t")));
    format.columns = {"data.Fx", "data.Fy", "data.Mx"};
    EXPECT_THAT(fault_of(file, format), HasSubstr("data.Mx: is not there"));

    std::string bytes = read_text_file(file);
    put("cut.mat", bytes.substr(0, bytes.size() / 2));
    EXPECT_THAT(fault_of(scratch() / "cut.mat"), HasSubstr("cannot be read as a MATLAB file"));
  }
}

/// The header that DynoWare 3.2.5.0 writes, line by line; a public file has it (docs/guide). One
/// more channel than the forces, of another sensor.
std::string dynoware(int samples, bool decimal_comma = false) {
  const auto cells = [](int, std::vector<std::string>& row) { row.push_back("0.013079"); };
  std::string text = fmt::format(
      "DynoWare\tVersion 3.2.5.0\nPath:\tC:\\Kistler\\Dynoware\\Data\\\nFilename:\tslot_03.dwd\n"
      "Config ID:\tslot.cfg\nSetup ID:\t0\nManipulated:\t0\nFilename 1:\t\nFilename 2:\t\n"
      "Date:\tTuesday, January 15, 2019\nTime:\t16:57:15\nSampling rate [Hz]:\t2000\n"
      "Measuring time [s]:\t{:g}\nDelay time [s]:\t0\nCycle time [s]:\t0\nCycles:\t1\n"
      "Samples per channel:\t{}\nCycle interval:\t0\nCycle No:\t1\nTime\tFx\tFy\tFz\tAFx\n"
      "s\tN\tN\tN\tg\n",
      samples / kRate, samples + 1);
  text += rows('\t', false, cells);
  if (decimal_comma) {
    // All numbers of the file, as Windows in a language with decimal commas writes them.
    const std::size_t begin = text.find("Sampling rate");
    std::replace(text.begin() + static_cast<std::ptrdiff_t>(begin), text.end(), '.', ',');
  }
  return text;
}

TEST_F(ForceRecordFile, ReadsDynoWare) {
  for (const bool decimal_comma : {false, true}) {
    const LoadedRecord loaded = read_force_record(put("r.txt", dynoware(kSamples, decimal_comma)));
    expect_forces(loaded);
    EXPECT_THAT(loaded.notes[0], HasSubstr("DynoWare text, separated by tabs, 200 samples"));
  }
}

TEST_F(ForceRecordFile, BridgesShortGapsWhereThatIsAskedFor) {
  const auto text = "time_s,Fx_N,Fy_N,Fz_N\n" + rows(',', false, [](int i, auto& cells) {
                      if (i == 20) cells[2] = "";
                      if (i == 30 || i == 31) cells[1] = "NaN";
                    });
  RecordFormat format;
  format.gaps = GapPolicy::interpolate;
  const LoadedRecord mended = read_force_record(put("r.csv", text), format);
  EXPECT_NEAR(mended.record.force(20, 1), 0.5 * (force(1, 19) + force(1, 21)), 1e-6);
  EXPECT_THAT(mended.warnings, SizeIs(2));

  std::string gap = "time_s,Fx_N,Fy_N,Fz_N\n";
  const std::string all = rows(',');
  for (std::size_t at = 0, i = 0; at < all.size(); ++i) {
    const std::size_t end = all.find('\n', at) + 1;
    if (i < 100 || i > 103) gap += all.substr(at, end - at);
    at = end;
  }
  const LoadedRecord bridged = read_force_record(put("r.csv", gap), format);
  ASSERT_EQ(bridged.record.force.rows(), kSamples);
  EXPECT_NEAR(bridged.record.force(101, 2),
              force(2, 99) + (force(2, 104) - force(2, 99)) * 2.0 / 5.0, 1e-6);
  EXPECT_THAT(bridged.warnings[0], HasSubstr("4 missing samples in 1 gaps"));
  EXPECT_THAT(fault_of(put("r.csv", gap)), HasSubstr("the first lies between 0.0495 and 0.052 s"));
}

/// Whatever is wrong is named with its place and its remedy.
TEST_F(ForceRecordFile, NamesWhatIsWrong) {
  const std::string head = "time_s,Fx_N,Fy_N,Fz_N\n";
  const auto changed = [&](const std::function<void(int, std::vector<std::string>&)>& change) {
    return head + rows(',', false, change);
  };
  const auto with = [](auto set) {
    RecordFormat format;
    set(format);
    return format;
  };
  struct Bad {
    const char* what;
    std::string text;
    RecordFormat format;
    const char* says;
  };
  for (const Bad& bad : {
           Bad{"NaN",
               changed([](int i, auto& c) {
                 if (i == 40) c[1] = "NaN";
               }),
               {},
               "Fx = 1 of 200 values: are empty or not finite"},
           {"an empty cell",
            changed([](int i, auto& c) {
              if (i == 40) c[3] = "";
            }),
            {},
            "Fz"},
           {"a word",
            changed([](int i, auto& c) {
              if (i == 40) c[3] = "over";
            }),
            {},
            "r.csv:42: Fz = over: must be a number"},
           {"a short line",
            changed([](int i, auto& c) {
              if (i == 199) c.pop_back();
            }),
            {},
            "the file may be cut off"},
           {"time that stands",
            changed([](int i, auto& c) {
              if (i == 9) c[0] = "0.004";
            }),
            {},
            "must grow; it does not at sample 9"},
           {"another rate", head + rows(','), with([](auto& f) { f.rate = 8000.0; }),
            "does not agree with the time column, which has 2000 samples a second"},
           {"another rate than the header", "Sampling rate: 2 kHz\nFx_N,Fy_N,Fz_N\n1,2,3\n4,5,6\n",
            with([](auto& f) { f.rate = 8000.0; }), "is not what the file says, 2000 Hz"},
           {"milliseconds for seconds", head + rows(','), with([](auto& f) {
              f.rate = 2000.0;
              f.time_unit = "ms";
            }),
            "which has 2e+06 samples a second"},
           {"no rate",
            "Fx_N,Fy_N,Fz_N\n1,2,3\n4,5,6\n7,8,9\n",
            {},
            "neither a time column nor a rate"},
           {"no unit", "time_s,Fx,Fy,Fz\n" + rows(','), {}, "does not say what Fx is measured in"},
           {"a wrong unit", "time_s,Fx [m],Fy [m],Fz [m]\n" + rows(','), {}, "is no unit of force"},
           {"a wrong unit of time", head + rows(','), with([](auto& f) { f.time_unit = "N"; }),
            "is no unit that time can have"},
           {"mV without sensitivity",
            "time_s,Fx_mV,Fy_mV,Fz_mV\n" + rows(','),
            {},
            "record.sensitivity_mv_per_n: is missing for Fx"},
           {"a missing column",
            "time_s,Fx_N,Fy_N,F_N\n" + rows(','),
            {},
            "name them in record.columns; the file has time, Fx, Fy, F"},
           {"a column that is not there", head + rows(','),
            with([](auto& f) { f.columns = {"Fx", "Fy", "Fn"}; }),
            "record.columns = Fn: is not there"},
           {"two axes of one name", head + rows(','),
            with([](auto& f) { f.axes = {"x", "x", "z"}; }),
            "must name x, y and z of the sensor once"},
           {"saturation", changed([](int i, auto& c) {
              if (i > 15 && i < 24) c[2] = "2.5";
            }),
            with([](auto& f) { f.range = {2.5}; }),
            "sensor axis y: 8 samples in 1 runs at 2.5 N, the first at 0.0080 s"},
           {"a DynoWare file that is cut off",
            dynoware(2 * kSamples),
            {},
            "the samples end after 0.1000 s: the file is cut off"},
           {"two cycles in one file",
            dynoware(kSamples) + "Cycle No:\t2\n" + rows('\t'),
            {},
            "must be a number"},
           {"decimal commas between commas",
            "DynoWare,Version 3.2.5.0\nSampling rate [Hz]:,2000\nTime,Fx,Fy,Fz\ns,N,N,N\n" +
                rows(',', true),
            {},
            "commas seem to be both decimal and between the columns"},
           {"no numbers", "a,b,c\nd,e,f\n", {}, "holds no two lines of three or more numbers"},
           {"nothing", "", {}, "holds no two lines"},
       }) {
    EXPECT_THAT(fault_of(put("r.csv", bad.text), bad.format), HasSubstr(bad.says)) << bad.what;
  }
  EXPECT_THAT(fault_of(scratch() / "none.csv"), HasSubstr("none.csv"));
  EXPECT_THAT(fault_of(scratch() / "none.mat"), HasSubstr("there is no such file"));
  EXPECT_THAT(fault_of(scratch() / "none.h5"), HasSubstr("there is no such file"));
  EXPECT_THAT(fault_of(put("text.h5", "no HDF5")), HasSubstr("cannot be read as HDF5"));
  EXPECT_THAT(fault_of(put("text.mat", "no MATLAB")), HasSubstr("cannot be read as a MATLAB"));
}

TEST_F(ForceRecordFile, WarnsOfAFlatTopWhereTheRangeIsNotKnown) {
  const auto text = "time_s,Fx_N,Fy_N,Fz_N\n" + rows(',', false, [](int i, auto& c) {
                      if (i > 15 && i < 24) c[2] = "2.1";
                    });
  const LoadedRecord loaded = read_force_record(put("r.csv", text));
  ASSERT_THAT(loaded.warnings, SizeIs(1));
  EXPECT_THAT(loaded.warnings[0], HasSubstr("seems to have reached the end of its range"));
}

}  // namespace
}  // namespace osteomill::io
