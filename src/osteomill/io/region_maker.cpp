// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/region_maker.hpp"

#include <fmt/format.h>

#include <array>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/io/solid.hpp"
#include "osteomill/io/stock_maker.hpp"

namespace osteomill::io {
namespace {

using geometry::Vector3;
using workpiece::Region;

geometry::Mesh in_work_frame(geometry::Mesh mesh, const StockCase& stock) {
  const geometry::Pose X_WP = work_frame(stock).inverse();
  for (Eigen::Vector3f& vertex : mesh.vertices)
    vertex = (X_WP * vertex.cast<double>()).cast<float>();
  return mesh;
}

/// What the five cuts of a femoral component take off, no farther up than the ends of its anterior
/// and its posterior cut.
Region five_cuts(const PlanCase& plan) {
  const robot::Profile profile = implant_of(plan.implant).profile;
  geometry::Pose X_WI = geometry::Pose::Identity();
  const Vector3 x = vector_of(plan.distal).normalized();
  const Vector3 across = x.cross(vector_of(plan.anterior));
  if (!(across.norm() > 1e-3))
    throw InvalidInput(
        Fault{"plan.anterior", "", "must not be zero or parallel to plan.distal", ""});
  X_WI.linear().col(0) = x;
  X_WI.linear().col(2) = across.normalized();
  X_WI.linear().col(1) = X_WI.linear().col(2).cross(x);
  X_WI.translation() = vector_of(plan.origin);
  const auto point = [&](const robot::Vector2& p) -> Vector3 {
    return X_WI * Vector3(p.x(), p.y(), 0.0);
  };
  const auto direction = [&](double dx, double dy) -> Vector3 {
    return X_WI.linear() * Vector3(dx, dy, 0.0);
  };
  std::array<Region, 5> cuts;
  for (std::size_t i = 0; i < 5; ++i) {
    const robot::Vector2 a = profile.corners[i], b = profile.corners[i + 1];
    // From anterior around to posterior the bone lies on the right.
    cuts[i] = workpiece::half_space(point(a), direction(-(b - a).y(), (b - a).x()));
  }
  const Region below_anterior = workpiece::half_space(point(profile.corners[0]), direction(1, 0));
  const Region below_posterior = workpiece::half_space(point(profile.corners[5]), direction(1, 0));
  return workpiece::any_of({workpiece::all_of({cuts[0], below_anterior}), cuts[1], cuts[2], cuts[3],
                            workpiece::all_of({cuts[4], below_posterior})});
}

Region solid_region(const PlanCase& plan, const StockCase& stock,
                    std::vector<std::string>& remarks) {
  const MeshFile file = read_solid(plan.file, {.unit = plan.unit});
  remarks.push_back(fmt::format("plan: {}", file.description));
  // Depths of millimetres are asked for by passes that let a ball down on it.
  const Solid solid(
      in_work_frame(file.mesh, stock),
      {.spacing = stock.spacing, .inside = 5.0 * units::mm, .outside = 5.0 * units::mm});
  Region inside = [solid](const Vector3& p_W) { return solid.distance(p_W); };
  return plan.kind == PlanKind::mesh ? inside : workpiece::outside(inside);
}

Region make_plan(const PlanCase& plan, const StockCase& stock, std::vector<std::string>& remarks) {
  switch (plan.kind) {
    case PlanKind::box:
      return workpiece::box(vector_of(plan.lower), vector_of(plan.upper));
    case PlanKind::ball:
      return workpiece::ball(vector_of(plan.centre), plan.radius);
    case PlanKind::tray: {
      workpiece::Polygon polygon;
      for (std::size_t i = 0; i < plan.x.size(); ++i) polygon.emplace_back(plan.x[i], plan.y[i]);
      return workpiece::prism(workpiece::outline_of({polygon}), plan.low, plan.high);
    }
    case PlanKind::femur:
      return five_cuts(plan);
    case PlanKind::mesh:
    case PlanKind::surface:
      return solid_region(plan, stock, remarks);
    case PlanKind::half_space:
      break;
  }
  return workpiece::half_space(vector_of(plan.point), vector_of(plan.normal));
}

workpiece::NoGo make_no_go(const NoGoCase& from, const StockCase& stock,
                           std::vector<std::string>& remarks) {
  if (from.kind == NoGoKind::box)
    return workpiece::no_go_box(from.name, vector_of(from.lower), vector_of(from.upper),
                                from.margin);
  if (from.kind == NoGoKind::half_space)
    return workpiece::no_go_half_space(from.name, vector_of(from.point), vector_of(from.normal),
                                       from.margin);
  if (from.kind == NoGoKind::ball)
    return workpiece::no_go_ball(from.name, vector_of(from.centre), from.radius, from.margin);
  // A surface with holes is as good to keep away from.
  MeshFile file = read_mesh(from.file, {.unit = from.unit});
  remarks.push_back(fmt::format("no-go region {}: {}", from.name, file.description));
  return {from.name, in_work_frame(std::move(file.mesh), stock), 0.0, from.margin};
}

workpiece::AccessWindow make_access(const AccessCase& access) {
  if (access.radius > 0.0)
    return {workpiece::circle({access.x[0], access.y[0]}, access.radius), access.height};
  workpiece::Polygon polygon;
  for (std::size_t i = 0; i < access.x.size(); ++i) polygon.emplace_back(access.x[i], access.y[i]);
  return {workpiece::outline_of({polygon}), access.height};
}

}  // namespace

MadeRegions make_regions(const RegionCase& regions, const StockCase& stock) {
  MadeRegions made;
  FaultList faults;
  if (regions.plan)
    faults.gather([&] { made.plan = make_plan(*regions.plan, stock, made.remarks); });
  for (const NoGoCase& from : regions.no_go)
    faults.gather([&] { made.no_go.push_back(make_no_go(from, stock, made.remarks)); });
  if (regions.access) faults.gather([&] { made.access = make_access(*regions.access); });
  faults.raise();
  return made;
}

nlohmann::ordered_json plan_report(const workpiece::Stock& before, const workpiece::Stock& after,
                                   const workpiece::Region& plan) {
  const workpiece::PlanResult result = workpiece::compare(before, after, plan);
  return {{"planned_volume_mm3", result.planned_volume / units::mm3},
          {"removed_volume_mm3", result.removed_volume / units::mm3},
          {"uncut_volume_mm3", result.uncut_volume / units::mm3},
          {"over_cut_volume_mm3", result.over_cut_volume / units::mm3},
          {"uncut_height_mm", result.uncut_height / units::mm},
          {"over_cut_depth_mm", result.over_cut_depth / units::mm}};
}

}  // namespace osteomill::io
