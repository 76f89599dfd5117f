// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/fit_case.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

#include "osteomill/base/units.hpp"
#include "osteomill/io/case_file.hpp"
#include "osteomill/io/csv_file.hpp"
#include "osteomill/io/section.hpp"

namespace osteomill::io {
namespace {

using cutting::OrthogonalCut;

struct Tables {
  std::filesystem::path file;
  std::optional<double> speed;
  bool averaged = true;
};

void bind(Section& section, FitCase& fit, Tables& tables) {
  section.table("cuts", "orthogonal cuts", Need::required, [&](Section& s) {
    s.file("file", tables.file,
           "table: chip_thickness_um, tangential_n_per_mm, radial_n_per_mm; also "
           "lateral_n_per_mm, direction_deg (0 | 90 to the fibres), speed_m_per_s");
    s.number("speed_m_per_s", tables.speed, {1.0, "m/s"}, positive(),
             "fit the cuts of this speed; absent: of all speeds");
    bool single = false;
    s.flag("single_cuts", single,
           "fit every cut by itself; otherwise the mean of each chip thickness");
    tables.averaged = !single;
  });
  section.table("fit", "the law to fit", Need::optional, [&](Section& s) {
    s.choice<FitForm>(
        "law", fit.form,
        {{"auto", FitForm::automatic}, {"log", FitForm::log}, {"power", FitForm::power}},
        "auto: the form that Akaike's criterion prefers over all components", Need::optional);
    s.number("rake_deg", fit.rake_angle, {units::deg, "deg"}, between(-60.0, 60.0),
             "rake angle of the edge");
    s.number("inclination_deg", fit.inclination, {units::deg, "deg"}, between(-75.0, 75.0),
             "inclination of the edge; 0: orthogonal", Need::optional);
  });
  fit.provenance.obtained = bone::Obtained::measured;
  section.table("provenance", "where the cuts come from", Need::optional, [&](Section& s) {
    using bone::Obtained;
    s.choice<Obtained>("obtained", fit.provenance.obtained,
                       {{"measured", Obtained::measured},
                        {"digitised", Obtained::digitised},
                        {"assumed", Obtained::assumed}},
                       "how the cuts were obtained", Need::optional);
    s.text("source", fit.provenance.source, "source", Need::optional);
    s.text("specimen", fit.provenance.specimen, "specimen", Need::optional);
    s.text("condition", fit.provenance.condition, "condition", Need::optional);
  });
}

/// One row of the table.
struct Row {
  double h = 0.0;
  std::optional<int> direction;
  std::optional<double> speed;
  std::array<std::optional<double>, 3> force;
};

constexpr std::array<const char*, 3> kComponents = {"tangential", "radial", "lateral"};

class Reader {
 public:
  explicit Reader(const CsvFile& table) : table_(table) {
    for (std::size_t i = 0; i < table.columns.size(); ++i) column(table.columns[i], i);
    if (h_ < 0) missing("chip_thickness_um");
    if (force_[0] < 0 && force_[1] < 0 && force_[2] < 0) missing("tangential_n_per_mm");
    if (table.rows.empty()) faults_.push_back({"cuts", "", "holds no cut", "", table.name});
  }

  std::vector<Row> rows() {
    std::vector<Row> rows;
    for (const CsvFile::Row& line : table_.rows) {
      Row row;
      if (h_ >= 0) row.h = number(line, h_, true).value_or(0.0) * units::um;
      row.direction = direction(line);
      if (speed_ >= 0) row.speed = number(line, speed_, true);
      for (std::size_t i = 0; i < force_.size(); ++i) {
        const auto force = force_[i] < 0 ? std::nullopt : number(line, force_[i], false);
        if (force) row.force[i] = *force * units::n_per_mm;
      }
      rows.push_back(row);
    }
    if (!faults_.empty()) throw InvalidInput(faults_);
    return rows;
  }

 private:
  void column(const std::string& name, std::size_t at) {
    const int place = static_cast<int>(at);
    if (name == "chip_thickness_um") return void(h_ = place);
    if (name == "direction_deg") return void(direction_ = place);
    if (name == "speed_m_per_s") return void(speed_ = place);
    for (std::size_t i = 0; i < kComponents.size(); ++i) {
      if (name == std::string(kComponents[i]) + "_n_per_mm") return void(force_[i] = place);
    }
    faults_.push_back({"cuts", '"' + name + '"', "is no column of a table of cuts",
                       "known: chip_thickness_um, tangential_n_per_mm, radial_n_per_mm, "
                       "lateral_n_per_mm, direction_deg, speed_m_per_s",
                       table_.name});
  }
  void missing(const char* name) {
    faults_.push_back({name, "", "is missing", "name the column in the heading", table_.name});
  }
  std::string place(const CsvFile::Row& line) const {
    return fmt::format("{}:{}", table_.name, line.line);
  }
  /// A number > 0; an empty cell is none where it may be.
  std::optional<double> number(const CsvFile::Row& line, int at, bool needed) {
    const auto i = static_cast<std::size_t>(at);
    const std::string& cell = line.cells[i];
    if (cell.empty() && !needed) return {};
    double value = 0.0;
    const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
    if (error == std::errc{} && end == cell.data() + cell.size() && std::isfinite(value) &&
        value > 0.0) {
      return value;
    }
    faults_.push_back({table_.columns[i], cell, "must be a number > 0", "", place(line)});
    return {};
  }
  std::optional<int> direction(const CsvFile::Row& line) {
    if (direction_ < 0) return {};
    const std::string& cell = line.cells[static_cast<std::size_t>(direction_)];
    if (cell == "0" || cell == "90") return cell == "0" ? 0 : 90;
    faults_.push_back({"direction_deg", cell, "must be 0 (along the fibres) or 90 (across)",
                       "leave the column out where directions are not told apart", place(line)});
    return {};
  }

  const CsvFile& table_;
  int h_ = -1, direction_ = -1, speed_ = -1;
  std::array<int, 3> force_{-1, -1, -1};
  std::vector<Fault> faults_;
};

bool same(double one, double other) { return std::abs(one - other) <= 1e-9 * std::abs(other); }

std::vector<double> speeds_of(const std::vector<Row>& rows) {
  std::vector<double> speeds;
  for (const Row& row : rows) {
    if (row.speed) speeds.push_back(*row.speed);
  }
  std::sort(speeds.begin(), speeds.end());
  speeds.erase(std::unique(speeds.begin(), speeds.end(), same), speeds.end());
  return speeds;
}

FitSeries series_of(const std::vector<Row>& rows, std::size_t component,
                    std::optional<int> direction, const FitCase& fit, bool averaged) {
  FitSeries series{
      .component = kComponents[component], .direction = direction, .cuts = {}, .speed_effects = {}};
  std::vector<OrthogonalCut> slow, fast;
  for (const Row& row : rows) {
    if (row.direction != direction || !row.force[component]) continue;
    const OrthogonalCut cut{row.h, *row.force[component]};
    const bool fitted = fit.fitted_speeds.empty() ||
                        std::any_of(fit.fitted_speeds.begin(), fit.fitted_speeds.end(),
                                    [&](double speed) { return same(*row.speed, speed); });
    if (fitted) series.cuts.push_back(cut);
    if (fit.speeds.size() < 2) continue;
    if (same(*row.speed, fit.speeds.front())) slow.push_back(cut);
    if (same(*row.speed, fit.speeds.back())) fast.push_back(cut);
  }
  if (averaged) series.cuts = cutting::averaged(series.cuts);
  series.speed_effects = cutting::speed_effects(slow, fast);
  return series;
}

std::string quoted(const std::string& text) { return nlohmann::json(text).dump(); }

std::string law_text(const FittedSeries& one, bool log_laws) {
  if (log_laws) {
    return fmt::format("{{ k1 = {:.6g}, k2 = {:.6g}, k3 = {:.6g} }}", one.log.law.k1,
                       one.log.law.k2, one.log.law.k3);
  }
  return fmt::format("{{ k = {:.6g}, n = {:.6g}, edge = {:.6g} }}",
                     one.power.law.at_1_mm / units::n_per_mm, one.power.law.exponent,
                     one.power.law.edge / units::n_per_mm);
}

}  // namespace

void bind_fit(Section& section) {
  FitCase fit;
  Tables tables;
  bind(section, fit, tables);
}

FitCase read_fit_case(const CaseRun& run) {
  FitCase fit;
  Tables tables;
  fit.expanded = Section::read(run, [&](Section& section) { bind(section, fit, tables); });
  const CsvFile table = read_csv(tables.file);
  const std::vector<Row> rows = Reader(table).rows();
  fit.speeds = speeds_of(rows);
  fit.fitted_speeds = fit.speeds;
  if (tables.speed) {
    if (std::none_of(fit.speeds.begin(), fit.speeds.end(),
                     [&](double speed) { return same(speed, *tables.speed); })) {
      throw InvalidInput(Fault{"cuts.speed_m_per_s", fmt::format("{:g} m/s", *tables.speed),
                               "no cut of the table has this speed",
                               fmt::format("the table has {} speeds", fit.speeds.size())});
    }
    fit.fitted_speeds = {*tables.speed};
  }
  for (std::size_t component = 0; component < kComponents.size(); ++component) {
    for (const std::optional<int> direction : {std::optional<int>{}, {0}, {90}}) {
      FitSeries series = series_of(rows, component, direction, fit, tables.averaged);
      if (!series.cuts.empty()) fit.series.push_back(std::move(series));
    }
  }
  return fit;
}

std::string bone_entry(const FitCase& fit, const std::vector<FittedSeries>& fitted, bool log_laws) {
  double low = std::numeric_limits<double>::infinity(), high = 0.0;
  std::string laws, quality;
  for (const char* component : kComponents) {
    std::string lines;
    const auto directions =
        std::count_if(fitted.begin(), fitted.end(), [&](const FittedSeries& one) {
          return one.series.component == component && one.series.direction;
        });
    for (const FittedSeries& one : fitted) {
      if (one.series.component != component) continue;
      // Cuts in one direction only have to stand for every direction.
      const std::string key = one.series.direction && directions == 2
                                  ? fmt::format("at_{}_deg", *one.series.direction)
                                  : "any_deg";
      lines += fmt::format("{} = {}\n", key, law_text(one, log_laws));
      low = std::min(low, one.log.law.range.low);
      high = std::max(high, one.log.law.range.high);
      const cutting::FitQuality& how = log_laws ? one.log.quality : one.power.quality;
      quality += fmt::format(
          "{}{} {} {:.2g}", quality.empty() ? "" : ", ", component,
          one.series.direction.value_or(-1) < 0 ? "any" : fmt::format("{}", *one.series.direction),
          how.rms / units::n_per_mm);
    }
    if (lines.empty()) continue;
    laws += fmt::format("\n[{}]\n{}", component, lines);
    if (component == std::string("lateral") && fit.inclination != 0.0) {
      laws += fmt::format("inclination_deg = {:g}\n", fit.inclination / units::deg);
    }
  }
  std::string entry = "# F in N per mm of edge. Fitted to orthogonal cuts by osteomill fit.\n";
  entry += fmt::format("law = \"{}\"\norientation = \"hankinson\"\nrange_um = [{:g}, {:g}]\n",
                       log_laws ? "log" : "power", low / units::um, high / units::um);
  if (fit.rake_angle) entry += fmt::format("rake_deg = {:g}\n", *fit.rake_angle / units::deg);
  if (fit.fitted_speeds.size() > 1) {
    entry += fmt::format("speed_range_m_per_s = [{:g}, {:g}]\n", fit.fitted_speeds.front(),
                         fit.fitted_speeds.back());
  }
  entry += laws;
  entry +=
      fmt::format("\n[provenance]\nobtained = \"{}\"\n", bone::name_of(fit.provenance.obtained));
  const auto line = [&](const char* key, const std::string& text) {
    if (!text.empty()) entry += fmt::format("{} = {}\n", key, quoted(text));
  };
  line("source", fit.provenance.source);
  line("specimen", fit.provenance.specimen);
  line("condition", fit.provenance.condition);
  line("uncertainty", "residual rms, N/mm: " + quality);
  return entry;
}

}  // namespace osteomill::io
