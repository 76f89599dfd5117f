// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/robot/size_study.hpp"

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <functional>
#include <mutex>
#include <nlopt.hpp>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"

namespace osteomill::robot {
namespace {

// Grid cells need no more than a hundredth of a millimetre; slopes and refined lengths do.
constexpr double kGridPrecision = 1e-5;
constexpr double kFinePrecision = 1e-8;

using Family = std::vector<PerCut<CutLine>>;

std::vector<double> steps(double low, double high, double step) {
  std::vector<double> values;
  const int count = static_cast<int>(std::floor((high - low) / step + 1e-9));
  for (int i = 0; i <= count; ++i) values.push_back(std::min(low + i * step, high));
  return values;
}

void check(const SizeStudyOptions& options) {
  const auto range = [](const char* field, double low, double high) {
    if (!(low > 0.0 && low <= high && high <= 1.0)) {
      throw InvalidInput(Fault{field,
                               fmt::format("{:g} ... {:g} mm", low / units::mm, high / units::mm),
                               "must rise from above 0 to at most 1000 mm", ""});
    }
  };
  range("size.l1_mm", options.l1_low, options.l1_high);
  range("size.l2_mm", options.l2_low, options.l2_high);
  require_positive("size.step_mm", options.step / units::mm, "mm");
  require_non_negative("robot.slide_stroke_mm", options.slide_stroke / units::mm, "mm");
}

/// What is minimised over the link lengths; empty where some implant has no place.
using Objective = std::function<std::optional<double>(double l1, double l2)>;

double slope(const Objective& objective, double l1, double l2, bool first,
             const SizeStudyOptions& options) {
  const double h = 0.02 * units::mm;
  const double low = first ? options.l1_low : options.l2_low;
  const double high = first ? options.l1_high : options.l2_high;
  const double at = first ? l1 : l2;
  const double up = std::min(high, at + h);
  const double down = std::max(low, at - h);
  const auto above = first ? objective(up, l2) : objective(l1, up);
  const auto below = first ? objective(down, l2) : objective(l1, down);
  return above && below && up > down ? (*above - *below) / (up - down) : 0.0;
}

LinkChoice choose(const SizeStudy& study, const std::vector<std::optional<double>>& surface,
                  const Objective& objective, const SizeStudyOptions& options) {
  LinkChoice best;
  for (std::size_t i = 0; i < surface.size(); ++i) {
    if (!surface[i] || (best.exists && *surface[i] >= best.value)) continue;
    best.exists = true;
    best.l1 = study.l1[i / study.l2.size()];
    best.l2 = study.l2[i % study.l2.size()];
    best.value = *surface[i];
  }
  if (!best.exists) return best;
  if (options.refine && options.l1_low < options.l1_high && options.l2_low < options.l2_high) {
    nlopt::opt optimiser(nlopt::LN_SBPLX, 2);
    optimiser.set_lower_bounds({options.l1_low, options.l2_low});
    optimiser.set_upper_bounds({options.l1_high, options.l2_high});
    optimiser.set_initial_step(0.5 * options.step);
    optimiser.set_xtol_abs(1e-6);
    optimiser.set_maxeval(300);
    auto function = [&objective](const std::vector<double>& v) {
      // A cell that serves not every implant is worse than any gap: 1 m.
      return objective(v[0], v[1]).value_or(1.0);
    };
    optimiser.set_min_objective(
        [](const std::vector<double>& v, std::vector<double>&, void* data) {
          return (*static_cast<decltype(function)*>(data))(v);
        },
        &function);
    std::vector<double> v{best.l1, best.l2};
    double value = 0.0;
    try {
      optimiser.optimize(v, value);
    } catch (const nlopt::roundoff_limited&) {
      value = function(v);  // NLopt leaves its best point in v
    }
    if (value < best.value) {
      best.l1 = v[0];
      best.l2 = v[1];
      best.value = value;
    }
  }
  best.slope_l1 = slope(objective, best.l1, best.l2, true, options);
  best.slope_l2 = slope(objective, best.l1, best.l2, false, options);
  return best;
}

}  // namespace

std::optional<double> largest_over_sizes(const GuidePositioner& robot,
                                         const std::vector<PerCut<CutLine>>& sizes,
                                         const PlacementOptions& options) {
  double largest = 0.0;
  for (const PerCut<CutLine>& lines : sizes) {
    const Placement placement = place(robot, lines, options);
    if (!placement.feasible) return std::nullopt;
    largest = std::max(largest, placement.largest_gap);
  }
  return largest;
}

SizeStudy study_sizes(const std::vector<ImplantFamily>& families, const SizeStudyOptions& options,
                      const Progress& progress) {
  check(options);
  if (families.empty()) {
    throw InvalidInput(Fault{"size.families", "", "must name at least one family", ""});
  }
  std::vector<Family> implants;
  long sizes = 0;
  for (const ImplantFamily& family : families) {
    Family& lines = implants.emplace_back();
    for (std::size_t size = 1; size <= family.anteroposterior.size(); ++size) {
      lines.push_back(cut_lines(profile_of(family, static_cast<int>(size)), options.cuts));
      ++sizes;
    }
  }

  SizeStudy study;
  study.l1 = steps(options.l1_low, options.l1_high, options.step);
  study.l2 = steps(options.l2_low, options.l2_high, options.step);
  const std::size_t cells = study.l1.size() * study.l2.size();
  if (cells > 1'000'000) {
    throw InvalidInput(Fault{"size.step_mm", fmt::format("{:g} mm", options.step / units::mm),
                             "must not make more than a million pairs of lengths",
                             "take a larger step"});
  }
  study.per_family.assign(families.size(), std::vector<std::optional<double>>(cells));
  study.largest.resize(cells);
  study.mean.resize(cells);
  study.placements = static_cast<long>(cells) * sizes;

  const auto placement_options = [&](double precision) {
    PlacementOptions placement;
    placement.branch = options.branch;
    placement.margin = options.margin;
    placement.precision = precision;
    return placement;
  };
  std::atomic<bool> stop{false};
  std::atomic<std::size_t> done{0};
  std::mutex reporting;
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, cells, 4), [&](const auto& range) {
    for (std::size_t cell = range.begin(); cell != range.end() && !stop; ++cell) {
      const GuidePositioner robot{.link1 = study.l1[cell / study.l2.size()],
                                  .link2 = study.l2[cell % study.l2.size()]};
      double largest = 0.0;
      double sum = 0.0;
      bool all = true;
      for (std::size_t f = 0; f < implants.size(); ++f) {
        const auto value =
            largest_over_sizes(robot, implants[f], placement_options(kGridPrecision));
        study.per_family[f][cell] = value;
        all = all && value.has_value();
        largest = std::max(largest, value.value_or(0.0));
        sum += value.value_or(0.0);
      }
      if (all) {
        study.largest[cell] = largest;
        study.mean[cell] = sum / static_cast<double>(implants.size());
      }
      ++done;
    }
    if (const std::unique_lock lock(reporting, std::try_to_lock); lock.owns_lock()) {
      const double share = static_cast<double>(done) / static_cast<double>(cells);
      if (!go_on(progress, "link lengths", share)) stop = true;
    }
  });
  if (stop) {
    study.stopped = true;
    return study;
  }

  const PlacementOptions fine = placement_options(kFinePrecision);
  const auto family_value = [&](std::size_t f, double l1, double l2) {
    return largest_over_sizes({.link1 = l1, .link2 = l2}, implants[f], fine);
  };
  const auto over_families = [&](bool mean) -> Objective {
    return [&, mean](double l1, double l2) -> std::optional<double> {
      double largest = 0.0;
      double sum = 0.0;
      for (std::size_t f = 0; f < implants.size(); ++f) {
        const auto value = family_value(f, l1, l2);
        if (!value) return std::nullopt;
        largest = std::max(largest, *value);
        sum += *value;
      }
      return mean ? sum / static_cast<double>(implants.size()) : largest;
    };
  };
  study.best_per_family.resize(implants.size());
  tbb::parallel_for(std::size_t{0}, implants.size() + 2, [&](std::size_t f) {
    if (f < implants.size()) {
      study.best_per_family[f] = choose(
          study, study.per_family[f],
          [&, f](double l1, double l2) { return family_value(f, l1, l2); }, options);
    } else if (f == implants.size()) {
      study.best_largest = choose(study, study.largest, over_families(false), options);
    } else {
      study.best_mean = choose(study, study.mean, over_families(true), options);
    }
  });
  for (std::size_t i = 0; i < cells && options.slide_stroke > 0.0; ++i) {
    if (!study.largest[i] || *study.largest[i] > options.slide_stroke) continue;
    study.most_compact = {
        true, study.l1[i / study.l2.size()], study.l2[i % study.l2.size()], *study.largest[i], 0.0,
        0.0};
    break;  // cells run from the shortest L1, and within it from the shortest L2
  }
  return study;
}

}  // namespace osteomill::robot
