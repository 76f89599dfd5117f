// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/instantaneous_case.hpp"

#include <fmt/format.h>

#include <cmath>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/cutting/milling_force.hpp"
#include "osteomill/identify/revolution_fit.hpp"
#include "osteomill/io/case_file.hpp"
#include "osteomill/io/law_entry.hpp"
#include "osteomill/io/section.hpp"

namespace osteomill::io {
namespace {

using namespace identify;
using Json = nlohmann::ordered_json;

const Need kOptional = Need::optional;

enum class Form { linear, polynomial, power, log };

struct Keys {
  InstantaneousCase input;
  CutCase cut;
  Form form = Form::linear;
  int shear_order = 0;
  int edge_order = 0;
  bool edge_force = false;
  std::optional<double> phase;
};

void bind(Section& section, Keys& keys) {
  InstantaneousCase& input = keys.input;
  section.table(
      "instantaneous", "the record, and what is unknown", Need::required, [&](Section& s) {
        s.file("record", input.record, "forces over time");
        s.choice<Form>("law", keys.form,
                       {{"linear", Form::linear},
                        {"polynomial", Form::polynomial},
                        {"power", Form::power},
                        {"log", Form::log}},
                       "linear: six coefficients; polynomial: of kappa; power and log: of the chip",
                       kOptional);
        s.flag("edge_force", keys.edge_force, "power: with a constant edge force");
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
  if (keys.form == Form::power) input.options.units = power_law_units(keys.edge_force);
  if (keys.form == Form::log) input.options.units = log_law_units();
  input.options.phase = keys.phase;
  return input;
}

InstantaneousResult solve(const InstantaneousCase& input) {
  InstantaneousResult result;
  LoadedRecord loaded = read_force_record(input.record, input.format);
  result.warnings = std::move(loaded.warnings);
  const CutOfRecord cut{input.condition.spindle_speed, input.cutter.cutter.flutes};
  result.raw = std::move(loaded.record);
  result.processed = process(result.raw, cut, input.signals.chain);
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
  // Kte, Kt and Fte are forces per width; nt and Kt1, Kt2, Kt3 are numbers.
  const bool logarithmic = name.size() == 3 && name[2] >= '1' && name[2] <= '3';
  if (name.front() == 'n' || (name.front() == 'K' && logarithmic)) return {1.0, "1"};
  if (name.front() == 'K' || name.front() == 'F') return {units::n_per_mm, "N/mm"};
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
  const cutting::Cutter& cutter = input.cutter.cutter;
  const double speed = result.processed.rotation->spindle_speed * cutter.radius;
  const bool cylinder = cutter.shape == cutting::CutterShape::cylindrical;
  const auto count = static_cast<Eigen::Index>(fit.units.size()) + exponents_of(fit.units);
  Eigen::VectorXd values(count);
  LawEntry entry;
  for (Eigen::Index i = 0; i < count; ++i) {
    const Estimate& one = fit.estimates[static_cast<std::size_t>(i)];
    const ShownEstimate shown = unit_of(one);
    values(i) = one.value;
    entry.coefficients.push_back(
        {one.name, shown.unit, shown.factor, one.value, one.standard_error});
  }
  entry.heading = "Identified from one record by the instantaneous method of osteomill.";
  entry.law = law_of(fit.units, values, cylinder ? cutter.helix_angle : 0.0);
  // Every chip from none to the largest passes in each turn.
  entry.range_um = {0.0,
                    cutting::largest_chip(cutter, input.condition, input.immersion) / units::um};
  // One speed was measured; a hundredth about it makes a range of it.
  entry.speed_range_m_per_s = {0.99 * speed, 1.01 * speed};
  entry.rake_deg = {cutter.rake_angle / units::deg};
  entry.provenance = input.provenance;
  entry.provenance.source =
      (input.provenance.source.empty() ? std::string() : input.provenance.source + ", ") +
      input.record.filename().string();
  entry.provenance.uncertainty =
      fmt::format("residual rms {:.3g}/{:.3g}/{:.3g} N (x/y/z)", fit.residual_rms.x(),
                  fit.residual_rms.y(), fit.residual_rms.z());
  entry.model = std::string(cutting::name_of(entry.law.tangential.at_0));
  entry.method = "instantaneous";
  entry.covariance = fit.covariance;
  entry.degrees_of_freedom = fit.degrees_of_freedom;
  entry.condition_number = fit.condition_number;
  return law_entry_text(entry);
}

}  // namespace osteomill::io
