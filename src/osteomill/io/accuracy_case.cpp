// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/accuracy_case.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "osteomill/base/units.hpp"
#include "osteomill/io/case_file.hpp"
#include "osteomill/io/catalogue.hpp"
#include "osteomill/io/section.hpp"
#include "osteomill/io/tool_section.hpp"
#include "osteomill/vibration/cutter_beam.hpp"

namespace osteomill::io {
namespace {

using namespace accuracy;

constexpr Quantity kMm{units::mm, "mm"};
constexpr Quantity kDeg{units::deg, "deg"};
constexpr Quantity kRpm{units::rpm, "rpm"};
constexpr Quantity kGpa{units::gpa, "GPa"};

struct DeflectTables {
  CutterCase cutter;
  CutCase cut;
  ToolCase tool;
  vibration::Beam beam;
  StructureCase structure;
  SurfaceCase surface;
  BudgetCase budget;
};

void bind_budget(Section& section, BudgetCase& budget) {
  budget.half_window = 3.0 * units::deg;
  section.table("budget", "other sources of angular error", Need::optional, [&](Section& s) {
    s.number("half_window_deg", budget.half_window, kDeg, positive(),
             "half of the window that the total shall stay in", Need::optional);
    s.integer("samples", budget.samples, between(100, 10000000), "of the Monte Carlo",
              Need::optional);
    s.integer("seed", budget.seed, between(0, 2000000000), "of the Monte Carlo", Need::optional);
    s.tables("sources", "independent sources", Need::required, [&](Section& t, std::size_t) {
      ErrorSource source, other;
      t.text("name", source.name, "name of the source");
      t.number("varus_valgus_deg", source.spread, kDeg, non_negative(),
               "spread in the frontal plane", Need::optional);
      t.number("flexion_extension_deg", other.spread, kDeg, non_negative(),
               "spread in the sagittal plane", Need::optional);
      t.number("varus_valgus_bias_deg", source.bias, kDeg, any(), "mean in the frontal plane",
               Need::optional);
      t.number("flexion_extension_bias_deg", other.bias, kDeg, any(), "mean in the sagittal plane",
               Need::optional);
      t.choice<ErrorShape>("shape", source.shape,
                           {{"normal", ErrorShape::normal},
                            {"uniform", ErrorShape::uniform},
                            {"triangular", ErrorShape::triangular}},
                           "normal: spread is the standard deviation; else the half width",
                           Need::optional);
      t.integer("times", source.times, between(1, 1000), "how often it enters independently",
                Need::optional);
      std::optional<double> load, load_sd, compliance, other_compliance;
      t.number("load_n", load, {1.0, "N"}, any(), "mean load on what gives way: fixation, guide");
      t.number("load_sd_n", load_sd, {1.0, "N"}, non_negative(), "standard deviation of the load");
      t.number("varus_valgus_deg_per_n", compliance, kDeg, non_negative(),
               "how far a newton turns it in the frontal plane; adds to bias and spread");
      t.number("flexion_extension_deg_per_n", other_compliance, kDeg, non_negative(),
               "the same in the sagittal plane");
      if ((compliance || other_compliance) && !load) {
        t.fault("load_n", "is missing", "a compliance needs the load on it");
      }
      if (load && !compliance && !other_compliance) {
        t.fault("varus_valgus_deg_per_n", "is missing", "a load needs a compliance to act on");
      }
      if (load) {
        if (source.spread != 0.0 || other.spread != 0.0) {
          t.fault("load_n", "stands beside a spread", "make two sources of it");
        }
        const auto add = [&](ErrorSource& to, double turn) {
          const ErrorSource part =
              source_from_compliance(source.name, *load, load_sd.value_or(0.0), turn);
          to.bias += part.bias;
          to.spread = part.spread;
        };
        add(source, compliance.value_or(0.0));
        add(other, other_compliance.value_or(0.0));
      }
      other.name = source.name;
      other.shape = source.shape;
      other.times = source.times;
      budget.varus_valgus.push_back(source);
      budget.flexion_extension.push_back(other);
    });
  });
}

void bind(Section& section, DeflectCase& one, DeflectTables& tables) {
  bind_cutter(section, tables.cutter);
  bind_bone(section, one.bone);
  bind_cut(section, tables.cut);
  const bool has_beam = section.has("beam"), has_tool = section.has("tool");
  const bool has_shank = tables.cutter.cutter.shank.has_value();
  if (section.when(has_tool || !(has_beam || has_shank)))
    bind_tool(section, tables.tool, Need::required);
  if (section.when(section.has("structure"))) {
    bind_structure(section, tables.structure, &tables.cutter.cutter);
  } else if (has_beam) {
    bind_beam(section, tables.beam);
  }
  if (has_beam && has_tool) section.fault("tool", "stands beside a [beam]", "keep one of the two");
  section.table("surface", "cut that a plate comes to lie on", Need::optional, [&](Section& s) {
    s.number("width_mm", tables.surface.width, kMm, positive(),
             "width across the feed's way, medio-lateral");
    s.choice<FeedPattern>("feed", tables.surface.feed,
                          {{"one-way", FeedPattern::one_way}, {"outward", FeedPattern::outward}},
                          "outward: from the middle to both sides", Need::optional);
  });
  bind_budget(section, tables.budget);
  section.table("options", "how to solve", Need::optional, [&](Section& s) {
    s.number("slice_height_mm", one.options.slice_height, kMm, positive(), "of the force slices",
             Need::optional);
    s.integer("steps", one.options.steps, between(12, 36000), "of a revolution", Need::optional);
    s.choice<bool>("model", one.flexible, {{"rigid", false}, {"flexible", true}},
                   "flexible: balances chips and deflection too", Need::optional);
  });
}

struct OptimiseTables {
  BoneCase bone;
  std::vector<CutterCase> cutters;
};

void bind_span(Section& s, const char* key, Span& span, Quantity quantity, const char* meaning,
               Need need = Need::required) {
  std::vector<double> ends;
  s.numbers(key, ends, quantity, positive(), meaning, need);
  if (ends.size() == 1) span = {ends[0], ends[0]};
  if (ends.size() == 2) span = {ends[0], ends[1]};
  if (ends.size() > 2 || (ends.size() == 2 && ends[0] > ends[1])) {
    s.fault(key, "must be one value, or the lowest and the highest");
  }
}

/// A candidate: a catalogue entry, keys of its own over it.
void bind_candidate(Section& t, Candidate& candidate, CutterCase& cutter) {
  t.text("name", candidate.name, "name");
  std::string use;
  t.text("use", use, "entry of the catalogue of cutters to start from", Need::optional);
  if (!use.empty()) {
    try {
      CaseRun entry;
      entry.tree.values["cutter"] = catalogue_entry("cutters", use).values;
      Section::read(entry, [&](Section& section) { bind_cutter(section, cutter); });
    } catch (const InvalidInput& error) {
      t.fault("use", error.faults().front().rule, error.faults().front().remedy);
    }
  }
  cutting::Cutter& c = cutter.cutter;
  std::optional<double> diameter, flutes, helix, length;
  t.number("diameter_mm", diameter, kMm, up_to(100.0), "diameter");
  t.number("flutes", flutes, {}, between(1, 64), "number of flutes");
  t.number("helix_deg", helix, kDeg, between(-75.0, 75.0), "helix angle");
  if (diameter) c.radius = 0.5 * *diameter;
  if (flutes) c.flutes = static_cast<int>(*flutes);
  if (helix) c.helix_angle = *helix;
  if (use.empty() && !diameter) t.fault("diameter_mm", "is missing", "set it, or use an entry");
  t.number("tool_length_mm", candidate.tool_length, kMm, positive(),
           "free length from the tip to the holder or bearing");
  t.number("effective_diameter_factor", candidate.effective_diameter_factor, {}, up_to(1.0),
           "effective over outer diameter in bending", Need::optional);
  t.number("youngs_modulus_gpa", candidate.youngs_modulus, kGpa, positive(), "Young's modulus",
           Need::optional);
  t.number("density_kg_per_m3", candidate.density, {1.0, "kg/m3"}, positive(), "density",
           Need::optional);
  if (c.cutting_length <= 0.0) c.cutting_length = candidate.tool_length;
  candidate.cutter = c;
}

void bind_limits(Section& section, ChoiceProblem& problem) {
  section.table("limits", "upper limits", Need::optional, [&](Section& s) {
    Limits& l = problem.limits;
    s.number("time_s", l.time, {1.0, "s"}, positive(), "time of the job");
    s.number("peak_force_n", l.peak_force, {1.0, "N"}, positive(), "peak resultant force");
    s.number("deflection_mm", l.deflection, kMm, positive(), "total tip deflection");
    s.number("surface_error_mm", l.surface_error, kMm, positive(), "largest surface error");
    s.number("temperature_c", l.temperature, {1.0, "degC"}, positive(),
             "temperature, quick relation");
    s.number("power_w", l.power, {1.0, "W"}, positive(), "mean spindle power");
    s.number("spectral_radius", l.chatter, {}, up_to(1.0), "chatter margin; stable below 1");
    s.number("feed_per_tooth_mm", l.feed_per_tooth, kMm, positive(), "for the roughness",
             Need::optional);
  });
}

void bind_heat(Section& section, ChoiceProblem& problem, std::optional<HeatCalibration>& fit) {
  section.table("heat", "calibration of T = K l omega N/f + T0", Need::optional, [&](Section& s) {
    std::optional<double> coefficient;
    problem.heat.start = 37.0;
    s.number("start_c", problem.heat.start, {1.0, "degC"}, any(), "temperature before the cut",
             Need::optional);
    s.number("coefficient_k", coefficient, {1.0, "K"}, positive(), "K");
    std::vector<HeatObservation> observations;
    s.tables("observations", "measured temperatures, in place of the coefficient", Need::optional,
             [&](Section& t, std::size_t) {
               HeatObservation o;
               t.number("axial_depth_mm", o.edge_length, kMm, positive(), "edge in contact");
               t.number("spindle_speed_rpm", o.spindle_speed, kRpm, positive(), "spindle speed");
               t.integer("flutes", o.flutes, between(1, 64), "number of flutes");
               t.number("feed_rate_mm_per_s", o.feed_rate, {units::mm_per_s, "mm/s"}, positive(),
                        "feed rate");
               t.number("temperature_c", o.temperature, {1.0, "degC"}, any(), "measured");
               observations.push_back(o);
             });
    if (coefficient) problem.heat.coefficient = *coefficient;
    const bool complete = !observations.empty() && observations.front().feed_rate > 0.0;
    if (!coefficient && complete) {
      fit = calibrate(observations, problem.heat.start);
      problem.heat = fit->relation;
    } else if (coefficient.has_value() == !observations.empty()) {
      s.fault("coefficient_k", "needs either this or observations");
    }
  });
}

void bind(Section& section, OptimiseCase& one, OptimiseTables& tables) {
  ChoiceProblem& problem = one.problem;
  section.tables("candidate", "cutters to choose from", Need::required,
                 [&](Section& t, std::size_t) {
                   one.candidates.emplace_back();
                   tables.cutters.emplace_back();
                   bind_candidate(t, one.candidates.back(), tables.cutters.back());
                 });
  bind_bone(section, tables.bone);
  section.table("job", "what to remove", Need::required, [&](Section& s) {
    std::optional<double> volume, area;
    s.number("volume_mm3", volume, {units::mm3, "mm3"}, positive(), "volume of bone");
    s.number("kerf_area_mm2", area, {units::mm2, "mm2"}, positive(),
             "area of a planar cut as wide as the cutter");
    s.exactly_one_of({"volume_mm3", "kerf_area_mm2"});
    problem.volume = volume.value_or(0.0);
    problem.kerf_area = area.value_or(0.0);
  });
  section.table("choose", "what may be chosen: one value, or lowest and highest", Need::required,
                [&](Section& s) {
                  using cutting::ImmersionKind;
                  bind_span(s, "feed_per_tooth_mm", problem.spans[0], kMm, "feed a tooth");
                  bind_span(s, "spindle_speed_rpm", problem.spans[1], kRpm, "spindle speed");
                  bind_span(s, "axial_depth_mm", problem.spans[2], kMm, "axial depth");
                  bind_span(s, "radial_depth_mm", problem.spans[3], kMm,
                            "radial depth; up and down only", Need::optional);
                  s.choice<ImmersionKind>("immersion", problem.immersion,
                                          {{"slot", ImmersionKind::slot},
                                           {"up", ImmersionKind::up},
                                           {"down", ImmersionKind::down}},
                                          "which side is in bone", Need::optional);
                  s.number("fibre_angle_deg", problem.fibre_angle, kDeg, between(-360.0, 360.0),
                           "fibres from the feed towards +y", Need::optional);
                });
  bind_limits(section, problem);
  bind_heat(section, problem, one.heat_fit);
  section.table("options", "goal and extras", Need::optional, [&](Section& s) {
    s.choice<Goal>("goal", problem.goal,
                   {{"time", Goal::time},
                    {"force", Goal::force},
                    {"heat", Goal::heat},
                    {"error", Goal::error}},
                   "what to make smallest", Need::optional);
    s.integer("pareto_points", one.pareto_points, between(0, 200),
              "points of time against surface error; 0: none", Need::optional);
    s.number("damping_ratio", problem.damping_ratio, {}, between(1e-4, 0.9),
             "of the tool's modes, for chatter", Need::optional);
  });
  section.table("compare", "conditions of equal removal rate", Need::optional, [&](Section& s) {
    s.number("removal_rate_mm3_per_s", one.removal_rate, {units::mm3, "mm3/s"}, positive(),
             "removal rate");
    s.number("spindle_speed_rpm", one.compare_speed, kRpm, positive(), "spindle speed");
    s.numbers("axial_depths_mm", one.compare_depths, kMm, positive(), "axial depths");
  });
}

}  // namespace

void bind_deflect(Section& section) {
  DeflectCase one;
  DeflectTables tables;
  bind(section, one, tables);
}

DeflectCase read_deflect_case(const CaseRun& run) {
  DeflectCase one;
  DeflectTables tables;
  one.expanded = Section::read(run, [&](Section& section) { bind(section, one, tables); });
  one.condition = condition_of(tables.cut, tables.cutter.cutter);
  settle(one.bone, tables.cutter.cutter, one.condition.spindle_speed);
  one.cutter = tables.cutter.cutter;
  one.immersion = tables.cut.immersion;
  const double support = tables.tool.support ? 1.0 / *tables.tool.support : 0.0;
  const auto& given = run.tree.values;
  if (given.contains("beam")) {
    // Beside a [structure] its table was read there; here the beam itself is wanted.
    vibration::Beam beam = tables.beam;
    if (beam.segments.empty()) {
      CaseRun alone;
      alone.tree.values["beam"] = given.at("beam");
      Section::read(alone, [&](Section& section) { bind_beam(section, beam); });
    }
    one.tool = ToolCompliance::of_beam(beam, support);
  } else if (!given.contains("tool") && one.cutter.shank) {
    one.tool = ToolCompliance::of_beam(vibration::beam_of(one.cutter), support);
  } else {
    one.tool = compliance_of(tables.tool);
  }
  one.caveats = caveats_of(tables.cutter, one.bone);
  if (given.contains("structure")) {
    one.structure = tables.structure;
    complete(*one.structure);
    one.caveats.insert(one.caveats.end(), one.structure->caveats.begin(),
                       one.structure->caveats.end());
  }
  if (given.contains("surface")) one.surface = tables.surface;
  if (given.contains("budget")) one.budget = tables.budget;
  return one;
}

void bind_optimise(Section& section) {
  OptimiseCase one;
  OptimiseTables tables;
  bind(section, one, tables);
}

OptimiseCase read_optimise_case(const CaseRun& run) {
  OptimiseCase one;
  OptimiseTables tables;
  one.expanded = Section::read(run, [&](Section& section) { bind(section, one, tables); });
  if (!tables.bone.tested.empty() || !tables.bone.low_speed.empty()) {
    throw InvalidInput(Fault{"bone.tested", "", "has no single law for all candidates",
                             "give one law; deflect and force take several"});
  }
  one.problem.law = tables.bone.law;
  check(one.problem, one.candidates);
  one.caveats.clear();
  for (const CutterCase& cutter : tables.cutters) {
    for (const std::string& caveat : caveats_of(cutter, tables.bone)) {
      if (std::find(one.caveats.begin(), one.caveats.end(), caveat) == one.caveats.end()) {
        one.caveats.push_back(caveat);
      }
    }
  }
  return one;
}

}  // namespace osteomill::io
