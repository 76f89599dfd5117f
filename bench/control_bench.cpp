// SPDX-License-Identifier: BSD-3-Clause
// The real-time part of the control loop, in three parts that end by themselves:
//   step            time of a control step, controller and supervisor, over a simulated cut
//   jitter SECONDS  lateness of the wake-ups of a loop of 1 ms that has nothing else to do
//   ingest SECONDS FILE  records of a fake Net F/T sensor at 8 kHz over UDP loopback to client and
//                   recorder, and the file read again
#include <atomic>
#include <cmath>
#include <cstdlib>
#include <string_view>
#include <thread>

#include "bench.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/control/loop.hpp"
#include "osteomill/io/netft_fake.hpp"
#include "osteomill/io/paced_plant.hpp"
#include "osteomill/io/real_time.hpp"
#include "osteomill/io/recording.hpp"
#include "osteomill/io/simulated_plant.hpp"
#include "osteomill/simulate/line_profile.hpp"

namespace osteomill::bench {
namespace {

constexpr double kMicro = 1e-6;

double now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

double quantile(std::vector<double>& values, double share) {
  const auto at = static_cast<std::size_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(at), values.end());
  return values[at];
}

control::FeedController with(decltype(control::FeedController::law) law) {
  control::FeedController controller;
  controller.law = std::move(law);
  controller.limits.lowest = 0.4e-3;
  controller.predictive = control::PredictiveMode{};
  return controller;
}

/// Sixty lines of bone, some 50 000 periods.
std::vector<double> step_times(const control::FeedController& controller) {
  simulate::LineProfile profile;
  profile.zones = {{0.0, 66e-3, 3250.0, {}, {}}};
  profile.lines = 60;
  simulate::LineProfileWorkpiece bone(profile);
  simulate::Machine machine;
  machine.spindle_speed = 6000 * units::rpm;
  machine.servo = numerics::SecondOrderLag{118.0, 0.7};
  machine.force_noise = 0.5;
  simulate::Milling milling(bone, machine, 30.0);
  io::SimulatedPlant plant(milling);
  control::LoopOptions options;
  options.path_length = bone.length();
  options.supervisor = control::SupervisorLimits{};
  options.clock = now;
  return control::run(plant, controller, options).compute_times;
}

void print_steps() {
  std::vector<Figure> figures;
  const auto add = [&](const std::string& name, const control::FeedController& controller) {
    std::vector<double> times = step_times(controller);
    figures.push_back({name, quantile(times, 0.5) / kMicro, "us"});
    figures.push_back({name + "-p999", quantile(times, 0.999) / kMicro, "us"});
  };
  io::ask_for_real_time();
  add("control-step", with(control::ModelAdaptive({})));
  add("control-step-sugita", with(control::SugitaLoop{}));
  add("control-step-constant", with(control::ConstantFeed{}));
  print(figures);
}

void print_jitter(double seconds) {
  class Still final : public control::Plant {
   public:
    control::Observation start() override { return {}; }
    control::Observation advance(const control::FeedCommand&) override { return {}; }
  };
  Still still;
  constexpr double kPeriod = 1e-3;
  io::PacedPlant paced(still, kPeriod);
  paced.start();
  const auto periods = static_cast<long>(seconds / kPeriod);
  for (long i = 0; i < periods; ++i) paced.advance({});
  print({{"jitter", paced.largest_lateness() / kMicro, "us"},
         {"jitter-p50", paced.lateness(0.5) / kMicro, "us"},
         {"jitter-p999", paced.lateness(0.999) / kMicro, "us"},
         {"jitter-real-time", paced.real_time() ? 1.0 : 0.0, "granted"}});
}

/// Ends with status 1 when a sample was lost.
int print_ingest(double seconds, const std::string& file) {
  constexpr double kMillisecond = 1e-3;
  constexpr std::size_t kPerMillisecond = 8;
  io::netft::FakeSensor sensor({.noise = 0.02});
  io::netft::Client client({.address = "127.0.0.1", .port = sensor.port()}, now);
  io::Recorder recorder(file, {.real_time = true});
  std::atomic<bool> over{false};
  double longest_gap = 0.0;
  client.start();
  std::thread receiver([&] {
    io::ask_for_real_time();
    std::vector<io::netft::Sample> arrived;
    arrived.reserve(1 << 16);
    double before = now();
    while (true) {
      const bool last = over;
      arrived.clear();
      client.receive(arrived);
      recorder.add(arrived);
      longest_gap = std::max(longest_gap, now() - before);
      before = now();
      if (last) return;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  });
  // The sensor's own clock: eight samples a millisecond, all of them, also after a late wake-up.
  std::thread sender([&] {
    io::ask_for_real_time(70);
    const std::vector<io::netft::Sample> load(kPerMillisecond,
                                              {{3.0, 12.0, -4.0}, {0.0, 0.0, 0.02}, 0});
    const double begin = now();
    for (long sent = 0; sent < static_cast<long>(seconds / kMillisecond); ++sent) {
      const double due = begin + static_cast<double>(sent) * kMillisecond;
      if (const double left = due - now(); left > 0.0) {
        std::this_thread::sleep_for(std::chrono::duration<double>(left));
      }
      sensor.measure(load);
    }
  });
  const double begin = now();
  sender.join();
  std::this_thread::sleep_for(std::chrono::milliseconds(50));  // the last are on their way
  over = true;
  receiver.join();
  const double took = now() - begin;
  recorder.finish();
  const std::vector<io::netft::Sample> recorded = io::read_recording(file).samples;
  std::uint64_t gaps = 0;
  for (std::size_t i = 0; i < recorded.size(); ++i) gaps += recorded[i].number != i + 1 ? 1 : 0;
  const io::netft::Health& health = client.health();
  const double sent = std::floor(seconds / kMillisecond) * kPerMillisecond;
  print({{"ingest-sent", sent, "samples"},
         {"ingest-received", static_cast<double>(health.received), "samples"},
         {"ingest-recorded", static_cast<double>(recorded.size()), "samples"},
         {"ingest-lost", static_cast<double>(health.lost), "samples"},
         {"ingest-gaps-in-file", static_cast<double>(gaps), "samples"},
         {"ingest-dropped", static_cast<double>(recorder.dropped()), "samples"},
         {"ingest-rate", sent / took, "samples/s"},
         {"ingest-longest-gap", longest_gap / kMicro, "us"}});
  const bool whole = health.lost == 0 && gaps == 0 && static_cast<double>(recorded.size()) == sent;
  return whole ? 0 : 1;
}

}  // namespace
}  // namespace osteomill::bench

int main(int argc, char** argv) {
  using namespace osteomill::bench;
  const std::string_view part = argc > 1 ? argv[1] : "";
  if (part == "step" && argc == 2) {
    print_steps();
    return 0;
  }
  const double seconds = argc > 2 ? std::atof(argv[2]) : 0.0;
  if (part == "jitter" && argc == 3 && seconds > 0.0) {
    print_jitter(seconds);
    return 0;
  }
  if (part == "ingest" && argc == 4 && seconds > 0.0) return print_ingest(seconds, argv[3]);
  fmt::print(stderr, "usage: {} step | jitter SECONDS | ingest SECONDS FILE\n", argv[0]);
  return 2;
}
