// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/vibration/frequency_response.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <kissfft/kissfft.hh>
#include <numbers>

#include "osteomill/base/error.hpp"

namespace osteomill::vibration {
namespace {

using Complex = std::complex<double>;
constexpr double kTurn = 2.0 * std::numbers::pi;

std::vector<Complex> spectrum(const std::vector<double>& signal) {
  std::vector<Complex> in(signal.begin(), signal.end()), out(signal.size());
  kissfft<double>(signal.size(), false).transform(in.data(), out.data());
  out.resize(signal.size() / 2 + 1);
  return out;
}

void check(const std::vector<ImpactRecord>& records) {
  std::vector<Fault> faults;
  if (records.empty()) faults.push_back({"records", "", "at least one blow is needed", ""});
  for (std::size_t i = 0; i < records.size(); ++i) {
    const ImpactRecord& r = records[i];
    const std::string name = fmt::format("records[{}]", i);
    if (!(r.sample_rate > 0.0)) faults.push_back({name, "", "sample rate must be > 0", ""});
    if (r.force.size() < 16 || r.force.size() != r.response.size()) {
      faults.push_back({name, fmt::format("{} and {} samples", r.force.size(), r.response.size()),
                        "needs as many samples of force as of response, and 16 at least", ""});
    } else if (*std::max_element(r.force.begin(), r.force.end()) <= 0.0) {
      faults.push_back(
          {name, "", "holds no blow: the force is never above 0", "turn the sign of the force"});
    }
    if (r.sample_rate != records[0].sample_rate || r.force.size() != records[0].force.size()) {
      faults.push_back({name, "", "differs from the first record in rate or length",
                        "cut the records to one length"});
    }
    for (std::size_t k = 0; k < std::min(r.force.size(), r.response.size()); ++k) {
      if (!std::isfinite(r.force[k]) || !std::isfinite(r.response[k])) {
        faults.push_back({name, fmt::format("sample {}", k), "must be finite", ""});
        break;
      }
    }
  }
  if (!faults.empty()) throw InvalidInput(std::move(faults));
}

}  // namespace

MeasuredFrf estimate_frf(const std::vector<ImpactRecord>& records, const FrfOptions& options) {
  check(records);
  require_within("options.window_end", options.window_end, 1e-6, 1.0, "");
  require_non_negative("options.force_window", options.force_window, "s");
  const double rate = records[0].sample_rate;
  const std::size_t n = records[0].force.size();
  MeasuredFrf frf;
  frf.blows = static_cast<int>(records.size());
  frf.window_damping = -std::log(options.window_end) * rate / static_cast<double>(n);
  std::vector<double> ff(n / 2 + 1), xx(n / 2 + 1);
  std::vector<Complex> fx(n / 2 + 1);
  for (const ImpactRecord& record : records) {
    std::vector<double> force = record.force, response = record.response;
    if (options.force_window > 0.0) {
      const auto blow =
          static_cast<std::size_t>(std::max_element(force.begin(), force.end()) - force.begin());
      const auto half = static_cast<std::size_t>(std::ceil(options.force_window * rate));
      for (std::size_t i = 0; i < n; ++i) {
        if (i + half < blow || i > blow + half) force[i] = 0.0;
      }
    }
    for (std::size_t i = 0; i < n; ++i) {
      const double window = std::exp(-frf.window_damping * static_cast<double>(i) / rate);
      force[i] *= window;
      response[i] *= window;
    }
    const auto f = spectrum(force), x = spectrum(response);
    for (std::size_t k = 0; k < f.size(); ++k) {
      ff[k] += std::norm(f[k]);
      xx[k] += std::norm(x[k]);
      fx[k] += std::conj(f[k]) * x[k];
    }
  }
  // Line 0 has no receptance from an acceleration and mostly drift otherwise.
  for (std::size_t k = 1; k < ff.size(); ++k) {
    const double f = static_cast<double>(k) * rate / static_cast<double>(n);
    Complex h = options.estimator == FrfEstimator::h1 ? fx[k] / ff[k] : xx[k] / std::conj(fx[k]);
    if (options.response == Response::acceleration) {
      // The window's decay belongs to the Laplace variable: s = iω + σ.
      const Complex s(frf.window_damping, kTurn * f);
      h /= s * s;
    }
    frf.frequency_hz.push_back(f);
    frf.receptance.push_back(h);
    const double both = ff[k] * xx[k];
    frf.coherence.push_back(both > 0.0 ? std::min(1.0, std::norm(fx[k]) / both) : 0.0);
  }
  return frf;
}

Mode FittedMode::mode(double direction_x, double direction_y) const {
  const double omega = kTurn * frequency_hz.value;
  return {.frequency_hz = frequency_hz.value,
          .damping_ratio = damping_ratio.value,
          .modal_mass = stiffness.value / (omega * omega),
          .direction_x = direction_x,
          .direction_y = direction_y};
}

}  // namespace osteomill::vibration
