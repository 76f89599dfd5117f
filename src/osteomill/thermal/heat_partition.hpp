// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <numbers>

namespace osteomill::thermal {

/// Share of the shear heat that leaves with the chip:
///
///   R = 1 / (1 + 1.328 sqrt(a g / (v h)))
///
/// a diffusivity of the bone, m²/s; g shear strain; v cutting speed, m/s; h chip thickness, m.
/// [loewen1954]; for bone 78 to 96 % at 20 to 100 µm and 0.5 to 5 m/s (g = 2). 0 for h = 0.
double chip_share(double diffusivity, double shear_strain, double cutting_speed,
                  double chip_thickness);

/// How the energy of a step is divided; J.
struct HeatShares {
  double chip = 0.0, tool = 0.0, bone = 0.0;
};

struct PartitionOptions {
  double shear_strain = 2.0;      ///< assumed
  double rubbing_to_bone = 0.9;   ///< of the rubbing heat; mostly to the bone, the value assumed
  double friction_share = 0.25;   ///< of the cutting heat that arises on the rake face, assumed
  double friction_to_tool = 0.3;  ///< of the rake-face heat; the rest goes with the chip, assumed
  /// An edge that comes from no chip ploughs until its chip is this thick, m; then it cuts to the
  /// chip's end. Between 0.76 and 2 µm, the thinnest cuts in bone that chips are reported of:
  /// [plaskos2006] 2.3.5 and 2.4.3.2; see shares_of_patch().
  double least_chip = 1e-6;
};

/// `cutting` is the energy of the chip-forming force, `rubbing` that of the edge force; J.
HeatShares partition(double cutting, double rubbing, double chip_share,
                     const PartitionOptions& options = {});

/// What the edges do on one patch of the cutter.
struct PatchCut {
  double work = 0.0;     ///< J
  double rubbing = 0.0;  ///< of it, by the edge forces
  double speed = 0.0;    ///< of the edges, m/s
  double chip = 0.0;     ///< uncut, at the middle, m
  double spread = 0.0;   ///< by which the chip at the patch's ends differs from it, m
  bool growing = false;  ///< the chip grows along the way of the edge
};

/// The division of a patch's work by its own chip. Below `least_chip` no chip forms yet where it
/// grows from nothing, as up-milling begins ([albrecht1960]: ploughing; [liu2006]: it takes 0.2 to
/// 0.4 of the edge radius); all of the work rubs there. Where the chip shrinks, as down-milling
/// ends, it is there already and goes on. That a chip once formed lasts to its end is assumed. A
/// patch that the limit passes through ploughs on its share of the way.
HeatShares shares_of_patch(const PatchCut& patch, const PartitionOptions& options = {});

/// Mean chip over the feed per tooth: the mean of the sine over half a turn.
inline constexpr double kMeanOfChip = 2.0 / std::numbers::pi;

/// The work of a spindle in cortical bone, J, or its power, W, of which `rubbing` is that of the
/// edge forces; at the surface speed of the cutter and the mean chip. What `osteomill force` prints
/// and what a simulation puts into its bone.
HeatShares shares_of_cut(double work, double rubbing, double surface_speed, double mean_chip,
                         const PartitionOptions& options = {});

}  // namespace osteomill::thermal
