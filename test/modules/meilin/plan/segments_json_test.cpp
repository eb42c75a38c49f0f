// Old plans in JSON: defaults of each type, and errors with their places.

#include "musher/modules/meilin/plan/segments_json.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace musher::meilin::segments_json_test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::StartsWith;

SegmentsReading ReadOne(const std::string& segment) {
  return ReadSegmentsJson(R"({"segments": [)" + segment + "]}");
}

TEST(SegmentsJson, HasTheDefaultsOfEachType) {
  struct Case {
    const char* type;
    bool drives;
    double speed_m_s;
    double timeout_s;
    bool waits;
    int arm;
  };
  for (const Case& one :
       {Case{"SPEAR_PREP", true, 0.4, 30, true, 0}, Case{"SPEAR_GRASP", false, 0.5, 5, true, 0},
        Case{"ALIGN", true, 0.4, 30, true, 0}, Case{"DOCK", false, 0.5, 10, true, 0},
        Case{"MOVE2", true, 0.5, 30, true, 0}, Case{"GRASP", false, 0.5, 30, true, 1},
        Case{"STORE1", false, 0.5, 30, false, 2}, Case{"STORE2", false, 0.5, 30, false, 3},
        Case{"EXIT", true, 0.6, 30, true, 7}, Case{"FINAL_MOVE2", true, 0.4, 30, true, 0},
        Case{"PLACE_MID", false, 0.5, 30, true, 5}, Case{"PLACE_HIGH", false, 0.5, 30, true, 6},
        Case{"FINISH", false, 0.5, 30, true, 7}}) {
    const std::string target = one.drives ? R"(, "move_target": {"x": 1, "y": 2, "yaw": 3})" : "";
    const SegmentsReading reading =
        ReadOne(R"({"segment_type": ")" + std::string(one.type) + "\"" + target + "}");
    ASSERT_EQ(reading.message(), "") << one.type;
    const Segment& segment = reading.segments.at(0);
    EXPECT_EQ(segment.segment_type, one.type);
    EXPECT_EQ(segment.max_speed, one.speed_m_s) << one.type;
    EXPECT_EQ(segment.timeout_sec, one.timeout_s) << one.type;
    EXPECT_EQ(segment.wait_result, one.waits) << one.type;
    EXPECT_EQ(segment.arm_command, one.arm) << one.type;
    EXPECT_EQ(segment.target_y, one.drives ? 2 : 0);
    EXPECT_EQ(reading.warnings.size(), one.arm > 6 ? 1U : 0U) << "the arm rejects it";
  }
  EXPECT_EQ(OldSegmentTypes().size(), 14U);
}

TEST(SegmentsJson, ReadsAWholeSegment) {
  const SegmentsReading reading = ReadSegmentsJson(R"({"stage": "meilin", "plan_id": "7",
    "segments": [{"segment_type": "CLIMB", "move_target": {"x": 1.5, "y": -2, "yaw": 0.5},
      "max_speed": 0.3, "timeout_sec": 12, "suspension_timeout_sec": 9, "climb_mode": "DOWN",
      "climb_direction": "RIGHT", "climb_height": 200, "arm_command": 4, "wait_result": false,
      "height_diff": -20}]})");
  ASSERT_EQ(reading.message(), "");
  EXPECT_EQ(reading.stage, "meilin");
  EXPECT_EQ(reading.plan_id, "7");
  const Segment& segment = reading.segments.at(0);
  EXPECT_EQ(segment.target_x, 1.5);
  EXPECT_EQ(segment.target_yaw, 0.5);
  EXPECT_EQ(segment.max_speed, 0.3);
  EXPECT_EQ(segment.suspension_timeout_sec, 9);
  EXPECT_EQ(segment.climb_mode, 2);
  EXPECT_EQ(segment.climb_direction, 2);
  EXPECT_EQ(segment.climb_height, 200);
  EXPECT_EQ(segment.arm_command, 4);
  EXPECT_FALSE(segment.wait_result);
  EXPECT_EQ(segment.height_diff, -20);
}

TEST(SegmentsJson, NamesThePlaceOfEachError) {
  const SegmentsReading reading = ReadSegmentsJson(R"({"stage": 3, "segments": [
    {"segment_type": "ALIGNN", "max_sped": 1},
    {"segment_type": "CLIMB", "move_target": {"x": 1}, "climb_mode": "UPP", "max_speed": "fast"},
    {"segment_type": "ALIGN"}, 4, {}]})");
  EXPECT_TRUE(reading.segments.empty());
  EXPECT_THAT(
      reading.faults,
      ElementsAre(StartsWith("stage: expected a string, found 3"),
                  StartsWith("segments[0].segment_type: unknown value 'ALIGNN'; did you mean "
                             "'ALIGN'?, expected SPEAR_PREP"),
                  "segments[0].max_sped: unknown key; did you mean 'max_speed'?",
                  "segments[1].move_target.y: missing, expected metres",
                  "segments[1].max_speed: expected a number from 0.01 to 5, found a string",
                  StartsWith("segments[1].climb_mode: unknown value 'UPP'; did you mean 'UP'?"),
                  "segments[2].move_target: missing, ALIGN drives to a pose",
                  "segments[3]: expected an object, found a number",
                  StartsWith("segments[4].segment_type: missing")));
}

TEST(SegmentsJson, NamesLineAndColumnOfTextThatIsNoJson) {
  EXPECT_THAT(ReadSegmentsJson("{\n  \"segments\": [,]}").message(),
              StartsWith("line 2, column 16: invalid JSON: "));
  EXPECT_THAT(ReadSegmentsJson("").message(), StartsWith("line 1, column 1: invalid JSON"));
  EXPECT_THAT(ReadSegmentsJson("{\"segments\": 1e999}").message(), HasSubstr("invalid JSON"));
}

TEST(SegmentsJson, RefusesAPlanWithoutSegments) {
  EXPECT_THAT(ReadSegmentsJson("{}").message(), StartsWith("segments: missing"));
  EXPECT_THAT(ReadSegmentsJson("[]").message(), StartsWith("expected an object, found an array"));
  EXPECT_THAT(ReadSegmentsJson(R"({"segments": []})").message(), HasSubstr("at least one"));
  EXPECT_THAT(ReadSegmentsJson(R"({"segments": {}})").message(), HasSubstr("expected an array"));
}

TEST(SegmentsJson, SurvivesDeepNesting) {
  const std::string deep = std::string(50'000, '[') + std::string(50'000, ']');
  EXPECT_FALSE(ReadSegmentsJson(deep).ok());
  EXPECT_FALSE(ReadSegmentsJson(std::string(50'000, '[')).ok());
}

}  // namespace
}  // namespace musher::meilin::segments_json_test
