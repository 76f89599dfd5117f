// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/identify/rotation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "osteomill/base/error.hpp"
#include "osteomill/identify/fourier.hpp"

namespace osteomill::identify {
namespace {

using std::numbers::pi;
using Complex = std::complex<double>;
using Lines = Eigen::Matrix<Complex, 1, 3>;

/// Straight lines through knots at growing places; the first and the last line go on.
Eigen::VectorXd through(const std::vector<double>& place, const std::vector<double>& value,
                        Eigen::Index samples) {
  Eigen::VectorXd out(samples);
  std::size_t k = 1;
  for (Eigen::Index i = 0; i < samples; ++i) {
    const auto at = static_cast<double>(i);
    while (k + 1 < place.size() && place[k] < at) ++k;
    const double slope = (value[k] - value[k - 1]) / (place[k] - place[k - 1]);
    out[i] = value[k - 1] + slope * (at - place[k - 1]);
  }
  return out;
}

double deviation(const std::vector<double>& values, double mean) {
  double sum = 0.0;
  for (const double value : values) sum += (value - mean) * (value - mean);
  return values.size() > 1 ? std::sqrt(sum / static_cast<double>(values.size() - 1)) : 0.0;
}

/// Speed of each stretch between knots of angle, from samples to rad/s.
void set_speed(Rotation& rotation, const std::vector<double>& place,
               const std::vector<double>& angle, double rate) {
  rotation.spindle_speed = (angle.back() - angle.front()) / (place.back() - place.front()) * rate;
  std::vector<double> speeds;
  for (std::size_t k = 1; k < place.size(); ++k) {
    speeds.push_back((angle[k] - angle[k - 1]) / (place[k] - place[k - 1]) * rate);
  }
  rotation.speed_deviation = deviation(speeds, rotation.spindle_speed);
}

/// Σ f e^{−iω t} of a piece of the record over its samples.
Lines demodulate(const Eigen::MatrixX3d& force, Eigen::Index begin, Eigen::Index end,
                 double omega_per_sample) {
  Lines sum = Lines::Zero();
  const Complex turn = std::polar(1.0, -omega_per_sample);
  const Eigen::RowVector3d mean = force.middleRows(begin, end - begin).colwise().mean();
  Complex z = std::polar(1.0, -omega_per_sample * static_cast<double>(begin));
  for (Eigen::Index i = begin; i < end; ++i) {
    for (int axis = 0; axis < 3; ++axis) sum[axis] += (force(i, axis) - mean[axis]) * z;
    z *= turn;
  }
  return sum;
}

/// The strongest harmonic of the tooth passing: its number and its frequency in rad a sample.
struct Line {
  int harmonic = 1;
  double omega = 0.0;
};

Line find_line(const ForceRecord& record, double spindle_speed, int flutes,
               const LineOptions& options) {
  // Enough for a fine spectrum; the phase block by block does the rest.
  constexpr Eigen::Index kLongest = 1 << 16;
  const Eigen::Index n = std::min(record.force.rows(), kLongest);
  const Eigen::Index begin = (record.force.rows() - n) / 2;
  const std::size_t length = fast_length(static_cast<std::size_t>(n));
  Eigen::VectorXd power = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(length / 2 + 1));
  const Eigen::ArrayXd window =
      0.5 - 0.5 * (Eigen::ArrayXd::LinSpaced(n, 0.0, static_cast<double>(n - 1)) *
                   (2.0 * pi / static_cast<double>(n)))
                      .cos();
  for (int axis = 0; axis < 3; ++axis) {
    const auto piece = record.force.col(axis).segment(begin, n).array();
    const Spectrum spectrum = forward(((piece - piece.mean()) * window).matrix(), length);
    for (Eigen::Index k = 0; k < power.size(); ++k)
      power[k] += std::norm(spectrum[static_cast<std::size_t>(k)]);
  }
  const double nominal = flutes * spindle_speed / (2.0 * pi);
  const double bin = record.rate / static_cast<double>(length);
  const auto highest = static_cast<double>(power.size() - 3) * bin;
  // A third of a line, so that the third harmonic is met as well.
  const auto steps = static_cast<int>(std::ceil(2.0 * options.search * nominal / (bin / 3.0)));
  std::vector<double> scores;
  double best = -1.0, frequency = nominal;
  for (int i = 0; i <= steps; ++i) {
    const double f = nominal * (1.0 - options.search) + i * bin / 3.0;
    double score = 0.0;
    for (int h = 1; h <= 3 && h * f < highest; ++h)
      score += power[static_cast<Eigen::Index>(std::lround(h * f / bin))];
    scores.push_back(score);
    if (score > best) {
      best = score;
      frequency = f;
    }
  }
  const auto middle = scores.begin() + static_cast<std::ptrdiff_t>(scores.size() / 2);
  std::nth_element(scores.begin(), middle, scores.end());
  // The largest of some thousand lines of white noise is about ln(1000)/ln 2 = 10 times the median.
  if (!(best > 25.0 * *middle)) {
    throw InvalidInput(
        {"signals.rotation", "line",
         fmt::format("no tooth-passing line stands out within {:.0f} % of {:.2f} Hz",
                     100.0 * options.search, nominal),
         "check the spindle speed and the number of flutes, or use the tachometer or \"speed\""});
  }
  Line line;
  double strongest = -1.0;
  for (int h = 1; h <= 3 && h * frequency < highest; ++h) {
    auto k = static_cast<Eigen::Index>(std::lround(h * frequency / bin));
    if (power[k + 1] > power[k]) ++k;
    if (k > 1 && power[k - 1] > power[k]) --k;
    if (k < 1 || power[k] <= strongest) continue;
    strongest = power[k];
    // Parabola through the logarithms of three lines of a Hann window.
    const double tiny = 1e-30 * power[k];
    const double a = std::log(power[k - 1] + tiny), b = std::log(power[k]),
                 c = std::log(power[k + 1] + tiny);
    const double shift = std::clamp(0.5 * (a - c) / (a - 2.0 * b + c), -0.5, 0.5);
    line.harmonic = h;
    line.omega = 2.0 * pi * (static_cast<double>(k) + shift) / static_cast<double>(length);
  }
  return line;
}

}  // namespace

Rotation rotation_from_tacho(const Eigen::VectorXd& tacho, double rate) {
  require_positive("record.rate", rate, "Hz");
  if (tacho.size() == 0) {
    throw InvalidInput({"record.tacho", "", "is missing", "name its column, or use the line"});
  }
  const double low = tacho.minCoeff(), high = tacho.maxCoeff();
  const double middle = 0.5 * (low + high), arm = middle - 0.05 * (high - low);
  std::vector<double> pulses;
  bool armed = false;
  for (Eigen::Index i = 0; i + 1 < tacho.size(); ++i) {
    armed = armed || tacho[i] < arm;
    if (armed && tacho[i] < middle && tacho[i + 1] >= middle) {
      pulses.push_back(static_cast<double>(i) + (middle - tacho[i]) / (tacho[i + 1] - tacho[i]));
      armed = false;
    }
  }
  if (pulses.size() < 2) {
    throw InvalidInput({"record.tacho", fmt::format("{} pulses", pulses.size()),
                        "needs two at least", "check the column, or use the tooth-passing line"});
  }
  std::vector<double> turns;
  for (std::size_t k = 1; k < pulses.size(); ++k) turns.push_back(pulses[k] - pulses[k - 1]);
  auto sorted = turns;
  std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2),
                   sorted.end());
  const double median = sorted[sorted.size() / 2];
  std::vector<double> angles{0.0};
  for (std::size_t k = 0; k < turns.size(); ++k) {
    if (std::abs(turns[k] - median) > 0.5 * median) {
      throw InvalidInput(
          {"record.tacho",
           fmt::format("a revolution of {:.4g} s at {:.4f} s", turns[k] / rate, pulses[k] / rate),
           fmt::format("must not differ by more than a half from the median, {:.4g} s",
                       median / rate),
           "a pulse is missing or doubled there: use the tooth-passing line, or cut the record"});
    }
    angles.push_back(2.0 * pi * static_cast<double>(k + 1));
  }
  Rotation rotation{.angle = through(pulses, angles, tacho.size()), .absolute = true};
  set_speed(rotation, pulses, angles, rate);
  return rotation;
}

Rotation rotation_from_line(const ForceRecord& record, double spindle_speed, int flutes,
                            const LineOptions& options) {
  require_positive("cut.spindle_speed_rpm", spindle_speed, "rad/s");
  const double nominal = flutes * spindle_speed / (2.0 * pi);
  if (nominal * (1.0 + options.search) >= 0.5 * record.rate) {
    throw InvalidInput({"signals.rotation", "line",
                        fmt::format("the teeth pass at {:.1f} Hz, above half the rate of {:g} Hz",
                                    nominal, record.rate),
                        "use the tachometer or \"speed\", or only the mean"});
  }
  const Eigen::Index n = record.force.rows();
  const double tooth = record.rate / nominal;  // samples
  if (static_cast<double>(n) < 4.0 * flutes * tooth) {
    throw InvalidInput({"plateau", fmt::format("{} samples", n),
                        fmt::format("must hold four revolutions of {:.1f} samples", flutes * tooth),
                        "take a longer cut"});
  }
  const Line line = find_line(record, spindle_speed, flutes, options);
  const auto blocks = std::max<Eigen::Index>(
      2, static_cast<Eigen::Index>(static_cast<double>(n) / (options.block * tooth)));
  std::vector<Lines> lines;
  std::vector<double> places;
  for (Eigen::Index b = 0; b < blocks; ++b) {
    const Eigen::Index begin = n * b / blocks, end = n * (b + 1) / blocks;
    lines.push_back(demodulate(record.force, begin, end, line.omega));
    places.push_back(0.5 * static_cast<double>(begin + end - 1));
  }
  const Lines reference = *std::max_element(
      lines.begin(), lines.end(),
      [](const Lines& a, const Lines& b) { return a.squaredNorm() < b.squaredNorm(); });
  Eigen::Index strongest = 0;
  reference.cwiseAbs().maxCoeff(&strongest);
  // Phase of each block against the reference, the axes together; unwrapped from block to block.
  const double per_turn = static_cast<double>(line.harmonic * flutes);
  std::vector<double> angles;
  double phase = 0.0, before = 0.0;
  for (std::size_t b = 0; b < lines.size(); ++b) {
    const Complex product = (lines[b].array() * reference.conjugate().array()).sum();
    const double now = std::arg(product);
    phase += std::remainder(now - before, 2.0 * pi);
    before = now;
    angles.push_back((line.omega * places[b] + phase + std::arg(reference[strongest])) / per_turn);
  }
  Rotation rotation{.angle = through(places, angles, n), .absolute = false};
  set_speed(rotation, places, angles, record.rate);
  return rotation;
}

Rotation rotation_of_speed(Eigen::Index samples, double rate, double spindle_speed) {
  require_positive("cut.spindle_speed_rpm", spindle_speed, "rad/s");
  const double last = static_cast<double>(samples - 1) / rate * spindle_speed;
  return {.angle = Eigen::VectorXd::LinSpaced(samples, 0.0, last), .spindle_speed = spindle_speed};
}

}  // namespace osteomill::identify
