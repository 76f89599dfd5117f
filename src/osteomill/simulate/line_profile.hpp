// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "osteomill/simulate/workpiece.hpp"

namespace osteomill::simulate {

/// A stretch of material along a line; where zones overlap the later one holds.
struct ProfileZone {
  double from = 0.0;               ///< m from the edge of the bone
  double to = 0.0;                 ///< m
  double gain = 0.0;               ///< K of F = K v, N/(m/s), [sugita2009] eq. 7
  std::optional<double> gain_end;  ///< at `to`, K linear between; none: K constant
  std::vector<int> lines;          ///< from 1; empty: every line
};

/// The one-dimensional bone of the Sugita cases: parallel lines side-milled at constant depths with
/// a ball cutter, force proportional to the feed and to a material profile.
struct LineProfile {
  std::vector<ProfileZone> zones;
  int lines = 3;
  double line_length = 66e-3;   ///< m of bone under each line
  double lead_in = 8e-3;        ///< air before first contact on each line, m
  double lead_out = 10.35e-3;   ///< air after the exit from each line, m
  double cutter_radius = 4e-3;  ///< m
  double radial_depth = 1e-3;   ///< a_e, m
  double axial_depth = 5e-3;    ///< a_p, m
  int flutes = 2;
  double peak_to_mean = 2.0;      ///< rho of the ripple at the tooth frequency, 1...2
  double edge_force = 0.0;        ///< added at any feed where the cutter is fully engaged, N
  double programmed_feed = 3e-3;  ///< m/s
  /// At which the gains hold, rad/s: at another speed the chip, and with it the gain, changes by
  /// the ratio. 0: the gains hold at every speed.
  double spindle_speed = 0.0;
  /// Factor on the gain along each line, linear between points that are this far apart; none: 1.
  std::vector<std::vector<double>> variation;
  double variation_spacing = 0.1e-3;  ///< m
};

/// Throws InvalidInput that names the field.
void check(const LineProfile& profile);

/// How far ahead of its axis the cutter touches the bone, R sin arccos(1 - a_e/R): 2.646 mm for
/// a_e 1 mm on D 8 mm.
double contact_lead(const LineProfile& profile);

/// What one line takes away a metre of its length: the part of the ball-ended silhouette that
/// reaches behind the wall at R - a_e from the axis, between the tip and a_p. 2.813 mm² for R 4,
/// a_e 1, a_p 5 mm (exact for a flat wall that is fresh over the whole axial depth).
double cross_section(const LineProfile& profile);

/// Material under the axis, N/(m/s); 0 outside the bone.
double gain_at(const LineProfile& profile, int line, double x);

/// The same smeared over the arc of contact: mean over u in (0, 1), 40 midpoints, of
/// K(x + R sin arccos(1 - u a_e/R)): chips are weighted by the radial depth at which they are cut.
double smeared_gain(const LineProfile& profile, int line, double x);

/// F(t) = smeared K(x) v(t) w(t), w a ripple of mean 1 and largest value rho at the tooth
/// frequency, along -x. x runs from -lead - lead_in to line_length + lead_out on every line; a line
/// ends with the control period in which it is done, the next one starts with the next period.
/// In W the wall is y = 0, the axis runs before it at y = a_e - R, and each line is a_p below the
/// last.
class LineProfileWorkpiece final : public Workpiece {
 public:
  explicit LineProfileWorkpiece(LineProfile profile);

  double length() const override;
  int lines() const override { return profile_.lines; }
  Place at(double position) const override;
  double to_contact(double position) const override;
  double to_engagement(double position) const override;
  double next_start(double from, double to) const override;
  void mill(const Motion& motion, Cut& cut) override;
  const char* material_key() const override { return "cutting_gain_n_per_mm_per_s"; }
  double material_unit() const override { return 1e3; }

 private:
  struct Sample {
    double gain = 0.0;   ///< smeared
    double share = 0.0;  ///< of the arc that is in bone
  };
  double pitch() const;  ///< path length of one line
  Sample sample(int line, double x) const;

  LineProfile profile_;
  double lead_ = 0.0;
  double section_ = 0.0;
  std::vector<std::vector<Sample>> table_;  ///< one a line, from -lead to line_length
};

}  // namespace osteomill::simulate
