// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/simulate/foresight.hpp"

#include <gtest/gtest.h>

#include "osteomill/base/error.hpp"
#include "osteomill/simulate/line_profile.hpp"

namespace osteomill::simulate {
namespace {

LineProfile profile() {
  LineProfile made;
  made.zones = {{0.0, 66e-3, 3250.0, {}, {}}, {5e-3, 61e-3, 620.0, {}, {2, 3}}};
  made.edge_force = 4.0;
  return made;
}

Machine machine() {
  Machine made;
  made.spindle_speed = 628.3185307179586;
  return made;
}

TEST(Foresight, FindsGainAndEdgeForceOfALineProfile) {
  const LineProfile bone = profile();
  const Foresight found =
      foresee([&] { return std::make_unique<LineProfileWorkpiece>(bone); }, machine(), {});
  const LineProfileWorkpiece workpiece(bone);
  ASSERT_EQ(found.gains.size(), found.edges.size());
  EXPECT_GE(static_cast<double>(found.gains.size()) * found.spacing, workpiece.length());
  const double start = contact_lead(bone) + bone.lead_in;  // of the bone on line 1
  const auto place = [&](double x) {
    return static_cast<std::size_t>((start + x) / found.spacing);
  };
  for (const double x : {10e-3, 30e-3, 55e-3}) {
    // The window of a revolution covers a stretch of uniform bone: exact but for its last sample.
    EXPECT_NEAR(found.gains[place(x)], 3250.0, 1.0);
    EXPECT_NEAR(found.edges[place(x)], 4.0, 0.01);
  }
  EXPECT_EQ(found.gains[place(-8e-3)], 0.0);
  EXPECT_EQ(found.edges[place(70e-3)], 0.0);
}

TEST(Foresight, RefusesFeedsThatMakeNoLine) {
  const LineProfile bone = profile();
  const auto fresh = [&] { return std::make_unique<LineProfileWorkpiece>(bone); };
  ForesightOptions options;
  options.fast_feed = options.slow_feed;
  EXPECT_THROW(foresee(fresh, machine(), options), InvalidInput);
  options = {};
  options.spacing = 0.0;
  EXPECT_THROW(foresee(fresh, machine(), options), InvalidInput);
}

}  // namespace
}  // namespace osteomill::simulate
