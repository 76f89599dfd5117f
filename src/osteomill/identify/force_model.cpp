// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/identify/force_model.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "osteomill/base/units.hpp"
#include "osteomill/cutting/milling_force.hpp"
#include "osteomill/numerics/bounded_least_squares.hpp"
#include "osteomill/numerics/decompositions.hpp"

namespace osteomill::identify {
namespace {

using cutting::CuttingLaw;
using cutting::DirectionalLaw;
using cutting::EdgeForce;
using cutting::PolynomialLaw;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::string numbered(const std::string& name, int order, int i) {
  return order == 0 ? name : name + std::to_string(i);
}

/// One component's power or log law, from four or fewer values.
EdgeForce law_of_one(const ForceModel& model, const double*& value,
                     const cutting::ChipRange& range) {
  if (model.form == LawForm::log) {
    cutting::LogLaw law{value[0], value[1], value[2], range};
    value += 3;
    return law;
  }
  cutting::PowerLaw law{value[0], value[1], model.edge_force ? value[2] : 0.0, range};
  value += model.edge_force ? 3 : 2;
  return law;
}

void keys_of_one(const ForceModel& model, const std::string& component, const std::string& suffix,
                 std::vector<CoefficientKey>& keys) {
  if (model.form == LawForm::log) {
    keys.push_back({"K" + component + "1" + suffix, Dimension::number, -kInfinity, kInfinity});
    keys.push_back({"K" + component + "2" + suffix, Dimension::number, -kInfinity, kInfinity});
    // A law with K3 > 0 has no limit for h -> 0.
    keys.push_back({"K" + component + "3" + suffix, Dimension::number, -kInfinity, 0.0});
    return;
  }
  keys.push_back({"K" + component + suffix, Dimension::force_per_width, 0.0, kInfinity});
  // The bracket of cutting::fit_power_law.
  keys.push_back({"n" + component + suffix, Dimension::number, 0.02, 1.5});
  if (model.edge_force) {
    keys.push_back({"F" + component + "e" + suffix, Dimension::force_per_width, 0.0, kInfinity});
  }
}

/// Coefficients order by order, t r a within an order; pressures first. Lateral is towards the tip,
/// axial away from it.
std::array<PolynomialLaw, 3> polynomials(const ForceModel& model, const VectorXd& values,
                                         const cutting::ChipRange& range) {
  std::array<PolynomialLaw, 3> laws;
  Index at = 0;
  for (int i = 0; i <= model.shear_order; ++i) {
    for (PolynomialLaw& law : laws) law.pressure.push_back(values(at++));
  }
  for (int i = 0; i <= model.edge_order; ++i) {
    for (PolynomialLaw& law : laws) law.edge.push_back(values(at++));
  }
  for (double& c : laws[2].pressure) c = -c;
  for (double& e : laws[2].edge) e = -e;
  for (PolynomialLaw& law : laws) law.range = range;
  return laws;
}

CuttingLaw linear_in_coefficients(const ForceModel& model, const VectorXd& values,
                                  const cutting::ChipRange& range) {
  const std::array<PolynomialLaw, 3> laws = polynomials(model, values, range);
  const auto one = [&](std::size_t i) -> EdgeForce {
    if (model.form == LawForm::polynomial) return laws[i];
    return cutting::LinearLaw{laws[i].pressure.empty() ? 0.0 : laws[i].pressure[0],
                              laws[i].edge.empty() ? 0.0 : laws[i].edge[0], range};
  };
  CuttingLaw law{{one(0), {}}, {one(1), {}}, DirectionalLaw{one(2), {}}};
  law.orientation = cutting::OrientationCriterion::none;
  return law;
}

}  // namespace

std::string name_of(const ForceModel& model) {
  const std::string fibres = model.directional ? ", along and across the fibres" : "";
  if (model.form == LawForm::log) return "log" + fibres;
  if (model.form == LawForm::power) {
    return (model.edge_force ? "power with edge force" : "power") + fibres;
  }
  if (model.form == LawForm::linear) {
    if (model.shear_order < 0) return "edge force alone";
    return model.edge_order < 0 ? "linear without edge force" : "linear";
  }
  const std::string shear = "shear order " + std::to_string(model.shear_order);
  const std::string edge = "edge order " + std::to_string(model.edge_order);
  if (model.shear_order < 0) return edge + " without shear";
  if (model.edge_order < 0) return shear + " without edge";
  return shear + ", " + edge;
}

bool is_linear(const ForceModel& model) {
  return model.form == LawForm::linear || model.form == LawForm::polynomial;
}

double factor_of(Dimension dimension) {
  switch (dimension) {
    case Dimension::pressure:
      return units::n_per_mm2;
    case Dimension::force_per_width:
      return units::n_per_mm;
    case Dimension::number:
      break;
  }
  return 1.0;
}

const char* unit_of(Dimension dimension) {
  switch (dimension) {
    case Dimension::pressure:
      return "N/mm2";
    case Dimension::force_per_width:
      return "N/mm";
    case Dimension::number:
      break;
  }
  return "1";
}

std::vector<CoefficientKey> coefficients_of(const ForceModel& model) {
  std::vector<CoefficientKey> keys;
  if (is_linear(model)) {
    for (int i = 0; i <= model.shear_order; ++i) {
      for (const char* name : {"Ktc", "Krc", "Kac"}) {
        keys.push_back({numbered(name, model.shear_order, i), Dimension::pressure});
      }
    }
    for (int i = 0; i <= model.edge_order; ++i) {
      for (const char* name : {"Kte", "Kre", "Kae"}) {
        keys.push_back({numbered(name, model.edge_order, i), Dimension::force_per_width});
      }
    }
    return keys;
  }
  for (const char* component : {"t", "r", "l"}) {
    // The sources measured the lateral force in one direction only.
    if (model.directional && *component != 'l') {
      keys_of_one(model, component, "_0", keys);
      keys_of_one(model, component, "_90", keys);
    } else {
      keys_of_one(model, component, "", keys);
    }
  }
  return keys;
}

CuttingLaw law_of(const ForceModel& model, const VectorXd& values, const cutting::ChipRange& range,
                  double inclination) {
  CuttingLaw law;
  if (is_linear(model)) {
    law = linear_in_coefficients(model, values, range);
  } else {
    const double* value = values.data();
    const auto directional = [&] {
      DirectionalLaw one{law_of_one(model, value, range), {}};
      if (model.directional) one.at_90 = law_of_one(model, value, range);
      return one;
    };
    law.tangential = directional();
    law.radial = directional();
    law.lateral = DirectionalLaw{law_of_one(model, value, range), {}};
    if (!model.directional) law.orientation = cutting::OrientationCriterion::none;
  }
  law.lateral_inclination = inclination;
  return law;
}

VectorXd mean_forces(const CuttingLaw& law, const std::vector<Experiment>& experiments) {
  VectorXd forces(3 * static_cast<Index>(experiments.size()));
  for (std::size_t i = 0; i < experiments.size(); ++i) {
    const Experiment& one = experiments[i];
    forces.segment<3>(3 * static_cast<Index>(i)) =
        cutting::mean_load(one.cutter, law, one.condition, one.immersion).force;
  }
  return forces;
}

VectorXd measured_forces(const std::vector<Experiment>& experiments) {
  VectorXd forces(3 * static_cast<Index>(experiments.size()));
  for (std::size_t i = 0; i < experiments.size(); ++i) {
    forces.segment<3>(3 * static_cast<Index>(i)) = experiments[i].mean_force;
  }
  return forces;
}

MatrixXd sensitivities(const ForceModel& model, const VectorXd& values,
                       const std::vector<Experiment>& experiments) {
  if (!is_linear(model)) {
    return numerics::central_differences(
        [&](const VectorXd& x) { return mean_forces(law_of(model, x), experiments); }, values);
  }
  const Index count = static_cast<Index>(coefficients_of(model).size());
  MatrixXd columns(3 * static_cast<Index>(experiments.size()), count);
  for (Index i = 0; i < count; ++i) {
    columns.col(i) = mean_forces(law_of(model, VectorXd::Unit(count, i)), experiments);
  }
  return columns;
}

VectorXd starting_values(const ForceModel& model, const std::vector<Experiment>& experiments) {
  const std::vector<CoefficientKey> keys = coefficients_of(model);
  const VectorXd measured = measured_forces(experiments);
  VectorXd best(static_cast<Index>(keys.size()));
  double least = kInfinity;
  for (const double n : {0.1, 0.25, 0.5, 0.75, 1.0}) {
    // With its exponent given the power law is linear in K.
    MatrixXd columns(measured.size(), 3);
    for (int component = 0; component < 3; ++component) {
      const auto unit = [&](int of) { return cutting::PowerLaw{of == component ? 1.0 : 0.0, n}; };
      const CuttingLaw law{{unit(0), {}},
                           {unit(1), {}},
                           DirectionalLaw{unit(2), {}},
                           cutting::OrientationCriterion::none};
      columns.col(component) = mean_forces(law, experiments);
    }
    VectorXd k = columns.colPivHouseholderQr().solve(measured);
    // A component that would be negative begins small.
    k = k.cwiseMax(1e-2 * k.cwiseAbs().maxCoeff());
    const double misfit = (columns * k - measured).squaredNorm();
    if (misfit >= least) continue;
    least = misfit;
    Index at = 0;
    for (int component = 0; component < 3; ++component) {
      const int copies = model.directional && component < 2 ? 2 : 1;
      for (int copy = 0; copy < copies; ++copy) {
        if (model.form == LawForm::log) {
          // F = K h^n with h in mm: log10 of h in µm is that in mm plus 3.
          best(at++) = std::log10(k(component) / units::n_per_mm) - 3.0 * n;
          best(at++) = n;
          best(at++) = -0.02;
        } else {
          best(at++) = k(component);
          best(at++) = n;
          if (model.edge_force) best(at++) = 0.1 * k(component) * std::pow(1e-3, n);
        }
      }
    }
  }
  return best;
}

cutting::ChipRange chip_range(const std::vector<Experiment>& experiments) {
  cutting::ChipRange range{kInfinity, 0.0};
  for (const Experiment& one : experiments) {
    const double chip = cutting::largest_chip(one.cutter, one.condition, one.immersion);
    range.low = std::min(range.low, chip);
    range.high = std::max(range.high, chip);
  }
  return range;
}

double largest_kappa(const std::vector<Experiment>& experiments) {
  double largest = 0.0;
  for (const Experiment& one : experiments) {
    largest =
        std::max(largest, cutting::axial_position_angle(one.cutter, one.immersion.axial_depth));
  }
  return largest;
}

double common_inclination(const std::vector<Experiment>& experiments) {
  const double helix = experiments.empty() ? 0.0 : experiments.front().cutter.helix_angle;
  const bool shared = std::all_of(experiments.begin(), experiments.end(), [&](const auto& one) {
    return one.cutter.shape == cutting::CutterShape::cylindrical && one.cutter.helix_angle == helix;
  });
  return shared ? helix : 0.0;
}

}  // namespace osteomill::identify
