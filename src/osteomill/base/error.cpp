// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/base/error.hpp"

#include <fmt/format.h>

#include <cmath>
#include <set>

namespace osteomill {
namespace {

std::string join(const std::vector<Fault>& faults) {
  std::string text;
  for (const Fault& fault : faults) {
    if (!text.empty()) text += '\n';
    text += describe(fault);
  }
  return text;
}

std::vector<Fault> each_once(std::vector<Fault> faults) {
  std::vector<Fault> kept;
  std::set<std::string> seen;
  for (Fault& fault : faults) {
    if (seen.insert(describe(fault)).second) kept.push_back(std::move(fault));
  }
  return kept;
}

std::string with_unit(double value, const char* unit) {
  return *unit == '\0' ? fmt::format("{:g}", value) : fmt::format("{:g} {}", value, unit);
}

}  // namespace

std::string describe(const Fault& fault) {
  std::string text;
  if (!fault.location.empty()) text += fault.location + ": ";
  text += fault.field;
  if (!fault.value.empty()) text += " = " + fault.value;
  text += ": " + fault.rule;
  if (!fault.remedy.empty()) text += "; " + fault.remedy;
  return text;
}

InvalidInput::InvalidInput(Fault fault) : InvalidInput(std::vector<Fault>{std::move(fault)}) {}

InvalidInput::InvalidInput(std::vector<Fault> faults)
    : std::runtime_error(join(faults = each_once(std::move(faults)))), faults_(std::move(faults)) {}

double require_finite(const char* field, double value, const char* unit) {
  if (!std::isfinite(value)) {
    throw InvalidInput(Fault{field, with_unit(value, unit), "must be a finite number", ""});
  }
  return value;
}

double require_positive(const char* field, double value, const char* unit) {
  if (!(require_finite(field, value, unit) > 0.0)) {
    throw InvalidInput(Fault{field, with_unit(value, unit), "must be > 0", ""});
  }
  return value;
}

double require_non_negative(const char* field, double value, const char* unit) {
  if (!(require_finite(field, value, unit) >= 0.0)) {
    throw InvalidInput(Fault{field, with_unit(value, unit), "must be >= 0", ""});
  }
  return value;
}

double require_within(const char* field, double value, double low, double high, const char* unit) {
  require_finite(field, value, unit);
  if (value < low || value > high) {
    throw InvalidInput(Fault{
        field, with_unit(value, unit),
        fmt::format("must lie in {} ... {}", with_unit(low, unit), with_unit(high, unit)), ""});
  }
  return value;
}

}  // namespace osteomill
