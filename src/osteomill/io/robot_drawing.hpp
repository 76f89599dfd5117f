// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "osteomill/robot/cut_sequence.hpp"
#include "osteomill/robot/size_study.hpp"

/// Drawings of the guide positioner; .svg, .png or .pdf as the path ends.
namespace osteomill::io {

/// The robot at each cut, to scale, with the bone that is there at that time. [plaskos2006]
/// fig. 4.6.
/// One panel: the axes' points from A1 to the tip of the guide.
struct PoseDrawing {
  robot::Cut cut = robot::Cut::distal;
  std::vector<robot::Vector2> points;
  double gap = 0.0;  ///< m
  bool trouble = false;
};
void draw_poses(const robot::Profile& profile, const robot::CutOptions& cuts,
                const robot::BoneOutline& bone, const std::vector<PoseDrawing>& steps,
                const std::string& title, const std::filesystem::path& path);
void draw_poses(const robot::Profile& profile, const robot::CutOptions& cuts,
                const robot::BoneOutline& bone, const robot::Vector2& axis_position,
                const std::vector<robot::SequenceStep>& steps, const std::string& title,
                const std::filesystem::path& path);

/// A circle of places to mark on a map.
struct Circle {
  robot::Vector2 centre;
  double radius = 0.0;  ///< m
  std::string label;
};

/// The largest gap over the place of the first axis and its optimum. [plaskos2006] fig. 4.10.
void draw_gap_map(const robot::GapMap& map, const robot::Placement& placement,
                  const std::optional<Circle>& mark, const std::string& title,
                  const std::filesystem::path& path);

/// The gap of each cut when the first axis is off its best place, distally and anteriorly; a curve
/// ends where its cut leaves the workspace or the guide would stand in bone.
void draw_sensitivity(const robot::GuidePositioner& robot,
                      const robot::PerCut<robot::CutLine>& lines, const robot::Placement& placement,
                      const std::string& title, const std::filesystem::path& path);

/// A surface of the size study over the two lengths, and the best pair. [plaskos2006] fig. 4.11.
void draw_size_study(const robot::SizeStudy& study,
                     const std::vector<std::optional<double>>& surface,
                     const robot::LinkChoice& best, const std::string& title,
                     const std::filesystem::path& path);

}  // namespace osteomill::io
