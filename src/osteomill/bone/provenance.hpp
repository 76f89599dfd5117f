// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>

namespace osteomill::bone {

/// How a value came to be known, from the firmest to the loosest.
enum class Obtained {
  measured,       ///< printed in the source as a measured number
  digitised,      ///< read off a figure of the source
  reconstructed,  ///< worked back from other printed numbers
  assumed,        ///< taken because something has to be taken
  unstated,
};

std::string_view name_of(Obtained obtained);

/// Where a value or a set of values comes from.
struct Provenance {
  Obtained obtained = Obtained::unstated;
  std::string source;       ///< a key of docs/bibliography.md, with table or page
  std::string specimen;     ///< which bone of which animal
  std::string condition;    ///< speed, wetness, tool
  std::string uncertainty;  ///< as the source or the reconstruction states it
  std::string note;
};

/// What a command that uses the values has to tell its user; empty for measured and digitised.
std::string caveat(std::string_view what, const Provenance& provenance);

/// A number with its provenance; SI.
struct Sourced {
  double value = 0.0;
  std::string_view unit;
  Obtained obtained = Obtained::unstated;
  std::string_view source;
};

}  // namespace osteomill::bone
