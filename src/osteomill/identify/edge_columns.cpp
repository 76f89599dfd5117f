// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/identify/edge_columns.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "osteomill/cutting/contact.hpp"
#include "osteomill/cutting/flutes.hpp"
#include "osteomill/numerics/quadrature.hpp"

namespace osteomill::identify {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kTurn = 2.0 * kPi;
/// Lag, kappa or relative radius that a panel spans: with three nodes the error of a smooth
/// integrand is of the sixth order, 1e-9 of it.
constexpr double kPanel = kPi / 18.0;
constexpr std::size_t kNodes = 3;
/// A chip this thin, m, has no force under a power or log law and a finite logarithm.
constexpr double kNoChip = 1e-18;
const double kLogMillimetre = std::log(1e-3);
const double kLogMicrometre = std::log(1e-6);

const numerics::QuadratureRule& rule() {
  static const numerics::QuadratureRule three = numerics::gauss_legendre(kNodes);
  return three;
}

/// What an edge element meets at one rotation angle.
struct Meeting {
  double sin_theta = 0.0;
  double cos_theta = 1.0;
  double into = 0.0;  ///< n · f
};

/// Where a margin goes through zero between a place with margin > 0 and one without, by false
/// position that halves the weight of an end that stays (Illinois).
template <class Margin>
double end_of_contact(double inside, double positive, double outside, double negative,
                      Margin margin) {
  if (negative == 0.0) return outside;
  const double close = 1e-12 * std::abs(outside - inside);
  bool moved_inside = false;
  bool moved_outside = false;
  for (int i = 0; i < 60 && std::abs(outside - inside) > close; ++i) {
    const double middle = inside + (outside - inside) * positive / (positive - negative);
    const double value = margin(middle);
    if (value > 0.0) {
      inside = middle;
      positive = value;
      if (std::exchange(moved_inside, true)) negative *= 0.5;
      moved_outside = false;
    } else {
      outside = middle;
      negative = value;
      if (std::exchange(moved_outside, true)) positive *= 0.5;
      moved_inside = false;
    }
    if (value == 0.0) return middle;
  }
  return inside;
}

}  // namespace

EdgeColumns::EdgeColumns(const cutting::Cutter& cutter, const cutting::Condition& condition,
                         const cutting::Immersion& immersion, std::vector<UnitForce> units)
    : cutter_(cutter),
      condition_(condition),
      band_(cutting::band(immersion, cutter)),
      envelope_(cutter),
      units_(std::move(units)) {
  const std::vector<double> pieces =
      cutting::smooth_pieces(envelope_, condition, band_, immersion.axial_depth);
  for (std::size_t piece = 0; piece + 1 < pieces.size(); ++piece) {
    const double length = pieces[piece + 1] - pieces[piece];
    const cutting::ProfilePoint low = envelope_.at(pieces[piece]);
    const cutting::ProfilePoint high = envelope_.at(pieces[piece + 1] - 1e-12 * length);
    const double turn = std::abs(high.lag - low.lag) + (high.kappa - low.kappa) +
                        (high.radius - low.radius) / cutter.radius;
    const int count = std::max(1, static_cast<int>(std::ceil(turn / kPanel)));
    for (int i = 0; i < count; ++i) ends_.push_back(pieces[piece] + length * i / count);
  }
  ends_.push_back(pieces.back());
  for (const double end : ends_) at_ends_.push_back(place_at(end, 0.0));
  for (std::size_t panel = 0; panel + 1 < ends_.size(); ++panel) {
    upright_.push_back(envelope_.is_cylinder(0.5 * (ends_[panel] + ends_[panel + 1])) &&
                       envelope_.is_cylinder(ends_[panel + 1]));
  }
  for (std::size_t panel = 0; panel + 1 < ends_.size(); ++panel) {
    const double width = ends_[panel + 1] - ends_[panel];
    for (std::size_t i = 0; i < kNodes; ++i) {
      nodes_.push_back(place_at(ends_[panel] + width * rule().nodes[i], width * rule().weights[i]));
    }
  }
}

EdgeColumns::Place EdgeColumns::place_at(double length, double weight) const {
  Place place;
  place.point = envelope_.at(length);
  place.weight = weight;
  place.sin_lag = std::sin(place.point.lag);
  place.cos_lag = std::cos(place.point.lag);
  place.sin_kappa = std::sin(place.point.kappa);
  place.cos_kappa = std::cos(place.point.kappa);
  return place;
}

EdgeColumns::Place EdgeColumns::place_in(std::size_t panel, double length) const {
  if (!upright_[panel]) return place_at(length, 0.0);
  // On a cylinder all but height and lag is that of the panel's ends, and these grow evenly.
  const Place& low = at_ends_[panel];
  const Place& high = at_ends_[panel + 1];
  const double share = (length - ends_[panel]) / (ends_[panel + 1] - ends_[panel]);
  Place place = low;
  place.point.z += share * (high.point.z - low.point.z);
  place.point.lag += share * (high.point.lag - low.point.lag);
  place.sin_lag = std::sin(place.point.lag);
  place.cos_lag = std::cos(place.point.lag);
  return place;
}

Eigen::MatrixXd EdgeColumns::at(const std::vector<double>& angle, double phase,
                                const cutting::RunOut& run_out,
                                const Eigen::Ref<const Eigen::VectorXd>& exponents) const {
  cutting::Cutter turned = cutter_;
  turned.run_out = run_out;
  const cutting::Flutes flutes(turned);
  const auto count = static_cast<std::size_t>(flutes.count());
  const auto rows = static_cast<Eigen::Index>(angle.size());
  const auto columns = static_cast<Eigen::Index>(units_.size());
  const double feed_a_turn = condition_.feed_per_tooth * flutes.count();
  const double sin_feed = std::sin(condition_.feed_elevation);
  const double cos_feed = std::cos(condition_.feed_elevation);

  // Chip of a flute: least over the flutes before it of share · into + excess. Shares do not depend
  // on the place, excesses not on the angle. See cutting::Flutes::chip.
  std::vector<double> share(count * count);
  for (std::size_t j = 0; j < count; ++j) {
    for (std::size_t b = 0; b < count; ++b) {
      double since = flutes.angle(static_cast<int>(j)) - flutes.angle(static_cast<int>(b));
      if (since <= 0.0) since += kTurn;
      share[j * count + b] = feed_a_turn * since / kTurn;
    }
  }
  // Deviation of a flute, cutting::Flutes::deviation, by the lag's sine and cosine.
  struct Toward {
    double cosine, sine;
  };
  const auto toward = [&](double direction, std::size_t flute) {
    const double off = direction - flutes.angle(static_cast<int>(flute));
    return Toward{std::cos(off), std::sin(off)};
  };
  std::vector<Toward> offset_toward, tilt_toward;
  for (std::size_t j = 0; j < count; ++j) {
    offset_toward.push_back(toward(run_out.offset_angle, j));
    tilt_toward.push_back(toward(run_out.tilt_angle, j));
  }
  const auto excess_at = [&](const Place& place, double* excess) {
    std::array<double, 64> deviation{};
    const double lean = run_out.tilt * place.point.z;
    for (std::size_t j = 0; j < count; ++j) {
      deviation[j] =
          (cutter_.radius_error.empty() ? 0.0 : cutter_.radius_error[j]) +
          place.cos_lag *
              (run_out.offset * offset_toward[j].cosine + lean * tilt_toward[j].cosine) +
          place.sin_lag * (run_out.offset * offset_toward[j].sine + lean * tilt_toward[j].sine);
    }
    for (std::size_t j = 0; j < count; ++j) {
      for (std::size_t b = 0; b < count; ++b) {
        excess[j * count + b] = (deviation[j] - deviation[b]) * place.sin_kappa;
      }
    }
  };
  const bool curved = exponents_of(units_) > 0;
  const std::size_t pairs = count * count;
  std::vector<double> excess_nodes(nodes_.size() * pairs);
  std::vector<double> excess_ends(at_ends_.size() * pairs);
  for (std::size_t i = 0; i < nodes_.size(); ++i) excess_at(nodes_[i], &excess_nodes[i * pairs]);
  for (std::size_t i = 0; i < at_ends_.size(); ++i) {
    excess_at(at_ends_[i], &excess_ends[i * pairs]);
  }

  const auto meet = [&](const Place& place, double sin_lead, double cos_lead) {
    Meeting now;
    now.sin_theta = sin_lead * place.cos_lag - cos_lead * place.sin_lag;
    now.cos_theta = cos_lead * place.cos_lag + sin_lead * place.sin_lag;
    now.into = place.sin_kappa * now.sin_theta * cos_feed - place.cos_kappa * sin_feed;
    return now;
  };
  const auto chip = [&](const double* excess, std::size_t flute, double into) {
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t b = 0; b < count; ++b) {
      least = std::min(least, share[flute * count + b] * into + excess[flute * count + b]);
    }
    return least;
  };
  const double full = cutter_.radius;
  const bool open_low = band_.low <= -full;
  const bool open_high = band_.high >= full;
  // > 0 where the edge is in contact and lifts a chip; see cutting::contact_margin.
  const auto margin = [&](const Place& place, const Meeting& now, double h) {
    const double y = place.point.radius * now.cos_theta;
    double least = std::min(now.into, h / feed_a_turn);
    if (!open_low) least = std::min(least, (y - band_.low) / full);
    if (!open_high) least = std::min(least, (band_.high - y) / full);
    return least;
  };

  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(3 * rows, columns);
  Eigen::Matrix3Xd sum(3, columns);
  const auto add = [&](const Place& place, const Meeting& now, double h) {
    const double s = now.sin_theta;
    const double c = now.cos_theta;
    const double sk = place.sin_kappa;
    const double ck = place.cos_kappa;
    // Against the motion, along the inward normal, and along the meridian away from the tip.
    const std::array<Eigen::Vector3d, 4> along{
        Eigen::Vector3d(-c, s, 0.0), Eigen::Vector3d(-sk * s, -sk * c, ck),
        Eigen::Vector3d(ck * s, ck * c, sk), Eigen::Vector3d(-ck * s, -ck * c, -sk)};
    const double log_h = curved ? std::log(std::max(h, kNoChip)) : 0.0;
    const double* exponent = exponents.data();
    for (Eigen::Index k = 0; k < columns; ++k) {
      const UnitForce& unit = units_[static_cast<std::size_t>(k)];
      double value = place.weight;
      if (unit.kind == UnitForce::Kind::shear) value *= h;
      if (unit.kind == UnitForce::Kind::edge_along_length) value *= place.point.stretch;
      if (unit.kind == UnitForce::Kind::power) {
        value *= std::exp(*exponent * (log_h - kLogMillimetre));
      }
      if (unit.kind == UnitForce::Kind::log) {
        const double log10_um = (log_h - kLogMicrometre) / std::numbers::ln10;
        value *= std::exp(std::numbers::ln10 * log10_um * (exponent[0] + exponent[1] * log10_um));
      }
      exponent += unit.exponents();
      for (int i = 0; i < unit.power; ++i) value *= place.point.kappa;
      sum.col(k) += value * along[static_cast<std::size_t>(unit.component)];
    }
  };
  std::vector<double> excess_here(pairs);
  for (Eigen::Index row = 0; row < rows; ++row) {
    sum.setZero();
    for (std::size_t flute = 0; flute < count; ++flute) {
      const double lead =
          angle[static_cast<std::size_t>(row)] - phase - flutes.angle(static_cast<int>(flute));
      const double sin_lead = std::sin(lead);
      const double cos_lead = std::cos(lead);
      std::size_t panel = 0;
      const auto margin_at = [&](double length) {
        const Place place = place_in(panel, length);
        excess_at(place, excess_here.data());
        const Meeting now = meet(place, sin_lead, cos_lead);
        return margin(place, now, chip(excess_here.data(), flute, now.into));
      };
      double margin_from = 0.0;
      for (std::size_t end = 0; end < ends_.size(); ++end) {
        const Meeting at_end = meet(at_ends_[end], sin_lead, cos_lead);
        const double margin_to =
            margin(at_ends_[end], at_end, chip(&excess_ends[end * pairs], flute, at_end.into));
        const double margin_before = std::exchange(margin_from, margin_to);
        const bool was_in = margin_before > 0.0;
        const bool is_in = margin_to > 0.0;
        if (end == 0 || (!was_in && !is_in)) continue;
        if (was_in && is_in) {
          for (std::size_t i = (end - 1) * kNodes; i < end * kNodes; ++i) {
            const Meeting now = meet(nodes_[i], sin_lead, cos_lead);
            add(nodes_[i], now, chip(&excess_nodes[i * pairs], flute, now.into));
          }
          continue;
        }
        panel = end - 1;
        const double inside = end_of_contact(
            was_in ? ends_[end - 1] : ends_[end], was_in ? margin_before : margin_to,
            was_in ? ends_[end] : ends_[end - 1], was_in ? margin_to : margin_before, margin_at);
        const double from = was_in ? ends_[end - 1] : inside;
        const double width = (was_in ? inside : ends_[end]) - from;
        for (std::size_t i = 0; i < kNodes; ++i) {
          Place place = place_in(panel, from + width * rule().nodes[i]);
          place.weight = width * rule().weights[i];
          excess_at(place, excess_here.data());
          const Meeting now = meet(place, sin_lead, cos_lead);
          add(place, now, chip(excess_here.data(), flute, now.into));
        }
      }
    }
    for (Eigen::Index axis = 0; axis < 3; ++axis) result.row(axis * rows + row) = sum.row(axis);
  }
  return result;
}

}  // namespace osteomill::identify
