// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/cutting/law_strength.hpp"

#include <cmath>

#include "osteomill/base/error.hpp"

namespace osteomill::cutting {
namespace {

struct Scale {
  double strength;

  EdgeForce operator()(LogLaw law) const {
    law.k1 += std::log10(strength);
    return law;
  }
  EdgeForce operator()(PowerLaw law) const {
    law.at_1_mm *= strength;
    law.edge *= strength;
    return law;
  }
  EdgeForce operator()(LinearLaw law) const {
    law.pressure *= strength;
    law.edge *= strength;
    return law;
  }
  EdgeForce operator()(PolynomialLaw law) const {
    for (double& one : law.pressure) one *= strength;
    for (double& one : law.edge) one *= strength;
    return law;
  }
};

DirectionalLaw scaled(const DirectionalLaw& law, const Scale& scale) {
  DirectionalLaw result{std::visit(scale, law.at_0), {}};
  if (law.at_90) result.at_90 = std::visit(scale, *law.at_90);
  return result;
}

}  // namespace

CuttingLaw scaled(const CuttingLaw& law, double strength) {
  const Scale scale{require_positive("bone.strength", strength, "")};
  CuttingLaw result = law;
  result.tangential = scaled(law.tangential, scale);
  result.radial = scaled(law.radial, scale);
  if (law.lateral) result.lateral = scaled(*law.lateral, scale);
  return result;
}

}  // namespace osteomill::cutting
