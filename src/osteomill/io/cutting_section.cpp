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

enum class Feed { parallel, transverse };

constexpr Quantity kMm{units::mm, "mm"};
constexpr Quantity kDeg{units::deg, "deg"};
constexpr Quantity kNPerMm{units::n_per_mm, "N/mm"};

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

/// The keys of apt that other shapes do not have; the cutter's radius is that of its top.
void bind_apt(Section& s, Cutter& c, double diameter) {
  c.apt.diameter = diameter;
  c.apt.side_angle = c.taper_angle;
  s.number("corner_centre_radius_mm", c.apt.corner_r, kMm, non_negative(),
           "of the corner's centre, from the axis");
  s.number("corner_centre_height_mm", c.apt.corner_z, kMm, non_negative(),
           "of the corner's centre, above the tip");
  s.number("bottom_deg", c.apt.bottom_angle, kDeg, between(0.0, 85.0),
           "of the lower line against the plane normal to the axis", Need::optional);
  // A faulty shape is refused with the other faults of the cutter.
  FaultList raised_elsewhere;
  raised_elsewhere.gather(
      [&] { c.radius = apt_joints(c.apt, c.corner_radius, c.cutting_length).top_radius; });
}

void bind_shank(Section& s, std::optional<Shank>& shank) {
  Shank held;
  const bool there = s.table(
      "shank", "how the cutter is held: for deflection and vibration", Need::optional,
      [&](Section& t) {
        t.number("free_length_mm", held.free_length, kMm, positive(),
                 "from the tip to the holder or bearing");
        t.number("diameter_mm", held.diameter, kMm, positive(), "above the edges");
        t.number("youngs_modulus_gpa", held.youngs_modulus, {units::gpa, "GPa"},
                 between(1.0, 1000.0), "Young's modulus");
        t.number("density_kg_per_m3", held.density, {1.0, "kg/m3"}, between(500.0, 25000.0),
                 "density");
        t.number("effective_diameter_factor", held.effective_diameter_factor, {}, between(0.1, 1.0),
                 "effective over outer diameter of the fluted part", Need::optional);
        t.number("holder_stiffness_n_per_mm", held.holder_stiffness, kNPerMm, non_negative(),
                 "against deflection at the held end; 0: rigid", Need::optional);
        t.number("holder_rotational_stiffness_nm_per_rad", held.holder_rotational_stiffness,
                 {1.0, "N m/rad"}, non_negative(), "against slope at the held end; 0: rigid",
                 Need::optional);
      });
  if (there) shank = held;
}

/// Which part of the cutter is in bone.
void bind_immersion(Section& s, CutCase& cut) {
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
}

void bind_lean(Section& s, CutCase& cut) {
  s.number("lead_deg", cut.lead, kDeg, between(-60.0, 60.0),
           "lean of the axis towards the feed; the feed then runs along the surface",
           Need::optional);
  s.number("tilt_deg", cut.tilt, kDeg, between(-60.0, 60.0), "lean of the axis towards +y",
           Need::optional);
  if ((cut.lead != 0.0 || cut.tilt != 0.0) && cut.feed_elevation != 0.0) {
    s.fault("feed_elevation_deg", "must be 0 with lead or tilt",
            "the feed of a leaning cutter runs along the surface");
  }
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
                           {"apt", CutterShape::apt},
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
    const bool apt = c.shape == CutterShape::apt;
    const bool tapered = c.shape == CutterShape::tapered;
    if (s.when(c.shape == CutterShape::bull || tapered || apt)) {
      s.number("corner_radius_mm", c.corner_radius, kMm, apt ? non_negative() : positive(),
               "radius of the corner (bull, apt) or of the ball at the tip (tapered)");
    }
    if (s.when(tapered || apt)) {
      s.number("taper_deg", c.taper_angle, kDeg, between(0.0, 80.0),
               "half angle of the cone, or of the upper line of apt",
               tapered ? Need::required : Need::optional);
    }
    if (s.when(apt)) bind_apt(s, c, diameter);
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
    bind_shank(s, c.shank);
    bind_provenance(s, cutter.provenance);
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
  texts.insert(texts.end(), bone.notes.begin(), bone.notes.end());
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

void bind_cut(Section& section, CutCase& cut, bool nominal) {
  section.table("cut", "cutting condition", Need::required, [&](Section& s) {
    s.number("spindle_speed_rpm", cut.spindle_speed, {units::rpm, "rpm"}, up_to(250000.0),
             "spindle speed");
    s.number("feed_rate_mm_per_min", cut.feed_rate, {units::mm_per_min, "mm/min"}, non_negative(),
             "feed rate");
    s.number("feed_per_tooth_mm", cut.feed_per_tooth, kMm, non_negative(), "feed a tooth");
    s.exactly_one_of({"feed_rate_mm_per_min", "feed_per_tooth_mm"});
    s.number("feed_elevation_deg", cut.feed_elevation, kDeg, between(-90.0, 90.0),
             "feed above the plane normal to the axis; -90 plunges", Need::optional);
    if (s.when(nominal)) bind_immersion(s, cut);
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
    if (s.when(nominal)) bind_lean(s, cut);
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

Condition condition_of(const CutCase& cut, const Cutter& cutter, bool nominal) {
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
  if (nominal) collect([&] { check(cut.immersion, cutter); });
  if (!faults.empty()) throw InvalidInput(faults);
  return condition;
}

}  // namespace osteomill::io
