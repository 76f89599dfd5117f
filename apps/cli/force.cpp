// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include "command.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/cutting/prediction.hpp"
#include "osteomill/io/case_file.hpp"
#include "osteomill/io/force_case.hpp"

namespace osteomill::cli {
namespace {

using Json = nlohmann::ordered_json;

Json xyz(const geometry::Vector3& vector) {
  return {{"x", vector.x()}, {"y", vector.y()}, {"z", vector.z()}};
}

Json document_of(const cutting::Prediction& cut) {
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
  document["removal_rate_mm3_per_s"] = cut.removal_rate / units::mm3;
  document["specific_energy_j_per_mm3"] = cut.specific_energy * units::mm3;
  document["feed_per_tooth_mm"] = cut.feed_per_tooth / units::mm;
  document["largest_chip_um"] = cut.largest_chip / units::um;
  Json& orders = document["harmonics"] = Json::array();
  for (std::size_t k = 0; k < cut.harmonics.size(); ++k) {
    orders.push_back({{"order", k + 1}, {"amplitude_n", xyz(cut.harmonics[k])}});
  }
  Json& turn = document["revolution"];
  turn["angle_deg"] = Json::array();
  turn["force_n"] = {{"x", Json::array()}, {"y", Json::array()}, {"z", Json::array()}};
  turn["torque_nmm"] = Json::array();
  for (std::size_t i = 0; i < cut.revolution.loads.size(); ++i) {
    const cutting::Load& load = cut.revolution.loads[i];
    turn["angle_deg"].push_back(cut.revolution.angle[i] / units::deg);
    turn["force_n"]["x"].push_back(load.force.x());
    turn["force_n"]["y"].push_back(load.force.y());
    turn["force_n"]["z"].push_back(load.force.z());
    turn["torque_nmm"].push_back(load.torque() / units::n_mm);
  }
  document["warnings"] = cut.warnings;
  return document;
}

std::vector<std::vector<std::string>> rows_of(const cutting::Prediction& cut) {
  const auto forces = [](const char* name, const geometry::Vector3& f, double resultant) {
    return std::vector<std::string>{name, fmt::format("{:.2f}", f.x()),
                                    fmt::format("{:.2f}", f.y()), fmt::format("{:.2f}", f.z()),
                                    fmt::format("{:.2f}", resultant)};
  };
  const auto one = [](const char* name, double value) {
    return std::vector<std::string>{name, fmt::format("{:.4g}", value)};
  };
  return {{"force on the cutter, N", "x (feed)", "y (normal)", "z (axis)", "resultant"},
          forces("mean", cut.mean.force, cut.mean.force.norm()),
          forces("peak", cut.peak, cut.peak_resultant),
          forces("rms", cut.rms, cut.rms.norm()),
          {""},
          one("mean torque, N mm", cut.mean_torque / units::n_mm),
          one("peak bending moment, N mm", cut.peak_bending_moment / units::n_mm),
          one("mean spindle power, W", cut.spindle_power),
          one("removal rate, mm3/s", cut.removal_rate / units::mm3),
          one("specific energy, J/mm3", cut.specific_energy * units::mm3),
          one("feed per tooth, um", cut.feed_per_tooth / units::um),
          one("largest chip, um", cut.largest_chip / units::um)};
}

void run(const CaseArguments& arguments) {
  for (const io::CaseRun& run : io::read_case(arguments.case_file, arguments.overrides)) {
    const io::ForceCase force = io::read_force_case(run);
    cutting::Prediction cut =
        cutting::predict(force.cutter, force.bone.law, force.condition, force.immersion);
    cut.warnings.insert(cut.warnings.begin(), force.caveats.begin(), force.caveats.end());
    for (const std::string& warning : cut.warnings) warn(warning);
    switch (arguments.format) {
      case Format::json:
        print_json(document_of(cut));
        break;
      case Format::csv:
        print_csv(rows_of(cut));
        break;
      case Format::table:
        print_table(rows_of(cut));
        break;
    }
  }
}

}  // namespace

void add_force(CLI::App& program) {
  auto arguments = std::make_shared<CaseArguments>();
  CLI::App* command =
      program.add_subcommand("force", "forces, torque and power of one cutting condition");
  add_case_arguments(*command, *arguments);
  command->callback([arguments] { run(*arguments); });
}

}  // namespace osteomill::cli
