// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/study_figures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "osteomill/io/colour.hpp"
#include "osteomill/io/gnuplot.hpp"
#include "osteomill/io/study_report.hpp"

namespace osteomill::io {
namespace {

using namespace study;
namespace fs = std::filesystem;

/// "varus/valgus, deg"
std::string label_of(const std::string& column) {
  const std::string unit = unit_of(column);
  return unit.empty() ? in_words(column) : in_words(column) + ", " + unit_in_words(unit);
}

std::string file_word(std::string text) {
  std::replace(text.begin(), text.end(), '_', '-');
  return text;
}

struct Canvas {
  int width = 800;
  int height = 420;
  std::string x_label = {};
  std::string y_label = {};
  std::vector<std::string> tics = {};  ///< names at x = 0, 1, ...
  double x_low = 0.0, x_high = 1.0;
  double y_low = 0.0, y_high = 1.0;
};

std::string set_up(const Canvas& c, const fs::path& path) {
  std::string script = gnuplot::prologue(path, c.width, c.height);
  script +=
      fmt::format("set xrange [{}:{}]\nset yrange [{}:{}]\n", c.x_low, c.x_high, c.y_low, c.y_high);
  script += fmt::format("set ylabel {}\nset xlabel {}\n", gnuplot::quoted(c.y_label),
                        gnuplot::quoted(c.x_label));
  if (!c.tics.empty()) {
    std::vector<std::string> tics;
    for (size_t i = 0; i < c.tics.size(); ++i) {
      tics.push_back(fmt::format("{} {}", gnuplot::quoted(c.tics[i]), i));
    }
    size_t letters = 0;
    for (const std::string& tic : c.tics) letters += tic.size() + 2;
    const bool slanted = letters * 7 > static_cast<size_t>(c.width);
    script += fmt::format("set xtics ({}) scale 0{}\nset grid noxtics\n", fmt::join(tics, ", "),
                          slanted ? " rotate by -25" : "");
  }
  script +=
      "set xzeroaxis lt 1 lc rgb '#555555' lw 0.75\nset key outside top right horizontal samplen "
      "1\n";
  return script;
}

std::string plot(const std::vector<std::string>& parts) {
  return fmt::format("plot {}\n", fmt::join(parts, ", \\\n  "));
}

/// Range of y with a little air.
void fit(Canvas& c, const std::vector<double>& values, bool from_zero) {
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  const double span = std::max(*high - (from_zero ? 0.0 : *low), 1e-9);
  c.y_low = from_zero || *low >= 0.0 ? 0.0 : *low - 0.06 * span;
  c.y_high = *high + 0.06 * span;
}

std::vector<std::string> groups_of(const StudyReport& report, const std::string& response,
                                   const std::string& factor) {
  std::vector<std::string> names;
  for (const GroupSummary& g : report.groups) {
    if (g.response == response && g.factor == factor) names.push_back(g.group);
  }
  return names;
}

struct Split {
  std::string subject, rest;
};
Split split(const std::string& group) {
  const std::string times = " × ";
  const size_t at = group.find(times);
  if (at == std::string::npos) return {group, ""};
  return {group.substr(0, at), group.substr(at + times.size())};
}

/// Mean as a bold line, box of plus and minus one SD, whiskers over the range.
void draw_boxes(const StudyReport& report, const std::string& response, const std::string& factor,
                const fs::path& path) {
  std::vector<std::string> subjects, kinds;
  const auto place = [](std::vector<std::string>& list, const std::string& name) {
    const auto found = std::find(list.begin(), list.end(), name);
    if (found != list.end()) return static_cast<size_t>(found - list.begin());
    list.push_back(name);
    return list.size() - 1;
  };
  struct Box {
    size_t subject, kind;
    const GroupSummary* summary;
  };
  std::vector<Box> boxes;
  Canvas c{.y_label = label_of(response)};
  std::vector<double> extent = {0.0};
  for (const GroupSummary& g : report.groups) {
    if (g.response != response || g.factor != factor) continue;
    const Split name = split(g.group);
    boxes.push_back({place(subjects, name.subject), place(kinds, name.rest), &g});
    extent.insert(extent.end(), {g.low, g.high, g.mean - g.sd, g.mean + g.sd});
  }
  c.tics = subjects;
  c.x_label = report.design.subject;
  c.x_low = -0.6;
  c.x_high = static_cast<double>(subjects.size()) - 0.4;
  fit(c, extent, false);
  const double width = 0.8 / static_cast<double>(kinds.size());
  std::string blocks;
  std::vector<std::string> parts;
  for (size_t k = 0; k < kinds.size(); ++k) {
    std::vector<double> x, mean, low, high, least, most, half;
    for (const Box& box : boxes) {
      if (box.kind != k) continue;
      x.push_back(static_cast<double>(box.subject) - 0.4 + width * (static_cast<double>(k) + 0.5));
      mean.push_back(box.summary->mean);
      low.push_back(box.summary->mean - box.summary->sd);
      high.push_back(box.summary->mean + box.summary->sd);
      least.push_back(box.summary->low);
      most.push_back(box.summary->high);
      half.push_back(0.36 * width);
    }
    const std::string name = fmt::format("k{}", k), colour = hex(palette(k));
    blocks += gnuplot::data_block(name, {&x, &mean, &low, &high, &least, &most, &half});
    parts.push_back(fmt::format("${} using 1:5:(0):($6-$5) with vectors nohead lw 1 lc rgb '{}'",
                                name, colour));
    parts.push_back(fmt::format(
        "${} using 1:2:($1-$7):($1+$7):3:4 with boxxyerror fc rgb '{}' fs solid 0.35 border lc rgb "
        "'{}'{}",
        name, colour, colour, kinds[k].empty() ? "" : " title " + gnuplot::quoted(kinds[k])));
    parts.push_back(fmt::format(
        "${} using ($1-$7):2:(2*$7):(0) with vectors nohead lw 3 lc rgb '{}'", name, colour));
  }
  gnuplot::run(set_up(c, path) + blocks + plot(parts), path);
}

/// SDs with their intervals: each operator, then each group.
void draw_variability(const StudyReport& report, const std::string& response,
                      const fs::path& path) {
  Canvas c{.y_label = "SD of " + label_of(response)};
  std::vector<double> x, sd, low, high, colour, extent;
  const auto add = [&](const VariabilityRecord& v, int kind) {
    x.push_back(static_cast<double>(x.size()));
    c.tics.push_back(v.factor == "all" ? "all" : v.group);
    sd.push_back(v.sd);
    low.push_back(v.interval.low);
    high.push_back(v.interval.high);
    colour.push_back(kind);
    extent.push_back(v.interval.high);
  };
  const auto take = [&](bool subjects) {
    for (const VariabilityRecord& v : report.variability) {
      const bool is_subject = v.factor == report.design.subject;
      const bool crossed = v.factor.find(" × ") != std::string::npos;
      if (v.response == response && is_subject == subjects && !crossed) add(v, subjects ? 0 : 1);
    }
  };
  take(true);
  take(false);
  // An SD of one degree of freedom has an interval that would hide all others.
  std::vector<double> sorted = extent;
  std::sort(sorted.begin(), sorted.end());
  fit(c, {0.0, std::min(sorted.back(), 2.5 * sorted[sorted.size() / 2])}, true);
  c.x_low = -0.6;
  c.x_high = static_cast<double>(x.size()) - 0.4;
  const std::string block = gnuplot::data_block("v", {&x, &sd, &low, &high, &colour});
  const std::vector<std::string> parts = {
      fmt::format(
          "$v using 1:($5==0?$2:1/0):(0.6) with boxes fs solid 0.85 noborder lc rgb '{}' title {}",
          hex(palette(5)), gnuplot::quoted("each " + report.design.subject)),
      fmt::format(
          "$v using 1:($5==1?$2:1/0):(0.6) with boxes fs solid 0.85 noborder lc rgb '{}' title "
          "'pooled'",
          hex(palette(0))),
      "$v using 1:3:(0):($4-$3) with vectors nohead lw 1 lc rgb '#222222'"};
  gnuplot::run(set_up(c, path) + block + plot(parts), path);
}

/// Error against guide movement: points by group, its line, the line of all dashed.
void draw_movement(const StudyReport& report, const std::string& response,
                   const std::string& covariate, const fs::path& path) {
  Canvas c{
      .width = 620, .height = 460, .x_label = label_of(covariate), .y_label = label_of(response)};
  std::string factor = "all";
  for (const RegressionRecord& r : report.regressions) {
    const bool crossed = r.factor.find(" × ") != std::string::npos;
    if (r.response == response && r.factor != "all" && !crossed) factor = r.factor;
  }
  std::vector<double> all_x, all_y;
  std::string blocks;
  std::vector<std::string> parts;
  size_t kind = 0;
  for (const RegressionRecord& r : report.regressions) {
    if (r.response != response || r.covariate != covariate) continue;
    if (r.factor == "all") {
      all_x = r.x;
      all_y = r.y;
      parts.push_back(fmt::format("{} + {}*x lc rgb '#555555' lw 1 dt 2 title 'all: r2 {:.0f} %'",
                                  r.intercept, r.slope, 100.0 * r.r_squared));
      if (factor != "all") continue;
    }
    if (r.factor != factor) continue;
    const std::string name = fmt::format("m{}", kind), colour = hex(palette(kind));
    blocks += gnuplot::data_block(name, {&r.x, &r.y});
    parts.push_back(fmt::format("${} with points pt {} ps 0.55 lc rgb '{}'", name,
                                kind % 2 == 0 ? 7 : 5, colour));
    if (r.factor != "all") {
      const auto [low, high] = std::minmax_element(r.x.begin(), r.x.end());
      parts.push_back(fmt::format(
          "[{}:{}] {} + {}*x lc rgb '{}' lw 1.6 title {}", *low, *high, r.intercept, r.slope,
          colour, gnuplot::quoted(fmt::format("{}: r2 {:.0f} %", r.group, 100.0 * r.r_squared))));
    }
    ++kind;
  }
  const auto [low, high] = std::minmax_element(all_x.begin(), all_x.end());
  const double air = 0.06 * std::max(*high - *low, 1e-9);
  c.x_low = *low - air;
  c.x_high = *high + air;
  fit(c, all_y, false);
  gnuplot::run(set_up(c, path) + blocks + plot(parts), path);
}

/// Shares of the variance, one stacked bar a response.
void draw_contributions(const StudyReport& report, const fs::path& path) {
  std::vector<std::string> responses, sources;
  for (const ContributionRecord& r : report.contributions) {
    if (std::find(responses.begin(), responses.end(), r.response) == responses.end()) {
      responses.push_back(r.response);
    }
    if (r.source != "cut (rest)" &&
        std::find(sources.begin(), sources.end(), r.source) == sources.end()) {
      sources.push_back(r.source);
    }
  }
  sources.push_back("cut (rest)");
  Canvas c{.width = 680, .height = 380, .y_label = "share of the variance, %"};
  for (const std::string& response : responses) {
    c.tics.push_back(in_words(response));
  }
  c.x_low = -0.6;
  c.x_high = static_cast<double>(responses.size()) - 0.4;
  c.y_high = 100.0;
  std::vector<double> base(responses.size(), 0.0), x;
  for (size_t i = 0; i < responses.size(); ++i) x.push_back(static_cast<double>(i));
  std::string blocks;
  std::vector<std::string> parts;
  for (size_t s = 0; s < sources.size(); ++s) {
    std::vector<double> top = base;
    for (const ContributionRecord& r : report.contributions) {
      if (r.source != sources[s]) continue;
      const auto at = std::find(responses.begin(), responses.end(), r.response) - responses.begin();
      top[static_cast<size_t>(at)] += 100.0 * r.share;
    }
    const std::string name = fmt::format("c{}", s);
    blocks += gnuplot::data_block(name, {&x, &base, &top});
    const bool rest = sources[s] == "cut (rest)";
    parts.push_back(
        fmt::format("${} using 1:2:($1-0.3):($1+0.3):2:3 with boxxyerror fs solid 0.85 noborder lc "
                    "rgb '{}' title {}",
                    name, rest ? "#b8b8b8" : hex(palette(s)), gnuplot::quoted(sources[s])));
    base = top;
  }
  gnuplot::run(set_up(c, path) + blocks + plot(parts), path);
}

}  // namespace

std::vector<StudyFigure> study_figures(const StudyReport& report) {
  std::vector<StudyFigure> figures;
  std::string crossed = report.design.subject;
  for (const std::string& name : report.design.within) crossed += " × " + name;
  for (const std::string& response : report.design.responses) {
    const std::string name = file_word(response);
    const std::string said = label_of(response);
    if (groups_of(report, response, crossed).size() > 1) {
      figures.push_back(
          {"boxes-" + name,
           said + ": bold line = mean, box = ± SD, whiskers = range, by " + crossed + ".",
           [&report, response, crossed](const fs::path& file) {
             draw_boxes(report, response, crossed, file);
           }});
    }
    const bool pooled = std::any_of(report.variability.begin(), report.variability.end(),
                                    [&](const auto& v) { return v.response == response; });
    if (pooled) {
      figures.push_back(
          {"variability-" + name,
           fmt::format("Cut-to-cut variability of {}: SD about exclusive means, bars = "
                       "{:g} % intervals (those that end outside the frame have few "
                       "degrees of freedom).",
                       said, 100.0 * report.design.confidence),
           [&report, response](const fs::path& file) {
             draw_variability(report, response, file);
           }});
    }
    std::set<std::string> covariates;
    for (const RegressionRecord& r : report.regressions) {
      if (r.response == response) covariates.insert(r.covariate);
    }
    for (const std::string& covariate : covariates) {
      figures.push_back(
          {"against-" + file_word(covariate) + "-" + name,
           fmt::format("{} against {}, with least-squares lines.", said, label_of(covariate)),
           [&report, response, covariate](const fs::path& file) {
             draw_movement(report, response, covariate, file);
           }});
    }
  }
  if (!report.contributions.empty()) {
    figures.push_back(
        {"contributions",
         "What makes the variance: REML components; guide movement is the share of the "
         "cut-to-cut variance that goes when the movement is known.",
         [&report](const fs::path& file) { draw_contributions(report, file); }});
  }
  return figures;
}

}  // namespace osteomill::io
