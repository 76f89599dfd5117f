// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/identify/fourier.hpp"

#include <kissfft/kissfft.hh>

namespace osteomill::identify {

std::size_t fast_length(std::size_t n) {
  for (std::size_t length = std::max<std::size_t>(n, 1);; ++length) {
    std::size_t rest = length;
    for (const std::size_t factor : {2u, 3u, 5u}) {
      while (rest % factor == 0) rest /= factor;
    }
    if (rest == 1) return length;
  }
}

Spectrum forward(const Eigen::Ref<const Eigen::VectorXd>& signal, std::size_t length) {
  Spectrum in(length), out(length);
  for (Eigen::Index i = 0; i < signal.size(); ++i) in[static_cast<std::size_t>(i)] = signal[i];
  kissfft<double>(length, false).transform(in.data(), out.data());
  return out;
}

Spectrum backward(const Spectrum& spectrum) {
  Spectrum out(spectrum.size());
  kissfft<double>(spectrum.size(), true).transform(spectrum.data(), out.data());
  for (auto& value : out) value /= static_cast<double>(spectrum.size());
  return out;
}

}  // namespace osteomill::identify
