// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/cutting/edge_sum.hpp"

#include <algorithm>
#include <cmath>
#include <span>

namespace osteomill::cutting {
namespace {

using geometry::Vector3;

/// A law in one direction to the fibres: what it is along them, or across.
CuttingLaw in_one_direction(CuttingLaw law, bool across) {
  const auto keep = [&](DirectionalLaw& one) {
    if (across && one.at_90) one.at_0 = *one.at_90;
    one.at_90.reset();
  };
  keep(law.tangential);
  keep(law.radial);
  if (law.lateral) keep(*law.lateral);
  law.orientation = OrientationCriterion::none;
  return law;
}

}  // namespace

EdgeSum::EdgeSum(const CuttingLaw& law, const Vector3& fibre) : law_(law), fibre_(fibre) {
  CuttingLaw lifted = law;
  lifted.minimum_chip = 0.0;
  if (law.orientation == OrientationCriterion::puw_hocheng) {
    batches_ = {ComponentBatch(in_one_direction(lifted, false)),
                ComponentBatch(in_one_direction(lifted, true))};
  } else {
    batches_ = {ComponentBatch(lifted)};
  }
  components_.resize(batches_.size());
}

void EdgeSum::at(const ProfilePoint& point, std::size_t load) {
  if (!rows_.empty() && rows_.back().begin == h_.size()) rows_.pop_back();
  rows_.push_back({point, h_.size(), load});
}

/// Components of all elements. Laws that know the place on the cutter only through the inclination
/// in proportion are one batch; the others go row by row.
void EdgeSum::evaluate(const ComponentBatch& batch, Components& out) {
  const std::size_t count = h_.size();
  out.tangential.resize(count);
  out.radial.resize(count);
  out.lateral.resize(count);
  const auto run = [&](std::size_t begin, std::size_t end, const ProfilePoint& point,
                       double inclination) {
    const auto part = [&](std::vector<double>& all) {
      return std::span<double>(all).subspan(begin, end - begin);
    };
    batch(part(h_), part(along_), {point.kappa, point.stretch}, inclination, part(out.tangential),
          part(out.radial), part(out.lateral));
  };
  if (batch.vectorised()) {
    run(0, count, rows_.front().point, law_.lateral_inclination);
    if (!law_.lateral || law_.lateral_inclination == 0.0) return;
  }
  for (std::size_t row = 0; row < rows_.size(); ++row) {
    const std::size_t end = row + 1 < rows_.size() ? rows_[row + 1].begin : count;
    const ProfilePoint& point = rows_[row].point;
    if (!batch.vectorised()) {
      run(rows_[row].begin, end, point, point.inclination);
      continue;
    }
    const double scale = point.inclination / law_.lateral_inclination;
    for (std::size_t i = rows_[row].begin; i < end; ++i) out.lateral[i] *= scale;
  }
}

/// Per width, N/m: see edge_force() for the signs, OrientationCriterion for Puw-Hocheng.
Vector3 EdgeSum::force(std::size_t i, double sin_kappa, double cos_kappa) const {
  const double s = elements_[i].sine;
  const double c = elements_[i].cosine;
  const Components& along = components_.front();
  if (batches_.size() == 1) {
    const double inward = along.radial[i] * sin_kappa + along.lateral[i] * cos_kappa;
    return {-along.tangential[i] * c - inward * s, along.tangential[i] * s - inward * c,
            along.radial[i] * cos_kappa - along.lateral[i] * sin_kappa};
  }
  const Components& across = components_.back();
  const Vector3 t(c, -s, 0.0);
  const Vector3 n(sin_kappa * s, sin_kappa * c, -cos_kappa);
  const Vector3 t_along = along_[i] * fibre_;
  const Vector3 n_along = n.dot(fibre_) * fibre_;
  const double lateral =
      law_.lateral && law_.lateral->at_90
          ? hankinson(along.lateral[i], across.lateral[i], along_[i], law_.orientation_exponent)
          : along.lateral[i];
  return -along.tangential[i] * t_along - across.tangential[i] * (t - t_along) -
         across.radial[i] * n_along - along.radial[i] * (n - n_along) - lateral * t.cross(n);
}

void EdgeSum::add_to(std::span<Load> loads) {
  const std::size_t count = h_.size();
  if (count == 0) {
    rows_.clear();
    return;
  }
  along_.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    along_[i] = elements_[i].cosine * fibre_.x() - elements_[i].sine * fibre_.y();
  }
  if (law_.minimum_chip > 0.0) {
    // An edge that ploughs takes its share of the force of the least chip.
    for (std::size_t i = 0; i < count; ++i) {
      const double share = std::min(1.0, h_[i] / law_.minimum_chip);
      elements_[i].width *= share;
      elements_[i].width_z *= share;
      h_[i] = std::max(h_[i], law_.minimum_chip);
    }
  }
  for (std::size_t i = 0; i < batches_.size(); ++i) evaluate(batches_[i], components_[i]);
  for (std::size_t row = 0; row < rows_.size(); ++row) {
    const std::size_t end = row + 1 < rows_.size() ? rows_[row + 1].begin : count;
    const ProfilePoint& point = rows_[row].point;
    const double sin_kappa = std::sin(point.kappa);
    const double cos_kappa = std::cos(point.kappa);
    Vector3 whole = Vector3::Zero();
    Vector3 moment = Vector3::Zero();
    for (std::size_t i = rows_[row].begin; i < end; ++i) {
      const Vector3 f = force(i, sin_kappa, cos_kappa);
      const auto [s, c, width, width_z] = elements_[i];
      whole += width * f;
      const double x = point.radius * s * width;
      const double y = point.radius * c * width;
      moment +=
          Vector3(y * f.z() - width_z * f.y(), width_z * f.x() - x * f.z(), x * f.y() - y * f.x());
    }
    loads[rows_[row].load].force += whole;
    loads[rows_[row].load].moment += moment;
  }
  rows_.clear();
  elements_.clear();
  h_.clear();
}

}  // namespace osteomill::cutting
