// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <string>
#include <vector>

#include "osteomill/calibrate/guide_model.hpp"
#include "osteomill/calibrate/shape_fit.hpp"
#include "osteomill/robot/guide_positioner.hpp"
#include "osteomill/robot/implant.hpp"

namespace osteomill::calibrate {

/// Readings at one stop of the procedure.
struct StopRecord {
  std::string name;
  Halls halls = Halls::Zero();  ///< rad of the motor
  std::vector<PoseSample> samples;
};

/// The procedure of [plaskos2006] 5.6: three passive stops P1–P3, then the sweep A1 (A2 locked) and
/// the sweep A2 (A1 locked), a stop every 10°.
struct GuideRecord {
  std::array<StopRecord, 3> passive;
  std::vector<StopRecord> sweep1;
  std::vector<StopRecord> sweep2;
};

/// The guide in the frame of its body G: a point of its tip, the direction towards the bone, the
/// normal of its plane. From a planar probe in the guide's slot.
struct GuideFrame {
  Vector3 tip_G = Vector3::Zero();
  Vector3 direction_G = Vector3::UnitX();
  Vector3 normal_G = Vector3::UnitZ();
};

/// Plane of a planar probe from its cones, palpated with a pointer; direction: from the first cone
/// to the middle of the others, laid into the plane. At least three cones.
GuideFrame guide_frame_from_cones(const std::vector<Vector3>& cones_G);

/// One planned cut in the bone's body F.
struct PlannedCut {
  robot::Cut cut = robot::Cut::distal;
  Vector3 entry_F = Vector3::Zero();       ///< a point of the cutting plane, on the side of entry
  Vector3 direction_F = Vector3::UnitX();  ///< of cutting, in the plane and across the robot's axes
  Vector3 normal_F = Vector3::UnitZ();
};

/// The five cuts of a profile whose frame I stands at X_FI (x distal, y anterior, z = x × y).
std::vector<PlannedCut> planned_cuts(const robot::PerCut<robot::CutLine>& lines, const Pose& X_FI);

/// How the implant is turned about a point, by the smallest turn, so that its cuts stand square to
/// the robot's first axis; the cuts keep their places to each other. [plaskos2006] 5.6.
struct ImplantTurn {
  Pose X_FF = Pose::Identity();    ///< applied to what was planned
  double angle = 0.0;              ///< rad
  double varus_valgus = 0.0;       ///< part about the anterior direction, rad
  double internal_external = 0.0;  ///< part about the distal direction, rad
};
ImplantTurn turn_implant(const Pose& X_FI, const Vector3& centre_F, const Axis& A1_F);

struct CalibrationOptions {
  Halls gear = {100.0, 100.0};
  int least_samples = 20;       ///< visible readings a stop must have
  double largest_spread = 3.0;  ///< a stop's deviation over the median of all
  double most_skew = 0.0175;    ///< between the axes, rad; more is named
  GuideFitOptions fit = {};
};

/// A fault that the recording shows, by name and place.
struct CalibrationFault {
  enum class Kind {
    hidden_marker,
    unsteady_stop,
    slip,
    moved_reference,
    bad_stop,
    skewed_axes,
    misfit
  };
  Kind kind = Kind::misfit;
  std::string stop;  ///< at or before which
  std::string text;  ///< what, how much, what to do
};

/// Sensor constants of [plaskos2006] eq. 4.1 from the three passive stops: theta = (C − C0)/K with
/// theta1 from the implant's anterior direction to the line A1-A2 and theta2 from there to the
/// guide.
struct SensorConstants {
  std::array<Halls, 3> each;
  Halls mean = Halls::Zero();
  Halls spread = Halls::Zero();  ///< largest minus smallest, rad of the motor
};

struct GuideCalibration {
  bool usable = false;  ///< no fault that makes the result wrong
  GuideFit fit;
  AxisFit axis1;  ///< plane and circle alone, for comparison; A1 in F
  AxisFit axis2;
  double link1 = 0.0;  ///< distance between the axes, m
  double skew = 0.0;   ///< angle between the axes, rad
  std::vector<CalibrationFault> faults;
};
GuideCalibration calibrate_guide(const GuideRecord& record, const CalibrationOptions& options = {});

/// The constants for an implant whose anterior direction is given; all stops see the same robot.
SensorConstants sensor_constants(const GuideModel& model, const GuideFrame& guide,
                                 const GuideRecord& record, const Vector3& anterior_F);

/// Where the guide stands against a planned cut. Angles about the robot's axis and about the
/// direction of cutting; offset of the tip along the cut's normal.
struct PlaneError {
  double flexion = 0.0;  ///< rad
  double tilt = 0.0;     ///< rad
  double offset = 0.0;   ///< m
};
PlaneError plane_error(const Pose& X_FG, const GuideFrame& guide, const PlannedCut& cut,
                       const Vector3& axis_F);

/// What to set for one cut.
struct CutTarget {
  robot::Cut cut = robot::Cut::distal;
  bool reachable = false;
  Halls halls = Halls::Zero();       ///< rad of the motor
  Eigen::Vector2d joints{0.0, 0.0};  ///< from the reference readings, rad
  PlaneError left;                   ///< what two axes cannot remove, by the calibrated model
  PlaneError sd;                     ///< uncertainty from the calibration and the sensors
};
/// `hall_sd`: repeatability of the sensors, rad of the motor. Branch as in the placement.
std::vector<CutTarget> cut_targets(const GuideFit& fit, const GuideFrame& guide,
                                   const std::vector<PlannedCut>& cuts, const Halls& hall_sd,
                                   robot::Branch branch = robot::Branch::outermost);

}  // namespace osteomill::calibrate
