// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/picture.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/io/canvas.hpp"
#include "osteomill/io/ray_scene.hpp"

namespace osteomill::io {
namespace {

using Eigen::Vector3f;

constexpr double kPixel = 2.0;  // pixels a point
constexpr Colour kInk{0.07F, 0.07F, 0.07F};
constexpr Colour kGrey{0.35F, 0.35F, 0.35F};

/// Extent of all that the views show, along the axes of the picture.
struct Extent {
  Vector3f low = Vector3f::Constant(std::numeric_limits<float>::infinity());
  Vector3f high = Vector3f::Constant(-std::numeric_limits<float>::infinity());
  void add(const Vector3f& p, float margin) {
    low = low.cwiseMin(p - Vector3f::Constant(margin));
    high = high.cwiseMax(p + Vector3f::Constant(margin));
  }
};

/// Makes a height of zero as large as the scene needs.
RayScene::Lens lens_of(const Picture& picture, double width, double& height) {
  RayScene::Lens lens;
  const geometry::Vector3& from = picture.camera.from;
  const geometry::Vector3 right = picture.camera.up.cross(from);
  if (!(right.norm() > 1e-9 * picture.camera.up.norm() * from.norm()) || !from.allFinite())
    throw InvalidInput(
        {"picture.camera", "", "must look from somewhere, and not along its up", ""});
  lens.towards = from.normalized().cast<float>();
  lens.right = right.normalized().cast<float>();
  lens.up = lens.towards.cross(lens.right);
  Eigen::Matrix3f axes;
  axes << lens.right.transpose(), lens.up.transpose(), lens.towards.transpose();
  Extent extent;
  for (const PictureView& view : picture.views) {
    for (const PictureMesh& part : view.meshes)
      for (const Vector3f& v : part.mesh.vertices) extent.add(axes * v, 0.0F);
    for (const PictureLine& line : view.lines)
      for (const geometry::Vector3& p : line.points)
        extent.add(axes * p.cast<float>(), static_cast<float>(line.radius));
  }
  if (!extent.low.allFinite() || !extent.high.allFinite())
    throw InvalidInput({"picture", "", "has nothing to see, or a point that is not finite", ""});
  const Vector3f size = extent.high - extent.low;
  lens.centre = axes.transpose() * (0.5F * (extent.low + extent.high));
  lens.reach = std::max(0.5F * size.norm(), 1e-6F);
  lens.parallel = !(picture.camera.field_of_view_deg > 0.0);
  if (height <= 0.0)
    height = std::clamp(lens.parallel ? size.y() / size.x() * width : width, 240.0 * kPixel,
                        0.75 * picture.width * kPixel);
  if (lens.parallel) {
    lens.distance = 2.0F * lens.reach;
    lens.pixel =
        std::max(size.x() / static_cast<float>(width), size.y() / static_cast<float>(height));
  } else {
    const double half = 0.5 * picture.camera.field_of_view_deg * units::deg;
    lens.distance = lens.reach / static_cast<float>(std::sin(half));
    lens.pixel =
        2.0F * lens.distance * static_cast<float>(std::tan(half) / std::min(width, height));
  }
  lens.pixel *= 1.03F;  // a little air around
  lens.pixel = std::max(lens.pixel / static_cast<float>(picture.camera.zoom), 1e-12F);
  return lens;
}

/// The largest of 1, 2, 5 times a power of ten that is not above the value.
double round_down(double value) {
  const double decade = std::pow(10.0, std::floor(std::log10(value)));
  for (const double step : {5.0, 2.0})
    if (step * decade <= value) return step * decade;
  return decade;
}

void draw_legend(Canvas& canvas, const PictureLegend& legend, double x, double y, double height) {
  const int bar = static_cast<int>(12 * kPixel);
  const int left = static_cast<int>(x);
  for (int j = 0; j < static_cast<int>(height); ++j)
    canvas.fill(left, static_cast<int>(y) + j, bar, 1,
                colour_at(legend.colours, 1.0 - (j + 0.5) / height));
  // "apparent density, g/cm³": the unit on a line of its own.
  const std::size_t comma = legend.label.rfind(", ");
  const std::string what = legend.label.substr(0, comma);
  const std::string unit = comma == std::string::npos ? "" : legend.label.substr(comma + 2);
  canvas.text(x, y - (unit.empty() ? 9 : 20) * kPixel, what, 9 * kPixel, Canvas::Align::left, kInk);
  canvas.text(x, y - 8 * kPixel, unit, 9 * kPixel, Canvas::Align::left, kGrey);
  const double span = legend.high - legend.low;
  if (!(span > 0.0)) return;
  const double step = round_down(span / 3.0);
  for (double v = std::ceil(legend.low / step - 1e-9) * step; v <= legend.high + 1e-9 * span;
       v += step) {
    const double at = y + height * (1.0 - (v - legend.low) / span);
    canvas.fill(left + bar, static_cast<int>(at), static_cast<int>(4 * kPixel), 2, kGrey);
    canvas.text(x + bar + 7 * kPixel, at + 3.2 * kPixel,
                fmt::format("{:g}", std::abs(v) < 1e-9 * span ? 0.0 : v), 8.5 * kPixel,
                Canvas::Align::left, kGrey);
  }
}

void draw_scale(Canvas& canvas, double metres_a_pixel, double x, double y) {
  const double length = round_down(90 * kPixel * metres_a_pixel);
  const int pixels = static_cast<int>(std::lround(length / metres_a_pixel));
  const int left = static_cast<int>(x);
  const int base = static_cast<int>(y);
  canvas.fill(left, base, pixels, static_cast<int>(1.5 * kPixel), kGrey);
  for (const int end : {left, left + pixels - 2})
    canvas.fill(end, base - static_cast<int>(3 * kPixel), 2, static_cast<int>(6 * kPixel), kGrey);
  canvas.text(left + 0.5 * pixels, y - 6 * kPixel, fmt::format("{:g} mm", length / units::mm),
              8.5 * kPixel, Canvas::Align::centre, kGrey);
}

}  // namespace

void draw(const Picture& picture, const std::filesystem::path& path) {
  if (picture.views.empty() || picture.width < 200 || (picture.height != 0 && picture.height < 150))
    throw InvalidInput(
        {"picture",
         fmt::format("{} views, {} × {}", picture.views.size(), picture.width, picture.height),
         "must have a view and 200 × 150 points or more", ""});
  const bool legends = picture.mesh_values || picture.line_values;
  const bool captions = std::any_of(picture.views.begin(), picture.views.end(),
                                    [](const PictureView& view) { return !view.caption.empty(); });
  const double margin = 16 * kPixel;
  const double top = (picture.title.empty() ? 10 : 36) * kPixel;
  const double bottom = (captions ? 44 : 30) * kPixel;
  const double right = (legends ? 118 : 16) * kPixel;
  const double gap = 14 * kPixel;
  const double count = static_cast<double>(picture.views.size());
  const double width = (picture.width * kPixel - margin - right - gap * (count - 1)) / count;
  double height = picture.height == 0 ? 0.0 : picture.height * kPixel - top - bottom;
  const RayScene::Lens lens = lens_of(picture, width, height);
  Canvas canvas(static_cast<int>(picture.width * kPixel), static_cast<int>(top + height + bottom));
  for (std::size_t i = 0; i < picture.views.size(); ++i) {
    const double left = margin + (width + gap) * static_cast<double>(i);
    RayScene(picture.views[i], picture, lens)
        .draw(canvas, static_cast<int>(left), static_cast<int>(top), static_cast<int>(width),
              static_cast<int>(height));
    canvas.text(left + 0.5 * width, canvas.height() - 14 * kPixel, picture.views[i].caption,
                10 * kPixel, Canvas::Align::centre, kInk);
  }
  canvas.text(margin, 23 * kPixel, picture.title, 13 * kPixel, Canvas::Align::left, kInk);
  const bool both = picture.mesh_values && picture.line_values;
  const double bar = both ? 0.5 * height - 45 * kPixel : 0.65 * height;
  double y = top + 26 * kPixel;
  for (const auto* legend : {&picture.line_values, &picture.mesh_values}) {
    if (!*legend) continue;
    draw_legend(canvas, **legend, canvas.width() - right + 18 * kPixel, y, bar);
    y += bar + 50 * kPixel;
  }
  if (lens.parallel) draw_scale(canvas, lens.pixel, margin, canvas.height() - 14 * kPixel);
  canvas.save_png(path);
}

}  // namespace osteomill::io
