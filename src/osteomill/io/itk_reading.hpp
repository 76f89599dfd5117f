// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <fmt/format.h>
#include <itkImage.h>

#include "osteomill/base/error.hpp"
#include "osteomill/io/ct_formats.hpp"

/// What the readers that use ITK share; included by their sources only, for it is heavy.
namespace osteomill::io {

using ItkVolume = itk::Image<float, 3>;

inline RawVolume from_itk(const ItkVolume& image) {
  RawVolume raw;
  const auto size = image.GetBufferedRegion().GetSize();
  for (unsigned axis = 0; axis < 3; ++axis) {
    raw.size[axis] = static_cast<int>(size[axis]);
    raw.spacing_mm[axis] = image.GetSpacing()[axis];
    raw.origin_mm[axis] = image.GetOrigin()[axis];
    for (unsigned row = 0; row < 3; ++row)
      raw.direction(row, axis) = image.GetDirection()[row][axis];
  }
  const float* begin = image.GetBufferPointer();
  raw.values.assign(begin, begin + image.GetBufferedRegion().GetNumberOfPixels());
  return raw;
}

/// Calls and turns what ITK throws into bad input of that path.
template <class Call>
auto guarded(const std::filesystem::path& path, Call call) {
  try {
    return call();
  } catch (const itk::ExceptionObject& error) {
    throw InvalidInput({path.string(), "", std::string("cannot be read: ") + error.GetDescription(),
                        "the file is truncated or no CT; export it again"});
  }
}

}  // namespace osteomill::io
