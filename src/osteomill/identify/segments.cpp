// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/identify/segments.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "osteomill/base/error.hpp"
#include "osteomill/identify/envelope.hpp"

namespace osteomill::identify {
namespace {

/// The value that splits a sample into two classes with the largest variance between them,
/// [otsu1979], on 128 classes of the range.
double otsu_threshold(const Eigen::VectorXd& values) {
  constexpr int kClasses = 128;
  const double low = values.minCoeff(), high = values.maxCoeff();
  if (!(high > low)) return high;
  const double scale = kClasses / (high - low);
  std::array<double, kClasses> histogram{};
  for (const double value : values) {
    histogram[static_cast<std::size_t>(std::min(kClasses - 1.0, (value - low) * scale))] += 1.0;
  }
  double total = 0.0;
  for (std::size_t k = 0; k < kClasses; ++k) total += histogram[k] * static_cast<double>(k);
  const auto n = static_cast<double>(values.size());
  double below = 0.0, sum_below = 0.0, best = -1.0;
  std::size_t first = 0, last = 0;  // all splits of the empty stretch between the classes are best
  for (std::size_t k = 0; k + 1 < kClasses; ++k) {
    below += histogram[k];
    sum_below += histogram[k] * static_cast<double>(k);
    if (below == 0.0 || below == n) continue;
    const double apart = sum_below / below - (total - sum_below) / (n - below);
    const double between = below * (n - below) * apart * apart;
    // Splits that differ by rounding only are equal.
    if (between > best * (1.0 + 1e-12)) {
      best = between;
      first = last = k;
    } else if (between >= best * (1.0 - 1e-12)) {
      last = k;
    }
  }
  return low + (0.5 * static_cast<double>(first + last) + 1.0) / scale;
}

/// Stretches where `inside` holds; breaks shorter than `bridge` do not end them, and those shorter
/// than `shortest` are left out.
template <class Inside>
std::vector<Segment> stretches(Eigen::Index n, Eigen::Index bridge, Eigen::Index shortest,
                               Inside inside) {
  std::vector<Segment> out;
  for (Eigen::Index i = 0; i < n; ++i) {
    if (!inside(i)) continue;
    if (!out.empty() && i - out.back().end < bridge) {
      out.back().end = i + 1;
    } else {
      out.push_back({i, i + 1});
    }
  }
  std::erase_if(out, [&](const Segment& s) { return s.size() < shortest; });
  return out;
}

/// The idle parts' means as a straight line over the record, or one value.
struct IdleLine {
  Eigen::RowVector3d value = Eigen::RowVector3d::Zero();
  Eigen::RowVector3d slope = Eigen::RowVector3d::Zero();
  double middle = 0.0;
  Eigen::RowVector3d at(Eigen::Index i) const {
    return value + slope * (static_cast<double>(i) - middle);
  }
};

/// Mean and variance over a window.
struct Calm {
  double variance = INFINITY;
  double middle = 0.0;
  Eigen::RowVector3d mean = Eigen::RowVector3d::Zero();
};

/// The window between two samples where the force varies least.
Calm calmest(const Eigen::MatrixX3d& force, Eigen::Index begin, Eigen::Index end,
             Eigen::Index window) {
  Calm out;
  for (Eigen::Index i = begin; i + window <= end; i += std::max<Eigen::Index>(1, window / 4)) {
    const auto piece = force.middleRows(i, window);
    const Eigen::RowVector3d mean = piece.colwise().mean();
    const double variance = (piece.rowwise() - mean).squaredNorm() / static_cast<double>(window);
    if (variance < out.variance)
      out = {variance, static_cast<double>(i) + 0.5 * static_cast<double>(window - 1), mean};
  }
  return out;
}

/// Idle value to begin with: a line through the calmest windows of the first and the last quarter
/// where both are about as calm as the calmest of all, which then stands for a drift; otherwise
/// that one's mean.
IdleLine first_guess(const Eigen::MatrixX3d& force, Eigen::Index window) {
  const Eigen::Index n = force.rows(), quarter = std::max(window, n / 4);
  const Calm all = calmest(force, 0, n, window), head = calmest(force, 0, quarter, window),
             tail = calmest(force, n - quarter, n, window);
  const double spread =
      (force.rowwise() - force.colwise().mean()).squaredNorm() / static_cast<double>(n);
  // Variances of equal noise differ by less than four times; a drift within a window is tiny.
  const double calm = 4.0 * all.variance + 1e-6 * spread;
  IdleLine line{.value = all.mean, .middle = all.middle};
  if (head.variance <= calm && tail.variance <= calm && tail.middle > head.middle) {
    line.value = head.mean;
    line.middle = head.middle;
    line.slope = (tail.mean - head.mean) / (tail.middle - head.middle);
  }
  return line;
}

IdleLine line_through(const Eigen::MatrixX3d& force, const std::vector<Segment>& idle) {
  double n = 0.0, sum_t = 0.0, sum_tt = 0.0;
  Eigen::RowVector3d sum = Eigen::RowVector3d::Zero(), sum_tf = Eigen::RowVector3d::Zero();
  for (const Segment& part : idle) {
    for (Eigen::Index i = part.begin; i < part.end; ++i) {
      const auto t = static_cast<double>(i);
      n += 1.0;
      sum_t += t;
      sum_tt += t * t;
      sum += force.row(i);
      sum_tf += t * force.row(i);
    }
  }
  IdleLine line{.value = sum / n, .middle = sum_t / n};
  if (idle.size() >= 2)
    line.slope = (sum_tf - sum * line.middle) / (sum_tt - n * line.middle * line.middle);
  return line;
}

Eigen::VectorXd level_about(const Eigen::MatrixX3d& force, const IdleLine& line,
                            Eigen::Index window, Eigen::MatrixX3d& rest) {
  for (Eigen::Index i = 0; i < force.rows(); ++i) rest.row(i) = force.row(i) - line.at(i);
  return moving_rms(rest, window);
}

double rms_over(const Eigen::MatrixX3d& rest, const std::vector<Segment>& parts) {
  double sum = 0.0, n = 0.0;
  for (const Segment& part : parts) {
    sum += rest.middleRows(part.begin, part.size()).squaredNorm();
    n += static_cast<double>(part.size());
  }
  return n > 0.0 ? std::sqrt(sum / n) : 0.0;
}

/// The steady part of a cut, and how steady it is.
void set_plateau(Segmentation& out, const Segment& cut, const Eigen::VectorXd& level,
                 const SegmentOptions& options, double rate) {
  std::vector<double> sorted(level.data() + cut.begin, level.data() + cut.end);
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  const double median = *middle;
  const auto steady = [&](Eigen::Index i) {
    return std::abs(level[i] - median) <= options.settle_band * median;
  };
  Segment found = cut;
  while (found.size() > 1 && !steady(found.begin)) ++found.begin;
  while (found.size() > 1 && !steady(found.end - 1)) --found.end;
  const auto guard = static_cast<Eigen::Index>(options.guard * rate);
  if (found.size() <= 2 * guard) {
    throw InvalidInput({"signals.guard_s", fmt::format("{:g} s", options.guard),
                        fmt::format("leaves nothing of a plateau of {:.4g} s",
                                    static_cast<double>(found.size()) / rate),
                        "lower it"});
  }
  out.plateau = {found.begin + guard, found.end - guard};
  Eigen::Index within = 0;
  for (Eigen::Index i = out.plateau.begin; i < out.plateau.end; ++i) within += steady(i);
  out.steady = static_cast<double>(within) / static_cast<double>(out.plateau.size());
}

/// The plateau that was asked for.
Segment given_plateau(const std::array<double, 2>& from_to, const ForceRecord& record) {
  const auto begin = static_cast<Eigen::Index>(std::ceil(from_to[0] * record.rate));
  const auto end = static_cast<Eigen::Index>(std::ceil(from_to[1] * record.rate));
  if (begin < 0 || end <= begin || end > record.force.rows()) {
    throw InvalidInput({"signals.plateau_s", fmt::format("{:g} … {:g} s", from_to[0], from_to[1]),
                        fmt::format("must lie within the record of {:.4g} s", duration(record)),
                        ""});
  }
  return {begin, end};
}

}  // namespace

Segmentation segment(const ForceRecord& record, const SegmentOptions& options) {
  require_positive("signals.window_s", options.window, "s");
  const Eigen::Index n = record.force.rows();
  const auto window =
      std::max<Eigen::Index>(2, static_cast<Eigen::Index>(options.window * record.rate));
  if (n < 2 * window) {
    throw InvalidInput({"record", fmt::format("{} samples", n),
                        fmt::format("must be longer than two windows of {} samples", window),
                        "take a longer record or a shorter signals.window_s"});
  }
  const Segment all{0, n};
  const auto shortest = static_cast<Eigen::Index>(options.shortest_cut * record.rate);
  Segmentation out;
  Eigen::MatrixX3d rest(n, 3);
  IdleLine line = first_guess(record.force, window);
  Eigen::VectorXd level;
  // Twice: the idle value of the first round is a guess, that of the second is their mean.
  for (int round = 0; round < 2; ++round) {
    level = level_about(record.force, line, window, rest);
    // Ratios, not differences, tell an idle part from a light cut beside a heavy one.
    const double floor = 1e-4 * level.maxCoeff();
    const Eigen::VectorXd size = level.array().max(floor).max(1e-300).log().matrix();
    const double threshold = std::exp(otsu_threshold(size));
    out.cuts = stretches(n, window, shortest, [&](Eigen::Index i) { return level[i] > threshold; });
    out.idle = stretches(n, 1, 1, [&](Eigen::Index i) { return !(level[i] > threshold); });
    // The level rises half a window before the cut; another half keeps a soft entry out.
    for (Segment& part : out.idle) {
      if (part.begin > 0) part.begin += window / 2;
      if (part.end < n) part.end -= window / 2;
    }
    std::erase_if(out.idle, [&](const Segment& s) { return s.size() < window / 2; });
    out.idle_level = rms_over(rest, out.idle);
    out.cut_level = rms_over(rest, out.cuts);
    if (out.idle.empty() || out.cuts.empty() || out.cut_level < options.contrast * out.idle_level) {
      out.idle.clear();
      out.cuts = {all};
      out.whole = true;
      out.idle_level = 0.0;
      break;
    }
    // Where single samples rise above the threshold the cut begins: the window only comes near.
    for (Segment& cut : out.cuts) {
      const auto above = [&](Eigen::Index i) { return rest.row(i).norm() > threshold; };
      const Eigen::Index last = cut.end - 1;
      while (cut.begin < last && !above(cut.begin)) ++cut.begin;
      while (cut.end > cut.begin + 1 && !above(cut.end - 1)) --cut.end;
    }
    line = line_through(record.force, out.idle);
  }
  if (out.whole) {
    level = moving_rms(record.force, window);
    out.cut_level = rms_over(record.force, out.cuts);
  }
  if (options.plateau) {
    out.plateau = given_plateau(*options.plateau, record);
    return out;
  }
  const Segment longest =
      *std::max_element(out.cuts.begin(), out.cuts.end(),
                        [](const Segment& a, const Segment& b) { return a.size() < b.size(); });
  set_plateau(out, longest, level, options, record.rate);
  return out;
}

ForceRecord cut_out(const ForceRecord& record, const Segment& segment) {
  ForceRecord out{.rate = record.rate,
                  .force = record.force.middleRows(segment.begin, segment.size()),
                  .tacho = {},
                  .torque = {}};
  if (record.tacho.size() > 0) out.tacho = record.tacho.segment(segment.begin, segment.size());
  if (record.torque.size() > 0) out.torque = record.torque.segment(segment.begin, segment.size());
  return out;
}

}  // namespace osteomill::identify
