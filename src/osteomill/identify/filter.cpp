// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/identify/filter.hpp"

#include <fmt/format.h>

#include <cmath>
#include <complex>
#include <numbers>

#include "osteomill/base/error.hpp"

namespace osteomill::identify {
namespace {

using std::numbers::pi;

/// Up to four signals side by side, one sample each.
using Lane = Eigen::Array4d;

/// A section with its state, transposed direct form II.
struct Running {
  Biquad c;
  Lane s1 = Lane::Zero();
  Lane s2 = Lane::Zero();

  /// The state that a constant input has led to; returns the output.
  Lane settle(const Lane& x) {
    const Lane y = x * ((c.b0 + c.b1 + c.b2) / (1.0 + c.a1 + c.a2));
    s1 = y - c.b0 * x;
    s2 = c.b2 * x - c.a2 * y;
    return y;
  }
  Lane step(const Lane& x) {
    const Lane y = c.b0 * x + s1;
    s1 = c.b1 * x - c.a1 * y + s2;
    s2 = c.b2 * x - c.a2 * y;
    return y;
  }
};

void settle(std::vector<Running>& running, Lane x) {
  for (Running& section : running) x = section.settle(x);
}

Lane step(std::vector<Running>& running, Lane x) {
  for (Running& section : running) x = section.step(x);
  return x;
}

Eigen::Index order_of(const std::vector<Biquad>& sections) {
  Eigen::Index order = 0;
  for (const Biquad& c : sections) order += c.a2 != 0.0 || c.b2 != 0.0 ? 2 : 1;
  return order;
}

}  // namespace

std::vector<Biquad> design(const Butterworth& filter, double rate) {
  require_within("signals.filter_order", filter.order, 1, 50, "");
  require_positive("record.rate", rate, "Hz");
  if (!(filter.cutoff_hz > 0.0 && filter.cutoff_hz < 0.5 * rate)) {
    throw InvalidInput({"signals.cutoff_hz", fmt::format("{:g} Hz", filter.cutoff_hz),
                        fmt::format("must lie between 0 and half the rate, {:g} Hz", 0.5 * rate),
                        "lower the cut-off or leave the filter out"});
  }
  const double k = std::tan(pi * filter.cutoff_hz / rate);
  const bool low = filter.pass == Pass::low;
  std::vector<Biquad> sections;
  if (filter.order % 2 == 1) {
    const double d = 1.0 / (1.0 + k);
    const double b = low ? k * d : d;
    sections.push_back({b, low ? b : -b, 0.0, (k - 1.0) * d, 0.0});
  }
  for (int pair = filter.order / 2 - 1; pair >= 0; --pair) {
    // Damping ratio of the pole pair: the sine of its angle from the imaginary axis.
    const double zeta = std::sin(pi * (2 * pair + 1) / (2.0 * filter.order));
    const double d = 1.0 / (1.0 + 2.0 * zeta * k + k * k);
    const double b = low ? k * k * d : d;
    sections.push_back({b, low ? 2.0 * b : -2.0 * b, b, 2.0 * (k * k - 1.0) * d,
                        (1.0 - 2.0 * zeta * k + k * k) * d});
  }
  return sections;
}

Eigen::MatrixXd zero_phase(const std::vector<Biquad>& sections,
                           const Eigen::Ref<const Eigen::MatrixXd>& signals) {
  const Eigen::Index n = signals.rows();
  const Eigen::Index extension = 3 * (order_of(sections) + 1);
  if (n <= extension) {
    throw InvalidInput({"record", fmt::format("{} samples", n),
                        fmt::format("must be longer than {} for a filter of this order", extension),
                        "take a longer record or a lower order"});
  }
  std::vector<Running> fresh;
  for (const Biquad& section : sections) fresh.push_back({section});
  Eigen::MatrixXd out(n, signals.cols());
  Eigen::Array<double, 4, Eigen::Dynamic> lanes(4, n + 2 * extension);
  for (Eigen::Index first = 0; first < signals.cols(); first += 4) {
    const Eigen::Index width = std::min<Eigen::Index>(4, signals.cols() - first);
    lanes.setZero();
    for (Eigen::Index column = 0; column < width; ++column) {
      const auto x = signals.col(first + column);
      auto lane = lanes.row(column);
      for (Eigen::Index i = 0; i < extension; ++i) {
        lane[i] = 2.0 * x[0] - x[extension - i];
        lane[extension + n + i] = 2.0 * x[n - 1] - x[n - 2 - i];
      }
      lane.segment(extension, n) = x.transpose();
    }
    auto running = fresh;
    settle(running, lanes.col(0));
    for (Eigen::Index i = 0; i < lanes.cols(); ++i) lanes.col(i) = step(running, lanes.col(i));
    running = fresh;
    settle(running, lanes.col(lanes.cols() - 1));
    for (Eigen::Index i = lanes.cols() - 1; i >= 0; --i) lanes.col(i) = step(running, lanes.col(i));
    for (Eigen::Index column = 0; column < width; ++column) {
      out.col(first + column) = lanes.row(column).segment(extension, n).transpose();
    }
  }
  return out;
}

double zero_phase_gain(const std::vector<Biquad>& sections, double frequency_hz, double rate) {
  const std::complex<double> z1 = std::polar(1.0, -2.0 * pi * frequency_hz / rate);
  double gain = 1.0;
  for (const Biquad& c : sections) {
    gain *= std::norm((c.b0 + z1 * (c.b1 + z1 * c.b2)) / (1.0 + z1 * (c.a1 + z1 * c.a2)));
  }
  return gain;
}

}  // namespace osteomill::identify
