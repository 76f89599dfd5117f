// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/study_report.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace osteomill::io {
namespace {

using namespace study;

std::string range(const Interval& i) { return fmt::format("{:.3g} … {:.3g}", i.low, i.high); }

std::string corrections_of(const TestRecord& t) {
  std::string text;
  for (const Correction& c : t.corrections) {
    text += (text.empty() ? "" : "; ") + c.name + " " + p_words(c.p);
  }
  return text;
}

ReportTable tests_table(const StudyReport& report, bool pairs) {
  ReportTable table;
  table.columns = {{.name = "test"},
                   {.name = "response"},
                   {.name = "term"},
                   {.name = "statistic", .digits = 3},
                   {.name = "df1", .digits = 1},
                   {.name = "df2", .digits = 1},
                   {.name = "p"},
                   {.name = "corrected"}};
  if (pairs)
    table.columns.insert(
        table.columns.begin() + 3,
        {.name = "estimate",
         .about = "difference of means, or ratio of variances, with its interval"});
  for (const TestRecord& t : report.tests) {
    if (t.estimate.has_value() != pairs) continue;
    std::vector<ReportCell> row(table.columns.size());
    size_t at = 0;
    row[at++] = t.name;
    row[at++] = in_words(t.response);
    row[at++] = t.term;
    if (pairs) row[at++] = fmt::format("{:.3g} ({})", *t.estimate, range(*t.interval));
    row[at++] = t.statistic;
    row[at++] = t.df1;
    if (t.df2) row[at] = *t.df2;
    row[++at] = p_words(t.p);
    row[++at] = corrections_of(t);
    table.rows.push_back(std::move(row));
  }
  return table;
}

ReportTable variability_table(const StudyReport& report) {
  ReportTable table;
  const std::string interval = fmt::format("{:g} % interval", 100.0 * report.design.confidence);
  table.caption =
      "Cut to cut: residuals about the exclusive means of each operator and condition. The first "
      "interval is exact for normal errors; the second does not suppose them, and what it held is "
      "how often it did so in simulated studies of as many cuts, over twelve shapes of errors.";
  table.columns = {{.name = "response"},
                   {.name = "by"},
                   {.name = "group"},
                   {.name = "cuts", .digits = 0},
                   {.name = "SD", .digits = 3, .bars = false},
                   {.name = interval, .about = "of normal errors"},
                   {.name = "df", .digits = 0},
                   {.name = fmt::format("SD of {} cuts", report.design.cuts_per_alignment),
                    .digits = 2,
                    .about = "of an alignment that rests on so many cuts"},
                   {.name = "without normality"},
                   {.name = "held", .about = "the truth, in simulations"}};
  for (const VariabilityRecord& v : report.variability) {
    const bool angle = unit_of(v.response) == "deg";
    table.rows.push_back(
        {in_words(v.response), v.factor, v.group, 1.0 * v.count, v.sd, range(v.interval),
         v.degrees_of_freedom, angle ? ReportCell(v.combined_sd) : ReportCell(),
         v.bootstrap_interval ? ReportCell(range(*v.bootstrap_interval)) : ReportCell(),
         v.bootstrap_interval ? ReportCell(coverage_words(v.bootstrap_coverage)) : ReportCell()});
  }
  return table;
}

ReportTable assumptions_table(const StudyReport& report) {
  ReportTable table;
  table.columns = {{.name = "assumption"}, {.name = "response"},
                   {.name = "term"},       {.name = "statistic", .digits = 4},
                   {.name = "p"},          {.name = "holds"}};
  for (const AssumptionRecord& a : report.assumptions) {
    table.rows.push_back({a.name, in_words(a.response), a.term, a.statistic, p_words(a.p),
                          std::string(a.holds ? "yes" : "no")});
  }
  return table;
}

ReportTable forecasts_table(const StudyReport& report) {
  ReportTable table;
  const Design& d = report.design;
  table.caption = fmt::format(
      "Cuts of other operators of the same kind; window ± {:g}°; an alignment rests on {} cuts.",
      d.limit_deg, d.cuts_per_alignment);
  table.columns = {
      {.name = "response"},
      {.name = "by"},
      {.name = "group"},
      {.name = "mean", .unit = "°"},
      {.name = "total SD", .unit = "°"},
      {.name = fmt::format("holds {:g} % of cuts", 100.0 * d.tolerance_content), .unit = "°"},
      {.name = "one cut outside", .unit = "%", .digits = 1},
      {.name = "interval", .unit = "%"},
      {.name = "alignment outside", .unit = "%", .digits = 1},
      {.name = "its interval", .unit = "%"}};
  const auto percent = [](const Interval& i) { return range({100.0 * i.low, 100.0 * i.high}); };
  for (const ForecastRecord& f : report.forecasts) {
    table.rows.push_back({in_words(f.response), f.factor, f.group, f.one_cut.mean, f.one_cut.sd,
                          range(f.one_cut.tolerance), 100.0 * f.one_cut.outside.estimate,
                          percent(f.one_cut.outside.interval), 100.0 * f.alignment.outside.estimate,
                          percent(f.alignment.outside.interval)});
  }
  return table;
}

ReportTable components_table(const StudyReport& report) {
  ReportTable table;
  table.columns = {{.name = "response"},
                   {.name = "source"},
                   {.name = "SD", .digits = 3},
                   {.name = "interval"},
                   {.name = "share", .unit = "%", .digits = 0, .bars = true}};
  for (const ComponentRecord& c : report.components) {
    table.rows.push_back({in_words(c.response), c.component.name, c.component.sd,
                          range(c.component.sd_interval), 100.0 * c.component.share});
  }
  return table;
}

ReportTable regressions_table(const StudyReport& report) {
  ReportTable table;
  table.columns = {{.name = "response"},
                   {.name = "against"},
                   {.name = "group"},
                   {.name = "cuts", .digits = 0},
                   {.name = "slope"},
                   {.name = "its interval"},
                   {.name = "intercept"},
                   {.name = "r²", .unit = "%", .digits = 1},
                   {.name = "interval of r²", .unit = "%"},
                   {.name = "p"}};
  for (const RegressionRecord& r : report.regressions) {
    const auto& i = r.r_squared_interval;
    table.rows.push_back({in_words(r.response), in_words(r.covariate), r.group, 1.0 * r.count,
                          r.slope, range(r.slope_interval), r.intercept, 100.0 * r.r_squared,
                          i ? ReportCell(range({100.0 * i->low, 100.0 * i->high})) : ReportCell(),
                          p_words(r.p)});
  }
  return table;
}

ReportTable adjusted_table(const StudyReport& report) {
  ReportTable table;
  table.caption = "Means of the groups at the covariates' means.";
  table.columns = {{.name = "response"},
                   {.name = "group"},
                   {.name = "cuts", .digits = 0},
                   {.name = "adjusted mean", .digits = 3},
                   {.name = "standard error", .digits = 3},
                   {.name = "interval"}};
  for (const AdjustedMeanRecord& a : report.adjusted_means) {
    table.rows.push_back({in_words(a.response), a.adjusted.level, 1.0 * a.adjusted.count,
                          a.adjusted.mean, a.adjusted.standard_error, range(a.adjusted.interval)});
  }
  return table;
}

/// Behind a number: "°", " s".
std::string unit_word(const std::string& response) {
  const std::string unit = unit_of(response);
  return unit.empty() || unit == "deg" ? unit_in_words(unit) : " " + unit_in_words(unit);
}

const VariabilityRecord* variability_of(const StudyReport& report, const std::string& response,
                                        const std::string& group) {
  for (const VariabilityRecord& v : report.variability) {
    if (v.response == response && v.group == group && v.factor.find(" × ") == std::string::npos &&
        v.factor != report.design.subject) {
      return &v;
    }
  }
  return nullptr;
}

/// The interval to read: that without normality where the residuals are not normal.
Interval interval_of(const StudyReport& report, const VariabilityRecord& v) {
  for (const AssumptionRecord& a : report.assumptions) {
    if (a.response == v.response && a.name.starts_with("normal residuals") && !a.holds) {
      return v.bootstrap_interval.value_or(v.interval);
    }
  }
  return v.interval;
}

}  // namespace

std::string in_words(const std::string& column) {
  const std::string unit = unit_of(column);
  std::string text = unit.empty() ? column : column.substr(0, column.size() - unit.size() - 1);
  for (const char* pair : {"varus_valgus", "flexion_extension"}) {
    const size_t at = text.find(pair);
    if (at != std::string::npos) text[text.find('_', at)] = '/';
  }
  std::replace(text.begin(), text.end(), '_', ' ');
  return text;
}

std::string unit_in_words(const std::string& unit) {
  if (unit == "deg") return "°";
  if (unit == "mm3_per_s") return "mm³/s";
  std::string text = unit;
  std::replace(text.begin(), text.end(), '_', ' ');
  return text;
}

std::string p_words(double p) {
  return p < 1e-4 ? std::string("p < 0.0001") : fmt::format("p = {:.4f}", p);
}

std::string coverage_words(const std::optional<CoverageRange>& coverage) {
  if (!coverage) return "not measured";
  return fmt::format("{:.0f}–{:.0f} %", 100.0 * coverage->low, 100.0 * coverage->high);
}

std::vector<std::string> study_sentences(const StudyReport& report) {
  std::vector<std::string> sentences;
  for (const std::string& response : report.design.responses) {
    const std::string unit = unit_word(response);
    for (const TestRecord& t : report.tests) {
      if (t.response != response || t.name != "F-test of variances" ||
          t.term.find(" | ") != std::string::npos) {
        continue;
      }
      const size_t colon = t.term.find(": "), slash = t.term.find(" / ");
      const std::string a = t.term.substr(colon + 2, slash - colon - 2),
                        b = t.term.substr(slash + 3);
      const auto* va = variability_of(report, response, a);
      const auto* vb = variability_of(report, response, b);
      if (!va || !vb) continue;
      sentences.push_back(fmt::format("{}, {}: SD {:.2g}{} ({}) {} against {:.2g}{} ({}) {}, {}.",
                                      in_words(response), t.term.substr(0, colon), va->sd, unit,
                                      range(interval_of(report, *va)), a, vb->sd, unit,
                                      range(interval_of(report, *vb)), b, p_words(t.p)));
    }
    for (const TestRecord& t : report.tests) {
      if (t.response != response || t.estimate || t.statistic_name != "F" ||
          t.name == "ANCOVA, equal slopes" || t.p >= report.design.alpha ||
          t.name.starts_with("mixed") || t.term.starts_with("guide_movement_")) {
        continue;
      }
      sentences.push_back(fmt::format("{}: the mean depends on {} ({}, F = {:.2f}, {}).",
                                      in_words(response), t.term, t.name, t.statistic,
                                      p_words(t.p)));
    }
  }
  return sentences;
}

ReportData study_page(const StudyReport& report, const std::string& name) {
  ReportData page;
  page.title = "Cutting-error study: " + name;
  page.subtitle = fmt::format("{} rows; subject: {}", report.rows, report.design.subject);
  page.headline = study_sentences(report);
  // The errors come first; what does not fit above the fold stands in the tables.
  constexpr size_t kMostSentences = 8;
  if (page.headline.size() > kMostSentences) page.headline.resize(kMostSentences);
  for (const std::string& response : report.design.responses) {
    const VariabilityRecord* all = variability_of(report, response, "all");
    if (!all || page.highlights.size() >= 4) continue;
    page.highlights.push_back(
        {fmt::format("{:.3g}", all->sd), unit_in_words(unit_of(response)),
         "SD of " + in_words(response),
         fmt::format("{} from {:g} degrees of freedom", range(interval_of(report, *all)),
                     all->degrees_of_freedom)});
  }
  for (const AssumptionRecord& a : report.assumptions) {
    if (a.holds) continue;
    page.notes.push_back(
        {.kind = ReportNote::Kind::assumption,
         .text = fmt::format("{}, {}: {} does not hold ({}): {}.", in_words(a.response), a.term,
                             a.name, p_words(a.p), a.consequence)});
  }
  page.notes.push_back({.kind = ReportNote::Kind::assumption, .text = normality_note()});
  for (const Finding& f : report.findings) {
    page.notes.push_back(
        {.kind = ReportNote::Kind::warning, .text = f.what + ": " + f.still + "."});
  }
  const auto add = [&](const char* heading, ReportTable table) {
    if (!table.rows.empty()) page.sections.push_back({heading, {std::move(table)}});
  };
  add("Variability", variability_table(report));
  add("Tests", tests_table(report, false));
  add("Assumptions", assumptions_table(report));
  add("What other operators would do", forecasts_table(report));
  add("Components of variance", components_table(report));
  add("Regressions", regressions_table(report));
  add("Adjusted means", adjusted_table(report));
  add("Level against level", tests_table(report, true));
  return page;
}

}  // namespace osteomill::io
