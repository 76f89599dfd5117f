// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <cctype>
#include <numbers>

#include "osteomill/io/force_record_table.hpp"

namespace osteomill::io {
namespace {

struct KnownUnit {
  UnitKind kind;
  std::string_view name;
  double factor;
};

constexpr double kPoundForce = 4.4482216152605;  // N
constexpr std::array kUnits{
    KnownUnit{UnitKind::force, "N", 1.0},
    KnownUnit{UnitKind::force, "kN", 1e3},
    KnownUnit{UnitKind::force, "mN", 1e-3},
    KnownUnit{UnitKind::force, "lbf", kPoundForce},
    KnownUnit{UnitKind::force, "lb", kPoundForce},
    KnownUnit{UnitKind::time, "s", 1.0},
    KnownUnit{UnitKind::time, "sec", 1.0},
    KnownUnit{UnitKind::time, "ms", 1e-3},
    KnownUnit{UnitKind::time, "us", 1e-6},
    KnownUnit{UnitKind::time, "µs", 1e-6},
    KnownUnit{UnitKind::time, "min", 60.0},
    KnownUnit{UnitKind::moment, "Nm", 1.0},
    KnownUnit{UnitKind::moment, "N m", 1.0},
    KnownUnit{UnitKind::moment, "N*m", 1.0},
    KnownUnit{UnitKind::moment, "N·m", 1.0},
    KnownUnit{UnitKind::moment, "Ncm", 1e-2},
    KnownUnit{UnitKind::moment, "Nmm", 1e-3},
    KnownUnit{UnitKind::angle, "deg", std::numbers::pi / 180.0},
    KnownUnit{UnitKind::angle, "°", std::numbers::pi / 180.0},
    KnownUnit{UnitKind::angle, "rad", 1.0},
    KnownUnit{UnitKind::voltage, "V", 1.0},
    KnownUnit{UnitKind::voltage, "mV", 1e-3},
};

bool same(std::string_view a, std::string_view b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](unsigned char x, unsigned char y) {
    return std::tolower(x) == std::tolower(y);
  });
}

std::string trimmed(std::string_view text) {
  const auto begin = text.find_first_not_of(" \t\"'");
  if (begin == std::string_view::npos) return {};
  return std::string(text.substr(begin, text.find_last_not_of(" \t\"'") - begin + 1));
}

}  // namespace

std::optional<double> unit_factor(UnitKind kind, std::string_view unit) {
  // mN is no MN, and mV no MV: as written first, then in any case.
  for (const KnownUnit& known : kUnits) {
    if (known.kind == kind && known.name == unit) return known.factor;
  }
  for (const KnownUnit& known : kUnits) {
    if (known.kind == kind && unit != "MN" && unit != "MV" && same(known.name, unit))
      return known.factor;
  }
  return {};
}

void split_unit(const std::string& heading, std::string& name, std::string& unit) {
  unit.clear();
  for (const auto& [open, close] : {std::pair{'[', ']'}, std::pair{'(', ')'}}) {
    const auto at = heading.find(open);
    if (at == std::string::npos || at == 0) continue;
    name = trimmed(heading.substr(0, at));
    unit = trimmed(heading.substr(at + 1, heading.find(close, at) - at - 1));
    return;
  }
  for (const std::string_view mark : {" / ", "/", ",", "_", " "}) {
    const auto at = heading.rfind(mark);
    if (at == std::string::npos || at == 0) continue;
    const std::string rest = trimmed(heading.substr(at + mark.size()));
    for (const KnownUnit& known : kUnits) {
      if (rest != known.name && !(mark == "_" && same(rest, known.name))) continue;
      name = trimmed(heading.substr(0, at));
      unit = known.name;
      return;
    }
  }
  name = trimmed(heading);
}

bool names_a_rate(std::string_view name) {
  const auto last = name.find_last_of("./");
  if (last != std::string_view::npos) name.remove_prefix(last + 1);
  for (const std::string_view known : {"rate", "rate_hz", "sampling_rate", "sampling_rate_hz",
                                       "sample_rate", "sample_rate_hz", "fs", "samplerate"}) {
    if (same(name, known)) return true;
  }
  return false;
}

void add_channels(RecordTable& table, const std::string& name, const std::string& unit,
                  const Eigen::MatrixXd& values) {
  const Eigen::MatrixXd columns = values.cols() > values.rows() ? values.transpose() : values;
  if (columns.cols() == 1) {
    table.channels.push_back({name, unit, columns.col(0)});
    return;
  }
  for (Eigen::Index k = 0; k < columns.cols(); ++k) {
    table.channels.push_back(
        {name + "(" + std::to_string(k + 1) + ")", unit, columns.col(k), name});
  }
}

}  // namespace osteomill::io
