// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/bone/density.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "osteomill/base/error.hpp"

namespace osteomill::bone {
namespace {

TEST(ApparentDensity, IsALineInHounsfieldUnitsThatStopsAtNothing) {
  EXPECT_DOUBLE_EQ(apparent_density(0.0), 131.0);
  EXPECT_DOUBLE_EQ(apparent_density(1500.0), 131.0 + 1.067 * 1500.0);
  EXPECT_EQ(apparent_density(-1000.0), 0.0);
}

TEST(ForceScale, IsOneAtTheReferenceAndNothingInAir) {
  const ForceDensityLaw law;
  EXPECT_DOUBLE_EQ(force_scale(law.reference.value), 1.0);
  EXPECT_DOUBLE_EQ(force_scale(0.5 * law.reference.value), 0.25);
  EXPECT_EQ(force_scale(0.0), 0.0);
  EXPECT_EQ(law.exponent.obtained, Obtained::assumed);
}

TEST(ForceScale, RefusesWhatIsNoDensity) {
  EXPECT_THROW(force_scale(-1.0), InvalidInput);
  EXPECT_THROW(force_scale(std::nan("")), InvalidInput);
  ForceDensityLaw law;
  law.reference.value = 0.0;
  EXPECT_THROW(force_scale(1000.0, law), InvalidInput);
}

TEST(Caveat, IsSaidOfWhatWasNotMeasured) {
  Provenance provenance;
  provenance.obtained = Obtained::measured;
  EXPECT_EQ(caveat("bone", provenance), "");
  provenance.obtained = Obtained::reconstructed;
  provenance.note = "fitted to 36 printed means";
  EXPECT_EQ(caveat("bone", provenance),
            "bone is reconstructed, not measured: fitted to 36 printed means");
}

}  // namespace
}  // namespace osteomill::bone
