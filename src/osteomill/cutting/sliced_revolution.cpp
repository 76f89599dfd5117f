// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/cutting/sliced_revolution.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "osteomill/base/error.hpp"
#include "osteomill/cutting/component_batch.hpp"
#include "osteomill/cutting/contact.hpp"
#include "osteomill/cutting/flutes.hpp"

namespace osteomill::cutting {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;

/// Elements one after the other, as components() has them.
void add_one_by_one(const CuttingLaw& law, const Condition& condition, const ProfilePoint& point,
                    double lag, double width, int first, int count, int steps,
                    SlicedRevolution& result) {
  for (int i = first; i < first + count; ++i) {
    const geometry::Vector3 force =
        width * edge_force(law, condition, kTurn * i / steps - lag, point);
    const auto at = static_cast<std::size_t>(i);
    result.x[at] += force.x();
    result.y[at] += force.y();
    result.z[at] += force.z();
  }
}

}  // namespace

SlicedRevolution sliced_revolution(const Cutter& cutter, const CuttingLaw& law,
                                   const Condition& condition, const Immersion& immersion,
                                   const SliceOptions& options) {
  const Flutes flutes(cutter);
  if (!flutes.equal() || condition.path != ToothPath::circular) {
    throw InvalidInput(Fault{"cutter", "", "must have equal flutes on a circular path here",
                             "use the exact revolution"});
  }
  const int steps = options.steps;
  const auto size = static_cast<std::size_t>(steps);
  SlicedRevolution result{std::vector<double>(size), std::vector<double>(size),
                          std::vector<double>(size)};
  std::vector<double> sine(size);
  std::vector<double> cosine(size);
  for (std::size_t i = 0; i < size; ++i) {
    sine[i] = std::sin(kTurn * static_cast<double>(i) / steps);
    cosine[i] = std::cos(kTurn * static_cast<double>(i) / steps);
  }
  const ComponentBatch batch(law);
  const bool vectors = options.vectorise && batch.vectorised();
  const Envelope envelope(cutter);
  const LateralBand bone = band(immersion, cutter);
  const double whole = envelope.length_to(immersion.axial_depth);
  const double width = whole / options.slices;
  const geometry::Vector3 feed = feed_direction(condition);
  for (int slice = 0; slice < options.slices; ++slice) {
    const ProfilePoint point = envelope.at(width * (slice + 0.5));
    const Arcs arcs = contact_arcs(point, condition, bone);
    kernel::Curves curves = batch.curves();
    if (law.lateral_inclination != 0.0) {
      curves.scale[2] = point.inclination / law.lateral_inclination;
    }
    kernel::Strip strip{};
    strip.sin_kappa = std::sin(point.kappa);
    strip.cos_kappa = std::cos(point.kappa);
    strip.chip_sine = condition.feed_per_tooth * strip.sin_kappa * feed.x();
    strip.chip_axial = condition.feed_per_tooth * strip.cos_kappa * feed.z();
    strip.fibre_x = condition.fibre_T.x();
    strip.fibre_y = condition.fibre_T.y();
    strip.width = width;
    for (int flute = 0; flute < flutes.count(); ++flute) {
      const double lag = flutes.angle(flute) + point.lag;
      strip.sin_lag = std::sin(lag);
      strip.cos_lag = std::cos(lag);
      for (int arc = 0; arc < arcs.count; ++arc) {
        const auto [start, end] = arcs.ends[static_cast<std::size_t>(arc)];
        // Steps within the arc, brought to 0 ... steps; an arc may run over the end of the table.
        int from = static_cast<int>(std::ceil((start + lag) / kTurn * steps));
        int left = static_cast<int>(std::floor((end + lag) / kTurn * steps)) - from + 1;
        from = ((from % steps) + steps) % steps;
        while (left > 0) {
          const int count = std::min(left, steps - from);
          if (vectors) {
            const auto at = static_cast<std::size_t>(from);
            kernel::best().add_strip(curves, strip, &sine[at], &cosine[at],
                                     static_cast<std::size_t>(count), &result.x[at], &result.y[at],
                                     &result.z[at]);
          } else {
            add_one_by_one(law, condition, point, lag, width, from, count, steps, result);
          }
          left -= count;
          from = 0;
        }
      }
    }
  }
  return result;
}

}  // namespace osteomill::cutting
