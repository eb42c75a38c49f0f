// Maps of boxes as text, and the plans of a map as JSON.

#include "musher/modules/meilin/plan/box_map_text.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace musher::meilin::box_map_text_test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::StartsWith;

constexpr const char* kJson =
    R"({"grid": [[0,0,0],[0,2,0],[0,0,1],[3,0,0],[0,0,0],[0,0,0]], "team": "red", "method": 0,
        "timestamp": 1718400000000})";

TEST(BoxMapText, ReadsTheMessageOfThePage) {
  const BoxMapReading reading = ReadBoxMapJson(kJson);
  ASSERT_TRUE(reading.map);
  EXPECT_EQ(reading.map->side, Side::kRed);
  EXPECT_TRUE(reading.map->omni);
  EXPECT_EQ(reading.map->At({1, 1}), Box::kKfs2);
  EXPECT_EQ(reading.map->At({2, 2}), Box::kKfs1);
  EXPECT_EQ(reading.map->At({3, 0}), Box::kFake);
}

TEST(BoxMapText, ReadsTheSameFromToml) {
  const auto reading = ReadBoxMapText(
      "team = \"red\"\nmethod = \"omni\"\ngrid = [[0, 0, 0], [0, 2, 0], [0, 0, 1], [3, 0, 0], "
      "[0, 0, 0], [0, 0, 0]]\n",
      "map.toml");
  ASSERT_TRUE(reading.map) << FormatDiagnostic(reading.diagnostics.at(0));
  EXPECT_EQ(*reading.map, *ReadBoxMapJson(kJson).map);
}

TEST(BoxMapText, NamesThePlaceOfEachErrorInJson) {
  EXPECT_THAT(ReadBoxMapJson(R"({"grid": [[0,0,0],[0,4,0],[0,0],7,[0.5,0,"x"],[0,0,0]],
                                 "team": "bleu", "method": 2})")
                  .faults,
              ElementsAre(StartsWith("team: unknown value 'bleu'; did you mean 'blue'?"),
                          StartsWith("method: expected a whole number from 0 to 1, found 2"),
                          HasSubstr("grid[1][1]: expected 0 (empty), 1 (KFS1), 2 (KFS2)"),
                          "grid[2]: expected 3 numbers, found 2",
                          "grid[3]: expected 3 numbers, found a number", StartsWith("grid[4][0]: "),
                          StartsWith("grid[4][2]: ")));
  EXPECT_THAT(ReadBoxMapJson("{}").faults,
              ElementsAre(StartsWith("team: missing"), StartsWith("grid: missing")));
  EXPECT_THAT(ReadBoxMapJson(R"({"team": "red", "grid": [[0,0,0]]})").faults,
              ElementsAre(HasSubstr("found 1 row")));
}

TEST(BoxMapText, NamesThePlaceOfEachErrorInToml) {
  const auto reading = ReadBoxMapText(
      "team = \"blue\"\ngrid = [[0, 0, 0],\n[0, 4, 0], [0, 0, 0], [0, 0, 0], [0, 0, 0],\n[0]]\n",
      "map.toml");
  ASSERT_EQ(reading.diagnostics.size(), 2U);
  EXPECT_EQ(reading.diagnostics[0].line, 3);
  EXPECT_EQ(reading.diagnostics[0].column, 5);
  EXPECT_EQ(reading.diagnostics[1].line, 4);
}

TEST(BoxMapText, PrintsPlansInTheFormOfThePage) {
  const RouteReport report = FindRoutes(*ReadBoxMapJson(kJson).map);
  const auto json = nlohmann::json::parse(RoutesJson(report.routes));
  ASSERT_EQ(json["buckets"].size(), 5U);
  const auto& bucket = json["buckets"][1];
  EXPECT_EQ(bucket["kfs2_count"], 1);
  EXPECT_GE(bucket["total"].get<int>(), 10);
  ASSERT_EQ(bucket["paths"].size(), 10U);
  const auto& path = bucket["paths"][0];
  EXPECT_EQ(path["index"], 1);
  EXPECT_EQ(path["kfs2_count"], 1);
  EXPECT_EQ(path["steps"], path["detail"].size());
  EXPECT_EQ(path["detail"][0].size(), 8U);
  EXPECT_TRUE(path["cost"].is_number());
}

}  // namespace
}  // namespace musher::meilin::box_map_text_test
