// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/study_json.hpp"

#include <fmt/format.h>

namespace osteomill::io {
namespace {

using Json = nlohmann::ordered_json;
using namespace study;

Json pair(const Interval& interval) { return {interval.low, interval.high}; }

template <class T>
Json or_null(const std::optional<T>& value) {
  return value ? Json(*value) : Json(nullptr);
}
Json or_null(const std::optional<Interval>& value) { return value ? pair(*value) : Json(nullptr); }

std::string with_unit(const std::string& key, const std::string& column) {
  const std::string unit = unit_of(column);
  return unit.empty() ? key : key + "_" + unit;
}

Json test_json(const TestRecord& test) {
  Json corrections = Json::array();
  for (const Correction& c : test.corrections) {
    corrections.push_back(
        {{"name", c.name}, {"epsilon", c.epsilon}, {"df1", c.df1}, {"df2", c.df2}, {"p", c.p}});
  }
  Json json = {{"name", test.name},           {"response", test.response},
               {"term", test.term},           {"statistic_name", test.statistic_name},
               {"statistic", test.statistic}, {"df1", test.df1},
               {"df2", or_null(test.df2)},    {"p", test.p},
               {"corrections", corrections}};
  if (test.estimate) json["estimate"] = *test.estimate;
  if (test.interval) json["estimate_ci"] = pair(*test.interval);
  return json;
}

/// "ci95": the key says the confidence.
std::string interval_key(const Design& design) {
  return fmt::format("ci{:g}", 100.0 * design.confidence);
}

Json variability_json(const VariabilityRecord& v, const std::string& ci) {
  const auto key = [&](const std::string& name) { return with_unit(name, v.response); };
  Json json = {{"response", v.response},
               {"factor", v.factor},
               {"group", v.group},
               {"count", v.count},
               {key("sd"), v.sd},
               {key(ci), pair(v.interval)},
               {"degrees_of_freedom", v.degrees_of_freedom},
               {key("alignment_sd"), v.combined_sd},
               {key("alignment_" + ci), pair(v.combined_interval)}};
  json[key("bootstrap_" + ci)] = or_null(v.bootstrap_interval);
  const auto coverage = [](const std::optional<CoverageRange>& c) {
    return c ? Json{c->low, c->high} : Json(nullptr);
  };
  json[ci + "_measured_coverage_if_not_normal"] = coverage(v.coverage_if_not_normal);
  json["bootstrap_" + ci + "_measured_coverage"] = coverage(v.bootstrap_coverage);
  return json;
}

Json forecast_json(const Forecast& f) {
  return {{"mean_deg", f.mean},
          {"sd_deg", f.sd},
          {"tolerance_deg", pair(f.tolerance)},
          {"share_outside", f.outside.estimate},
          {"share_outside_ci", pair(f.outside.interval)}};
}

Json design_json(const Design& d) {
  const char* types[] = {"I", "II", "III"};
  return {{"subject", d.subject},
          {"between", d.between},
          {"within", d.within},
          {"blocks", d.blocks},
          {"covariates", d.covariates},
          {"responses", d.responses},
          {"random", d.random},
          {"exclusive_means", d.exclusive_means},
          {"sum_of_squares", types[static_cast<int>(d.sum_of_squares)]},
          {"confidence", d.confidence},
          {"alpha", d.alpha},
          {"limit_deg", d.limit_deg},
          {"cuts_per_alignment", d.cuts_per_alignment},
          {"tolerance_content", d.tolerance_content},
          {"seed", d.seed}};
}

Json findings_json(const std::vector<Finding>& findings) {
  Json list = Json::array();
  for (const Finding& f : findings) {
    list.push_back({{"what", f.what}, {"still", f.still}, {"lines", f.lines}});
  }
  return list;
}

}  // namespace

Json study_document(const StudyReport& r) {
  const std::string ci = interval_key(r.design);
  Json json;
  json["rows"] = r.rows;
  json["design"] = design_json(r.design);
  json["findings"] = findings_json(r.findings);
  auto& tests = json["tests"] = Json::array();
  for (const TestRecord& test : r.tests) tests.push_back(test_json(test));
  auto& assumptions = json["assumptions"] = Json::array();
  for (const AssumptionRecord& a : r.assumptions) {
    assumptions.push_back({{"name", a.name},
                           {"response", a.response},
                           {"term", a.term},
                           {"holds", a.holds},
                           {"statistic", a.statistic},
                           {"p", a.p},
                           {"consequence", a.consequence}});
  }
  json["normality_note"] = normality_note();
  auto& groups = json["groups"] = Json::array();
  for (const GroupSummary& g : r.groups) {
    const auto key = [&](const char* name) { return with_unit(name, g.response); };
    groups.push_back({{"response", g.response},
                      {"factor", g.factor},
                      {"group", g.group},
                      {"count", g.count},
                      {key("mean"), g.mean},
                      {key("sd_about_mean"), g.sd},
                      {key("range"), {g.low, g.high}}});
  }
  auto& variability = json["variability"] = Json::array();
  for (const VariabilityRecord& v : r.variability) variability.push_back(variability_json(v, ci));
  auto& forecasts = json["forecasts"] = Json::array();
  for (const ForecastRecord& f : r.forecasts) {
    forecasts.push_back({{"response", f.response},
                         {"factor", f.factor},
                         {"group", f.group},
                         {"operators", f.population.operators},
                         {"one_cut", forecast_json(f.one_cut)},
                         {"alignment", forecast_json(f.alignment)}});
  }
  auto& regressions = json["regressions"] = Json::array();
  for (const RegressionRecord& g : r.regressions) {
    regressions.push_back({{"response", g.response},
                           {"covariate", g.covariate},
                           {"factor", g.factor},
                           {"group", g.group},
                           {"count", g.count},
                           {"slope", g.slope},
                           {"slope_" + ci, pair(g.slope_interval)},
                           {"intercept", g.intercept},
                           {"intercept_" + ci, or_null(g.intercept_interval)},
                           {"r_squared", g.r_squared},
                           {"r_squared_" + ci, or_null(g.r_squared_interval)},
                           {"p", g.p}});
  }
  auto& components = json["variance_components"] = Json::array();
  for (const ComponentRecord& c : r.components) {
    components.push_back({{"response", c.response},
                          {"source", c.component.name},
                          {with_unit("sd", c.response), c.component.sd},
                          {with_unit(ci, c.response), pair(c.component.sd_interval)},
                          {"share", c.component.share},
                          {"at_zero", c.component.at_zero}});
  }
  auto& contributions = json["contributions"] = Json::array();
  for (const ContributionRecord& c : r.contributions) {
    contributions.push_back({{"response", c.response},
                             {"source", c.source},
                             {"variance", c.variance},
                             {"share", c.share}});
  }
  auto& adjusted = json["adjusted_means"] = Json::array();
  for (const AdjustedMeanRecord& a : r.adjusted_means) {
    adjusted.push_back({{"response", a.response},
                        {"group", a.adjusted.level},
                        {"count", a.adjusted.count},
                        {"mean", a.adjusted.mean},
                        {"standard_error", a.adjusted.standard_error},
                        {ci, pair(a.adjusted.interval)}});
  }
  return json;
}

Json plan_document(const Plan& plan) {
  const auto point = [](const PlanPoint& p) {
    return Json{{"operators", p.operators}, {"cuts", p.cuts}, {"power", p.power}};
  };
  Json json;
  json["feasible"] = plan.feasible;
  json["reason"] = plan.reason;
  json["operators"] = plan.feasible ? Json(plan.least.operators) : Json(nullptr);
  json["cuts"] = plan.feasible ? Json(plan.least.cuts) : Json(nullptr);
  json["power"] = plan.feasible ? Json(plan.least.power) : Json(nullptr);
  json["curve"] = Json::array();
  for (const PlanPoint& p : plan.curve) json["curve"].push_back(point(p));
  return json;
}

}  // namespace osteomill::io
