// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "osteomill/control/tuning.hpp"
#include "osteomill/io/simulated_run.hpp"

namespace osteomill::io {

class Section;

/// [tune] beside the tables of simulate: the published loop on a range of bones and delays.
struct TuneCase {
  SimulateCase job;  ///< its controller is the loop as it is
  control::TuningRange range;
  control::TuningGoal goal;
  double share = 0.95;  ///< of limits.force_n that a simulated peak may reach
};

void bind_tune(Section& section, TuneCase& to);
/// The same for `osteomill schema`.
void bind_tune_keys(Section& section);
TuneCase read_tune_case(const CaseRun& run);

/// One loop at one corner of the range. Gains are those on the sum of the taps, m/s per N.
struct TunedCorner {
  control::LinearPlant plant;
  double critical_gain = 0.0;
  control::Margins given_up, given_down, proposed_up, proposed_down;
};

/// How a loop does on the bone of the case.
struct TunedRun {
  std::string name;
  int delay = 1;
  simulate::Summary summary;
};

struct Tuning {
  control::SugitaLoop proposed;
  double entry_feed = 0.0;  ///< m/s
  /// Without servo and at one period of delay the loop is critical at this gain times K_f.
  double bare_critical_loop_gain = 0.0;
  std::vector<TunedCorner> corners;
  std::vector<TunedRun> runs;  ///< as given and as proposed, on a line profile; else none
  /// Where the bone of a line profile is none of the range, for which the margins hold.
  std::vector<std::string> warnings;
};

/// Gains from the margins; reference force and entry feed from the bone of the case where it is a
/// line profile: the largest at which no simulated peak passes the share of the limit. Throws
/// NoSolution when there is none.
Tuning tune(const TuneCase& input, const Progress& progress = {});

}  // namespace osteomill::io
