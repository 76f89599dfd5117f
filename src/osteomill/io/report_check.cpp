// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/report_check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "osteomill/base/error.hpp"

namespace osteomill::io {
namespace {

class Checker {
 public:
  void fault(std::string field, std::string value, std::string rule, std::string remedy = {}) {
    faults_.push_back({std::move(field), std::move(value), std::move(rule), std::move(remedy)});
  }

  void same_length(const std::string& field, std::size_t length, std::size_t wanted,
                   const char* of) {
    if (length != wanted)
      fault(field, fmt::format("{} values", length),
            fmt::format("must have {} like {}", wanted, of));
  }

  void increasing(const std::string& field, const std::vector<double>& times) {
    for (std::size_t i = 0; i < times.size(); ++i) {
      const bool follows = i == 0 || times[i] > times[i - 1];
      if (std::isfinite(times[i]) && follows) continue;
      return fault(fmt::format("{}[{}]", field, i), fmt::format("{} s", times[i]),
                   "times must be finite and increase");
    }
  }

  /// NaN may stand for "nothing here", an infinity for nothing.
  void not_infinite(const std::string& field, const std::vector<double>& values) {
    const auto bad =
        std::find_if(values.begin(), values.end(), [](double v) { return std::isinf(v); });
    if (bad != values.end())
      fault(fmt::format("{}[{}]", field, bad - values.begin()), fmt::format("{}", *bad),
            "must be finite, or NaN for a gap");
  }

  void table(const std::string& field, const ReportTable& table) {
    for (std::size_t r = 0; r < table.rows.size(); ++r)
      same_length(fmt::format("{}.rows[{}]", field, r), table.rows[r].size(), table.columns.size(),
                  "the columns");
  }

  void chart(const std::string& field, const ReportChart& chart) {
    for (const auto& series : chart.series) {
      const std::string name = fmt::format("{}.series[{}]", field, series.name);
      same_length(name + ".y", series.y.size(), series.x.size(), "x");
      not_infinite(name + ".x", series.x);
      not_infinite(name + ".y", series.y);
    }
  }

  void picture(const std::string& field, const ReportPicture& picture) {
    if (media_type(picture.image).empty())
      fault(field, fmt::format("{} bytes", picture.image.size()), "must be a PNG or SVG picture");
  }

  void mesh(const std::string& field, const geometry::Mesh& mesh) {
    if (!mesh.values.empty())
      same_length(field + ".values", mesh.values.size(), mesh.vertices.size(), "the vertices");
    if (std::any_of(mesh.vertices.begin(), mesh.vertices.end(),
                    [](const Eigen::Vector3f& vertex) { return !vertex.allFinite(); }))
      fault(field + ".vertices", "not finite", "must be finite");
    for (const auto& triangle : mesh.triangles)
      if (std::any_of(triangle.begin(), triangle.end(),
                      [&](unsigned corner) { return corner >= mesh.vertices.size(); }))
        return fault(field + ".triangles",
                     fmt::format("a corner of {} vertices", mesh.vertices.size()),
                     "must be indices into the vertices");
  }

  void path(const std::string& field, const ReportPath& path) {
    const std::size_t count = path.time_s.size();
    increasing(field + ".time_s", path.time_s);
    same_length(field + ".tip", path.tip.size(), count, "the times");
    same_length(field + ".value", path.value.size(), count, "the times");
    if (count > 0 && path.axis.size() != 1)
      same_length(field + ".axis", path.axis.size(), count, "the times (or one for all)");
    const auto finite = [](const geometry::Vector3& v) { return v.allFinite(); };
    if (!std::all_of(path.tip.begin(), path.tip.end(), finite))
      fault(field + ".tip", "not finite", "must be finite");
    // A unit vector that was normalised in double precision is much closer to 1 than this; one that
    // was not normalised at all is farther.
    if (!std::all_of(path.axis.begin(), path.axis.end(),
                     [](const geometry::Vector3& v) { return std::abs(v.norm() - 1.0) < 1e-6; }))
      fault(field + ".axis", "not a unit vector", "must have length 1");
    not_infinite(field + ".value", path.value);
  }

  void run(const std::string& field, const ReportRun& run) {
    increasing(field + ".time_s", run.time_s);
    for (const auto& signal : run.signals) {
      const std::string name = fmt::format("{}.signals[{}]", field, signal.name);
      same_length(name + ".values", signal.values.size(), run.time_s.size(), "the times");
      not_infinite(name + ".values", signal.values);
    }
    for (const auto& strip : run.strips)
      for (const auto& interval : strip.intervals)
        if (!(interval.from_s <= interval.to_s))
          fault(fmt::format("{}.strips[{}]", field, strip.name),
                fmt::format("{} s to {} s", interval.from_s, interval.to_s),
                "an interval must end after it starts");
    path(field + ".path", run.path);
    mesh(field + ".before", run.before);
    mesh(field + ".after", run.after);
  }

  void finish() {
    if (!faults_.empty()) throw InvalidInput(std::move(faults_));
  }

 private:
  std::vector<Fault> faults_;
};

}  // namespace

std::string media_type(const std::string& image) {
  if (image.starts_with("\x89PNG\r\n\x1a\n")) return "image/png";
  const std::size_t text = image.find_first_not_of(" \t\r\n");
  const bool xml = text != std::string::npos && image[text] == '<';
  return xml && image.find("<svg") != std::string::npos ? "image/svg+xml" : "";
}

void check(const ReportData& data) {
  Checker checker;
  if (data.title.empty()) checker.fault("title", "", "must not be empty");
  checker.table("summary", data.summary);
  std::set<std::string> names;
  for (const auto& run : data.runs) {
    const std::string field = fmt::format("runs[{}]", run.name);
    if (!names.insert(run.name).second)
      checker.fault(field, "", "each run needs a name of its own");
    checker.run(field, run);
  }
  if (data.scene) checker.mesh("scene.before", data.scene->before);
  for (const auto& section : data.sections)
    for (std::size_t b = 0; b < section.blocks.size(); ++b) {
      const std::string field = fmt::format("sections[{}].blocks[{}]", section.heading, b);
      if (const auto* table = std::get_if<ReportTable>(&section.blocks[b]))
        checker.table(field, *table);
      if (const auto* chart = std::get_if<ReportChart>(&section.blocks[b]))
        checker.chart(field, *chart);
      if (const auto* picture = std::get_if<ReportPicture>(&section.blocks[b]))
        checker.picture(field, *picture);
    }
  for (std::size_t i = 0; i < data.pictures.size(); ++i)
    checker.picture(fmt::format("pictures[{}]", i), data.pictures[i]);
  if (!data.expanded_case.empty() && !nlohmann::json::accept(data.expanded_case))
    checker.fault("expanded_case", "", "must be JSON");
  checker.finish();
}

}  // namespace osteomill::io
