// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/simulate/force_map.hpp"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <unordered_map>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/cutting/edge_sum.hpp"
#include "osteomill/cutting/envelope.hpp"
#include "osteomill/cutting/flutes.hpp"

namespace osteomill::simulate {
namespace {

using geometry::Vector3;
constexpr double kTurn = 2.0 * std::numbers::pi;
constexpr int kNodes = 12;
constexpr double kDecades = 2.0;
/// Slices of one profile that share a chip reach no farther than this along the axis, m: the chip
/// changes in proportion to the distance from the pivot, and the error is of second order.
constexpr double kShared = 2e-3;
constexpr double kMostPoses = 1e6;
constexpr double kSamePlace = 1e-9;  // m; far below what bone changes over, far above rounding

ForceMapOptions checked(ForceMapOptions o) {
  FaultList faults;
  const auto require = [&](bool holds, const char* field, double value, const char* unit,
                           const std::string& rule, const char* remedy = "") {
    if (!holds)
      faults.gather([&] {
        throw InvalidInput(Fault{field, fmt::format("{:g} {}", value, unit), rule, remedy});
      });
  };
  faults.gather([&] { cutting::check(o.cutter); });
  faults.gather([&] { cutting::check(o.law); });
  GuidePoses& p = o.poses;
  require(o.spindle_speed > 0.0, "map.spindle_speed_rpm", o.spindle_speed / units::rpm, "rpm",
          "must be > 0");
  require(o.largest_feed > 0.0, "limits.max_feed_mm_per_s", o.largest_feed / units::mm_per_s,
          "mm/s", "must be > 0");
  require(p.last_angle >= p.first_angle, "map.last_angle_deg", p.last_angle / units::deg, "deg",
          "must not be below map.first_angle_deg");
  require(p.last_angle - p.first_angle < kTurn, "map.last_angle_deg", p.last_angle / units::deg,
          "deg", "must be less than a turn from the first");
  require(p.angle_step > 0.0, "map.angle_step_deg", p.angle_step / units::deg, "deg",
          "must be > 0");
  require(p.first_insertion > 0.0, "map.first_insertion_mm", p.first_insertion / units::mm, "mm",
          "must be > 0");
  require(p.last_insertion >= p.first_insertion, "map.last_insertion_mm",
          p.last_insertion / units::mm, "mm", "must not be below map.first_insertion_mm");
  require(p.insertion_step > 0.0, "map.insertion_step_mm", p.insertion_step / units::mm, "mm",
          "must be > 0");
  require(o.axial_depth > 0.0 && o.axial_depth <= o.cutter.cutting_length, "map.advance_mm",
          o.axial_depth / units::mm, "mm",
          fmt::format("must be > 0 and not above the cutting length of {:g} mm",
                      o.cutter.cutting_length / units::mm),
          "advance by less, or set cutter.cutting_length_mm");
  require(p.normal_W.norm() > 0.0, "map.normal", 0.0, "", "must not be zero");
  const Vector3 n = p.normal_W.normalized();
  const Vector3 f = p.forward_W - n * n.dot(p.forward_W);
  require(f.norm() > 1e-3 * p.forward_W.norm(), "map.forward", f.norm(), "",
          "must not be along map.normal", "give a direction in the cutting plane");
  require(o.slice_height > 0.0, "map.slice_height_mm", o.slice_height / units::mm, "mm",
          "must be > 0");
  require(o.angles >= 8, "map.patches", o.angles, "", "must be 8 or more");
  faults.raise();
  const double poses = ((p.last_angle - p.first_angle) / p.angle_step + 1.0) *
                       ((p.last_insertion - p.first_insertion) / p.insertion_step + 1.0);
  require(poses <= kMostPoses, "map.angle_step_deg", p.angle_step / units::deg, "deg",
          fmt::format("would give {:.2g} poses: must not be more than a million", poses),
          "make map.angle_step_deg or map.insertion_step_mm larger");
  faults.raise();
  p.normal_W = n;
  p.forward_W = f.normalized();
  o.fibre_W.normalize();
  return o;
}

/// From first to last in equal steps of at most `step`; a millionth of one is rounding.
std::vector<double> range(double first, double last, double step) {
  const int steps = static_cast<int>(std::ceil((last - first) / step - 1e-6));
  std::vector<double> values = {first};
  for (int i = 1; i <= steps; ++i) values.push_back(first + (last - first) * i / steps);
  return values;
}

bool linear_in_chip(const cutting::DirectionalLaw& law, bool one_direction) {
  const auto linear = [](const cutting::EdgeForce& edge) {
    if (const auto* power = std::get_if<cutting::PowerLaw>(&edge)) return power->exponent == 1.0;
    return !std::holds_alternative<cutting::LogLaw>(edge);
  };
  return linear(law.at_0) && (!law.at_90 || (!one_direction && linear(*law.at_90)));
}

/// Whether the force of an edge is A + B h. Hankinson's criterion between two linear laws is not.
bool linear_in_chip(const cutting::CuttingLaw& law) {
  const bool hankinson = law.orientation == cutting::OrientationCriterion::hankinson;
  return law.minimum_chip == 0.0 && linear_in_chip(law.tangential, hankinson) &&
         linear_in_chip(law.radial, hankinson) &&
         (!law.lateral || linear_in_chip(*law.lateral, true));
}

/// Strength of the bone at a point: occupancy × force scale, between the centres of voxels in
/// proportion.
double strength_at(const workpiece::Stock& stock, const Vector3& p_W) {
  const geometry::GridShape& shape = stock.shape();
  const Vector3 at = (p_W - shape.origin) / stock.spacing();
  const int x = static_cast<int>(std::floor(at.x())), y = static_cast<int>(std::floor(at.y())),
            z = static_cast<int>(std::floor(at.z()));
  if (x < -1 || y < -1 || z < -1 || x >= shape.size[0] || y >= shape.size[1] || z >= shape.size[2])
    return 0.0;
  const double u = at.x() - x, v = at.y() - y, w = at.z() - z;
  double sum = 0.0;
  for (int corner = 0; corner < 8; ++corner) {
    const int i = corner & 1, j = (corner >> 1) & 1, k = corner >> 2;
    const double share = stock.occupancy(x + i, y + j, z + k);
    if (!(share > 0.0)) continue;
    sum += (i ? u : 1.0 - u) * (j ? v : 1.0 - v) * (k ? w : 1.0 - w) * share *
           stock.material(x + i, y + j, z + k).force_scale;
  }
  return sum;
}

/// A stretch of the cutter: slices whose elements share a profile point and a chip.
struct Strip {
  cutting::ProfilePoint point;  ///< at its middle
  double width = 0.0;           ///< of cut, m
  int first_slice = 0, last_slice = 0;
};

struct Slice {
  cutting::ProfilePoint point;
  double width = 0.0;
};

/// The front of the cutter, where its side goes into the bone: sines and cosines of the angles.
struct Front {
  std::vector<double> sine, cosine;
};

/// Everything of the cutter that is the same at all poses.
struct Tool {
  std::vector<Slice> slices;
  std::vector<Strip> strips;
  Front front;
  cutting::Flutes flutes;
  int all_angles = 0;
  bool cylinder = true;  ///< all slices have one profile
  explicit Tool(const ForceMapOptions& o) : flutes(o.cutter), all_angles(o.angles) {
    const cutting::Envelope envelope(o.cutter);
    const int count = std::max(1, static_cast<int>(std::ceil(o.axial_depth / o.slice_height)));
    const double height = o.axial_depth / count;
    for (int s = 0; s < count; ++s) {
      const double from = envelope.length_to(s * height), to = envelope.length_to((s + 1) * height);
      slices.push_back({envelope.at(0.5 * (from + to)), to - from});
      const Slice& slice = slices.back();
      cylinder = cylinder && slice.point.radius == slices.front().point.radius &&
                 slice.point.kappa == slices.front().point.kappa;
      const bool joins = !strips.empty() && flutes.equal() &&
                         strips.back().point.kappa == slice.point.kappa &&
                         strips.back().point.radius == slice.point.radius &&
                         (s - strips.back().first_slice + 1) * height <= kShared * (1.0 + 1e-9);
      if (!joins) {
        strips.push_back({slice.point, 0.0, s, s});
        continue;
      }
      strips.back().last_slice = s;
      const double middle = 0.5 * (strips.back().first_slice + s + 1) * height;
      strips.back().point = envelope.at(envelope.length_to(middle));
    }
    for (int a = 0; a < o.angles; ++a) {
      const double theta = kTurn * (a + 0.5) / o.angles;
      if (!(std::sin(theta) > 0.0)) continue;
      front.sine.push_back(std::sin(theta));
      front.cosine.push_back(std::cos(theta));
    }
  }
};

/// Width of cut × strength of each strip and angle at one pose.
struct Widths {
  std::vector<double> width, width_z;
};

}  // namespace

ForceMap::ForceMap(const workpiece::Stock& stock, const ForceMapOptions& options)
    : options_(checked(options)),
      x_(options_.poses.forward_W),
      y_(options_.poses.normal_W.cross(x_)) {
  const GuidePoses& poses_of = options_.poses;
  angles_ = range(poses_of.first_angle, poses_of.last_angle, poses_of.angle_step);
  insertions_ = range(poses_of.first_insertion, poses_of.last_insertion, poses_of.insertion_step);
  const Tool tool(options_);
  if (linear_in_chip(options_.law) && tool.flutes.equal()) {
    feeds_ = {0.0, options_.largest_feed};
  } else {
    for (int k = 0; k < kNodes; ++k)
      feeds_.push_back(options_.largest_feed *
                       std::pow(10.0, kDecades * (k - kNodes + 1) / (kNodes - 1)));
    feeds_.back() = options_.largest_feed;
  }
  const std::vector<float> empty(poses());
  nodes_.assign(feeds_.size(), {empty, empty, empty, empty});
  contact_ = empty;

  const Vector3 n = poses_of.normal_W;
  // Swinging towards larger angles the spindle, clockwise seen from itself, leaves the plane behind
  // an edge that comes out of it: up-milling.
  const double sense = options_.milling == workpiece::Milling::up ? 1.0 : -1.0;
  const std::size_t across = tool.front.sine.size();
  const int different = tool.flutes.equal() ? 1 : tool.flutes.count();
  const double share =
      static_cast<double>(tool.flutes.count()) / different / static_cast<double>(tool.all_angles);
  tbb::parallel_for(std::size_t{0}, angles_.size(), [&](std::size_t i) {
    const Vector3 u = std::cos(angles_[i]) * x_ + std::sin(angles_[i]) * y_;
    const Vector3 along = sense * n.cross(u);  // the feed: x of the tool frame
    const Vector3 side = -u.cross(along);      // y of the tool frame; z is -u
    const Vector3 fibre_T(along.dot(options_.fibre_W), side.dot(options_.fibre_W),
                          -u.dot(options_.fibre_W));
    cutting::EdgeSum sum(options_.law, fibre_T);
    Widths all;
    std::unordered_map<long long, std::vector<double>> rings;  // strength around the tool
    for (std::size_t j = 0; j < insertions_.size(); ++j) {
      const double insertion = insertions_[j];
      const Vector3 tip = poses_of.pivot_W + insertion * u + options_.cutter.radius * n;
      all.width.assign(tool.strips.size() * across, 0.0);
      all.width_z.assign(tool.strips.size() * across, 0.0);
      std::size_t touched = 0, looked = 0;
      for (std::size_t b = 0; b < tool.strips.size(); ++b) {
        const Strip& strip = tool.strips[b];
        for (int s = strip.first_slice; s <= strip.last_slice; ++s) {
          const Slice& slice = tool.slices[static_cast<std::size_t>(s)];
          if (slice.point.z >= insertion) continue;  // before the pivot
          // A cylinder meets the same ring again from another insertion.
          const auto place = std::llround((insertion - slice.point.z) / kSamePlace);
          std::vector<double>& ring = rings[tool.cylinder ? place : s];
          if (ring.empty() || !tool.cylinder) {
            ring.resize(across);
            const Vector3 centre = tip - slice.point.z * u;
            for (std::size_t a = 0; a < across; ++a)
              ring[a] =
                  strength_at(stock, centre + slice.point.radius * (tool.front.sine[a] * along +
                                                                    tool.front.cosine[a] * side));
          }
          looked += across;
          for (std::size_t a = 0; a < across; ++a) {
            if (!(ring[a] > 0.0)) continue;
            ++touched;
            all.width[b * across + a] += ring[a] * slice.width;
            all.width_z[b * across + a] += ring[a] * slice.width * slice.point.z;
          }
        }
      }
      const std::size_t at = index(i, j);
      if (touched == 0) continue;
      contact_[at] = static_cast<float>(touched) / static_cast<float>(looked);
      for (std::size_t k = 0; k < feeds_.size(); ++k) {
        const double tip_chip =
            cutting::feed_per_tooth(feeds_[k], options_.spindle_speed, tool.flutes.count());
        for (std::size_t b = 0; b < tool.strips.size(); ++b) {
          const Strip& strip = tool.strips[b];
          const double sin_kappa = std::sin(strip.point.kappa);
          const double chip = tip_chip * (insertion - strip.point.z) / insertion;
          sum.at(strip.point);
          for (std::size_t a = 0; a < across; ++a) {
            const double w = all.width[b * across + a];
            if (!(w > 0.0)) continue;
            for (int flute = 0; flute < different; ++flute) {
              const double h =
                  tool.flutes.chip(flute, strip.point, chip, sin_kappa * tool.front.sine[a]);
              if (!tool.flutes.equal() && h <= 0.0) continue;
              sum.push(tool.front.sine[a], tool.front.cosine[a], h, share * w,
                       share * all.width_z[b * across + a]);
            }
          }
        }
        cutting::Load mean;
        sum.add_to(mean);
        nodes_[k].feed[at] = static_cast<float>(-mean.force.x());
        nodes_[k].normal[at] = static_cast<float>(mean.force.y() * side.dot(n));
        nodes_[k].axial[at] = static_cast<float>(mean.force.z());
        nodes_[k].torque[at] = static_cast<float>(mean.torque());
      }
    }
  });
}

Vector3 ForceMap::place_W(std::size_t angle, std::size_t insertion) const {
  const Vector3 u = std::cos(angles_[angle]) * x_ + std::sin(angles_[angle]) * y_;
  return options_.poses.pivot_W + insertions_[insertion] * u;
}

/// Lagrange's polynomial through the two nodes, or the four around the feed in ln(feed).
ForceMap::Weights ForceMap::weights_at(double feed) const {
  Weights w;
  if (linear()) {
    w.count = 2;
    w.of[1] = feed / feeds_[1];
    w.of[0] = 1.0 - w.of[1];
    return w;
  }
  const double step = kDecades * std::numbers::ln10 / (kNodes - 1);
  const double place = std::log(feed / feeds_.front()) / step;
  w.count = 4;
  w.first = static_cast<std::size_t>(std::clamp(std::floor(place) - 1.0, 0.0, kNodes - 4.0));
  const double t = place - static_cast<double>(w.first);
  for (int k = 0; k < 4; ++k) {
    w.of[k] = 1.0;
    for (int m = 0; m < 4; ++m)
      if (m != k) w.of[k] *= (t - m) / (k - m);
  }
  return w;
}

PoseForces ForceMap::at(double feed) const {
  // A billionth: the feed may have been through a file.
  require_within("map.feed_mm_per_s", feed / units::mm_per_s,
                 feeds_.front() / units::mm_per_s * (1.0 - 1e-9),
                 feeds_.back() / units::mm_per_s * (1.0 + 1e-9), "mm/s");
  const Weights w = weights_at(feed);
  const auto mixed = [&](std::vector<float> PoseForces::* part) {
    std::vector<float> out(poses());
    for (int k = 0; k < w.count; ++k) {
      const std::vector<float>& from = nodes_[w.first + static_cast<std::size_t>(k)].*part;
      const float weight = static_cast<float>(w.of[k]);
      for (std::size_t i = 0; i < out.size(); ++i) out[i] += weight * from[i];
    }
    return out;
  };
  return {mixed(&PoseForces::normal), mixed(&PoseForces::feed), mixed(&PoseForces::axial),
          mixed(&PoseForces::torque)};
}

std::vector<float> ForceMap::largest_feeds(LimitedForce what, double force) const {
  require_positive("limits.force_n", force, "N");
  const auto size_at = [&](std::size_t pose, const Weights& w) {
    Vector3 sum = Vector3::Zero();
    for (int k = 0; k < w.count; ++k) {
      const PoseForces& node = nodes_[w.first + static_cast<std::size_t>(k)];
      sum += w.of[k] * Vector3(node.normal[pose], node.feed[pose], node.axial[pose]);
    }
    if (what == LimitedForce::normal) return std::abs(sum.x());
    if (what == LimitedForce::feed) return std::abs(sum.y());
    return sum.norm();
  };
  std::vector<Weights> at_nodes;
  for (const double feed : feeds_) at_nodes.push_back(weights_at(feed));
  std::vector<float> result(poses());
  for (std::size_t pose = 0; pose < poses(); ++pose) {
    std::size_t above = 0;
    while (above < feeds_.size() && size_at(pose, at_nodes[above]) <= force) ++above;
    if (above == 0) continue;
    if (above == feeds_.size()) {
      result[pose] = static_cast<float>(options_.largest_feed);
      continue;
    }
    double low = feeds_[above - 1], high = feeds_[above];
    // To a millionth of the interval.
    for (int step = 0; step < 20; ++step) {
      const double middle = 0.5 * (low + high);
      (size_at(pose, weights_at(middle)) <= force ? low : high) = middle;
    }
    result[pose] = static_cast<float>(low);
  }
  return result;
}

}  // namespace osteomill::simulate
