// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/study/analysis.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "osteomill/base/error.hpp"
#include "osteomill/numerics/distributions.hpp"
#include "osteomill/study/slice.hpp"

namespace osteomill::study {
namespace {

const std::string kMovement = "guide_movement_";

bool contains(const std::vector<std::string>& list, const std::string& name) {
  return std::find(list.begin(), list.end(), name) != list.end();
}

std::string joined(const std::vector<std::string>& list) {
  std::string text;
  for (const std::string& item : list) text += (text.empty() ? "" : ", ") + item;
  return text;
}

/// Whether the factor takes two levels within some subject.
bool varies_inside(const Factor& factor, const Factor& subject) {
  std::vector<int> seen(subject.levels.size(), -1);
  for (size_t i = 0; i < factor.level.size(); ++i) {
    const int s = subject.level[i], l = factor.level[i];
    if (s < 0 || l < 0) continue;
    if (seen[s] >= 0 && seen[s] != l) return true;
    seen[s] = l;
  }
  return false;
}

/// Factors on the wrong side of between and within are moved, and the report says so.
void settle_sides(Design& design, const Table& table, std::vector<Finding>& findings) {
  if (!table.find(design.subject)) return;
  const Factor subject = factor(table, design.subject);
  const auto move = [&](std::vector<std::string>& from, std::vector<std::string>& to, bool wanted,
                        const char* is, const char* becomes) {
    for (size_t i = 0; i < from.size();) {
      if (varies_inside(factor(table, from[i]), subject) != wanted) {
        ++i;
        continue;
      }
      findings.push_back({fmt::format("{} {} within {}", from[i], is, design.subject),
                          fmt::format("taken as a factor {} subjects", becomes),
                          {}});
      to.push_back(from[i]);
      from.erase(from.begin() + static_cast<std::ptrdiff_t>(i));
    }
  };
  const std::vector<std::string> between = design.between;
  move(design.between, design.within, true, "varies", "within");
  std::vector<std::string> moved(
      design.within.end() - static_cast<std::ptrdiff_t>(between.size() - design.between.size()),
      design.within.end());
  std::vector<std::string> own(design.within.begin(),
                               design.within.end() - static_cast<std::ptrdiff_t>(moved.size()));
  move(own, design.between, false, "is constant", "between");
  own.insert(own.end(), moved.begin(), moved.end());
  design.within = std::move(own);
}

void require_columns(const Design& design, const Table& table) {
  std::vector<Fault> faults;
  const auto check = [&](const char* key, const std::vector<std::string>& names) {
    for (const std::string& name : names) {
      if (!table.find(name)) {
        faults.push_back(Fault{key, name, "no such column",
                               fmt::format("{} has: {}", table.source, joined(table.columns))});
      }
    }
  };
  check("between", design.between);
  check("within", design.within);
  check("blocks", design.blocks);
  check("covariates", design.covariates);
  check("responses", design.responses);
  check("random", design.random);
  check("exclusive_means", design.exclusive_means);
  if (!design.within.empty() && !table.find(design.subject)) check("subject", {design.subject});
  if (design.responses.empty() && faults.empty()) {
    faults.push_back(Fault{"responses", "",
                           "the table has no varus_valgus_deg, "
                           "flexion_extension_deg or time_s",
                           "name the measured columns in the design: responses = [...]"});
  }
  if (!faults.empty()) throw InvalidInput(std::move(faults));
}

std::vector<std::string> covariates_of(const Design& design, const Table& table,
                                       const std::string& response) {
  std::vector<std::string> own;
  for (const std::string& name : design.covariates) {
    const bool matched =
        name.starts_with(kMovement) && contains(design.responses, name.substr(kMovement.size()));
    if (!matched || name == kMovement + response) own.push_back(name);
  }
  const std::string movement = kMovement + response;
  if (design.covariates.empty() && table.find(movement)) own.push_back(movement);
  return own;
}

/// Rows that have the response and every factor; what is missing is named once a column.
struct Sliced {
  Slice slice;            ///< covariates left out
  Slice with_covariates;  ///< rows that have them too
};

Sliced make_slices(const Design& design, const Table& table, const std::string& response,
                   std::vector<Finding>& findings) {
  std::vector<bool> keep(table.rows.size(), true);
  const auto missing = [&](const std::string& column, const std::vector<bool>& present,
                           const std::string& still, std::vector<bool>& rows) {
    Finding finding{fmt::format("{}: {} is missing", response, column), still, {}};
    if (column == response) finding.what = fmt::format("missing cells: {} is empty", response);
    for (size_t i = 0; i < present.size(); ++i) {
      if (rows[i] && !present[i]) finding.lines.push_back(table.rows[i].line);
      rows[i] = rows[i] && present[i];
    }
    if (!finding.lines.empty()) findings.push_back(std::move(finding));
  };
  const auto present = [](const auto& values, const auto& test) {
    std::vector<bool> result;
    for (const auto& value : values) result.push_back(test(value));
    return result;
  };
  const auto is_number = [](const std::optional<double>& v) { return v.has_value(); };
  const auto is_level = [](int l) { return l >= 0; };

  const auto values = numbers(table, response);
  missing(response, present(values, is_number), "those rows are left out of this response alone",
          keep);
  Slice all;
  all.response = response;
  const auto add = [&](const std::vector<std::string>& names, std::vector<Factor>& to) {
    for (const std::string& name : names) {
      to.push_back(factor(table, name));
      missing(name, present(to.back().level, is_level), "those rows are left out", keep);
    }
  };
  add(design.between, all.between);
  add(design.within, all.within);
  add(design.blocks, all.blocks);
  add(design.random, all.random);
  if (table.find(design.subject)) {
    std::vector<Factor> subject;
    add({design.subject}, subject);
    all.subject = subject.front();
  }
  std::vector<Factor> cells;
  for (const std::string& name : design.exclusive_means) cells.push_back(factor(table, name));
  all.cell = combined(cells, static_cast<int>(table.rows.size()));
  all.y.resize(static_cast<Eigen::Index>(values.size()));
  for (size_t i = 0; i < values.size(); ++i) {
    all.y(static_cast<Eigen::Index>(i)) = values[i].value_or(0.0);
    all.lines.push_back(table.rows[i].line);
  }

  Sliced result;
  result.slice = subset(all, keep);
  std::vector<bool> full = keep;
  for (const std::string& name : covariates_of(design, table, response)) {
    const auto x = numbers(table, name);
    missing(name, present(x, is_number),
            "those rows are left out of the regressions and the analysis of covariance alone",
            full);
    Covariate covariate{name, Eigen::VectorXd(static_cast<Eigen::Index>(x.size()))};
    for (size_t i = 0; i < x.size(); ++i) {
      covariate.value(static_cast<Eigen::Index>(i)) = x[i].value_or(0.0);
    }
    all.covariates.push_back(std::move(covariate));
  }
  result.with_covariates = subset(all, full);
  return result;
}

/// Frontal and sagittal errors are analysed apart, as if uncorrelated [plaskos2002] 2.2.3: tested
/// on the residuals about exclusive means.
void report_correlation(const Table& table, const Design& design, StudyReport& report) {
  const std::string a = "varus_valgus_deg", b = "flexion_extension_deg";
  if (!contains(design.responses, a) || !contains(design.responses, b)) return;
  const auto va = numbers(table, a), vb = numbers(table, b);
  std::vector<Factor> parts;
  for (const std::string& name : design.exclusive_means) parts.push_back(factor(table, name));
  const Factor cell = combined(parts, static_cast<int>(table.rows.size()));
  std::vector<double> sum_a(cell.levels.size(), 0.0), sum_b(sum_a), count(sum_a);
  for (size_t i = 0; i < va.size(); ++i) {
    if (!va[i] || !vb[i]) continue;
    sum_a[cell.level[i]] += *va[i];
    sum_b[cell.level[i]] += *vb[i];
    count[cell.level[i]] += 1.0;
  }
  double aa = 0.0, bb = 0.0, ab = 0.0, df = 0.0;
  for (const double n : count) df += std::max(0.0, n - 1.0);
  for (size_t i = 0; i < va.size(); ++i) {
    if (!va[i] || !vb[i]) continue;
    const int k = cell.level[i];
    const double ra = *va[i] - sum_a[k] / count[k], rb = *vb[i] - sum_b[k] / count[k];
    aa += ra * ra;
    bb += rb * rb;
    ab += ra * rb;
  }
  if (df < 4.0 || !(aa > 0.0) || !(bb > 0.0)) return;
  const double r = ab / std::sqrt(aa * bb);
  if (std::abs(r) >= 1.0) return;
  const double t = r * std::sqrt((df - 1.0) / (1.0 - r * r));
  const double p = numerics::student_t_two_sided_p(t, df - 1.0);
  const bool holds = p >= design.alpha;
  report.assumptions.push_back(
      {"uncorrelated errors", a, a + " and " + b, holds, r, p,
       holds ? ""
             : "each error's own results stand; a joint statement on both must use the "
               "correlation"});
}

void add_removal_rate(Table& table) {
  const std::string rate = "removal_rate_mm3_per_s";
  const auto volume = table.find("removed_volume_mm3"), time = table.find("time_s");
  if (!volume || !time || table.find(rate)) return;
  const auto v = numbers(table, "removed_volume_mm3"), t = numbers(table, "time_s");
  table.columns.push_back(rate);
  for (size_t i = 0; i < table.rows.size(); ++i) {
    const bool known = v[i] && t[i] && *t[i] > 0.0;
    table.rows[i].cells.push_back(known ? fmt::format("{}", *v[i] / *t[i]) : std::string());
  }
}

}  // namespace

Design complete_design(const Design& given, const Table& table, std::vector<Finding>& findings) {
  Design design = given;
  if (design.responses.empty()) {
    for (const char* name :
         {"varus_valgus_deg", "flexion_extension_deg", "time_s", "removal_rate_mm3_per_s"}) {
      if (table.find(name)) design.responses.push_back(name);
    }
  }
  const auto varies = [&](const std::string& name) {
    return table.find(name) && factor(table, name).levels.size() >= 2;
  };
  const bool silent = design.between.empty() && design.within.empty() && design.blocks.empty();
  if (silent && table.find(design.subject)) {
    for (const char* name : {"group", "technique", "guide"}) {
      if (!varies(name)) continue;
      const bool inside = varies_inside(factor(table, name), factor(table, design.subject));
      (inside ? design.within : design.between).push_back(name);
    }
  } else if (silent) {
    for (const char* name : {"group", "technique", "guide"}) {
      if (varies(name)) design.between.push_back(name);
    }
  }
  require_columns(design, table);
  settle_sides(design, table, findings);
  const auto drop_constant = [&](std::vector<std::string>& names) {
    std::erase_if(names, [&](const std::string& name) {
      if (varies(name)) return false;
      findings.push_back({fmt::format("{} has one level only", name),
                          "it is left out; nothing can be compared by it",
                          {}});
      return true;
    });
  };
  drop_constant(design.between);
  drop_constant(design.within);
  if (table.find("specimen") && !contains(design.random, "specimen") &&
      design.subject != "specimen") {
    design.random.push_back("specimen");
  }
  if (design.exclusive_means.empty()) {
    std::vector<std::string> names{design.subject};
    names.insert(names.end(), design.between.begin(), design.between.end());
    names.insert(names.end(), design.within.begin(), design.within.end());
    names.insert(names.end(), {"technique", "guide", "cut"});
    for (const std::string& name : names) {
      if (table.find(name) && !contains(design.exclusive_means, name)) {
        design.exclusive_means.push_back(name);
      }
    }
  }
  return design;
}

StudyReport analyse_study(Table table, const Design& given, const Progress& progress) {
  StudyReport report;
  if (table.rows.empty()) {
    throw InvalidInput(Fault{"table", "no rows", "needs a row for each cut", "", table.source});
  }
  report.findings = settle_duplicates(table);
  add_removal_rate(table);
  report.design = complete_design(given, table, report.findings);
  const Design& design = report.design;
  report.rows = static_cast<int>(table.rows.size());
  for (auto& finding : suspicious_units(table, design.responses, design.subject)) {
    report.findings.push_back(std::move(finding));
  }
  for (auto& finding : suspicious_sides(table, design.responses)) {
    report.findings.push_back(std::move(finding));
  }
  for (size_t r = 0; r < design.responses.size(); ++r) {
    const std::string& response = design.responses[r];
    if (!go_on(progress, "study",
               static_cast<double>(r) / static_cast<double>(design.responses.size()))) {
      break;
    }
    const auto [slice, with_covariates] = make_slices(design, table, response, report.findings);
    if (slice.y.size() < 2) {
      report.findings.push_back({fmt::format("{}: fewer than two complete rows", response),
                                 "nothing is computed for it",
                                 {}});
      continue;
    }
    const std::optional<bool> normal = report_normality(slice, report);
    const bool covariance_only = !design.covariates.empty() && !slice.subject;
    if (!covariance_only) report_anova(slice, normal, report);
    report_mixed_model(slice, report);
    if (!with_covariates.covariates.empty()) {
      report_covariance(with_covariates, report);
      report_mixed_model(with_covariates, report);
      report_regressions(with_covariates, report);
    }
    report_contributions(slice, with_covariates, report);
    report_groups(slice, report);
    report_forecasts(slice, report);
    report_comparisons(slice, report);
  }
  report_correlation(table, design, report);
  return report;
}

}  // namespace osteomill::study
