// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>

#include "documents.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/cutting/condition.hpp"
#include "osteomill/io/map_case.hpp"
#include "osteomill/io/map_result.hpp"
#include "osteomill/io/mesh_file.hpp"
#include "osteomill/io/stock_maker.hpp"

namespace osteomill::cli {
namespace {

using Json = nlohmann::ordered_json;
using units::mm_per_s;

double seconds_since(std::chrono::steady_clock::time_point begin) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

const char* name_of(simulate::LimitedForce what) {
  switch (what) {
    case simulate::LimitedForce::normal:
      return "normal force";
    case simulate::LimitedForce::feed:
      return "feed force";
    case simulate::LimitedForce::resultant:
      break;
  }
  return "force";
}

/// A made map with its bone; pictures and files look at it.
struct Made {
  io::MadeStock stock;
  std::unique_ptr<simulate::ForceMap> map;
  io::MapResult result;
};

struct Extremes {
  std::size_t in_bone = 0;
  std::size_t stuck = 0;      ///< poses at which no feed is slow enough
  std::size_t strongest = 0;  ///< pose of the largest normal force
  std::size_t slowest = 0;    ///< pose of the least largest feed
  double normal_low = 0.0, normal_high = 0.0, feed = 0.0;
};

Extremes extremes_of(const io::MapResult& r) {
  Extremes e;
  double strongest = -1.0, slowest = 1e300;
  for (std::size_t i = 0; i < r.map->poses(); ++i) {
    if (!(r.map->contact()[i] > 0.0F)) continue;
    ++e.in_bone;
    if (r.largest_feeds[i] == 0.0F) ++e.stuck;
    e.normal_low = std::min<double>(e.normal_low, r.forces.normal[i]);
    e.normal_high = std::max<double>(e.normal_high, r.forces.normal[i]);
    e.feed = std::max<double>(e.feed, r.forces.feed[i]);
    if (std::abs(r.forces.normal[i]) > strongest) {
      strongest = std::abs(r.forces.normal[i]);
      e.strongest = i;
    }
    if (r.largest_feeds[i] < slowest) {
      slowest = r.largest_feeds[i];
      e.slowest = i;
    }
  }
  return e;
}

std::string pose_text(const simulate::ForceMap& map, std::size_t pose) {
  const std::size_t n = map.insertions().size();
  return fmt::format("{:.0f} deg, {:.0f} mm", map.angles()[pose / n] / units::deg,
                     map.insertions()[pose % n] / units::mm);
}

Shown solve(const io::CaseRun& run) {
  io::MapCase one = io::read_map_case(run);
  auto made = std::make_shared<Made>();
  made->stock = io::make_stock(one.stock, one.bone);
  one.map.fibre_W = made->stock.fibre_W;
  auto begin = std::chrono::steady_clock::now();
  made->map = std::make_unique<simulate::ForceMap>(*made->stock.stock, one.map);
  const double build = seconds_since(begin);
  const simulate::ForceMap& map = *made->map;
  begin = std::chrono::steady_clock::now();
  io::MapResult& result = made->result;
  result = {&map,
            one.map.poses,
            one.feed,
            one.force_limit,
            map.at(one.feed),
            map.largest_feeds(one.limited, one.force_limit)};
  const double refeed = seconds_since(begin);
  const Extremes e = extremes_of(result);
  if (e.in_bone == 0)
    throw InvalidInput(Fault{"map.pivot_mm", "no pose meets bone",
                             "must lie so that the tool reaches the bone",
                             "look at map.normal (into the bone that goes), map.forward, the "
                             "angles and insertions, and the region of the stock"});
  // The map keeps its guide when the case has gone; feeds are allowed where there is bone.
  Shown shown;
  shown.expanded = one.expanded;
  shown.document = {{"poses", map.poses()},
                    {"poses_in_bone", e.in_bone},
                    {"largest_normal_force_n", e.normal_high},
                    {"smallest_normal_force_n", e.normal_low},
                    {"largest_feed_force_n", e.feed},
                    {"force_limit_n", one.force_limit},
                    {"limit_on", name_of(one.limited)},
                    {"smallest_largest_feed_mm_per_s", result.largest_feeds[e.slowest] / mm_per_s},
                    {"poses_without_feed", e.stuck},
                    {"linear_in_feed", map.linear()},
                    {"map_time_s", build},
                    {"new_feed_time_ms", refeed / units::ms},
                    {"stock", made->stock.report}};
  shown.document["map"] = io::map_document(result, false);
  const double tooth =
      cutting::feed_per_tooth(one.map.largest_feed, one.map.spindle_speed, one.map.cutter.flutes);
  shown.warnings = one.caveats;
  const cutting::ChipRange range = cutting::range_of(one.map.law);
  if (tooth > range.high * 1.001)
    shown.warnings.push_back(fmt::format(
        "the largest feed takes {:.0f} um a tooth, the law was measured up to {:.0f} um: forces "
        "and largest feeds beyond {:.3g} mm/s are extrapolated",
        tooth / units::um, range.high / units::um,
        one.map.largest_feed * range.high / tooth / mm_per_s));
  if (io::follows_density(one.stock))
    shown.warnings.push_back(fmt::format(
        "the force follows the local density as (density / {:g} kg/m3)^{:g}: an assumption",
        one.bone.density.reference.value, one.bone.density.exponent.value));
  shown.warnings.insert(shown.warnings.end(), made->stock.remarks.begin(),
                        made->stock.remarks.end());
  shown.warnings.push_back(
      "mean forces of a rigid tool over a revolution; the bone nearer the pivot than the groove "
      "counts as cut, the bone above the cutter as standing");
  shown.document["warnings"] = shown.warnings;
  shown.rows = {
      {"over the plane", "value", "at"},
      {"poses in bone", fmt::format("{} of {}", e.in_bone, map.poses()), ""},
      {"largest normal force off the cut, N", fmt::format("{:.2f}", e.normal_high),
       e.normal_high > 0.0 && result.forces.normal[e.strongest] > 0.0F ? pose_text(map, e.strongest)
                                                                       : ""},
      {"largest normal force into it, N", fmt::format("{:.2f}", -e.normal_low),
       result.forces.normal[e.strongest] < 0.0F ? pose_text(map, e.strongest) : ""},
      {"largest feed force, N", fmt::format("{:.2f}", e.feed), ""},
      {fmt::format("slowest largest feed for {:g} N, mm/s", one.force_limit),
       fmt::format("{:.2f}", result.largest_feeds[e.slowest] / mm_per_s),
       pose_text(map, e.slowest)}};
  const std::string allowed =
      e.stuck == 0
          ? fmt::format("{:.2f} mm/s at {} and more elsewhere",
                        result.largest_feeds[e.slowest] / mm_per_s, pose_text(map, e.slowest))
          : fmt::format("no feed at {} of the poses, as at {}", e.stuck, pose_text(map, e.slowest));
  shown.sentences = {
      fmt::format("At {:g} mm/s the tool is lifted off the cut by up to {:.1f} N and pushed with "
                  "up to {:.1f} N; a {} of {:g} N allows {}. The map took {:.0f} ms, a new feed "
                  "{:.1f} ms.",
                  one.feed / mm_per_s, e.normal_high, e.feed, name_of(one.limited), one.force_limit,
                  allowed, build / units::ms, refeed / units::ms)};
  using io::MapValue;
  const auto figure = [&](const char* name, const char* caption, MapValue value) {
    shown.figures.push_back({name, caption, [made, value](const std::filesystem::path& file) {
                               io::draw(io::map_figure(made->result, value), file);
                             }});
  };
  shown.figures.push_back({"overlay", "normal force on the cutting plane, seen from the guide",
                           [made](const std::filesystem::path& file) {
                             io::draw(io::map_picture(made->result, *made->stock.stock), file);
                           }});
  figure("normal_force", "mean normal force on the tool at every pose", MapValue::normal_force);
  figure("feed_force", "mean force that the tool is pushed with", MapValue::feed_force);
  figure("largest_feed", "largest feed within the limit", MapValue::largest_feed);
  shown.files = {{"map.json", io::map_document(result, true).dump() + "\n"},
                 {"map.csv", io::map_table(result)}};
  shown.written = {{"map.h5",
                    [made](const std::filesystem::path& file) {
                      io::write_signals(io::map_signals(made->result), file);
                    }},
                   {"overlay.ply", [made](const std::filesystem::path& file) {
                      const io::PictureLegend legend =
                          io::map_legend(made->result, MapValue::normal_force);
                      io::write_mesh(io::map_overlay(made->result, MapValue::normal_force), file,
                                     io::ValueColours{legend.colours, legend.low, legend.high});
                    }}};
  return shown;
}

}  // namespace

void add_map(CLI::App& program) {
  auto arguments = std::make_shared<CaseArguments>();
  CLI::App* command = program.add_subcommand(
      "map", "forces and largest feeds at every pose of the milling guide over a cutting plane");
  add_case_arguments(*command, *arguments);
  command->callback([arguments] { show_runs(*arguments, "map", solve); });
}

}  // namespace osteomill::cli
