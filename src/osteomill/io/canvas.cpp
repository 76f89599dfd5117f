// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/canvas.hpp"

#include <fmt/format.h>
#include <ft2build.h>
#include <png.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "osteomill/base/error.hpp"
#include "osteomill/io/pending_file.hpp"

#include FT_FREETYPE_H

namespace osteomill::io {
namespace {

constexpr const char* kFont = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf";

struct Font {
  FT_Library library = nullptr;
  FT_Face face = nullptr;
  Font() {
    if (FT_Init_FreeType(&library) != 0 || FT_New_Face(library, kFont, 0, &face) != 0)
      throw WorldError(
          fmt::format("{}: the font cannot be read; install it: apt-get install "
                      "fonts-dejavu-core",
                      kFont));
  }
  ~Font() {
    FT_Done_Face(face);
    FT_Done_FreeType(library);
  }
  Font(const Font&) = delete;
  Font& operator=(const Font&) = delete;
};

/// UTF-8 into code points; a broken byte stands for itself.
std::vector<FT_ULong> code_points(const std::string& line) {
  std::vector<FT_ULong> out;
  for (std::size_t i = 0; i < line.size();) {
    const auto byte = static_cast<unsigned char>(line[i]);
    const std::size_t more = byte >= 0xF0 ? 3 : byte >= 0xE0 ? 2 : byte >= 0xC0 ? 1 : 0;
    if (i + more >= line.size() + (more == 0 ? 1 : 0)) break;
    FT_ULong code = more == 0 ? byte : byte & (0x3Fu >> more);
    for (std::size_t k = 1; k <= more; ++k)
      code = (code << 6) | (static_cast<unsigned char>(line[i + k]) & 0x3Fu);
    out.push_back(code);
    i += more + 1;
  }
  return out;
}

}  // namespace

Canvas::Canvas(int width, int height)
    : width_(width),
      height_(height),
      pixels_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height),
              Colour{1.0F, 1.0F, 1.0F}) {}

void Canvas::blend(int x, int y, const Colour& colour, float share) {
  if (x < 0 || y < 0 || x >= width_ || y >= height_) return;
  Colour& pixel = pixels_[index(x, y)];
  for (std::size_t i = 0; i < 3; ++i) pixel[i] += share * (colour[i] - pixel[i]);
}

void Canvas::fill(int x, int y, int width, int height, const Colour& colour) {
  for (int j = y; j < y + height; ++j)
    for (int i = x; i < x + width; ++i) blend(i, j, colour, 1.0F);
}

void Canvas::text(double x, double y, const std::string& line, double size, Align align,
                  const Colour& colour) {
  const Font font;
  FT_Set_Char_Size(font.face, 0, static_cast<FT_F26Dot6>(std::lround(size * 64.0)), 72, 72);
  const std::vector<FT_ULong> codes = code_points(line);
  double length = 0.0;
  for (const FT_ULong code : codes)
    if (FT_Load_Char(font.face, code, FT_LOAD_NO_HINTING) == 0)
      length += static_cast<double>(font.face->glyph->advance.x) / 64.0;
  double pen = x - (align == Align::left ? 0.0 : align == Align::right ? length : 0.5 * length);
  for (const FT_ULong code : codes) {
    if (FT_Load_Char(font.face, code, FT_LOAD_RENDER | FT_LOAD_NO_HINTING) != 0) continue;
    const FT_GlyphSlot glyph = font.face->glyph;
    const int left = static_cast<int>(std::lround(pen)) + glyph->bitmap_left;
    const int top = static_cast<int>(std::lround(y)) - glyph->bitmap_top;
    for (unsigned j = 0; j < glyph->bitmap.rows; ++j)
      for (unsigned i = 0; i < glyph->bitmap.width; ++i) {
        const unsigned char cover =
            glyph->bitmap.buffer[static_cast<std::ptrdiff_t>(j) * glyph->bitmap.pitch + i];
        blend(left + static_cast<int>(i), top + static_cast<int>(j), colour,
              static_cast<float>(cover) / 255.0F);
      }
    pen += static_cast<double>(glyph->advance.x) / 64.0;
  }
}

void Canvas::save_png(const std::filesystem::path& path) const {
  PendingFile pending(path);
  std::vector<unsigned char> bytes;
  bytes.reserve(pixels_.size() * 3);
  for (const Colour& pixel : pixels_)
    for (const float v : pixel)
      bytes.push_back(static_cast<unsigned char>(std::lround(255.0F * std::clamp(v, 0.0F, 1.0F))));
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(width_);
  image.height = static_cast<png_uint_32>(height_);
  image.format = PNG_FORMAT_RGB;
  if (png_image_write_to_file(&image, pending.path().c_str(), 0, bytes.data(), 0, nullptr) == 0)
    throw WorldError(fmt::format("{}: cannot be written: {}", path.string(), image.message));
  pending.commit();
}

}  // namespace osteomill::io
