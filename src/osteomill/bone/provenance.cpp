// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/bone/provenance.hpp"

namespace osteomill::bone {

std::string_view name_of(Obtained obtained) {
  switch (obtained) {
    case Obtained::measured:
      return "measured";
    case Obtained::digitised:
      return "digitised";
    case Obtained::reconstructed:
      return "reconstructed";
    case Obtained::assumed:
      return "assumed";
    case Obtained::unstated:
      break;
  }
  return "unstated";
}

std::string caveat(std::string_view what, const Provenance& provenance) {
  if (provenance.obtained != Obtained::reconstructed && provenance.obtained != Obtained::assumed) {
    return "";
  }
  std::string text =
      std::string(what) + " is " + std::string(name_of(provenance.obtained)) + ", not measured";
  if (!provenance.note.empty()) text += ": " + provenance.note;
  return text;
}

}  // namespace osteomill::bone
