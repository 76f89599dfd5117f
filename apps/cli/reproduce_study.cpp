// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <cmath>

#include "osteomill/io/study_case.hpp"
#include "osteomill/study/intervals.hpp"
#include "reproduce.hpp"

namespace osteomill::cli {
namespace {

using study::Interval;

const std::string kSource = "plaskos2002";

/// Cells of one row by column.
class Row {
 public:
  Row(const study::Table& table, size_t row) : table_(table), cells_(table.rows.at(row).cells) {}
  const std::string& text(const char* column) const { return cells_.at(*table_.find(column)); }
  double number(const char* column) const { return std::stod(text(column)); }

 private:
  const study::Table& table_;
  const std::vector<std::string>& cells_;
};

std::string range(const std::vector<int>& all) {
  if (all.empty()) return "none";
  if (all.size() == 1) return fmt::format("{}", all.front());
  return fmt::format("{} to {}", all.front(), all.back());
}

void sd_intervals(std::vector<Reproduced>& list) {
  const study::Table table =
      io::read_study_table(reproduce_directory() / "plaskos2002/sd_intervals.csv");
  for (size_t r = 0; r < table.rows.size(); ++r) {
    const Row row(table, r);
    const study::PrintedInterval printed{
        .sd = row.number("sd_deg"),
        .sd_half_digit = 0.5 * std::pow(10.0, -row.number("sd_digits")),
        .interval = {row.number("low_deg"), row.number("high_deg")},
        .half_digit = 0.005};
    const int cuts = static_cast<int>(row.number("cuts"));
    const double df = cuts - row.number("operators");
    const auto at95 = study::degrees_of_freedom_implied(printed, 0.95);
    const auto at90 = study::degrees_of_freedom_implied(printed, 0.90);
    const Interval ours = study::sd_interval(printed.sd, df);
    Reproduced one{
        kSource,
        "SD of " + row.text("group"),
        fmt::format("{} deg [{}-{}], {} cuts", row.text("sd_deg"), row.text("low_deg"),
                    row.text("high_deg"), cuts),
        "the 95 % chi-squared interval on some degrees of freedom below the cuts rounds to it",
        fmt::format("[{:.2f}-{:.2f}] on {:g} (cuts less operators); the printed ends ask for {}",
                    ours.low, ours.high, df, range(at95)),
        !at95.empty() && at95.front() < cuts};
    if (!one.pass) {
      const bool fits = !at90.empty() && at90.front() < cuts;
      one.reason =
          fmt::format("as a 90 % interval (5 % on each side) it asks for {}, {}", range(at90),
                      fits ? "which the cuts can give" : "still more than the cuts can give");
    }
    list.push_back(std::move(one));
  }
}

void r_squared_intervals(std::vector<Reproduced>& list) {
  const study::Table table =
      io::read_study_table(reproduce_directory() / "plaskos2002/r_squared_intervals.csv");
  for (size_t i = 0; i < table.rows.size(); ++i) {
    const Row row(table, i);
    const double r = std::sqrt(row.number("r_squared_percent") / 100.0);
    const int cuts = static_cast<int>(row.number("cuts"));
    const Interval ours = study::r_squared_interval(r, cuts);
    const double half = 1.96 / (cuts - 3.0), z = std::atanh(r);
    const double low = row.number("low_percent"), high = row.number("high_percent");
    const bool pass =
        std::abs(100.0 * ours.low - low) < 1.0 && std::abs(100.0 * ours.high - high) < 1.0;
    list.push_back(
        {kSource, "r2 of guide movement, " + row.text("group"),
         fmt::format("{} % [{}-{}]", row.text("r_squared_percent"), row.text("low_percent"),
                     row.text("high_percent")),
         "Fisher's interval with the variance 1/(n-3) that 2.2.3 states, within 1 %",
         fmt::format("[{:.1f}-{:.1f}] for {} cuts", 100.0 * ours.low, 100.0 * ours.high, cuts),
         pass,
         pass ? ""
              : fmt::format(
                    "the variance was taken for the standard deviation: z +- 1.96/(n-3) gives "
                    "[{:.1f}-{:.1f}]",
                    100.0 * std::pow(std::tanh(z - half), 2.0),
                    100.0 * std::pow(std::tanh(z + half), 2.0))});
  }
}

/// sqrt(2) times the upper end of the printed interval, "on the order of".
void alignments(std::vector<Reproduced>& list) {
  struct Statement {
    const char* what;
    double upper, printed;
  };
  for (const Statement& s :
       {Statement{"expert sawing V/V (2.4)", 0.55, 0.8},
        Statement{"trainee sawing V/V (2.4)", 0.97, 1.5}, Statement{"milling V/V (3.4)", 0.37, 0.6},
        Statement{"milling F/E (3.4)", 0.81, 1.2}}) {
    const double ours = study::combined_sd(s.upper);
    const bool pass = std::abs(ours - s.printed) <= 0.1;
    list.push_back({kSource, std::string("alignment of two cuts, ") + s.what,
                    fmt::format("~{:g} deg", s.printed),
                    "sqrt(2) times the printed upper end, within 0.1 deg",
                    fmt::format("{:.2f} deg", ours), pass, pass ? "" : "the thesis rounds up"});
  }
}

/// Mean volume over mean time, against the mean of the cuts' own rates.
void removal_rates(std::vector<Reproduced>& list) {
  struct Technique {
    const char* name;
    double volume, time, time_sd, rate;
  };
  for (const Technique& t :
       {Technique{"milling", 10735, 215, 50, 55}, Technique{"sawing", 4370, 100, 30, 49}}) {
    // To second order the mean of 1/t is (1 + (sd/mean)^2) / mean.
    const double ours = t.volume / t.time * (1.0 + std::pow(t.time_sd / t.time, 2.0));
    list.push_back({kSource, std::string("removal rate of novices, ") + t.name + " (3.3.6)",
                    fmt::format("{:g} mm3/s", t.rate),
                    "mean volume times the mean of 1/time, within 10 %",
                    fmt::format("{:.1f} mm3/s", ours), std::abs(ours / t.rate - 1.0) <= 0.1, ""});
  }
}

}  // namespace

void reproduce_cutting_study(std::vector<Reproduced>& list) {
  sd_intervals(list);
  r_squared_intervals(list);
  alignments(list);
  removal_rates(list);
}

}  // namespace osteomill::cli
