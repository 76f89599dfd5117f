// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/cutting/engaged_force.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <string>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/cutting/edge_sum.hpp"

namespace osteomill::cutting {
namespace {

using geometry::Vector3;
constexpr double kTurn = 2.0 * std::numbers::pi;

double weight_of(const Engagement& engagement, int slice) {
  const auto angles = static_cast<std::ptrdiff_t>(engagement.angles);
  const auto first = engagement.weights.begin() + slice * angles;
  return std::accumulate(first, first + angles, 0.0);
}

}  // namespace

EngagedForce::EngagedForce(const Cutter& cutter, const CuttingLaw& law, int angles, int slices,
                           double slice_height)
    : cutter_(cutter),
      flutes_(cutter),
      law_(law),
      angles_(angles),
      slices_(slices),
      slice_height_(slice_height) {
  require_within("engagement.angles", angles, 4.0, 1e5, "");
  require_within("engagement.slices", slices, 1.0, 1e5, "");
  require_positive("engagement.slice_height_mm", slice_height / units::mm, "mm");
  const Envelope envelope(cutter);
  for (int slice = 0; slice < slices; ++slice) {
    const double from = envelope.length_to(slice * slice_height);
    const double to = envelope.length_to((slice + 1) * slice_height);
    // Near the tip of a ball one slice spans many degrees of kappa: parts of at most 5 degrees.
    const double turn = envelope.at(to).kappa - envelope.at(from).kappa;
    const int parts = std::max(1, static_cast<int>(std::ceil(turn / (5.0 * units::deg))));
    for (int part = 0; part < parts; ++part) {
      const ProfilePoint point = envelope.at(from + (to - from) * (part + 0.5) / parts);
      // Unequal flutes cut other chips at every height.
      if (strips_.empty() || !flutes_.equal() || strips_.back().point.kappa != point.kappa ||
          strips_.back().point.radius != point.radius) {
        ++rows_;
      }
      strips_.push_back({point, (to - from) / parts, slice, rows_ - 1, std::sin(point.kappa),
                         std::cos(point.kappa)});
      for (int flute = 0; flute < cutter.flutes; ++flute) {
        const double angle = flutes_.angle(flute) + point.lag;
        behind_.push_back({angle, std::sin(angle), std::cos(angle)});
      }
    }
  }
  for (int angle = 0; angle < angles; ++angle) {
    motions_.push_back(motion(kTurn * (angle + 0.5) / angles));
  }
}

void EngagedForce::require_grid(const Engagement& engagement) const {
  if (engagement.angles != angles_ || engagement.slices != slices_ ||
      engagement.slice_height != slice_height_) {
    throw InvalidInput(Fault{"engagement",
                             std::to_string(engagement.angles) + " angles x " +
                                 std::to_string(engagement.slices) + " slices",
                             "must have the grid that the force model was made for",
                             "make an EngagedForce for each grid"});
  }
}

Load EngagedForce::mean(const Engagement& engagement, const Condition& condition) const {
  require_grid(engagement);
  const auto angles = static_cast<std::size_t>(angles_);
  // Equal flutes are worked out once.
  const int different = flutes_.equal() ? 1 : flutes_.count();
  const double share = static_cast<double>(flutes_.count()) / different / angles_;
  // Width of cut in bone, and its moment about the tip, by row and angle.
  std::vector<double> width(angles);
  std::vector<double> width_z(angles);
  const Vector3 feed = feed_direction(condition);
  EdgeSum sum(law_, condition.fibre_T);
  // Where the tool turns every height has its own chip.
  const bool turns = !condition.turn_T.isZero(0.0);
  Load mean;
  for (auto strip = strips_.begin(); strip != strips_.end();) {
    const ProfilePoint& row = strip->point;
    width.assign(angles, 0.0);
    width_z.assign(angles, 0.0);
    const int this_row = strip->row;
    bool first = true;
    for (; strip != strips_.end() && strip->row == this_row && (first || !turns); ++strip) {
      first = false;
      const double* weights = &engagement.weights[static_cast<std::size_t>(strip->slice) * angles];
      const double w = strip->width;
      const double wz = w * strip->point.z;
      for (std::size_t a = 0; a < angles; ++a) {
        width[a] += weights[a] * w;
        width_z[a] += weights[a] * wz;
      }
    }
    const double sin_kappa = std::sin(row.kappa);
    const double cos_kappa = std::cos(row.kappa);
    sum.at(row);
    for (std::size_t a = 0; a < angles; ++a) {
      if (!(width[a] > 0.0)) continue;
      const double sine = -motions_[a].y();
      const double cosine = motions_[a].x();
      double into = sin_kappa * (sine * feed.x() + cosine * feed.y()) - cos_kappa * feed.z();
      if (turns) {
        const Vector3 n(sin_kappa * sine, sin_kappa * cosine, -cos_kappa);
        const Vector3 p(row.radius * sine, row.radius * cosine, row.z - condition.turn_height);
        into += n.dot(condition.turn_T.cross(p));
      }
      for (int flute = 0; flute < different; ++flute) {
        const double h = flutes_.chip(flute, row, condition.feed_per_tooth, std::max(0.0, into));
        if (!flutes_.equal() && h <= 0.0) continue;
        sum.push(sine, cosine, h, share * width[a], share * width_z[a]);
      }
    }
  }
  sum.add_to(mean);
  return mean;
}

double EngagedForce::edge_in_bone(const Engagement& engagement) const {
  require_grid(engagement);
  double sum = 0.0;
  for (const Strip& strip : strips_)
    sum += weight_of(engagement, strip.slice) * strip.width * strip.point.stretch;
  return sum * flutes_.count() / angles_;
}

std::vector<EngagedForce::PatchWork> EngagedForce::work(const Engagement& engagement,
                                                        const Condition& condition) const {
  require_grid(engagement);
  const Vector3 feed = feed_direction(condition);
  std::vector<PatchWork> patches(engagement.weights.size());
  std::vector<double> widths(patches.size(), 0.0);
  for (const Strip& strip : strips_)
    for (int angle = 0; angle < angles_; ++angle) {
      const double weight = engagement.at(strip.slice, angle);
      if (!(weight > 0.0)) continue;
      const double theta = kTurn * (angle + 0.5) / angles_;
      const Vector3 n = outward_normal(theta, strip.point.kappa);
      const Vector3 place(strip.point.radius * std::sin(theta),
                          strip.point.radius * std::cos(theta), strip.point.z);
      const Vector3 arm = place - condition.turn_height * Vector3::UnitZ();
      const double into = std::max(0.0, n.dot(feed + condition.turn_T.cross(arm)));
      const std::size_t at =
          static_cast<std::size_t>(strip.slice) * static_cast<std::size_t>(angles_) +
          static_cast<std::size_t>(angle);
      PatchWork& patch = patches[at];
      for (int flute = 0; flute < flutes_.count(); ++flute) {
        const double h = flutes_.chip(flute, strip.point, condition.feed_per_tooth, into);
        if (!flutes_.equal() && h <= 0.0) continue;
        const Vector3 force = weight * strip.width / angles_ *
                              edge_force(law_, h, condition.fibre_T,
                                         motions_[static_cast<std::size_t>(angle)], n, strip.point);
        patch.torque += place.cross(force).z();
        patch.chip += h * strip.width;
        widths[at] += strip.width;
      }
    }
  for (std::size_t at = 0; at < patches.size(); ++at)
    if (widths[at] > 0.0) patches[at].chip /= widths[at];
  return patches;
}

Revolution EngagedForce::revolution(const Engagement& engagement, const Condition& condition,
                                    int steps) const {
  require_grid(engagement);
  const Vector3 feed = feed_direction(condition);
  const bool turns = !condition.turn_T.isZero(0.0);
  // Equal flutes do the same one after the other.
  const bool repeats = flutes_.equal() && steps % cutter_.flutes == 0;
  const int different = repeats ? steps / cutter_.flutes : steps;
  std::vector<Load> loads(static_cast<std::size_t>(different));
  EdgeSum sum(law_, condition.fibre_T);
  std::vector<std::size_t> in_bone;  // strips that meet any
  for (std::size_t strip = 0; strip < strips_.size(); ++strip)
    if (weight_of(engagement, strips_[strip].slice) > 0.0) in_bone.push_back(strip);
  for (int step = 0; step < different; ++step) {
    const double angle = kTurn * step / steps;
    const double sine_of_step = std::sin(angle), cosine_of_step = std::cos(angle);
    int row = -1;
    for (const std::size_t strip : in_bone) {
      const Strip& here = strips_[strip];
      if (here.row != row) {
        row = here.row;
        sum.at(here.point, static_cast<std::size_t>(step));
      }
      for (int flute = 0; flute < cutter_.flutes; ++flute) {
        const Behind& behind = behind_[strip * static_cast<std::size_t>(cutter_.flutes) +
                                       static_cast<std::size_t>(flute)];
        const double turns_of = (angle - behind.angle) / kTurn;
        const int patch =
            std::min(angles_ - 1, static_cast<int>((turns_of - std::floor(turns_of)) * angles_));
        const double weight = engagement.at(here.slice, patch);
        if (!(weight > 0.0)) continue;
        const double sine = sine_of_step * behind.cosine - cosine_of_step * behind.sine;
        const double cosine = cosine_of_step * behind.cosine + sine_of_step * behind.sine;
        const Vector3 n(here.sin_kappa * sine, here.sin_kappa * cosine, -here.cos_kappa);
        double into = n.dot(feed);
        if (turns) {
          const Vector3 at(here.point.radius * sine, here.point.radius * cosine,
                           here.point.z - condition.turn_height);
          into += n.dot(condition.turn_T.cross(at));
        }
        const double h =
            flutes_.chip(flute, here.point, condition.feed_per_tooth, std::max(0.0, into));
        if (!flutes_.equal() && h <= 0.0) continue;
        const double width = weight * here.width;
        sum.push(sine, cosine, h, width, width * here.point.z);
      }
    }
  }
  sum.add_to(loads);
  Revolution result;
  for (int step = 0; step < steps; ++step) {
    result.angle.push_back(kTurn * step / steps);
    result.loads.push_back(loads[static_cast<std::size_t>(step % different)]);
  }
  return result;
}

}  // namespace osteomill::cutting
