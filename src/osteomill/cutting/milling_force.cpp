// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/cutting/milling_force.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
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

/// Nodes along an arc of contact and along a piece of the meridian, coarse to fine.
struct Level {
  numerics::QuadratureRule arc, meridian;
};
const std::vector<Level>& levels() {
  using numerics::gauss_legendre_gathered;
  static const std::vector<Level> all = [] {
    std::vector<Level> made;
    for (const auto& [arc, meridian] :
         {std::pair{3, 2}, {4, 3}, {6, 5}, {9, 8}, {13, 12}, {20, 18}}) {
      made.push_back({gauss_legendre_gathered(arc), gauss_legendre_gathered(meridian)});
    }
    return made;
  }();
  return all;
}

/// Visits a piece of the engaged envelope: at(point), then arc(point, start, stop, weight) for each
/// arc of contact at each node of the meridian.
template <class At, class Arc>
void for_each_arc(const Envelope& envelope, const Condition& condition, const LateralBand& bone,
                  double from, double to, const numerics::QuadratureRule& meridian, At at,
                  Arc arc) {
  const double length = to - from;
  for (std::size_t i = 0; i < meridian.nodes.size(); ++i) {
    const ProfilePoint point = envelope.at(from + length * meridian.nodes[i]);
    at(point);
    const Arcs arcs = contact_arcs(point, condition, bone);
    for (int k = 0; k < arcs.count; ++k) {
      const auto [start, stop] = arcs.ends[static_cast<std::size_t>(k)];
      arc(point, start, stop, length * meridian.weights[i]);
    }
  }
}

/// The means of a nominal cut, piece by piece of the envelope.
class MeanIntegral {
 public:
  MeanIntegral(const Cutter& cutter, const CuttingLaw& law, const Condition& condition,
               const Immersion& immersion)
      : cutter_(cutter),
        condition_(condition),
        feed_(feed_direction(condition)),
        flutes_(cutter),
        bone_(band(immersion, cutter)),
        envelope_(cutter),
        ends_(smooth_pieces(envelope_, condition, bone_, immersion.axial_depth)),
        minimum_chip_(law.minimum_chip),
        // Equal flutes are worked out once.
        sums_(flutes_.equal() ? 1U : static_cast<std::size_t>(flutes_.count()),
              EdgeSum(law, condition.fibre_T)) {}

  std::size_t pieces() const { return ends_.size() - 1; }
  std::size_t different_flutes() const { return sums_.size(); }
  int flutes() const { return flutes_.count(); }

  /// Mean of each different flute over one piece.
  std::vector<Load> of(std::size_t piece, const Level& level) {
    static const numerics::QuadratureRule two = numerics::gauss_legendre(2);
    // Along a cylinder the load is constant and the moment linear: two nodes are exact, unless the
    // run-out or the lead changes along it.
    const bool linear = envelope_.is_cylinder(ends_[piece]) && cutter_.run_out.offset == 0.0 &&
                        cutter_.run_out.tilt == 0.0;
    for_each_arc(
        envelope_, condition_, bone_, ends_[piece], ends_[piece + 1], linear ? two : level.meridian,
        [&](const ProfilePoint& point) {
          sin_kappa_ = std::sin(point.kappa);
          horizontal_ = sin_kappa_ * feed_.x();
          vertical_ = -std::cos(point.kappa) * feed_.z();
          for (EdgeSum& sum : sums_) sum.at(point);
          if (!flutes_.equal()) {
            deviations_.clear();
            for (int flute = 0; flute < flutes_.count(); ++flute) {
              deviations_.push_back(flutes_.deviation(flute, point));
            }
          }
        },
        [&](const ProfilePoint& point, double start, double stop, double weight) {
          for (std::size_t flute = 0; flute < sums_.size(); ++flute) {
            push(flute, point, start, stop, weight, level.arc);
          }
        });
    std::vector<Load> means(sums_.size());
    for (std::size_t flute = 0; flute < sums_.size(); ++flute) sums_[flute].add_to(means[flute]);
    return means;
  }

 private:
  /// An arc of contact, in parts over which the chip and the law are smooth.
  void push(std::size_t flute, const ProfilePoint& point, double start, double stop, double weight,
            const numerics::QuadratureRule& rule) {
    pieces_.assign(1, {0.0, condition_.feed_per_tooth, 0.0});
    if (!flutes_.equal()) {
      flutes_.chip_pieces(static_cast<int>(flute), deviations_, sin_kappa_,
                          condition_.feed_per_tooth, pieces_);
    }
    for (std::size_t i = 0; i < pieces_.size(); ++i) {
      const Flutes::ChipPiece& piece = pieces_[i];
      const double end =
          i + 1 < pieces_.size() ? pieces_[i + 1].from : std::numeric_limits<double>::infinity();
      // Where the edge begins to lift a chip.
      const double lifts = minimum_chip_ > 0.0 ? (minimum_chip_ - piece.start) / piece.rise : 0.0;
      if (lifts > piece.from && lifts < end) {
        push_between(flute, point, piece, piece.from, lifts, start, stop, weight, rule);
        push_between(flute, point, piece, lifts, end, start, stop, weight, rule);
      } else {
        push_between(flute, point, piece, piece.from, end, start, stop, weight, rule);
      }
    }
  }

  /// The parts of an arc on which `into` lies between two values: on both sides of the top of
  /// n · f = horizontal sin theta + vertical.
  void push_between(std::size_t flute, const ProfilePoint& point, const Flutes::ChipPiece& piece,
                    double low, double high, double start, double stop, double weight,
                    const numerics::QuadratureRule& rule) {
    const auto part = [&](double from, double to) {
      push_smooth(flute, point, piece, std::max(from, start), std::min(to, stop), weight, rule);
    };
    if (low <= 0.0 && high == std::numeric_limits<double>::infinity()) return part(start, stop);
    if (horizontal_ < 1e-12) {  // a plunge: the same all around
      if (vertical_ >= low && vertical_ < high) part(start, stop);
      return;
    }
    const double from = (low - vertical_) / horizontal_;
    const double to = (high - vertical_) / horizontal_;
    if (from >= 1.0) return;
    const double rise = from <= -1.0 ? -0.5 * kPi : std::asin(from);
    if (to >= 1.0) return part(rise, kPi - rise);
    if (to <= -1.0) return;
    const double fall = std::asin(to);
    part(rise, fall);
    part(kPi - fall, kPi - rise);
  }

  void push_smooth(std::size_t flute, const ProfilePoint& point, const Flutes::ChipPiece& piece,
                   double start, double stop, double weight, const numerics::QuadratureRule& rule) {
    if (!(stop > start)) return;
    const bool trochoidal = condition_.path == ToothPath::trochoidal;
    const double scale = weight * (stop - start) / kTurn;
    for (std::size_t k = 0; k < rule.nodes.size(); ++k) {
      const double theta = start + (stop - start) * rule.nodes[k];
      const double sine = std::sin(theta);
      const double cosine = std::cos(theta);
      const double h = trochoidal
                           ? sin_kappa_ * trochoidal_chip(point.radius, condition_.feed_per_tooth,
                                                          cutter_.flutes, theta)
                           : piece.rise * (horizontal_ * sine + vertical_) + piece.start;
      const double width = scale * rule.weights[k];
      sums_[flute].push(sine, cosine, std::max(0.0, h), width, width * point.z);
    }
  }

  const Cutter& cutter_;
  const Condition& condition_;
  Vector3 feed_;
  Flutes flutes_;
  LateralBand bone_;
  Envelope envelope_;
  std::vector<double> ends_;
  double minimum_chip_;
  std::vector<EdgeSum> sums_;
  std::vector<double> deviations_;
  std::vector<Flutes::ChipPiece> pieces_;
  // Of the point at hand: n · f = horizontal sin theta + vertical.
  double sin_kappa_ = 0.0, horizontal_ = 0.0, vertical_ = 0.0;
};

Vector3 force_of(const std::vector<Load>& means) {
  Vector3 force = Vector3::Zero();
  for (const Load& mean : means) force += mean.force;
  return force;
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
                              const Condition& condition, const Immersion& immersion,
                              const MeanOptions& options) {
  MeanIntegral integral(cutter, law, condition, immersion);
  const std::size_t pieces = integral.pieces();
  std::vector<std::vector<Load>> parts;
  Vector3 whole = Vector3::Zero();
  for (std::size_t piece = 0; piece < pieces; ++piece) {
    parts.push_back(integral.of(piece, levels().front()));
    whole += force_of(parts.back());
  }
  // The change that a level brings is more than three times the error that it leaves down to errors
  // of 1e-3, where the infinite slopes at h = 0 begin to slow the levels, and more than the error
  // below (tested). The errors of pieces are of either sign.
  const double gain = options.tolerance >= 1e-3 ? 3.0 : 1.0;
  const double allowed =
      gain * options.tolerance * whole.norm() / std::sqrt(static_cast<double>(pieces));
  std::vector<Load> means(integral.different_flutes());
  for (std::size_t piece = 0; piece < pieces; ++piece) {
    for (std::size_t level = 1; level < levels().size(); ++level) {
      std::vector<Load> finer = integral.of(piece, levels()[level]);
      const double change = (force_of(finer) - force_of(parts[piece])).norm();
      parts[piece] = std::move(finer);
      if (change <= allowed) break;
    }
    for (std::size_t flute = 0; flute < means.size(); ++flute) means[flute] += parts[piece][flute];
  }
  means.resize(static_cast<std::size_t>(integral.flutes()), Load(means.front()));
  return means;
}

Load mean_load(const Cutter& cutter, const CuttingLaw& law, const Condition& condition,
               const Immersion& immersion, const MeanOptions& options) {
  Load mean;
  for (const Load& one : flute_means(cutter, law, condition, immersion, options)) mean += one;
  return mean;
}

double removal_rate(const Cutter& cutter, const Condition& condition, const Immersion& immersion) {
  const LateralBand bone = band(immersion, cutter);
  const Envelope envelope(cutter);
  const std::vector<double> ends = smooth_pieces(envelope, condition, bone, immersion.axial_depth);
  const Level& finest = levels().back();
  double area = 0.0;
  for (std::size_t piece = 0; piece + 1 < ends.size(); ++piece) {
    for_each_arc(
        envelope, condition, bone, ends[piece], ends[piece + 1], finest.meridian,
        [](const ProfilePoint&) {},
        [&](const ProfilePoint& point, double start, double stop, double weight) {
          // n · f = horizontal sin theta + vertical > 0 all along the arc.
          const Vector3 feed = feed_direction(condition);
          area += weight * point.radius *
                  (std::sin(point.kappa) * feed.x() * (std::cos(start) - std::cos(stop)) -
                   std::cos(point.kappa) * feed.z() * (stop - start));
        });
  }
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
