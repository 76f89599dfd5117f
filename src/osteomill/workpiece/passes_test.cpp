// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/workpiece/passes.hpp"

#include <gtest/gtest.h>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/workpiece/phantoms.hpp"
#include "osteomill/workpiece/remover.hpp"

namespace osteomill::workpiece {
namespace {

using units::mm;

const CutSettings kCut{3e-3, 628.0};

Lines three() {
  Lines lines;
  lines.start_W = {0, 0, -2 * mm};
  lines.along_W = {20 * mm, 0, 0};
  lines.step_over_W = {0, 1 * mm, 0};
  lines.count = 3;
  return lines;
}

TEST(OneWay, HasTheNextBoneOnTheRightOfTheFeedWhenMillingDown) {
  for (const Milling milling : {Milling::down, Milling::up}) {
    const ToolPath path = one_way(three(), kCut, milling);
    for (const Move& move : path.moves()) {
      if (move.kind == MoveKind::rapid) continue;
      const Vector3 along = move.points_W.back() - move.points_W.front();
      const double to_right = along.cross(Vector3::UnitZ()).y();
      EXPECT_EQ(to_right > 0.0, milling == Milling::down);
    }
  }
}

TEST(OneWay, EngagesTheSideThatItsNameSays) {
  // A half immersed pass: the bone of the next line is met on one side of the cutter only.
  for (const Milling milling : {Milling::down, Milling::up}) {
    Lines lines = directed(three(), milling);
    lines.count = 1;
    Stock stock = block({-10 * mm, 0, -4 * mm}, {30 * mm, 12 * mm, 0}, {1900, 1}, 0.4 * mm);
    cutting::Cutter cutter;
    cutter.radius = 3 * mm;
    cutter.cutting_length = 8 * mm;
    Remover remover(stock, cutter);
    const Vector3 middle = lines.start_W + 0.5 * lines.along_W;
    remover.step(lines.start_W, middle);
    remover.step(middle, middle + 0.1 * lines.along_W);
    const cutting::Engagement& engagement = remover.engagement();
    // Angles run from the left of the feed over its front to its right.
    double left = 0.0, right = 0.0;
    for (int a = 0; a < engagement.angles / 2; ++a)
      (4 * a < engagement.angles ? left : right) += engagement.at(0, a);
    EXPECT_EQ(right > left, milling == Milling::down);
  }
}

TEST(RoughAndFinish, GoesBackOverEachLineAgainstTheFirstDirection) {
  RoughAndFinish passes;
  passes.lines = three();
  passes.allowance_W = {0, 0, 0.1 * mm};
  passes.finish_feed = 1e-3;
  const ToolPath path = rough_and_finish(passes, kCut);
  ASSERT_EQ(path.moves().size(), 6u);
  for (std::size_t n = 0; n < 6; n += 2) {
    const Move& rough = path.moves()[n];
    const Move& finish = path.moves()[n + 1];
    EXPECT_EQ(rough.points_W.back().z(), -1.9 * mm);
    EXPECT_EQ(finish.points_W.back().z(), -2.0 * mm);
    EXPECT_EQ(finish.feed_rate, 1e-3);
    const Vector3 there = rough.points_W.back() - rough.points_W[rough.points_W.size() - 2];
    const Vector3 back = finish.points_W.back() - finish.points_W[1];
    EXPECT_LT((there + back).norm(), 1e-15);
    EXPECT_GT(there.cross(Vector3::UnitZ()).y(), 0.0) << "rough passes mill down";
  }
}

TEST(OneWay, NeedsAStepToOneSide) {
  Lines stacked = three();
  stacked.step_over_W = {0, 0, -1 * mm};
  EXPECT_THROW(one_way(stacked, kCut, Milling::down), InvalidInput);
  stacked.step_over_W = {1 * mm, 0, 0};
  EXPECT_THROW(rough_and_finish({stacked, Vector3::Zero(), 0.0}, kCut), InvalidInput);
}

}  // namespace
}  // namespace osteomill::workpiece
