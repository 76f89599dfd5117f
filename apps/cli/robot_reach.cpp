// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/robot_chain_case.hpp"
#include "robot.hpp"

namespace osteomill::cli {
namespace {

using Json = nlohmann::ordered_json;
using units::deg;
using units::mm;

Shown solve(const io::CaseRun& run, std::string& no_solution) {
  io::RobotReachCase c;
  Shown shown;
  shown.expanded =
      io::Section::read(run, [&](io::Section& section) { io::bind_robot_reach(section, c); });
  if (c.placeholders) {
    shown.warnings.push_back(
        "seven-axis robot: C2 to C5, G9 and the joint limits are placeholders, the paper does not "
        "print them; its stiffnesses are measured at home and taken as those of the slides");
  }
  shown.rows = {{"target", "reached", "error, mm", "to limit, %", "smallest singular value",
                 "deflection, mm"}};
  for (const robot::Joint& joint : c.chain.joints) {
    shown.rows.front().push_back(joint.name + (joint.prismatic ? ", mm" : ", deg"));
  }
  Json& list = shown.document["targets"] = Json::array();
  Eigen::VectorXd q = Eigen::VectorXd::Zero(c.chain.size());
  for (const io::RobotReachCase::Target& target : c.targets) {
    // The way from target to target is short when each starts at the one before.
    const robot::InverseResult found = robot::inverse(c.chain, target.X_BT, q, c.options);
    const robot::Dexterity dexterity = robot::dexterity(c.chain, found.q);
    const auto compliance = robot::tool_compliance(c.chain, found.q);
    const robot::Vector3 bent = compliance.topLeftCorner<3, 3>() * c.force;
    Json one = {{"name", target.name},
                {"reached", found.converged},
                {"reason", found.reason},
                {"position_error_mm", found.position_error / mm},
                {"rotation_error_deg", found.rotation_error / deg},
                {"limit_distance", found.limit_distance},
                {"rank", dexterity.rank},
                {"smallest_singular_value", dexterity.smallest},
                {"manipulability", dexterity.manipulability},
                {"deflection_mm", xyz(bent, mm)}};
    std::vector<std::string> row = {target.name,
                                    found.converged ? "yes" : "no",
                                    fmt::format("{:.1e}", found.position_error / mm),
                                    fixed(100.0 * found.limit_distance, 0),
                                    fixed(dexterity.smallest, 3),
                                    fixed(bent.norm() / mm, 3)};
    for (Eigen::Index i = 0; i < c.chain.size(); ++i) {
      const robot::Joint& joint = c.chain.joints[static_cast<std::size_t>(i)];
      const double value = found.q[i] / (joint.prismatic ? mm : deg);
      one["joints"][joint.name + (joint.prismatic ? "_mm" : "_deg")] = value;
      row.push_back(fixed(value, 2));
    }
    const auto ellipsoid = robot::stiffness_ellipsoid(c.chain, found.q);
    one["stiffness_ellipsoid"] = Json::array();
    for (std::size_t k = 0; k < ellipsoid.stiffness.size(); ++k) {
      one["stiffness_ellipsoid"].push_back(
          {{"stiffness_n_per_mm", ellipsoid.stiffness[k] / units::n_per_mm},
           {"direction", xyz(ellipsoid.directions[k], 1.0)}});
    }
    list.push_back(one);
    shown.rows.push_back(row);
    if (found.converged) {
      q = found.q;
    } else if (no_solution.empty()) {
      no_solution = fmt::format("{}: {}", target.name, found.reason);
    }
  }
  return shown;
}

}  // namespace

void add_robot_reach(CLI::App& program) {
  add_robot_command(program, "reach", "joint values of a serial robot for poses of its tool",
                    solve);
}

}  // namespace osteomill::cli
