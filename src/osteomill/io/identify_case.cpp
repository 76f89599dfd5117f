// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/identify_case.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/io/case_file.hpp"
#include "osteomill/io/cutting_section.hpp"
#include "osteomill/io/section.hpp"
#include "osteomill/io/signal_export.hpp"

namespace osteomill::io {
namespace {

using namespace identify;

constexpr Quantity kMm{units::mm, "mm"};
const Need kOptional = Need::optional;

enum class Select { automatic, given };

struct ModelKeys {
  LawForm law = LawForm::polynomial;
  int shear_order = 0;
  int edge_order = 0;
  bool edge_force = false;
  bool directional = false;
};

struct BoundKeys {
  std::string coefficient;
  std::optional<double> low, high;
};

struct Keys {
  ExperimentsCase experiments;
  CutterCase cutter;
  ExperimentDefaults cut;
  IdentifyMethod method = IdentifyMethod::automatic;
  Select select = Select::automatic;
  ModelKeys model;
  bool model_given = false;
  std::vector<ModelKeys> compare;
  std::vector<BoundKeys> bounds;
  SelectionOptions options;
  RunOutCase run_out;
  bone::Provenance provenance{.obtained = bone::Obtained::measured,
                              .source = {},
                              .specimen = {},
                              .condition = {},
                              .uncertainty = {},
                              .note = {}};
};

void bind_model_keys(Section& s, ModelKeys& m) {
  s.choice<LawForm>(
      "law", m.law,
      {{"polynomial", LawForm::polynomial},
       {"linear", LawForm::linear},
       {"power", LawForm::power},
       {"log", LawForm::log}},
      "form of the law; polynomial: of kappa, edge force per length of edge; linear: per width",
      kOptional);
  s.integer("shear_order", m.shear_order, between(-1, 6),
            "polynomial: order of the pressures in kappa; -1: none", kOptional);
  s.integer("edge_order", m.edge_order, between(-1, 6),
            "polynomial: order of the edge forces in kappa; -1: none", kOptional);
  s.flag("edge_force", m.edge_force, "power: with a constant edge force");
  s.flag("directional", m.directional, "power and log: one law along the fibres, one across");
}

ForceModel model_of(const ModelKeys& m) {
  ForceModel model;
  model.form = m.law;
  if (is_linear(model)) {
    model.shear_order = m.shear_order;
    model.edge_order = m.edge_order;
  }
  model.edge_force = m.law == LawForm::power && m.edge_force;
  model.directional = m.directional && !is_linear(model);
  return model;
}

void check_model(Section& s, const ModelKeys& m) {
  if (is_linear(model_of(m)) && m.shear_order < 0 && m.edge_order < 0) {
    s.fault("edge_order", "leaves a law without any force", "set one of the orders to 0 or more");
  }
  if (m.law == LawForm::linear && (m.shear_order > 0 || m.edge_order > 0)) {
    s.fault("law", "is linear and takes orders 0 or -1", "set law = \"polynomial\"");
  }
}

void bind_model(Section& section, Keys& keys) {
  section.table(
      "model", "which laws are tried, and how they are fitted", kOptional, [&](Section& s) {
        s.choice<IdentifyMethod>("method", keys.method,
                                 {{"auto", IdentifyMethod::automatic},
                                  {"mean-forces", IdentifyMethod::mean_forces},
                                  {"instantaneous", IdentifyMethod::instantaneous}},
                                 "auto: mean forces, and where records tell the rotation the "
                                 "instantaneous method beside them",
                                 kOptional);
        s.choice<Select>("select", keys.select,
                         {{"auto", Select::automatic}, {"given", Select::given}},
                         "auto: all laws that suit the cutter; given: the one below, or those of "
                         "[[model.compare]]",
                         kOptional);
        keys.model_given = s.has("law") || s.has("shear_order") || s.has("edge_order");
        bind_model_keys(s, keys.model);
        check_model(s, keys.model);
        s.tables("compare", "laws to compare", kOptional, [&](Section& one, std::size_t) {
          bind_model_keys(one, keys.compare.emplace_back());
          check_model(one, keys.compare.back());
        });
        s.table("reference", "a law that is judged beside the chosen one", kOptional,
                [&](Section& one) {
                  ModelKeys reference;
                  bind_model_keys(one, reference);
                  check_model(one, reference);
                  keys.options.reference = model_of(reference);
                });
        s.integer("largest_shear_order", keys.options.largest_shear_order, between(-1, 6),
                  "auto: highest order of the pressures that is tried", kOptional);
        s.integer("largest_edge_order", keys.options.largest_edge_order, between(-1, 6),
                  "auto: highest order of the edge forces that is tried", kOptional);
        s.choice<RankBy>("rank_by", keys.options.rank_by,
                         {{"leave-one-out", RankBy::leave_one_out},
                          {"leave-one-group-out", RankBy::leave_one_group_out}},
                         "what is left out of a fit and predicted", kOptional);
        FitOptions& fit = keys.options.fit;
        s.choice<Weighting>("weights", fit.weighting,
                            {{"auto", Weighting::automatic},
                             {"equal", Weighting::equal},
                             {"standard-errors", Weighting::standard_errors}},
                            "auto: by standard errors where the table has them all", kOptional);
        s.choice<Loss>("loss", fit.loss,
                       {{"squares", Loss::squares}, {"huber", Loss::huber}, {"tukey", Loss::tukey}},
                       "robust losses count outliers less", kOptional);
        s.number("ridge", fit.ridge, {}, non_negative(),
                 "penalty on large coefficients of polynomial laws; 1 weighs as much as the data",
                 kOptional);
        s.number("confidence", fit.confidence, {}, between(0.5, 0.9999), "of every interval",
                 kOptional);
        s.tables("bound", "limits of coefficients", kOptional, [&](Section& one, std::size_t) {
          BoundKeys& bound = keys.bounds.emplace_back();
          one.text("coefficient", bound.coefficient, "name, as Ktc");
          one.number("low", bound.low, {}, any(), "least value, in the unit of the coefficient");
          one.number("high", bound.high, {}, any(), "largest value");
        });
      });
}

void bind(Section& section, Keys& keys) {
  bind_experiments(section, keys.experiments);
  bind_cutter(section, keys.cutter);
  section.table("cut", "what the table leaves out", kOptional, [&](Section& s) {
    ExperimentDefaults& c = keys.cut;
    using cutting::ImmersionKind;
    s.choice<ImmersionKind>(
        "immersion", c.immersion.kind,
        {{"slot", ImmersionKind::slot}, {"up", ImmersionKind::up}, {"down", ImmersionKind::down}},
        "which side is in bone", kOptional);
    s.number("radial_depth_mm", c.immersion.radial_depth, kMm, non_negative(),
             "radial depth at the full radius, up and down", kOptional);
    s.number("axial_depth_mm", c.immersion.axial_depth, kMm, non_negative(), "axial depth",
             kOptional);
    s.number("feed_per_tooth_mm", c.feed_per_tooth, kMm, non_negative(), "feed a tooth", kOptional);
    s.number("spindle_speed_rpm", c.spindle_speed, {units::rpm, "rpm"}, non_negative(),
             "spindle speed", kOptional);
    s.number("fibre_angle_deg", c.fibre_angle, {units::deg, "deg"}, between(-360.0, 360.0),
             "fibres from the feed towards +y", kOptional);
  });
  bind_model(section, keys);
  section.table("run_out", "what is known of the cutter's run-out in mean forces", kOptional,
                [&](Section& s) {
                  s.choice<RunOutFrom>("from", keys.run_out.from,
                                       {{"auto", RunOutFrom::automatic},
                                        {"cutter", RunOutFrom::cutter},
                                        {"records", RunOutFrom::records}},
                                       "auto: [cutter] where it states one, else the revolutions "
                                       "of the records",
                                       kOptional);
                  s.number("standard_error_um", keys.run_out.standard_error, {units::um, "um"},
                           between(0.0, 500.0), "of each component of what [cutter] states",
                           kOptional);
                  s.number("bound_um", keys.run_out.bound, {units::um, "um"}, between(0.0, 500.0),
                           "the largest it may be where nobody measured it: goes into the "
                           "intervals",
                           kOptional);
                });
  section.table("result", "what the catalogue entry says of itself", kOptional, [&](Section& s) {
    s.text("source", keys.provenance.source, "laboratory, or key of the bibliography", kOptional);
    s.text("specimen", keys.provenance.specimen, "which bone of which animal", kOptional);
    s.text("condition", keys.provenance.condition, "wetness, temperature, machine", kOptional);
    s.text("note", keys.provenance.note, "what a user has to know", kOptional);
  });
}

/// Bounds are given in the unit of their coefficient, which the first model that has it tells.
std::vector<Bound> bounds_of(const Keys& keys, const std::vector<ForceModel>& models) {
  std::vector<Bound> bounds;
  FaultList faults;
  for (const BoundKeys& one : keys.bounds) {
    faults.gather([&] {
      for (const ForceModel& model : models) {
        for (const CoefficientKey& key : coefficients_of(model)) {
          if (key.name != one.coefficient) continue;
          const double factor = factor_of(key.dimension);
          Bound& bound = bounds.emplace_back(Bound{one.coefficient});
          if (one.low) bound.low = *one.low * factor;
          if (one.high) bound.high = *one.high * factor;
          return;
        }
      }
      throw InvalidInput(Fault{"model.bound", one.coefficient, "is no coefficient of any model",
                               "e.g. Ktc; osteomill identify prints the names"});
    });
  }
  faults.raise();
  return bounds;
}

/// The law that revolutions are fitted with: that of the case where it has one, otherwise the
/// linear one.
std::vector<UnitForce> units_of(const IdentifyCase& input) {
  const ForceModel model = input.models.size() == 1 ? input.models.front() : ForceModel{};
  if (model.directional) {
    if (input.method != IdentifyMethod::instantaneous) return linear_law_units();
    throw InvalidInput(Fault{"model.directional", "true",
                             "is not known to the instantaneous method",
                             "set method = \"mean-forces\", or directional = false"});
  }
  if (model.form == LawForm::power) return power_law_units(model.edge_force);
  if (model.form == LawForm::log) return log_law_units();
  if (model.form == LawForm::polynomial) {
    return polynomial_law_units(model.shear_order, model.edge_order);
  }
  std::vector<UnitForce> units = linear_law_units();
  std::erase_if(units, [&](const UnitForce& unit) {
    const bool shear = unit.kind == UnitForce::Kind::shear;
    return shear ? model.shear_order < 0 : model.edge_order < 0;
  });
  return units;
}

}  // namespace

void bind_identify(Section& section) {
  Keys keys;
  bind(section, keys);
}

SignalsFile record_signals(const IdentifyCase& input) {
  SignalsFile out;
  load_experiments(
      input.source, input.defaults, [&](const ForceRecord& raw, const LoadedExperiment& one) {
        const CutOfRecord cut{one.experiment.condition.spindle_speed, one.experiment.cutter.flutes};
        out.runs.push_back(signals_of(raw, *one.processed, input.chain, cut, one.experiment.name));
      });
  return out;
}

IdentifyCase read_identify_case(const CaseRun& run) {
  Keys keys;
  IdentifyCase result;
  result.expanded = Section::read(run, [&](Section& section) { bind(section, keys); });
  cutting::check(keys.cutter.cutter);
  keys.cut.cutter = keys.cutter.cutter;
  // The steps are drawn for the first record: the others are treated alike.
  const auto seen = [&](const ForceRecord& raw, const LoadedExperiment& one) {
    if (!result.signal_figures.empty()) return;
    result.signal_figures =
        figures_of(raw, *one.processed, one.experiment.cutter.flutes, one.experiment.name);
  };
  result.source = keys.experiments;
  result.defaults = keys.cut;
  result.loaded = load_experiments(keys.experiments, keys.cut, seen);
  for (const LoadedExperiment& one : result.loaded) result.experiments.push_back(one.experiment);
  result.chain = keys.experiments.signals.chain;
  result.method = keys.method;
  result.options = keys.options;
  result.table = keys.experiments.table.filename().string();
  result.provenance = keys.provenance;
  if (!keys.compare.empty()) {
    for (const ModelKeys& one : keys.compare) result.models.push_back(model_of(one));
  } else if (keys.model_given || keys.select == Select::given) {
    result.models = {model_of(keys.model)};
  } else {
    result.models = models_to_try(result.experiments, keys.options);
  }
  result.options.fit.bounds = bounds_of(keys, result.models);
  result.run_out = keys.run_out;
  result.units = units_of(result);
  return result;
}

}  // namespace osteomill::io
