// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>

#include "osteomill/accuracy/choose_conditions.hpp"
#include "osteomill/accuracy/error_budget.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/io/accuracy_case.hpp"
#include "osteomill/io/case_file.hpp"
#include "osteomill/io/csv_file.hpp"
#include "osteomill/vibration/exact_beam.hpp"
#include "reproduce.hpp"

namespace osteomill::cli {
namespace {

using units::mm;

vibration::Beam shaft(double free_length_mm) {
  return {
      .segments = {{.length = 100 * mm, .diameter = 3.1 * mm}},
      .supports = {{.position = 0.0, .type = vibration::SupportType::clamp},
                   {.position = (100 - free_length_mm) * mm, .type = vibration::SupportType::pin}},
      .youngs_modulus = 197 * units::gpa,
      .density = 7850.0};
}

void frequencies(std::vector<Reproduced>& list) {
  const struct {
    double free_length;
    double printed[2];
  } known[] = {{34.0, {1140.0, 3000.0}}, {56.0, {560.0, 3800.0}}};
  for (const auto& k : known) {
    const auto f = vibration::exact_natural_frequencies(shaft(k.free_length), 2);
    for (int mode = 0; mode < 2; ++mode) {
      const double ours = f[static_cast<std::size_t>(mode)];
      list.push_back(
          {"plaskos2002",
           fmt::format("Appendix A, natural frequency {}, {:g} mm free", mode + 1, k.free_length),
           fmt::format("~{:g} Hz", k.printed[mode]), "within 5 %", fmt::format("{:.1f} Hz", ours),
           std::abs(ours / k.printed[mode] - 1.0) < 0.05,
           "does not follow from the thesis' own inputs (d 3.1, L 100 mm, E 197 GPa, 7850 kg/m3): "
           "its 5 x 5 determinant has our roots; 3 mm less free length gives the printed first "
           "frequencies, but second ones of 2733 and 3691 Hz"});
    }
  }
}

/// The cases of figures 4.20 and 4.21.
io::DeflectCase deflection_case(int flutes, bool extended, bool deep) {
  std::vector<std::string> overrides = {fmt::format("cutter.flutes={}", flutes)};
  if (extended) {
    overrides.insert(overrides.end(), {"tool.length_mm=55", "tool.effective_diameter_mm=2.76"});
  }
  if (!deep) {
    overrides.insert(overrides.end(), {"cut.feed_rate_mm_per_min=193.55", "cut.axial_depth_mm=5"});
  }
  return io::read_deflect_case(
      io::read_case(reproduce_directory() / "plaskos2002" / "m10_deflection.toml", overrides)
          .at(0));
}

accuracy::ToolDeflection bent(int flutes, bool extended, bool deep) {
  const io::DeflectCase one = deflection_case(flutes, extended, deep);
  return accuracy::tool_deflection(*one.tool, one.cutter, one.bone.law, one.condition,
                                   one.immersion);
}

void deflections(std::vector<Reproduced>& list) {
  const char* law = "with power laws that were chosen to fit these deflections (assumed)";
  const struct {
    int flutes;
    bool extended, deep;
    double printed;
  } known[] = {{2, false, true, 0.9}, {2, false, false, 0.7}, {2, true, true, 4.0},
               {2, true, false, 2.0}, {4, false, true, 0.5},  {4, false, false, 0.3},
               {4, true, true, 2.0},  {4, true, false, 1.0}};
  for (const auto& k : known) {
    const double ours = bent(k.flutes, k.extended, k.deep).total_tip / mm;
    // Quoted with one digit: half a unit of it, at least 10 %.
    const double tolerance = std::max(k.printed >= 1.0 ? 0.5 : 0.05, 0.1 * k.printed);
    list.push_back(
        {"plaskos2002",
         fmt::format("figure 4.2{}: total tip deflection, {} flutes, {} mm, {} mm deep",
                     k.flutes == 2 ? 0 : 1, k.flutes, k.extended ? 55 : 35, k.deep ? 35 : 5),
         fmt::format("~{:g} mm", k.printed), fmt::format("+- {:g} mm", tolerance),
         fmt::format("{:.2f} mm", ours), std::abs(ours - k.printed) <= tolerance, law});
  }
  const double two = bent(2, false, true).tip_at_surface / mm;
  list.push_back({"plaskos2002", "4.4.3: tip deflection at 180 deg, two straight flutes", "0",
                  "exactly", fmt::format("{:g} mm", two), two == 0.0});
  for (const bool extended : {false, true}) {
    for (const bool deep : {true, false}) {
      const double printed = extended ? 0.5 : 0.2;
      const double ours = bent(4, extended, deep).tip_at_surface / mm;
      list.push_back(
          {"plaskos2002",
           fmt::format("4.4.3: tip deflection at 180 deg, four flutes, {} mm, {} mm deep",
                       extended ? 55 : 35, deep ? 35 : 5),
           fmt::format("~{:g} mm", printed), "+- 0.05 mm", fmt::format("{:.2f} mm", ours),
           std::abs(ours - printed) <= 0.05,
           deep ? "0.2 mm at 35 mm and 0.5 mm at 55 mm cannot both hold for one deep cut: the two "
                  "tools' influence functions differ by another ratio"
                : law});
    }
  }
  const double halved = 1.0 - bent(2, true, false).total_tip / bent(2, true, true).total_tip;
  list.push_back({"plaskos2002", "4.6: less deflection at equal time", "~50 %", "45 ... 55 %",
                  fmt::format("{:.0f} %", 100.0 * halved), halved > 0.45 && halved < 0.55, law});
  const double thicker = 1.0 - std::pow(1.25, -4.0);
  list.push_back({"plaskos2002", "4.5.2: less deflection of a 25 % thicker tool", "over 60 %",
                  "> 60 %", fmt::format("{:.1f} %", 100.0 * thicker), thicker > 0.6,
                  "1 - 1.25^-4 is 59.0 %"});
}

/// Table 4.1: the tool's stiffness, printed as the diameter of a plain shaft that bends alike.
void effective_diameter(std::vector<Reproduced>& list) {
  const double e = 197 * units::gpa, fluted = 2.54 * mm, length = 55 * mm;
  const vibration::Beam stepped{
      .segments = {{.length = 20 * mm, .diameter = 3.1 * mm},
                   {.length = 35 * mm,
                    .diameter = 3.1 * mm,
                    .effective_diameter_factor = fluted / (3.1 * mm)}},
      .supports = {{.position = 0.0, .type = vibration::SupportType::clamp}},
      .youngs_modulus = e,
      .density = 7850.0};
  const auto stiffness = [&](double diameter) {
    return 3.0 * e * std::numbers::pi * std::pow(diameter, 4.0) / 64.0 / std::pow(length, 3.0);
  };
  const double ours = 1.0 / vibration::exact_tip_receptance(stepped, 0.0);
  const double diameter = std::pow(ours / stiffness(1.0), 0.25);
  list.push_back(
      {"plaskos2002", "table 4.1: stiffness of the mill, 55 mm free",
       fmt::format("effective diameter 2.76 mm, {:.1f} N/mm", stiffness(2.76 * mm) * mm),
       "exact beam of 20 mm shaft and 35 mm flutes with the 2.54 mm of table 4.1, within 10 %",
       fmt::format("{:.2f} mm, {:.1f} N/mm", diameter / mm, ours * mm),
       std::abs(ours / stiffness(2.76 * mm) - 1.0) <= 0.1,
       "the 20 mm between the two lengths are plain shaft, which bends less than the printed 2.76 "
       "mm "
       "says; a clamp that turned under the load would explain it, part of it hidden in the 2.54 "
       "mm"});
}

/// Registration and sawing of one leg, [plaskos2002] 1.1.4 and 2.4.
void saw_share(std::vector<Reproduced>& list) {
  const auto share = [](double registration, double cut) {
    return accuracy::propagate({{.name = "registration", .spread = registration},
                                {.name = "sawing", .spread = cut, .times = 2}})
        .shares[1]
        .share_of_variance;
  };
  const double ours = share(0.5, 0.8);
  list.push_back(
      {"plaskos2002", "1.1.4: share of cutting in the frontal variance", "over 90 %", "> 90 %",
       fmt::format("{:.0f} %", 100.0 * ours), ours > 0.9,
       fmt::format("of a trainee's 0.8 deg SD a cut beside a registration of 0.5 deg SD, the bound "
                   "that is printed; with 0.35 deg it is {:.0f} %. The SD of the pilot behind the "
                   "statement is not printed",
                   100.0 * share(0.35, 0.8))});
}

/// What the regression lines of table 5.2 say together.
struct FixationLines {
  std::string name;
  std::array<double, 4> slope{}, offset{};  ///< x, y, z, magnitude; mm/N, mm
  double magnitude(double load) const {
    return std::hypot(slope[0] * load + offset[0], slope[1] * load + offset[1],
                      slope[2] * load + offset[2]);
  }
};

std::vector<FixationLines> fixation_lines() {
  const io::CsvFile table = io::read_csv(reproduce_directory() / "plaskos2006/table_5_2.csv");
  std::vector<FixationLines> list;
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    const auto& cells = table.rows[i].cells;
    if (i % 4 == 0)
      list.push_back({.name = cells[0] + ", " + cells[1] + (cells[1] == "1" ? " day" : " days")});
    list.back().slope[i % 4] = std::stod(cells[3]);
    list.back().offset[i % 4] = std::stod(cells[4]);
  }
  return list;
}

void fixation(std::vector<Reproduced>& list) {
  const std::vector<FixationLines> tests = fixation_lines();
  for (const FixationLines& test : tests) {
    const double ours = 1.0 / std::hypot(test.slope[0], test.slope[1], test.slope[2]),
                 printed = 1.0 / test.slope[3];
    const bool pass = std::abs(ours / printed - 1.0) <= 0.1;
    list.push_back({"plaskos2006", "table 5.2: stiffness of the fixation, " + test.name,
                    fmt::format("{:.0f} N/mm (slope of dP {:g} mm/N)", printed, test.slope[3]),
                    "one over the vector sum of the printed x, y, z slopes, within 10 %",
                    fmt::format("{:.0f} N/mm", ours), pass,
                    pass ? ""
                         : "a magnitude cannot grow slower than its parts: the line printed "
                           "for dP does not go with those for x, y and z"});
  }
  const auto across = [&](double load) {
    std::vector<double> all;
    for (const FixationLines& test : tests) all.push_back(test.magnitude(load));
    std::sort(all.begin(), all.end());
    return all;
  };
  const struct {
    double load, low, high;
  } ranges[] = {{100.0, 0.6, 1.5}, {200.0, 1.2, 3.0}};
  for (const auto& range : ranges) {
    const std::vector<double> all = across(range.load);
    list.push_back(
        {"plaskos2006", fmt::format("5.3.1.3: displacement of the fixation at {:g} N", range.load),
         fmt::format("~{:.1f}-{:.1f} mm", range.low, range.high),
         "range of the five specimens from their lines, each end within 0.1 mm",
         fmt::format("{:.2f}-{:.2f} mm", all.front(), all.back()),
         std::abs(all.front() - range.low) <= 0.1 && std::abs(all.back() - range.high) <= 0.1,
         fmt::format("the lines of the one-day specimen give the lower end; from the "
                     "two-day ones on it is {:.2f} mm",
                     all[1])});
  }
  const std::vector<double> all = across(50.0);
  const double mean =
      std::accumulate(all.begin(), all.end(), 0.0) / static_cast<double>(all.size());
  list.push_back({"plaskos2006", "5.3.1.4: displacement of the fixation in surgery, 50 N",
                  "~0.5 mm", "mean of the five specimens from their lines, +- 0.1 mm",
                  fmt::format("{:.2f} mm", mean), std::abs(mean - 0.5) <= 0.1});
}

}  // namespace

void reproduce_plaskos2002_accuracy(std::vector<Reproduced>& list) {
  frequencies(list);
  effective_diameter(list);
  deflections(list);
  saw_share(list);
}

void reproduce_plaskos2006_accuracy(std::vector<Reproduced>& list) {
  const auto stiffness = [](double extension) {
    const vibration::Beam beam{
        .segments = {{.length = extension * mm,
                      .diameter = 3.17 * mm,
                      .tube_outer_diameter = 6 * mm,
                      .tube_inner_diameter = 4 * mm}},
        .supports = {{.position = 0.0, .type = vibration::SupportType::clamp}},
        .youngs_modulus = 197 * units::gpa,
        .density = 7850.0};
    return mm / vibration::exact_tip_receptance(beam, 0.0);
  };
  const double force = 0.5 * stiffness(90.0);
  list.push_back(
      {"plaskos2006", "5.5.3: force for 0.5 mm at 90 mm", "22 N", "to 1 N",
       fmt::format("{:.1f} N ({:.1f} N/mm: exact beam of shaft and tube)", force, stiffness(90.0)),
       std::abs(force - 22.0) <= 1.0});
  fixation(list);
  const double whole = accuracy::allowed_deviation(3.0, 0.95) / std::numbers::sqrt2;
  const double bone = accuracy::allowed_deviation(1.5, 0.95) / std::numbers::sqrt2;
  list.push_back(
      {"plaskos2006", "4.2.1: SD that each of two bones may have", "~1 deg", "+- 0.1 deg",
       fmt::format("{:.2f} deg for legs within +- 3 deg", whole), std::abs(whole - 1.0) <= 0.1,
       fmt::format("a window 3 deg wide, which the margins below go with, leaves {:.2f} deg",
                   bone)});
  const accuracy::ErrorSource registration{.name = "registration", .spread = 0.3};
  const double frontal =
      accuracy::remaining_deviation({registration, {.name = "saw", .spread = 0.3}}, bone);
  const double sagittal =
      accuracy::remaining_deviation({registration, {.name = "saw", .spread = 0.7}}, bone);
  list.push_back({"plaskos2006", "4.2.1: what is left for the guide, frontal", "~0.4 deg SD",
                  "+- 0.05 deg", fmt::format("{:.2f} deg", frontal),
                  std::abs(frontal - 0.4) <= 0.05,
                  "the thesis does not say how it splits the 3 deg window; ours: 95 % of the legs, "
                  "two bones"});
  list.push_back({"plaskos2006", "4.2.1: what is left for the guide, sagittal", "virtually no room",
                  "<= 0.1 deg", sagittal > 0.0 ? fmt::format("{:.2f} deg", sagittal) : "nothing",
                  sagittal <= 0.1});
}

}  // namespace osteomill::cli
