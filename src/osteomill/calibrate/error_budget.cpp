// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/calibrate/error_budget.hpp"

#include <tbb/parallel_for.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "osteomill/base/error.hpp"

namespace osteomill::calibrate {
namespace {

struct Sources {
  bool camera = false;
  bool sensors = false;
  bool probe = false;
  bool gears = false;
  bool skew = false;
  bool weight = false;
  bool verification = false;
};

struct Sample {
  robot::PerCut<double> flexion{};
  robot::PerCut<double> offset{};
  bool usable = false;
};

Vector3 normals(Random& random, double sd) {
  const double x = random.normal(0.0, sd);
  const double y = random.normal(0.0, sd);
  const double z = random.normal(0.0, sd);
  return {x, y, z};
}

/// The guide's slot lies in the plane of A2 and the guide's direction; at P1 it points posteriorly.
GuideFrame true_guide(const GuideModel& truth, double spacing, Random& random, double cone_sd) {
  const Pose X_GF = truth.X_FG0.inverse();
  const Vector3 axis = truth.A2_F.direction;
  const Vector3 along = (-Vector3::UnitY() + axis * axis.y()).normalized();
  const Vector3 tip = truth.A2_F.point + 30.0 * units::mm * along;
  std::vector<Vector3> cones;
  for (const Vector3& p :
       {Vector3(tip - 0.5 * spacing * along), Vector3(tip + 0.5 * spacing * (along + axis)),
        Vector3(tip + 0.5 * spacing * (along - axis))}) {
    cones.push_back(X_GF * p + normals(random, cone_sd));
  }
  return guide_frame_from_cones(cones);
}

Sample play(const BudgetOptions& options, const Sources& on, std::uint64_t trial) {
  // The same stream for every line: sources switched on one after the other see the same draws.
  Random random(options.seed, trial);
  SimulatedRobot robot = options.robot;
  // Without camera noise the fit still needs a weight: a thousandth of it.
  const double camera = on.camera ? 1.0 : 1e-3;
  robot.tracker.position *= camera;
  robot.tracker.rotation *= camera;
  if (!on.sensors) robot.hall_sd = Halls::Zero();
  const double skew = on.skew ? random.normal(0.0, options.skew) : 0.0;
  robot.truth.A2_F.direction = (robot.truth.A2_F.direction + skew * Vector3::UnitX()).normalized();

  Random recording(options.seed + 1, trial);
  const GuideRecord record = play_procedure(robot, recording);
  CalibrationOptions calibration;
  calibration.gear = robot.truth.gear;
  calibration.fit.alarm = 0.0;  // nothing goes wrong here; a sensor error is no fault
  const GuideCalibration found = calibrate_guide(record, calibration);

  Random probe(options.seed + 2, trial);
  const GuideFrame exact = true_guide(robot.truth, options.cone_spacing, probe, 0.0);
  const double cone_sd = on.probe ? options.cone_noise / std::sqrt(30.0) : 0.0;
  const GuideFrame seen = true_guide(robot.truth, options.cone_spacing, probe, cone_sd);

  const auto lines = robot::cut_lines(robot::profile_of(robot::generic_family(), 4));
  const ImplantTurn turn = turn_implant(Pose::Identity(), Vector3::Zero(), found.fit.model.A1_F);
  const auto cuts = planned_cuts(lines, turn.X_FF);
  const auto targets = cut_targets(found.fit, seen, cuts, Halls::Zero());
  Random driving(options.seed + 3, trial);
  Sample sample;
  sample.usable = found.fit.converged;
  for (std::size_t i = 0; i < cuts.size(); ++i) {
    if (!targets[i].reachable) {
      sample.usable = false;
      return sample;
    }
    // The motors stop where their sensors read the target; the gears turn a little more or less.
    Halls at = targets[i].halls;
    for (int k = 0; k < 2; ++k) {
      at[k] += driving.normal(0.0, robot.hall_sd[k]);
      const double gear = driving.normal(0.0, options.gear_error) * robot.truth.gear[k];
      if (on.gears) at[k] += gear;
    }
    if (on.weight) {
      // The weight hangs on link 1 and winds up its gear; it pulls most when the link is level.
      const double level = std::cos(targets[i].joints[0]);
      at[0] -= robot.truth.gear[0] * options.guide_torque * level / options.gear_stiffness;
    }
    Pose X_FG = robot.truth.pose(at);
    const GuideFrame* frame = &exact;
    if (on.verification) {
      X_FG = average(readings(X_FG, options.robot.tracker, options.robot.samples, driving)).X_FG;
      frame = &seen;
    }
    const PlaneError error = plane_error(X_FG, *frame, cuts[i], robot.truth.A1_F.direction);
    sample.flexion[robot::index(cuts[i].cut)] = error.flexion;
    sample.offset[robot::index(cuts[i].cut)] = error.offset;
  }
  return sample;
}

}  // namespace

std::vector<BudgetLine> error_budget(const BudgetOptions& options, const Progress& progress) {
  require_within("budget.trials", options.trials, 10.0, 1e6, "");
  require_positive("budget.cone_spacing_mm", options.cone_spacing / units::mm, "mm");
  require_positive("budget.gear_stiffness_nm_per_rad", options.gear_stiffness, "N m/rad");
  const std::vector<std::pair<std::string, Sources>> cases = {
      {"camera", {.camera = true}},
      {"motor sensors", {.sensors = true}},
      {"planar probe", {.probe = true}},
      {"gears", {.gears = true}},
      {"skewed axes", {.skew = true}},
      {"guide's weight", {.weight = true}},
      {"all", {true, true, true, true, true, true, false}},
      {"all, as verified", {true, true, true, true, true, true, true}},
  };
  std::vector<BudgetLine> lines;
  for (const auto& [name, sources] : cases) {
    if (!go_on(progress, "error budget",
               static_cast<double>(lines.size()) / static_cast<double>(cases.size()))) {
      break;
    }
    std::vector<Sample> samples(static_cast<std::size_t>(options.trials));
    tbb::parallel_for(std::size_t{0}, samples.size(),
                      [&, on = sources](std::size_t i) { samples[i] = play(options, on, i); });
    BudgetLine line;
    line.source = name;
    double count = 0.0;
    for (const Sample& sample : samples) {
      if (!sample.usable) continue;
      count += 1.0;
      for (std::size_t c = 0; c < 5; ++c) {
        line.flexion_sd[c] += sample.flexion[c] * sample.flexion[c];
        line.offset_sd[c] += sample.offset[c] * sample.offset[c];
        line.mean_absolute += std::abs(sample.flexion[c]) / 5.0;
      }
    }
    if (count < 1.0) throw NoSolution("the simulated robot reaches none of the five cuts");
    line.mean_absolute /= count;
    for (std::size_t c = 0; c < 5; ++c) {
      line.flexion_rms += line.flexion_sd[c] / count / 5.0;
      line.offset_rms += line.offset_sd[c] / count / 5.0;
      line.flexion_sd[c] = std::sqrt(line.flexion_sd[c] / count);
      line.offset_sd[c] = std::sqrt(line.offset_sd[c] / count);
    }
    line.flexion_rms = std::sqrt(line.flexion_rms);
    line.offset_rms = std::sqrt(line.offset_rms);
    lines.push_back(line);
  }
  if (lines.size() == cases.size()) {
    std::stable_sort(lines.begin(), lines.end() - 2, [](const BudgetLine& a, const BudgetLine& b) {
      return a.flexion_rms > b.flexion_rms;
    });
  }
  return lines;
}

}  // namespace osteomill::calibrate
