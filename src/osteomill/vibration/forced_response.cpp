// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/vibration/forced_response.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <mutex>
#include <numbers>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/cutting/flutes.hpp"

namespace osteomill::vibration {
namespace {

using Complex = std::complex<double>;
constexpr double kTurn = 2.0 * std::numbers::pi;

double largest_distance(const std::vector<double>& x, const std::vector<double>& y) {
  double largest = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) largest = std::max(largest, std::hypot(x[i], y[i]));
  return largest;
}

}  // namespace

ForcedMotion forced_motion(const Receptance& receptance, const cutting::Cutter& cutter,
                           const cutting::CuttingLaw& law, const cutting::Condition& condition,
                           const cutting::Immersion& immersion, int steps) {
  require_within("options.steps", steps, 8.0, 4096.0, "");
  const cutting::Revolution turn =
      cutting::revolution(cutter, law, condition, immersion, steps * cutter.flutes);
  // Equal flutes repeat with the pitch, others with the revolution.
  const bool equal = cutting::Flutes(cutter).equal();
  const double tooth_hz = condition.spindle_speed * (equal ? cutter.flutes : 1) / kTurn;
  const std::size_t n = equal ? static_cast<std::size_t>(steps) : turn.loads.size();
  ForcedMotion motion;
  for (auto* list : {&motion.x, &motion.y, &motion.static_x, &motion.static_y}) list->resize(n);
  const TipReceptance still = receptance(0.0);
  std::vector<Complex> roots(n);
  for (std::size_t i = 0; i < n; ++i) {
    roots[i] = std::polar(1.0, kTurn * static_cast<double>(i) / static_cast<double>(n));
  }
  // Lines up to half the sampling; the last one is left out.
  for (std::size_t k = 0; k < n / 2; ++k) {
    Complex fx = 0.0, fy = 0.0;
    for (std::size_t i = 0; i < n; ++i) {
      const geometry::Vector3& f = turn.loads[i].force;
      const Complex turn_back = std::conj(roots[k * i % n]);
      fx += f.x() * turn_back;
      fy += f.y() * turn_back;
    }
    const double share = (k == 0 ? 1.0 : 2.0) / static_cast<double>(n);
    const TipReceptance h = receptance(static_cast<double>(k) * tooth_hz);
    const Complex dx = share * (h.xx * fx + h.xy * fy), dy = share * (h.xy * fx + h.yy * fy);
    const Complex sx = share * (still.xx * fx + still.xy * fy);
    const Complex sy = share * (still.xy * fx + still.yy * fy);
    for (std::size_t i = 0; i < n; ++i) {
      const Complex forward = roots[k * i % n];
      motion.x[i] += (dx * forward).real();
      motion.y[i] += (dy * forward).real();
      motion.static_x[i] += (sx * forward).real();
      motion.static_y[i] += (sy * forward).real();
    }
  }
  return motion;
}

std::vector<ForcedPoint> forced_sweep(const Receptance& receptance, const cutting::Cutter& cutter,
                                      const cutting::CuttingLaw& law,
                                      const cutting::Condition& condition,
                                      const cutting::Immersion& immersion,
                                      const std::vector<double>& speeds,
                                      const std::vector<double>& feed_rates,
                                      const Progress& progress) {
  for (const double speed : speeds) {
    require_positive("options.spindle_speeds_rpm", speed / units::rpm, "rpm");
  }
  for (const double feed : feed_rates) {
    require_positive("options.feed_rates_mm_per_s", feed / units::mm_per_s, "mm/s");
  }
  std::vector<ForcedPoint> points(speeds.size() * feed_rates.size());
  std::atomic<std::size_t> done = 0;
  std::atomic<bool> stopped = false;
  std::mutex mutex;
  tbb::parallel_for(std::size_t{0}, points.size(), [&](std::size_t i) {
    if (stopped) return;
    ForcedPoint& point = points[i];
    point.spindle_speed = speeds[i % speeds.size()];
    point.feed_rate = feed_rates[i / speeds.size()];
    cutting::Condition one = condition;
    one.spindle_speed = point.spindle_speed;
    one.feed_per_tooth =
        cutting::feed_per_tooth(point.feed_rate, point.spindle_speed, cutter.flutes);
    const ForcedMotion motion = forced_motion(receptance, cutter, law, one, immersion);
    point.peak = largest_distance(motion.x, motion.y);
    point.static_peak = largest_distance(motion.static_x, motion.static_y);
    for (const double y : motion.y) point.peak_normal = std::max(point.peak_normal, std::abs(y));
    const std::size_t so_far = ++done;
    if (const std::unique_lock lock(mutex, std::try_to_lock); lock.owns_lock()) {
      const double share = static_cast<double>(so_far) / static_cast<double>(points.size());
      if (!go_on(progress, "forced vibration", share)) stopped = true;
    }
  });
  if (stopped) throw NoSolution("forced vibration: stopped before it was done");
  return points;
}

std::vector<ResonanceSpeed> resonance_speeds(const std::vector<double>& natural_frequencies_hz,
                                             int flutes, int harmonics, double low, double high) {
  require_within("cutter.flutes", flutes, 1.0, 64.0, "");
  std::vector<ResonanceSpeed> speeds;
  for (std::size_t mode = 0; mode < natural_frequencies_hz.size(); ++mode) {
    for (int r = 1; r <= harmonics; ++r) {
      const double speed = kTurn * natural_frequencies_hz[mode] / (r * flutes);
      if (speed >= low && speed <= high) {
        speeds.push_back({speed, static_cast<int>(mode) + 1, r});
      }
    }
  }
  std::sort(speeds.begin(), speeds.end(),
            [](const auto& a, const auto& b) { return a.spindle_speed < b.spindle_speed; });
  return speeds;
}

std::vector<CalmRange> calm_ranges(const std::vector<ForcedPoint>& sweep,
                                   double largest_amplification) {
  std::vector<CalmRange> ranges;
  double smallest = 0.0;
  bool inside = false;
  for (const ForcedPoint& point : sweep) {
    const bool calm = point.amplification() <= largest_amplification;
    if (calm && !inside) {
      ranges.push_back({point.spindle_speed, point.spindle_speed, point.spindle_speed});
      smallest = point.peak;
    } else if (calm) {
      ranges.back().high = point.spindle_speed;
      if (point.peak < smallest) {
        smallest = point.peak;
        ranges.back().calmest = point.spindle_speed;
      }
    }
    inside = calm;
  }
  std::erase_if(ranges, [](const CalmRange& range) { return range.low == range.high; });
  return ranges;
}

}  // namespace osteomill::vibration
