// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/vibration/beam_elements.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "osteomill/base/error.hpp"

namespace osteomill::vibration {
namespace {

constexpr int kGyroscopicModes = 24;  // enough for the dozen lowest whirls to six digits

/// Deflection in an element for (w₁, θ₁, w₂, θ₂) at s = x/l; phi = 0 gives the cubic Hermite set.
Eigen::RowVector4d deflection(double s, double l, double phi) {
  const double mu = 1.0 / (1.0 + phi);
  return mu * Eigen::RowVector4d(1.0 - 3.0 * s * s + 2.0 * s * s * s + phi * (1.0 - s),
                                 l * (s - 2.0 * s * s + s * s * s + 0.5 * phi * (s - s * s)),
                                 3.0 * s * s - 2.0 * s * s * s + phi * s,
                                 l * (-s * s + s * s * s + 0.5 * phi * (s * s - s)));
}

/// Rotation of the cross-section.
Eigen::RowVector4d rotation(double s, double l, double phi) {
  const double mu = 1.0 / (1.0 + phi);
  return mu * Eigen::RowVector4d(6.0 / l * (s * s - s),
                                 3.0 * s * s - 4.0 * s + 1.0 + phi * (1.0 - s),
                                 -6.0 / l * (s * s - s), 3.0 * s * s - 2.0 * s + phi * s);
}

/// Its derivative along the beam: the curvature.
Eigen::RowVector4d curvature(double s, double l, double phi) {
  const double mu = 1.0 / (1.0 + phi);
  return mu / l *
         Eigen::RowVector4d(6.0 / l * (2.0 * s - 1.0), 6.0 * s - 4.0 - phi,
                            -6.0 / l * (2.0 * s - 1.0), 6.0 * s - 2.0 + phi);
}

// Four Gauss points integrate degree 7 exactly; the mass terms have degree 6.
constexpr std::array<double, 4> kPoints = {0.06943184420297371, 0.33000947820757187,
                                           0.66999052179242813, 0.93056815579702629};
constexpr std::array<double, 4> kWeights = {0.17392742256872693, 0.32607257743127307,
                                            0.32607257743127307, 0.17392742256872693};

std::vector<double> mesh_nodes(const Beam& beam, const ElementOptions& options) {
  const double end = length(beam);
  std::vector<double> nodes;
  if (options.mesh == Mesh::equal) {
    for (int i = 0; i <= options.elements; ++i) nodes.push_back(end * i / options.elements);
    return nodes;
  }
  const std::vector<double> places = stations(beam);
  nodes.push_back(0.0);
  for (std::size_t i = 0; i + 1 < places.size(); ++i) {
    const double gap = places[i + 1] - places[i];
    const int parts = std::max(1, static_cast<int>(std::lround(options.elements * gap / end)));
    for (int k = 1; k <= parts; ++k) nodes.push_back(places[i] + gap * k / parts);
  }
  return nodes;
}

std::size_t element_of(const std::vector<double>& nodes, double x) {
  std::size_t e = 0;
  while (e + 2 < nodes.size() && x >= nodes[e + 1]) ++e;
  return e;
}

}  // namespace

BeamModel::BeamModel(const Beam& beam, const ElementOptions& options) {
  check(beam);
  require_within("options.elements", options.elements, 2.0, 400.0, "");
  nodes_ = mesh_nodes(beam, options);
  const Eigen::Index n = 2 * static_cast<Eigen::Index>(nodes_.size());
  Eigen::MatrixXd k = Eigen::MatrixXd::Zero(n, n), m = k, g = k;
  const bool stout = options.theory == BeamTheory::timoshenko;
  const std::vector<double> places = stations(beam);
  for (std::size_t e = 0; e + 1 < nodes_.size(); ++e) {
    const double l = nodes_[e + 1] - nodes_[e];
    // Steps of the section inside an element (equal mesh) are integrated piece by piece.
    std::vector<double> cuts{nodes_[e]};
    for (const double place : places) {
      if (place > nodes_[e] + 1e-9 * l && place < nodes_[e + 1] - 1e-9 * l) cuts.push_back(place);
    }
    cuts.push_back(nodes_[e + 1]);
    const Section middle = section_at(beam, nodes_[e] + 0.5 * l);
    const double phi =
        stout ? 12.0 * middle.bending_stiffness / (middle.shear_stiffness * l * l) : 0.0;
    shear_.push_back(phi);
    Eigen::Matrix4d ke = Eigen::Matrix4d::Zero(), me = ke, ge = ke;
    for (std::size_t c = 0; c + 1 < cuts.size(); ++c) {
      const Section s = section_at(beam, 0.5 * (cuts[c] + cuts[c + 1]));
      for (std::size_t q = 0; q < kPoints.size(); ++q) {
        const double x = cuts[c] + kPoints[q] * (cuts[c + 1] - cuts[c]);
        const double weight = kWeights[q] * (cuts[c + 1] - cuts[c]);
        const double t = (x - nodes_[e]) / l;
        const Eigen::RowVector4d w = deflection(t, l, phi), r = rotation(t, l, phi);
        const Eigen::RowVector4d b = curvature(t, l, phi);
        ke += weight * s.bending_stiffness * b.transpose() * b;
        if (stout) {
          // Shear strain w' − θ is constant along the element.
          const double mu = phi / (1.0 + phi);
          const Eigen::RowVector4d strain = mu * Eigen::RowVector4d(-1.0 / l, -0.5, 1.0 / l, -0.5);
          ke += weight * s.shear_stiffness * strain.transpose() * strain;
          me += weight * s.rotary_inertia * r.transpose() * r;
        }
        me += weight * s.mass_per_length * w.transpose() * w;
        ge += weight * 2.0 * s.rotary_inertia * r.transpose() * r;
      }
    }
    const Eigen::Index at = 2 * static_cast<Eigen::Index>(e);
    k.block<4, 4>(at, at) += ke;
    m.block<4, 4>(at, at) += me;
    g.block<4, 4>(at, at) += ge;
  }

  // Supports: springs add stiffness, pins and clamps are linear conditions on the freedoms.
  std::vector<Eigen::VectorXd> conditions;
  for (const Support& support : beam.supports) {
    const std::size_t e = element_of(nodes_, support.position);
    const double l = nodes_[e + 1] - nodes_[e];
    const double t = (support.position - nodes_[e]) / l;
    Eigen::VectorXd w = Eigen::VectorXd::Zero(n), r = w;
    w.segment<4>(2 * static_cast<Eigen::Index>(e)) = deflection(t, l, shear_[e]).transpose();
    r.segment<4>(2 * static_cast<Eigen::Index>(e)) = rotation(t, l, shear_[e]).transpose();
    if (support.type == SupportType::spring) {
      k += support.stiffness * w * w.transpose();
      k += support.rotational_stiffness * r * r.transpose();
    } else {
      conditions.push_back(w.normalized());
      if (support.type == SupportType::clamp) conditions.push_back(r.normalized());
    }
  }
  Eigen::MatrixXd free = Eigen::MatrixXd::Identity(n, n);
  if (!conditions.empty()) {
    Eigen::MatrixXd c(n, static_cast<Eigen::Index>(conditions.size()));
    for (std::size_t i = 0; i < conditions.size(); ++i) {
      c.col(static_cast<Eigen::Index>(i)) = conditions[i];
    }
    const Eigen::MatrixXd q = Eigen::HouseholderQR<Eigen::MatrixXd>(c).householderQ();
    free = q.rightCols(n - c.cols());
  }
  // Lengths and slopes differ by the element size: scaling by the diagonal keeps the digits.
  const Eigen::MatrixXd stiffness = free.transpose() * k * free;
  const Eigen::MatrixXd mass = free.transpose() * m * free;
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> solver(stiffness, mass);
  if (solver.info() != Eigen::Success) throw NoSolution("the beam's eigenvalues did not converge");
  const Eigen::MatrixXd vectors = free * solver.eigenvectors();
  for (Eigen::Index i = 0; i < vectors.cols(); ++i) {
    frequencies_hz_.push_back(std::sqrt(std::max(0.0, solver.eigenvalues()[i])) /
                              (2.0 * std::numbers::pi));
    vectors_.emplace_back(vectors.col(i).data(), vectors.col(i).data() + n);
  }
  const Eigen::Index few = std::min<Eigen::Index>(kGyroscopicModes, vectors.cols());
  const Eigen::MatrixXd reduced = vectors.leftCols(few).transpose() * g * vectors.leftCols(few);
  for (Eigen::Index i = 0; i < few; ++i) {
    gyroscopic_.emplace_back(reduced.col(i).data(), reduced.col(i).data() + few);
  }
}

double BeamModel::normalised_deflection(int mode, double x) const {
  const std::size_t e = element_of(nodes_, x);
  const double l = nodes_[e + 1] - nodes_[e];
  const std::vector<double>& v = vectors_[static_cast<std::size_t>(mode)];
  const Eigen::Map<const Eigen::Vector4d> ends(v.data() + 2 * e);
  return deflection((x - nodes_[e]) / l, l, shear_[e]).dot(ends);
}

std::vector<double> BeamModel::shape(int mode, const std::vector<double>& positions) const {
  std::vector<double> values;
  double largest = 0.0;
  for (const double x : positions) {
    values.push_back(normalised_deflection(mode, x));
    if (std::abs(values.back()) > std::abs(largest)) largest = values.back();
  }
  if (largest != 0.0) {
    for (double& value : values) value /= largest;
  }
  return values;
}

double BeamModel::static_compliance(double at, double force_at) const {
  // The modes of the model are complete, so their sum is the inverse of its stiffness.
  double sum = 0.0;
  for (int i = 0; i < modes(); ++i) {
    const double omega = 2.0 * std::numbers::pi * frequencies_hz_[static_cast<std::size_t>(i)];
    sum += normalised_deflection(i, at) * normalised_deflection(i, force_at) / (omega * omega);
  }
  return sum;
}

std::vector<double> BeamModel::whirl_frequencies_hz(double spindle_speed, int count) const {
  const Eigen::Index few = static_cast<Eigen::Index>(gyroscopic_.size());
  require_within("options.modes", count, 1.0, static_cast<double>(few), "");
  // z = φ e^{iωt} in modal coordinates: (Λ + Ωω G − ω²) φ = 0. With φ₁ = Λ^{1/2} φ, φ₂ = ω φ it is
  // the symmetric problem [0 Λ^{1/2}; Λ^{1/2} ΩG] whose eigenvalues are the ± whirls.
  Eigen::MatrixXd a = Eigen::MatrixXd::Zero(2 * few, 2 * few);
  for (Eigen::Index i = 0; i < few; ++i) {
    const double omega = 2.0 * std::numbers::pi * frequencies_hz_[static_cast<std::size_t>(i)];
    a(i, few + i) = a(few + i, i) = omega;
    for (Eigen::Index j = 0; j < few; ++j) {
      a(few + i, few + j) =
          spindle_speed * gyroscopic_[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)];
    }
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(a, Eigen::EigenvaluesOnly);
  std::vector<double> whirls;
  for (Eigen::Index i = 0; i < 2 * few; ++i) {
    whirls.push_back(std::abs(solver.eigenvalues()[i]) / (2.0 * std::numbers::pi));
  }
  std::sort(whirls.begin(), whirls.end());
  whirls.resize(static_cast<std::size_t>(count));
  return whirls;
}

std::vector<Mode> tip_modes(const BeamModel& model, double tip, int count, double damping_ratio,
                            double direction_x, double direction_y) {
  std::vector<Mode> modes;
  for (int i = 0; i < std::min(count, model.modes()); ++i) {
    const double deflection = model.normalised_deflection(i, tip);
    modes.push_back({.frequency_hz = model.natural_frequencies_hz()[static_cast<std::size_t>(i)],
                     .damping_ratio = damping_ratio,
                     .modal_mass = 1.0 / (deflection * deflection),
                     .direction_x = direction_x,
                     .direction_y = direction_y});
  }
  return modes;
}

}  // namespace osteomill::vibration
