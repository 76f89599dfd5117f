// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/identify/feed_response.hpp"

#include <algorithm>
#include <cmath>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/cutting/milling_force.hpp"

namespace osteomill::identify {
namespace {

constexpr int kKnots = 32;
/// Feeds below this share of the highest are not told apart.
constexpr double kLeast = 1e-2;
/// Steps a revolution for the mean magnitude, which is smooth: better than 1e-3.
constexpr int kSteps = 90;

FeedResponse::Answer between(const FeedResponse::Answer& a, const FeedResponse::Answer& b,
                             double share) {
  const auto mix = [&](double one, double two) { return one + share * (two - one); };
  return {mix(a.force, b.force), mix(a.power, b.power), mix(a.tangential, b.tangential),
          mix(a.radial, b.radial)};
}

/// The law with nothing but its radial component, or nothing but its tangential one.
cutting::CuttingLaw only(const cutting::CuttingLaw& law, bool tangential) {
  const cutting::DirectionalLaw none{cutting::LinearLaw{}, std::nullopt};
  cutting::CuttingLaw result = law;
  (tangential ? result.radial : result.tangential) = none;
  result.lateral.reset();
  return result;
}

}  // namespace

FeedResponse::FeedResponse(const cutting::Cutter& cutter, const cutting::CuttingLaw& law,
                           const cutting::Condition& condition, const cutting::Immersion& immersion,
                           double highest_feed) {
  require_positive("highest feed", highest_feed / units::mm_per_s, "mm/s");
  cutting::check(immersion, cutter);
  feed_.push_back(0.0);
  answer_.emplace_back();
  for (int k = 0; k < kKnots; ++k) {
    const double feed =
        highest_feed * std::pow(kLeast, 1.0 - static_cast<double>(k) / (kKnots - 1));
    cutting::Condition here = condition;
    here.feed_per_tooth = cutting::feed_per_tooth(feed, condition.spindle_speed, cutter.flutes);
    Answer answer;
    for (const cutting::Load& load :
         cutting::revolution(cutter, law, here, immersion, kSteps).loads) {
      answer.force += load.force.norm() / kSteps;
      answer.power += cutting::spindle_power(load, condition.spindle_speed) / kSteps;
    }
    // Torque over radius where the edges are all at one radius; on other shapes an equivalent one.
    answer.tangential = answer.power / (condition.spindle_speed * cutter.radius);
    const cutting::Load radial = cutting::mean_load(cutter, only(law, false), here, immersion);
    const cutting::Load tangential = cutting::mean_load(cutter, only(law, true), here, immersion);
    answer.radial =
        answer.tangential * radial.force.norm() / std::max(tangential.force.norm(), 1e-12);
    feed_.push_back(feed);
    answer_.push_back(answer);
  }
}

FeedResponse::FeedResponse(double gain)
    : feed_{0.0, 1.0}, answer_{{}, {.force = require_positive("gain", gain, "N/(m/s)")}} {}

FeedResponse::Answer FeedResponse::at(double feed) const noexcept {
  if (!(feed > 0.0)) return {};
  if (feed >= feed_.back()) return between({}, answer_.back(), feed / feed_.back());
  const auto above = std::upper_bound(feed_.begin(), feed_.end(), feed);
  const auto k = static_cast<std::size_t>(above - feed_.begin());
  return between(answer_[k - 1], answer_[k], (feed - feed_[k - 1]) / (feed_[k] - feed_[k - 1]));
}

}  // namespace osteomill::identify
