// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/signal_export.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "osteomill/base/units.hpp"

namespace osteomill::io {
namespace {

Signal signal(const std::string& name, const std::string& unit, const Eigen::VectorXd& values,
              const std::string& about) {
  return {name, unit, {values.data(), values.data() + values.size()}, about};
}

}  // namespace

SignalRun signals_of(const identify::ForceRecord& raw, const identify::ProcessedRecord& processed,
                     const identify::SignalChain& chain, const identify::CutOfRecord& cut,
                     const std::string& name) {
  SignalRun out{.name = name, .signals = {}};
  // Experiments may be called anything; groups of HDF5 may not.
  std::replace(out.name.begin(), out.name.end(), '/', '_');
  const Eigen::Index n = raw.force.rows();
  const double last = n > 0 ? static_cast<double>(n - 1) / raw.rate : 0.0;
  out.signals.push_back(signal("time", "s", Eigen::VectorXd::LinSpaced(n, 0.0, last), ""));
  for (int axis = 0; axis < 3; ++axis) {
    out.signals.push_back(signal(fmt::format("force_{}", "xyz"[axis]), "N", raw.force.col(axis),
                                 "on the tool, in the tool frame, as read"));
  }
  for (int axis = 0; axis < 3; ++axis) {
    out.signals.push_back(signal(fmt::format("processed_force_{}", "xyz"[axis]), "N",
                                 processed.record.force.col(axis),
                                 "after compensation, baseline and filter"));
  }
  for (std::size_t axis = 0; axis < processed.envelope.size(); ++axis) {
    const identify::Segment& plateau = processed.segments.plateau;
    if (axis == 0) {
      out.signals.push_back(signal(
          "plateau_time", "s",
          Eigen::VectorXd::LinSpaced(plateau.size(), static_cast<double>(plateau.begin) / raw.rate,
                                     static_cast<double>(plateau.end - 1) / raw.rate),
          "of the envelopes"));
    }
    out.signals.push_back(signal(fmt::format("envelope_low_{}", "xyz"[axis]), "N",
                                 processed.envelope[axis].lower, "of the plateau"));
    out.signals.push_back(signal(fmt::format("envelope_high_{}", "xyz"[axis]), "N",
                                 processed.envelope[axis].upper, "of the plateau"));
  }
  if (raw.tacho.size() > 0)
    out.signals.push_back(signal("tacho", "1", raw.tacho, "once a revolution, as read"));
  if (processed.revolution) {
    const identify::RevolutionAverage& average = *processed.revolution;
    out.signals.push_back(
        signal("revolution_angle", "deg", average.angle / units::deg, "of each bin's samples"));
    for (int axis = 0; axis < 3; ++axis) {
      out.signals.push_back(signal(fmt::format("revolution_force_{}", "xyz"[axis]), "N",
                                   average.force.col(axis), "mean over the revolutions"));
      out.signals.push_back(signal(fmt::format("revolution_standard_error_{}", "xyz"[axis]), "N",
                                   average.standard_error.col(axis), ""));
    }
  }
  out.attributes["rate_hz"] = raw.rate;
  out.attributes["plateau_begin_s"] =
      static_cast<double>(processed.segments.plateau.begin) / raw.rate;
  out.attributes["plateau_end_s"] = static_cast<double>(processed.segments.plateau.end) / raw.rate;
  out.attributes["filter_order"] = std::int64_t{chain.filter_order};
  out.attributes["cutoff_hz"] = chain.filter_order > 0 ? identify::cutoff_of(chain, cut) : 0.0;
  out.attributes["spindle_speed_rpm"] =
      (processed.rotation ? processed.rotation->spindle_speed : cut.spindle_speed) / units::rpm;
  out.attributes["steps"] = fmt::format("{}", fmt::join(processed.steps, "\n"));
  return out;
}

}  // namespace osteomill::io
