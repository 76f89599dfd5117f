// SPDX-License-Identifier: BSD-3-Clause
// The robot's place: one implant, certified, on one core, beside a plain grid search of 0.05 mm;
// and the study of 36 x 36 link lengths over ten shapes of seven sizes.
#include "bench.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/robot/size_study.hpp"

namespace {

using namespace osteomill;
using namespace osteomill::robot;
using units::mm;

/// Ten families around the generic one.
std::vector<ImplantFamily> shapes() {
  std::vector<ImplantFamily> list;
  for (int i = 0; i < 10; ++i) {
    ImplantFamily family = generic_family();
    family.distal_half_length = 0.20 + 0.008 * i;
    family.anterior = 0.50 + 0.005 * i;
    family.posterior = 0.44 + 0.006 * i;
    family.anterior_tilt = (2.0 + 0.6 * i) * units::deg;
    list.push_back(family);
  }
  return list;
}

double grid_search(const GuidePositioner& robot, const PerCut<CutLine>& lines) {
  double best = 1.0;
  for (double x = -50.0 * mm; x < 0.0; x += 0.05 * mm) {
    for (double y = -25.0 * mm; y < 25.0 * mm; y += 0.05 * mm) {
      const GapReport report = gaps_at(robot, lines, {x, y});
      if (report.allowed) best = std::min(best, report.largest_gap);
    }
  }
  return best;
}

}  // namespace

int main() {
  const GuidePositioner robot{.link1 = 60.0 * mm, .link2 = 30.0 * mm};
  const PerCut<CutLine> lines = cut_lines(profile_of(generic_family(), 4));
  double keep = 0.0;
  const double certified = bench::best_time(200, [&] { keep += place(robot, lines).largest_gap; });
  const double grid = bench::best_time(3, [&] { keep += grid_search(robot, lines); });
  SizeStudyOptions options;
  const auto families = shapes();
  const double study =
      bench::best_time(2, [&] { keep += study_sizes(families, options).best_mean.value; });
  if (!(keep > 0.0)) return 1;
  bench::print({{"placement", 1e3 * certified, "ms", "grid of 0.05 mm", 1e3 * grid},
                {"size-study", study, "s"}});
  return 0;
}
