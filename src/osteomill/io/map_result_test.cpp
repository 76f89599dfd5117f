// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/map_result.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/io/case_file.hpp"
#include "osteomill/io/map_case.hpp"
#include "osteomill/io/stock_maker.hpp"

namespace osteomill::io {
namespace {

const std::filesystem::path kExample = OSTEOMILL_SOURCE_DIR "/examples/force_map.toml";

MapCase read(std::vector<std::string> overrides) {
  // Few poses of coarse bone: what is tested is how they are told.
  overrides.insert(overrides.end(),
                   {"stock.spacing_mm=1.5", "map.angle_step_deg=10", "map.insertion_step_mm=6"});
  return read_map_case(read_case(kExample, overrides).front());
}

struct Made {
  std::unique_ptr<simulate::ForceMap> map;
  MapResult result;
};
Made make(const MapCase& one) {
  Made made;
  made.map = std::make_unique<simulate::ForceMap>(*make_stock(one.stock, one.bone).stock, one.map);
  made.result = {made.map.get(),
                 one.map.poses,
                 one.feed,
                 one.force_limit,
                 made.map->at(one.feed),
                 made.map->largest_feeds(one.limited, one.force_limit)};
  return made;
}

TEST(MapResult, ACockpitFindsEveryPoseAndCanMakeAnotherFeed) {
  for (const std::string law : {"", "bone.law=linear"}) {
    std::vector<std::string> overrides;
    if (!law.empty())
      overrides = {R"(bone={law="linear",tangential={any_deg={k=60,edge=2}},radial={any_deg={k=30,)"
                   R"(edge=1}},orientation="none"})"};
    const Made made = make(read(overrides));
    const auto document = map_document(made.result, true);
    const std::size_t poses = made.map->poses();
    EXPECT_EQ(document.at("angle_deg").size() * document.at("insertion_mm").size(), poses);
    for (const char* name : {"normal_force_n", "feed_force_n", "largest_feed_mm_per_s", "contact"})
      EXPECT_EQ(document.at(name).size(), poses) << name;
    const bool linear = document.at("linear_in_feed").get<bool>();
    EXPECT_EQ(linear, !law.empty());
    EXPECT_EQ(document.at("nodes").size(), linear ? 2U : 12U);
    if (!linear) continue;
    const auto& nodes = document.at("nodes");
    const double share =
        made.result.feed / units::mm_per_s / nodes[1].at("feed_mm_per_s").get<double>();
    for (std::size_t i = 0; i < poses; ++i) {
      const double f0 = nodes[0].at("normal_force_n")[i], f1 = nodes[1].at("normal_force_n")[i];
      const double told = document.at("normal_force_n")[i];
      EXPECT_NEAR(f0 + (f1 - f0) * share, told, 3e-5 * std::abs(f1));  // five digits are told
    }
  }
}

TEST(MapResult, TheOverlayLiesOnThePlaneWithThePosesInBone) {
  const Made made = make(read({}));
  const geometry::Mesh mesh = map_overlay(made.result, MapValue::normal_force);
  ASSERT_GT(mesh.triangles.size(), 20U);
  ASSERT_EQ(mesh.values.size(), mesh.vertices.size());
  for (const Eigen::Vector3f& v : mesh.vertices) EXPECT_NEAR(v.z(), 0.0, 1e-9);
  for (const auto& t : mesh.triangles) {
    const Eigen::Vector3f a = mesh.vertices[t[1]] - mesh.vertices[t[0]];
    const Eigen::Vector3f b = mesh.vertices[t[2]] - mesh.vertices[t[0]];
    EXPECT_GT(a.cross(b).z(), 0.0F);  // seen from the bone that goes
  }
  const float most =
      *std::max_element(made.result.forces.normal.begin(), made.result.forces.normal.end());
  EXPECT_LE(*std::max_element(mesh.values.begin(), mesh.values.end()), most);
  const std::string csv = map_table(made.result);
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'),
            static_cast<std::ptrdiff_t>(made.map->poses() + 1));
  const SignalsFile signals = map_signals(made.result);
  for (const Signal& signal : signals.runs.front().signals)
    EXPECT_EQ(signal.values.size(), made.map->poses()) << signal.name;
  const HeatMap figure = map_figure(made.result, MapValue::largest_feed);
  EXPECT_EQ(figure.values.size(), figure.x_centres.size() * figure.y_centres.size());
}

std::string refusal(const std::vector<std::string>& overrides) {
  try {
    make(read(overrides));
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "accepted";
}

TEST(MapCase, RefusesBadInputWithTheKeyAndTheRule) {
  EXPECT_THAT(refusal({"map.advance_mm=30"}), testing::HasSubstr("cutting length"));
  EXPECT_THAT(refusal({"map.feed_mm_per_s=25"}), testing::HasSubstr("max_feed_mm_per_s"));
  EXPECT_THAT(refusal({"map.feed_mm_per_s=0.01"}), testing::HasSubstr("map.feed_mm_per_s"));
  EXPECT_THAT(refusal({"map.last_angle_deg=-70"}), testing::HasSubstr("first_angle_deg"));
  EXPECT_THAT(refusal({"map.forward=[0,0,1]"}), testing::HasSubstr("map.forward"));
  EXPECT_THAT(refusal({"limits.on=sideways"}), testing::HasSubstr("resultant | normal | feed"));
}

}  // namespace
}  // namespace osteomill::io
