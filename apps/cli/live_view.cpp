// SPDX-License-Identifier: BSD-3-Clause
#include "live_view.hpp"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <boost/lockfree/spsc_queue.hpp>
#include <chrono>
#include <iterator>
#include <mutex>
#include <thread>
#include <utility>

#include "osteomill/base/units.hpp"

namespace osteomill::cli {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

constexpr auto kFrame = 100ms;
constexpr auto kPlainLine = 2s;
constexpr int kLines = 4;     // of the drawing
constexpr int kWidest = 100;  // columns
constexpr int kUnknown = 80;  // columns of a terminal that does not say

struct Snapshot {
  double time = 0.0, position = 0.0, feed = 0.0, mean_force = 0.0, peak_force = 0.0;
  double command = 0.0;
  control::Mode mode = control::Mode::stopped;
};

int columns() {
  winsize size{};
  const bool said = ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0;
  return std::min<int>(said ? size.ws_col : kUnknown, kWidest);
}

std::string bar(double share, int width) {
  const int full = static_cast<int>(std::clamp(share, 0.0, 1.0) * static_cast<double>(width) + 0.5);
  std::string text(static_cast<std::size_t>(full), '#');
  text.resize(static_cast<std::size_t>(width), '.');
  return text;
}

/// Written at once, so that no half frame is seen.
void write_all(const std::string& text) {
  std::size_t done = 0;
  while (done < text.size()) {
    const ssize_t wrote = write(STDERR_FILENO, text.data() + done, text.size() - done);
    if (wrote <= 0) return;  // nobody looks any more
    done += static_cast<std::size_t>(wrote);
  }
}

/// A plant that leaves what is to be shown.
class WatchedPlant final : public control::Plant {
 public:
  using Ring = boost::lockfree::spsc_queue<Snapshot, boost::lockfree::capacity<1024>>;
  WatchedPlant(control::Plant& plant, Ring& ring) : plant_(plant), ring_(ring) {}

  control::Observation start() override { return plant_.start(); }
  control::Observation advance(const control::FeedCommand& command) override {
    const control::Observation seen = plant_.advance(command);
    // A view that is late misses some.
    ring_.push({seen.time, seen.position, seen.feed, seen.mean_force, seen.peak_force, command.feed,
                command.mode});
    return seen;
  }

 private:
  control::Plant& plant_;
  Ring& ring_;
};

}  // namespace

struct LiveView::Parts {
  Parts() : terminal(isatty(STDERR_FILENO) == 1) {
    thread = std::thread([this] { work(); });
  }
  ~Parts() { end(); }

  void end() {
    over = true;
    if (thread.joinable()) thread.join();
  }

  void work() {
    auto line_due = Clock::now() + kPlainLine;
    while (true) {
      const bool last = over;
      {
        const std::lock_guard lock(mutex);
        take();
        if (terminal && any) {
          draw();
        } else if (any && (last || Clock::now() >= line_due)) {
          line_due = Clock::now() + kPlainLine;
          write_all(plain());
        }
      }
      if (last) return;
      std::this_thread::sleep_for(kFrame);
    }
  }

  /// What the loop has left since the last look.
  void take() {
    Snapshot next;
    double peak = 0.0;
    bool fresh = false;
    while (ring.pop(next)) {
      newest = next;
      peak = std::max(peak, next.peak_force);
      fresh = any = true;
    }
    if (fresh) newest.peak_force = peak;  // of all since the last frame
    control::LoopEvent event;
    while (events.pop(event)) {
      news += fmt::format("{}: {:.2f} s: the supervisor stopped: {}", run.name, event.time,
                          control::name(event.cause));
      news += '\n';
    }
  }

  double share() const { return run.length > 0.0 ? newest.position / run.length : 0.0; }
  const char* state() const {
    return newest.mode == control::Mode::stopped ? "stopped" : control::name(newest.mode);
  }

  std::string plain() {
    std::string text = std::exchange(news, {});
    fmt::format_to(std::back_inserter(text),
                   "{}: {:.0f} %, {:.1f} s, force {:.1f} N (peak {:.1f}), feed {:.2f} mm/s, {}\n",
                   run.name, 100.0 * std::clamp(share(), 0.0, 1.0), newest.time, newest.mean_force,
                   newest.peak_force, newest.feed / units::mm_per_s, state());
    return text;
  }

  void draw() {
    const int width = columns() - 1;  // the last one would wrap
    const int bars = std::max(0, width - 46);
    std::vector<std::string> lines;
    lines.push_back(fmt::format("{:<24.24} {:>7.1f} s {:>4.0f} %   [{}]", run.name, newest.time,
                                100.0 * std::clamp(share(), 0.0, 1.0), bar(share(), bars)));
    lines.push_back(fmt::format("force {:>6.1f} N  peak {:>6.1f} of {:>4.0f} N   [{}]",
                                newest.mean_force, newest.peak_force, run.force_limit,
                                bar(newest.peak_force / run.force_limit, bars)));
    lines.push_back(fmt::format("feed  {:>6.2f} mm/s   asked {:>6.2f} of {:>3.0f}  [{}]",
                                newest.feed / units::mm_per_s, newest.command / units::mm_per_s,
                                run.highest_feed / units::mm_per_s,
                                bar(newest.feed / run.highest_feed, bars)));
    lines.push_back(fmt::format("state {}", state()));
    std::string frame;
    if (drawn) frame = fmt::format("\033[{}A", kLines);
    // What has happened stands above the drawing and scrolls away with it.
    for (std::size_t from = 0; from < news.size();) {
      const std::size_t to = news.find('\n', from);
      frame += "\r\033[K" + news.substr(from, to - from) + "\n";
      from = to + 1;
    }
    news.clear();
    for (const std::string& line : lines) {
      frame += "\r\033[K" + line.substr(0, static_cast<std::size_t>(std::max(0, width))) + "\n";
    }
    write_all(frame);
    drawn = true;
  }

  bool terminal;
  WatchedPlant::Ring ring;
  boost::lockfree::spsc_queue<control::LoopEvent, boost::lockfree::capacity<64>> events;
  std::mutex mutex;  ///< for all below, between the view and who begins a run
  LiveRun run;
  Snapshot newest;
  std::string news;    ///< lines about events that are not shown yet
  bool any = false;    ///< there is something to show
  bool drawn = false;  ///< the cursor stands below a drawing
  std::unique_ptr<WatchedPlant> watched;
  std::atomic<bool> over{false};
  std::thread thread;
};

LiveView::LiveView() : parts_(std::make_unique<Parts>()) {}

LiveView::~LiveView() = default;

control::Plant& LiveView::watch(control::Plant& plant, const LiveRun& run) {
  const std::lock_guard lock(parts_->mutex);
  parts_->take();
  if (parts_->any && parts_->terminal) parts_->draw();
  // The last run's drawing stands; the next one is drawn below it.
  parts_->drawn = parts_->any = false;
  parts_->run = run;
  parts_->newest = {};
  parts_->watched = std::make_unique<WatchedPlant>(plant, parts_->ring);
  return *parts_->watched;
}

void LiveView::event(const control::LoopEvent& event) noexcept { parts_->events.push(event); }

void LiveView::end() { parts_->end(); }

}  // namespace osteomill::cli
