// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/region_section.hpp"

#include "osteomill/base/units.hpp"
#include "osteomill/io/section.hpp"

namespace osteomill::io {
namespace {

constexpr Quantity kMm{units::mm, "mm"};
constexpr Quantity kPlain{};

void bind_unit(Section& s, LengthUnit& unit) {
  s.choice<LengthUnit>("unit", unit,
                       {{"guess", LengthUnit::guess},
                        {"mm", LengthUnit::millimetre},
                        {"cm", LengthUnit::centimetre},
                        {"m", LengthUnit::metre},
                        {"inch", LengthUnit::inch}},
                       "of the file", Need::optional);
}

void bind_corners(Section& s, std::vector<double>& x, std::vector<double>& y, std::size_t least) {
  s.numbers("x_mm", x, kMm, any(), "x of the corners in the work frame");
  s.numbers("y_mm", y, kMm, any(), "y of the corners");
  if (s.has("x_mm") && s.has("y_mm") && (x.size() != y.size() || x.size() < least))
    s.fault("y_mm", "must be as many as x_mm, three or more for corners");
}

void bind_plan(Section& s, PlanCase& plan) {
  s.choice<PlanKind>("kind", plan.kind,
                     {{"half-space", PlanKind::half_space},
                      {"box", PlanKind::box},
                      {"ball", PlanKind::ball},
                      {"tray", PlanKind::tray},
                      {"femur", PlanKind::femur},
                      {"mesh", PlanKind::mesh},
                      {"surface", PlanKind::surface}},
                     "shape of the bone that is to go; surface: what lies outside the mesh goes");
  const auto is = [&](PlanKind kind) { return s.when(plan.kind == kind); };
  if (is(PlanKind::half_space)) {
    s.triple("point_mm", plan.point, kMm, any(), "on the resection plane, in the work frame");
    s.triple("normal", plan.normal, kPlain, any(), "of the plane, to the side that goes",
             Need::optional);
  }
  if (is(PlanKind::box)) {
    s.triple("lower_mm", plan.lower, kMm, any(), "lower corner in the work frame");
    s.triple("upper_mm", plan.upper, kMm, any(), "upper corner in the work frame");
  }
  if (is(PlanKind::ball)) {
    s.triple("centre_mm", plan.centre, kMm, any(), "middle in the work frame");
    s.number("radius_mm", plan.radius, kMm, positive(), "of the ball");
  }
  if (is(PlanKind::tray)) {
    bind_corners(s, plan.x, plan.y, 3);
    s.number("low_mm", plan.low, kMm, any(), "height of the tray's lower side");
    s.number("high_mm", plan.high, kMm, any(), "up to which bone goes");
  }
  if (is(PlanKind::femur)) {
    s.table("implant", "femoral component with five cuts", Need::required,
            [&](Section& implant) { bind_implant(implant, plan.implant); });
    s.triple("origin_mm", plan.origin, kMm, any(), "middle of the distal cut in the work frame");
    s.triple("distal", plan.distal, kPlain, any(), "direction in the work frame", Need::optional);
    s.triple("anterior", plan.anterior, kPlain, any(), "direction in the work frame",
             Need::optional);
  }
  if (s.when(plan.kind == PlanKind::mesh || plan.kind == PlanKind::surface)) {
    s.file("file", plan.file, "surface in the frame of the CT, the mesh or the phantom");
    bind_unit(s, plan.unit);
  }
}

void bind_no_go(Section& s, NoGoCase& region) {
  s.text("name", region.name, "for the report");
  s.choice<NoGoKind>("kind", region.kind,
                     {{"mesh", NoGoKind::mesh},
                      {"box", NoGoKind::box},
                      {"ball", NoGoKind::ball},
                      {"half-space", NoGoKind::half_space}},
                     "shape", Need::optional);
  s.number("margin_mm", region.margin, kMm, non_negative(), "that stays between it and the tool",
           Need::optional);
  if (s.when(region.kind == NoGoKind::mesh)) {
    s.file("file", region.file, "surface in the frame of the CT, the mesh or the phantom");
    bind_unit(s, region.unit);
  }
  if (s.when(region.kind == NoGoKind::box)) {
    s.triple("lower_mm", region.lower, kMm, any(), "lower corner in the work frame");
    s.triple("upper_mm", region.upper, kMm, any(), "upper corner in the work frame");
  }
  if (s.when(region.kind == NoGoKind::half_space)) {
    s.triple("point_mm", region.point, kMm, any(), "of its plane in the work frame");
    s.triple("normal", region.normal, kPlain, any(), "into what is forbidden", Need::optional);
  }
  if (s.when(region.kind == NoGoKind::ball)) {
    s.triple("centre_mm", region.centre, kMm, any(), "middle in the work frame");
    s.number("radius_mm", region.radius, kMm, positive(), "of the ball");
  }
}

}  // namespace

void bind_regions(Section& section, RegionCase& regions) {
  PlanCase plan;
  if (section.table("plan", "bone that is to go; absent: the path decides", Need::optional,
                    [&](Section& s) { bind_plan(s, plan); }))
    regions.plan = plan;
  section.tables("no_go", "what the tool must keep away from", Need::optional,
                 [&](Section& s, std::size_t) {
                   NoGoCase region;
                   bind_no_go(s, region);
                   regions.no_go.push_back(region);
                 });
  AccessCase access;
  if (section.table(
          "access", "opening that an upright tool has to pass", Need::optional, [&](Section& s) {
            s.number("height_mm", access.height, kMm, any(), "of the opening in the work frame");
            bind_corners(s, access.x, access.y, 1);
            s.number("radius_mm", access.radius, kMm, non_negative(),
                     "of a round opening; then one corner is its middle", Need::optional);
            if ((access.x.size() == 1) != (access.radius > 0.0) || access.x.size() == 2)
              s.fault("x_mm",
                      "must be one middle with radius_mm, or three corners or "
                      "more without");
          }))
    regions.access = access;
}

}  // namespace osteomill::io
