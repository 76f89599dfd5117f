// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <stdexcept>
#include <string>
#include <vector>

namespace osteomill {

/// One thing that is wrong with an input: which field, what it holds, what is allowed, what to do.
struct Fault {
  std::string field;   ///< full name of the field, "cut.feed_rate_mm_per_min", or a file name
  std::string value;   ///< what it holds, with its unit; empty when it is missing
  std::string rule;    ///< what is allowed: "must be > 0"
  std::string remedy;  ///< what to do; empty where the rule already says it
  std::string location = {};  ///< "case.toml:12", "--set"; empty when there is none
};

/// "case.toml:12: cut.feed_rate_mm_per_min = -3: must be > 0; ...", one line a fault.
std::string describe(const Fault& fault);

/// Bad input: usage, case file, data file. Carries all the faults that were found, each once.
/// Exit status 2.
class InvalidInput : public std::runtime_error {
 public:
  explicit InvalidInput(Fault fault);
  explicit InvalidInput(std::vector<Fault> faults);
  const std::vector<Fault>& faults() const { return faults_; }

 private:
  std::vector<Fault> faults_;
};

/// Gathers the faults of several steps, so that all are reported at once.
class FaultList {
 public:
  /// Runs a step; keeps the faults of its InvalidInput. Returns whether there was none.
  template <class Step>
  bool gather(Step&& step) {
    try {
      step();
      return true;
    } catch (const InvalidInput& error) {
      faults_.insert(faults_.end(), error.faults().begin(), error.faults().end());
      return false;
    }
  }
  /// Throws InvalidInput when there is a fault.
  void raise() const {
    if (!faults_.empty()) throw InvalidInput(faults_);
  }

 private:
  std::vector<Fault> faults_;
};

/// The input is right but there is no answer: infeasible or not converged. Exit status 3.
class NoSolution : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// A supervisor stopped the machine. Exit status 4.
class SafetyStop : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// The outside world failed: device, network, disk. Exit status 5.
class WorldError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// The value, or InvalidInput with the field's name when it does not lie in (low, high] and such.
/// These guard constructors of values; case files collect their faults in io.
double require_positive(const char* field, double value, const char* unit);
double require_non_negative(const char* field, double value, const char* unit);
double require_within(const char* field, double value, double low, double high, const char* unit);
double require_finite(const char* field, double value, const char* unit);

}  // namespace osteomill
