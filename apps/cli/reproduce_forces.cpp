// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <numeric>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/cutting/flutes.hpp"
#include "osteomill/cutting/law_fit.hpp"
#include "osteomill/cutting/prediction.hpp"
#include "osteomill/io/case_file.hpp"
#include "osteomill/io/force_case.hpp"
#include "reproduce.hpp"
#include "reproduce_rows.hpp"

namespace osteomill::cli {
namespace {

using geometry::Vector3;

/// A case of reproduce/ with keys of [cut] and [cutter] replaced.
io::ForceCase read(const std::string& name, const std::vector<std::string>& overrides = {}) {
  return io::read_force_case(io::read_case(reproduce_directory() / name, overrides).at(0));
}

Vector3 mean(const io::ForceCase& one) {
  return cutting::mean_load(one.cutter, one.bone.law, one.condition, one.immersion).force;
}

/// The same with another feed per tooth, m.
Vector3 mean(io::ForceCase one, double feed_per_tooth) {
  one.condition.feed_per_tooth = feed_per_tooth;
  return mean(one);
}

double peak(const io::ForceCase& one) {
  return cutting::predict(one.cutter, one.bone.law, one.condition, one.immersion).peak_resultant;
}

using Row = MeanRow;

/// A block of a table of means: rows of one tool and kind, our means of the same feeds.
struct Block {
  std::vector<Vector3> printed, ours, error;
};
Block block(const std::vector<Row>& rows, const std::string& tool, const std::string& kind,
            const std::string& case_name) {
  Block result;
  for (const Row& row : rows) {
    if (row.tool != tool || row.kind != kind) continue;
    result.printed.push_back(row.force);
    result.ours.push_back(
        mean(read(case_name, {fmt::format("cut.feed_rate_mm_per_min={}", row.feed_rate)})));
    result.error.push_back(result.ours.back() - result.printed.back());
  }
  return result;
}

Reproduced predicted_block(const std::string& entry, const Block& block, const char* reason) {
  const Vector3 share = 100.0 * rms(block.error).cwiseQuotient(rms(block.printed));
  return {.source = "[plaskos2006]",
          .entry = entry + ", predicted means",
          .printed = fmt::format("rms {} N (x / y / z)", three(rms(block.printed))),
          .criterion = "error of each component within 1 % rms",
          .ours = three(share) + " % rms",
          .pass = share.maxCoeff() < 1.0,
          .reason = reason};
}

void tables(std::vector<Reproduced>& list) {
  const auto half = read_mean_rows("plaskos2006/table_3_4.csv");
  const auto slot = read_mean_rows("plaskos2006/table_3_5.csv");
  const char* const fitted = "the law was reconstructed from these rows";
  struct Part {
    const char* entry;
    const std::vector<Row>& rows;
    const char* tool;
    const char* case_name;
  };
  const std::vector<Part> parts = {
      {"table 3.4, tool A", half, "a", "plaskos2006/table_3_4_tool_a.toml"},
      {"table 3.4, tool C", half, "c", "plaskos2006/table_3_4_tool_c.toml"},
      {"table 3.5, tool B", slot, "b", "plaskos2006/table_3_5_tool_b.toml"},
      {"table 3.5, tool C", slot, "c", "plaskos2006/table_3_5_tool_c.toml"}};
  std::vector<Vector3> thesis, ours;
  for (const Part& part : parts) {
    const Block predicted = block(part.rows, part.tool, "predicted", part.case_name);
    const Block measured = block(part.rows, part.tool, "measured", part.case_name);
    list.push_back(predicted_block(part.entry, predicted, fitted));
    for (std::size_t i = 0; i < measured.printed.size(); ++i) {
      thesis.push_back(predicted.printed[i] - measured.printed[i]);
      ours.push_back(measured.error[i]);
    }
  }
  list.push_back({.source = "[plaskos2006]",
                  .entry = "tables 3.4 and 3.5, measured means",
                  .printed = "its own predictions miss by " + three(rms(thesis)) + " N rms",
                  .criterion = "ours miss by no more than 1 % more",
                  .ours = three(rms(ours)) + " N rms",
                  .pass = (rms(ours).array() <= 1.01 * rms(thesis).array()).all(),
                  .reason = "orthogonal cutting predicts milling of this bone no better; a law "
                            "identified on milling itself does (osteomill identify)"});
}

/// The feed per tooth, m, where a mean component changes its sign; bisection.
double sign_change(const io::ForceCase& one, double low, double high) {
  const bool negative = mean(one, low).x() < 0.0;
  if (negative == (mean(one, high).x() < 0.0)) {
    throw NoSolution("the feed force does not change its sign in the range");
  }
  for (int i = 0; i < 50; ++i) {
    const double middle = 0.5 * (low + high);
    ((mean(one, middle).x() < 0.0) == negative ? low : high) = middle;
  }
  return low;
}

void trends(std::vector<Reproduced>& list) {
  const io::ForceCase half_c = read("plaskos2006/table_3_4_tool_c.toml");
  const double change = sign_change(half_c, 1e-6, 50e-6) / units::um;
  list.push_back({.source = "[plaskos2006]",
                  .entry = "3.4.3, feed force of half-immersion down milling changes its sign",
                  .printed = "tool C: predicted between 13 and 25 um a tooth, measured between 1 "
                             "and 13 um",
                  .criterion = "ours where the prediction's is",
                  .ours = fmt::format("{:.1f} um a tooth", change),
                  .pass = change > 13.0 && change < 25.0});

  const io::ForceCase slot_a = read("plaskos2006/tool_a_fast.toml");
  const double plateau = mean(slot_a, 50e-6).x() / mean(slot_a, 25e-6).x();
  const double normal = mean(slot_a, 50e-6).y() / mean(slot_a, 25e-6).y();
  list.push_back({.source = "[plaskos2006]",
                  .entry = "3.5.1, the feed force of a slot levels off, the normal force does not",
                  .printed = "tool A, 5000 rpm: no increase above 12-25 um a tooth",
                  .criterion = "from 25 to 50 um: feed force + < 10 %, normal force + > 25 %",
                  .ours = fmt::format("feed force {:+.1f} %, normal force {:+.1f} %",
                                      100.0 * (plateau - 1.0), 100.0 * (normal - 1.0)),
                  .pass = plateau < 1.10 && normal > 1.25});

  const auto rows = read_mean_rows("plaskos2006/table_3_5.csv");
  const Block two = block(rows, "b", "predicted", "plaskos2006/table_3_5_tool_b.toml");
  const Block four = block(rows, "c", "predicted", "plaskos2006/table_3_5_tool_c.toml");
  bool larger = true;
  double least_x = 1e9, least_y = 1e9;
  for (std::size_t i = 0; i < two.ours.size(); ++i) {
    least_x = std::min(least_x, four.ours[i].x() / two.ours[i].x());
    least_y = std::min(least_y, four.ours[i].y() / two.ours[i].y());
    larger = larger && least_x > least_y;
  }
  list.push_back(
      {.source = "[plaskos2006]",
       .entry = "3.5.2, four flutes against two at equal feed rate",
       .printed = "both forces larger with four, the feed force more so",
       .criterion = "so at all four feeds",
       .ours = fmt::format("at least x {:.2f} feed force, x {:.2f} normal force", least_x, least_y),
       .pass = larger && least_x > 1.0 && least_y > 1.0});
}

/// SD over mean of the sum of chip thicknesses of straight flutes in a slot.
double chip_variation(int flutes) {
  constexpr int kSteps = 7200;
  std::vector<double> sums(kSteps, 0.0);
  for (int i = 0; i < kSteps; ++i) {
    for (int j = 0; j < flutes; ++j) {
      const double theta = 2.0 * std::numbers::pi *
                           (static_cast<double>(i) / kSteps - static_cast<double>(j) / flutes);
      cutting::Condition unit;
      unit.feed_per_tooth = 1.0;
      sums[static_cast<std::size_t>(i)] +=
          cutting::chip_thickness(unit, theta, 0.5 * std::numbers::pi);
    }
  }
  const double mean_sum = std::accumulate(sums.begin(), sums.end(), 0.0) / kSteps;
  double square = 0.0;
  for (const double sum : sums) square += (sum - mean_sum) * (sum - mean_sum) / kSteps;
  return std::sqrt(square) / mean_sum;
}

void chips_and_speeds(std::vector<Reproduced>& list) {
  const Vector3 variation =
      100.0 * Vector3(chip_variation(2), chip_variation(4), chip_variation(8));
  list.push_back({.source = "[plaskos2006]",
                  .entry = "3.5.2, variation of the total chip thickness of a slot",
                  .printed = "about 50 / 10 / 2.5 % SD for 2 / 4 / 8 straight flutes",
                  .criterion = "48 / 10 / 2.3 % to the last digit",
                  .ours = three(variation, 1) + " %",
                  .pass = std::abs(variation.x() - 48.0) < 0.5 &&
                          std::abs(variation.y() - 10.0) < 0.5 &&
                          std::abs(variation.z() - 2.3) < 0.05});

  const io::ForceCase fast = read("plaskos2006/tool_a_fast.toml");
  const io::ForceCase slow = read("plaskos2006/tool_a_slow.toml");
  const double printed_x[] = {54.4, 39.7, 24.1, 37.9, 63.7};
  const double printed_y[] = {35.2, 61.2, 20.0, 19.5, 24.0};
  const double feeds_um[] = {2, 7, 13, 25, 50};
  std::string ours_x, ours_y;
  bool within = true;
  for (int i = 0; i < 5; ++i) {
    const Vector3 ratio =
        mean(slow, feeds_um[i] * units::um).cwiseQuotient(mean(fast, feeds_um[i] * units::um));
    const double x = 100.0 * (ratio.x() - 1.0), y = 100.0 * (ratio.y() - 1.0);
    ours_x += fmt::format("{}{:.0f}", i == 0 ? "" : " ", x);
    ours_y += fmt::format("{}{:.0f}", i == 0 ? "" : " ", y);
    within = within && std::abs(x - printed_x[i]) < 20.0 && std::abs(y - printed_y[i]) < 20.0;
  }
  const char* const no_law =
      "the low-speed law is in figures only; the one used is an assumed example";
  list.push_back({.source = "[plaskos2006]",
                  .entry = "table 3.3, increase of the means from 5000 to 100 rpm",
                  .printed = "x 54.4 39.7 24.1 37.9 63.7, y 35.2 61.2 20.0 19.5 24.0 %",
                  .criterion = "each within 20 points",
                  .ours = "x " + ours_x + ", y " + ours_y + " %",
                  .pass = within,
                  .reason = no_law});

  // 100 against 5000 rpm at equal feed rate: fifty times the feed per tooth.
  const Vector3 times = mean(slow, 50.0 * 2e-6).cwiseQuotient(mean(fast, 2e-6));
  list.push_back(
      {.source = "[plaskos2006]",
       .entry = "figure 3.13, 100 against 5000 rpm at equal feed rate",
       .printed = "about 5 times the feed force and 20 times the normal force",
       .criterion = "each within a factor of 1.5, at 2 and 100 um a tooth",
       .ours = fmt::format("x {:.1f} feed force, x {:.1f} normal force", times.x(), times.y()),
       .pass = times.x() > 5.0 / 1.5 && times.x() < 5.0 * 1.5 && times.y() > 20.0 / 1.5 &&
               times.y() < 20.0 * 1.5,
       .reason = no_law});
}

/// Misfit, rms over mean force, of the best power law to cuts that follow a law; 2.5 to 50 um.
double power_law_misfit(const cutting::EdgeForce& law) {
  std::vector<cutting::OrthogonalCut> cuts;
  double mean_force = 0.0;
  for (const double um : {2.5, 5.0, 7.5, 12.5, 25.0, 37.5, 50.0}) {
    cuts.push_back({um * units::um, cutting::force_per_width(law, um * units::um)});
    mean_force += cuts.back().force / 7.0;
  }
  return cutting::fit_power_law(cuts).quality.rms / mean_force;
}

void fits(std::vector<Reproduced>& list) {
  const cutting::CuttingLaw law = read("plaskos2006/table_3_5_tool_c.toml").bone.law;
  const double tangential = power_law_misfit(law.tangential.at_0);
  const double radial = power_law_misfit(law.radial.at_0);
  list.push_back({.source = "[plaskos2006]",
                  .entry = "2.4.4, the log law fits better, the power law cannot follow F_r",
                  .printed = "better fit for both forces; F_r falls with the chip (n_r < 0)",
                  .criterion = "the power law misses the log law's curve by more for F_r than for "
                               "F_t, and for F_r by more than the cuts' SD of about 5 %",
                  .ours = fmt::format("F_r {:.1f} %, F_t {:.1f} % rms at 0 deg, 2.5 to 50 um",
                                      100.0 * radial, 100.0 * tangential),
                  .pass = radial > tangential && radial > 0.05,
                  .reason =
                      "the cuts are in figures only: points of the law reconstructed from the "
                      "milling means stand for them, so only the power law is tested"});
}

}  // namespace

void reproduce_plaskos2006(std::vector<Reproduced>& list) {
  fits(list);
  tables(list);
  trends(list);
  chips_and_speeds(list);
}

void reproduce_plaskos2002(std::vector<Reproduced>& list) {
  const char* const power = "plaskos2002/m10_slot.toml";
  const char* const linear = "plaskos2002/m10_slot_linear.toml";
  const char* const example =
      "the laws' constants are in figures only; those used are an assumed example, so the trend is "
      "what is tested";
  const auto feeds = [](const char* name, int flutes, double feed_mm_per_s) {
    return read(name, {fmt::format("cutter.flutes={}", flutes),
                       fmt::format("cut.feed_rate_mm_per_min={}", 60.0 * feed_mm_per_s)});
  };
  bool grows = true;
  std::string ours;
  for (const char* name : {power, linear}) {
    for (const int flutes : {2, 4}) {
      const double slow = peak(feeds(name, flutes, 0.5));
      const double middle = peak(feeds(name, flutes, 1.0));
      const double fast = peak(feeds(name, flutes, 2.0));
      grows = grows && middle > slow && fast > middle && middle < 2.0 * slow && fast < 2.0 * middle;
      ours += fmt::format("{}{:.2f} {:.2f} {:.2f}", ours.empty() ? "" : "; ", slow, middle, fast);
    }
  }
  list.push_back(
      {.source = "[plaskos2002]",
       .entry = "4.4.2, effect of feed on the largest force",
       .printed = "grows with feed, less than doubled when the feed doubles, both models",
       .criterion = "so from 0.5 to 1 to 2 mm/s for 2 and 4 flutes",
       .ours = ours + " N (non-linear 2, 4; linear 2, 4 flutes)",
       .pass = grows,
       .reason = example});

  const double tiny_power = peak(feeds(power, 2, 1e-9)) / peak(feeds(power, 2, 1.0));
  const double tiny_linear = peak(feeds(linear, 2, 1e-9)) / peak(feeds(linear, 2, 1.0));
  list.push_back(
      {.source = "[plaskos2002]",
       .entry = "4.4.2, feed towards zero",
       .printed = "the non-linear model tends to zero, the linear one to its edge force",
       .criterion = "below 5 % and above 20 % of the force at 1 mm/s",
       .ours = fmt::format("{:.2g} % and {:.0f} %", 100.0 * tiny_power, 100.0 * tiny_linear),
       .pass = tiny_power < 0.05 && tiny_linear > 0.2,
       .reason = example});

  const double power_ratio = peak(feeds(power, 4, 1.0)) / peak(feeds(power, 2, 1.0));
  const double linear_ratio = peak(feeds(linear, 4, 1.0)) / peak(feeds(linear, 2, 1.0));
  list.push_back({.source = "[plaskos2002]",
                  .entry = "4.4.1, four flutes against two at 1 mm/s",
                  .printed = "largest force higher for two (non-linear), slightly higher for four "
                             "(linear)",
                  .criterion = "ratio four to two below 1 and above 1",
                  .ours = fmt::format("{:.3f} and {:.3f}", power_ratio, linear_ratio),
                  .pass = power_ratio < 1.0 && linear_ratio > 1.0,
                  .reason = example});

  // 50 mm³/s at 20 000 rpm: depth and feed of figures 4.18 and 4.19.
  const auto at_equal_volume = [&](const char* name, int flutes, double depth, double feed) {
    return peak(read(name, {fmt::format("cutter.flutes={}", flutes), "cut.spindle_speed_rpm=20000",
                            fmt::format("cut.axial_depth_mm={}", depth),
                            fmt::format("cut.feed_rate_mm_per_min={}", 60.0 * feed)}));
  };
  bool falls = true;
  std::string forces;
  for (const char* name : {power, linear}) {
    for (const int flutes : {2, 4}) {
      const double deep = at_equal_volume(name, flutes, 30.0, 0.54);
      const double middle = at_equal_volume(name, flutes, 20.0, 0.81);
      const double shallow = at_equal_volume(name, flutes, 10.0, 1.61);
      falls = falls && deep > 1.1 * middle && middle > 1.1 * shallow;
      forces +=
          fmt::format("{}{:.0f} {:.0f} {:.0f}", forces.empty() ? "" : "; ", deep, middle, shallow);
    }
  }
  list.push_back({.source = "[plaskos2002]",
                  .entry = "4.4.2, depth at a constant removal rate of 50 mm3/s",
                  .printed = "significantly lower forces at smaller depth and larger feed",
                  .criterion = "each step from 30 to 20 to 10 mm lowers the peak by 10 % or more",
                  .ours = forces + " N (non-linear 2, 4; linear 2, 4 flutes)",
                  .pass = falls,
                  .reason = example});

  std::string differences;
  bool similar = true;
  for (const int flutes : {2, 4}) {
    const io::ForceCase hankinson = feeds(linear, flutes, 1.0);
    io::ForceCase puw = hankinson;
    puw.bone.law.orientation = cutting::OrientationCriterion::puw_hocheng;
    const double difference = peak(puw) / peak(hankinson) - 1.0;
    similar = similar && std::abs(difference) < 0.1;
    differences += fmt::format("{}{:+.1f} %", differences.empty() ? "" : ", ", 100.0 * difference);
  }
  list.push_back({.source = "[plaskos2002]",
                  .entry = "4.4.1, linear against FRP (Puw-Hocheng) model",
                  .printed = "very similar curves",
                  .criterion = "largest force within 10 %",
                  .ours = differences + " for 2 and 4 flutes",
                  .pass = similar,
                  .reason = example});
}

void reproduce_tian2023(std::vector<Reproduced>& list) {
  const std::string source = "[tian2023]";
  // Rows x, y, z; columns t, r, a. The printed matrix of eq. 14 has -L Q in the middle row.
  const auto largest_defect = [](double sign) {
    double defect = 0.0;
    for (double kappa = 0.1; kappa < 1.5; kappa += 0.2) {
      for (double psi = 0.1; psi < 3.1; psi += 0.3) {
        Eigen::Matrix3d t;
        t.col(0) = -cutting::motion(psi);
        t.col(1) = -cutting::outward_normal(psi, kappa);
        t.col(2) = cutting::motion(psi).cross(cutting::outward_normal(psi, kappa));
        t(1, 2) *= sign;
        defect = std::max(defect, (t.transpose() * t - Eigen::Matrix3d::Identity()).norm());
      }
    }
    return defect;
  };
  list.push_back({.source = source,
                  .entry = "eqs. 14 and 16, transformation to x, y, z",
                  .printed = "-L Q in the second row; eq. 7 has +L Q",
                  .criterion = "orthonormal to rounding",
                  .ours = fmt::format("|T'T - 1| <= {:.0e} with +L Q, {:.2f} as printed",
                                      largest_defect(1.0), largest_defect(-1.0)),
                  .pass = largest_defect(1.0) < 1e-12 && largest_defect(-1.0) > 0.1,
                  .reason = "the printed sign is a misprint"});

  const io::ForceCase base = read("tian2023/table_1.toml");
  const cutting::EdgePlace at_1{1.0, 1.0};
  const auto pressure = [&](const cutting::EdgeForce& law) {
    // Per chip of 1 m, less the edge force: the polynomial itself, N/mm².
    return (cutting::force_per_width(law, 1.0, at_1) - cutting::force_per_width(law, 0.0, at_1)) /
           units::n_per_mm2;
  };
  const Vector3 at_kappa_1(pressure(base.bone.law.tangential.at_0),
                           pressure(base.bone.law.radial.at_0),
                           -pressure(base.bone.law.lateral->at_0));
  list.push_back(
      {.source = source,
       .entry = "4.3, coefficients of eq. 17 at kappa = 1",
       .printed = "375.61 / 380.12 / 315.72 N/mm2 (t / r / a)",
       .criterion = "within 0.02 N/mm2",
       .ours = three(at_kappa_1),
       .pass = (at_kappa_1 - Vector3(375.61, 380.12, 315.72)).cwiseAbs().maxCoeff() < 0.02,
       .reason = "the radial one does not follow from eq. 17; -159.14 in place of "
                 "-195.24 would give 380.12: two digits swapped in one of the places"});

  const auto rows = read_mean_rows("tian2023/table_1.csv");
  double flutes = 0.0;
  for (const Row& row : rows) {
    flutes += row.feed_rate / (5000.0 * row.feed_per_tooth) / static_cast<double>(rows.size());
  }
  list.push_back({.source = source,
                  .entry = "table 1, number of flutes",
                  .printed = "not stated",
                  .criterion = "feed rate over speed and feed per tooth is a whole number",
                  .ours = fmt::format("{:.3f}", flutes),
                  .pass = std::abs(flutes - 8.0) < 1e-9});

  std::string sizes;
  bool close = true;
  for (const double diameter : {2.18, 4.0, 6.0}) {
    Vector3 ratio = Vector3::Zero();
    for (const Row& row : rows) {
      const Vector3 ours = mean(read(
          "tian2023/table_1.toml", {fmt::format("cutter.diameter_mm={}", diameter),
                                    fmt::format("cut.axial_depth_mm={}", row.depth),
                                    fmt::format("cut.feed_per_tooth_mm={}", row.feed_per_tooth)}));
      const Vector3 one = ours.cwiseQuotient(row.force);
      ratio += one / static_cast<double>(rows.size());
      close = close && (one.array() > 0.8).all() && (one.array() < 1.2).all();
    }
    sizes += fmt::format("{}R {:.2f} mm: {}", sizes.empty() ? "" : "; ", 0.5 * diameter,
                         three(ratio, 1));
  }
  list.push_back({.source = source,
                  .entry = "table 1, means with the published coefficients",
                  .printed = "-0.62 ... -1.29 / 6.18 ... 10.96 / -7.46 ... -11.16 N",
                  .criterion = "each mean within 20 % for some radius",
                  .ours = "ours over printed, mean of the ten rows: " + sizes,
                  .pass = close,
                  .reason = "the published coefficients do not belong to this table: they are not "
                            "its least-squares solution either, whatever the radius, which is not "
                            "given"});
}

}  // namespace osteomill::cli
