// SPDX-License-Identifier: BSD-3-Clause
#include "command.hpp"
#include "osteomill/io/accuracy_case.hpp"
#include "osteomill/io/control_case.hpp"
#include "osteomill/io/fit_case.hpp"
#include "osteomill/io/force_case.hpp"
#include "osteomill/io/identify_case.hpp"
#include "osteomill/io/instantaneous_case.hpp"
#include "osteomill/io/map_case.hpp"
#include "osteomill/io/online_case.hpp"
#include "osteomill/io/robot_calibration_case.hpp"
#include "osteomill/io/robot_case.hpp"
#include "osteomill/io/robot_chain_case.hpp"
#include "osteomill/io/simulate_case.hpp"
#include "osteomill/io/study_case.hpp"
#include "osteomill/io/tune_case.hpp"
#include "osteomill/io/vibration_case.hpp"

namespace osteomill::cli {

void add_catalogue(CLI::App& program);
void add_deflect(CLI::App& program);
void add_control(CLI::App& program);
void add_fit(CLI::App& program);
void add_force(CLI::App& program);
void add_identify(CLI::App& program);
void add_identify_instantaneous(CLI::App& program);
void add_identify_online(CLI::App& program);
void add_map(CLI::App& program);
void add_modes(CLI::App& program);
void add_reproduce(CLI::App& program);
void add_optimise(CLI::App& program);
void add_respond(CLI::App& program);
void add_robot_calibrate(CLI::App& program);
void add_robot_place(CLI::App& program);
void add_robot_position(CLI::App& program);
void add_robot_reach(CLI::App& program);
void add_robot_size(CLI::App& program);
void add_robot_stiffness(CLI::App& program);
void add_robot_tibia(CLI::App& program);
void add_schema(CLI::App& program);
void add_stability(CLI::App& program);
void add_simulate(CLI::App& program);
void add_study(CLI::App& program);
void add_study_plan(CLI::App& program);
void add_tune(CLI::App& program);

const std::vector<Command>& commands() {
  static const std::vector<Command> list = {
      {"catalogue", add_catalogue, {}},
      {"deflect", add_deflect, io::bind_deflect},
      {"control", add_control, io::bind_control_keys},
      {"fit", add_fit, io::bind_fit},
      {"force", add_force, io::bind_force},
      {"identify", add_identify, io::bind_identify},
      {"identify instantaneous", add_identify_instantaneous, io::bind_instantaneous},
      {"identify online", add_identify_online, io::bind_online},
      {"map", add_map, io::bind_map},
      {"modes", add_modes, io::bind_modes},
      {"reproduce", add_reproduce, {}},
      {"optimise", add_optimise, io::bind_optimise},
      {"respond", add_respond, io::bind_respond},
      {"robot calibrate", add_robot_calibrate, io::bind_robot_calibrate_keys},
      {"robot place", add_robot_place, io::bind_robot_place_keys},
      {"robot position", add_robot_position, io::bind_robot_position_keys},
      {"robot reach", add_robot_reach, io::bind_robot_reach_keys},
      {"robot size", add_robot_size, io::bind_robot_size_keys},
      {"robot stiffness", add_robot_stiffness, io::bind_robot_stiffness_keys},
      {"robot tibia", add_robot_tibia, io::bind_robot_tibia_keys},
      {"schema", add_schema, {}},
      {"stability", add_stability, io::bind_stability},
      {"study", add_study, io::bind_study},
      {"study plan", add_study_plan, io::bind_study_plan},
      {"simulate", add_simulate, io::bind_simulate_keys},
      {"tune", add_tune, io::bind_tune_keys},
  };
  return list;
}

}  // namespace osteomill::cli
