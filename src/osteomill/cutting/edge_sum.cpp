// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/cutting/edge_sum.hpp"

#include <cmath>

namespace osteomill::cutting {

using geometry::Vector3;

EdgeSum::EdgeSum(const CuttingLaw& law, const Vector3& fibre)
    : law_(law), batch_(law), fibre_(fibre) {}

void EdgeSum::push(double sine, double cosine, double h, double width, double width_z) {
  sine_.push_back(sine);
  cosine_.push_back(cosine);
  h_.push_back(h);
  width_.push_back(width);
  width_z_.push_back(width_z);
}

void EdgeSum::add_to(Load& load, const ProfilePoint& point) {
  const std::size_t count = h_.size();
  const double sin_kappa = std::sin(point.kappa);
  const double cos_kappa = std::cos(point.kappa);
  const bool vectors = law_.orientation == OrientationCriterion::puw_hocheng;
  if (!vectors) {
    along_.resize(count);
    tangential_.resize(count);
    radial_.resize(count);
    lateral_.resize(count);
    for (std::size_t i = 0; i < count; ++i) {
      along_[i] = cosine_[i] * fibre_.x() - sine_[i] * fibre_.y();
    }
    batch_(h_, along_, {point.kappa, point.stretch}, point.inclination, tangential_, radial_,
           lateral_);
  }
  Vector3 force = Vector3::Zero();
  Vector3 moment = Vector3::Zero();
  for (std::size_t i = 0; i < count; ++i) {
    const double s = sine_[i];
    const double c = cosine_[i];
    Vector3 f;
    if (vectors) {
      f = edge_force(law_, h_[i], fibre_, {c, -s, 0.0}, {sin_kappa * s, sin_kappa * c, -cos_kappa},
                     point);
    } else {
      const double inward = radial_[i] * sin_kappa + lateral_[i] * cos_kappa;
      f = Vector3(-tangential_[i] * c - inward * s, tangential_[i] * s - inward * c,
                  radial_[i] * cos_kappa - lateral_[i] * sin_kappa);
    }
    force += width_[i] * f;
    const double x = point.radius * s * width_[i];
    const double y = point.radius * c * width_[i];
    moment += Vector3(y * f.z() - width_z_[i] * f.y(), width_z_[i] * f.x() - x * f.z(),
                      x * f.y() - y * f.x());
  }
  load.force += force;
  load.moment += moment;
  sine_.clear();
  cosine_.clear();
  h_.clear();
  width_.clear();
  width_z_.clear();
}

}  // namespace osteomill::cutting
