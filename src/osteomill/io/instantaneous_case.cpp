// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/instantaneous_case.hpp"

#include <fmt/format.h>

#include <cmath>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/identify/revolution_fit.hpp"
#include "osteomill/io/case_file.hpp"
#include "osteomill/io/section.hpp"
#include "osteomill/io/toml_text.hpp"

namespace osteomill::io {
namespace {

using namespace identify;
using Json = nlohmann::ordered_json;

const Need kOptional = Need::optional;

enum class Form { linear, polynomial };

struct Keys {
  InstantaneousCase input;
  CutCase cut;
  Form form = Form::linear;
  int shear_order = 0;
  int edge_order = 0;
  std::optional<double> phase;
};

void bind(Section& section, Keys& keys) {
  InstantaneousCase& input = keys.input;
  section.table(
      "instantaneous", "the record, and what is unknown", Need::required, [&](Section& s) {
        s.file("record", input.record, "forces over time");
        s.choice<Form>("law", keys.form,
                       {{"linear", Form::linear}, {"polynomial", Form::polynomial}},
                       "linear: six coefficients; polynomial: of kappa", kOptional);
        s.integer("shear_order", keys.shear_order, between(0, 6),
                  "polynomial: order of the pressures", kOptional);
        s.integer("edge_order", keys.edge_order, between(0, 6),
                  "polynomial: order of the edge forces", kOptional);
        s.flag("run_out", input.options.run_out, "offset of the axis and its direction are sought");
        s.flag("tilt", input.options.tilt, "and a lean of the axis");
        s.number("phase_deg", keys.phase, {units::deg, "deg"}, between(-360.0, 360.0),
                 "angle of the index at which flute 0 points along +y; else sought");
        s.number("confidence", input.options.confidence, {}, between(0.5, 0.9999),
                 "of every interval", kOptional);
      });
  bind_record_format(section, input.format);
  bind_signals(section, input.signals);
  bind_cutter(section, input.cutter);
  bind_cut(section, keys.cut);
  section.table("result", "what the catalogue entry says of itself", kOptional, [&](Section& s) {
    s.text("source", input.provenance.source, "laboratory, or key of the bibliography", kOptional);
    s.text("specimen", input.provenance.specimen, "which bone of which animal", kOptional);
    s.text("condition", input.provenance.condition, "wetness, temperature, machine", kOptional);
    s.text("note", input.provenance.note, "what a user has to know", kOptional);
  });
}

Json list_of(const Eigen::VectorXd& values) {
  return Json(std::vector<double>(values.begin(), values.end()));
}

Json axes_of(const geometry::Vector3& values) {
  return {{"x", values.x()}, {"y", values.y()}, {"z", values.z()}};
}

/// The law's tables as a case has them.
Json law_tables(const std::vector<UnitForce>& units, const InstantaneousFit& fit) {
  Json law;
  const bool polynomial = numbered(units);
  law["law"] = polynomial ? "polynomial" : "linear";
  law["orientation"] = "none";
  static constexpr const char* kNames[] = {"tangential", "radial", "axial"};
  for (std::size_t i = 0; i < units.size(); ++i) {
    const UnitForce& unit = units[i];
    const Estimate& one = fit.estimates[i];
    const double value = one.value / unit_of(one).factor;
    const int component = static_cast<int>(unit.component);
    const bool shear = unit.kind == UnitForce::Kind::shear;
    if (polynomial) {
      law[shear ? "shear" : "edge"][kNames[component]].push_back(value);
      continue;
    }
    const bool axial = unit.component == ForceComponent::axial;
    // The lateral component points the other way.
    law[axial ? "lateral" : kNames[component]]["any_deg"][shear ? "k" : "edge"] =
        axial ? -value : value;
  }
  return law;
}

}  // namespace

void bind_instantaneous(Section& section) {
  Keys keys;
  bind(section, keys);
}

InstantaneousCase read_instantaneous_case(const CaseRun& run) {
  Keys keys;
  keys.input.expanded = Section::read(run, [&](Section& section) { bind(section, keys); });
  InstantaneousCase& input = keys.input;
  input.condition = condition_of(keys.cut, input.cutter.cutter);
  input.immersion = keys.cut.immersion;
  cutting::check(input.immersion, input.cutter.cutter);
  if (tilted_cut_of(keys.cut)) {
    throw InvalidInput(Fault{"cut.lead_deg", "", "must be 0 with tilt_deg",
                             "the instantaneous method knows upright cutters only"});
  }
  if (!input.signals.dynamometer_frf.empty()) {
    input.signals.chain.dynamometer = read_dynamometer(input.signals.dynamometer_frf);
  }
  if (keys.form == Form::polynomial) {
    input.options.units = polynomial_law_units(keys.shear_order, keys.edge_order);
  }
  input.options.phase = keys.phase;
  return input;
}

InstantaneousResult solve(const InstantaneousCase& input) {
  InstantaneousResult result;
  LoadedRecord loaded = read_force_record(input.record, input.format);
  result.warnings = std::move(loaded.warnings);
  const CutOfRecord cut{input.condition.spindle_speed, input.cutter.cutter.flutes};
  result.processed = process(loaded.record, cut, input.signals.chain);
  result.processed.steps.insert(result.processed.steps.begin(), loaded.notes.begin(),
                                loaded.notes.end());
  result.warnings.insert(result.warnings.end(), result.processed.warnings.begin(),
                         result.processed.warnings.end());
  result.fit = fit_processed(result.processed, input.signals.chain, input.cutter.cutter,
                             input.condition, input.immersion, input.options);
  const Segment& plateau = result.processed.segments.plateau;
  result.forces =
      gather_revolutions(result.processed.record.force.middleRows(plateau.begin, plateau.size()),
                         *result.processed.rotation, input.signals.chain.bins);
  return result;
}

ShownEstimate unit_of(const Estimate& estimate) {
  const std::string& name = estimate.name;
  if (name.front() == 'K' && name[2] == 'c') return {units::n_per_mm2, "N/mm2"};
  if (name.front() == 'K') return {units::n_per_mm, "N/mm"};
  if (name.starts_with("run_out")) return {units::um, "um"};
  if (name.starts_with("tilt")) return {units::um / units::mm, "um/mm"};
  if (name == "phase") return {units::deg, "deg"};
  return {1.0, "N"};
}

Json instantaneous_document(const InstantaneousCase& input, const InstantaneousResult& result) {
  const InstantaneousFit& fit = result.fit;
  Json document;
  document["record"] = input.record.filename().string();
  document["status"] = fit.status == FitStatus::converged ? "converged" : "iteration limit";
  document["revolutions"] =
      result.processed.revolution ? result.processed.revolution->revolutions : 0;
  document["spindle_speed_rpm"] = result.processed.rotation->spindle_speed / units::rpm;
  Json list = Json::array();
  for (const Estimate& one : fit.estimates) {
    const ShownEstimate shown = unit_of(one);
    Json entry = {{"name", one.name}, {"value", one.value / shown.factor}, {"unit", shown.unit}};
    entry["determined"] = one.determined;
    if (one.determined) {
      entry["standard_error"] = one.standard_error / shown.factor;
      entry["low"] = one.low / shown.factor;
      entry["high"] = one.high / shown.factor;
    } else {
      entry["standard_error"] = nullptr;
    }
    list.push_back(entry);
  }
  document["coefficients"] = list;
  document["run_out_um"] = fit.run_out.offset / units::um;
  document["run_out_angle_deg"] = fit.run_out.offset_angle / units::deg;
  document["phase_deg"] = fit.phase / units::deg;
  document["residual_rms_n"] = axes_of(fit.residual_rms);
  document["noise_rms_n"] = axes_of(fit.noise_rms);
  document["condition_number"] = fit.condition_number;
  document["degrees_of_freedom"] = fit.degrees_of_freedom;
  document["values"] = 3 * result.forces.angle.size();
  document["effective_values"] = fit.effective_values;
  document["verdict"] = fit.verdict;
  document["steps"] = result.processed.steps;
  document["warnings"] = result.warnings;
  std::vector<double> angle;
  for (const double one : result.forces.angle) angle.push_back(one / units::deg);
  const auto columns = [&](const Eigen::MatrixX3d& force) -> Json {
    return {
        {"x", list_of(force.col(0))}, {"y", list_of(force.col(1))}, {"z", list_of(force.col(2))}};
  };
  document["revolution"] = {{"angle_deg", angle},
                            {"measured_n", columns(result.forces.mean)},
                            {"fitted_n", columns(fit.fitted)}};
  return document;
}

std::string instantaneous_entry(const InstantaneousCase& input, const InstantaneousResult& result) {
  const InstantaneousFit& fit = result.fit;
  Json entry = law_tables(input.options.units, fit);
  const double speed = result.processed.rotation->spindle_speed * input.cutter.cutter.radius;
  // One speed was measured; a hundredth about it makes a range of it.
  entry["speed_range_m_per_s"] = {0.99 * speed, 1.01 * speed};
  entry["rake_deg"] = input.cutter.cutter.rake_angle / units::deg;
  entry["provenance"] = {
      {"obtained", "measured"},
      {"source",
       (input.provenance.source.empty() ? std::string() : input.provenance.source + ", ") +
           input.record.filename().string()},
      {"specimen", input.provenance.specimen},
      {"condition", input.provenance.condition},
      {"uncertainty",
       fmt::format("residual rms {:.3g}/{:.3g}/{:.3g} N (x/y/z)", fit.residual_rms.x(),
                   fit.residual_rms.y(), fit.residual_rms.z())},
      {"note", input.provenance.note}};
  Json found = {{"method", "instantaneous"}};
  const auto units = static_cast<Eigen::Index>(input.options.units.size());
  for (Eigen::Index i = 0; i < units; ++i) {
    const Estimate& one = fit.estimates[static_cast<std::size_t>(i)];
    const ShownEstimate shown = unit_of(one);
    found["coefficients"].push_back(one.name);
    found["units"].push_back(shown.unit);
    found["values"].push_back(one.value / shown.factor);
    found["standard_errors"].push_back(one.standard_error / shown.factor);
    Json row = Json::array();
    for (Eigen::Index k = 0; k < units; ++k) {
      row.push_back(fit.covariance(i, k) /
                    (shown.factor * unit_of(fit.estimates[static_cast<std::size_t>(k)]).factor));
    }
    found["covariance"].push_back(row);
  }
  found["degrees_of_freedom"] = fit.degrees_of_freedom;
  found["condition_number"] = fit.condition_number;
  entry["identification"] = found;
  return "# Identified from one record by the instantaneous method of osteomill.\n" +
         toml_text(entry);
}

}  // namespace osteomill::io
