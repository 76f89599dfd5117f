// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "osteomill/cutting/cutter.hpp"
#include "osteomill/cutting/cutting_law.hpp"
#include "osteomill/workpiece/passes.hpp"
#include "osteomill/workpiece/stock.hpp"

namespace osteomill::simulate {

/// A cutting plane with the milling guide on it, and the poses that the guide lets the tool take:
/// it turns about the pivot by phi and slides through it by the insertion, its axis in the plane
/// at the cutter's radius above it; [plaskos2006] fig. 6.1.
struct GuidePoses {
  geometry::Vector3 pivot_W = geometry::Vector3::Zero();     ///< on the cutting plane
  geometry::Vector3 normal_W = geometry::Vector3::UnitZ();   ///< into the bone that goes
  geometry::Vector3 forward_W = geometry::Vector3::UnitX();  ///< insertion at phi = 0
  double first_angle = 0.0, last_angle = 0.0;                ///< about the normal, rad
  double angle_step = 0.0174532925199433;                    ///< at most, rad
  double first_insertion = 0.0, last_insertion = 0.0;        ///< of the tip beyond the pivot, m
  double insertion_step = 1e-3;                              ///< at most, m
};

struct ForceMapOptions {
  GuidePoses poses;
  cutting::Cutter cutter;
  cutting::CuttingLaw law;
  double spindle_speed = 0.0;  ///< rad/s
  geometry::Vector3 fibre_W = geometry::Vector3::UnitX();
  /// Length of cutter from the tip that is in uncut bone: the groove by which the tool was advanced
  /// since the last swing, m. What lies nearer the pivot was cut then.
  double axial_depth = 10e-3;
  workpiece::Milling milling = workpiece::Milling::down;  ///< which way it swings
  double largest_feed = 20e-3;                            ///< of the tip, m/s
  double slice_height = 0.5e-3;                           ///< at most, m
  int angles = 72;                                        ///< patches around the cutter
};

/// Mean forces over a revolution, one value a pose, N (torque N m).
struct PoseForces {
  std::vector<float> normal;  ///< on the tool along the plane's normal: > 0 lifts it off the cut
  std::vector<float> feed;    ///< that the tool has to be pushed with along its swing
  std::vector<float> axial;   ///< on the tool along its axis: > 0 out of the bone
  std::vector<float> torque;  ///< that the spindle gives
};

/// What a limit is on.
enum class LimitedForce { resultant, normal, feed };

/// The force prediction map of [plaskos2006] 6.2.1: mean normal, feed and axial force at every pose
/// of the guide in this bone, for any feed. Each pose looks at the bone in front of the cutter as
/// it is in the stock, slice by slice and angle by angle (occupancy × force scale, interpolated
/// between voxels), so radial immersion and axial depth follow from the anatomy. A slice at r from
/// the pivot moves at r over the insertion times the tip's feed.
///
/// The forces are kept at some feeds (nodes). For laws that are linear in the chip there are two
/// and the map is exact; otherwise twelve over two decades, between which it is cubic in ln(feed),
/// within 0.1 % for log and power laws. A new feed is then a weighted sum of what is kept.
class ForceMap {
 public:
  /// Throws InvalidInput with all faults. The same result on any number of threads.
  ForceMap(const workpiece::Stock& stock, const ForceMapOptions& options);

  const std::vector<double>& angles() const { return angles_; }          ///< rad
  const std::vector<double>& insertions() const { return insertions_; }  ///< m
  std::size_t poses() const { return angles_.size() * insertions_.size(); }
  /// Insertion runs fastest.
  std::size_t index(std::size_t angle, std::size_t insertion) const {
    return angle * insertions_.size() + insertion;
  }
  /// Below the tip of a pose, on the cutting plane.
  geometry::Vector3 place_W(std::size_t angle, std::size_t insertion) const;
  /// Share of the front of the cutter, as far as it is inserted into uncut bone, that meets bone.
  const std::vector<float>& contact() const { return contact_; }

  bool linear() const { return feeds_.size() == 2; }
  /// Feeds of the nodes, m/s, rising. The first is the smallest that can be asked for.
  const std::vector<double>& feeds() const { return feeds_; }
  const PoseForces& node(std::size_t feed) const { return nodes_[feed]; }

  /// Forces at a feed of the tip, m/s. Throws InvalidInput outside the range of the nodes.
  PoseForces at(double feed) const;
  /// Largest feed of the tip at which the mean force stays within the limit, m/s, one a pose: at
  /// most the largest feed of the map, 0 where even the smallest is too much.
  std::vector<float> largest_feeds(LimitedForce what, double force) const;

 private:
  struct Weights {
    std::size_t first = 0;  ///< node
    int count = 0;
    double of[4] = {};
  };
  Weights weights_at(double feed) const;

  ForceMapOptions options_;
  geometry::Vector3 x_, y_;  ///< in the plane, W: forward, and to its left
  std::vector<double> angles_, insertions_;
  std::vector<double> feeds_;
  std::vector<PoseForces> nodes_;
  std::vector<float> contact_;
};

}  // namespace osteomill::simulate
