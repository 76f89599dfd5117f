// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/vibration/stability.hpp"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <atomic>
#include <cmath>
#include <mutex>
#include <numbers>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/vibration/floquet.hpp"
#include "osteomill/vibration/frequency_domain.hpp"
#include "osteomill/vibration/time_domain_maps.hpp"

namespace osteomill::vibration {
namespace {

constexpr double kNone = std::numeric_limits<double>::infinity();
constexpr double kTurn = 2.0 * std::numbers::pi;

int steps_of(const RegenerativeSystem& system, double speed, const StabilityOptions& options) {
  return options.steps > 0 ? options.steps : default_steps(system, speed);
}

DelayMap map_of(const RegenerativeSystem& system, double speed, double depth,
                const StabilityOptions& options) {
  const int steps = steps_of(system, speed, options);
  return options.method == StabilityMethod::full_discretisation
             ? full_discretisation(system, speed, depth, steps)
             : semi_discretisation(system, speed, depth, steps);
}

/// What happens at the limit: from the multiplier and the motion that belongs to it.
void describe_limit(const RegenerativeSystem& system, const StabilityOptions& options,
                    LobePoint& point) {
  StabilityOptions semi = options;
  if (semi.method == StabilityMethod::collocation) {
    semi.method = StabilityMethod::semi_discretisation;
  }
  const DelayMap map = map_of(system, point.spindle_speed, point.limit_depth, semi);
  const std::complex<double> mu = dominant_multiplier(map).value;
  const double angle = std::arg(mu);
  point.bifurcation = Bifurcation::hopf;
  if (std::abs(mu.imag()) < 1e-6 * std::abs(mu)) {
    point.bifurcation = mu.real() < 0.0 ? Bifurcation::flip : Bifurcation::fold;
  }
  // d(t) = e^{i angle t/T} × periodic: the strongest line of the periodic part names the frequency.
  const Eigen::MatrixXcd motion = dominant_motion(map, mu);
  const Eigen::Index m = motion.cols();
  const double period = system.tooth_period(point.spindle_speed);
  double strongest = -1.0;
  for (Eigen::Index k = -m / 2; k < m / 2; ++k) {
    Eigen::VectorXcd line = Eigen::VectorXcd::Zero(motion.rows());
    for (Eigen::Index i = 0; i < m; ++i) {
      const double t = static_cast<double>(i) / static_cast<double>(m);
      line += motion.col(i) * std::polar(1.0, -(angle + kTurn * static_cast<double>(k)) * t);
    }
    if (line.norm() > strongest) {
      strongest = line.norm();
      point.chatter_frequency_hz = std::abs(angle / kTurn + static_cast<double>(k)) / period;
    }
  }
}

/// Regula falsi with the Illinois step on log ρ between a stable and an unstable depth.
double between(const RegenerativeSystem& system, double speed, const StabilityOptions& options,
               double low, double f_low, double high, double f_high) {
  int side = 0;
  for (int i = 0; i < 60 && high - low > 1e-7 * high; ++i) {
    double middle = (low * f_high - high * f_low) / (f_high - f_low);
    if (!(middle > low && middle < high)) middle = 0.5 * (low + high);
    const double f = std::log(spectral_radius(system, speed, middle, options));
    if (std::abs(f) < 1e-9) return middle;
    if (f < 0.0) {
      low = middle;
      f_low = f;
      if (side == -1) f_high *= 0.5;
      side = -1;
    } else {
      high = middle;
      f_high = f;
      if (side == 1) f_low *= 0.5;
      side = 1;
    }
  }
  return high;
}

/// Scan upwards from a depth that is far below every limit. Where the growth has a summit close
/// below zero between three depths, the summit itself is sought: a thin island may rise above it.
double scanned_limit(const RegenerativeSystem& system, double speed, double first,
                     const StabilityOptions& options) {
  struct Sample {
    double depth, growth;
  };
  const auto sample = [&](double depth) {
    return Sample{depth, std::log(spectral_radius(system, speed, depth, options))};
  };
  const auto root = [&](const Sample& low, const Sample& high) {
    return between(system, speed, options, low.depth, low.growth, high.depth, high.growth);
  };
  Sample before = sample(0.0), last = before;
  for (double depth = std::min(first, options.max_depth);;
       depth = std::min(depth * options.scan_ratio, options.max_depth)) {
    const Sample now = sample(depth);
    if (last.growth > before.growth && last.growth > now.growth && last.growth > -0.3) {
      Sample low = before, top = last, high = now;
      while (high.depth - low.depth > 1e-3 * high.depth && top.growth < 0.0) {
        const bool right = high.depth - top.depth > top.depth - low.depth;
        const Sample probe =
            sample(right ? 0.5 * (top.depth + high.depth) : 0.5 * (low.depth + top.depth));
        if (probe.growth > top.growth) {
          (right ? low : high) = top;
          top = probe;
        } else {
          (right ? high : low) = probe;
        }
      }
      if (top.growth >= 0.0) return root(low, top);
    }
    if (now.growth >= 0.0) return root(last, now);
    if (depth >= options.max_depth) return kNone;
    before = last;
    last = now;
  }
}

/// Where a scan starts: half the zero-order minimum. Should the cut already chatter there, the
/// limit is sought between nothing and that depth.
double first_depth(const RegenerativeSystem& system, const StabilityOptions& options) {
  const double minimum = ZeroOrder(system, 1000).absolute_minimum().depth;
  return std::isfinite(minimum) ? 0.5 * minimum : 0.01 * options.max_depth;
}

void check_options(const std::vector<double>& speeds, const StabilityOptions& options) {
  for (const double speed : speeds) {
    require_positive("options.spindle_speeds_rpm", speed / units::rpm, "rpm");
  }
  require_positive("options.max_depth_mm", options.max_depth / units::mm, "mm");
  require_within("options.scan_ratio", options.scan_ratio, 1.001, 2.0, "");
  if (options.steps != 0) require_within("options.steps", options.steps, 4.0, 100000.0, "");
}

/// Runs body(i) for all i on threads, reports progress from whichever thread has the lock.
template <class Body>
void in_parallel(std::size_t count, const Progress& progress, const Body& body) {
  std::atomic<std::size_t> done = 0;
  std::atomic<bool> stopped = false;
  std::mutex mutex;
  tbb::parallel_for(std::size_t{0}, count, [&](std::size_t i) {
    if (stopped) return;
    body(i);
    const std::size_t so_far = ++done;
    if (const std::unique_lock lock(mutex, std::try_to_lock); lock.owns_lock()) {
      if (!go_on(progress, "stability", static_cast<double>(so_far) / static_cast<double>(count))) {
        stopped = true;
      }
    }
  });
  if (stopped) throw NoSolution("stability: stopped before it was done");
}

LobePoint frequency_domain_point(const RegenerativeSystem& system, double speed,
                                 const StabilityOptions& options, const ZeroOrder& zero_order) {
  const FrequencyDomainLimit limit =
      options.method == StabilityMethod::zero_order
          ? zero_order.limit(speed)
          : multi_frequency_limit(system, speed, options.harmonics, options.max_depth);
  LobePoint point{.spindle_speed = speed};
  if (limit.depth <= options.max_depth) {
    point.limit_depth = limit.depth;
    point.chatter_frequency_hz = limit.chatter_frequency_hz;
    point.bifurcation = limit.flip ? Bifurcation::flip : Bifurcation::hopf;
  }
  return point;
}

}  // namespace

double spectral_radius(const RegenerativeSystem& system, double spindle_speed, double depth,
                       const StabilityOptions& options) {
  switch (options.method) {
    case StabilityMethod::semi_discretisation:
    case StabilityMethod::full_discretisation:
      return std::abs(dominant_multiplier(map_of(system, spindle_speed, depth, options)).value);
    case StabilityMethod::collocation:
      return std::abs(
          collocation_multiplier(system, spindle_speed, depth,
                                 std::max(4, steps_of(system, spindle_speed, options) / 4))
              .value);
    default:
      throw InvalidInput(Fault{"options.method", "a frequency-domain method",
                               "has no Floquet multiplier", "use \"semi-discretisation\""});
  }
}

std::vector<LobePoint> lobes(const RegenerativeSystem& system, const std::vector<double>& speeds,
                             const StabilityOptions& options) {
  check_options(speeds, options);
  const bool frequency_domain = options.method == StabilityMethod::zero_order ||
                                options.method == StabilityMethod::multi_frequency;
  const ZeroOrder zero_order(system, frequency_domain ? 4000 : 100);
  const double first = frequency_domain ? 0.0 : first_depth(system, options);
  std::vector<LobePoint> points(speeds.size());
  in_parallel(speeds.size(), options.progress, [&](std::size_t i) {
    if (frequency_domain) {
      points[i] = frequency_domain_point(system, speeds[i], options, zero_order);
      return;
    }
    points[i].spindle_speed = speeds[i];
    points[i].limit_depth = scanned_limit(system, speeds[i], first, options);
    if (points[i].limit_depth < kNone) describe_limit(system, options, points[i]);
  });
  return points;
}

std::vector<LobePoint> lobes_by_continuation(const RegenerativeSystem& system,
                                             const std::vector<double>& speeds,
                                             const StabilityOptions& options) {
  check_options(speeds, options);
  const double first = first_depth(system, options);
  constexpr std::size_t block = 16;  // fixed, so that the answer is the same for any thread count
  const std::size_t blocks = (speeds.size() + block - 1) / block;
  std::vector<LobePoint> points(speeds.size());
  const auto log_radius = [&](double speed, double depth) {
    return std::log(spectral_radius(system, speed, depth, options));
  };
  in_parallel(blocks, options.progress, [&](std::size_t b) {
    double previous = kNone;
    for (std::size_t i = b * block; i < std::min(speeds.size(), (b + 1) * block); ++i) {
      LobePoint& point = points[i];
      point.spindle_speed = speeds[i];
      if (previous == kNone) {
        point.limit_depth = scanned_limit(system, speeds[i], first, options);
      } else {
        double low = previous, f_low = log_radius(speeds[i], low);
        double high = low, f_high = f_low, stretch = 1.03;
        while (f_low >= 0.0) {
          high = low;
          f_high = f_low;
          low = low > 1e-3 * first ? low / stretch : 0.0;
          f_low = log_radius(speeds[i], low);
          stretch *= stretch;
        }
        while (f_high < 0.0 && high < options.max_depth) {
          low = high;
          f_low = f_high;
          high = std::min(high * stretch, options.max_depth);
          f_high = log_radius(speeds[i], high);
          stretch = std::min(stretch * stretch, 1.3);
        }
        point.limit_depth =
            f_high < 0.0 ? kNone : between(system, speeds[i], options, low, f_low, high, f_high);
      }
      previous = point.limit_depth;
      if (point.limit_depth < kNone) describe_limit(system, options, point);
    }
  });
  return points;
}

std::vector<double> stability_map(const RegenerativeSystem& system,
                                  const std::vector<double>& speeds,
                                  const std::vector<double>& depths,
                                  const StabilityOptions& options) {
  check_options(speeds, options);
  std::vector<double> radii(speeds.size() * depths.size());
  in_parallel(speeds.size(), options.progress, [&](std::size_t i) {
    for (std::size_t k = 0; k < depths.size(); ++k) {
      radii[i * depths.size() + k] = spectral_radius(system, speeds[i], depths[k], options);
    }
  });
  return radii;
}

}  // namespace osteomill::vibration
