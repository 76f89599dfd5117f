// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/cutting/milling_force.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "osteomill/cutting/contact.hpp"
#include "osteomill/cutting/edge_sum.hpp"
#include "osteomill/cutting/flutes.hpp"
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

/// Uncut chip thickness of a flute; the point moves into the bone there (n · f = into > 0).
double chip_of(const Cutter& cutter, const Flutes& flutes, int flute, const Condition& condition,
               double theta, const ProfilePoint& point, double into) {
  if (condition.path == ToothPath::trochoidal) {
    return std::sin(point.kappa) *
           std::max(0.0,
                    trochoidal_chip(point.radius, condition.feed_per_tooth, cutter.flutes, theta));
  }
  return flutes.chip(flute, point, condition.feed_per_tooth, into);
}

double into_bone(const Condition& condition, double theta, double kappa) {
  return std::max(0.0, outward_normal(theta, kappa).dot(feed_direction(condition)));
}

/// Visits the engaged envelope: begin(point) ... node(theta, ds dtheta) ... end(point) for each
/// quadrature point of the meridian.
template <class Node, class End>
void for_each_node(const Cutter& cutter, const Condition& condition, const Immersion& immersion,
                   Node node, End end) {
  static const numerics::QuadratureRule gathered = numerics::gauss_legendre_gathered(16);
  static const numerics::QuadratureRule two = numerics::gauss_legendre(2);
  const LateralBand bone = band(immersion, cutter);
  const Envelope envelope(cutter);
  const std::vector<double> ends = smooth_pieces(envelope, condition, bone, immersion.axial_depth);
  for (std::size_t piece = 0; piece + 1 < ends.size(); ++piece) {
    const double length = ends[piece + 1] - ends[piece];
    // Along a cylinder the load is constant and the moment linear: two nodes are exact, unless the
    // run-out or the lead changes along it.
    const bool linear = envelope.is_cylinder(ends[piece]) && cutter.run_out.offset == 0.0 &&
                        cutter.run_out.tilt == 0.0;
    const numerics::QuadratureRule& rule = linear ? two : gathered;
    for (std::size_t i = 0; i < rule.nodes.size(); ++i) {
      const ProfilePoint point = envelope.at(ends[piece] + length * rule.nodes[i]);
      const Arcs arcs = contact_arcs(point, condition, bone);
      for (int arc = 0; arc < arcs.count; ++arc) {
        const auto [start, stop] = arcs.ends[static_cast<std::size_t>(arc)];
        for (std::size_t k = 0; k < gathered.nodes.size(); ++k) {
          node(point, start + (stop - start) * gathered.nodes[k],
               length * rule.weights[i] * (stop - start) * gathered.weights[k]);
        }
      }
      end(point);
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
  if (law.orientation == OrientationCriterion::puw_hocheng && h < law.minimum_chip) {
    return h / law.minimum_chip * edge_force(law, law.minimum_chip, fibre, t, n, point);
  }
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

std::vector<Load> flute_means(const Cutter& cutter, const CuttingLaw& law,
                              const Condition& condition, const Immersion& immersion) {
  const Flutes flutes(cutter);
  // Equal flutes are worked out once.
  const int different = flutes.equal() ? 1 : flutes.count();
  std::vector<EdgeSum> sums(static_cast<std::size_t>(different), {law, condition.fibre_T});
  std::vector<Load> means(static_cast<std::size_t>(flutes.count()));
  for_each_node(
      cutter, condition, immersion,
      [&](const ProfilePoint& point, double theta, double weight) {
        const double into = into_bone(condition, theta, point.kappa);
        for (int flute = 0; flute < different; ++flute) {
          const double h = chip_of(cutter, flutes, flute, condition, theta, point, into);
          if (!flutes.equal() && h <= 0.0) continue;
          const double width = weight / kTurn;
          sums[static_cast<std::size_t>(flute)].push(std::sin(theta), std::cos(theta), h, width,
                                                     width * point.z);
        }
      },
      [&](const ProfilePoint& point) {
        for (std::size_t flute = 0; flute < sums.size(); ++flute) {
          sums[flute].add_to(means[flute], point);
        }
      });
  if (flutes.equal()) std::fill(means.begin(), means.end(), Load(means.front()));
  return means;
}

Load mean_load(const Cutter& cutter, const CuttingLaw& law, const Condition& condition,
               const Immersion& immersion) {
  Load mean;
  for (const Load& one : flute_means(cutter, law, condition, immersion)) mean += one;
  return mean;
}

double removal_rate(const Cutter& cutter, const Condition& condition, const Immersion& immersion) {
  double area = 0.0;
  for_each_node(
      cutter, condition, immersion,
      [&](const ProfilePoint& point, double theta, double weight) {
        area += weight * point.radius * into_bone(condition, theta, point.kappa);
      },
      [](const ProfilePoint&) {});
  return area * feed_rate(condition, cutter.flutes);
}

double largest_chip(const Cutter& cutter, const Condition& condition, const Immersion& immersion) {
  const Flutes flutes(cutter);
  const LateralBand bone = band(immersion, cutter);
  const Envelope envelope(cutter);
  const std::vector<double> ends = smooth_pieces(envelope, condition, bone, immersion.axial_depth);
  double largest = 0.0;
  const auto look = [&](double s) {
    const ProfilePoint point = envelope.at(s);
    const Arcs arcs = contact_arcs(point, condition, bone);
    for (int arc = 0; arc < arcs.count; ++arc) {
      // The chip grows towards a quarter turn from either side.
      const auto [start, end] = arcs.ends[static_cast<std::size_t>(arc)];
      const double theta = std::clamp(0.5 * kPi, start, end);
      const double into = into_bone(condition, theta, point.kappa);
      for (int flute = 0; flute < flutes.count(); ++flute) {
        largest = std::max(largest, chip_of(cutter, flutes, flute, condition, theta, point, into));
      }
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
  const Envelope envelope(cutter);
  const Flutes flutes(cutter);
  // Panels along the edge: ends of the smooth pieces, and one for every 3 degrees of lag,
  // of kappa, and of radius over full radius.
  std::vector<double> panels;
  const std::vector<double> ends = smooth_pieces(envelope, condition, bone, immersion.axial_depth);
  for (std::size_t piece = 0; piece + 1 < ends.size(); ++piece) {
    const double length = ends[piece + 1] - ends[piece];
    const ProfilePoint low = envelope.at(ends[piece]);
    const ProfilePoint high = envelope.at(ends[piece + 1] - 1e-12 * length);
    const double turn = std::abs(high.lag - low.lag) + (high.kappa - low.kappa) +
                        (high.radius - low.radius) / cutter.radius;
    const int count = std::max(1, static_cast<int>(std::ceil(turn * 60.0 / kPi)));
    for (int i = 0; i < count; ++i) panels.push_back(ends[piece] + length * i / count);
  }
  panels.push_back(ends.back());

  Revolution result;
  for (int step = 0; step < steps; ++step) {
    const double angle = kTurn * step / steps;
    Load load;
    for (int flute = 0; flute < flutes.count(); ++flute) {
      const double lead = angle - flutes.angle(flute);
      const auto margin = [&](double s) {
        const ProfilePoint point = envelope.at(s);
        return contact_margin(point, lead - point.lag, condition, bone, cutter.radius);
      };
      const auto integrate = [&](double from, double to) {
        for (std::size_t i = 0; i < rule.nodes.size(); ++i) {
          const ProfilePoint point = envelope.at(from + (to - from) * rule.nodes[i]);
          const double theta = lead - point.lag;
          const double into = into_bone(condition, theta, point.kappa);
          const double h = chip_of(cutter, flutes, flute, condition, theta, point, into);
          if (!flutes.equal() && h <= 0.0) continue;
          const Vector3 force = (to - from) * rule.weights[i] *
                                edge_force(law, h, condition.fibre_T, motion(theta),
                                           outward_normal(theta, point.kappa), point);
          const Vector3 place(point.radius * std::sin(theta), point.radius * std::cos(theta),
                              point.z);
          load += Load{force, place.cross(force)};
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
