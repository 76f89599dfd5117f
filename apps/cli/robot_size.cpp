// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/robot_case.hpp"
#include "osteomill/io/robot_drawing.hpp"
#include "osteomill/robot/size_error.hpp"
#include "robot.hpp"

namespace osteomill::cli {
namespace {

using Json = nlohmann::ordered_json;
using units::mm;

Json choice(const robot::LinkChoice& best, const char* value) {
  if (!best.exists) return nullptr;
  return {{"l1_mm", best.l1 / mm},
          {"l2_mm", best.l2 / mm},
          {value, best.value / mm},
          {"change_with_l1", best.slope_l1},
          {"change_with_l2", best.slope_l2}};
}

Json surface(const std::vector<std::optional<double>>& values) {
  Json list = Json::array();
  for (const auto& value : values) list.push_back(value ? Json(*value / mm) : Json(nullptr));
  return list;
}

Json risk(const robot::LengthRisk& risk) {
  if (!risk.exists) return nullptr;
  return {{"share_forbidden", risk.share_forbidden},
          {"worst_implant_share_forbidden", risk.worst_share},
          {"mean_largest_gap_mm", risk.mean_gap / mm},
          {"largest_gap_95_percent_mm", risk.gap_95 / mm}};
}

Json errors_document(const io::RobotSizeCase& c, const robot::SizeErrorStudy& errors) {
  Json document;
  document["margin_mm"] = errors.margin / mm;
  document["kept_share"] = c.kept_share;
  document["added_mm_per_mm_margin"] = errors.added_per_margin;
  document["best_largest_without_margin"] = risk(errors.nominal);
  document["best_largest"] = choice(errors.with_margin.best_largest, "largest_gap_mm");
  document["best_largest_monte_carlo"] = risk(errors.largest);
  document["best_mean"] = choice(errors.with_margin.best_mean, "mean_of_largest_gaps_mm");
  document["best_mean_monte_carlo"] = risk(errors.mean);
  document["largest_gap_mm"] = surface(errors.with_margin.largest);
  document["mean_gap_mm"] = surface(errors.with_margin.mean);
  return document;
}

Json document_of(const io::RobotSizeCase& c, const robot::SizeStudy& study) {
  Json document;
  document["best_largest"] = choice(study.best_largest, "largest_gap_mm");
  document["best_mean"] = choice(study.best_mean, "mean_of_largest_gaps_mm");
  document["most_compact"] = choice(study.most_compact, "required_stroke_mm");
  document["families"] = Json::array();
  for (std::size_t f = 0; f < c.families.size(); ++f) {
    Json one = choice(study.best_per_family[f], "largest_gap_mm");
    document["families"].push_back(
        {{"name", c.families[f]}, {"best", one}, {"largest_gap_mm", surface(study.per_family[f])}});
  }
  document["l1_mm"] = Json::array();
  document["l2_mm"] = Json::array();
  for (const double l1 : study.l1) document["l1_mm"].push_back(l1 / mm);
  for (const double l2 : study.l2) document["l2_mm"].push_back(l2 / mm);
  document["largest_gap_mm"] = surface(study.largest);
  document["mean_gap_mm"] = surface(study.mean);
  document["placements"] = study.placements;
  return document;
}

std::vector<std::string> row(const std::string& name, const robot::LinkChoice& best) {
  if (!best.exists) return {name, "none"};
  return {name,
          fixed(best.l1 / mm, 1),
          fixed(best.l2 / mm, 1),
          fixed(best.value / mm, 2),
          fixed(best.slope_l1, 2),
          fixed(best.slope_l2, 2)};
}

std::vector<std::vector<std::string>> rows_of(const io::RobotSizeCase& c,
                                              const robot::SizeStudy& study) {
  std::vector<std::vector<std::string>> rows = {
      {"best for", "L1, mm", "L2, mm", "gap, mm", "per mm L1", "per mm L2"}};
  for (std::size_t f = 0; f < c.families.size(); ++f) {
    rows.push_back(row(c.families[f], study.best_per_family[f]));
  }
  rows.push_back(row("largest of all", study.best_largest));
  rows.push_back(row("mean of all", study.best_mean));
  if (c.study.slide_stroke > 0.0) rows.push_back(row("shortest L1 with slide", study.most_compact));
  return rows;
}

/// Under the nominal choices: what errors of placement do to them, and the choices that bear them.
void add_errors(const io::RobotSizeCase& c, const robot::SizeErrorStudy& errors, Shown& shown) {
  shown.document["with_placement_errors"] = errors_document(c, errors);
  const auto percent = [](double share) { return fixed(100.0 * share, 1); };
  const auto add = [&](const std::string& name, const robot::LinkChoice& best,
                       const robot::LengthRisk& at) {
    std::vector<std::string> one = row(name, best);
    if (at.exists) {
      one.resize(6);
      one.insert(one.end(), {percent(at.share_forbidden), fixed(at.gap_95 / mm, 2)});
    }
    shown.rows.push_back(std::move(one));
  };
  shown.rows[0].insert(shown.rows[0].end(), {"out of bounds, %", "95th percentile, mm"});
  for (std::vector<std::string>& one : shown.rows) {
    if (one[0] == "largest of all" && errors.nominal.exists) {
      one.insert(one.end(),
                 {percent(errors.nominal.share_forbidden), fixed(errors.nominal.gap_95 / mm, 2)});
    }
  }
  const std::string margin = fmt::format(", {:.2f} mm margin", errors.margin / mm);
  add("largest" + margin, errors.with_margin.best_largest, errors.largest);
  add("mean" + margin, errors.with_margin.best_mean, errors.mean);
}

Shown solve(const io::CaseRun& run, std::string& no_solution) {
  io::RobotSizeCase c;
  Shown shown;
  shown.expanded =
      io::Section::read(run, [&](io::Section& section) { io::bind_robot_size(section, c); });
  std::vector<robot::ImplantFamily> families;
  std::string assumed;
  for (const std::string& name : c.families) {
    io::ImplantCase sample;
    sample.family = name;
    if (io::implant_of(sample).obtained == "assumed") {
      assumed += (assumed.empty() ? "" : ", ") + name;
    }
    families.push_back(io::implant_family(name));
  }
  if (!assumed.empty()) {
    shown.warnings.push_back(fmt::format(
        "implants {}: their dimensions are assumed, they stand for no product", assumed));
  }
  const robot::SizeStudy study = robot::study_sizes(families, c.study, console_progress());
  if (study.stopped) throw Interrupted{};
  shown.document = document_of(c, study);
  shown.rows = rows_of(c, study);
  if (!study.best_largest.exists) {
    no_solution =
        "no pair of link lengths serves every size of every family; widen size.l1_mm and "
        "size.l2_mm";
    return shown;
  }
  shown.figures = {
      {"largest_gap", "Largest gap over all families and sizes, each at its best place",
       [study](const std::filesystem::path& file) {
         io::draw_size_study(study, study.largest, study.best_largest,
                             "Largest gap over all families and sizes", file);
       }},
      {"mean_gap", "Mean over the families of their largest gap",
       [study](const std::filesystem::path& file) {
         io::draw_size_study(study, study.mean, study.best_mean,
                             "Mean over the families of their largest gap", file);
       }}};
  if (!c.errors) return shown;
  const robot::SizeErrorStudy errors = robot::study_size_errors(families, c.study, study, *c.errors,
                                                                c.kept_share, console_progress());
  if (errors.with_margin.stopped) throw Interrupted{};
  add_errors(c, errors, shown);
  if (!errors.with_margin.best_largest.exists) {
    shown.warnings.push_back(
        fmt::format("no pair of link lengths serves every implant with a margin of {:.2f} mm",
                    errors.margin / mm));
    return shown;
  }
  shown.figures.push_back(
      {"largest_gap_with_errors",
       fmt::format("The same, every place kept {:.2f} mm inside of what is allowed",
                   errors.margin / mm),
       [errors](const std::filesystem::path& file) {
         io::draw_size_study(
             errors.with_margin, errors.with_margin.largest, errors.with_margin.best_largest,
             fmt::format("Largest gap, places {:.2f} mm inside", errors.margin / mm), file);
       }});
  return shown;
}

}  // namespace

void add_robot_size(CLI::App& program) {
  add_robot_command(program, "size", "link lengths over implants and sizes", solve);
}

}  // namespace osteomill::cli
