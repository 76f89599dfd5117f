// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "osteomill/io/catalogue.hpp"

namespace osteomill::cli {

/// One published result against ours.
struct Reproduced {
  std::string source;     ///< key of docs/bibliography.md
  std::string entry;      ///< table, figure or statement
  std::string printed;    ///< what the source says
  std::string criterion;  ///< when it counts as reproduced
  std::string ours;
  bool pass = false;
  std::string reason = "";  ///< of a miss, or what a pass rests on
};

/// The folder reproduce/, beside data/.
inline std::filesystem::path reproduce_directory() {
  return io::data_directory().parent_path() / "reproduce";
}

/// Forces: [plaskos2002], [plaskos2006], [tian2023]. Each adds its entries to the list.
void reproduce_plaskos2006(std::vector<Reproduced>& list);
void reproduce_plaskos2002(std::vector<Reproduced>& list);
void reproduce_tian2023(std::vector<Reproduced>& list);

/// Identification from their measured means.
void reproduce_plaskos2006_identification(std::vector<Reproduced>& list);
void reproduce_tian2023_identification(std::vector<Reproduced>& list);

/// The cutting studies of [plaskos2002] chapters 2 and 3.
void reproduce_cutting_study(std::vector<Reproduced>& list);
/// Robot and calibration: chapters 4 and 5.
void reproduce_plaskos2006_robot(std::vector<Reproduced>& list);
/// Beams, deflection, alignment.
void reproduce_plaskos2002_accuracy(std::vector<Reproduced>& list);
void reproduce_plaskos2006_accuracy(std::vector<Reproduced>& list);

/// Control: [sugita2009].
void reproduce_sugita2009(std::vector<Reproduced>& list);

}  // namespace osteomill::cli
