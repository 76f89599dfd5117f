// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/vibration_case.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "osteomill/base/units.hpp"
#include "osteomill/io/case_file.hpp"
#include "osteomill/io/section.hpp"
#include "osteomill/vibration/cutter_beam.hpp"
#include "osteomill/vibration/linearised_cut.hpp"

namespace osteomill::io {
namespace {

using namespace vibration;

constexpr Quantity kMm{units::mm, "mm"};
constexpr Quantity kRpm{units::rpm, "rpm"};
constexpr Quantity kDeg{units::deg, "deg"};
constexpr Quantity kNPerMm{units::n_per_mm, "N/mm"};
constexpr Quantity kNPerMm2{units::n_per_mm2, "N/mm2"};

void bind_options(Section& section, ModesCase& one) {
  section.table("options", "how to solve", Need::optional, [&](Section& s) {
    s.choice<bool>("method", one.exact, {{"exact", true}, {"finite-element", false}},
                   "exact: distributed-parameter Euler-Bernoulli beam", Need::optional);
    s.integer("modes", one.modes, between(1, 24), "number of modes", Need::optional);
    s.integer("elements", one.elements.elements, between(2, 400), "number of finite elements",
              Need::optional);
    s.choice<BeamTheory>(
        "theory", one.elements.theory,
        {{"euler-bernoulli", BeamTheory::euler_bernoulli}, {"timoshenko", BeamTheory::timoshenko}},
        "theory of the finite elements", Need::optional);
    s.choice<Mesh>("mesh", one.elements.mesh, {{"aligned", Mesh::aligned}, {"equal", Mesh::equal}},
                   "aligned: a node at every step and support", Need::optional);
    s.number("spindle_speed_rpm", one.spindle_speed, kRpm, non_negative(),
             "speed for the whirl frequencies; 0: none", Need::optional);
  });
}

/// Speeds as a list or as a range.
void bind_speeds(Section& s, std::vector<double>& speeds) {
  std::vector<double> range;
  int count = 200;
  s.numbers("spindle_speeds_rpm", speeds, kRpm, positive(), "spindle speeds", Need::optional);
  s.numbers("spindle_speed_range_rpm", range, kRpm, positive(),
            "lowest and highest spindle speed, in place of a list", Need::optional);
  s.integer("spindle_speed_count", count, between(2, 5000), "number of speeds in the range",
            Need::optional);
  if (range.size() == 2 && range[0] < range[1] && speeds.empty()) {
    for (int i = 0; i < count; ++i) {
      speeds.push_back(range[0] + (range[1] - range[0]) * i / (count - 1));
    }
  } else if (!range.empty() && speeds.empty()) {
    s.fault("spindle_speed_range_rpm", "must be two speeds, the lower first");
  } else if (range.empty() == speeds.empty()) {
    s.fault("spindle_speeds_rpm", "needs either this list or spindle_speed_range_rpm");
  }
}

/// [cut] with constant coefficients.
struct CoefficientCut {
  int flutes = 2;
  cutting::ImmersionKind immersion = cutting::ImmersionKind::slot;
  std::optional<double> share;
  EdgeStiffness stiffness;
  double helix = 0.0;
  std::optional<double> diameter;
};

void bind_coefficient_cut(Section& section, CoefficientCut& cut) {
  using cutting::ImmersionKind;
  section.table("cut", "cut with constant coefficients", Need::required, [&](Section& s) {
    s.integer("flutes", cut.flutes, between(1, 64), "number of flutes");
    s.choice<ImmersionKind>(
        "immersion", cut.immersion,
        {{"slot", ImmersionKind::slot}, {"up", ImmersionKind::up}, {"down", ImmersionKind::down}},
        "which side is in bone");
    s.number("radial_immersion", cut.share, {}, up_to(1.0),
             "radial depth over diameter; needed up and down");
    if (!cut.share && cut.immersion != ImmersionKind::slot) {
      s.fault("radial_immersion", "is missing", "set it to the radial depth over the diameter");
    }
    s.number("tangential_coefficient_n_per_mm2", cut.stiffness.tangential, kNPerMm2, any(),
             "tangential cutting coefficient");
    s.number("radial_coefficient_n_per_mm2", cut.stiffness.radial, kNPerMm2, any(),
             "radial cutting coefficient");
    s.number("helix_deg", cut.helix, kDeg, between(-75.0, 75.0), "helix angle", Need::optional);
    s.number("diameter_mm", cut.diameter, kMm, positive(), "diameter; needed with a helix");
    if (cut.helix != 0.0 && !cut.diameter) {
      s.fault("diameter_mm", "is missing", "a helix needs the diameter");
    }
  });
}

struct StabilityTables {
  CoefficientCut coefficients;
  CutterCase cutter;
  BoneCase bone;
  CutCase cut;
  double thinnest_chip = 0.5e-6;
};

void bind(Section& section, StabilityCase& one, StabilityTables& tables) {
  const bool in_bone = section.has("bone");
  if (section.when(in_bone)) bind_cutter(section, tables.cutter);
  bind_structure(section, one.structure, &tables.cutter.cutter);
  if (section.when(in_bone)) {
    bind_bone(section, tables.bone);
    bind_cut(section, tables.cut);
  }
  if (section.when(!in_bone)) bind_coefficient_cut(section, tables.coefficients);
  section.table("options", "how to solve", Need::required, [&](Section& s) {
    StabilityOptions& o = one.options;
    s.choice<StabilityMethod>("method", o.method,
                              {{"semi-discretisation", StabilityMethod::semi_discretisation},
                               {"full-discretisation", StabilityMethod::full_discretisation},
                               {"collocation", StabilityMethod::collocation},
                               {"multi-frequency", StabilityMethod::multi_frequency},
                               {"zero-order", StabilityMethod::zero_order}},
                              "method", Need::optional);
    bind_speeds(s, one.speeds);
    s.number("max_depth_mm", o.max_depth, kMm, positive(), "largest axial depth of interest");
    s.integer("steps", o.steps, between(0, 4000), "of a tooth period; 0: by the fastest mode",
              Need::optional);
    s.integer("harmonics", o.harmonics, between(0, 40), "multi-frequency: beyond the modes",
              Need::optional);
    s.flag("continuation", one.continuation,
           "follow the boundary from speed to speed instead of scanning each");
    s.integer("map_depths", one.map_depths, between(0, 1000),
              "depths of a map of the spectral radius; 0: no map", Need::optional);
    s.integer("judge", one.judge, between(0, 1000),
              "speeds of the list at which a simulation in time judges the limit from both sides",
              Need::optional);
    s.number("thinnest_chip_um", tables.thinnest_chip, {units::um, "um"}, positive(),
             "chip below which a law of bone is not linearised", Need::optional);
    const bool frequency_domain =
        o.method == StabilityMethod::multi_frequency || o.method == StabilityMethod::zero_order;
    if (frequency_domain && (one.continuation || one.map_depths > 0)) {
      s.fault("method", "has no Floquet multiplier, which continuation and map need",
              "use \"semi-discretisation\"");
    }
  });
}

void bind(Section& section, RespondCase& one, CutterCase& cutter, CutCase& cut) {
  bind_cutter(section, cutter);
  bind_structure(section, one.structure, &cutter.cutter);
  bind_bone(section, one.bone);
  bind_cut(section, cut);
  section.table("options", "what to sweep", Need::required, [&](Section& s) {
    bind_speeds(s, one.speeds);
    s.numbers("feed_rates_mm_per_s", one.feed_rates, {units::mm_per_s, "mm/s"}, positive(),
              "feed rates; none: that of the cut", Need::optional);
    s.integer("harmonics", one.harmonics, between(1, 20),
              "harmonics of the tooth passing among the resonance speeds", Need::optional);
    s.number("calm_amplification", one.calm_amplification, {}, Range{1.0},
             "largest ratio of the vibration to the static deflection at a recommended speed",
             Need::optional);
  });
}

}  // namespace

void bind_beam(Section& section, Beam& beam) {
  section.table(
      "beam", "tool as a beam from the chuck to the tip", Need::required, [&](Section& s) {
        s.number("youngs_modulus_gpa", beam.youngs_modulus, {units::gpa, "GPa"}, positive(),
                 "Young's modulus");
        s.number("density_kg_per_m3", beam.density, {1.0, "kg/m3"}, positive(), "density");
        s.number("poissons_ratio", beam.poissons_ratio, {}, between(0.0, 0.49), "Poisson's ratio",
                 Need::optional);
        s.tables(
            "segments", "uniform pieces, from the chuck to the tip", Need::required,
            [&](Section& t, std::size_t) {
              BeamSegment piece;
              t.number("length_mm", piece.length, kMm, positive(), "length");
              t.number("diameter_mm", piece.diameter, kMm, positive(), "outer diameter");
              t.number("inner_diameter_mm", piece.inner_diameter, kMm, non_negative(), "bore",
                       Need::optional);
              t.number("effective_diameter_factor", piece.effective_diameter_factor, {}, up_to(1.0),
                       "effective over outer diameter of a fluted piece", Need::optional);
              t.number("tube_outer_diameter_mm", piece.tube_outer_diameter, kMm, non_negative(),
                       "tube that bends with the shaft; 0: none", Need::optional);
              t.number("tube_inner_diameter_mm", piece.tube_inner_diameter, kMm, non_negative(),
                       "bore of the tube", Need::optional);
              beam.segments.push_back(piece);
            });
        s.tables("supports", "what holds it", Need::required, [&](Section& t, std::size_t) {
          Support support;
          t.number("at_mm", support.position, kMm, non_negative(), "distance from the chuck end");
          t.choice<SupportType>("type", support.type,
                                {{"clamp", SupportType::clamp},
                                 {"pin", SupportType::pin},
                                 {"spring", SupportType::spring}},
                                "kind of support");
          t.number("stiffness_n_per_mm", support.stiffness, kNPerMm, non_negative(),
                   "of a spring, against deflection", Need::optional);
          t.number("rotational_stiffness_nm_per_rad", support.rotational_stiffness,
                   {1.0, "N m/rad"}, non_negative(), "of a spring, against slope", Need::optional);
          beam.supports.push_back(support);
        });
      });
}

void bind_structure(Section& section, StructureCase& structure, const cutting::Cutter* cutter) {
  Beam beam;
  std::vector<Mode> modes;
  double damping = 0.02;
  int beam_modes = 2;
  section.table("structure", "what vibrates", Need::required, [&](Section& s) {
    s.tables("modes", "modes at the tip, one by one", Need::optional, [&](Section& m, std::size_t) {
      Mode mode;
      bind_direction(m, mode.direction_x, mode.direction_y);
      m.number("frequency_hz", mode.frequency_hz, {1.0, "Hz"}, positive(),
               "undamped natural frequency");
      m.number("damping_ratio", mode.damping_ratio, {}, between(1e-6, 0.99),
               "damping over critical damping");
      std::optional<double> mass, stiffness;
      m.number("modal_mass_kg", mass, {1.0, "kg"}, positive(), "modal mass at the tip");
      m.number("stiffness_n_per_mm", stiffness, kNPerMm, positive(),
               "modal stiffness at the tip, in place of the mass");
      m.exactly_one_of({"modal_mass_kg", "stiffness_n_per_mm"});
      const double omega = 2.0 * std::numbers::pi * mode.frequency_hz;
      mode.modal_mass = mass.value_or(stiffness.value_or(0.0) / (omega * omega));
      modes.push_back(mode);
    });
    bind_measured(s, structure.measured);
    s.number("damping_ratio", damping, {}, between(1e-6, 0.99),
             "of every mode of the [beam]; assumed unless measured", Need::optional);
    s.integer("beam_modes", beam_modes, between(1, 12), "modes of the [beam] to take",
              Need::optional);
  });
  bool has_beam = section.has("beam");
  if (section.when(has_beam)) bind_beam(section, beam);
  const bool measured = !structure.measured.empty();
  if (!has_beam && modes.empty() && !measured && cutter && cutter->shank) {
    has_beam = true;
    // Faults of the cutter are raised with its other ones.
    FaultList raised_elsewhere;
    raised_elsewhere.gather([&] { beam = beam_of(*cutter); });
  }
  if (static_cast<int>(has_beam) + static_cast<int>(!modes.empty()) + static_cast<int>(measured) >
      1) {
    section.fault("structure", "has more than one of modes, measured and [beam]", "keep one");
  } else if (!has_beam && modes.empty() && !measured) {
    section.fault("structure", "has no modes",
                  "list them in structure.modes, name a measurement in structure.measured or "
                  "describe the tool in [beam] or [cutter.shank]");
  } else if (has_beam && !beam.segments.empty()) {
    const BeamModel model(beam, {});
    for (const bool y : {false, true}) {
      const auto in_one =
          tip_modes(model, length(beam), beam_modes, damping, y ? 0.0 : 1.0, y ? 1.0 : 0.0);
      modes.insert(modes.end(), in_one.begin(), in_one.end());
    }
    structure.caveats.push_back(fmt::format(
        "the damping ratio {:g} of the beam's modes is assumed unless it was measured", damping));
  }
  structure.modes = modes;
}

void complete(StructureCase& structure) {
  if (structure.measured.empty()) {
    structure.receptance = [modes = structure.modes](double f) { return tip_receptance(modes, f); };
    return;
  }
  MeasuredStructure measured = measured_structure(structure.measured);
  structure.modes = std::move(measured.modes);
  structure.receptance = std::move(measured.receptance);
  structure.caveats.insert(structure.caveats.end(), measured.caveats.begin(),
                           measured.caveats.end());
}

void bind_modes(Section& section) {
  ModesCase one;
  ImpactTable impact;
  CutterCase cutter;
  bind_impact(section, impact);
  bind_beam(section, one.beam);
  bind_cutter(section, cutter);
  bind_options(section, one);
}

ModesCase read_modes_case(const CaseRun& run) {
  ModesCase one;
  ImpactTable impact;
  const bool measured = run.tree.values.contains("impact");
  const bool of_cutter = !run.tree.values.contains("beam") && run.tree.values.contains("cutter");
  CutterCase cutter;
  one.expanded = Section::read(run, [&](Section& section) {
    if (measured) return bind_impact(section, impact);
    if (of_cutter) bind_cutter(section, cutter);
    if (!of_cutter) bind_beam(section, one.beam);
    bind_options(section, one);
  });
  if (of_cutter && !measured) {
    cutting::check(cutter.cutter);
    one.beam = beam_of(cutter.cutter);
  }
  if (measured) {
    one.impact = impact_of(impact);
  } else {
    check(one.beam);
  }
  return one;
}

void bind_stability(Section& section) {
  StabilityCase one;
  StabilityTables tables;
  bind(section, one, tables);
}

StabilityCase read_stability_case(const CaseRun& run) {
  StabilityCase one;
  StabilityTables tables;
  one.expanded = Section::read(run, [&](Section& section) { bind(section, one, tables); });
  complete(one.structure);
  one.caveats = one.structure.caveats;
  if (run.tree.values.contains("bone")) {
    const cutting::Condition condition = condition_of(tables.cut, tables.cutter.cutter);
    settle(tables.bone, tables.cutter.cutter, condition.spindle_speed);
    one.cut = linearised_cut(tables.cutter.cutter, tables.bone.law, condition, tables.cut.immersion,
                             tables.thinnest_chip);
    one.depth = tables.cut.immersion.axial_depth;
    one.speed = tables.cut.spindle_speed;
    const auto more = caveats_of(tables.cutter, tables.bone);
    one.caveats.insert(one.caveats.end(), more.begin(), more.end());
  } else {
    const CoefficientCut& c = tables.coefficients;
    const ContactAngles contact = contact_angles(c.immersion, c.share.value_or(1.0));
    const double lag = c.helix == 0.0 ? 0.0 : std::tan(c.helix) / (0.5 * c.diameter.value_or(1.0));
    one.cut.emplace(c.flutes, contact.entry, contact.exit, lag, c.stiffness);
  }
  return one;
}

void bind_respond(Section& section) {
  RespondCase one;
  CutterCase cutter;
  CutCase cut;
  bind(section, one, cutter, cut);
}

RespondCase read_respond_case(const CaseRun& run) {
  RespondCase one;
  CutterCase cutter;
  CutCase cut;
  one.expanded = Section::read(run, [&](Section& section) { bind(section, one, cutter, cut); });
  complete(one.structure);
  one.condition = condition_of(cut, cutter.cutter);
  settle(one.bone, cutter.cutter, one.condition.spindle_speed);
  one.cutter = cutter.cutter;
  one.immersion = cut.immersion;
  if (one.feed_rates.empty()) {
    one.feed_rates = {cutting::feed_rate(one.condition, one.cutter.flutes)};
  }
  one.caveats = one.structure.caveats;
  const auto more = caveats_of(cutter, one.bone);
  one.caveats.insert(one.caveats.end(), more.begin(), more.end());
  return one;
}

}  // namespace osteomill::io
