// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/cutting/component_batch.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace osteomill::cutting {
namespace {

const DirectionalLaw kLogs{LogLaw{0.42083, 0.58122, -0.06584}, LogLaw{0.27242, 0.66537, -0.08710}};
const DirectionalLaw kPowers{PowerLaw{71.1e3, 0.684, 0.0}, PowerLaw{63.1e3, 0.569, 2e3}};
const DirectionalLaw kOneLog{LogLaw{-0.19495, 0.61971, -0.07352}, {}};
const DirectionalLaw kOneLinear{LinearLaw{200e6, 3e3}, {}};

void expect_equal_to_one_by_one(const CuttingLaw& law, bool vectorised) {
  const ComponentBatch batch(law);
  EXPECT_EQ(batch.vectorised(), vectorised);
  std::vector<double> h;
  std::vector<double> cosine;
  for (int i = 0; i < 243; ++i) {  // no multiple of any vector's width
    h.push_back(i == 7 ? 0.0 : std::pow(10.0, -12.0 + 0.04 * i));
    cosine.push_back(std::cos(0.1 * i));
  }
  std::vector<double> t(h.size()), r(h.size()), l(h.size());
  const EdgePlace place{1.2, 1.1};
  batch(h, cosine, place, 0.4, t, r, l);
  for (std::size_t i = 0; i < h.size(); ++i) {
    const EdgeComponents one = components(law, Chip(h[i]), cosine[i], place, 0.4);
    EXPECT_NEAR(t[i], one.tangential, 1e-12 * std::abs(one.tangential)) << h[i];
    EXPECT_NEAR(r[i], one.radial, 1e-12 * std::abs(one.radial)) << h[i];
    EXPECT_NEAR(l[i], one.lateral, 1e-12 * std::abs(one.lateral)) << h[i];
  }
}

TEST(ComponentBatch, EqualsOneByOne) {
  CuttingLaw law{kLogs, kPowers, kOneLog};
  expect_equal_to_one_by_one(law, true);
  law.lateral_inclination = 0.5;
  expect_equal_to_one_by_one(law, true);
  law.orientation = OrientationCriterion::none;
  expect_equal_to_one_by_one(law, true);
  law.lateral.reset();
  expect_equal_to_one_by_one(law, true);
  law.orientation = OrientationCriterion::hankinson;
  law.orientation_exponent = 3.0;
  expect_equal_to_one_by_one(law, false);
  expect_equal_to_one_by_one({kLogs, kOneLinear, {}}, false);
}

TEST(ComponentBatch, EveryInstructionSetOfTheMachineAgrees) {
  kernel::Curves curves{};
  curves.components = 1;
  curves.along[0] = {6.9, 0.6, -0.03, 0.0};
  curves.across[0] = {6.5, 0.7, -0.04, 0.0};
  curves.directional[0] = true;
  curves.scale[0] = 1.0;
  std::vector<double> h, cosine;
  for (int i = 0; i < 37; ++i) {
    h.push_back(1e-7 * (i + 1));
    cosine.push_back(std::cos(0.3 * i));
  }
  std::vector<double> reference(h.size()), other(h.size());
  double* const to_reference[3] = {reference.data(), nullptr, nullptr};
  double* const to_other[3] = {other.data(), nullptr, nullptr};
  kernel::kSse2.evaluate(curves, h.data(), cosine.data(), h.size(), to_reference);
  const auto compare = [&](const kernel::Functions& functions) {
    functions.evaluate(curves, h.data(), cosine.data(), h.size(), to_other);
    for (std::size_t i = 0; i < h.size(); ++i) {
      EXPECT_NEAR(other[i], reference[i], 1e-13 * reference[i]);
    }
  };
  if (__builtin_cpu_supports("avx2") != 0) compare(kernel::kAvx2);
  if (__builtin_cpu_supports("avx512f") != 0) compare(kernel::kAvx512);
}

}  // namespace
}  // namespace osteomill::cutting
