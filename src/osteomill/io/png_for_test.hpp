// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>
#include <png.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <vector>

#include "osteomill/io/colour.hpp"

/// For tests only.
namespace osteomill::io {

struct DecodedPng {
  int width = 0;
  int height = 0;
  std::vector<std::array<int, 3>> pixels;

  const std::array<int, 3>& at(int x, int y) const {
    return pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                  static_cast<std::size_t>(x)];
  }
  /// Pixels that show this colour as it is, not mixed with a neighbour.
  long count(const Colour& colour) const {
    return std::count_if(pixels.begin(), pixels.end(), [&](const auto& pixel) {
      for (std::size_t i = 0; i < 3; ++i)
        if (std::abs(static_cast<float>(pixel[i]) - 255.0F * colour[i]) > 1.5F) return false;
      return true;
    });
  }
};

inline DecodedPng decode(const std::filesystem::path& path) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  EXPECT_TRUE(png_image_begin_read_from_file(&image, path.c_str())) << image.message;
  image.format = PNG_FORMAT_RGB;
  std::vector<unsigned char> bytes(PNG_IMAGE_SIZE(image));
  EXPECT_TRUE(png_image_finish_read(&image, nullptr, bytes.data(), 0, nullptr)) << image.message;
  DecodedPng picture{static_cast<int>(image.width), static_cast<int>(image.height), {}};
  for (std::size_t i = 0; i < bytes.size(); i += 3)
    picture.pixels.push_back({bytes[i], bytes[i + 1], bytes[i + 2]});
  return picture;
}

}  // namespace osteomill::io
