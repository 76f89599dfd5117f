// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "osteomill/io/colour.hpp"

namespace osteomill::io {

/// A sheet of pixels to draw on, white at first. Pixel (0, 0) is at the upper left.
class Canvas {
 public:
  enum class Align { left, centre, right };

  Canvas(int width, int height);
  int width() const { return width_; }
  int height() const { return height_; }

  void set(int x, int y, const Colour& colour) { pixels_[index(x, y)] = colour; }
  const Colour& at(int x, int y) const { return pixels_[index(x, y)]; }
  /// Lays the colour over the pixel; what lies outside the sheet is left out.
  void blend(int x, int y, const Colour& colour, float share);
  void fill(int x, int y, int width, int height, const Colour& colour);
  /// One line of UTF-8 in DejaVu Sans; (x, y) is on its base line, size is that of the em in
  /// pixels.
  void text(double x, double y, const std::string& line, double size, Align align,
            const Colour& colour);

  /// WorldError when the file cannot be written.
  void save_png(const std::filesystem::path& path) const;

 private:
  std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
           static_cast<std::size_t>(x);
  }

  int width_;
  int height_;
  std::vector<Colour> pixels_;
};

}  // namespace osteomill::io
