// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/simulate/line_profile.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "osteomill/base/error.hpp"

namespace osteomill::simulate {
namespace {

LineProfile cortical() {
  LineProfile profile;
  profile.zones = {{0.0, 66e-3, 3800.0, {}, {}}};
  return profile;
}

TEST(LineProfile, ContactLeadsTheAxisByTheChordOfTheRadialDepth) {
  EXPECT_NEAR(contact_lead(cortical()), std::sqrt(7.0) * 1e-3, 1e-12);  // 2.646 mm
}

TEST(LineProfile, CrossSectionIsThatOfTheSilhouetteBehindTheWall) {
  // Midpoint sum of the silhouette over the height, independent of the closed form.
  LineProfile profile = cortical();
  for (const double axial_depth : {2e-3, 3.5e-3, 4e-3, 5e-3}) {
    profile.axial_depth = axial_depth;
    double area = 0.0;
    const int slices = 100000;
    for (int i = 0; i < slices; ++i) {
      const double z = (i + 0.5) * axial_depth / slices;
      const double silhouette = z < 4e-3 ? std::sqrt(z * (8e-3 - z)) : 4e-3;
      area += std::max(0.0, silhouette - 3e-3) * axial_depth / slices;
    }
    // A kink where the silhouette crosses the wall: error of the order of one slice's width times
    // the slope there, (5e-8)² x 1.
    EXPECT_NEAR(cross_section(profile), area, 1e-13);
  }
}

TEST(LineProfile, SmearingKeepsTheAreaUnderTheMaterial) {
  LineProfile profile = cortical();
  profile.zones.push_back({20e-3, 25e-3, 450.0, {}, {}});
  profile.zones.push_back({25e-3, 28e-3, 450.0, 3800.0, {}});
  double plain = 0.0;
  double smeared = 0.0;
  const double dx = 1e-5;
  for (double x = -5e-3; x < 70e-3; x += dx) {
    plain += gain_at(profile, 0, x) * dx;
    smeared += smeared_gain(profile, 0, x) * dx;
  }
  // Rectangle rule over jumps of 3800 N/(m/s): one cell of 1e-5 m each, four jumps.
  EXPECT_NEAR(smeared, plain, 4 * 3800.0 * dx);
}

TEST(LineProfile, TheLaterZoneHoldsAndALineListNamesItsLines) {
  LineProfile profile = cortical();
  profile.zones.push_back({5e-3, 61e-3, 450.0, {}, {2, 3}});
  EXPECT_EQ(gain_at(profile, 0, 30e-3), 3800.0);
  EXPECT_EQ(gain_at(profile, 1, 30e-3), 450.0);
  EXPECT_EQ(gain_at(profile, 2, 4.9e-3), 3800.0);
  EXPECT_EQ(gain_at(profile, 0, -1e-9), 0.0);
  EXPECT_EQ(gain_at(profile, 0, 66.1e-3), 0.0);
}

TEST(LineProfile, VariationIsAFactorOnTheGainAlongEachLine) {
  LineProfile profile = cortical();
  profile.lines = 1;
  profile.variation_spacing = 33e-3;
  profile.variation = {{1.0, 2.0, 1.0}};
  EXPECT_NEAR(gain_at(profile, 0, 16.5e-3), 1.5 * 3800.0, 1e-9);
  EXPECT_NEAR(gain_at(profile, 0, 33e-3), 2.0 * 3800.0, 1e-9);
}

TEST(LineProfileWorkpiece, KnowsHowFarTheNextEntryIs) {
  const LineProfileWorkpiece workpiece(cortical());
  EXPECT_NEAR(workpiece.to_contact(0.0), 8e-3, 1e-12);
  EXPECT_NEAR(workpiece.to_contact(9e-3), -1e-3, 1e-12);
  const double line = workpiece.length() / 3.0;
  EXPECT_NEAR(workpiece.to_contact(line - 1e-3), 9e-3, 1e-12);
  EXPECT_LT(workpiece.to_contact(workpiece.length() - 1e-3), 0.0);
  // Fully engaged when the axis has come to the edge, 2.646 mm on.
  EXPECT_NEAR(workpiece.to_engagement(8e-3), 2.645751e-3, 1e-9);
  EXPECT_NEAR(workpiece.to_engagement(11e-3), -0.354249e-3, 1e-9);
}

TEST(LineProfileWorkpiece, EveryLineStartsAtItsBeginning) {
  const LineProfileWorkpiece workpiece(cortical());
  const double line = workpiece.length() / 3.0;
  double position = 0.0;
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(workpiece.at(position).line, i);
    position = workpiece.next_start(position + 0.9 * line, position + 1.01 * line);
    EXPECT_NEAR(position, (i + 1) * line, 1e-12);
  }
}

TEST(LineProfile, RefusesWhatIsNoBone) {
  const auto broken = [](auto change) {
    LineProfile profile = cortical();
    change(profile);
    return profile;
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NO_THROW(check(cortical()));
  EXPECT_THROW(check(broken([](LineProfile& p) { p.zones.clear(); })), InvalidInput);
  EXPECT_THROW(check(broken([](LineProfile& p) { p.zones[0].to = 0.0; })), InvalidInput);
  EXPECT_THROW(check(broken([](LineProfile& p) { p.zones[0].gain = -1.0; })), InvalidInput);
  EXPECT_THROW(check(broken([&](LineProfile& p) { p.zones[0].gain_end = nan; })), InvalidInput);
  EXPECT_THROW(check(broken([](LineProfile& p) { p.zones[0].lines = {4}; })), InvalidInput);
  EXPECT_THROW(check(broken([](LineProfile& p) { p.lines = 0; })), InvalidInput);
  EXPECT_THROW(check(broken([](LineProfile& p) { p.radial_depth = 4.1e-3; })), InvalidInput);
  EXPECT_THROW(check(broken([](LineProfile& p) { p.peak_to_mean = 0.9; })), InvalidInput);
  EXPECT_THROW(check(broken([](LineProfile& p) { p.programmed_feed = -3e-3; })), InvalidInput);
  EXPECT_THROW(check(broken([](LineProfile& p) { p.variation = {{1.0, 1.0}}; })), InvalidInput);
}

}  // namespace
}  // namespace osteomill::simulate
