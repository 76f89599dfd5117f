// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/cutting/component_batch.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>
#include <optional>

#include "osteomill/base/units.hpp"

namespace osteomill::cutting {
namespace {

constexpr double kLn10 = std::numbers::ln10;

std::optional<kernel::Curve> curve_of(const EdgeForce& law) {
  if (const auto* log = std::get_if<LogLaw>(&law)) {
    if (has_floor(*log)) return std::nullopt;
    return kernel::Curve{kLn10 * log->k1 + std::log(units::n_per_mm), log->k2, log->k3 / kLn10,
                         0.0};
  }
  if (const auto* power = std::get_if<PowerLaw>(&law); power != nullptr && power->at_1_mm > 0.0) {
    // h^n with h in mm: l is the logarithm of h in µm.
    return kernel::Curve{std::log(power->at_1_mm) - power->exponent * 3.0 * kLn10, power->exponent,
                         0.0, power->edge};
  }
  return std::nullopt;
}

}  // namespace

const kernel::Functions& kernel::best() {
  static const Functions& best =
      __builtin_cpu_supports("avx512f") != 0                                      ? kAvx512
      : __builtin_cpu_supports("avx2") != 0 && __builtin_cpu_supports("fma") != 0 ? kAvx2
                                                                                  : kSse2;
  return best;
}

ComponentBatch::ComponentBatch(const CuttingLaw& law) : law_(law) {
  if (law.orientation == OrientationCriterion::puw_hocheng || law.minimum_chip > 0.0) return;
  if (law.orientation == OrientationCriterion::hankinson && law.orientation_exponent != 2.0) return;
  const DirectionalLaw* const laws[] = {&law.tangential, &law.radial,
                                        law.lateral ? &*law.lateral : nullptr};
  for (const DirectionalLaw* one : laws) {
    if (one == nullptr) continue;
    const auto along = curve_of(one->at_0);
    const bool directional = one->at_90 && law.orientation != OrientationCriterion::none;
    const auto across = directional ? curve_of(*one->at_90) : along;
    if (!along || !across) return;
    const int i = curves_.components++;
    curves_.along[i] = *along;
    curves_.across[i] = *across;
    curves_.directional[i] = directional;
    curves_.scale[i] = 1.0;
  }
  vectorised_ = true;
}

void ComponentBatch::operator()(std::span<const double> h, std::span<const double> cosine,
                                const EdgePlace& place, double inclination,
                                std::span<double> tangential, std::span<double> radial,
                                std::span<double> lateral) const {
  assert(h.size() == cosine.size() && h.size() == tangential.size() && h.size() == radial.size() &&
         h.size() == lateral.size());
  if (!vectorised_) {
    for (std::size_t i = 0; i < h.size(); ++i) {
      const EdgeComponents f = components(law_, Chip(h[i]), cosine[i], place, inclination);
      tangential[i] = f.tangential;
      radial[i] = f.radial;
      lateral[i] = f.lateral;
    }
    return;
  }
  kernel::Curves curves = curves_;
  if (law_.lateral_inclination != 0.0) curves.scale[2] = inclination / law_.lateral_inclination;
  double* const out[3] = {tangential.data(), radial.data(), lateral.data()};
  kernel::best().evaluate(curves, h.data(), cosine.data(), h.size(), out);
  if (!law_.lateral) std::fill(lateral.begin(), lateral.end(), 0.0);
}

}  // namespace osteomill::cutting
