// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/ray_scene.hpp"

#include <embree3/rtcore.h>
#include <fmt/format.h>
#include <tbb/blocked_range2d.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>

#include "osteomill/base/error.hpp"

namespace osteomill::io {
namespace {

using Eigen::Vector3f;

constexpr int kSamplesAcross = 2;     // per pixel and direction, against stairs at edges
constexpr double kSkyRays = 3e6;      // in all, over the vertices
constexpr float kSeenThrough = 0.6F;  // share of a line that shows through what is before it
constexpr float kCrease = 0.80F;      // cosine: flatter edges are rounded off in the light
constexpr Colour kNoValue{0.72F, 0.72F, 0.72F};

float to_linear(float v) { return std::pow(v, 2.2F); }
float to_screen(float v) { return std::pow(std::clamp(v, 0.0F, 1.0F), 1.0F / 2.2F); }

Vector3f linear(const Colour& c) { return {to_linear(c[0]), to_linear(c[1]), to_linear(c[2])}; }

Vector3f coloured(double value, const std::optional<PictureLegend>& legend) {
  if (!legend || !std::isfinite(value)) return linear(kNoValue);
  const double span = legend->high - legend->low;
  return linear(colour_at(legend->colours, span > 0.0 ? (value - legend->low) / span : 0.5));
}

/// Numbers that look random and depend on nothing but their place: the picture is the same however
/// the work is shared.
float scattered(std::uint32_t x, std::uint32_t y, std::uint32_t k) {
  std::uint32_t h = x * 0x9E3779B1u ^ y * 0x85EBCA77u ^ k * 0xC2B2AE3Du;
  h ^= h >> 15;
  h *= 0x2C1B3C6Du;
  h ^= h >> 12;
  h *= 0x297A2D39u;
  h ^= h >> 15;
  return static_cast<float>(h >> 8) * 0x1p-24F;
}

/// A direction about the normal, more often near it, as the light of an even sky comes in.
Vector3f sky_direction(const Vector3f& normal, float u, float v) {
  const float r = std::sqrt(u);
  const float angle = 2.0F * std::numbers::pi_v<float> * v;
  const Vector3f side = normal.unitOrthogonal();
  return (side * (r * std::cos(angle)) + normal.cross(side) * (r * std::sin(angle)) +
          normal * std::sqrt(std::max(0.0F, 1.0F - u)))
      .normalized();
}

void check(const geometry::Mesh& mesh) {
  for (const Vector3f& vertex : mesh.vertices)
    if (!vertex.allFinite())
      throw InvalidInput({"picture.mesh", "", "has a vertex that is not finite", ""});
  for (const auto& triangle : mesh.triangles)
    for (const unsigned corner : triangle)
      if (corner >= mesh.vertices.size())
        throw InvalidInput({"picture.mesh", fmt::format("corner {}", corner),
                            fmt::format("there are {} vertices", mesh.vertices.size()), ""});
  if (!mesh.values.empty() && mesh.values.size() != mesh.vertices.size())
    throw InvalidInput({"picture.mesh", fmt::format("{} values", mesh.values.size()),
                        "must be one a vertex, or none", ""});
}

/// A mesh with what its light needs.
struct Surface {
  std::vector<std::array<unsigned, 3>> triangles;
  std::vector<Vector3f> corner_normals;  ///< three a triangle, averaged up to creases
  std::vector<Vector3f> vertex_normals;
  std::vector<Vector3f> colours;  ///< linear
  std::vector<float> sky;         ///< share of the sky that a vertex sees

  Surface(const PictureMesh& part, const std::optional<PictureLegend>& legend)
      : triangles(part.mesh.triangles) {
    const geometry::Mesh& mesh = part.mesh;
    colours.assign(mesh.vertices.size(), linear(part.colour));
    for (std::size_t v = 0; v < mesh.values.size(); ++v)
      colours[v] = coloured(mesh.values[v], legend);

    std::vector<Vector3f> areas(triangles.size());
    vertex_normals.assign(mesh.vertices.size(), Vector3f::Zero());
    std::vector<unsigned> first(mesh.vertices.size() + 1, 0);
    for (std::size_t t = 0; t < triangles.size(); ++t) {
      const auto& [a, b, c] = triangles[t];
      // In mm², so that small triangles do not vanish in single precision.
      areas[t] =
          (mesh.vertices[b] - mesh.vertices[a]).cross(mesh.vertices[c] - mesh.vertices[a]) * 1e6F;
      for (const unsigned corner : triangles[t]) {
        ++first[corner + 1];
        vertex_normals[corner] += areas[t];
      }
    }
    for (Vector3f& normal : vertex_normals) normal.stableNormalize();
    for (std::size_t v = 1; v < first.size(); ++v) first[v] += first[v - 1];
    std::vector<unsigned> around(first.back());
    std::vector<unsigned> next = first;
    for (std::size_t t = 0; t < triangles.size(); ++t)
      for (const unsigned corner : triangles[t]) around[next[corner]++] = static_cast<unsigned>(t);
    corner_normals.resize(triangles.size() * 3);
    tbb::parallel_for(std::size_t{0}, triangles.size(), [&](std::size_t t) {
      const Vector3f own = areas[t].stableNormalized();
      for (std::size_t k = 0; k < 3; ++k) {
        const unsigned corner = triangles[t][k];
        Vector3f sum = Vector3f::Zero();
        for (unsigned i = first[corner]; i < first[corner + 1]; ++i)
          if (areas[around[i]].stableNormalized().dot(own) >= kCrease) sum += areas[around[i]];
        corner_normals[3 * t + k] = sum.squaredNorm() > 0.0F ? sum.stableNormalized() : own;
      }
    });
  }

  template <class T>
  static T mixed(const T& a, const T& b, const T& c, float u, float v) {
    return a * (1.0F - u - v) + b * u + c * v;
  }
};

/// An embree scene with the shapes attached to it in order.
class Shapes {
 public:
  explicit Shapes(RTCDevice device) : device_(device), scene_(rtcNewScene(device)) {}
  ~Shapes() { rtcReleaseScene(scene_); }
  Shapes(const Shapes&) = delete;
  Shapes& operator=(const Shapes&) = delete;

  void add(const geometry::Mesh& mesh) {
    RTCGeometry shape = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* vertices = static_cast<float*>(
        rtcSetNewGeometryBuffer(shape, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                3 * sizeof(float), mesh.vertices.size()));
    for (const Vector3f& v : mesh.vertices)
      for (int i = 0; i < 3; ++i) *vertices++ = v[i];
    auto* corners = static_cast<unsigned*>(
        rtcSetNewGeometryBuffer(shape, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                3 * sizeof(unsigned), mesh.triangles.size()));
    for (const auto& triangle : mesh.triangles)
      corners = std::copy(triangle.begin(), triangle.end(), corners);
    attach(shape);
  }

  void add(const PictureLine& line) {
    RTCGeometry shape = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_ROUND_LINEAR_CURVE);
    auto* points = static_cast<float*>(rtcSetNewGeometryBuffer(shape, RTC_BUFFER_TYPE_VERTEX, 0,
                                                               RTC_FORMAT_FLOAT4, 4 * sizeof(float),
                                                               line.points.size()));
    for (const geometry::Vector3& p : line.points) {
      for (int i = 0; i < 3; ++i) *points++ = static_cast<float>(p[i]);
      *points++ = static_cast<float>(line.radius);
    }
    auto* segments = static_cast<unsigned*>(
        rtcSetNewGeometryBuffer(shape, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT, sizeof(unsigned),
                                line.points.size() - 1));
    for (unsigned i = 0; i + 1 < line.points.size(); ++i) segments[i] = i;
    attach(shape);
  }

  void commit() { rtcCommitScene(scene_); }

  struct Hit {
    unsigned shape = 0;
    unsigned part = 0;
    float u = 0.0F;
    float v = 0.0F;
    float distance = 0.0F;
    Vector3f normal;
  };

  std::optional<Hit> hit(const Vector3f& from, const Vector3f& direction) const {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    RTCRayHit ray{ray_of(from, direction, 0.0F, std::numeric_limits<float>::infinity()), {}};
    ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(scene_, &context, &ray);
    if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID) return {};
    return Hit{
        ray.hit.geomID, ray.hit.primID,
        ray.hit.u,      ray.hit.v,
        ray.ray.tfar,   Vector3f(ray.hit.Ng_x, ray.hit.Ng_y, ray.hit.Ng_z).stableNormalized()};
  }

  bool blocks(const Vector3f& from, const Vector3f& direction, float near, float far) const {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    RTCRay ray = ray_of(from, direction, near, far);
    rtcOccluded1(scene_, &context, &ray);
    return ray.tfar < 0.0F;
  }

 private:
  static RTCRay ray_of(const Vector3f& from, const Vector3f& direction, float near, float far) {
    RTCRay ray{};
    ray.org_x = from.x(), ray.org_y = from.y(), ray.org_z = from.z();
    ray.dir_x = direction.x(), ray.dir_y = direction.y(), ray.dir_z = direction.z();
    ray.tnear = near;
    ray.tfar = far;
    ray.mask = ~0u;
    return ray;
  }

  void attach(RTCGeometry shape) {
    rtcCommitGeometry(shape);
    rtcAttachGeometry(scene_, shape);
    rtcReleaseGeometry(shape);
  }

  RTCDevice device_;
  RTCScene scene_;
};

}  // namespace

struct RayScene::Impl {
  struct Device {
    RTCDevice is = rtcNewDevice(nullptr);
    Device() = default;
    Device(const Device&) = delete;
    Device& operator=(const Device&) = delete;
    ~Device() { rtcReleaseDevice(is); }
  };

  Device device;
  Shapes bone{device.is};
  Shapes paths{device.is};
  std::vector<Surface> surfaces;
  std::vector<std::vector<Vector3f>> path_colours;
  Lens lens;

  void add(const PictureMesh& part, const std::optional<PictureLegend>& legend) {
    check(part.mesh);
    if (part.mesh.triangles.empty()) return;
    bone.add(part.mesh);
    surfaces.emplace_back(part, legend);
  }

  void add(const PictureLine& line, const std::optional<PictureLegend>& legend) {
    if (!line.values.empty() && line.values.size() != line.points.size())
      throw InvalidInput(
          {"picture.line", fmt::format("{} values", line.values.size()),
           fmt::format("must be one for each of {} points, or none", line.points.size()), ""});
    for (const geometry::Vector3& point : line.points)
      if (!point.allFinite())
        throw InvalidInput({"picture.line", "", "has a point that is not finite", ""});
    if (line.points.size() < 2) return;
    paths.add(line);
    std::vector<Vector3f> colours(line.points.size(), linear(line.colour));
    for (std::size_t i = 0; i < line.values.size(); ++i)
      colours[i] = coloured(line.values[i], legend);
    path_colours.push_back(std::move(colours));
  }

  /// How much of the sky each vertex sees: hollows are darker. Rays are shared out over all
  /// vertices, so that the work does not grow with them.
  void look_at_the_sky(const PictureView& view) {
    std::size_t vertices = 0;
    for (const Surface& surface : surfaces) vertices += surface.colours.size();
    const auto rays = static_cast<std::uint32_t>(
        std::clamp(kSkyRays / static_cast<double>(std::max<std::size_t>(1, vertices)), 8.0, 64.0));
    std::size_t next = 0;
    for (const PictureMesh& part : view.meshes) {
      if (part.mesh.triangles.empty()) continue;
      Surface& surface = surfaces[next++];
      surface.sky.resize(surface.colours.size());
      tbb::parallel_for(std::size_t{0}, surface.sky.size(), [&](std::size_t v) {
        const Vector3f& normal = surface.vertex_normals[v];
        surface.sky[v] = 1.0F;
        if (!(normal.squaredNorm() > 0.5F)) return;  // of no triangle
        const Vector3f start = part.mesh.vertices[v] + normal * lift();
        std::uint32_t open = 0;
        for (std::uint32_t k = 0; k < rays; ++k) {
          const float turn = scattered(static_cast<std::uint32_t>(v), 7, k);
          const Vector3f way = sky_direction(
              normal, (static_cast<float>(k) + 0.5F) / static_cast<float>(rays), turn);
          if (!bone.blocks(start, way, lift(), 0.35F * lens.reach)) ++open;
        }
        surface.sky[v] = static_cast<float>(open) / static_cast<float>(rays);
      });
      smooth(surface);
    }
  }

  /// One step towards the mean of the neighbours takes the grain of the few rays away.
  static void smooth(Surface& surface) {
    std::vector<float> sum(surface.sky.size(), 0.0F);
    std::vector<float> count(surface.sky.size(), 0.0F);
    for (const auto& [a, b, c] : surface.triangles) {
      const float mean = (surface.sky[a] + surface.sky[b] + surface.sky[c]) / 3.0F;
      for (const unsigned corner : {a, b, c}) sum[corner] += mean, count[corner] += 1.0F;
    }
    for (std::size_t v = 0; v < sum.size(); ++v)
      if (count[v] > 0.0F) surface.sky[v] = sum[v] / count[v];
  }

  float lift() const { return 1e-4F * lens.reach; }

  /// Light of a surface under one large lamp beside the eye and an even sky.
  Vector3f light(const Vector3f& own, const Vector3f& normal, const Vector3f& flat,
                 const Vector3f& place, const Vector3f& direction, float sky,
                 const std::array<std::uint32_t, 3>& seed, bool shadows) const {
    const Vector3f lamp = (lens.towards * 0.9F + lens.up * 0.75F - lens.right * 0.55F).normalized();
    const Vector3f blur(scattered(seed[0], seed[1], seed[2]) - 0.5F,
                        scattered(seed[0], seed[1], seed[2] + 1) - 0.5F,
                        scattered(seed[0], seed[1], seed[2] + 2) - 0.5F);
    const Vector3f key = (lamp + 0.12F * blur).normalized();
    const float facing = normal.dot(key);
    const bool lit = facing > 0.0F && (!shadows || !bone.blocks(place + flat * lift(), key, lift(),
                                                                4.0F * lens.reach));
    const float overhead = 0.5F + 0.5F * normal.dot(lens.up);
    const float shine =
        lit ? 0.04F * std::pow(std::max(0.0F, normal.dot((key - direction).normalized())), 40.0F)
            : 0.0F;
    const Vector3f warm(1.0F, 0.97F, 0.92F);
    const Vector3f cool(0.92F, 0.96F, 1.0F);
    return own.cwiseProduct(cool * (sky * (0.46F + 0.22F * overhead)) +
                            warm * (lit ? 0.66F * facing : 0.0F)) +
           warm * shine;
  }

  /// Light that comes back along the ray, linear; nothing when it meets nothing.
  std::optional<Vector3f> trace(const Vector3f& from, const Vector3f& direction,
                                const std::array<std::uint32_t, 3>& seed) const {
    const auto at_bone = bone.hit(from, direction);
    const auto at_path = paths.hit(from, direction);
    std::optional<Vector3f> seen;
    if (at_bone) {
      const Surface& surface = surfaces[at_bone->shape];
      const std::size_t part = at_bone->part;
      const auto& [a, b, c] = surface.triangles[part];
      const float u = at_bone->u;
      const float v = at_bone->v;
      Vector3f flat = at_bone->normal;
      Vector3f normal =
          Surface::mixed(surface.corner_normals[3 * part], surface.corner_normals[3 * part + 1],
                         surface.corner_normals[3 * part + 2], u, v)
              .stableNormalized();
      if (flat.dot(direction) > 0.0F) flat = -flat, normal = -normal;
      const Vector3f own =
          Surface::mixed(surface.colours[a], surface.colours[b], surface.colours[c], u, v);
      const float sky = Surface::mixed(surface.sky[a], surface.sky[b], surface.sky[c], u, v);
      seen = light(own, normal, flat, from + direction * at_bone->distance, direction, sky, seed,
                   true);
    }
    if (at_path) {
      const std::vector<Vector3f>& colours = path_colours[at_path->shape];
      const Vector3f own =
          colours[at_path->part] * (1.0F - at_path->u) + colours[at_path->part + 1] * at_path->u;
      const Vector3f normal =
          at_path->normal.dot(direction) > 0.0F ? Vector3f(-at_path->normal) : at_path->normal;
      const Vector3f line = light(own, normal, normal, from + direction * at_path->distance,
                                  direction, 1.0F, seed, false);
      const bool behind = seen && at_bone->distance < at_path->distance;
      seen = behind ? Vector3f(kSeenThrough * line + (1.0F - kSeenThrough) * *seen) : line;
    }
    return seen;
  }
};

RayScene::RayScene(const PictureView& view, const Picture& picture, const Lens& lens)
    : impl_(std::make_unique<Impl>()) {
  impl_->lens = lens;
  for (const PictureMesh& mesh : view.meshes) impl_->add(mesh, picture.mesh_values);
  for (const PictureLine& line : view.lines) impl_->add(line, picture.line_values);
  impl_->bone.commit();
  impl_->paths.commit();
  impl_->look_at_the_sky(view);
}

RayScene::~RayScene() = default;

void RayScene::draw(Canvas& canvas, int x0, int y0, int width, int height) const {
  const Lens& lens = impl_->lens;
  const Vector3f eye = lens.centre + lens.towards * lens.distance;
  const auto draw_pixel = [&](int x, int y) {
    Vector3f sum = Vector3f::Zero();
    int hits = 0;
    for (int s = 0; s < kSamplesAcross * kSamplesAcross; ++s) {
      const float dx = (static_cast<float>(s % kSamplesAcross) + 0.5F) / kSamplesAcross;
      const float dy = (static_cast<float>(s / kSamplesAcross) + 0.5F) / kSamplesAcross;
      const float right =
          lens.pixel * (static_cast<float>(x) + dx - 0.5F * static_cast<float>(width));
      const float down =
          lens.pixel * (static_cast<float>(y) + dy - 0.5F * static_cast<float>(height));
      const Vector3f on_sheet = lens.centre + lens.right * right - lens.up * down;
      const Vector3f from = lens.parallel ? Vector3f(on_sheet + lens.towards * lens.distance) : eye;
      const auto seen = impl_->trace(from, (on_sheet - from).normalized(),
                                     {static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y),
                                      static_cast<std::uint32_t>(s) * 4});
      if (!seen) continue;
      sum += *seen;
      ++hits;
    }
    if (hits == 0) return;
    sum /= static_cast<float>(hits);
    canvas.blend(x0 + x, y0 + y, {to_screen(sum.x()), to_screen(sum.y()), to_screen(sum.z())},
                 static_cast<float>(hits) / (kSamplesAcross * kSamplesAcross));
  };
  tbb::parallel_for(tbb::blocked_range2d<int>(0, height, 16, 0, width, 16),
                    [&](const tbb::blocked_range2d<int>& tile) {
                      for (int y = tile.rows().begin(); y < tile.rows().end(); ++y)
                        for (int x = tile.cols().begin(); x < tile.cols().end(); ++x)
                          draw_pixel(x, y);
                    });
}

}  // namespace osteomill::io
