// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <vector>

#include "osteomill/accuracy/tool_deflection.hpp"
#include "osteomill/cutting/flutes.hpp"
#include "osteomill/vibration/linearised_cut.hpp"

namespace osteomill::accuracy {

using Eigen::Index;

/// What an edge before another left at the same angle: its place at rotation `low` and, by `share`,
/// at the one behind it; `gap` is what lies between them without deflection.
struct Before {
  double gap = 0.0;
  Index low = 0, high = 0;
  double share = 0.0;
};

/// The edge of a slice and flute in contact at a rotation.
struct Edge {
  Index rotation = 0, slice = 0;
  double sine = 0.0, cosine = 0.0;  ///< of its angle
  double own_gap = 0.0;             ///< chip if it met what it left itself a revolution before
  std::vector<Before> before;
  geometry::Vector3 t, normal;
};

/// Chips differ by less where they balance: a picometre, a thousandth of a chip of a nanometre.
inline constexpr double kBalanced = 1e-12;

/// A turn at equally spaced rotations, whose edges meet what others of them left.
struct Turn {
  std::vector<double> rotation;
  std::vector<Edge> edges;
  std::vector<Index> first;  ///< edge of each rotation, and their number
  Eigen::VectorXd root;      ///< unknown of an edge: cube root of its chip over that of the feed
  Eigen::VectorXd force_x, force_y;  ///< of an edge, N
  Eigen::VectorXd slope_x, slope_y;  ///< by its unknown
  Eigen::VectorXd rise;              ///< of the chip by its unknown, m
  Eigen::VectorXd residual;          ///< chip less what lies before the deflected edge, m
  std::vector<Index> meets;          ///< of `before`, or -1: its own
  Eigen::MatrixXd jacobian;
};

/// Balance of forces and deflections of all edges in contact: the equations of flexible_cut().
class EdgeBalance {
 public:
  EdgeBalance(const ToolCompliance& tool, const cutting::Cutter& cutter,
              const cutting::CuttingLaw& law, const cutting::Condition& condition,
              const cutting::Immersion& immersion, int slices);

  double middle(int slice) const { return middles_[static_cast<std::size_t>(slice)]; }
  const cutting::Flutes& flutes() const { return flutes_; }

  /// Balances the turn at these rotations: from a turn near by, from the chips of the rigid cut or,
  /// where both lead nowhere, from equal flutes on, whose balance is that of the rigid cut.
  Turn solve(const std::vector<double>& rotations, const Turn& near) const;

  /// Growth of a disturbance in a revolution: spectral radius of the map from the chips of one turn
  /// to those of the next, which meet the surface that they leave.
  /// By a number of revolutions: quick, and good to some thousandths.
  double growth(const Turn& turn) const;
  /// By all eigenvalues.
  double exact_growth(const Turn& turn) const;

  /// What the linearised cut is at one rotation: z = compliance x dF/dh has its eigenvalues; an
  /// edge that meets its own kind leaves z/(1 + z) of a disturbance of the surface.
  struct Stiffness {
    double over_tool = 0.0;  ///< largest |z|
    double left = 0.0;       ///< largest |z/(1 + z)|
  };
  Stiffness stiffness(const Turn& turn, Index rotation) const;

  /// Forces of a rotation times what they do each at their slices: x and y.
  Eigen::Vector2d sum(const Turn& turn, Index rotation, const Eigen::VectorXd& influence) const;

 private:
  Turn begin(const std::vector<double>& rotations, double share) const;
  void add_edge(Turn& turn, Index m, int s, int j, double share) const;
  bool newton(Turn& turn) const;
  Eigen::MatrixXd next_turn(const Turn& turn, Eigen::MatrixXd chips, int turns) const;
  void evaluate(Turn& turn) const;
  double outward_by(const Turn& turn, Index i, Index k) const;
  void assemble(Turn& turn) const;

  const cutting::Cutter& cutter_;
  const cutting::CuttingLaw& law_;
  const cutting::Condition& condition_;
  cutting::Flutes flutes_;
  int slices_;
  double dz_;
  vibration::ContactAngles contact_;
  Eigen::MatrixXd compliance_;
  std::vector<double> middles_;
  std::vector<cutting::ProfilePoint> points_;
};

}  // namespace osteomill::accuracy
