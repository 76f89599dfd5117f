// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/workpiece/contact.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/workpiece/remover.hpp"

namespace osteomill::workpiece {

namespace {

std::string in_mm(const Vector3& p) {
  return fmt::format("({:.2f}, {:.2f}, {:.2f})", p.x() / units::mm, p.y() / units::mm,
                     p.z() / units::mm);
}

[[noreturn]] void throw_outside(const Stock& stock, const ToolPath& path) {
  const Stock::Box box = stock.bone_box();
  const geometry::GridShape& shape = stock.shape();
  Vector3 low = path.at(0.0).position_W, high = low;
  for (const Move& move : path.moves())
    for (const Vector3& point : move.points_W) {
      low = low.cwiseMin(point);
      high = high.cwiseMax(point);
    }
  throw InvalidInput(Fault{"path", in_mm(low) + " to " + in_mm(high) + " mm",
                           "must touch the bone, which lies in " +
                               in_mm(shape.centre(box.first[0], box.first[1], box.first[2])) +
                               " to " + in_mm(shape.centre(box.last[0], box.last[1], box.last[2])) +
                               " mm",
                           "check origin, axes and depth of the path"});
}

}  // namespace

ContactMap::ContactMap(Stock stock, const cutting::Cutter& cutter, const ToolPath& path,
                       double step, Stock* left) {
  if (step == 0.0) step = stock.spacing();
  require_positive("path.contact_step_mm", step / units::mm, "mm");
  RemoverOptions options;
  options.patches = {1, 4, cutter.cutting_length};  // the map isn't asked for
  options.memory = 0.0;
  Remover remover(stock, cutter, options);
  // A trace of occupancy is no contact: a thousandth of a voxel in a step.
  const double least = 1e-3 * stock.shape().voxel_volume();
  FaultList rapids;
  std::vector<Stretch> raw;
  for (std::size_t m = 0; m < path.moves().size(); ++m) {
    std::vector<double> stops = path.corners_between(path.start_of(m), path.end_of(m));
    stops.push_back(path.end_of(m));
    double from = path.start_of(m), in_rapid = 0.0;
    for (double stop : stops) {
      const double length = stop - from;
      const int steps = std::max(1, static_cast<int>(std::ceil(length / step - 1e-9)));
      for (int k = 0; k < steps && length > 0.0; ++k) {
        const double a = from + length * k / steps, b = from + length * (k + 1) / steps;
        const Removal removal = remover.step(path.at(a).pose(), path.at(b).pose());
        const double volume = removal.volume + removal.buried_volume;
        removed_volume_ += volume;
        if (path.moves()[m].kind == MoveKind::rapid) in_rapid += volume;
        frontal_.push_back({0.5 * (a + b), volume / (b - a)});
        if (volume < least) continue;
        if (!raw.empty() && a - raw.back().end < cutter.radius)
          raw.back().end = b;
        else
          raw.push_back({a, b, a});
      }
      from = stop;
    }
    if (in_rapid >= least)
      rapids.gather([&] {
        throw InvalidInput(Fault{fmt::format("path.moves[{}]", m),
                                 fmt::format("rapid of line {} through {:.3g} mm³ of bone",
                                             path.moves()[m].line, in_rapid / units::mm3),
                                 "must not go through bone",
                                 "raise the clearance or make it a cut"});
      });
  }
  rapids.raise();
  if (raw.empty()) throw_outside(stock, path);
  stretches_ = std::move(raw);
  for (Stretch& stretch : stretches_) {
    const double last = stretch.begin + 2.0 * cutter.radius;
    double largest = 0.0;
    const auto inside = [&](const Frontal& f) {
      return f.arc_length > stretch.begin && f.arc_length < std::min(stretch.end, last);
    };
    for (const Frontal& f : frontal_)
      if (inside(f)) largest = std::max(largest, f.area);
    const auto full = std::find_if(frontal_.begin(), frontal_.end(), [&](const Frontal& f) {
      return inside(f) && f.area >= 0.95 * largest;
    });
    stretch.engaged = full == frontal_.end() ? stretch.end : full->arc_length;
  }
  if (left != nullptr) *left = std::move(stock);
}

const ContactMap::Stretch* ContactMap::at_or_after(double arc_length) const {
  const auto found =
      std::lower_bound(stretches_.begin(), stretches_.end(), arc_length,
                       [](const Stretch& stretch, double at) { return stretch.end <= at; });
  return found == stretches_.end() ? nullptr : &*found;
}

bool ContactMap::in_contact(double arc_length) const {
  return distance_to_contact(arc_length) == 0.0;
}

double ContactMap::distance_to_contact(double arc_length) const {
  const Stretch* next = at_or_after(arc_length);
  if (!next) return std::numeric_limits<double>::infinity();
  return std::max(0.0, next->begin - arc_length);
}

double ContactMap::distance_to_full_engagement(double arc_length) const {
  const Stretch* next = at_or_after(arc_length);
  if (!next) return std::numeric_limits<double>::infinity();
  return std::max(0.0, next->engaged - arc_length);
}

}  // namespace osteomill::workpiece
