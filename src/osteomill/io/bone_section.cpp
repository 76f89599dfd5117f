// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/bone_section.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/cutting/law_interpolation.hpp"
#include "osteomill/cutting/law_strength.hpp"
#include "osteomill/io/section.hpp"

namespace osteomill::io {
namespace {

using namespace cutting;

enum class LawKind { log, power, linear, kienzle, polynomial };

constexpr Quantity kDeg{units::deg, "deg"};
constexpr Quantity kNPerMm{units::n_per_mm, "N/mm"};
constexpr Quantity kNPerMm2{units::n_per_mm2, "N/mm2"};

/// The keys of one law. Every kind of law is walked for the schema; reading takes the one chosen.
EdgeForce bind_law(Section& s, LawKind kind, const ChipRange& range) {
  LogLaw log;
  PowerLaw power;
  LinearLaw linear;
  double pressure = 0.0;
  double m = 0.0;
  if (s.when(kind == LawKind::log)) {
    s.number("k1", log.k1, {}, any(), "K1 of log10 F = K3 L^2 + K2 L + K1, L = log10 h, h in um");
    s.number("k2", log.k2, {}, any(), "K2");
    s.number("k3", log.k3, {}, any(), "K3");
  }
  if (s.when(kind == LawKind::power)) {
    s.number("k", power.at_1_mm, kNPerMm, non_negative(), "K of F = K h^n + edge, h in mm");
    s.number("n", power.exponent, {}, up_to(2.0), "exponent n");
    s.number("edge", power.edge, kNPerMm, non_negative(), "edge force", Need::optional);
  }
  if (s.when(kind == LawKind::linear)) {
    s.number("k", linear.pressure, kNPerMm2, any(), "pressure of F = k h + edge");
    s.number("edge", linear.edge, kNPerMm, any(), "edge force", Need::optional);
  }
  if (s.when(kind == LawKind::kienzle)) {
    s.number("k", pressure, kNPerMm2, non_negative(), "k_c1.1, pressure at a chip of 1 mm");
    s.number("m", m, {}, between(0.0, 0.99), "exponent m of k_c1.1 h^-m, h in mm");
  }
  switch (kind) {
    case LawKind::log:
      log.range = range;
      return log;
    case LawKind::power:
      power.range = range;
      return power;
    case LawKind::linear:
      linear.range = range;
      return linear;
    case LawKind::kienzle:
      return cutting::kienzle(pressure, m, range);
    case LawKind::polynomial:
      break;
  }
  return linear;
}

void bind_directional(Section& s, LawKind kind, const ChipRange& range, DirectionalLaw& law) {
  const auto one = [&](const char* key, const char* meaning, EdgeForce& to) {
    return s.table(key, meaning, Need::optional,
                   [&](Section& below) { to = bind_law(below, kind, range); });
  };
  EdgeForce at_90;
  const bool any = one("any_deg", "law in every direction", law.at_0);
  const bool along = one("at_0_deg", "law of motion along the fibres", law.at_0);
  const bool across = one("at_90_deg", "law of motion across the fibres", at_90);
  if (across) law.at_90 = at_90;
  if (any ? along || across : !(along && across)) {
    s.fault("any_deg", "needs either any_deg, or both at_0_deg and at_90_deg");
  }
}

void bind_polynomial(Section& s, const ChipRange& range, CuttingLaw& law) {
  PolynomialLaw tangential;
  PolynomialLaw radial;
  PolynomialLaw axial;
  s.table("shear", "pressures as polynomials in kappa, [c0, c1, ...]", Need::required,
          [&](Section& t) {
            t.numbers("tangential", tangential.pressure, kNPerMm2, any(), "tangential pressure");
            t.numbers("radial", radial.pressure, kNPerMm2, any(), "radial pressure");
            t.numbers("axial", axial.pressure, kNPerMm2, any(), "axial pressure", Need::optional);
          });
  s.table("edge", "edge forces as polynomials in kappa", Need::optional, [&](Section& t) {
    t.numbers("tangential", tangential.edge, kNPerMm, any(), "tangential edge force",
              Need::optional);
    t.numbers("radial", radial.edge, kNPerMm, any(), "radial edge force", Need::optional);
    t.numbers("axial", axial.edge, kNPerMm, any(), "axial edge force", Need::optional);
  });
  for (PolynomialLaw* one : {&tangential, &radial, &axial}) one->range = range;
  law.tangential = {tangential, {}};
  law.radial = {radial, {}};
  if (!axial.pressure.empty() || !axial.edge.empty()) {
    // [tian2023] has it along the meridian away from the tip, the lateral force points to the tip.
    for (double& c : axial.pressure) c = -c;
    for (double& e : axial.edge) e = -e;
    law.lateral = DirectionalLaw{axial, {}};
  }
}

/// The keys of one law with what it was measured on.
void bind_law_keys(Section& s, BoneCase& bone) {
  LawKind kind = LawKind::log;
  s.choice<LawKind>("law", kind,
                    {{"log", LawKind::log},
                     {"power", LawKind::power},
                     {"linear", LawKind::linear},
                     {"kienzle", LawKind::kienzle},
                     {"polynomial", LawKind::polynomial}},
                    "form of the edge-force law");
  ChipRange range;
  std::vector<double> ends;
  s.numbers("range_um", ends, {units::um, "um"}, non_negative(),
            "smallest and largest chip thickness that the law was measured on", Need::optional);
  if (ends.size() == 2 && ends[0] < ends[1]) {
    range = {ends[0], ends[1]};
  } else if (!ends.empty()) {
    s.fault("range_um", "must be two chip thicknesses, the smaller first");
  }
  CuttingLaw& law = bone.law;
  s.choice<OrientationCriterion>("orientation", law.orientation,
                                 {{"hankinson", OrientationCriterion::hankinson},
                                  {"puw-hocheng", OrientationCriterion::puw_hocheng},
                                  {"none", OrientationCriterion::none}},
                                 "criterion between motion along and across the fibres",
                                 Need::optional);
  s.number("orientation_exponent", law.orientation_exponent, {}, between(0.5, 6.0),
           "exponent of Hankinson's criterion", Need::optional);
  if (s.when(kind != LawKind::polynomial)) {
    const auto component = [&](const char* key, const char* meaning, Need need,
                               DirectionalLaw& to) {
      return s.table(key, meaning, need,
                     [&](Section& below) { bind_directional(below, kind, range, to); });
    };
    component("tangential", "force against the edge's motion", Need::required, law.tangential);
    component("radial", "force along the inward normal", Need::required, law.radial);
    DirectionalLaw lateral;
    const bool there = s.table(
        "lateral", "force along the edge's meridian towards the tip", Need::optional,
        [&](Section& below) {
          bind_directional(below, kind, range, lateral);
          below.number("inclination_deg", law.lateral_inclination, kDeg, between(-75.0, 75.0),
                       "inclination that the law was measured at; 0: use it as it is",
                       Need::optional);
        });
    if (there) law.lateral = lateral;
  }
  if (s.when(kind == LawKind::polynomial)) bind_polynomial(s, range, law);
  s.number("minimum_chip_um", law.minimum_chip, {units::um, "um"}, between(0.0, 100.0),
           "least chip that the edge lifts; it ploughs below (an assumption)", Need::optional);
  std::vector<double> speeds;
  s.numbers("speed_range_m_per_s", speeds, {1.0, "m/s"}, non_negative(),
            "slowest and fastest surface speed that the law was measured at", Need::optional);
  if (speeds.size() == 2 && speeds[0] < speeds[1]) {
    bone.speed_range = {speeds[0], speeds[1]};
  } else if (!speeds.empty()) {
    s.fault("speed_range_m_per_s", "must be two speeds, the smaller first");
  }
  s.number("rake_deg", bone.rake_angle, kDeg, between(-60.0, 60.0),
           "rake angle of the edges that the law was measured with");
  s.number("reference_density_kg_per_m3", bone.density.reference.value, {1.0, "kg/m3"}, positive(),
           "apparent density that the law was measured at", Need::optional);
  s.number("density_exponent", bone.density.exponent.value, {}, between(0.0, 4.0),
           "exponent of density over reference density in the force (an assumption)",
           Need::optional);
  s.number("strength", bone.strength, {}, Range{1e-3, 1e3},
           "times the force of the law: a patient's bone, as identify online finds it",
           Need::optional);
  if (bone.strength > 0.0 && bone.strength != 1.0) law = cutting::scaled(law, bone.strength);
  bind_provenance(s, bone.provenance);
  s.free_table("identification", "covariance and quality of a law that was identified");
}

double angle_of(const BoneCase& one, TestedBy by) {
  return by == TestedBy::rake ? one.rake_angle.value_or(0.0) : one.law.lateral_inclination;
}

void settle_angle(BoneCase& bone, const Cutter& cutter) {
  const bool rake = bone.tested_by == TestedBy::rake;
  const double angle = rake ? cutter.rake_angle : std::abs(cutter.helix_angle);
  std::vector<BoneCase> tested = std::move(bone.tested);
  std::stable_sort(tested.begin(), tested.end(), [&](const BoneCase& a, const BoneCase& b) {
    return angle_of(a, bone.tested_by) < angle_of(b, bone.tested_by);
  });
  const auto degrees = [&](const BoneCase& one) {
    return angle_of(one, bone.tested_by) / units::deg;
  };
  const auto above = std::find_if(tested.begin() + 1, tested.end(), [&](const BoneCase& one) {
    return degrees(one) >= angle / units::deg - 1e-9;
  });
  if (above == tested.end() || degrees(*(above - 1)) > angle / units::deg + 1e-9) {
    throw InvalidInput(Fault{rake ? "cutter.rake_deg" : "cutter.helix_deg",
                             fmt::format("{:g} deg", angle / units::deg),
                             fmt::format("must lie within the tested angles, {:g} ... {:g} deg",
                                         degrees(tested.front()), degrees(tested.back())),
                             "nothing is extrapolated: add a law to bone.tested"});
  }
  const BoneCase& low = *(above - 1);
  const BoneCase& high = *above;
  const InterpolatedLaw between = interpolate({low.law, degrees(low) * units::deg},
                                              {high.law, degrees(high) * units::deg}, angle);
  std::vector<std::string> notes = std::move(bone.notes);
  for (const BoneCase* one : {&low, &high}) {
    const std::string text = bone::caveat("the cutting law", one->provenance);
    if (!text.empty() && std::find(notes.begin(), notes.end(), text) == notes.end()) {
      notes.push_back(text);
    }
  }
  notes.push_back(
      fmt::format("the law is interpolated between {} of {:g} and {:g} deg, linearly in the force; "
                  "written as a "
                  "log law that is within {:.2g} %",
                  rake ? "rakes" : "inclinations", degrees(low), degrees(high),
                  100.0 * between.largest_deviation));
  BoneCase settled = low;
  settled.law = between.law;
  settled.rake_angle = rake ? std::optional(angle) : low.rake_angle;
  if (!rake) settled.law.lateral_inclination = angle;
  settled.provenance = {};
  settled.provenance.obtained = bone::Obtained::measured;  // the tested laws' own caveats are noted
  settled.notes = std::move(notes);
  bone = std::move(settled);
}

}  // namespace

void bind_provenance(Section& section, bone::Provenance& provenance) {
  section.table("provenance", "where the values come from", Need::optional, [&](Section& s) {
    using bone::Obtained;
    s.choice<Obtained>("obtained", provenance.obtained,
                       {{"measured", Obtained::measured},
                        {"digitised", Obtained::digitised},
                        {"reconstructed", Obtained::reconstructed},
                        {"assumed", Obtained::assumed},
                        {"unstated", Obtained::unstated}},
                       "how the values were obtained", Need::optional);
    s.text("source", provenance.source, "source, by its key in the bibliography", Need::optional);
    s.text("specimen", provenance.specimen, "specimen", Need::optional);
    s.text("condition", provenance.condition, "condition", Need::optional);
    s.text("uncertainty", provenance.uncertainty, "uncertainty", Need::optional);
    s.text("note", provenance.note, "what a user has to know", Need::optional);
  });
}

void bind_bone(Section& section, BoneCase& bone) {
  section.table("bone", "bone", Need::required, [&](Section& s) {
    const bool several = s.has("tested");
    if (s.when(!several)) bind_law_keys(s, bone);
    if (s.when(several)) {
      s.tables("tested", "laws of tested edges, to interpolate between", Need::optional,
               [&](Section& t, std::size_t) { bind_law_keys(t, bone.tested.emplace_back()); });
      s.choice<TestedBy>("tested_by", bone.tested_by,
                         {{"rake", TestedBy::rake}, {"inclination", TestedBy::inclination}},
                         "angle of the edge that the tested laws differ in", Need::optional);
      if (bone.tested.size() == 1) s.fault("tested", "needs two laws or more");
      for (const BoneCase& one : bone.tested) {
        if (bone.tested_by == TestedBy::rake && !one.rake_angle) {
          s.fault("tested", "needs the rake_deg of each law");
          break;
        }
      }
    }
    BoneCase low_speed;
    if (s.table("low_speed", "law that holds up to 100 rpm, in place of the other", Need::optional,
                [&](Section& t) { bind_law_keys(t, low_speed); })) {
      bone.low_speed.assign(1, low_speed);
    }
  });
}

void settle(BoneCase& bone, const Cutter& cutter, std::optional<double> spindle_speed) {
  if (!bone.low_speed.empty() && spindle_speed) {
    BoneCase low_speed = std::move(bone.low_speed.front());
    bone.low_speed.clear();
    if (&law_at_speed(low_speed.law, bone.law, *spindle_speed) == &low_speed.law) {
      bone = std::move(low_speed);
      bone.notes.push_back("the low-speed law holds: the spindle turns at 100 rpm or less");
    }
  }
  if (!bone.tested.empty()) settle_angle(bone, cutter);
  cutting::check(bone.law);
}

}  // namespace osteomill::io
