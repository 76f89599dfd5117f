// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "osteomill/accuracy/tool_compliance.hpp"
#include "osteomill/cutting/cutter.hpp"
#include "osteomill/cutting/cutting_law.hpp"
#include "osteomill/cutting/engaged_force.hpp"
#include "osteomill/simulate/bone_heat.hpp"
#include "osteomill/simulate/workpiece.hpp"
#include "osteomill/workpiece/contact.hpp"
#include "osteomill/workpiece/no_go.hpp"
#include "osteomill/workpiece/remover.hpp"
#include "osteomill/workpiece/stock.hpp"
#include "osteomill/workpiece/tool_path.hpp"

namespace osteomill::simulate {

/// What is milled in three dimensions, by what, along which path.
struct StockJob {
  cutting::Cutter cutter;
  cutting::CuttingLaw law;
  workpiece::ToolPath path;
  /// Of the moves that are not cuts, m/s; before a cut they slow down to its feed.
  double rapid_feed = 12e-3;
  geometry::Vector3 fibre_W = geometry::Vector3::UnitX();  ///< direction of the bone's fibres, unit
  /// The same by place, where it is known; none: fibre_W everywhere.
  std::function<geometry::Vector3(const geometry::Vector3& p_W)> fibre_at = {};
  double sample_rate = 8000.0;  ///< of the force sensor, 1/s: how fine a revolution is worked out
  std::optional<BoneHeatOptions> heat = {};  ///< none: temperatures are not worked out
  std::vector<workpiece::NoGo> no_go = {};   ///< regions that the tool keeps away from
  /// How the tool gives way; none: it is rigid. The mean force of a period, acting at the height
  /// that its moment says, bends the tool sideways; the cutter is moved by that in the next period.
  std::optional<accuracy::ToolCompliance> tool = {};
};

/// Deflection of the tool while it cut, sideways, m.
struct BentTool {
  double mean = 0.0;  ///< over the periods in contact
  double largest = 0.0;
};

/// A voxel stock milled along a tool path.
///
/// In each control period the cutter is moved along the path, the stock says what was removed and
/// which part of the cutter is in contact, and the cutting law gives the forces over one revolution
/// at the mean feed per tooth of the period. The sensor's samples are read off that revolution at
/// the angles of the spindle. Where nothing is removed there is no force.
class StockWorkpiece final : public Workpiece {
 public:
  /// Throws InvalidInput when cutter, law and path do not fit together or never meet the bone.
  StockWorkpiece(workpiece::Stock stock, StockJob job);
  StockWorkpiece(const StockWorkpiece&) = delete;
  StockWorkpiece& operator=(const StockWorkpiece&) = delete;

  double length() const override { return job_.path.length(); }
  int lines() const override { return static_cast<int>(lines_.size()); }
  Place at(double position) const override;
  double to_contact(double position) const override;
  double to_engagement(double position) const override;
  void mill(const Motion& motion, Cut& cut) override;
  double temperature() const override { return heat_ ? heat_->hottest() : 0.0; }
  double no_go_distance() const override { return no_go_distance_; }
  const char* material_key() const override { return "density_kg_per_m3"; }
  double material_unit() const override { return 1.0; }

  const workpiece::Stock& stock() const { return stock_; }
  const workpiece::ContactMap& contact() const { return contact_; }
  /// Smallest and largest uncut chip thickness at full feed-normal so far, m: the range of the law
  /// that was used.
  double largest_chip() const { return largest_chip_; }
  /// Bone that a move met inside the cutter, m³; see workpiece::Removal.
  double buried_volume() const { return buried_volume_; }
  /// Of the bone so far; null when the job did not ask for it.
  const BoneHeat* heat() const { return heat_ ? &*heat_ : nullptr; }
  /// All zero for a rigid tool.
  BentTool bent_tool() const;

  /// What milling changes; see base/archive.hpp.
  template <class Archive>
  void exchange(Archive& a) {
    a(stock_, remover_, largest_chip_, buried_volume_, bent_W_, next_bent_W_, bent_sum_,
      bent_largest_, bent_periods_, no_go_distance_, no_go_found_, no_go_tip_W_, no_go_axis_W_);
    if (heat_) a(*heat_);
  }

 private:
  double rapid_feed(std::size_t move, double position) const;
  void watch_no_go(const workpiece::ToolPose& pose);
  const workpiece::ContactMap::Stretch& nearest_entry(double position) const;
  cutting::Condition condition_of(const Motion& motion, const Place& place, double feed) const;
  void sample_forces(const Motion& motion, const Place& place, double feed, Cut& cut);
  void heat_bone(const Motion& motion, const Place& place, double feed);
  void bend(const cutting::Load& mean_T, const Eigen::Matrix3d& R_WT);

  workpiece::Stock stock_;
  StockJob job_;
  std::unique_ptr<workpiece::Stock> left_;  ///< by the path; null once the heat knows it
  workpiece::ContactMap contact_;
  workpiece::Remover remover_;
  workpiece::PatchGrid patches_;
  cutting::EngagedForce force_;
  std::optional<cutting::EngagedForce> edge_force_;  ///< what rubs; where there is heat
  std::vector<int> lines_;                           ///< numbers of the path's lines, in order
  double largest_chip_ = 0.0;
  double buried_volume_ = 0.0;
  double no_go_distance_ = std::numeric_limits<double>::infinity();
  double no_go_found_ = 0.0;  ///< where it was worked out last, at
  geometry::Vector3 no_go_tip_W_ = geometry::Vector3::Zero();
  geometry::Vector3 no_go_axis_W_ = geometry::Vector3::UnitZ();
  std::optional<BoneHeat> heat_;
  std::vector<thermal::PatchCut> patch_cuts_;
  geometry::Vector3 bent_W_ = geometry::Vector3::Zero();  ///< where the cutter is beside the path
  geometry::Vector3 next_bent_W_ = geometry::Vector3::Zero();  ///< at the end of the next period
  double bent_sum_ = 0.0, bent_largest_ = 0.0;
  std::int64_t bent_periods_ = 0;
};

}  // namespace osteomill::simulate
