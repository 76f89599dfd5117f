// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/study_measure.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <map>
#include <set>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/study/table.hpp"

namespace osteomill::io {
namespace {

using study::Vector3;
using units::deg;

/// Reads cells of one table and keeps every fault.
class Cells {
 public:
  explicit Cells(const CsvFile& file) : file_(file) {
    for (size_t i = 0; i < file.columns.size(); ++i) at_[file.columns[i]] = i;
  }
  bool has(const std::string& column) const { return at_.contains(column); }
  bool has_all(const std::string& stem, std::initializer_list<const char*> ends) const {
    return std::all_of(ends.begin(), ends.end(), [&](const char* end) { return has(stem + end); });
  }
  const std::string& text(const CsvFile::Row& row, const std::string& column) const {
    return row.cells[at_.at(column)];
  }
  double number(const CsvFile::Row& row, const std::string& column) {
    const std::string& cell = text(row, column);
    double value = 0.0;
    const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
    if (error != std::errc{} || end != cell.data() + cell.size()) {
      fault(row, column, cell, "must be a number", "with a decimal point and no unit");
    }
    return value;
  }
  Vector3 vector(const CsvFile::Row& row, const std::string& stem,
                 std::initializer_list<const char*> ends) {
    Vector3 v;
    Eigen::Index i = 0;
    for (const char* end : ends) v(i++) = number(row, stem + end);
    return v;
  }
  void fault(const CsvFile::Row& row, const std::string& field, const std::string& value,
             const std::string& rule, const std::string& remedy) {
    faults_.push_back({field, value, rule, remedy, fmt::format("{}:{}", file_.name, row.line)});
  }
  void add(const InvalidInput& error, const CsvFile::Row& row) {
    for (Fault f : error.faults()) {
      f.location = fmt::format("{}:{}", file_.name, row.line);
      faults_.push_back(std::move(f));
    }
  }
  size_t faults() const { return faults_.size(); }
  void throw_faults() {
    if (!faults_.empty()) throw InvalidInput(std::move(faults_));
  }

 private:
  const CsvFile& file_;
  std::map<std::string, size_t> at_;
  std::vector<Fault> faults_;
};

const auto kQuaternion = {"_qw", "_qx", "_qy", "_qz"};
const auto kNormal = {"_nx", "_ny", "_nz"};
const auto kEntry = {"_ex", "_ey", "_ez"};

Eigen::Matrix3d rotation_of(Cells& cells, const CsvFile::Row& row, const std::string& stem) {
  Eigen::Quaterniond q(cells.number(row, stem + "_qw"), cells.number(row, stem + "_qx"),
                       cells.number(row, stem + "_qy"), cells.number(row, stem + "_qz"));
  if (!(std::abs(q.norm() - 1.0) < 5e-3)) {
    throw InvalidInput(Fault{stem + "_q…", fmt::format("length {:.4f}", q.norm()),
                             "a quaternion of a rotation has length one",
                             "export qw qx qy qz unscaled"});
  }
  return q.normalized().toRotationMatrix();
}

/// Normal of one surface, from a pose or as it stands.
Vector3 normal_of(Cells& cells, const CsvFile::Row& row, const std::string& stem) {
  if (cells.has_all(stem, kQuaternion)) return rotation_of(cells, row, stem).col(2);
  return cells.vector(row, stem, kNormal);
}

bool given(const Cells& cells, const CsvFile::Row& row, const std::string& stem) {
  const bool pose = cells.has_all(stem, kQuaternion), normal = cells.has_all(stem, kNormal);
  if (!pose && !normal) return false;
  return !study::is_missing(cells.text(row, stem + (pose ? "_qw" : "_nx")));
}

Eigen::Matrix3d guide_of(Cells& cells, const CsvFile::Row& row, const Vector3* fitted) {
  if (cells.has_all("guide", kQuaternion)) return rotation_of(cells, row, "guide");
  const Vector3 outward = fitted ? *fitted : cells.vector(row, "guide", kNormal);
  return study::guide_frame(outward, cells.vector(row, "guide", kEntry));
}

std::optional<study::CutSide> side_of(Cells& cells, const CsvFile::Row& row) {
  static const std::map<std::string, study::CutKind> kinds = {
      {"proximal-tibia", study::CutKind::kProximalTibia},
      {"distal-femur", study::CutKind::kDistalFemur},
      {"anterior-femur", study::CutKind::kAnteriorFemur},
      {"posterior-femur", study::CutKind::kPosteriorFemur}};
  const auto kind = kinds.find(cells.text(row, "cut_kind"));
  const std::string& side = cells.text(row, "side");
  if (kind == kinds.end()) {
    cells.fault(row, "cut_kind", cells.text(row, "cut_kind"), "is no cut",
                "proximal-tibia, distal-femur, anterior-femur or posterior-femur");
  }
  if (side != "left" && side != "right") {
    cells.fault(row, "side", side, "must be left or right", "varus turns its sign with the side");
  }
  if (kind == kinds.end() || (side != "left" && side != "right")) return {};
  return study::side_of(kind->second, side == "right");
}

void require_columns(const CsvFile& file, const Cells& cells,
                     std::initializer_list<const char*> names) {
  std::vector<Fault> faults;
  for (const char* name : names) {
    if (!cells.has(name)) {
      faults.push_back({name, "", "no such column", "docs/guide/study.md lists them", file.name});
    }
  }
  if (!faults.empty()) throw InvalidInput(std::move(faults));
}

/// Points of a surface of a cut, m.
using Clouds = std::map<std::pair<std::string, std::string>, std::vector<Vector3>>;
Clouds read_clouds(const CsvFile& file) {
  Cells cells(file);
  require_columns(file, cells, {"cut_id", "surface", "x_mm", "y_mm", "z_mm"});
  Clouds clouds;
  for (const CsvFile::Row& row : file.rows) {
    const std::string& surface = cells.text(row, "surface");
    if (surface != "guide" && surface != "cut") {
      cells.fault(row, "surface", surface, "must be guide or cut", "");
    }
    clouds[{cells.text(row, "cut_id"), surface}].push_back(
        cells.vector(row, "", {"x_mm", "y_mm", "z_mm"}) * units::mm);
  }
  cells.throw_faults();
  return clouds;
}

std::string three(double value) { return fmt::format("{:.4f}", value); }

}  // namespace

MeasuredCuts measure_cuts(const CsvFile& cuts, const std::optional<CsvFile>& points) {
  Cells cells(cuts);
  require_columns(cuts, cells, {"cut_kind", "side"});
  const bool pose = cells.has_all("guide", kQuaternion);
  if (!pose && !cells.has_all("guide", kEntry)) {
    throw InvalidInput(Fault{
        "guide", "", "its orientation is missing",
        "give guide_qw … guide_qz, or guide_nx … guide_nz and guide_ex … guide_ez", cuts.name});
  }
  if (points) require_columns(cuts, cells, {"cut_id"});
  const Clouds clouds = points ? read_clouds(*points) : Clouds{};

  MeasuredCuts result{{cuts.name, {}, {}}, {}};
  std::vector<size_t> kept;
  for (size_t i = 0; i < cuts.columns.size(); ++i) {
    const std::string& name = cuts.columns[i];
    const bool raw = name.starts_with("guide_") ||
                     (name.starts_with("cut_") && name != "cut_id" && name != "cut_kind");
    if (raw) continue;
    kept.push_back(i);
    result.table.columns.push_back(name);
  }
  for (const char* name :
       {"varus_valgus_deg", "flexion_extension_deg", "guide_movement_varus_valgus_deg",
        "guide_movement_flexion_extension_deg"}) {
    result.table.columns.emplace_back(name);
  }
  if (points) {
    for (const char* name : {"flatness_um", "roughness_um", "tilt_sd_deg"}) {
      result.table.columns.emplace_back(name);
    }
  }
  for (const CsvFile::Row& row : cuts.rows) {
    try {
      const std::optional<study::CutSide> side = side_of(cells, row);
      std::optional<study::PlaneFit> guide_fit, cut_fit;
      const Vector3 hint =
          given(cells, row, "guide") ? normal_of(cells, row, "guide") : Vector3::UnitZ();
      if (points) {
        const std::string& id = cells.text(row, "cut_id");
        if (const auto found = clouds.find({id, "guide"}); found != clouds.end()) {
          guide_fit = study::fit_plane(found->second, hint);
        }
        if (const auto found = clouds.find({id, "cut"}); found != clouds.end()) {
          cut_fit = study::fit_plane(found->second, hint);
        }
      }
      if (!guide_fit && !given(cells, row, "guide")) {
        cells.fault(row, "guide", "", "has neither an orientation nor points", "");
        continue;
      }
      if (!cut_fit && !given(cells, row, "cut")) {
        cells.fault(row, "cut", "", "has neither an orientation nor points", "");
        continue;
      }
      const size_t before = cells.faults();
      const Eigen::Matrix3d R_BG = guide_of(cells, row, guide_fit ? &guide_fit->normal : nullptr);
      const Vector3 normal = cut_fit ? cut_fit->normal : normal_of(cells, row, "cut");
      if (!side || cells.faults() != before) continue;
      const study::CutError error = study::cut_error(R_BG, normal, *side);
      CsvFile::Row out{row.line, {}};
      for (const size_t i : kept) out.cells.push_back(row.cells[i]);
      out.cells.push_back(three(error.varus_valgus / deg));
      out.cells.push_back(three(error.flexion_extension / deg));
      if (given(cells, row, "guide_after")) {
        const study::CutError moved =
            study::cut_error(R_BG, normal_of(cells, row, "guide_after"), *side);
        out.cells.push_back(three(moved.varus_valgus / deg));
        out.cells.push_back(three(moved.flexion_extension / deg));
      } else {
        out.cells.insert(out.cells.end(), 2, "");
      }
      if (points) {
        const bool rough = cut_fit && cut_fit->roughness_known;
        out.cells.push_back(cut_fit ? fmt::format("{:.1f}", cut_fit->flatness / units::um) : "");
        out.cells.push_back(rough ? fmt::format("{:.2f}", cut_fit->roughness_rms / units::um) : "");
        out.cells.push_back(
            cut_fit
                ? three(std::max(cut_fit->tilt_sd_about_axis1, cut_fit->tilt_sd_about_axis2) / deg)
                : "");
      }
      if (std::max(std::abs(error.varus_valgus), std::abs(error.flexion_extension)) > 20.0 * deg) {
        result.warnings.push_back(fmt::format(
            "{}:{}: errors of {:.1f} and {:.1f} deg: the frame of guide or cut may be turned or "
            "mirrored",
            cuts.name, row.line, error.varus_valgus / deg, error.flexion_extension / deg));
      }
      result.table.rows.push_back(std::move(out));
    } catch (const InvalidInput& error) {
      cells.add(error, row);
    }
  }
  cells.throw_faults();
  return result;
}

MeasuredPrecision measure_precision(const CsvFile& placements) {
  const MeasuredCuts measured = measure_cuts(placements, std::nullopt);
  std::vector<double> varus, flexion;
  const auto at =
      std::find(measured.table.columns.begin(), measured.table.columns.end(), "varus_valgus_deg") -
      measured.table.columns.begin();
  for (const CsvFile::Row& row : measured.table.rows) {
    varus.push_back(std::stod(row.cells[static_cast<size_t>(at)]) * deg);
    flexion.push_back(std::stod(row.cells[static_cast<size_t>(at) + 1]) * deg);
  }
  return {study::placement_precision(varus), study::placement_precision(flexion)};
}

}  // namespace osteomill::io
