// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/stock_maker.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/io/ct_volume.hpp"
#include "osteomill/io/solid.hpp"
#include "osteomill/workpiece/fibre_field.hpp"
#include "osteomill/workpiece/shell_bone.hpp"
#include "osteomill/workpiece/thickness.hpp"

namespace osteomill::io {
namespace {

using geometry::Vector3;

// The largest value of a 12-bit scanner; and slices in which a cortical shell is lost.
constexpr int kSaturatedHounsfield = 3071;
constexpr double kPaintSpacing = 0.4 * units::mm;  // half the thinnest layer that is painted
// Between the grid points of a distance the facets of a scanned bone, a millimetre wide, are
// planes; finer fields of a whole bone take gigabytes.
constexpr double kFinestSurface = 0.1 * units::mm;
constexpr double kThickSlice = 3.0 * units::mm;

void check_voxels(const workpiece::Extent& box, double spacing) {
  const Vector3 counts = (box.upper - box.lower) / spacing;
  if (counts.prod() > most_voxels())
    throw InvalidInput(
        Fault{"stock.spacing_mm", fmt::format("{:g} mm", spacing / units::mm),
              fmt::format("makes {:.2g} voxels of the whole bone; the memory of this computer is "
                          "enough for {:.2g}",
                          counts.prod(), most_voxels()),
              "give a region by stock.lower_mm and stock.upper_mm, or a larger spacing"});
}

std::shared_ptr<const workpiece::Stock> place(const StockCase& stock,
                                              const workpiece::Anatomy& anatomy) {
  const geometry::Pose X_PW = work_frame(stock);
  workpiece::Extent box;
  if (stock.lower && stock.upper) {
    box = {vector_of(*stock.lower), vector_of(*stock.upper)};
  } else {
    // Air around the bone, so that the cutter is seen to enter and leave.
    box = workpiece::extent_in(anatomy, X_PW);
    box.lower -= Vector3::Constant(2.0 * stock.spacing);
    box.upper += Vector3::Constant(2.0 * stock.spacing);
  }
  check_voxels(box, stock.spacing);
  return std::make_shared<const workpiece::Stock>(
      workpiece::stock_of(anatomy, X_PW, box, stock.spacing));
}

/// Voxels of the CT in the region (with one beside it) that are at the end of the scanner's scale.
std::size_t saturated_voxels(const StockCase& stock, const CtVolume& ct) {
  const geometry::Pose X_WG = work_frame(stock).inverse() * ct.X_PG;
  const geometry::GridShape& grid = ct.hounsfield.shape();
  const Vector3 beside = Vector3::Constant(grid.spacing.maxCoeff());
  const Vector3 lower = vector_of(*stock.lower) - beside, upper = vector_of(*stock.upper) + beside;
  std::size_t count = 0;
  for (int z = 0; z < grid.size[2]; ++z)
    for (int y = 0; y < grid.size[1]; ++y)
      for (int x = 0; x < grid.size[0]; ++x) {
        if (ct.hounsfield.at(x, y, z) < kSaturatedHounsfield) continue;
        const Vector3 p_W = X_WG * grid.centre(x, y, z);
        if ((p_W.array() > lower.array()).all() && (p_W.array() < upper.array()).all()) ++count;
      }
  return count;
}

void check_ct(const StockCase& stock, const CtVolume& ct) {
  FaultList faults;
  const Vector3 spacing = ct.hounsfield.shape().spacing;
  if (spacing.maxCoeff() > kThickSlice && !stock.accepts("thick-slices"))
    faults.gather([&] {
      throw InvalidInput(
          Fault{"stock.file",
                fmt::format("voxels of {:.2f} x {:.2f} x {:.2f} mm", spacing.x() / units::mm,
                            spacing.y() / units::mm, spacing.z() / units::mm),
                fmt::format("must not be larger than {:g} mm: a cortical shell is lost in them",
                            kThickSlice / units::mm),
                "use a series with thinner slices, or stock.accept = [\"thick-slices\"]"});
    });
  const std::size_t saturated = saturated_voxels(stock, ct);
  if (saturated > 0 && !stock.accepts("metal"))
    faults.gather([&] {
      throw InvalidInput(Fault{
          "stock.file",
          fmt::format("{} voxels of the region at {} HU or above", saturated, kSaturatedHounsfield),
          "must be bone: that is metal or a saturated scan, and what lies around it is "
          "streaked",
          "choose a region away from it, or stock.accept = [\"metal\"] to cut it as the "
          "densest bone"});
    });
  faults.raise();
}

void add_fibres(const StockCase& stock, double threshold,
                const geometry::VoxelGrid<float>& hounsfield, MadeStock& made) {
  const auto field = std::make_shared<const workpiece::FibreField>(
      hounsfield, workpiece::FibreOptions{.cell = stock.fibre_cell, .threshold = threshold});
  const Vector3 mean = field->mean().direction_W;
  made.fibre_W = mean;
  made.fibre_at = [field](const Vector3& p_W) { return field->at(p_W).direction_W; };
  made.report["fibre"] = {
      {"mean_direction", nlohmann::ordered_json::array({mean.x(), mean.y(), mean.z()})},
      {"agreement", field->mean().anisotropy},
      {"share_of_cells", field->share()}};
  made.remarks.push_back(fmt::format(
      "fibres from the CT: {:.0f} % of the cells of {:g} mm have a direction of their own, the "
      "others take the mean (agreement {:.2f}); a clinical CT shows density, not osteons: assumed "
      "to follow",
      100.0 * field->share(), stock.fibre_cell / units::mm, field->mean().anisotropy));
}

MadeStock from_ct(const StockCase& stock, const BoneCase& bone) {
  const CtVolume ct = read_ct(stock.file, {stock.series});
  check_ct(stock, ct);
  // The Hounsfield units are wanted as fine as the voxels, one voxel beyond the region.
  const geometry::GridShape region =
      workpiece::cubes_over(vector_of(*stock.lower), vector_of(*stock.upper), stock.spacing);
  workpiece::BoneFromCt options = stock.bone_from_ct;
  options.force = bone.density;
  const geometry::VoxelGrid<float> hounsfield = resample(ct, region, work_frame(stock));
  MadeStock made;
  made.stock = std::make_shared<const workpiece::Stock>(
      workpiece::stock_from_hounsfield(hounsfield, stock.spacing, options));
  made.remarks = ct.remarks;
  made.report["from"] = ct.description;
  made.report["threshold_hu"] = options.threshold_hu;
  const bone::DensityFromCt published;
  const bool default_line = options.density.at_zero.value == published.at_zero.value &&
                            options.density.per_hounsfield.value == published.per_hounsfield.value;
  made.report["density_calibration"] =
      fmt::format("{:g} + {:g} HU kg/m3, {}", options.density.at_zero.value,
                  options.density.per_hounsfield.value,
                  default_line ? "the published default" : "as the case gives it");
  if (stock.fibre_from_ct) add_fibres(stock, options.threshold_hu, hounsfield, made);
  return made;
}

MadeStock from_mesh(const StockCase& stock, const BoneCase& bone) {
  const MeshFile file = read_solid(stock.file, {.unit = stock.mesh.unit});
  if (file.repair.turned_all && !stock.mesh.turn_inside_out)
    throw InvalidInput(Fault{
        "stock.file", stock.file.filename().string(),
        "is inside out: seen from outside its corners run clockwise",
        "flip the normals in a mesh editor, or stock.turn_inside_out = true if the bone is what "
        "the surface encloses"});
  workpiece::JointPlace joint;
  joint.axis_P = vector_of(stock.mesh.joint_axis.value_or(stock.z_axis));
  joint.shaft = stock.mesh.shaft;
  if (stock.mesh.joint) {
    joint.level_P = vector_of(*stock.mesh.joint);
  } else {
    const auto lower = [&](const Eigen::Vector3f& a, const Eigen::Vector3f& b) {
      return joint.axis_P.dot(a.cast<double>()) < joint.axis_P.dot(b.cast<double>());
    };
    joint.level_P = std::max_element(file.mesh.vertices.begin(), file.mesh.vertices.end(), lower)
                        ->cast<double>();
  }
  workpiece::EpiphysisBone painted = stock.painted;
  painted.force = bone.density;
  // The surface itself from a fine grid, the layers below it from one that reaches deeper: they end
  // where their depth does, what is deeper is all one.
  const double h = stock.spacing;
  const double deepest = std::max({painted.shell_joint, painted.shell_shaft, painted.plate});
  const Solid surface(file.mesh,
                      {.spacing = std::max(0.5 * h, kFinestSurface), .inside = h, .outside = h});
  const Solid depth(file.mesh, {.spacing = std::max(h, kPaintSpacing),
                                .inside = deepest + 2.0 * std::max(h, kPaintSpacing)});
  const auto distance = [surface, depth, h](const Vector3& p_P) {
    const double near = surface.distance(p_P);
    return std::abs(near) < h ? near : depth.distance(p_P);
  };
  MadeStock made;
  made.stock = place(
      stock, workpiece::shell_bone(distance, {surface.lower(), surface.upper()}, joint, painted));
  made.report["from"] = file.description;
  made.report["unit"] = file.unit_reason;
  made.report["repair"] = geometry::describe(file.repair);
  made.remarks.push_back(file.description);
  made.remarks.emplace_back(
      "the surface says nothing of the inside: cortical shell, subchondral plate, cancellous "
      "gradient and marrow are painted by depth, with assumed densities");
  return made;
}

MadeStock from_knee(const StockCase& stock, const BoneCase& bone) {
  workpiece::EpiphysisBone painted = stock.painted;
  painted.force = bone.density;
  workpiece::Anatomy anatomy;
  if (stock.kind == StockKind::proximal_tibia) {
    workpiece::ProximalTibia tibia = stock.proximal_tibia;
    tibia.bone = painted;
    anatomy = workpiece::anatomy_of(tibia);
  } else {
    workpiece::DistalFemur femur = stock.distal_femur;
    femur.bone = painted;
    anatomy = workpiece::anatomy_of(femur);
  }
  MadeStock made;
  made.stock = place(stock, anatomy);
  made.report["from"] = "phantom by code, of adult dimensions";
  made.remarks.emplace_back(
      "the phantom's shape and the densities of its layers are assumed, of adult size");
  return made;
}

/// Where the fibres run along the bone: its axis, in W.
Vector3 along_the_bone(const StockCase& stock) {
  Vector3 axis_P = Vector3::UnitZ();
  if (stock.kind == StockKind::mesh)
    axis_P = vector_of(stock.mesh.joint_axis.value_or(stock.z_axis));
  return (work_frame(stock).linear().transpose() * axis_P).normalized();
}

/// How much the assumed exponent of the density law matters for this bone.
void report_density_law(const workpiece::Stock& stock, const bone::ForceDensityLaw& law,
                        nlohmann::ordered_json& report) {
  // Exponents of strength and stiffness against apparent density in the literature: 1.5 to 2.5.
  constexpr double low = 1.5, high = 2.5;
  const double mean = stock.remaining_mass() / stock.initial_volume();
  const auto scale = [&](double exponent) {
    bone::ForceDensityLaw other = law;
    other.exponent.value = exponent;
    return bone::force_scale(mean, other);
  };
  report["density_law"] = {{"law", "(density / reference)^exponent, assumed"},
                           {"reference_kg_per_m3", law.reference.value},
                           {"exponent", law.exponent.value},
                           {"mean_density_kg_per_m3", mean},
                           {"force_scale_at_mean", scale(law.exponent.value)},
                           {"force_scale_with_exponent_1_5", scale(low)},
                           {"force_scale_with_exponent_2_5", scale(high)}};
}

/// Volume of the bone by density: where the values of apparent density in the literature part
/// cancellous from cortical bone, and trabecular bone from a canal of marrow.
void report_volumes(const workpiece::Stock& stock, nlohmann::ordered_json& report) {
  constexpr double cortical_from = 1000.0, cancellous_from = 100.0;  // kg/m³
  double cortical = 0.0, cancellous = 0.0, marrow = 0.0;
  const geometry::GridShape& shape = stock.shape();
  const workpiece::Stock::Box box = stock.bone_box();
  for (int z = box.first[2]; z <= box.last[2]; ++z)
    for (int y = box.first[1]; y <= box.last[1]; ++y)
      for (int x = box.first[0]; x <= box.last[0]; ++x) {
        const double share = stock.occupancy(x, y, z);
        if (share == 0.0) continue;
        const double density = stock.material(x, y, z).density;
        (density >= cortical_from     ? cortical
         : density >= cancellous_from ? cancellous
                                      : marrow) += share;
      }
  const double voxel = shape.voxel_volume() / units::mm3;
  report["spacing_mm"] = stock.spacing() / units::mm;
  report["voxels"] = shape.size;
  report["volume_mm3"] = stock.initial_volume() / units::mm3;
  report["mass_g"] = 1e3 * stock.remaining_mass();
  report["cortical_mm3"] = cortical * voxel;
  report["cancellous_mm3"] = cancellous * voxel;
  report["marrow_mm3"] = marrow * voxel;
  const workpiece::CorticalThickness shell = workpiece::cortical_thickness(stock, cortical_from);
  if (shell.places > 0)
    report["cortical_thickness_mm"] = {{"p5", shell.p5 / units::mm},
                                       {"median", shell.median / units::mm},
                                       {"p95", shell.p95 / units::mm},
                                       {"share_of_surface", shell.share}};
}

}  // namespace

geometry::Pose work_frame(const StockCase& stock) {
  const Vector3 z = vector_of(stock.z_axis);
  const Vector3 x = vector_of(stock.x_axis);
  const Vector3 across = z.cross(x);
  // Axes closer than a thousandth of a radian do not say where x is.
  if (!(across.norm() > 1e-3 * z.norm() * x.norm())) {
    throw InvalidInput(
        Fault{"stock.x_axis", "", "must not be zero or parallel to stock.z_axis", ""});
  }
  geometry::Pose X_PW = geometry::Pose::Identity();
  X_PW.translation() = vector_of(stock.origin);
  X_PW.linear().col(2) = z.normalized();
  X_PW.linear().col(1) = across.normalized();
  X_PW.linear().col(0) = across.cross(z).normalized();
  return X_PW;
}

MadeStock make_stock(const StockCase& stock, const BoneCase& bone) {
  MadeStock made;
  // Air around the bone, so that the cutter is seen to enter and leave.
  const double margin = 2.0 * stock.spacing;
  switch (stock.kind) {
    case StockKind::ct:
      made = from_ct(stock, bone);
      break;
    case StockKind::mesh:
      made = from_mesh(stock, bone);
      break;
    case StockKind::proximal_tibia:
    case StockKind::distal_femur:
      made = from_knee(stock, bone);
      break;
    case StockKind::tibia_section:
      made.stock = std::make_shared<const workpiece::Stock>(
          workpiece::tibia_section(stock.tibia, stock.spacing, margin));
      made.report["from"] = "tibia section by code";
      break;
    case StockKind::block:
    case StockKind::line_profile: {
      const workpiece::BoneMaterial material{
          stock.density,
          stock.force_scale.value_or(bone::force_scale(stock.density, bone.density))};
      made.stock = std::make_shared<const workpiece::Stock>(workpiece::block(
          vector_of(*stock.lower), vector_of(*stock.upper), material, stock.spacing, margin));
      made.report["from"] = "block by code";
      break;
    }
  }
  if (stock.fibre)
    made.fibre_W = vector_of(*stock.fibre).normalized();
  else if (stock.kind == StockKind::mesh || stock.kind == StockKind::proximal_tibia ||
           stock.kind == StockKind::distal_femur)
    made.fibre_W = along_the_bone(stock);
  report_volumes(*made.stock, made.report);
  if (follows_density(stock)) report_density_law(*made.stock, bone.density, made.report);
  return made;
}

bool follows_density(const StockCase& stock) {
  switch (stock.kind) {
    case StockKind::line_profile:
    case StockKind::tibia_section:
      return false;
    case StockKind::block:
      return !stock.force_scale;
    default:
      return true;
  }
}

}  // namespace osteomill::io
