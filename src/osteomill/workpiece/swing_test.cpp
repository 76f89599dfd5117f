// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/workpiece/swing.hpp"

#include <gmock/gmock.h>

#include <cmath>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"

namespace osteomill::workpiece {
namespace {

using units::mm;

const CutSettings kCut{3e-3, 628.0};

Swing guide() {
  Swing swing;
  swing.pivot_W = {-40 * mm, 5 * mm, -8 * mm};
  swing.normal_W = Vector3(0.1, 0, 1);
  swing.forward_W = {1, 0.2, 0};
  swing.first_angle = -25 * units::deg;
  swing.last_angle = 35 * units::deg;
  swing.first_insertion = 20 * mm;
  swing.last_insertion = 55 * mm;
  swing.advance = 10 * mm;
  return swing;
}

TEST(Swing, TurnsAboutAndSlidesThroughItsPivotInThePlane) {
  const Swing swing = guide();
  const ToolPath path = swing_and_advance(swing, kCut);
  const Vector3 n = swing.normal_W.normalized();
  for (const Move& move : path.moves()) {
    ASSERT_EQ(move.axes_W.size(), move.points_W.size());
    for (std::size_t i = 0; i < move.points_W.size(); ++i) {
      const Vector3 from_pivot = move.points_W[i] - swing.pivot_W;
      EXPECT_NEAR(n.dot(from_pivot), 0.0, 1e-12);
      // The axis points back at the pivot.
      EXPECT_NEAR(from_pivot.cross(move.axes_W[i]).norm(), 0.0, 1e-12);
      EXPECT_LE(from_pivot.dot(move.axes_W[i]), 0.0);
    }
  }
  EXPECT_FALSE(path.upright());
}

TEST(Swing, AdvancesByAGrooveAfterEachSwingThereAndBack) {
  const Swing swing = guide();
  const ToolPath path = swing_and_advance(swing, kCut);
  // 20, 30, 40, 50, 55 mm: slide, there, back.
  ASSERT_EQ(path.moves().size(), 15u);
  EXPECT_EQ(path.moves().back().line, 5);
  const double insertions[] = {20, 30, 40, 50, 55};
  for (std::size_t n = 0; n < 5; ++n) {
    const Move& there = path.moves()[3 * n + 1];
    const Move& back = path.moves()[3 * n + 2];
    for (const Vector3& p : there.points_W)
      EXPECT_NEAR((p - swing.pivot_W).norm(), insertions[n] * mm, 1e-12);
    EXPECT_LT((there.points_W.front() - back.points_W.back()).norm(), 1e-12);
    // An arc of 60°, its chords within 5 µm: shorter by the share e/r * 2/3 of that at most.
    const double arc = insertions[n] * mm * 60 * units::deg;
    EXPECT_NEAR(path.end_of(3 * n + 1) - path.start_of(3 * n + 1), arc, arc * 5e-6 / (20 * mm));
  }
}

TEST(Swing, WithoutTheWayBackAdvancesAtAlternateEnds) {
  Swing swing = guide();
  swing.there_and_back = false;
  const ToolPath path = swing_and_advance(swing, kCut);
  ASSERT_EQ(path.moves().size(), 10u);
  EXPECT_LT((path.moves()[2].axes_W.front() - path.moves()[1].axes_W.back()).norm(), 1e-12);
  EXPECT_GT((path.moves()[2].axes_W.front() - path.moves()[4].axes_W.front()).norm(), 0.5);
}

TEST(Swing, RefusesWhatAGuideCannotDo) {
  const auto broken = [](auto change) {
    Swing swing = guide();
    change(swing);
    EXPECT_THROW(swing_and_advance(swing, kCut), InvalidInput);
  };
  broken([](Swing& s) { s.last_angle = s.first_angle; });
  broken([](Swing& s) { s.last_angle = s.first_angle + 190 * units::deg; });
  broken([](Swing& s) { s.first_insertion = 0.0; });
  broken([](Swing& s) { s.last_insertion = 10 * mm; });
  broken([](Swing& s) { s.advance = 0.0; });
  broken([](Swing& s) { s.forward_W = s.normal_W; });
}

}  // namespace
}  // namespace osteomill::workpiece
