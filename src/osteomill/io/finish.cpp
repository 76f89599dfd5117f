// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/finish.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_map>

#include "osteomill/base/units.hpp"
#include "osteomill/io/section.hpp"
#include "osteomill/io/surface.hpp"
#include "osteomill/workpiece/cut_surface.hpp"

namespace osteomill::io {
namespace {

using geometry::Vector3;
using Json = nlohmann::ordered_json;
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
// Meshes of more voxels are made of blocks of two: a picture does not show more.
constexpr double kFineVoxels = 6e7;

Vector3 vector_from(const std::array<double, 3>& a) { return {a[0], a[1], a[2]}; }

/// The direction that most of the cutting goes along, in the plane normal to n.
Vector3 feed_of(const workpiece::ToolPath& path, const Vector3& n) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const workpiece::Move& move : path.moves()) {
    if (move.kind != workpiece::MoveKind::cut) continue;
    for (std::size_t i = 1; i < move.points_W.size(); ++i) {
      Vector3 d = move.points_W[i] - move.points_W[i - 1];
      d -= n * n.dot(d);
      if (d.norm() > 0.0) sum += d * d.transpose() / d.norm();
    }
  }
  if (!(sum.trace() > 0.0)) return n.unitOrthogonal();
  const Vector3 d = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(sum).eigenvectors().col(2);
  Eigen::Index largest = 0;
  d.cwiseAbs().maxCoeff(&largest);
  return d[largest] < 0.0 ? Vector3(-d) : d;  // the same sign on any machine
}

Vector3 gradient(const workpiece::Region& region, const Vector3& p, double step) {
  Vector3 g;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const Vector3 e = step * Vector3::Unit(axis);
    g[axis] = region(p + e) - region(p - e);
  }
  return g.norm() > 0.0 ? Vector3(g.normalized()) : Vector3::UnitZ();
}

/// Points by the voxel that they lie in, to find those around a place.
class Nearby {
 public:
  Nearby(const std::vector<workpiece::CutPoint>& points, double cell)
      : points_(points), cell_(cell) {
    for (std::size_t i = 0; i < points.size(); ++i)
      cells_[key(points[i].p_W, 0, 0, 0)].push_back(i);
  }
  /// How far above the surface a place is, by the mean over the tangents of the points within a
  /// voxel or two; nothing where there is none.
  std::optional<std::pair<double, Vector3>> height(const Vector3& p) const {
    double weight = 0.0, sum = 0.0;
    Vector3 normal = Vector3::Zero();
    for (int i = -1; i <= 1; ++i)
      for (int j = -1; j <= 1; ++j)
        for (int k = -1; k <= 1; ++k) {
          const auto found = cells_.find(key(p, i, j, k));
          if (found == cells_.end()) continue;
          for (const std::size_t at : found->second) {
            const Vector3 d = p - points_[at].p_W;
            const double w = std::max(0.0, 1.0 - d.norm() / (1.5 * cell_));
            weight += w;
            sum += w * points_[at].normal_W.dot(d);
            normal += w * points_[at].normal_W;
          }
        }
    if (!(weight > 0.0) || !(normal.norm() > 0.5 * weight)) return {};
    return std::pair{sum / weight, Vector3(normal.normalized())};
  }

 private:
  std::int64_t key(const Vector3& p, int i, int j, int k) const {
    const auto at = [&](double v, int by) {
      return (static_cast<std::int64_t>(std::floor(v / cell_)) + by) & 0x1fffff;
    };
    return at(p.x(), i) | (at(p.y(), j) << 21) | (at(p.z(), k) << 42);
  }
  const std::vector<workpiece::CutPoint>& points_;
  double cell_;
  std::unordered_map<std::int64_t, std::vector<std::size_t>> cells_;
};

Json microns(const study::Roughness& r) {
  if (r.lengths == 0) return nullptr;
  return {
      {"ra_um", r.ra / units::um}, {"rz_um", r.rz / units::um}, {"sampling_lengths", r.lengths}};
}

Json report_of(const study::FinishedSurface& s, const std::optional<study::CutError>& error,
               const cutting::Cutter& cutter, const Vector3& feed) {
  Json report = {{"area_mm2", s.area / units::mm2},
                 {"ledges_mm2", s.beyond_area / units::mm2},
                 {"deviation_mm",
                  {{"mean", s.mean / units::mm},
                   {"rms", s.rms / units::mm},
                   {"lowest", s.lowest / units::mm},
                   {"highest", s.highest / units::mm}}}};
  if (s.fit && error) {
    report["plane"] = {{"varus_valgus_deg", error->varus_valgus / units::deg},
                       {"flexion_extension_deg", error->flexion_extension / units::deg},
                       {"flatness_mm", s.fit->flatness / units::mm},
                       {"flatness_rms_mm", s.fit->flatness_rms / units::mm}};
  }
  report["roughness"] = {{"along", microns(s.along)}, {"across", microns(s.across)}};
  report["feed_direction"] = Json::array({feed.x(), feed.y(), feed.z()});
  if (s.scallops.count > 0) {
    report["scallops"] = {{"count", s.scallops.count},
                          {"mean_um", s.scallops.mean / units::um},
                          {"largest_um", s.scallops.largest / units::um},
                          {"spacing_mm", s.scallops.spacing / units::mm}};
    if (cutter.shape == cutting::CutterShape::ball)
      report["scallops"]["of_the_ball_um"] =
          study::ball_scallop(cutter.radius, s.scallops.spacing) / units::um;
  } else {
    report["scallops"] = nullptr;
  }
  return report;
}

}  // namespace

void bind_finish(Section& section, std::optional<FinishCase>& finish) {
  FinishCase made;
  const Quantity mm{units::mm, "mm"};
  if (section.table("finish", "what is left is measured against [plan]; absent: it is not",
                    Need::optional, [&](Section& s) {
                      using study::CutKind;
                      s.choice<CutKind>("cut", made.cut,
                                        {{"proximal-tibia", CutKind::kProximalTibia},
                                         {"distal-femur", CutKind::kDistalFemur},
                                         {"anterior-femur", CutKind::kAnteriorFemur},
                                         {"posterior-femur", CutKind::kPosteriorFemur}},
                                        "names the sides of the plane's two angles",
                                        Need::optional);
                      s.choice<bool>("knee", made.right_knee, {{"left", false}, {"right", true}},
                                     "which side is medial", Need::optional);
                      s.triple("entry", made.entry, {}, any(),
                               "towards where the tool comes from: to the front on primary cuts",
                               Need::optional);
                      s.number("sampling_length_mm", made.sampling_length, mm, positive(),
                               "of a roughness profile", Need::optional);
                      s.number("reach_mm", made.reach, mm, positive(),
                               "what is farther from the plan is a ledge, no finished surface",
                               Need::optional);
                    }))
    finish = made;
}

std::optional<PlanPlane> plane_of(const PlanCase& planned) {
  switch (planned.kind) {
    case PlanKind::half_space:
      return PlanPlane{vector_from(planned.point), vector_from(planned.normal).normalized()};
    case PlanKind::box:
      return PlanPlane{{0, 0, planned.lower[2]}, Vector3::UnitZ()};
    case PlanKind::tray:
      return PlanPlane{{0, 0, planned.low}, Vector3::UnitZ()};
    default:
      return {};
  }
}

Finish finish_of(const workpiece::Stock& before, const workpiece::Stock& after,
                 const PlanCase& planned, const workpiece::Region& plan,
                 const workpiece::ToolPath& path, const cutting::Cutter& cutter,
                 const FinishCase& options) {
  const std::vector<workpiece::CutPoint> points = workpiece::cut_surface(before, after);
  const std::optional<PlanPlane> plane = plane_of(planned);
  study::FinishedSurfaceOptions how;
  how.normal = plane ? plane->normal : Vector3::UnitZ();
  how.feed = feed_of(path, how.normal);
  how.cell = after.spacing();
  how.sampling_length = options.sampling_length;
  how.reach = options.reach;
  how.plane = plane.has_value();
  const auto deviation = [&](const Vector3& p) {
    return plane ? plane->normal.dot(p - plane->point) : -plan(p);
  };
  std::vector<study::SurfaceSample> samples;
  for (const workpiece::CutPoint& point : points)
    samples.push_back(
        {point.p_W, point.normal_W, deviation(point.p_W),
         plane ? plane->normal : Vector3(-gradient(plan, point.p_W, 0.5 * how.cell))});
  Finish made;
  made.surface = study::measure_surface(samples, how);
  std::optional<study::CutError> error;
  if (made.surface.fit)
    error =
        study::cut_error(study::guide_frame(how.normal, vector_from(options.entry)),
                         made.surface.fit->normal, study::side_of(options.cut, options.right_knee));
  made.report = report_of(made.surface, error, cutter, how.feed);

  SurfaceOptions mesh;
  mesh.simplify = 0.0;
  if (static_cast<double>(after.shape().count()) > kFineVoxels) mesh.coarsen = 2;
  made.mesh = surface_of(after, mesh);
  made.mesh.values.assign(made.mesh.vertices.size(), static_cast<float>(kNone));
  const Nearby nearby(points, after.spacing());
  for (std::size_t v = 0; v < made.mesh.vertices.size(); ++v) {
    const Vector3 p = made.mesh.vertices[v].cast<double>();
    const auto found = nearby.height(p);
    if (!found) continue;
    // Onto the surface between the voxels.
    const Vector3 on = p - found->first * found->second;
    made.mesh.vertices[v] = on.cast<float>();
    made.mesh.values[v] = static_cast<float>(deviation(on));
  }
  const double most = std::max(std::abs(made.surface.lowest), std::abs(made.surface.highest));
  // To 1, 2 or 5 of a power of ten.
  const double unit = std::pow(10.0, std::floor(std::log10(std::max(most / units::mm, 1e-3))));
  const double digit = most / units::mm / unit;
  made.scale = unit * (digit <= 1.0 ? 1.0 : digit <= 2.0 ? 2.0 : digit <= 5.0 ? 5.0 : 10.0);
  return made;
}

Picture finish_picture(const Finish& finish, const std::string& title,
                       const std::vector<geometry::Mesh>& beside) {
  geometry::Mesh cut, rest;
  cut.vertices = rest.vertices = finish.mesh.vertices;
  for (const float value : finish.mesh.values)
    cut.values.push_back(std::isfinite(value) ? value / static_cast<float>(units::mm) : 0.0F);
  for (const auto& triangle : finish.mesh.triangles) {
    const bool whole = std::all_of(triangle.begin(), triangle.end(), [&](unsigned corner) {
      return std::isfinite(finish.mesh.values[corner]);
    });
    (whole ? cut : rest).triangles.push_back(triangle);
  }
  Picture picture;
  picture.title = title;
  PictureView view;
  if (!rest.triangles.empty()) view.meshes.push_back({std::move(rest)});
  if (!cut.triangles.empty()) view.meshes.push_back({std::move(cut)});
  for (const geometry::Mesh& mesh : beside)
    if (mesh.vertices.size() > 3) view.meshes.push_back({mesh, {0.30F, 0.55F, 0.62F}});
  picture.views = {std::move(view)};
  picture.camera.from = Vector3(0.3, -0.7, 1.4);
  picture.mesh_values = {"deviation, mm", -finish.scale, finish.scale, ColourMap::deviation};
  picture.width = 1000;
  return picture;
}

HeatMap finish_map(const Finish& finish, const std::string& title) {
  const study::HeightMap& map = finish.surface.map;
  HeatMap figure;
  figure.title = title;
  figure.x = {.label = "along the feed, mm"};
  figure.y = {.label = "across the feed, mm"};
  figure.value_label = "bone left (+), over-cut (-), um";
  for (int i = 0; i < map.along; ++i)
    figure.x_centres.push_back((map.first_along + i * map.cell) / units::mm);
  for (int j = 0; j < map.across; ++j)
    figure.y_centres.push_back((map.first_across + j * map.cell) / units::mm);
  for (const double d : map.deviations) figure.values.push_back(d / units::um);
  const double most = 1e3 * finish.scale;
  figure.low = -most;
  figure.high = most;
  figure.colours = ColourMap::deviation;
  figure.height = static_cast<int>(
      std::clamp(120.0 + 460.0 * map.across / std::max(1, map.along), 260.0, 720.0));
  return figure;
}

LinePlot finish_profiles(const Finish& finish, const std::string& title) {
  const study::HeightMap& map = finish.surface.map;
  const auto longest = [&](bool along) {
    // The line with most places, the first of those.
    int best = 0, most = -1;
    for (int line = 0; line < (along ? map.across : map.along); ++line) {
      int count = 0;
      for (int k = 0; k < (along ? map.along : map.across); ++k)
        if (std::isfinite(along ? map.at(k, line) : map.at(line, k))) ++count;
      if (count > most) most = count, best = line;
    }
    return best;
  };
  LinePlot plot;
  plot.title = title;
  plot.x = {"place on the profile, mm"};
  for (const bool along : {true, false}) {
    Series series;
    const int line = longest(along);
    int first = -1;  // both profiles from their first place
    for (int k = 0; k < (along ? map.along : map.across); ++k) {
      if (first < 0 && !std::isfinite(along ? map.at(k, line) : map.at(line, k))) continue;
      if (first < 0) first = k;
      series.x.push_back((k - first) * map.cell / units::mm);
      series.y.push_back((along ? map.at(k, line) : map.at(line, k)) / units::um);
    }
    plot.panels.push_back({{along ? "along the feed, um" : "across the feed, um"}, {series}});
  }
  return plot;
}

namespace {

/// With its sign, but for what rounds to nothing.
std::string with_sign(double value, int decimals) {
  const double shown = std::abs(value) < 0.5 * std::pow(10.0, -decimals) ? 0.0 : value;
  return fmt::format("{:+.{}f}", shown, decimals);
}

}  // namespace

std::string finish_sentence(const std::string& name, const Finish& finish) {
  const study::FinishedSurface& s = finish.surface;
  std::string text =
      fmt::format("{}: finished surface {:.0f} mm2, {} mm from the plan on average, {} to {} mm",
                  name, s.area / units::mm2, with_sign(s.mean / units::mm, 3),
                  with_sign(s.lowest / units::mm, 3), with_sign(s.highest / units::mm, 3));
  if (finish.report.contains("plane")) {
    const Json& plane = finish.report.at("plane");
    text += fmt::format(", flat to {:.3f} mm, V/V {} deg, F/E {} deg", s.fit->flatness / units::mm,
                        with_sign(plane.at("varus_valgus_deg").get<double>(), 2),
                        with_sign(plane.at("flexion_extension_deg").get<double>(), 2));
  }
  if (s.along.lengths > 0 && s.across.lengths > 0)
    text += fmt::format("; Ra {:.1f} um along the feed, {:.1f} um across, Rz {:.0f} and {:.0f} um",
                        s.along.ra / units::um, s.across.ra / units::um, s.along.rz / units::um,
                        s.across.rz / units::um);
  if (s.scallops.count > 0)
    text += fmt::format("; ridges of {:.1f} um every {:.2f} mm", s.scallops.mean / units::um,
                        s.scallops.spacing / units::mm);
  return text;
}

}  // namespace osteomill::io
