// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/cutting/edge_sum.hpp"

#include <cmath>
#include <span>

namespace osteomill::cutting {

using geometry::Vector3;

EdgeSum::EdgeSum(const CuttingLaw& law, const Vector3& fibre)
    : law_(law), batch_(law), fibre_(fibre) {}

void EdgeSum::at(const ProfilePoint& point) {
  if (!rows_.empty() && rows_.back().begin == h_.size()) rows_.pop_back();
  rows_.push_back({point, h_.size()});
}

/// Components of all elements. Laws that know the place on the cutter only through the inclination
/// in proportion are one batch; the others go row by row.
void EdgeSum::evaluate() {
  const std::size_t count = h_.size();
  along_.resize(count);
  tangential_.resize(count);
  radial_.resize(count);
  lateral_.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    along_[i] = elements_[i].cosine * fibre_.x() - elements_[i].sine * fibre_.y();
  }
  const auto batch = [&](std::size_t begin, std::size_t end, const ProfilePoint& point,
                         double inclination) {
    const auto part = [&](std::vector<double>& all) {
      return std::span<double>(all).subspan(begin, end - begin);
    };
    batch_(part(h_), part(along_), {point.kappa, point.stretch}, inclination, part(tangential_),
           part(radial_), part(lateral_));
  };
  if (batch_.vectorised()) {
    batch(0, count, rows_.front().point, law_.lateral_inclination);
    if (!law_.lateral || law_.lateral_inclination == 0.0) return;
  }
  for (std::size_t row = 0; row < rows_.size(); ++row) {
    const std::size_t end = row + 1 < rows_.size() ? rows_[row + 1].begin : count;
    const ProfilePoint& point = rows_[row].point;
    if (!batch_.vectorised()) {
      batch(rows_[row].begin, end, point, point.inclination);
      continue;
    }
    const double scale = point.inclination / law_.lateral_inclination;
    for (std::size_t i = rows_[row].begin; i < end; ++i) lateral_[i] *= scale;
  }
}

void EdgeSum::add_to(Load& load) {
  const std::size_t count = h_.size();
  if (count == 0) {
    rows_.clear();
    return;
  }
  const bool vectors = law_.orientation == OrientationCriterion::puw_hocheng;
  if (!vectors) evaluate();
  Vector3 force = Vector3::Zero();
  Vector3 moment = Vector3::Zero();
  for (std::size_t row = 0; row < rows_.size(); ++row) {
    const std::size_t end = row + 1 < rows_.size() ? rows_[row + 1].begin : count;
    const ProfilePoint& point = rows_[row].point;
    const double sin_kappa = std::sin(point.kappa);
    const double cos_kappa = std::cos(point.kappa);
    for (std::size_t i = rows_[row].begin; i < end; ++i) {
      const auto [s, c, width, width_z] = elements_[i];
      Vector3 f;
      if (vectors) {
        f = edge_force(law_, h_[i], fibre_, {c, -s, 0.0},
                       {sin_kappa * s, sin_kappa * c, -cos_kappa}, point);
      } else {
        const double inward = radial_[i] * sin_kappa + lateral_[i] * cos_kappa;
        f = Vector3(-tangential_[i] * c - inward * s, tangential_[i] * s - inward * c,
                    radial_[i] * cos_kappa - lateral_[i] * sin_kappa);
      }
      force += width * f;
      const double x = point.radius * s * width;
      const double y = point.radius * c * width;
      moment +=
          Vector3(y * f.z() - width_z * f.y(), width_z * f.x() - x * f.z(), x * f.y() - y * f.x());
    }
  }
  load.force += force;
  load.moment += moment;
  rows_.clear();
  elements_.clear();
  h_.clear();
}

}  // namespace osteomill::cutting
