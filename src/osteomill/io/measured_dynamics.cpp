// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/measured_dynamics.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <functional>
#include <nlohmann/json.hpp>
#include <numbers>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/io/section.hpp"
#include "osteomill/io/text_file.hpp"
#include "osteomill/io/vibration_records.hpp"

namespace osteomill::io {

using namespace vibration;

namespace {

/// Everything but where the response comes from.
void bind_fit(Section& s, ImpactTable& table) {
  s.choice<FrfEstimator>(
      "estimator", table.options.estimator, {{"h1", FrfEstimator::h1}, {"h2", FrfEstimator::h2}},
      "h1: noise on the response averages out; h2: on the force", Need::optional);
  s.number("window_end", table.options.window_end, {}, Range{1e-6, 1.0},
           "end of an exponential window over its beginning; 1: none", Need::optional);
  s.number("force_window_ms", table.options.force_window, {units::ms, "ms"}, non_negative(),
           "kept on both sides of the blow's top; 0: all", Need::optional);
  s.number("low_hz", table.fit.low_hz, {1.0, "Hz"}, non_negative(), "lower end of the fit",
           Need::optional);
  s.number("high_hz", table.fit.high_hz, {1.0, "Hz"}, non_negative(),
           "upper end of the fit; 0: all", Need::optional);
  s.integer("modes", table.fit.modes, between(1, 20), "modes to fit", Need::optional);
}

void bind_response(Section& s, ImpactTable& table) {
  s.files("records", table.records,
          "files of hammer blows: time_s, force_n, displacement_um or acceleration_m_per_s2",
          Need::optional);
  s.file("frf", table.frf,
         "file of a frequency response: frequency_hz, real_um_per_n, imaginary_um_per_n, "
         "coherence",
         Need::optional);
}

double largest_in_band(const ImpactCase& impact) {
  double largest = 0.0;
  for (std::size_t i = 0; i < impact.frf.frequency_hz.size(); ++i) {
    const double f = impact.frf.frequency_hz[i];
    const bool inside =
        f >= impact.fit.low_hz && (impact.fit.high_hz == 0.0 || f <= impact.fit.high_hz);
    if (inside) largest = std::max(largest, std::abs(impact.frf.receptance[i]));
  }
  return largest;
}

/// A response with the modes that were fitted to it.
struct Fitted {
  MeasuredFrf frf;
  ModalFit fit;
  ModalFitOptions band;
};

/// What `osteomill modes` found in an impact test.
Fitted fitted_of_result(const MeasuredTable& table) {
  const auto fault = [&](const char* rule) {
    return InvalidInput(Fault{"structure.measured.result", table.result.filename().string(), rule,
                              "name the run folder of osteomill modes with an [impact]"});
  };
  const bool folder = std::filesystem::is_directory(table.result);
  auto document = nlohmann::json::parse(
      read_text_file(folder ? table.result / "run.json" : table.result), nullptr, false);
  if (document.is_discarded() || !document.is_object()) throw fault("is no JSON object");
  if (document.contains("summary") && document["summary"].is_object()) {
    document = nlohmann::json(document["summary"]);
  }
  if (document.value("method", "") != "impact-test") throw fault("holds no impact test");
  Fitted fitted;
  try {
    for (const auto& entry : document.at("modes")) {
      const auto value = [&](const char* key) { return entry.at(key).at("value").get<double>(); };
      fitted.fit.modes.push_back({.frequency_hz = {value("frequency_hz")},
                                  .stiffness = {value("stiffness_n_per_mm") * units::n_per_mm},
                                  .damping_ratio = {value("damping_ratio")}});
    }
    fitted.fit.residual_flexibility =
        document.at("residual_flexibility_um_per_n").get<double>() * units::um;
    const auto& lines = document.at("receptance");
    fitted.frf.frequency_hz = lines.at("frequency_hz").get<std::vector<double>>();
    const auto real = lines.at("real_um_per_n").get<std::vector<double>>();
    const auto imaginary = lines.at("imaginary_um_per_n").get<std::vector<double>>();
    for (std::size_t i = 0; i < fitted.frf.frequency_hz.size(); ++i) {
      fitted.frf.receptance.emplace_back(real.at(i) * units::um, imaginary.at(i) * units::um);
    }
  } catch (const std::exception&) {
    throw fault("has no complete modes and receptance");
  }
  if (fitted.fit.modes.empty() || fitted.frf.frequency_hz.size() < 2) {
    throw fault("has no modes, or too few lines");
  }
  fitted.fit.converged = true;
  fitted.fit.status = "converged";
  return fitted;
}

Fitted fitted_of(const MeasuredTable& table, std::vector<std::string>& caveats) {
  if (!table.result.empty()) return fitted_of_result(table);
  ImpactCase impact = impact_of(table.impact);
  ModalFit fit = fit_modes(impact.frf, impact.fit);
  if (!fit.converged) throw NoSolution("structure.measured: modal fit: " + fit.status);
  const double left = fit.residual_rms / largest_in_band(impact);
  if (left > 0.1) {
    caveats.push_back(fmt::format(
        "the modes fitted to the measured response leave {:.0f} % of its peak: time-domain methods "
        "stand on them; fit more modes or another band",
        100.0 * left));
  }
  return {std::move(impact.frf), std::move(fit), impact.fit};
}

}  // namespace

void bind_impact(Section& section, ImpactTable& table) {
  section.table("impact", "impact test, in place of a [beam]", Need::required, [&](Section& s) {
    bind_response(s, table);
    s.exactly_one_of({"records", "frf"});
    bind_fit(s, table);
  });
}

ImpactCase impact_of(const ImpactTable& table) {
  ImpactCase impact{.frf = {}, .fit = table.fit};
  if (!table.frf.empty()) {
    impact.frf = read_frf(table.frf);
    return impact;
  }
  FrfOptions options = table.options;
  std::vector<ImpactRecord> records;
  for (const std::filesystem::path& file : table.records) {
    records.push_back(read_impact_record(file, options.response));
  }
  impact.frf = estimate_frf(records, options);
  return impact;
}

void bind_direction(Section& section, double& x, double& y) {
  enum class Axis { feed, normal };
  Axis axis = Axis::feed;
  section.choice<Axis>("direction", axis, {{"x", Axis::feed}, {"y", Axis::normal}},
                       "x along the feed, y normal to it", Need::optional);
  std::optional<double> angle;
  section.number("direction_deg", angle, {units::deg, "deg"}, between(-360.0, 360.0),
                 "from the feed towards +y, in place of direction's right angles");
  x = angle ? std::cos(*angle) : axis == Axis::feed ? 1.0 : 0.0;
  y = angle ? std::sin(*angle) : axis == Axis::normal ? 1.0 : 0.0;
}

void bind_measured(Section& section, std::vector<MeasuredTable>& tables) {
  section.tables("measured", "measured responses of the tip, one a direction", Need::optional,
                 [&](Section& s, std::size_t) {
                   MeasuredTable table;
                   bind_direction(s, table.direction_x, table.direction_y);
                   bind_response(s, table.impact);
                   s.file("result", table.result, "result.json of osteomill modes with an [impact]",
                          Need::optional);
                   s.exactly_one_of({"frf", "records", "result"});
                   bind_fit(s, table.impact);
                   tables.push_back(table);
                 });
}

MeasuredStructure measured_structure(const std::vector<MeasuredTable>& tables) {
  struct Line {
    double x, y;
    std::function<std::complex<double>(double)> response;
  };
  MeasuredStructure structure;
  std::vector<Line> lines;
  for (const MeasuredTable& table : tables) {
    const double x = table.direction_x, y = table.direction_y;
    const Fitted fitted = fitted_of(table, structure.caveats);
    for (const FittedMode& mode : fitted.fit.modes) structure.modes.push_back(mode.mode(x, y));
    lines.push_back({x, y, receptance_of(fitted.frf, fitted.fit, fitted.band)});
  }
  for (const auto& [axis, flexible] :
       {std::pair{"x", std::any_of(lines.begin(), lines.end(),
                                   [](const Line& line) { return std::abs(line.x) > 1e-9; })},
        std::pair{"y", std::any_of(lines.begin(), lines.end(),
                                   [](const Line& line) { return std::abs(line.y) > 1e-9; })}}) {
    if (!flexible) {
      structure.caveats.push_back(
          fmt::format("nothing was measured along {}: the tip is taken as rigid there", axis));
    }
  }
  structure.receptance = [lines = std::move(lines)](double f) {
    TipReceptance sum{};
    for (const Line& line : lines) {
      const std::complex<double> h = line.response(f);
      sum.xx += line.x * line.x * h;
      sum.xy += line.x * line.y * h;
      sum.yy += line.y * line.y * h;
    }
    return sum;
  };
  return structure;
}

}  // namespace osteomill::io
