// SPDX-License-Identifier: BSD-3-Clause
#include "force.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "documents.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/cutting/prediction.hpp"
#include "osteomill/io/case_file.hpp"
#include "osteomill/io/force_case.hpp"
#include "osteomill/io/plot.hpp"

namespace osteomill::cli {
namespace {

using Json = nlohmann::ordered_json;

Json xyz(const geometry::Vector3& vector) {
  return {{"x", vector.x()}, {"y", vector.y()}, {"z", vector.z()}};
}

/// A solved case.
struct Solved {
  cutting::Prediction cut;
  thermal::HeatShares heat;  ///< W
};

/// The numbers of a prediction, without its signals.
Json figures_of(const Solved& solved) {
  const cutting::Prediction& cut = solved.cut;
  Json document;
  document["mean_force_n"] = xyz(cut.mean.force);
  document["peak_force_n"] = xyz(cut.peak);
  document["peak_force_n"]["resultant"] = cut.peak_resultant;
  document["rms_force_n"] = xyz(cut.rms);
  document["mean_torque_nmm"] = cut.mean_torque / units::n_mm;
  document["peak_torque_nmm"] = cut.peak_torque / units::n_mm;
  document["peak_bending_moment_nmm"] = cut.peak_bending_moment / units::n_mm;
  document["mean_power_w"] = cut.spindle_power;
  document["mean_feed_power_w"] = cut.feed_power;
  document["rubbing_power_w"] = cut.rubbing_power;
  document["heat_w"] = {
      {"chip", solved.heat.chip}, {"tool", solved.heat.tool}, {"bone", solved.heat.bone}};
  document["removal_rate_mm3_per_s"] = cut.removal_rate / units::mm3;
  document["specific_energy_j_per_mm3"] = cut.specific_energy * units::mm3;
  document["feed_per_tooth_mm"] = cut.feed_per_tooth / units::mm;
  document["largest_chip_um"] = cut.largest_chip / units::um;
  return document;
}

Json document_of(const Solved& solved) {
  const cutting::Prediction& cut = solved.cut;
  Json document = figures_of(solved);
  Json& orders = document["harmonics"] = Json::array();
  for (std::size_t k = 0; k < cut.harmonics.size(); ++k) {
    orders.push_back({{"order", k + 1}, {"amplitude_n", xyz(cut.harmonics[k])}});
  }
  Json& flutes = document["flutes"] = Json::array();
  for (const geometry::Vector3& mean : cut.flute_means) {
    flutes.push_back({{"mean_force_n", xyz(mean)}});
  }
  Json& turn = document["revolution"];
  turn["angle_deg"] = Json::array();
  turn["force_n"] = {{"x", Json::array()}, {"y", Json::array()}, {"z", Json::array()}};
  turn["torque_nmm"] = Json::array();
  turn["bending_moment_nmm"] = Json::array();
  for (std::size_t i = 0; i < cut.revolution.loads.size(); ++i) {
    const cutting::Load& load = cut.revolution.loads[i];
    turn["angle_deg"].push_back(cut.revolution.angle[i] / units::deg);
    turn["force_n"]["x"].push_back(load.force.x());
    turn["force_n"]["y"].push_back(load.force.y());
    turn["force_n"]["z"].push_back(load.force.z());
    turn["torque_nmm"].push_back(load.torque() / units::n_mm);
    turn["bending_moment_nmm"].push_back(cut.bending_moments[i] / units::n_mm);
  }
  document["warnings"] = cut.warnings;
  return document;
}

std::vector<std::vector<std::string>> rows_of(const Solved& solved) {
  const cutting::Prediction& cut = solved.cut;
  const auto forces = [](const std::string& name, const geometry::Vector3& f, double resultant) {
    return std::vector<std::string>{name, fmt::format("{:.2f}", f.x()),
                                    fmt::format("{:.2f}", f.y()), fmt::format("{:.2f}", f.z()),
                                    fmt::format("{:.2f}", resultant)};
  };
  const auto one = [](const char* name, double value) {
    return std::vector<std::string>{name, fmt::format("{:.4g}", value)};
  };
  std::vector<std::vector<std::string>> rows = {
      {"force on the cutter, N", "x (feed)", "y (normal)", "z (axis)", "resultant"},
      forces("mean", cut.mean.force, cut.mean.force.norm()),
      forces("peak", cut.peak, cut.peak_resultant),
      forces("rms", cut.rms, cut.rms.norm())};
  const auto unequal = [&](const geometry::Vector3& flute) {
    return (flute - cut.flute_means.front()).norm() > 1e-9 * cut.mean.force.norm();
  };
  if (std::any_of(cut.flute_means.begin(), cut.flute_means.end(), unequal)) {
    for (std::size_t i = 0; i < cut.flute_means.size(); ++i) {
      rows.push_back(forces(fmt::format("mean of flute {}", i), cut.flute_means[i],
                            cut.flute_means[i].norm()));
    }
  }
  const std::vector<std::vector<std::string>> rest = {
      one("mean torque, N mm", cut.mean_torque / units::n_mm),
      one("peak torque, N mm", cut.peak_torque / units::n_mm),
      one("peak bending moment, N mm", cut.peak_bending_moment / units::n_mm),
      one("mean spindle power, W", cut.spindle_power),
      one("of it rubbing, W", cut.rubbing_power),
      one("heat into the chip, W", solved.heat.chip),
      one("heat into the tool, W", solved.heat.tool),
      one("heat into the bone, W", solved.heat.bone),
      one("removal rate, mm3/s", cut.removal_rate / units::mm3),
      one("specific energy, J/mm3", cut.specific_energy * units::mm3),
      one("feed per tooth, um", cut.feed_per_tooth / units::um),
      one("largest chip, um", cut.largest_chip / units::um)};
  rows.insert(rows.end(), rest.begin(), rest.end());
  return rows;
}

std::vector<Figure> figures_for(const cutting::Prediction& cut) {
  std::vector<double> angle;
  io::Series x{.label = "Fx (feed)", .x = {}, .y = {}};
  io::Series y{.label = "Fy (normal)", .x = {}, .y = {}};
  io::Series z{.label = "Fz (axis)", .x = {}, .y = {}};
  io::Series torque{.label = "", .x = {}, .y = {}};
  io::Series resultant{.label = "in the plane of the feed", .x = {}, .y = {}};
  for (std::size_t i = 0; i <= cut.revolution.loads.size(); ++i) {
    const std::size_t at = i % cut.revolution.loads.size();  // close the turn
    const cutting::Load& load = cut.revolution.loads[at];
    angle.push_back(360.0 * static_cast<double>(i) /
                    static_cast<double>(cut.revolution.loads.size()));
    x.y.push_back(load.force.x());
    y.y.push_back(load.force.y());
    z.y.push_back(load.force.z());
    torque.y.push_back(load.torque() / units::n_mm);
    resultant.y.push_back(std::hypot(load.force.x(), load.force.y()));
  }
  x.x = y.x = z.x = torque.x = resultant.x = angle;
  io::LinePlot turn;
  turn.title = "One revolution";
  turn.x = {.label = "rotation of the first flute, deg", .low = 0.0, .high = 360.0};
  turn.panels = {
      {.y = {.label = "force on the cutter, N"}, .series = {x, y, z}},
      {.y = {.label = "torque, N mm", .low = 0.0}, .series = {torque}, .share_of_height = 0.5}};
  turn.height = 560;
  io::PolarPlot polar;
  polar.title = "Force in the plane of the feed";
  polar.radius_label = "force, N";
  polar.series = {resultant};
  polar.zero_on_top = true;
  polar.clockwise = true;
  io::Bars bx{.label = "Fx", .values = {}}, by{.label = "Fy", .values = {}},
      bz{.label = "Fz", .values = {}};
  io::BarChart orders;
  orders.title = "Harmonics of the spindle speed";
  orders.y = {.label = "amplitude, N"};
  for (std::size_t k = 0; k < cut.harmonics.size(); ++k) {
    orders.categories.push_back(std::to_string(k + 1));
    bx.values.push_back(cut.harmonics[k].x());
    by.values.push_back(cut.harmonics[k].y());
    bz.values.push_back(cut.harmonics[k].z());
  }
  orders.series = {bx, by, bz};
  return {{"revolution", "Force and torque over one revolution of the cutter.",
           [turn](const std::filesystem::path& file) { io::draw(turn, file); }},
          {"polar", "Resultant in the plane of the feed over the rotation of the first flute.",
           [polar](const std::filesystem::path& file) { io::draw(polar, file); }},
          {"harmonics", "Amplitudes of the harmonics of the spindle speed.",
           [orders](const std::filesystem::path& file) { io::draw(orders, file); }}};
}

cutting::Prediction predict(const io::ForceCase& force) {
  const cutting::Cutter& cutter = force.cutter;
  const cutting::CuttingLaw& law = force.bone.law;
  if (force.engagement) {
    return cutting::predict(cutter, law, force.condition, *force.engagement);
  }
  if (force.tilted) return cutting::predict(cutter, law, force.condition, *force.tilted);
  return cutting::predict(cutter, law, force.condition, force.immersion);
}

Solved solve(const io::ForceCase& force) {
  Solved solved{predict(force), {}};
  cutting::Prediction& cut = solved.cut;
  cut.warnings.insert(cut.warnings.begin(), force.caveats.begin(), force.caveats.end());
  solved.heat = thermal::shares_of_cut(
      cut.spindle_power, cut.rubbing_power, force.condition.spindle_speed * force.cutter.radius,
      thermal::kMeanOfChip * force.condition.feed_per_tooth, force.heat);
  return solved;
}

std::string heat_sentence(const thermal::PartitionOptions& heat) {
  return fmt::format(
      "heat: assumes a shear strain of {:g}, {:g} % friction on the rake face, {:g} % of it into "
      "the tool, {:g} % of the rubbing into the bone",
      heat.shear_strain, 100.0 * heat.friction_share, 100.0 * heat.friction_to_tool,
      100.0 * heat.rubbing_to_bone);
}

/// "cut.feed_per_tooth_mm=0.001:0.1:50", the section left out where the key is unique; with
/// ":log" behind it the values grow by equal factors.
struct Over {
  std::string path;
  std::vector<double> values;
  bool whole = false;  ///< the key is an integer
  bool logarithmic = false;
};

/// "cutter.profile.1.z_mm" as the schema has it: "cutter.profile[].z_mm".
std::string schema_path(const std::string& path) {
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  std::string in_schema;
  for (auto at = path.begin(); at != path.end();) {
    const auto end = *at == '.' ? std::find_if_not(at + 1, path.end(), is_digit) : at + 1;
    if (end - at > 1)
      in_schema += "[]";
    else
      in_schema += *at;
    at = end;
  }
  return in_schema;
}

Over parse_over(const std::string& text) {
  const auto refuse = [&](const char* rule) {
    throw InvalidInput(
        Fault{"--over", text, rule,
              "e.g. --over cut.feed_per_tooth_mm=0.001:0.1:50, or ...:50:log for equal factors"});
  };
  Over over;
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos) refuse("must read key=from:to:count");
  over.path = text.substr(0, equals);
  std::string range = text.substr(equals + 1);
  over.logarithmic = range.ends_with(":log");
  if (over.logarithmic) range.resize(range.size() - 4);
  double from = 0.0, to = 0.0;
  int count = 0, read = 0;
  if (std::sscanf(range.c_str(), "%lf:%lf:%d%n", &from, &to, &count, &read) != 3 ||
      static_cast<std::size_t>(read) != range.size() || !std::isfinite(from) ||
      !std::isfinite(to)) {
    refuse("must read key=from:to:count");
  }
  if (count < 2 || count > 10000) refuse("must have 2 ... 10000 values");
  if (over.logarithmic && !(from > 0.0 && to > 0.0)) refuse("must have ends > 0 with log");
  for (int i = 0; i < count; ++i) {
    const double share = static_cast<double>(i) / (count - 1);
    over.values.push_back(over.logarithmic ? from * std::pow(to / from, share)
                                           : from + (to - from) * share);
  }
  std::vector<io::SchemaKey> found;
  for (const io::SchemaKey& key : io::Section::schema(io::bind_force)) {
    if (key.type != "number" && key.type != "integer") continue;
    const std::string asked = schema_path(over.path);
    if (key.path == asked) {
      over.whole = key.type == "integer";
      return over;
    }
    if (key.path.ends_with("." + asked) && key.path.find("[]") == std::string::npos) {
      found.push_back(key);
    }
  }
  if (found.size() != 1) {
    refuse(found.empty() ? "names no key with a number; osteomill schema force lists them"
                         : "names more than one key; write the section before it");
  }
  over.path = found[0].path;
  over.whole = found[0].type == "integer";
  return over;
}

/// The case with the key set; the other way to give the feed goes.
io::CaseRun with(const io::CaseRun& run, const Over& over, double value) {
  io::CaseRun changed = run;
  Json* node = &changed.tree.values;
  std::size_t begin = 0;
  for (std::size_t dot; (dot = over.path.find('.', begin)) != std::string::npos; begin = dot + 1) {
    const std::string step = over.path.substr(begin, dot - begin);
    if (!node->is_array()) {
      node = &(*node)[step];
      continue;
    }
    const std::size_t index = std::stoul(step);  // schema_path() found a number here
    if (index >= node->size()) {
      throw InvalidInput(Fault{"--over", over.path,
                               fmt::format("the list has {} elements", node->size()),
                               "name one by its number, from 0"});
    }
    node = &(*node)[index];
  }
  const std::string key = over.path.substr(begin);
  if (key == "feed_per_tooth_mm") node->erase("feed_rate_mm_per_min");
  if (key == "feed_rate_mm_per_min") node->erase("feed_per_tooth_mm");
  if (over.whole) {
    (*node)[key] = static_cast<int>(std::lround(value));
  } else {
    (*node)[key] = value;
  }
  changed.tree.places[over.path] = "--over";
  return changed;
}

Shown show_over(const io::CaseRun& run, const Over& over) {
  Shown shown;
  Json points = Json::array();
  const std::string key = over.path.substr(over.path.rfind('.') + 1);
  shown.rows = {{key, "mean Fx, N", "mean Fy, N", "mean Fz, N", "peak, N", "torque, N mm",
                 "power, W", "energy, J/mm3"}};
  io::Series x{.label = "mean Fx", .x = over.values, .y = {}};
  io::Series y{.label = "mean Fy", .x = over.values, .y = {}};
  io::Series z{.label = "mean Fz", .x = over.values, .y = {}};
  io::Series peak{.label = "peak resultant", .x = over.values, .y = {}, .mark = io::Mark::dashed};
  io::Series energy{.label = "", .x = over.values, .y = {}};
  for (const double value : over.values) {
    const io::ForceCase force = io::read_force_case(with(run, over, value));
    const Solved solved = solve(force);
    const cutting::Prediction& cut = solved.cut;
    Json point;
    point[key] = value;
    point.update(figures_of(solved));
    points.push_back(point);
    shown.rows.push_back({fmt::format("{:.6g}", value), fmt::format("{:.3f}", cut.mean.force.x()),
                          fmt::format("{:.3f}", cut.mean.force.y()),
                          fmt::format("{:.3f}", cut.mean.force.z()),
                          fmt::format("{:.3f}", cut.peak_resultant),
                          fmt::format("{:.4g}", cut.mean_torque / units::n_mm),
                          fmt::format("{:.4g}", cut.spindle_power),
                          fmt::format("{:.4g}", cut.specific_energy * units::mm3)});
    x.y.push_back(cut.mean.force.x());
    y.y.push_back(cut.mean.force.y());
    z.y.push_back(cut.mean.force.z());
    peak.y.push_back(cut.peak_resultant);
    energy.y.push_back(cut.specific_energy * units::mm3);
    for (const std::string& warning : cut.warnings) {
      // The extrapolation's text carries the chip of its point: the first says enough.
      const std::string_view head = std::string_view(warning).substr(0, 17);
      if (std::none_of(shown.warnings.begin(), shown.warnings.end(),
                       [&](const std::string& old) { return old.starts_with(head); })) {
        shown.warnings.push_back(warning);
      }
    }
    shown.expanded = force.expanded;
  }
  shown.document["over"] = over.path;
  shown.document["points"] = points;
  shown.document["warnings"] = shown.warnings;
  io::LinePlot plot;
  plot.title = "Force over " + key;
  plot.x = {.label = key, .logarithmic = over.logarithmic};
  plot.panels = {
      {.y = {.label = "force on the cutter, N"}, .series = {x, y, z, peak}},
      {.y = {.label = "energy, J/mm³", .low = 0.0}, .series = {energy}, .share_of_height = 0.6}};
  plot.height = 560;
  shown.figures = {{"over", "Mean force, peak and specific energy.",
                    [plot](const std::filesystem::path& file) { io::draw(plot, file); }}};
  return shown;
}

}  // namespace

Shown show_force(const io::CaseRun& run) {
  const io::ForceCase force = io::read_force_case(run);
  const Solved solved = solve(force);
  Shown shown;
  shown.document = document_of(solved);
  shown.expanded = force.expanded;
  shown.rows = rows_of(solved);
  shown.sentences = {heat_sentence(force.heat)};
  shown.warnings = solved.cut.warnings;
  shown.figures = figures_for(solved.cut);
  return shown;
}

void add_force(CLI::App& program) {
  struct Arguments : CaseArguments {
    std::string over;
  };
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command =
      program.add_subcommand("force", "forces, torque and power of one cutting condition");
  add_case_arguments(*command, *arguments);
  command->add_option("--over", arguments->over, "a curve over a key: KEY=from:to:count[:log]");
  command->callback([arguments] {
    if (arguments->over.empty()) return show_runs(*arguments, "force", show_force);
    const Over over = parse_over(arguments->over);
    show_runs(*arguments, "force", [&](const io::CaseRun& run) { return show_over(run, over); });
  });
}

}  // namespace osteomill::cli
