// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/robot_calibration_case.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <charconv>
#include <cmath>
#include <map>

#include "osteomill/base/units.hpp"
#include "osteomill/io/csv_file.hpp"
#include "osteomill/io/text_file.hpp"

namespace osteomill::io {
namespace {

constexpr Quantity kMm{units::mm, "mm"};
constexpr Quantity kDeg{units::deg, "deg"};
const std::vector<std::string> kColumns = {"stop", "phase", "h1_deg", "h2_deg", "visible", "x_mm",
                                           "y_mm", "z_mm",  "qw",     "qx",     "qy",      "qz"};

/// "A1 stop 4" → its number among P1, P2, P3, A1 stops, A2 stops; by the simulated ranges.
void stop_number(Section& section, const char* key, std::optional<std::size_t>& stop,
                 const char* meaning) {
  int number = -1;
  section.integer(key, number, between(-1, 1000), meaning, Need::optional);
  if (number >= 0) stop = static_cast<std::size_t>(number);
}

calibrate::Vector3 triple(Section& section, const char* key, Quantity quantity,
                          const calibrate::Vector3& before, const char* meaning) {
  std::array<double, 3> values{before.x(), before.y(), before.z()};
  section.triple(key, values, quantity, any(), meaning, Need::optional);
  return {values[0], values[1], values[2]};
}

calibrate::Pose pose_of(const calibrate::Vector3& origin, const calibrate::Vector3& turn) {
  calibrate::Pose pose = calibrate::Pose::Identity();
  pose.translation() = origin;
  if (turn.norm() > 0.0) {
    pose.linear() = Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
  }
  return pose;
}

void bind_simulation(Section& table, RobotCalibrateCase& c) {
  int seed = static_cast<int>(c.seed);
  table.integer("seed", seed, between(0, 2e9), "of the random numbers", Need::optional);
  c.seed = static_cast<std::uint64_t>(seed);
  table.number("camera_position_sd_mm", c.robot.tracker.position, kMm, up_to(10.0),
               "noise of one reading, each coordinate", Need::optional);
  table.number("camera_rotation_sd_deg", c.robot.tracker.rotation, kDeg, up_to(10.0),
               "noise of one reading, each coordinate", Need::optional);
  table.integer("samples", c.robot.samples, between(2, 10000), "readings a stop", Need::optional);
  table.number("hall1_sd_deg", c.robot.hall_sd[0], kDeg, between(0.0, 90.0),
               "noise of the first motor's sensor", Need::optional);
  table.number("hall2_sd_deg", c.robot.hall_sd[1], kDeg, between(0.0, 90.0),
               "noise of the second motor's sensor", Need::optional);
  table.table(
      "faults", "what goes wrong; stops count from 0: P1, P2, P3, A1 ..., A2 ...", Need::optional,
      [&](Section& faults) {
        stop_number(faults, "reference_moves_at", c.faults.reference_moves_at,
                    "stop from which the body on the bone stands elsewhere");
        c.faults.reference_shift =
            pose_of(triple(faults, "reference_shift_mm", kMm, {1.0, 0.0, 0.0}, "by how much"),
                    calibrate::Vector3::Zero());
        stop_number(faults, "brake_slips_at", c.faults.brake_slips_at,
                    "stop before which a brake slips");
        faults.integer("slipping_axis", c.faults.slipping_axis, between(1, 2), "1 or 2",
                       Need::optional);
        faults.number("slip_deg", c.faults.slip, kDeg, between(-90.0, 90.0), "by how much",
                      Need::optional);
        stop_number(faults, "hidden_at", c.faults.hidden_at, "stop at which a marker is hidden");
        faults.number("hidden_share", c.faults.hidden_share, {1.0, "of the readings"},
                      between(0.0, 1.0), "how often", Need::optional);
      });
}

}  // namespace

void bind_robot_calibrate(Section& section, RobotCalibrateCase& c) {
  section.exactly_one_of({"record", "simulation"});
  section.table(
      "record", "what a tracker and the sensors recorded", Need::optional, [&](Section& table) {
        table.file("file", c.record, "CSV: stop, phase, h1_deg, h2_deg, visible, x_mm ... qz");
      });
  section.table("simulation", "a simulated robot and tracker instead", Need::optional,
                [&](Section& table) { bind_simulation(table, c); });
  section.table("guide", "the planar probe in the guide's slot, in the frame of body G",
                Need::optional, [&](Section& table) {
                  c.cones_G.clear();
                  for (const char* key : {"cone1_mm", "cone2_mm", "cone3_mm"}) {
                    std::array<double, 3> cone{};
                    table.triple(key, cone, kMm, any(),
                                 "a cone; the guide points from the first to between the others");
                    c.cones_G.emplace_back(cone[0], cone[1], cone[2]);
                  }
                });
  section.table("implant", "what is cut", Need::required,
                [&](Section& table) { bind_implant(table, c.implant); });
  section.table("placement", "of the implant in the frame of body F", Need::optional,
                [&](Section& table) {
                  const auto zero = calibrate::Vector3::Zero();
                  c.X_FI = pose_of(triple(table, "origin_mm", kMm, zero, "of the profile"),
                                   triple(table, "turn_deg", kDeg, zero, "rotation vector"));
                  c.knee_centre_F = triple(table, "knee_centre_mm", kMm, zero,
                                           "about which the implant is turned onto the axes");
                  table.number("distal_overhang_mm", c.distal_overhang, kMm, between(0.0, 100.0),
                               "bone anterior of the distal cut in its plane", Need::optional);
                });
  section.table("options", "of the calibration", Need::optional, [&](Section& table) {
    table.number("gear1", c.options.gear[0], {1.0, "motor turns a joint turn"}, positive(),
                 "reduction of the first axis", Need::optional);
    table.number("gear2", c.options.gear[1], {1.0, "motor turns a joint turn"}, positive(),
                 "reduction of the second axis", Need::optional);
    table.integer("least_samples", c.options.least_samples, between(2, 10000),
                  "visible readings that a stop must have", Need::optional);
    table.number("alarm", c.options.fit.alarm, {1.0, "probability"}, between(0.0, 0.5),
                 "faults are looked for below it", Need::optional);
  });
  section.table("budget", "what each source of error does to the guide, by simulation",
                Need::optional, [&](Section& table) {
                  calibrate::BudgetOptions budget;
                  table.integer("trials", budget.trials, between(10, 1e6), "of the simulation",
                                Need::optional);
                  table.number("gear_error_deg", budget.gear_error, kDeg, between(0.0, 10.0),
                               "of each gear's transmission", Need::optional);
                  table.number("cone_spacing_mm", budget.cone_spacing, kMm, positive(),
                               "of the planar probe", Need::optional);
                  if (!table.when(false)) c.budget = budget;
                });
  c.robot.truth.gear = c.options.gear;
  if (c.budget) c.budget->robot = c.robot;
}

void bind_robot_calibrate_keys(Section& section) {
  RobotCalibrateCase c;
  bind_robot_calibrate(section, c);
}

calibrate::GuideRecord read_guide_record(const std::filesystem::path& file) {
  const CsvFile csv = read_csv(file);
  std::map<std::string, std::size_t> at;
  for (std::size_t i = 0; i < csv.columns.size(); ++i) at[csv.columns[i]] = i;
  std::vector<Fault> faults;
  for (const std::string& column : kColumns) {
    if (!at.contains(column)) {
      faults.push_back({column, "", "is missing among the columns",
                        "needed: stop, phase, h1_deg, h2_deg, visible, x_mm, y_mm, z_mm, qw, qx, "
                        "qy, qz",
                        csv.name + ":1"});
    }
  }
  if (!faults.empty()) throw InvalidInput(faults);
  calibrate::GuideRecord record;
  std::vector<calibrate::StopRecord> passive;
  std::string last;
  std::vector<calibrate::StopRecord>* group = nullptr;
  double count = 0.0;
  for (const CsvFile::Row& row : csv.rows) {
    const std::string place = fmt::format("{}:{}", csv.name, row.line);
    const auto number = [&](const char* column) {
      const std::string& cell = row.cells[at[column]];
      double value = 0.0;
      const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
      if (error != std::errc() || end != cell.data() + cell.size() || !std::isfinite(value)) {
        faults.push_back({column, cell, "must be a finite number", "", place});
      }
      return value;
    };
    const std::string& phase = row.cells[at["phase"]];
    const std::string key = phase + " " + row.cells[at["stop"]];
    if (key != last) {
      last = key;
      count = 0.0;
      if (phase == "P") {
        group = &passive;
      } else if (phase == "A1") {
        group = &record.sweep1;
      } else if (phase == "A2") {
        group = &record.sweep2;
      } else {
        faults.push_back({"phase", phase, "must be P, A1 or A2", "", place});
        continue;
      }
      group->push_back({row.cells[at["stop"]], calibrate::Halls::Zero(), {}});
    }
    if (group == nullptr) continue;
    calibrate::StopRecord& stop = group->back();
    count += 1.0;
    const calibrate::Halls halls(number("h1_deg") * units::deg, number("h2_deg") * units::deg);
    stop.halls += (halls - stop.halls) / count;
    calibrate::PoseSample sample;
    sample.visible = number("visible") != 0.0;
    if (sample.visible) {
      sample.X_FG.translation() =
          calibrate::Vector3(number("x_mm"), number("y_mm"), number("z_mm")) * units::mm;
      const Eigen::Quaterniond q(number("qw"), number("qx"), number("qy"), number("qz"));
      // Six printed digits leave 1e-6; anything else is no rotation.
      if (std::abs(q.norm() - 1.0) > 1e-3) {
        faults.push_back(
            {"qw", fmt::format("norm {:g}", q.norm()), "must be a unit quaternion", "", place});
      } else {
        sample.X_FG.linear() = q.normalized().toRotationMatrix();
      }
    }
    stop.samples.push_back(sample);
  }
  if (passive.size() != 3) {
    faults.push_back({"phase", fmt::format("{} stops of phase P", passive.size()), "must be 3",
                      "record P1, P2 and P3", csv.name});
  }
  if (!faults.empty()) throw InvalidInput(faults);
  std::move(passive.begin(), passive.end(), record.passive.begin());
  return record;
}

void write_guide_record(const std::filesystem::path& file, const calibrate::GuideRecord& record) {
  std::string text = fmt::format("{}\n", fmt::join(kColumns, ","));
  const auto write = [&](const calibrate::StopRecord& stop, const char* phase) {
    for (const calibrate::PoseSample& sample : stop.samples) {
      const Eigen::Quaterniond q(sample.X_FG.linear());
      const calibrate::Vector3 p = sample.X_FG.translation() / units::mm;
      text +=
          fmt::format("{},{},{:.4f},{:.4f},{:d},{:.4f},{:.4f},{:.4f},{:.7f},{:.7f},{:.7f},{:.7f}\n",
                      stop.name, phase, stop.halls[0] / units::deg, stop.halls[1] / units::deg,
                      sample.visible, p.x(), p.y(), p.z(), q.w(), q.x(), q.y(), q.z());
    }
  };
  for (const auto& stop : record.passive) write(stop, "P");
  for (const auto& stop : record.sweep1) write(stop, "A1");
  for (const auto& stop : record.sweep2) write(stop, "A2");
  write_text_file(file, text);
}

}  // namespace osteomill::io
