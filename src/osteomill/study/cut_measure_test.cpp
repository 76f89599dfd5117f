// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/study/cut_measure.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <tuple>

#include "osteomill/base/error.hpp"
#include "osteomill/base/random.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/study/intervals.hpp"

namespace osteomill::study {
namespace {

using units::deg;
using units::mm;

const Eigen::Matrix3d kGuide =
    Eigen::AngleAxisd(0.7, Vector3(1, 2, -1).normalized()).toRotationMatrix();

TEST(CutError, GivesBackTheRotationsInBothOrders) {
  for (const RotationOrder order :
       {RotationOrder::kVarusThenFlexion, RotationOrder::kFlexionThenVarus}) {
    for (const bool medial : {true, false}) {
      const CutError made{2.5 * deg, -4.0 * deg};
      const CutError read =
          cut_error(kGuide, cut_normal(kGuide, made, {medial}, order), {medial}, order);
      EXPECT_NEAR(read.varus_valgus, made.varus_valgus, 1e-14);
      EXPECT_NEAR(read.flexion_extension, made.flexion_extension, 1e-14);
    }
  }
}

TEST(CutError, DiffersBetweenTheOrdersInThirdOrderAlone) {
  const double a = 3.0 * deg, b = 3.0 * deg;
  const Vector3 normal = cut_normal(kGuide, {a, b}, {false}, RotationOrder::kVarusThenFlexion);
  const CutError other = cut_error(kGuide, normal, {false}, RotationOrder::kFlexionThenVarus);
  // tan a' = tan a / cos b and sin b' = cos a sin b; the next terms are of fifth order.
  EXPECT_NEAR(other.varus_valgus - a, 0.5 * a * b * b, 1e-6);
  EXPECT_NEAR(other.flexion_extension - b, -0.5 * a * a * b, 1e-6);
  EXPECT_NEAR((other.varus_valgus - a) / deg, 0.0041, 2e-4);
}

// The whole of R = R_y(b) R_x(a), not only its normal: a turn of the implant in its own plane,
// which a flat dummy may take, changes nothing.
TEST(CutError, IgnoresTheTurnInThePlane) {
  const CutError made{1.0 * deg, 2.0 * deg};
  const Vector3 normal = cut_normal(kGuide, made, {true});
  for (const double turn : {0.3, 2.0}) {
    const Eigen::Matrix3d R = kGuide * Eigen::AngleAxisd(made.flexion_extension, Vector3::UnitY()) *
                              Eigen::AngleAxisd(-made.varus_valgus, Vector3::UnitX()) *
                              Eigen::AngleAxisd(turn, Vector3::UnitZ());
    EXPECT_NEAR((R.col(2) - normal).norm(), 0.0, 1e-14);
  }
}

TEST(CutError, TellsVarusAndExtensionAsASurgeonDoes) {
  // Right tibia: anterior x, proximal z, so y points to the patient's left, which is medial.
  const Eigen::Matrix3d G = guide_frame(Vector3::UnitZ(), Vector3::UnitX());
  EXPECT_NEAR((G - Eigen::Matrix3d::Identity()).norm(), 0.0, 1e-15);
  // Medial side cut lower: the normal leans to medial. That is varus.
  const Vector3 leans_medially = Vector3(0, std::sin(2 * deg), std::cos(2 * deg));
  EXPECT_NEAR(cut_error(G, leans_medially, {true}).varus_valgus, 2 * deg, 1e-14);
  EXPECT_NEAR(cut_error(G, leans_medially, {false}).varus_valgus, -2 * deg, 1e-14);
  // Bone left posteriorly: the surface falls toward anterior, the normal leans there.
  const Vector3 leans_anteriorly = Vector3(std::sin(3 * deg), 0, std::cos(3 * deg));
  EXPECT_NEAR(cut_error(G, leans_anteriorly, {true}).flexion_extension, 3 * deg, 1e-14);
  // A plane has no sides: the normal into the bone tells the same.
  EXPECT_NEAR(cut_error(G, -leans_anteriorly, {true}).flexion_extension, 3 * deg, 1e-14);
}

// Patient axes: anterior X, left Y, proximal Z.
TEST(CutSide, FollowsFromTheAxesOfEachCut) {
  const Vector3 anterior = Vector3::UnitX(), left = Vector3::UnitY(), proximal = Vector3::UnitZ();
  const std::tuple<CutKind, Vector3, Vector3> cuts[] = {
      {CutKind::kProximalTibia, proximal, anterior},
      {CutKind::kDistalFemur, -proximal, anterior},
      {CutKind::kAnteriorFemur, anterior, -proximal},
      {CutKind::kPosteriorFemur, -anterior, -proximal}};
  for (const auto& [kind, outward, entry] : cuts) {
    const Vector3 y = guide_frame(outward, entry).col(1);
    EXPECT_EQ(side_of(kind, true).medial_is_y, y.dot(left) > 0.0);
    EXPECT_EQ(side_of(kind, false).medial_is_y, y.dot(left) < 0.0);
  }
}

std::vector<Vector3> noisy_points(const Vector3& normal, double sd, Random& random) {
  // 9 x 6 points over 70 x 45 mm, as a probe would touch a tibial cut.
  Vector3 u = normal.unitOrthogonal(), v = normal.cross(u);
  std::vector<Vector3> points;
  for (int i = 0; i < 9; ++i) {
    for (int j = 0; j < 6; ++j) {
      points.push_back(Vector3(0.1, -0.2, 0.9) + (i - 4) * 8.75 * mm * u +
                       (j - 2.5) * 9.0 * mm * v + random.normal(0.0, sd) * normal);
    }
  }
  return points;
}

TEST(PlaneFit, OfNoisyPointsIsUnbiasedAndAsPreciseAsItPredicts) {
  const CutError truth{0.8 * deg, -1.2 * deg};
  const Vector3 normal = cut_normal(kGuide, truth, {true});
  std::vector<double> varus, flexion;
  double predicted = 0.0, noise = 0.0;
  constexpr int kRepetitions = 1000;
  std::vector<double> about1, about2;
  double sd1 = 0.0, sd2 = 0.0;
  for (int r = 0; r < kRepetitions; ++r) {
    Random random(77, r);
    const PlaneFit fit = fit_plane(noisy_points(normal, 0.2 * mm, random), kGuide.col(2));
    const CutError error = cut_error(kGuide, fit.normal, {true});
    varus.push_back(error.varus_valgus);
    flexion.push_back(error.flexion_extension);
    about1.push_back(normal.dot(fit.axis2));
    about2.push_back(normal.dot(fit.axis1));
    sd1 += fit.tilt_sd_about_axis1 / kRepetitions;
    sd2 += fit.tilt_sd_about_axis2 / kRepetitions;
    noise += fit.residual_sd / kRepetitions;
    predicted += std::hypot(fit.tilt_sd_about_axis1, fit.tilt_sd_about_axis2) / kRepetitions;
  }
  const Moments v = moments(varus), f = moments(flexion);
  const double standard_error = predicted / std::sqrt(1.0 * kRepetitions);
  EXPECT_NEAR(v.mean, truth.varus_valgus, 3.0 * standard_error);
  EXPECT_NEAR(f.mean, truth.flexion_extension, 3.0 * standard_error);
  // An SD of 1 000 values is known to 1/sqrt(2000) = 2.2 %; three times that.
  EXPECT_NEAR(moments(about1).sd / sd1, 1.0, 0.067);
  EXPECT_NEAR(moments(about2).sd / sd2, 1.0, 0.067);
  EXPECT_NEAR(std::hypot(v.sd, f.sd) / predicted, 1.0, 0.067);
  EXPECT_NEAR(noise / (0.2 * mm), 1.0, 0.01);
}

TEST(PlaneFit, TellsFormFromRoughness) {
  // A crown of 0.5 mm under noise of 0.05 mm: flatness has both, roughness the noise alone.
  Random random(3);
  std::vector<Vector3> points;
  for (int i = -20; i <= 20; ++i) {
    for (int j = -20; j <= 20; ++j) {
      const double x = 2.0 * mm * i, y = 1.5 * mm * j;
      const double crown = 0.5 * mm * (1.0 - i * i / 400.0);
      points.emplace_back(x, y, crown + random.normal(0.0, 0.05 * mm));
    }
  }
  const PlaneFit fit = fit_plane(points, Vector3::UnitZ());
  ASSERT_TRUE(fit.roughness_known);
  EXPECT_NEAR(fit.roughness_rms, 0.05 * mm, 0.003 * mm);
  EXPECT_GT(fit.flatness, 0.5 * mm);
  EXPECT_GT(fit.flatness_rms, 2.0 * fit.roughness_rms);
}

TEST(PlacementPrecision, OfThirtyPlacementsIsTheThesesUpperBound) {
  // [plaskos2002] 2.2.2 prints upper bounds of 0.10 and 0.17 deg: SDs of about 0.074 and 0.126 deg.
  std::vector<double> placed;
  for (int i = 0; i < 30; ++i) placed.push_back((i % 2 == 0 ? 1.0 : -1.0));
  const PlacementPrecision p = placement_precision(placed);
  EXPECT_EQ(p.placements, 30);
  EXPECT_NEAR(p.upper / p.sd, 1.3443, 1e-4);  // sqrt(29 / 16.047)
}

TEST(CutMeasure, NamesMirroredFramesAndPointsThatSpanNoPlane) {
  const auto message = [](const auto& call) -> std::string {
    try {
      call();
    } catch (const InvalidInput& error) {
      return error.what();
    }
    return "";
  };
  Eigen::Matrix3d mirrored = kGuide;
  mirrored.col(1) *= -1.0;
  EXPECT_NE(message([&] { checked_rotation(mirrored, "guide"); }).find("mirrored"),
            std::string::npos);
  EXPECT_NE(message([&] { checked_rotation(1.2 * kGuide, "guide"); }).find("must be a rotation"),
            std::string::npos);
  EXPECT_NE(message([&] { guide_frame(Vector3::UnitX(), Vector3::UnitX()); }).find("parallel"),
            std::string::npos);
  const std::vector<Vector3> line = {{0, 0, 0}, {1, 1, 1}, {2, 2, 2}, {3, 3, 3}};
  EXPECT_NE(message([&] { fit_plane(line, Vector3::UnitZ()); }).find("on one line"),
            std::string::npos);
  EXPECT_NE(message([&] { fit_plane({line.data(), 3}, Vector3::UnitZ()); }).find("4 or more"),
            std::string::npos);
  EXPECT_THROW(cut_error(kGuide, Vector3::Zero(), {true}), InvalidInput);
}

TEST(CheckedRotation, TakesThreeDigitExportsToTheNearestRotation) {
  Eigen::Matrix3d rounded = (kGuide * 1000.0).array().round().matrix() / 1000.0;
  const Eigen::Matrix3d R = checked_rotation(rounded, "guide");
  EXPECT_NEAR((R.transpose() * R - Eigen::Matrix3d::Identity()).norm(), 0.0, 1e-14);
  EXPECT_NEAR((R - kGuide).norm(), 0.0, 2e-3);
}

}  // namespace
}  // namespace osteomill::study
