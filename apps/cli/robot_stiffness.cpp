// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/cutting/prediction.hpp"
#include "osteomill/io/robot_chain_case.hpp"
#include "robot.hpp"

namespace osteomill::cli {
namespace {

using Json = nlohmann::ordered_json;
using robot::Vector3;
using units::deg;
using units::mm;

struct Load {
  std::string name;
  Vector3 force;
};

Shown solve(const io::CaseRun& run, std::string&) {
  io::RobotStiffnessCase c;
  Shown shown;
  shown.expanded =
      io::Section::read(run, [&](io::Section& section) { io::bind_robot_stiffness(section, c); });
  std::vector<Load> loads;
  if (c.force) {
    loads.push_back({"given", *c.force});
  } else {
    const cutting::Prediction cut = cutting::predict(
        c.cutter.cutter, c.bone.law, io::condition_of(c.cut, c.cutter.cutter), c.cut.immersion);
    const Vector3 z = c.axis_direction;
    const Vector3 x = (c.feed_direction - z * z.dot(c.feed_direction)).normalized();
    const Vector3 y = z.cross(x);
    const auto in_w = [&](const Vector3& f) { return Vector3(f.x() * x + f.y() * y + f.z() * z); };
    loads.push_back({"mean of the cut", in_w(cut.mean.force)});
    // The instant of the largest resultant: its components belong together.
    Vector3 largest = Vector3::Zero();
    for (const cutting::Load& load : cut.revolution.loads) {
      if (load.force.norm() > largest.norm()) largest = load.force;
    }
    loads.push_back({"peak of the cut", in_w(largest)});
    shown.warnings = c.caveats;
    shown.warnings.insert(shown.warnings.end(), cut.warnings.begin(), cut.warnings.end());
  }
  shown.rows = {{"load", "part", "x, mm", "y, mm", "z, mm", "total, mm"}};
  Json& list = shown.document["loads"] = Json::array();
  for (const Load& load : loads) {
    const robot::EdgeDeflection bent = robot::deflection_at(c.parts, c.edge, load.force);
    Json one = {{"name", load.name},
                {"force_n", xyz(load.force, 1.0)},
                {"deflection_mm", xyz(bent.translation, mm)},
                {"total_deflection_mm", bent.translation.norm() / mm},
                {"rotation_deg", xyz(bent.rotation, deg)}};
    if (bent.translation.norm() > 0.0) {
      one["stiffness_n_per_mm"] = load.force.norm() / (bent.translation.norm() / mm);
    }
    const auto row = [&](const std::string& part, const Vector3& d) {
      shown.rows.push_back({load.name, part, fixed(d.x() / mm, 4), fixed(d.y() / mm, 4),
                            fixed(d.z() / mm, 4), fixed(d.norm() / mm, 4)});
    };
    for (const auto& share : bent.shares) {
      one["shares"].push_back(
          {{"part", share.name}, {"deflection_mm", xyz(share.translation, mm)}});
      row(share.name, share.translation);
    }
    row("all", bent.translation);
    list.push_back(one);
  }
  // Stiffness of the whole chain at the edge, along each axis.
  for (int k = 0; k < 3; ++k) {
    const Vector3 unit = Vector3::Unit(k);
    const double give = robot::deflection_at(c.parts, c.edge, unit).translation[k];
    const char* const axis[] = {"x", "y", "z"};
    shown.document["stiffness_n_per_mm"][axis[k]] =
        give > 0.0 ? Json(1.0 / (give / mm)) : Json(nullptr);
  }
  return shown;
}

}  // namespace

void add_robot_stiffness(CLI::App& program) {
  add_robot_command(program, "stiffness", "deflection at the cutting edge, part by part", solve);
}

}  // namespace osteomill::cli
