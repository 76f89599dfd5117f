// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "osteomill/cutting/cutter.hpp"
#include "osteomill/geometry/mesh.hpp"

/// What an HTML report shows. Any command fills these plain values and calls write_report; every
/// part may be empty and is then left out of the page. Numbers of tables, charts and signals stand
/// in the unit that is named beside them, as the reader shall see them; places and times are SI.
namespace osteomill::io {

/// One column of a table. `digits` are those behind the point.
struct ReportColumn {
  std::string name;
  std::string unit = {};
  int digits = 2;
  bool bars = false;       ///< draws each number's size as a bar behind it
  std::string about = {};  ///< shown as an explanation of the heading
};

/// A number, a word, or nothing.
using ReportCell = std::variant<std::monostate, double, std::string>;

struct ReportTable {
  std::string caption = {};
  std::vector<ReportColumn> columns;
  std::vector<std::vector<ReportCell>> rows;
};

struct ReportSeries {
  enum class Style { line, points, line_and_points, bars };
  std::string name;
  std::vector<double> x;  ///< bars stand at 0, 1, 2, ...
  std::vector<double> y;  ///< as long as x; NaN is a gap
  Style style = Style::line;
};

struct ReportAxis {
  std::string label;
  std::string unit = {};
  bool logarithmic = false;
  std::vector<std::string> categories = {};  ///< of an x axis: words in place of 0, 1, 2, ...
};

struct ReportChart {
  std::string title = {};
  ReportAxis x;
  ReportAxis y;
  std::vector<ReportSeries> series;
  struct Limit {
    std::string name;
    double value = 0.0;
  };
  std::vector<Limit> limits = {};  ///< horizontal lines
  std::string about = {};          ///< stands below the chart
};

/// A picture that is carried within the page.
struct ReportPicture {
  std::string caption;      ///< also read aloud in place of the picture
  std::string image;        ///< the bytes of a PNG file, or the text of an SVG file
  bool scene_view = false;  ///< stands in for the 3-D view where there is no WebGL
};

struct ReportParagraph {
  std::string text;
};

struct ReportSection {
  std::string heading;
  std::vector<std::variant<ReportParagraph, ReportTable, ReportChart, ReportPicture>> blocks;
};

/// A number that is worth a tile at the top: "41.2 s", "cutting time, adaptive", "−49 %".
struct ReportHighlight {
  std::string value;
  std::string unit;
  std::string label;
  std::string note = {};
};

/// An assumption or a warning that the reader has to know.
struct ReportNote {
  enum class Kind { assumption, warning, information };
  Kind kind = Kind::assumption;
  std::string text;
  std::string provenance = {};  ///< measured, digitised, reconstructed ..., assumed; may be empty
  std::string source = {};      ///< key in the bibliography
};

/// A value over the time of a run. Signals of one panel share a chart, and the panels stand below
/// each other in the order in which they first appear.
struct ReportSignal {
  std::string name;
  std::string unit;
  std::vector<double> values;  ///< one for each time of the run; NaN is a gap
  std::optional<double> limit = {};
  std::string limit_name = "limit";
  std::string panel = {};  ///< empty: the name of the signal
};

/// Something that holds from one time to another: a material, a line of the path, a saturation.
struct ReportInterval {
  double from_s = 0.0;
  double to_s = 0.0;
  std::string label;  ///< intervals of one label have one colour; air, cancellous and cortical
                      ///< have their own
};

/// A row of intervals below the charts ("material"), or bands within them.
struct ReportStrip {
  std::string name;
  std::vector<ReportInterval> intervals;
  bool within_charts = false;
};

struct ReportEvent {
  double time_s = 0.0;
  std::string label;
};

/// Where the tip of the cutter was, and a value that colours the path.
struct ReportPath {
  std::vector<double> time_s;           ///< increasing
  std::vector<geometry::Vector3> tip;   ///< m, one for each time
  std::vector<geometry::Vector3> axis;  ///< from the tip to the spindle; one for all, or one each
  std::vector<double> value;            ///< one for each time; NaN: no line leads to this place
};

struct ReportRun {
  std::string name;
  std::string about = {};
  std::vector<double> time_s;  ///< increasing
  std::vector<ReportSignal> signals;
  std::vector<ReportStrip> strips = {};
  std::vector<ReportEvent> events = {};
  ReportPath path = {};
  geometry::Mesh before = {};  ///< the stock of this run; empty: that of the scene
  geometry::Mesh after = {};   ///< the stock when the run is over
};

/// The 3-D view, which the runs share.
struct ReportScene {
  geometry::Mesh before;  ///< the stock, m; each run may have its own
  std::optional<cutting::Cutter> cutter = {};
  std::string path_value_name = "force";
  std::string path_value_unit = "N";
  std::optional<double> path_value_limit = {};
  std::string mesh_value_name = {};  ///< of Mesh::values; empty: they are not shown
  std::string mesh_value_unit = {};
};

struct ReportData {
  std::string title;
  std::string subtitle = {};
  std::string program = {};           ///< name and version of what computed it
  std::string created = {};           ///< date and time, as they shall be shown
  std::vector<std::string> headline;  ///< the conclusion, a sentence each
  std::vector<ReportHighlight> highlights = {};
  ReportTable summary = {};  ///< one row a run, in the order of the runs
  std::vector<ReportNote> notes = {};
  std::vector<ReportRun> runs = {};
  std::optional<ReportScene> scene = {};
  std::vector<ReportSection> sections = {};
  std::vector<ReportPicture> pictures = {};
  std::string expanded_case = {};  ///< the case as JSON text
};

struct ReportOptions {
  /// More samples than this are shown by the least and the largest of each short interval, so that
  /// no peak is lost. Shared among all signals of all runs.
  std::size_t most_samples = 1'500'000;
  /// Surfaces with more triangles than this are made coarser for the page.
  std::size_t most_triangles = 300'000;
};

/// The whole page as text. Throws InvalidInput with all faults of the data: lengths that differ,
/// times that do not increase, values that are infinite, pictures that are neither PNG nor SVG.
std::string report_html(const ReportData& data, const ReportOptions& options = {});

/// Writes the page to a file, whole or not at all. Throws WorldError when it cannot be written.
void write_report(const std::filesystem::path& file, const ReportData& data,
                  const ReportOptions& options = {});

}  // namespace osteomill::io
