// SPDX-License-Identifier: BSD-3-Clause
// Whole simulations, seconds of the cut a second of the computer: the tibia section of [sugita2009]
// with forces and control on one thread, and the craniotomy of the examples with 0.1 mm voxels and
// heat. Making the bone (reading the CT, too) and predicting the contacts are counted. One core is
// measured by processor time, since others may share the machine, two by the clock on the wall. The
// record of every period is the same, bit by bit, on one thread and on two.
#include <tbb/global_control.h>

#include <ctime>
#include <stdexcept>

#include "bench.hpp"
#include "osteomill/base/archive.hpp"
#include "osteomill/io/case_file.hpp"
#include "osteomill/io/simulated_run.hpp"

namespace {

using namespace osteomill;

struct Timed {
  double simulated = 0.0;    ///< s
  double wall = 0.0;         ///< s, the shortest
  double processor = 1e300;  ///< s, the shortest
  std::string steps;         ///< as they lie in memory
};

Timed run(const std::string& example, const std::vector<std::string>& overrides, int runs,
          std::size_t threads) {
  const tbb::global_control most(tbb::global_control::max_allowed_parallelism, threads);
  const std::vector<io::SimulateCase> cases =
      io::read_simulate_cases(io::read_case(OSTEOMILL_EXAMPLES "/" + example, overrides));
  Timed timed;
  timed.wall = bench::best_time(runs, [&] {
    const std::clock_t begin = std::clock();
    timed.simulated = 0.0;
    timed.steps.clear();
    Archive archive = Archive::saving([&](const void* from, std::size_t size) {
      timed.steps.append(static_cast<const char*>(from), size);
    });
    for (io::SimulatedRun& one : io::run_simulations(cases)) {
      timed.simulated += one.steps.back().time;
      archive(one.steps);
    }
    const double spent = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
    timed.processor = std::min(timed.processor, spent);
  });
  return timed;
}

bench::Figure figure(const std::string& name, double simulated, double spent) {
  return {name, simulated / spent, "s/s", "real time", 1.0};
}

}  // namespace

int main() {
  const Timed tibia = run("tibia_section.toml", {}, 5, 1);
  const std::vector<std::string> fine = {"stock.spacing_mm=0.1", "heat={}"};
  const Timed two = run("cranium_ct.toml", fine, 1, 2);
  const Timed one = run("cranium_ct.toml", fine, 1, 1);
  if (one.steps != two.steps) throw std::logic_error("the threads change the result");
  bench::print({figure("tibia-0.2mm-one-core", tibia.simulated, tibia.processor),
                figure("craniotomy-0.1mm-heat-two-cores", two.simulated, two.wall),
                figure("craniotomy-0.1mm-heat-one-core", one.simulated, one.processor)});
  return 0;
}
