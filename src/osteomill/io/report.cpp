// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/io/pending_file.hpp"
#include "osteomill/io/report_check.hpp"
#include "osteomill/io/report_encode.hpp"
#include "osteomill/io/report_page.hpp"

namespace osteomill::io {
namespace {

using Json = nlohmann::json;

constexpr float kToMm = static_cast<float>(1.0 / units::mm);
constexpr std::size_t kMostPlaces = 5000;  // of a path: more than the view has pixels along it

Json floats(std::span<const double> values) {
  return {{"type", "f32"}, {"count", values.size()}, {"data", pack_floats(values)}};
}

Json indices(std::span<const std::uint32_t> values) {
  return {{"type", "u32"}, {"count", values.size()}, {"data", pack_indices(values)}};
}

/// Floats in 65534 steps of their range.
Json steps(const std::vector<float>& values) {
  float low = std::numeric_limits<float>::infinity(), high = -low;
  for (const float value : values)
    if (!std::isnan(value)) {
      low = std::min(low, value);
      high = std::max(high, value);
    }
  if (!(low <= high)) low = high = 0.0f;
  return {{"type", "steps"},
          {"count", values.size()},
          {"low", low},
          {"high", high},
          {"data", pack_steps(values, low, high)}};
}

Json number_or_null(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json table_json(const ReportTable& table) {
  Json columns = Json::array(), rows = Json::array();
  for (const auto& c : table.columns)
    columns.push_back({{"name", c.name},
                       {"unit", c.unit},
                       {"digits", c.digits},
                       {"bars", c.bars},
                       {"about", c.about}});
  for (const auto& row : table.rows) {
    Json cells = Json::array();
    for (const auto& cell : row) {
      if (const double* number = std::get_if<double>(&cell))
        cells.push_back(number_or_null(*number));
      else if (const std::string* text = std::get_if<std::string>(&cell))
        cells.push_back(*text);
      else
        cells.push_back(nullptr);
    }
    rows.push_back(std::move(cells));
  }
  return {{"caption", table.caption}, {"columns", columns}, {"rows", rows}};
}

Json axis_json(const ReportAxis& axis) {
  return {{"label", axis.label},
          {"unit", axis.unit},
          {"logarithmic", axis.logarithmic},
          {"categories", axis.categories}};
}

Json chart_json(const ReportChart& chart, std::size_t most) {
  static constexpr const char* styles[] = {"line", "points", "line-and-points", "bars"};
  Json series = Json::array(), limits = Json::array();
  for (const auto& s : chart.series) {
    // Only a line over increasing x can be thinned; a cloud or a loop is shown whole.
    const bool may_thin =
        s.style == ReportSeries::Style::line && std::is_sorted(s.x.begin(), s.x.end());
    const auto few = thinned(s.x, {s.y}, may_thin ? most : std::max<std::size_t>(s.x.size(), 4));
    series.push_back({{"name", s.name},
                      {"style", styles[static_cast<int>(s.style)]},
                      {"x", floats(few.time)},
                      {"y", floats(few.signals[0])}});
  }
  for (const auto& limit : chart.limits)
    limits.push_back({{"name", limit.name}, {"value", limit.value}});
  return {{"title", chart.title}, {"x", axis_json(chart.x)}, {"y", axis_json(chart.y)},
          {"series", series},     {"limits", limits},        {"about", chart.about}};
}

Json picture_json(const ReportPicture& picture) {
  return {
      {"caption", picture.caption},
      {"sceneView", picture.scene_view},
      {"src", fmt::format("data:{};base64,{}", media_type(picture.image), base64(picture.image))}};
}

Json section_json(const ReportSection& section, std::size_t most) {
  Json blocks = Json::array();
  for (const auto& block : section.blocks) {
    if (const auto* paragraph = std::get_if<ReportParagraph>(&block))
      blocks.push_back({{"kind", "paragraph"}, {"text", paragraph->text}});
    else if (const auto* table = std::get_if<ReportTable>(&block))
      blocks.push_back({{"kind", "table"}, {"table", table_json(*table)}});
    else if (const auto* chart = std::get_if<ReportChart>(&block))
      blocks.push_back({{"kind", "chart"}, {"chart", chart_json(*chart, most)}});
    else if (const auto* picture = std::get_if<ReportPicture>(&block))
      blocks.push_back({{"kind", "picture"}, {"picture", picture_json(*picture)}});
  }
  return {{"heading", section.heading}, {"blocks", blocks}};
}

/// The stock in mm. `run` gives the times at which its cutter reaches the vertices.
Json mesh_json(const geometry::Mesh& mesh) {
  Json json;
  for (int a = 0; a < 3; ++a) {
    std::vector<float> along(mesh.vertices.size());
    std::transform(mesh.vertices.begin(), mesh.vertices.end(), along.begin(),
                   [a](const Eigen::Vector3f& vertex) { return vertex[a] * kToMm; });
    json["position"].push_back(steps(along));
  }
  std::vector<std::uint32_t> corners;
  corners.reserve(3 * mesh.triangles.size());
  for (const auto& triangle : mesh.triangles)
    corners.insert(corners.end(), triangle.begin(), triangle.end());
  json["corners"] = indices(corners);
  if (!mesh.values.empty()) json["value"] = steps(mesh.values);
  return json;
}

/// What a run's cutter has reached by when; it stands apart from the mesh, which runs may share.
Json reach_json(const geometry::Mesh& mesh, const ReportPath& path, const cutting::Cutter& cutter) {
  // A vertex on the finished surface lies off the ideal one by less than the mesh resolves.
  const double margin = 0.5 * mean_edge(mesh);
  return steps(reach_times(mesh.vertices, path.time_s, path.tip, path.axis, cutter, margin));
}

Json intervals_json(const std::vector<ReportInterval>& intervals) {
  Json json = Json::array();
  for (const auto& i : intervals)
    json.push_back({{"from", i.from_s}, {"to", i.to_s}, {"label", i.label}});
  return json;
}

/// Places in mm with the largest value of the samples that each stands for.
Json path_json(const ReportPath& path, std::size_t most) {
  const std::size_t count = path.time_s.size();
  const std::size_t stride = (count + most - 1) / std::max<std::size_t>(most, 1);
  std::vector<double> time, value;
  std::array<std::vector<float>, 3> tip, axis;
  for (std::size_t i = 0; i < count; i += stride) {
    time.push_back(path.time_s[i]);
    double largest = path.value[i];
    // A jump stays a jump: once NaN, always NaN.
    for (std::size_t k = i; k < std::min(i + stride, count); ++k)
      if (!(path.value[k] <= largest)) largest = std::isnan(largest) ? largest : path.value[k];
    value.push_back(largest);
    for (int a = 0; a < 3; ++a) {
      tip[a].push_back(static_cast<float>(path.tip[i][a]) * kToMm);
      if (path.axis.size() > 1 || axis[a].empty())
        axis[a].push_back(static_cast<float>(path.axis[path.axis.size() > 1 ? i : 0][a]));
    }
  }
  Json json = {{"time", floats(time)}, {"value", floats(value)}};
  for (int a = 0; a < 3; ++a) {
    json["tip"].push_back(steps(tip[a]));
    json["axis"].push_back(steps(axis[a]));
  }
  return json;
}

Json run_json(const ReportRun& run, std::size_t most_samples) {
  std::vector<std::span<const double>> values;
  for (const auto& signal : run.signals) values.emplace_back(signal.values);
  const Thinned few = thinned(run.time_s, values, most_samples);
  Json json = {{"name", run.name},
               {"about", run.about},
               {"time", floats(few.time)},
               {"thinnedFrom", few.time.size() < run.time_s.size() ? run.time_s.size() : 0},
               {"signals", Json::array()},
               {"strips", Json::array()},
               {"events", Json::array()}};
  for (std::size_t i = 0; i < run.signals.size(); ++i) {
    const auto& signal = run.signals[i];
    Json entry = {{"name", signal.name},
                  {"unit", signal.unit},
                  {"panel", signal.panel.empty() ? signal.name : signal.panel},
                  {"values", floats(few.signals[i])}};
    if (signal.limit) entry["limit"] = {{"name", signal.limit_name}, {"value", *signal.limit}};
    json["signals"].push_back(std::move(entry));
  }
  for (const auto& strip : run.strips)
    json["strips"].push_back({{"name", strip.name},
                              {"withinCharts", strip.within_charts},
                              {"intervals", intervals_json(strip.intervals)}});
  for (const auto& event : run.events)
    json["events"].push_back({{"time", event.time_s}, {"label", event.label}});
  return json;
}

Json scene_json(const ReportScene& scene) {
  Json json = {{"valueName", scene.path_value_name},
               {"valueUnit", scene.path_value_unit},
               {"meshValueName", scene.mesh_value_name},
               {"meshValueUnit", scene.mesh_value_unit}};
  if (scene.path_value_limit) json["valueLimit"] = *scene.path_value_limit;
  if (scene.cutter) {
    Json outline = Json::array();
    const int parts = 48;
    for (int i = 0; i <= parts; ++i) {
      // Finer towards the tip, where a ball is round.
      const double z = scene.cutter->cutting_length * i * i / (parts * parts);
      outline.push_back({cutting::radius_at(*scene.cutter, z) / units::mm, z / units::mm,
                         cutting::lag_angle(*scene.cutter, z)});
    }
    json["cutter"] = {{"outline", outline},
                      {"radius", scene.cutter->radius / units::mm},
                      {"flutes", scene.cutter->flutes}};
  }
  return json;
}

Json page_json(const ReportData& data, const ReportOptions& options) {
  static constexpr const char* kinds[] = {"assumption", "warning", "information"};
  Json json = {{"title", data.title},         {"subtitle", data.subtitle},
               {"program", data.program},     {"created", data.created},
               {"headline", data.headline},   {"summary", table_json(data.summary)},
               {"highlights", Json::array()}, {"notes", Json::array()},
               {"runs", Json::array()},       {"sections", Json::array()},
               {"pictures", Json::array()},   {"case", nullptr}};
  for (const auto& h : data.highlights)
    json["highlights"].push_back(
        {{"value", h.value}, {"unit", h.unit}, {"label", h.label}, {"note", h.note}});
  for (const auto& n : data.notes)
    json["notes"].push_back({{"kind", kinds[static_cast<int>(n.kind)]},
                             {"text", n.text},
                             {"provenance", n.provenance},
                             {"source", n.source}});

  std::size_t arrays = 1;
  for (const auto& run : data.runs) arrays += 1 + run.signals.size();
  const std::size_t most = std::clamp<std::size_t>(options.most_samples / arrays, 1000, 100'000);
  for (const auto& run : data.runs) json["runs"].push_back(run_json(run, most));

  if (data.scene) {
    json["scene"] = scene_json(*data.scene);
    std::size_t meshes = 1;
    for (const auto& run : data.runs) meshes += run.before.triangles.empty() ? 1 : 2;
    const std::size_t triangles = std::max<std::size_t>(options.most_triangles / meshes, 1);
    const geometry::Mesh before = coarsened(data.scene->before, triangles);
    if (!before.triangles.empty()) json["scene"]["before"] = mesh_json(before);
    for (std::size_t i = 0; i < data.runs.size(); ++i) {
      const ReportRun& run = data.runs[i];
      Json& to = json["runs"][i];
      const bool moves = !run.path.time_s.empty();
      if (moves) to["path"] = path_json(run.path, kMostPlaces);
      const bool reaches = moves && data.scene->cutter;
      const geometry::Mesh own = coarsened(run.before, triangles);
      if (!own.triangles.empty()) to["before"] = mesh_json(own);
      const geometry::Mesh& start = own.triangles.empty() ? before : own;
      if (reaches && !start.triangles.empty())
        to["beforeReach"] = reach_json(start, run.path, *data.scene->cutter);
      const geometry::Mesh after = coarsened(run.after, triangles);
      if (after.triangles.empty()) continue;
      to["after"] = mesh_json(after);
      if (reaches) to["afterReach"] = reach_json(after, run.path, *data.scene->cutter);
    }
  }
  for (const auto& section : data.sections) json["sections"].push_back(section_json(section, most));
  for (const auto& picture : data.pictures) json["pictures"].push_back(picture_json(picture));
  if (!data.expanded_case.empty()) json["case"] = data.expanded_case;
  return json;
}

std::string escaped(const std::string& text) {
  std::string result;
  for (const char c : text) {
    if (c == '<')
      result += "&lt;";
    else if (c == '&')
      result += "&amp;";
    else
      result += c;
  }
  return result;
}

std::string with(std::string page, const std::string& mark, const std::string& text) {
  const std::size_t at = page.find(mark);
  if (at == std::string::npos) throw std::logic_error("the report page has no place for " + mark);
  return page.replace(at, mark.size(), text);
}

}  // namespace

std::string report_html(const ReportData& data, const ReportOptions& options) {
  check(data);
  // A "<" within a JSON string could end the element that carries the text; its escape cannot.
  // Bytes that are not UTF-8 come out as the replacement character.
  const std::string plain =
      page_json(data, options).dump(-1, ' ', false, Json::error_handler_t::replace);
  std::string safe;
  safe.reserve(plain.size() + 1000);
  for (const char c : plain) {
    if (c == '<')
      safe += "\\u003c";
    else
      safe += c;
  }
  std::string page(report_page());
  page = with(std::move(page), "<!--title-->", escaped(data.title));
  return with(std::move(page), "<!--data-->", safe);
}

void write_report(const std::filesystem::path& file, const ReportData& data,
                  const ReportOptions& options) {
  const std::string page = report_html(data, options);
  PendingFile pending(file);
  std::ofstream stream(pending.path(), std::ios::binary);
  stream << page;
  stream.close();
  if (!stream)
    throw WorldError(fmt::format("{}: cannot be written; is the disk full?", file.string()));
  pending.commit();
}

}  // namespace osteomill::io
