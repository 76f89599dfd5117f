// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/simulate_picture.hpp"

#include <gtest/gtest.h>

#include "osteomill/base/units.hpp"
#include "osteomill/geometry/mesh_check.hpp"

namespace osteomill::io {
namespace {

using geometry::Vector3;
using units::mm;

/// A run along y through a block, in bone for y from 2 to 8 mm but for a gap, and from side to side
/// by `sway`.
SimulatedRun run(double sway) {
  SimulatedRun made;
  made.input.name = "slot";
  made.input.cutter.cutter.radius = 1.5 * mm;
  geometry::GridShape shape;
  shape.size = {20, 20, 10};
  shape.spacing = Vector3::Constant(0.5 * mm);
  shape.origin = Vector3::Constant(0.25 * mm);
  made.before = made.after = std::make_shared<workpiece::Stock>(shape, [](const Vector3& p) {
    return workpiece::BoneSample{-1.0, {p.z() > 2.5 * mm ? 1812.0 : 655.0, 1.0}};
  });
  for (int i = 0; i <= 100; ++i) {
    simulate::Step step;
    step.tip_W = Vector3(5.0 + (i % 2 == 0 ? sway : -sway), 0.1 * i, 1.0) * mm;
    step.samples_in_contact = i >= 20 && i <= 80 && i / 10 != 5 ? 80 : 0;
    step.mean_force = step.samples_in_contact > 0 ? 0.1 * i : 0.0;
    made.steps.push_back(step);
  }
  return made;
}

TEST(SimulatePicture, ASlotIsCutOpenAlongItsPath) {
  const std::vector<SimulatedRun> runs = {run(0.0)};
  const RunSurfaces surfaces = surfaces_of(runs);
  const Picture picture = force_picture_of(runs, surfaces, 0);
  ASSERT_EQ(picture.views.size(), 1u);
  // Half the block, without what half a voxel takes off edges.
  EXPECT_NEAR(
      geometry::volume(picture.views[0].meshes[0].mesh) / geometry::volume(surfaces.after[0]), 0.5,
      0.02);
  // The camera looks at the open side, which is that of x here: the path runs along y.
  EXPECT_GT(std::abs(picture.camera.from.x()), 2.0 * std::abs(picture.camera.from.y()));
  // The gap in the contact is a gap in the line.
  ASSERT_EQ(picture.views[0].lines.size(), 2u);
  const PictureLine& line = picture.views[0].lines[0];
  EXPECT_DOUBLE_EQ(line.points.front().y(), 2.0 * mm);
  EXPECT_DOUBLE_EQ(line.points.back().y(), 4.9 * mm);
  EXPECT_EQ(line.points.size(), line.values.size());
  // In between as far apart as the line is thick.
  for (std::size_t i = 1; i + 1 < line.points.size(); ++i)
    EXPECT_GE((line.points[i] - line.points[i - 1]).norm(), line.radius);
  EXPECT_EQ(picture.line_values->high, 8.0);
  EXPECT_EQ(picture.mesh_values->low, 600.0);
  EXPECT_EQ(picture.mesh_values->high, 1900.0);
}

TEST(SimulatePicture, APathThatSpreadsIsSeenThroughTheWholeBone) {
  const std::vector<SimulatedRun> runs = {run(3.0)};
  const RunSurfaces surfaces = surfaces_of(runs);
  EXPECT_EQ(force_picture_of(runs, surfaces, 0).views[0].meshes[0].mesh.triangles.size(),
            surfaces.after[0].triangles.size());
}

TEST(SimulatePicture, RunsOfOneStockShareItInTheSceneAndOthersBringTheirOwn) {
  std::vector<SimulatedRun> runs = {run(0.0), run(0.0)};
  ReportData data;
  data.runs.resize(2);
  data.scene.emplace();
  add_scene(data, runs, surfaces_of(runs));
  EXPECT_FALSE(data.scene->before.triangles.empty());
  EXPECT_FALSE(data.runs[1].before.triangles.empty());
  runs[1].before = runs[0].before;
  data.runs = std::vector<ReportRun>(2);
  add_scene(data, runs, surfaces_of(runs));
  EXPECT_TRUE(data.runs[1].before.triangles.empty());
  EXPECT_FALSE(data.runs[1].after.triangles.empty());
}

}  // namespace
}  // namespace osteomill::io
