// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Dense>

// Eigen's decompositions of dense real matrices, compiled once: a source that includes this header
// in place of <Eigen/Dense> compiles in a fraction of the time. Fixed sizes are still compiled
// where they are used, so small systems are best written with MatrixXd too unless they are hot.
extern template class Eigen::ColPivHouseholderQR<Eigen::MatrixXd>;
extern template class Eigen::JacobiSVD<Eigen::MatrixXd>;
extern template class Eigen::LDLT<Eigen::MatrixXd>;
extern template class Eigen::LLT<Eigen::MatrixXd>;
extern template class Eigen::PartialPivLU<Eigen::MatrixXd>;
extern template class Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>;
