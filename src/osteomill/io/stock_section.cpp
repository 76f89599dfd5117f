// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/stock_section.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>

#include "osteomill/base/units.hpp"
#include "osteomill/io/section.hpp"

namespace osteomill::io {
namespace {

constexpr Quantity kMm{units::mm, "mm"};
constexpr Quantity kDensity{1.0, "kg/m3"};
constexpr Quantity kGain{1e3, "N/(mm/s)"};
constexpr Quantity kNewton{1.0, "N"};
constexpr Quantity kPlain{};

void bind_zone(Section& s, simulate::ProfileZone& zone, double length) {
  s.number("from_mm", zone.from, kMm, non_negative(),
           "start of the zone from the edge of the bone");
  s.number("to_mm", zone.to, kMm, positive(), "end of the zone");
  s.number("gain_n_per_mm_per_s", zone.gain, kGain, non_negative(),
           "cutting force per feed, K of F = K v");
  s.number("gain_end_n_per_mm_per_s", zone.gain_end, kGain, non_negative(),
           "gain at the end of the zone, linear between; absent: constant");
  std::vector<double> numbers;
  s.numbers("lines", numbers, kPlain, between(1, 1000), "lines that have the zone; absent: all",
            Need::optional);
  for (const double number : numbers) zone.lines.push_back(static_cast<int>(number));
  // 1 um: rounding of mm.
  if (zone.to <= zone.from) s.fault("to_mm", "must be greater than from_mm");
  if (zone.to > length + 1e-6) {
    s.fault("to_mm", fmt::format("must be <= stock.length_mm = {:g} mm", length / units::mm));
  }
}

void bind_line_profile(Section& s, StockCase& stock) {
  simulate::LineProfile& profile = stock.profile;
  s.number("length_mm", profile.line_length, kMm, positive(), "length of bone under each line",
           Need::optional);
  s.number("peak_to_mean", profile.peak_to_mean, kPlain, between(1.0, 2.0),
           "largest over mean force within a tooth period", Need::optional);
  s.number("edge_force_n", profile.edge_force, kNewton, non_negative(),
           "mean force at any feed while fully engaged", Need::optional);
  s.tables("zones", "material along the lines; a later zone holds over an earlier one",
           Need::required, [&](Section& zone, std::size_t) {
             simulate::ProfileZone to;
             bind_zone(zone, to, profile.line_length);
             profile.zones.push_back(to);
           });
}

/// A region that may be left out where the bone has an end.
void bind_region(Section& s, StockCase& stock, bool needed) {
  s.triple("lower_mm", stock.lower, kMm, any(),
           "lower corner in the work frame; may be absent where the bone has an end");
  s.triple("upper_mm", stock.upper, kMm, any(), "upper corner in the work frame");
  if (stock.lower.has_value() != stock.upper.has_value() || (needed && !stock.lower))
    s.fault(stock.lower ? "upper_mm" : "lower_mm", "must be given");
  if (!stock.lower || !stock.upper) return;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (!((*stock.upper)[axis] > (*stock.lower)[axis])) {
      s.fault("upper_mm", "must be greater than lower_mm on every axis");
      break;
    }
  }
}

void bind_tibia(Section& s, workpiece::TibiaSection& tibia) {
  s.number("length_mm", tibia.length, kMm, positive(), "size along x", Need::optional);
  s.number("width_mm", tibia.width, kMm, positive(), "size along y", Need::optional);
  s.number("height_mm", tibia.height, kMm, positive(), "size below z = 0", Need::optional);
  s.number("rim_mm", tibia.rim, kMm, positive(), "thickness of the cortical rim", Need::optional);
  s.number("graded_mm", tibia.graded, kMm, non_negative(),
           "width inside the rim over which the bone softens linearly", Need::optional);
  s.number("cortical_density_kg_per_m3", tibia.cortical.density, kDensity, positive(),
           "density of the rim", Need::optional);
  s.number("cancellous_density_kg_per_m3", tibia.cancellous.density, kDensity, positive(),
           "density inside", Need::optional);
  s.number("cortical_force_scale", tibia.cortical.force_scale, kPlain, non_negative(),
           "cutting force of the rim relative to [bone]", Need::optional);
  s.number("cancellous_force_scale", tibia.cancellous.force_scale, kPlain, non_negative(),
           "cutting force inside relative to [bone]", Need::optional);
}

void bind_frame(Section& s, StockCase& stock, Need need) {
  s.triple("origin_mm", stock.origin, kMm, any(),
           "origin of the work frame in the frame of the CT, the mesh or the phantom", need);
  s.triple("x_axis", stock.x_axis, kPlain, any(), "x of the work frame there", Need::optional);
  s.triple("z_axis", stock.z_axis, kPlain, any(), "z of the work frame, towards the spindle, there",
           Need::optional);
}

void bind_painted(Section& s, workpiece::EpiphysisBone& bone, bool canal) {
  s.number("cortical_density_kg_per_m3", bone.cortical, kDensity, positive(), "of the shell",
           Need::optional);
  s.number("subchondral_density_kg_per_m3", bone.subchondral, kDensity, positive(),
           "of the plate below the joint", Need::optional);
  s.number("cancellous_joint_density_kg_per_m3", bone.cancellous_joint, kDensity, positive(),
           "of cancellous bone below the plate", Need::optional);
  s.number("cancellous_shaft_density_kg_per_m3", bone.cancellous_shaft, kDensity, positive(),
           "of cancellous bone gradient_depth_mm below and beyond", Need::optional);
  s.number("gradient_depth_mm", bone.gradient_depth, kMm, positive(),
           "over which cancellous bone thins out", Need::optional);
  s.number("plate_mm", bone.plate, kMm, positive(), "thickness of the subchondral plate",
           Need::optional);
  s.number("shell_joint_mm", bone.shell_joint, kMm, positive(), "cortical thickness at the joint",
           Need::optional);
  s.number("shell_shaft_mm", bone.shell_shaft, kMm, positive(), "cortical thickness at the shaft",
           Need::optional);
  if (!s.when(canal)) return;
  s.number("marrow_from_mm", bone.marrow_from, kMm, positive(),
           "below the joint the canal of the shaft begins here", Need::optional);
  s.number("marrow_density_kg_per_m3", bone.marrow, kDensity, positive(), "bone in the canal",
           Need::optional);
}

void bind_proximal_tibia(Section& s, workpiece::ProximalTibia& tibia) {
  s.number("width_mm", tibia.width, kMm, positive(), "medio-lateral at the plateau",
           Need::optional);
  s.number("depth_mm", tibia.depth, kMm, positive(), "antero-posterior at the plateau",
           Need::optional);
  s.number("shaft_mm", tibia.shaft, kMm, positive(), "diameter at the lower end", Need::optional);
  s.number("length_mm", tibia.length, kMm, positive(), "of the bone below the plateau",
           Need::optional);
  s.number("slope_deg", tibia.slope, {units::deg, "deg"}, between(-30, 30),
           "of the plateau, down backwards", Need::optional);
}

void bind_distal_femur(Section& s, workpiece::DistalFemur& femur) {
  s.number("width_mm", femur.width, kMm, positive(), "medio-lateral over the condyles",
           Need::optional);
  s.number("depth_mm", femur.depth, kMm, positive(), "antero-posterior of the condyles",
           Need::optional);
  s.number("condyle_height_mm", femur.condyle_height, kMm, positive(), "of the condyles",
           Need::optional);
  s.number("notch_mm", femur.notch, kMm, positive(), "width between the condyles", Need::optional);
  s.number("shaft_mm", femur.shaft, kMm, positive(), "diameter at the upper end", Need::optional);
  s.number("length_mm", femur.length, kMm, positive(), "of the bone above the condyles' end",
           Need::optional);
}

void bind_mesh(Section& s, StockCase& stock) {
  s.file("file", stock.file, "surface of the bone: STL, PLY or OBJ");
  s.choice<LengthUnit>("unit", stock.mesh.unit,
                       {{"guess", LengthUnit::guess},
                        {"mm", LengthUnit::millimetre},
                        {"cm", LengthUnit::centimetre},
                        {"m", LengthUnit::metre},
                        {"inch", LengthUnit::inch}},
                       "of the file", Need::optional);
  s.flag("turn_inside_out", stock.mesh.turn_inside_out,
         "turn a surface whose corners run clockwise seen from outside, rather than refuse it");
  s.triple("joint_mm", stock.mesh.joint, kMm, any(),
           "a point at the joint's level, in the frame of the mesh; absent: its end along "
           "joint_axis");
  s.triple("joint_axis", stock.mesh.joint_axis, kPlain, any(),
           "from the shaft to the joint, in the frame of the mesh; absent: z_axis");
  s.number("shaft_from_mm", stock.mesh.shaft, kMm, positive(),
           "below the joint the shell has its thickness at the shaft", Need::optional);
}

void bind_ct(Section& s, StockCase& stock) {
  s.file("file", stock.file, "CT: DICOM folder, NIfTI, NRRD, MetaImage or InVesalius project");
  s.text("series", stock.series, "which series of a DICOM folder", Need::optional);
  s.texts("accept", stock.accept,
          "what is refused otherwise: metal (voxels of the region at 3071 HU or above), "
          "thick-slices (voxels above 3 mm)",
          Need::optional);
  for (const std::string& what : stock.accept)
    if (what != "metal" && what != "thick-slices")
      s.fault("accept", fmt::format("knows no \"{}\"", what), "metal, thick-slices");
  workpiece::BoneFromCt& bone = stock.bone_from_ct;
  s.number("threshold_hu", bone.threshold_hu, {1.0, "HU"}, between(-1000, 4000), "bone from here",
           Need::optional);
  s.number("density_at_0_hu_kg_per_m3", bone.density.at_zero.value, kDensity, any(),
           "apparent density at 0 HU", Need::optional);
  s.number("density_per_hu_kg_per_m3", bone.density.per_hounsfield.value, kDensity, positive(),
           "apparent density for each HU", Need::optional);
}

double vector_norm(const std::array<double, 3>& v) { return std::hypot(v[0], v[1], v[2]); }

}  // namespace

bool StockCase::accepts(const char* what) const {
  return std::find(accept.begin(), accept.end(), what) != accept.end();
}

double most_voxels() {
  return 0.25 * static_cast<double>(sysconf(_SC_PHYS_PAGES)) *
         static_cast<double>(sysconf(_SC_PAGESIZE));
}

void bind_stock(Section& section, StockCase& stock) {
  section.table("stock", "bone before the cut", Need::required, [&](Section& s) {
    s.choice<StockKind>("kind", stock.kind,
                        {{"line-profile", StockKind::line_profile},
                         {"block", StockKind::block},
                         {"tibia-section", StockKind::tibia_section},
                         {"proximal-tibia", StockKind::proximal_tibia},
                         {"distal-femur", StockKind::distal_femur},
                         {"mesh", StockKind::mesh},
                         {"ct", StockKind::ct}},
                        "what the bone is given by");
    const auto is = [&](StockKind kind) { return s.when(stock.kind == kind); };
    const bool knee = stock.kind == StockKind::proximal_tibia ||
                      stock.kind == StockKind::distal_femur || stock.kind == StockKind::mesh;
    s.text("note", stock.note, "what the reader of the result has to know of it", Need::optional);
    if (is(StockKind::line_profile)) bind_line_profile(s, stock);
    if (s.when(stock.kind == StockKind::block || stock.kind == StockKind::ct))
      bind_region(s, stock, true);
    if (is(StockKind::block)) {
      s.number("density_kg_per_m3", stock.density, kDensity, positive(), "density of the block");
      s.number("force_scale", stock.force_scale, kPlain, non_negative(),
               "cutting force relative to [bone]; absent: by density");
    }
    if (is(StockKind::tibia_section)) bind_tibia(s, stock.tibia);
    // Its joint looks at the spindle.
    if (stock.kind == StockKind::distal_femur) stock.z_axis = {0, 0, -1};
    if (is(StockKind::proximal_tibia)) bind_proximal_tibia(s, stock.proximal_tibia);
    if (is(StockKind::distal_femur)) bind_distal_femur(s, stock.distal_femur);
    if (is(StockKind::mesh)) bind_mesh(s, stock);
    if (is(StockKind::ct)) bind_ct(s, stock);
    if (s.when(knee)) {
      bind_region(s, stock, false);
      bind_painted(s, stock.painted, stock.kind == StockKind::mesh);
    }
    if (s.when(knee || stock.kind == StockKind::ct))
      bind_frame(s, stock, stock.kind == StockKind::ct ? Need::required : Need::optional);
    if (is(StockKind::ct)) {
      s.flag("fibre_from_ct", stock.fibre_from_ct,
             "the bone's fibres run where the CT changes least, cell by cell");
      if (s.when(stock.fibre_from_ct))
        s.number("fibre_cell_mm", stock.fibre_cell, kMm, positive(), "edge of these cells",
                 Need::optional);
    }
    if (s.when(stock.kind != StockKind::line_profile)) {
      s.triple("fibre", stock.fibre, kPlain, any(),
               "direction of the bone's fibres in the work frame; absent: along the bone (mesh and "
               "knee phantoms), x otherwise");
      if (stock.fibre && vector_norm(*stock.fibre) < 1e-9) s.fault("fibre", "must not be zero");
      if (stock.fibre && stock.fibre_from_ct)
        s.fault("fibre", "must not stand beside fibre_from_ct");
      s.number("spacing_mm", stock.spacing, kMm, up_to(5.0), "edge of a voxel", Need::optional);
      if (!stock.lower || !stock.upper) return;
      double voxels = 1.0;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        voxels *= std::max(0.0, (*stock.upper)[axis] - (*stock.lower)[axis]) / stock.spacing;
      }
      if (voxels > most_voxels()) {
        s.fault("spacing_mm",
                fmt::format("makes {:.2g} voxels; the memory of this computer is enough for {:.2g}",
                            voxels, most_voxels()),
                "use a larger spacing or a smaller region");
      }
    }
  });
}

}  // namespace osteomill::io
