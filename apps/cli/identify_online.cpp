// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "documents.hpp"
#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/io/online_case.hpp"
#include "osteomill/io/plot.hpp"
#include "osteomill/io/text_file.hpp"

namespace osteomill::cli {
namespace {

using namespace identify;

struct Arguments : CaseArguments {
  std::filesystem::path entry;
};

/// What was measured against what bone of strength 1 would have shown, and the strength with what
/// two standard errors leave open.
io::LinePlot plot_of(const io::OnlineCase& input, const OnlineTrack& track) {
  const bool power = input.options.measure == OnlineMeasure::power;
  io::Series measured{.label = "measured", .x = {}, .y = {}};
  io::Series fitted{.label = "reference × strength", .x = {}, .y = {}, .mark = io::Mark::dashed};
  io::Series feed{.label = "", .x = {}, .y = {}};
  io::Series strength{.label = "strength", .x = {}, .y = {}};
  io::Band band{.label = "± 1.96 standard errors", .x = {}, .low = {}, .high = {}};
  const double gap = std::numeric_limits<double>::quiet_NaN();
  for (std::size_t i = 0; i < track.estimates.size(); ++i) {
    const OnlineEstimate& one = track.estimates[i];
    const bool in = track.in_bone[i];
    measured.x.push_back(one.time);
    measured.y.push_back(input.periods[i].measured);
    fitted.x.push_back(one.time);
    fitted.y.push_back(in ? one.offset + one.strength * track.unit[i] : gap);
    feed.x.push_back(one.time);
    feed.y.push_back(input.periods[i].feed / units::mm_per_s);
    strength.x.push_back(one.time);
    strength.y.push_back(in ? one.strength : gap);
    band.x.push_back(one.time);
    band.low.push_back(in ? std::max(0.0, one.strength - 1.96 * one.standard_error) : gap);
    band.high.push_back(in ? one.strength + 1.96 * one.standard_error : gap);
  }
  io::LinePlot plot;
  plot.title = "strength of the bone from " + std::string(power ? "spindle power" : "force");
  plot.x = {.label = "time, s"};
  plot.height = 620;
  plot.panels.push_back(
      {.y = {.label = power ? "power, W" : "force, N"}, .series = {measured, fitted}});
  plot.panels.push_back({.y = {.label = "strength, 1", .low = 0.0},
                         .series = {strength},
                         .limits = {{.y = 1.0, .label = "reference"}},
                         .bands = {band}});
  plot.panels.push_back(
      {.y = {.label = "feed, mm/s", .low = 0.0}, .series = {feed}, .share_of_height = 0.5});
  return plot;
}

Shown show_online(const io::CaseRun& run, const Arguments& arguments) {
  const io::OnlineCase input = io::read_online_case(run);
  const OnlineTrack track = follow(input.periods, input.response, input.options);
  Shown shown;
  shown.document = io::online_document(input, track);
  shown.expanded = input.expanded;
  shown.warnings = input.warnings;
  const OnlineEstimate& last = track.estimates.back();
  shown.rows = {
      {"", "strength"},
      {"median in bone", fmt::format("{:.3f}", track.median)},
      {"5 % below", fmt::format("{:.3f}", track.low)},
      {"5 % above", fmt::format("{:.3f}", track.high)},
      {"at the end", fmt::format("{:.3f} ± {:.3f}", last.strength, 1.96 * last.standard_error)}};
  shown.sentences.push_back(fmt::format("{} of {} periods in bone, {} changes of bone seen",
                                        track.periods_in_bone, track.estimates.size(),
                                        track.jumps));
  if (track.periods_in_bone == 0) {
    shown.sentences.emplace_back("no period was in bone: see online.contact and the offset");
  }
  shown.figures.push_back({"strength", "What was measured, the strength that it means, the feed",
                           [plot = plot_of(input, track)](const std::filesystem::path& file) {
                             io::draw(plot, file);
                           }});
  if (!arguments.entry.empty()) {
    io::write_text_file(arguments.entry, io::patient_entry(input, track));
  }
  return shown;
}

}  // namespace

void add_identify_online(CLI::App& program) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* parent = program.get_subcommand("identify");
  // The case of `identify` itself is not needed with `identify online`; see add_identify.
  parent->get_option("case")->required(false);
  CLI::App* command = parent->add_subcommand(
      "online", "the local strength of the bone from a recording of force or spindle power");
  add_case_arguments(*command, *arguments);
  command->add_option("--entry", arguments->entry,
                      "write the bone at this strength as a catalogue entry (TOML)");
  command->callback([arguments] {
    show_runs(*arguments, "identify online",
              [&](const io::CaseRun& run) { return show_online(run, *arguments); });
  });
}

}  // namespace osteomill::cli
