// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "osteomill/base/random.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/identify/force_model.hpp"

namespace osteomill::identify::for_test {

inline cutting::Cutter end_mill() {
  cutting::Cutter cutter;
  cutter.radius = 3.0 * units::mm;
  cutter.flutes = 4;
  cutter.helix_angle = 30.0 * units::deg;
  cutter.cutting_length = 20.0 * units::mm;
  return cutter;
}

inline cutting::Cutter ball() {
  cutting::Cutter cutter = end_mill();
  cutter.shape = cutting::CutterShape::ball;
  return cutter;
}

inline Experiment cut(const cutting::Cutter& cutter, double depth_mm, double feed_mm,
                      cutting::ImmersionKind kind = cutting::ImmersionKind::slot) {
  Experiment one;
  one.cutter = cutter;
  one.condition.spindle_speed = 5000.0 * units::rpm;
  one.condition.feed_per_tooth = feed_mm * units::mm;
  one.immersion = {kind, kind == cutting::ImmersionKind::slot ? 0.0 : 0.5 * cutter.radius,
                   depth_mm * units::mm};
  return one;
}

/// Slots and both kinds of side milling over depths and feeds, without forces.
inline std::vector<Experiment> plan(const cutting::Cutter& cutter) {
  using cutting::ImmersionKind;
  std::vector<Experiment> cuts;
  for (const double depth : {0.3, 0.8, 1.5, 2.4}) {
    for (const double feed : {0.004, 0.012, 0.03}) {
      for (const auto kind : {ImmersionKind::slot, ImmersionKind::up, ImmersionKind::down}) {
        cuts.push_back(cut(cutter, depth, feed, kind));
        cuts.back().name = std::to_string(cuts.size());
        cuts.back().group = std::to_string(static_cast<int>(10.0 * depth));
      }
    }
  }
  return cuts;
}

/// Gives the cuts the forces of a law, with normal noise of a standard deviation in N.
inline void measure(std::vector<Experiment>& cuts, const cutting::CuttingLaw& law, double noise,
                    std::uint64_t seed) {
  Random random(seed);
  const Eigen::VectorXd forces = mean_forces(law, cuts);
  for (std::size_t i = 0; i < cuts.size(); ++i) {
    for (Eigen::Index c = 0; c < 3; ++c) {
      cuts[i].mean_force(c) =
          forces(3 * static_cast<Eigen::Index>(i) + c) + noise * random.normal();
    }
  }
}

/// Ktc Krc Kac Kte Kre Kae of bone, SI.
inline Eigen::VectorXd bone() {
  Eigen::VectorXd values{{180.0, 90.0, 40.0, 3.0, 4.0, -1.0}};
  values.head(3) *= units::n_per_mm2;
  values.tail(3) *= units::n_per_mm;
  return values;
}

}  // namespace osteomill::identify::for_test
