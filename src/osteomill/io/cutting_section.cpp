// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/cutting_section.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "osteomill/base/units.hpp"
#include "osteomill/io/section.hpp"

namespace osteomill::io {
namespace {

using namespace cutting;

enum class LawKind { log, power, linear, kienzle, polynomial };
enum class Feed { parallel, transverse };

constexpr Quantity kMm{units::mm, "mm"};
constexpr Quantity kDeg{units::deg, "deg"};
constexpr Quantity kNPerMm{units::n_per_mm, "N/mm"};
constexpr Quantity kNPerMm2{units::n_per_mm2, "N/mm2"};

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

void bind_flutes(Section& s, Cutter& c) {
  s.choice<Lead>("lead", c.lead,
                 {{"constant-lead", Lead::constant_lead}, {"constant-angle", Lead::constant_angle}},
                 "how the edge winds where the radius changes", Need::optional);
  s.numbers("pitch_deg", c.pitch, kDeg, positive(),
            "from each flute to the next; empty: equal pitch", Need::optional);
  s.numbers("radius_error_um", c.radius_error, {units::um, "um"}, between(-200.0, 200.0),
            "how much farther out each flute is; empty: none", Need::optional);
  s.table("run_out", "how the cutter sits in the spindle", Need::optional, [&](Section& t) {
    t.number("offset_um", c.run_out.offset, {units::um, "um"}, between(0.0, 500.0),
             "distance of the cutter's axis from the spindle's at the tip", Need::optional);
    t.number("offset_angle_deg", c.run_out.offset_angle, kDeg, any(),
             "direction of the offset, as a lag behind flute 0", Need::optional);
    t.number("tilt_um_per_mm", c.run_out.tilt, {1e-3, "um/mm"}, between(-20.0, 20.0),
             "change of the distance with height", Need::optional);
    t.number("tilt_angle_deg", c.run_out.tilt_angle, kDeg, any(), "direction of the tilt",
             Need::optional);
  });
}

}  // namespace

void bind_cutter(Section& section, CutterCase& cutter) {
  section.table("cutter", "cutter", Need::required, [&](Section& s) {
    Cutter& c = cutter.cutter;
    s.choice<CutterShape>("shape", c.shape,
                          {{"cylindrical", CutterShape::cylindrical},
                           {"ball", CutterShape::ball},
                           {"bull", CutterShape::bull},
                           {"tapered", CutterShape::tapered},
                           {"profile", CutterShape::profile}},
                          "shape of the envelope");
    double diameter = 2.0 * c.radius;
    s.number("diameter_mm", diameter, kMm, up_to(100.0), "diameter");
    c.radius = 0.5 * diameter;
    s.integer("flutes", c.flutes, between(1, 64), "number of flutes");
    s.number("helix_deg", c.helix_angle, kDeg, between(-75.0, 75.0),
             "helix angle at the full radius, > 0 right-hand", Need::optional);
    s.number("rake_deg", c.rake_angle, kDeg, between(-60.0, 60.0), "rake angle", Need::optional);
    std::optional<double> length;
    s.number("cutting_length_mm", length, kMm, positive(), "axial length with edges");
    c.cutting_length = length.value_or(8.0 * diameter);
    if (s.when(c.shape == CutterShape::bull || c.shape == CutterShape::tapered)) {
      s.number("corner_radius_mm", c.corner_radius, kMm, positive(),
               "radius of the corner (bull) or of the ball at the tip (tapered)");
    }
    if (s.when(c.shape == CutterShape::tapered)) {
      s.number("taper_deg", c.taper_angle, kDeg, between(0.0, 80.0), "half angle of the cone");
    }
    if (s.when(c.shape == CutterShape::profile)) {
      s.tables("profile", "points of the profile from the tip up", Need::required,
               [&](Section& point, std::size_t) {
                 ProfileCorner& corner = c.profile.emplace_back();
                 point.number("radius_mm", corner.radius, kMm, non_negative(),
                              "distance from the axis");
                 point.number("z_mm", corner.z, kMm, non_negative(), "height above the tip");
               });
    }
    bind_flutes(s, c);
    bind_provenance(s, cutter.provenance);
  });
}

void bind_bone(Section& section, BoneCase& bone) {
  section.table("bone", "bone", Need::required, [&](Section& s) {
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
    s.number("reference_density_kg_per_m3", bone.density.reference.value, {1.0, "kg/m3"},
             positive(), "apparent density that the law was measured at", Need::optional);
    s.number("density_exponent", bone.density.exponent.value, {}, between(0.0, 4.0),
             "exponent of density over reference density in the force (an assumption)",
             Need::optional);
    bind_provenance(s, bone.provenance);
    s.free_table("identification", "covariance and quality of a law that was identified");
  });
}

std::vector<std::string> caveats_of(const CutterCase& cutter, const BoneCase& bone,
                                    std::optional<double> spindle_speed) {
  std::vector<std::string> texts;
  for (const std::string& text : {bone::caveat("the cutting law", bone.provenance),
                                  bone::caveat("the cutter's geometry", cutter.provenance)}) {
    if (!text.empty()) texts.push_back(text);
  }
  // A degree: what separates neighbouring tested rakes is ten.
  if (bone.rake_angle && std::abs(*bone.rake_angle - cutter.cutter.rake_angle) > units::deg) {
    texts.push_back(
        fmt::format("the law was measured with a rake of {:.3g} deg, the cutter has {:.3g} deg",
                    *bone.rake_angle / units::deg, cutter.cutter.rake_angle / units::deg));
  }
  const double surface_speed = spindle_speed.value_or(0.0) * cutter.cutter.radius;
  if (spindle_speed && bone.speed_range &&
      (surface_speed < 0.99 * (*bone.speed_range)[0] ||
       surface_speed > 1.01 * (*bone.speed_range)[1])) {
    texts.push_back(fmt::format(
        "the law was measured at {:.3g} ... {:.3g} m/s, the cutter's surface runs at {:.3g} m/s",
        (*bone.speed_range)[0], (*bone.speed_range)[1], surface_speed));
  }
  return texts;
}

void bind_cut(Section& section, CutCase& cut) {
  section.table("cut", "cutting condition", Need::required, [&](Section& s) {
    s.number("spindle_speed_rpm", cut.spindle_speed, {units::rpm, "rpm"}, up_to(250000.0),
             "spindle speed");
    s.number("feed_rate_mm_per_min", cut.feed_rate, {units::mm_per_min, "mm/min"}, non_negative(),
             "feed rate");
    s.number("feed_per_tooth_mm", cut.feed_per_tooth, kMm, non_negative(), "feed a tooth");
    s.exactly_one_of({"feed_rate_mm_per_min", "feed_per_tooth_mm"});
    s.number("feed_elevation_deg", cut.feed_elevation, kDeg, between(-90.0, 90.0),
             "feed above the plane normal to the axis; -90 plunges", Need::optional);
    s.number("axial_depth_mm", cut.immersion.axial_depth, kMm, positive(), "axial depth");
    s.choice<ImmersionKind>(
        "immersion", cut.immersion.kind,
        {{"slot", ImmersionKind::slot}, {"up", ImmersionKind::up}, {"down", ImmersionKind::down}},
        "which side is in bone");
    std::optional<double> radial_depth;
    s.number("radial_depth_mm", radial_depth, kMm, positive(),
             "radial depth at the full radius; needed up and down, without meaning in a slot");
    if (!radial_depth && cut.immersion.kind != ImmersionKind::slot) {
      s.fault("radial_depth_mm", "is missing", "set it to the radial depth, or mill a slot");
    }
    cut.immersion.radial_depth = radial_depth.value_or(0.0);
    std::optional<double> angle;
    Feed feed = Feed::parallel;
    s.choice<Feed>("feed_direction", feed,
                   {{"parallel", Feed::parallel}, {"transverse", Feed::transverse}},
                   "feed along the bone's fibres or across them", Need::optional);
    s.number("fibre_angle_deg", angle, kDeg, between(-360.0, 360.0),
             "fibres from the feed towards +y, in place of feed_direction");
    cut.fibre_angle = angle.value_or(feed == Feed::transverse ? 0.5 * std::numbers::pi : 0.0);
    s.number("fibre_elevation_deg", cut.fibre_elevation, kDeg, between(-90.0, 90.0),
             "fibres above the plane normal to the axis", Need::optional);
    s.number("lead_deg", cut.lead, kDeg, between(-60.0, 60.0),
             "lean of the axis towards the feed; the feed then runs along the surface",
             Need::optional);
    s.number("tilt_deg", cut.tilt, kDeg, between(-60.0, 60.0), "lean of the axis towards +y",
             Need::optional);
    if ((cut.lead != 0.0 || cut.tilt != 0.0) && cut.feed_elevation != 0.0) {
      s.fault("feed_elevation_deg", "must be 0 with lead or tilt",
              "the feed of a leaning cutter runs along the surface");
    }
    s.choice<ToothPath>("tooth_path", cut.path,
                        {{"circular", ToothPath::circular}, {"trochoidal", ToothPath::trochoidal}},
                        "path that the chip thickness is worked out on", Need::optional);
  });
}

std::optional<TiltedCut> tilted_cut_of(const CutCase& cut) {
  if (cut.lead == 0.0 && cut.tilt == 0.0) return std::nullopt;
  return TiltedCut{cut.lead, cut.tilt, cut.immersion.axial_depth, cut.immersion.radial_depth,
                   cut.immersion.kind};
}

Condition condition_of(const CutCase& cut, const Cutter& cutter) {
  std::vector<Fault> faults;
  const auto collect = [&](auto&& check_it) {
    try {
      check_it();
    } catch (const InvalidInput& error) {
      faults.insert(faults.end(), error.faults().begin(), error.faults().end());
    }
  };
  Condition condition;
  condition.spindle_speed = cut.spindle_speed;
  condition.feed_per_tooth = cut.feed_per_tooth ? *cut.feed_per_tooth
                                                : feed_per_tooth(cut.feed_rate.value_or(0.0),
                                                                 cut.spindle_speed, cutter.flutes);
  condition.feed_elevation = cut.feed_elevation;
  condition.fibre_T = std::cos(cut.fibre_elevation) * fibre_at_angle(cut.fibre_angle);
  condition.fibre_T.z() = std::sin(cut.fibre_elevation);
  condition.path = cut.path;
  collect([&] { check(cutter); });
  collect([&] { check(condition, cutter); });
  collect([&] { check(cut.immersion, cutter); });
  if (!faults.empty()) throw InvalidInput(faults);
  return condition;
}

}  // namespace osteomill::io
