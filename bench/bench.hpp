// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <string>
#include <vector>

/// What every benchmark program needs: the best of many runs, and its figures as one JSON document
/// on standard output, as docs/guide/benchmarks.md has it. tools/bench.py runs the programs.
namespace osteomill::bench {

/// Shortest time of `runs` calls, s: on a shared machine the least disturbed one.
template <class Work>
double best_time(int runs, Work work) {
  double best = 1e300;
  for (int i = 0; i < runs; ++i) {
    const auto begin = std::chrono::steady_clock::now();
    work();
    const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - begin;
    best = std::min(best, spent.count());
  }
  return best;
}

struct Figure {
  std::string name;
  double value = 0.0;
  std::string unit;
  std::string baseline = "";  ///< what it is compared with; empty: nothing
  double baseline_value = 0.0;
};

/// Prints the document. `ratio` is how many times better than the baseline; for units with "/s" in
/// them more is better, otherwise less.
inline void print(const std::vector<Figure>& figures) {
  std::string text;
  for (const Figure& figure : figures) {
    if (!text.empty()) text += ",\n";
    text += fmt::format(R"(    {{"name": "{}", "value": {:.6g}, "unit": "{}")", figure.name,
                        figure.value, figure.unit);
    if (!figure.baseline.empty()) {
      const bool more = figure.unit.find("/s") != std::string::npos;
      const double ratio =
          more ? figure.value / figure.baseline_value : figure.baseline_value / figure.value;
      text += fmt::format(R"(, "baseline": "{}", "baseline_value": {:.6g}, "ratio": {:.4g})",
                          figure.baseline, figure.baseline_value, ratio);
    }
    text += "}";
  }
  fmt::print("{{\n  \"figures\": [\n{}\n  ]\n}}\n", text);
}

}  // namespace osteomill::bench
