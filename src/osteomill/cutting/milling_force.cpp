// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/cutting/milling_force.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "osteomill/numerics/quadrature.hpp"

namespace osteomill::cutting {
namespace {

using geometry::Vector3;
constexpr double kPi = std::numbers::pi;
constexpr double kTurn = 2.0 * std::numbers::pi;

/// Each component of the motion meets its own law: see OrientationCriterion::puw_hocheng.
Vector3 puw_hocheng(const CuttingLaw& law, const Chip& chip, const ProfilePoint& point,
                    const EdgePlace& place, const Vector3& fibre, const Vector3& t,
                    const Vector3& n) {
  const auto across = [&](const DirectionalLaw& one) {
    return force_per_width(one.at_90 ? *one.at_90 : one.at_0, chip, place);
  };
  const Vector3 t_along = t.dot(fibre) * fibre;
  const Vector3 n_along = n.dot(fibre) * fibre;
  Vector3 force = -force_per_width(law.tangential.at_0, chip, place) * t_along -
                  across(law.tangential) * (t - t_along) - across(law.radial) * n_along -
                  force_per_width(law.radial.at_0, chip, place) * (n - n_along);
  if (law.lateral) {
    CuttingLaw lateral_only = law;
    lateral_only.orientation = OrientationCriterion::hankinson;
    const double f_l =
        components(lateral_only, chip, t.dot(fibre), place, point.inclination).lateral;
    force -= f_l * t.cross(n);
  }
  return force;
}

/// Arcs of rotation angle in (-pi/2, 3 pi/2) where the envelope moves into the bone of a band.
struct Arcs {
  std::array<std::array<double, 2>, 4> ends{};
  int count = 0;
  void add(double from, double to) {
    if (to > from) ends[static_cast<std::size_t>(count++)] = {from, to};
  }
};

Arcs contact_arcs(const ProfilePoint& point, const Condition& condition, const LateralBand& band) {
  Arcs arcs;
  // n · f > 0: sin kappa sin theta cos elevation > cos kappa sin elevation.
  const double horizontal = std::sin(point.kappa) * std::cos(condition.feed_elevation);
  const double vertical = std::cos(point.kappa) * std::sin(condition.feed_elevation);
  if (horizontal < 1e-12) {
    // Straight up or down: all around or not at all.
    if (vertical >= 0.0) return arcs;
  } else if (vertical >= horizontal) {
    return arcs;
  }
  const double rise =
      horizontal < 1e-12 || vertical <= -horizontal ? -kPi / 2.0 : std::asin(vertical / horizontal);
  // The band holds r cos theta in low ... high on theta in 0 ... pi, and mirrored on -pi ... 0.
  const double from = std::acos(std::clamp(band.high / point.radius, -1.0, 1.0));
  const double to = std::acos(std::clamp(band.low / point.radius, -1.0, 1.0));
  arcs.add(std::max(from, rise), std::min(to, kPi - rise));
  if (rise < 0.0) {
    arcs.add(std::max(-to, rise), std::min(-from, kPi - rise));
    arcs.add(std::max(kTurn - to, rise), std::min(kTurn - from, kPi - rise));
  }
  return arcs;
}

/// How deep inside the contact a place is, in lengths of no meaning; > 0 in contact.
double contact_margin(const ProfilePoint& point, double theta, const Condition& condition,
                      const LateralBand& band, double radius) {
  const double into = outward_normal(theta, point.kappa).dot(feed_direction(condition));
  const double y = point.radius * std::cos(theta) / radius;
  // A slot's band ends where the cutter does and must not cut off its sides.
  const double inside = std::min(band.low <= -radius ? 2.0 : y - band.low / radius,
                                 band.high >= radius ? 2.0 : band.high / radius - y);
  return std::min(into, inside);
}

Load load_at(const CuttingLaw& law, const Condition& condition, double theta,
             const ProfilePoint& point, double weight) {
  Load load;
  load.force = weight * edge_force(law, condition, theta, point);
  const Vector3 place(point.radius * std::sin(theta), point.radius * std::cos(theta), point.z);
  load.moment = place.cross(load.force);
  return load;
}

/// Lengths along the meridian, from the tip to the axial depth, between which entry and exit vary
/// smoothly: ends of the round part, where the band begins to be reached, where the normal turns
/// away from the feed, and where these two meet.
std::vector<double> meridian_pieces(const Cutter& cutter, const Condition& condition,
                                    const LateralBand& bone, double axial_depth) {
  const double whole = meridian_length(cutter, axial_depth);
  std::vector<double> ends{0.0, whole};
  if (cutter.shape == CutterShape::ball) {
    const double sin_e = std::sin(condition.feed_elevation);
    const auto add = [&](double sin_kappa) {
      if (sin_kappa > 0.0 && sin_kappa <= 1.0) ends.push_back(cutter.radius * std::asin(sin_kappa));
    };
    add(1.0);
    add(std::abs(sin_e));
    for (const double edge : {bone.low, bone.high}) {
      const double y = edge / cutter.radius;
      add(std::abs(y));
      // r cos theta = edge and n · f = 0 together.
      add(std::sqrt(y * y * (1.0 - sin_e * sin_e) + sin_e * sin_e));
    }
  }
  std::sort(ends.begin(), ends.end());
  ends.erase(std::unique(ends.begin(), ends.end(),
                         [&](double one, double two) { return two - one < 1e-12 * whole; }),
             ends.end());
  while (ends.back() > whole) ends.pop_back();
  if (ends.back() < whole) ends.push_back(whole);
  return ends;
}

/// Visits quadrature nodes of the engaged envelope: visit(point, theta, ds dtheta).
template <class Visitor>
void for_each_node(const Cutter& cutter, const Condition& condition, const Immersion& immersion,
                   Visitor visit) {
  static const numerics::QuadratureRule gathered = numerics::gauss_legendre_gathered(24);
  static const numerics::QuadratureRule two = numerics::gauss_legendre(2);
  const LateralBand bone = band(immersion, cutter);
  const std::vector<double> ends = meridian_pieces(cutter, condition, bone, immersion.axial_depth);
  for (std::size_t piece = 0; piece + 1 < ends.size(); ++piece) {
    const double length = ends[piece + 1] - ends[piece];
    // Along a cylinder the load is constant and the moment linear: two nodes are exact.
    const bool straight = profile_at(cutter, ends[piece]).kappa == kPi / 2.0;
    const numerics::QuadratureRule& rule = straight ? two : gathered;
    for (std::size_t i = 0; i < rule.nodes.size(); ++i) {
      const ProfilePoint point = profile_at(cutter, ends[piece] + length * rule.nodes[i]);
      const Arcs arcs = contact_arcs(point, condition, bone);
      for (int arc = 0; arc < arcs.count; ++arc) {
        const auto [start, end] = arcs.ends[static_cast<std::size_t>(arc)];
        for (std::size_t k = 0; k < gathered.nodes.size(); ++k) {
          visit(point, start + (end - start) * gathered.nodes[k],
                length * rule.weights[i] * (end - start) * gathered.weights[k]);
        }
      }
    }
  }
}

}  // namespace

double Load::bending_moment(double height) const {
  const Vector3 there = moment - Vector3(0.0, 0.0, height).cross(force);
  return std::hypot(there.x(), there.y());
}

Load& Load::operator+=(const Load& other) {
  force += other.force;
  moment += other.moment;
  return *this;
}

Vector3 motion(double theta) { return {std::cos(theta), -std::sin(theta), 0.0}; }

Vector3 outward_normal(double theta, double kappa) {
  return {std::sin(kappa) * std::sin(theta), std::sin(kappa) * std::cos(theta), -std::cos(kappa)};
}

double chip_thickness(const Condition& condition, double theta, double kappa) {
  return condition.feed_per_tooth *
         std::max(0.0, outward_normal(theta, kappa).dot(feed_direction(condition)));
}

Vector3 edge_force(const CuttingLaw& law, double h, const Vector3& fibre, const Vector3& t,
                   const Vector3& n, const ProfilePoint& point) {
  const Chip chip(h);
  const EdgePlace place{point.kappa, point.stretch};
  if (law.orientation == OrientationCriterion::puw_hocheng) {
    return puw_hocheng(law, chip, point, place, fibre, t, n);
  }
  const EdgeComponents f = components(law, chip, t.dot(fibre), place, point.inclination);
  return -f.tangential * t - f.radial * n - f.lateral * t.cross(n);
}

Vector3 edge_force(const CuttingLaw& law, const Condition& condition, double theta,
                   const ProfilePoint& point) {
  return edge_force(law, chip_thickness(condition, theta, point.kappa), condition.fibre_T,
                    motion(theta), outward_normal(theta, point.kappa), point);
}

Load mean_load(const Cutter& cutter, const CuttingLaw& law, const Condition& condition,
               const Immersion& immersion) {
  Load mean;
  const double share = cutter.flutes / kTurn;
  for_each_node(cutter, condition, immersion,
                [&](const ProfilePoint& point, double theta, double weight) {
                  mean += load_at(law, condition, theta, point, share * weight);
                });
  return mean;
}

double removal_rate(const Cutter& cutter, const Condition& condition, const Immersion& immersion) {
  double area = 0.0;
  for_each_node(cutter, condition, immersion,
                [&](const ProfilePoint& point, double theta, double weight) {
                  area += weight * point.radius *
                          outward_normal(theta, point.kappa).dot(feed_direction(condition));
                });
  return area * feed_rate(condition, cutter.flutes);
}

double largest_chip(const Cutter& cutter, const Condition& condition, const Immersion& immersion) {
  const LateralBand bone = band(immersion, cutter);
  const std::vector<double> ends = meridian_pieces(cutter, condition, bone, immersion.axial_depth);
  double largest = 0.0;
  const auto look = [&](double s) {
    const ProfilePoint point = profile_at(cutter, s);
    const Arcs arcs = contact_arcs(point, condition, bone);
    for (int arc = 0; arc < arcs.count; ++arc) {
      // The chip grows towards a quarter turn from either side.
      const auto [start, end] = arcs.ends[static_cast<std::size_t>(arc)];
      const double theta = std::clamp(0.5 * kPi, start, end);
      largest = std::max(largest, chip_thickness(condition, theta, point.kappa));
    }
  };
  for (std::size_t piece = 0; piece + 1 < ends.size(); ++piece) {
    for (int i = 0; i <= 32; ++i) look(ends[piece] + (ends[piece + 1] - ends[piece]) * i / 32);
  }
  return largest;
}

Revolution revolution(const Cutter& cutter, const CuttingLaw& law, const Condition& condition,
                      const Immersion& immersion, int steps) {
  static const numerics::QuadratureRule rule = numerics::gauss_legendre(3);
  const LateralBand bone = band(immersion, cutter);
  // Panels along the edge: ends of the smooth pieces, and one every 3 degrees of lag or kappa.
  std::vector<double> panels;
  const std::vector<double> ends = meridian_pieces(cutter, condition, bone, immersion.axial_depth);
  for (std::size_t piece = 0; piece + 1 < ends.size(); ++piece) {
    const ProfilePoint low = profile_at(cutter, ends[piece]);
    const ProfilePoint high = profile_at(cutter, ends[piece + 1]);
    const double turn = std::max(std::abs(high.lag - low.lag), high.kappa - low.kappa);
    const int count = std::max(1, static_cast<int>(std::ceil(turn * 60.0 / kPi)));
    for (int i = 0; i < count; ++i) {
      panels.push_back(ends[piece] + (ends[piece + 1] - ends[piece]) * i / count);
    }
  }
  panels.push_back(ends.back());

  Revolution result;
  for (int step = 0; step < steps; ++step) {
    const double angle = kTurn * step / steps;
    Load load;
    for (int flute = 0; flute < cutter.flutes; ++flute) {
      const double lead = angle - kTurn * flute / cutter.flutes;
      const auto margin = [&](double s) {
        const ProfilePoint point = profile_at(cutter, s);
        return contact_margin(point, lead - point.lag, condition, bone, cutter.radius);
      };
      const auto integrate = [&](double from, double to) {
        for (std::size_t i = 0; i < rule.nodes.size(); ++i) {
          const ProfilePoint point = profile_at(cutter, from + (to - from) * rule.nodes[i]);
          load += load_at(law, condition, lead - point.lag, point, (to - from) * rule.weights[i]);
        }
      };
      double from = 0.0;
      double margin_from = margin(from);
      for (std::size_t panel = 1; panel < panels.size(); ++panel) {
        const double to = panels[panel];
        const double margin_to = margin(to);
        if (margin_from > 0.0 && margin_to > 0.0) {
          integrate(from, to);
        } else if (margin_from > 0.0 || margin_to > 0.0) {
          double inside = margin_from > 0.0 ? from : to;
          double outside = margin_from > 0.0 ? to : from;
          for (int i = 0; i < 40; ++i) {
            const double middle = 0.5 * (inside + outside);
            (margin(middle) > 0.0 ? inside : outside) = middle;
          }
          margin_from > 0.0 ? integrate(from, inside) : integrate(inside, to);
        }
        from = to;
        margin_from = margin_to;
      }
    }
    result.angle.push_back(angle);
    result.loads.push_back(load);
  }
  return result;
}

}  // namespace osteomill::cutting
