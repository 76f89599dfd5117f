// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/simulate/summary.hpp"

#include <algorithm>

namespace osteomill::simulate {
namespace {

/// Sums over the samples in contact of some steps.
struct Contact {
  double first = 0.0;
  double last = 0.0;
  double sum_force = 0.0;
  long samples = 0;

  void add(const Step& step) {
    if (step.samples_in_contact == 0) return;
    if (samples == 0) first = step.first_contact;
    last = step.last_contact;
    sum_force += step.sum_force;
    samples += step.samples_in_contact;
  }
  double time() const { return last - first; }
  double mean_force() const {
    return samples == 0 ? 0.0 : sum_force / static_cast<double>(samples);
  }
};

}  // namespace

const char* name(Status status) {
  switch (status) {
    case Status::not_run:
      return "not run";
    case Status::finished:
      return "finished";
    case Status::stopped:
      return "stopped";
    case Status::supervisor:
      return "stopped by the supervisor";
    case Status::stalled:
      break;
  }
  return "stalled";
}

Summary summarise(const std::vector<Step>& steps, int lines, Status status) {
  Summary summary;
  summary.status = status;
  summary.steps = steps.size();
  Contact whole;
  std::vector<Contact> each_line(lines);
  for (const Step& step : steps) {
    whole.add(step);
    each_line[step.line].add(step);
    summary.peak_force = std::max(summary.peak_force, step.peak_force);
    summary.time_above_limit += step.time_above_limit;
    summary.removed_volume += step.removed_volume;
    summary.feed_work += step.feed_work;
    summary.spindle_work += step.spindle_work;
  }
  summary.cutting_time = whole.time();
  summary.first_contact = whole.first;
  summary.mean_force = whole.mean_force();
  for (const Contact& line : each_line) {
    summary.line_times.push_back(line.time());
    summary.line_mean_forces.push_back(line.mean_force());
  }

  std::vector<std::array<double, 2>>& intervals = summary.saturated_intervals;
  bool inside = false;
  double start = 0.0;
  for (const Step& step : steps) {
    if (step.samples_in_contact > 0) summary.max_feed = std::max(summary.max_feed, step.feed);
    const bool saturated = step.saturated && step.samples_in_contact > 0;
    if (saturated && !inside) intervals.push_back({start - whole.first, 0.0});
    if (saturated) intervals.back()[1] = step.time - whole.first;
    inside = saturated;
    start = step.time;
  }
  std::erase_if(intervals,
                [](const auto& interval) { return interval[1] - interval[0] < kShortestInterval; });
  return summary;
}

}  // namespace osteomill::simulate
