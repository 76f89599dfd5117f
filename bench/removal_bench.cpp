// SPDX-License-Identifier: BSD-3-Clause
// Removal with the engagement map, steps a second of one thread's processor time, beside OpenVDB on
// the same cuts; and what a step costs against the stock, the cutter and what is newly touched.
#include <time.h>

#include <cmath>
#include <functional>

#include "bench.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/workpiece/phantoms.hpp"
#include "osteomill/workpiece/remover.hpp"
#include "removal_openvdb.hpp"

namespace {

using namespace osteomill;
using bench::Figure;
using workpiece::Vector3;
constexpr double mm = units::mm;

double processor_time() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

struct Cut {
  const char* name;
  bool ball;
  double diameter, spacing, depth, step;  // m
  double heading;                         // rad, against the rows of voxels
  double half_side = 30 * mm;             // of the stock
  double tilt = 0.0;                      // of the tool's axis, sideways, rad
  bool many_materials = false;
};

constexpr double kLength = 40 * mm;
constexpr double kHeight = 14 * mm;
constexpr int kRuns = 5;

Vector3 along_of(const Cut& cut) { return {std::cos(cut.heading), std::sin(cut.heading), 0.0}; }
Vector3 start_of(const Cut& cut) {
  const double half = std::min(0.5 * kLength, cut.half_side - 0.6 * cut.diameter);
  return Vector3(0.03 * mm, 0.02 * mm, -cut.depth) - half * along_of(cut);
}
int steps_of(const Cut& cut) {
  return static_cast<int>(std::lround(2.0 * start_of(cut).head<2>().norm() / cut.step));
}

/// Even bone, or of a hundred densities in no order, as a CT gives.
workpiece::Stock stock_of(const Cut& cut, const Vector3& low, const Vector3& high) {
  if (!cut.many_materials) return workpiece::block(low, high, {1900.0, 1.0}, cut.spacing);
  return {workpiece::cubes_over(low, high, cut.spacing), [&](const Vector3& p) {
            const double step =
                std::round(100.0 * std::abs(std::sin(p.x() / mm) * std::cos((p.y() + p.z()) / mm)));
            return workpiece::BoneSample{(low - p).cwiseMax(p - high).maxCoeff(),
                                         {300.0 + 16.0 * step, 0.1 + 0.009 * step}};
          }};
}

struct Measured {
  double rate = 0.0;      // steps/s, the best of the runs
  double per_step = 0.0;  // voxels newly taken
};

Measured ours(const Cut& cut, bool with_map = true) {
  const Vector3 side(cut.half_side, cut.half_side, 0.0);
  const workpiece::Stock whole = stock_of(cut, -side - kHeight * Vector3::UnitZ(), side);
  cutting::Cutter cutter;
  cutter.shape = cut.ball ? cutting::CutterShape::ball : cutting::CutterShape::cylindrical;
  cutter.radius = 0.5 * cut.diameter;
  cutter.cutting_length = 10 * mm;
  const Vector3 along = along_of(cut), start = start_of(cut);
  const Vector3 axis = Eigen::AngleAxisd(cut.tilt, along) * Vector3::UnitZ();
  const int steps = steps_of(cut);
  Measured measured;
  double weights = 0.0;
  for (int run = 0; run < kRuns; ++run) {
    workpiece::Stock stock = whole;
    workpiece::Remover remover(stock, cutter);
    const auto at = [&](double k) -> workpiece::ToolPose {
      return {start + cut.step * k * along, axis};
    };
    remover.step(at(0.0), at(0.01));
    double volume = 0.0;
    const double begin = processor_time();
    for (int k = 0; k < steps; ++k) {
      volume += remover.step(at(k == 0 ? 0.01 : k), at(k + 1)).volume;
      if (with_map) weights += remover.engagement().weights.front();
    }
    measured.rate = std::max(measured.rate, steps / (processor_time() - begin));
    measured.per_step = volume / std::pow(cut.spacing, 3) / steps;
  }
  if (!std::isfinite(weights)) std::abort();
  return measured;
}

double openvdb_rate(const Cut& cut, bool csg) {
  const Vector3 side(cut.half_side, cut.half_side, 0.0);
  const bench::VdbTool tool{cut.ball, 0.5 * cut.diameter};
  const Vector3 along = along_of(cut), start = start_of(cut);
  double best = 0.0;
  for (int run = 0; run < 2; ++run) {
    bench::VdbStock stock(-side - kHeight * Vector3::UnitZ(), side, cut.spacing);
    const int steps = std::min(steps_of(cut), csg ? 10 : 60);
    stock.cut_leaves(tool, start, start + 0.01 * cut.step * along);
    const double begin = processor_time();
    for (int k = 0; k < steps; ++k) {
      const Vector3 from = start + cut.step * k * along, to = from + cut.step * along;
      if (csg)
        stock.cut_csg(tool, to);
      else
        stock.cut_leaves(tool, from, to);
    }
    best = std::max(best, steps / (processor_time() - begin));
  }
  return best;
}

}  // namespace

int main() {
  std::vector<Figure> figures;
  const Cut cuts[] = {
      {"ball-8-mm-0.1-mm-1-mm-deep", true, 8 * mm, 0.1 * mm, 1 * mm, 0.1 * mm, 0.0},
      {"ball-8-mm-0.1-mm-1-mm-deep-oblique", true, 8 * mm, 0.1 * mm, 1 * mm, 0.1 * mm, 0.5},
      {"ball-8-mm-0.1-mm-buried", true, 8 * mm, 0.1 * mm, 8 * mm, 0.5 * mm, 0.0},
      {"ball-8-mm-0.1-mm-buried-oblique", true, 8 * mm, 0.1 * mm, 8 * mm, 0.5 * mm, 0.5},
      {"cylinder-3-mm-0.2-mm", false, 3 * mm, 0.2 * mm, 5 * mm, 0.2 * mm, 0.0},
      {"cylinder-3-mm-0.2-mm-oblique", false, 3 * mm, 0.2 * mm, 5 * mm, 0.2 * mm, 0.5},
  };
  for (const Cut& cut : cuts)
    figures.push_back({cut.name, ours(cut).rate, "steps/s", "OpenVDB, its leaves in their buffers",
                       openvdb_rate(cut, false)});
  for (const int at : {0, 2})
    figures.push_back({std::string(cuts[at].name) + "-csg", ours(cuts[at]).rate, "steps/s",
                       "OpenVDB, csgDifference", openvdb_rate(cuts[at], true)});
  for (const int at : {1, 3, 5}) {
    Cut cut = cuts[at];
    cut.tilt = 0.4;
    figures.push_back({std::string(cut.name) + "-tilted", ours(cut).rate, "steps/s"});
  }
  for (const int at : {0, 1, 2, 3}) {
    Cut cut = cuts[at];
    cut.many_materials = true;
    figures.push_back({std::string(cut.name) + "-many-materials", ours(cut).rate, "steps/s"});
  }
  // What a step costs.
  const auto cost = [&](const std::string& name, const Cut& cut) {
    const Measured measured = ours(cut, false);
    figures.push_back({"cost-" + name, 1e6 / measured.rate, "us"});
    figures.push_back({"touched-" + name, measured.per_step, "voxels"});
  };
  for (const double half : {8.0, 15.0, 30.0}) {
    Cut cut = cuts[0];
    cut.half_side = half * mm;
    cost(fmt::format("stock-{:g}-mm", 2.0 * half), cut);
  }
  for (const double step : {0.05, 0.1, 0.2, 0.5, 1.0}) {
    Cut cut = cuts[3];
    cut.step = step * mm;
    cost(fmt::format("step-{:g}-mm", step), cut);
  }
  for (const double diameter : {4.0, 8.0, 16.0}) {
    // The same 1 mm of depth: the ball's volume grows eightfold from one to the next.
    Cut cut = cuts[1];
    cut.diameter = diameter * mm;
    cost(fmt::format("ball-{:g}-mm", diameter), cut);
  }
  bench::print(figures);
}
