// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "osteomill/io/canvas.hpp"
#include "osteomill/io/picture.hpp"

namespace osteomill::io {

/// What a view shows, ready for rays of light (embree).
class RayScene {
 public:
  /// From where, and how large, it is seen.
  struct Lens {
    Eigen::Vector3f centre;  ///< of the picture, m
    Eigen::Vector3f right;   ///< unit vectors along the picture
    Eigen::Vector3f up;
    Eigen::Vector3f towards;  ///< unit vector from the scene to the eye
    float pixel = 0.0F;       ///< m a pixel, at the centre
    float distance = 0.0F;    ///< of the eye from the centre, m
    bool parallel = true;     ///< the rays, or they meet in the eye
    float reach = 0.0F;       ///< half the diagonal of all that is seen, m
  };

  RayScene(const PictureView& view, const Picture& picture, const Lens& lens);
  ~RayScene();
  RayScene(const RayScene&) = delete;
  RayScene& operator=(const RayScene&) = delete;

  /// Draws into the rectangle of the sheet, which stays as it is where there is nothing.
  void draw(Canvas& canvas, int x0, int y0, int width, int height) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace osteomill::io
