// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "osteomill/bone/provenance.hpp"
#include "osteomill/cutting/cutting_law.hpp"

namespace osteomill::io {

/// A coefficient in the unit that tables and documents have.
struct EntryCoefficient {
  std::string name;
  std::string unit;
  double factor = 1.0;  ///< value in SI = value in the unit × factor
  double value = 0.0;   ///< SI
  double standard_error = 0.0;
};

/// An identified law as the catalogue keeps it.
struct LawEntry {
  std::string heading;  ///< what it is, without the leading #
  cutting::CuttingLaw law;
  std::vector<double> range_um;             ///< of the chips; empty: not said
  std::vector<double> speed_range_m_per_s;  ///< of the cutting speed; empty: not said
  std::vector<double> rake_deg;             ///< one, or none where cutters differ
  bone::Provenance provenance;
  std::string model, method;
  std::vector<EntryCoefficient> coefficients;
  Eigen::MatrixXd covariance;  ///< SI
  double degrees_of_freedom = 0.0;
  double condition_number = 0.0;
  std::vector<std::pair<std::string, double>> further;  ///< keys of [identification]
};

/// TOML: the law with its range, [provenance], and under [identification] standard errors and
/// covariance.
std::string law_entry_text(const LawEntry& entry);

/// The two ends of a range, a little apart where all are the same.
std::vector<double> ends_of(double low, double high);

}  // namespace osteomill::io
