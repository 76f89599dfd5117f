// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/identify/record_check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace osteomill::identify {
namespace {

constexpr Eigen::Index kRun = 3;         // samples in a row
constexpr Eigen::Index kSuspicious = 8;  // samples in such runs when the range is not known

/// Runs of three or more samples that `at` holds for.
template <class At>
std::vector<Segment> runs_where(Eigen::Index n, At at) {
  std::vector<Segment> runs;
  for (Eigen::Index i = 0; i < n;) {
    if (!at(i)) {
      ++i;
      continue;
    }
    Segment run{i, i};
    while (run.end < n && at(run.end)) ++run.end;
    if (run.size() >= kRun) runs.push_back(run);
    i = run.end;
  }
  return runs;
}

/// Middle one of n values.
template <class Value>
double median(Eigen::Index n, Value value) {
  std::vector<double> values;
  for (Eigen::Index i = 0; i < n; ++i) values.push_back(value(i));
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

std::vector<Saturation> find_saturation(const ForceRecord& record, const Eigen::Vector3d& range) {
  std::vector<Saturation> found;
  for (int axis = 0; axis < 3; ++axis) {
    const auto force = record.force.col(axis);
    if (force.size() == 0) continue;
    const double high = force.maxCoeff(), low = force.minCoeff();
    if (!(high > low)) continue;
    const auto look = [&](double level, auto at) {
      Saturation one{axis, level, runs_where(force.size(), at), 0};
      for (const Segment& run : one.runs) one.samples += run.size();
      const bool known = range[axis] > 0.0;
      if (one.samples >= (known ? kRun : kSuspicious)) found.push_back(std::move(one));
    };
    if (range[axis] > 0.0) {
      // A converter's last step may stay a thousandth below the nominal range.
      const double limit = 0.999 * range[axis];
      look(range[axis], [&](Eigen::Index i) { return force[i] >= limit; });
      look(-range[axis], [&](Eigen::Index i) { return force[i] <= -limit; });
    } else {
      look(high, [&](Eigen::Index i) { return force[i] == high; });
      look(low, [&](Eigen::Index i) { return force[i] == low; });
    }
  }
  return found;
}

TimeCheck check_time(const Eigen::VectorXd& time) {
  const Eigen::Index n = time.size();
  if (n < 3) {
    throw InvalidInput({"time", fmt::format("{} samples", n), "needs three at least", ""});
  }
  for (Eigen::Index i = 0; i + 1 < n; ++i) {
    if (!(time[i + 1] > time[i])) {
      throw InvalidInput({"time", fmt::format("{:.9g} s after {:.9g} s", time[i + 1], time[i]),
                          fmt::format("must grow; it does not at sample {}", i + 1),
                          "take out repeated samples, or set time = \"none\" and give rate_hz"});
    }
  }
  // Times are often printed with few digits, so that single steps are coarse: the step is that over
  // a hundred samples, and half a step counts as a gap only beyond twice what steps scatter.
  const Eigen::Index reach = std::clamp<Eigen::Index>(n / 4, 1, 100);
  const double step = median(n - reach, [&](Eigen::Index i) { return time[i + reach] - time[i]; }) /
                      static_cast<double>(reach);
  const auto excess = [&](Eigen::Index i) { return time[i + 1] - time[i] - step; };
  const double scatter = median(n - 1, [&](Eigen::Index i) { return std::abs(excess(i)); });
  TimeCheck out;
  double span = 0.0, count = 0.0;
  for (Eigen::Index i = 0; i + 1 < n; ++i) {
    if (excess(i) > 0.5 * step + 2.0 * scatter) {
      out.gaps.push_back({i, i + 2});
    } else {
      span += time[i + 1] - time[i];
      count += 1.0;
    }
  }
  out.rate = count / span;
  for (const Segment& gap : out.gaps) {
    out.missing += std::round((time[gap.begin + 1] - time[gap.begin]) * out.rate) - 1.0;
  }
  return out;
}

std::vector<std::string> sampling_warnings(double rate, double spindle_speed, int flutes) {
  const double line = flutes * spindle_speed / (2.0 * std::numbers::pi);
  if (!(line > 0.0)) return {};
  if (line >= 0.5 * rate) {
    const double seen = std::abs(line - std::round(line / rate) * rate);
    return {fmt::format(
        "the teeth pass at {:.1f} Hz, above half the sampling rate of {:g} Hz: the line shows at "
        "{:.1f} Hz instead, and no instantaneous force can be told from this record; its mean can",
        line, rate, seen)};
  }
  if (rate < 10.0 * line) {
    return {fmt::format(
        "{:.1f} samples a tooth ({:g} Hz for a tooth passing of {:.1f} Hz): harmonics of the tooth "
        "passing beyond the {}. are lost or folded",
        rate / line, rate, line, static_cast<int>(0.5 * rate / line))};
  }
  return {};
}

}  // namespace osteomill::identify
