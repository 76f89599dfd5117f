// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <vector>

#include "osteomill/identify/instantaneous.hpp"

/// What fit_instantaneous minimises: the unknowns, and the model's forces on the averaged angles.
namespace osteomill::identify::detail {

/// The unknowns that the forces are not linear in, made dimensionless: exponents of the law,
/// run-out x, y and tilt x, y (times the axial depth) over the feed per tooth, phase in rad.
struct Layout {
  std::vector<UnitForce> units;
  bool run_out = false;
  bool tilt = false;
  bool phase = false;
  double feed = 0.0;
  double depth = 0.0;
  double known_phase = 0.0;

  Eigen::Index exponents() const { return exponents_of(units); }
  Eigen::Index size() const { return exponents() + 2 * run_out + 2 * tilt + phase; }
  cutting::RunOut run_out_of(const Eigen::VectorXd& u, const cutting::RunOut& known) const;
  double phase_of(const Eigen::VectorXd& u) const { return phase ? u[size() - 1] : known_phase; }
  /// From dimensionless to SI.
  Eigen::VectorXd scales() const;
  /// Exponents to begin with, the rest 0.
  Eigen::VectorXd start() const;
  /// The nearest that a law may have: 0.02 <= n <= 1.5, K3 <= 0 (a log law with K3 > 0 has no limit
  /// for a thin chip).
  void clamp(Eigen::VectorXd& u) const;
  /// Whether an exponent stands at such a limit.
  bool at_limit(const Eigen::VectorXd& u, Eigen::Index i) const;
  std::vector<std::string> names() const;

 private:
  struct Limits {
    Eigen::VectorXd low, high;
  };
  Limits limits() const;
};

/// Values on some of the angles, and what the model says of them.
class RevolutionProblem {
 public:
  RevolutionProblem(const EdgeColumns& model, const Layout& layout,
                    const InstantaneousOptions& options, std::vector<double> angle,
                    const Eigen::MatrixX3d& mean, double width);

  Eigen::Index linear() const {
    return static_cast<Eigen::Index>(model_.units().size() + offsets_.size());
  }
  const std::vector<Eigen::Index>& offsets() const { return offsets_; }
  const Eigen::VectorXd& values() const { return values_; }

  /// Forces of each unknown the model is linear in, 3 n rows.
  Eigen::MatrixXd columns(const Eigen::VectorXd& u) const;

  /// Columns over the standard deviation of the values, and below them rows for what is known of
  /// the offsets beforehand.
  Eigen::MatrixXd weigh(const Eigen::MatrixXd& columns, const Eigen::Vector3d& deviation) const;
  /// The same for derivatives and values, which the rows below have none of.
  Eigen::MatrixXd weigh_values(const Eigen::MatrixXd& columns,
                               const Eigen::Vector3d& deviation) const;

 private:
  Eigen::Index prior_rows() const;
  void prepare_gains(double width);
  void prepare_width(double width);

  const EdgeColumns& model_;
  const Layout& layout_;
  const InstantaneousOptions& options_;
  std::vector<double> angle_;
  Eigen::Index rows_;
  Eigen::VectorXd values_;
  std::vector<Eigen::Index> offsets_;
  std::vector<double> fine_angle_;
  Eigen::MatrixXd gains_;
};

}  // namespace osteomill::identify::detail
