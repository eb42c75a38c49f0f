// Plans of eight numbers a step: what is accepted, and each sentence of a refusal.

#include "musher/modules/meilin/plan/action_sequence.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

namespace musher::meilin::action_sequence_test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::StartsWith;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

struct Row {
  double action = 0;
  double row = 0;
  double col = 0;
  double height = 0;
  double yaw = 0;
};

msg::Float32MultiArray PlanOf(const std::vector<Row>& rows) {
  msg::Float32MultiArray plan;
  for (const Row& row : rows) {
    for (const double number : {row.action, row.row, row.col, row.height, row.yaw, 0., 0., 0.}) {
      plan.data.push_back(static_cast<float>(number));
    }
  }
  return plan;
}

PlanReading Read(const std::vector<Row>& rows, const PlanStart& start = {}) {
  return ReadActionSequence(PlanOf(rows), {}, start);
}

std::string Refusal(const std::vector<Row>& rows, const PlanStart& start = {}) {
  const PlanReading reading = Read(rows, start);
  EXPECT_TRUE(reading.segments.empty());
  return reading.message();
}

TEST(ActionSequence, BecomesSegmentsAndAnEnd) {
  const PlanReading reading = Read({{0, 0, 1, 0, 0},
                                    {1, 1, 1, 200, 0},
                                    {0, 1, 1, 200, 0},
                                    {1, 1, 0, 200, -kPi / 2},
                                    {0, 2, 1, 0, -kPi / 2}});
  ASSERT_EQ(reading.message(), "");
  ASSERT_EQ(reading.segments.size(), 6U);
  const Segment& fetch = reading.segments[1];
  EXPECT_EQ(fetch.segment_type, kFetchType);
  EXPECT_EQ(fetch.debug_name, "fetch (1, 1)");
  EXPECT_EQ(fetch.kfs_row, 1);
  EXPECT_EQ(fetch.kfs_col, 1);
  EXPECT_EQ(fetch.height_diff, 200);
  const Segment& move = reading.segments[4];
  EXPECT_EQ(move.segment_type, kMoveType);
  EXPECT_EQ(move.index, 4);
  EXPECT_EQ(move.move_row, 2);
  EXPECT_EQ(move.move_col, 1);
  EXPECT_EQ(move.target_height_mm, 400) << "of the map, not of the plan";
  EXPECT_NEAR(move.target_yaw, -kPi / 2, 1e-6);
  const Segment& done = reading.segments[5];
  EXPECT_EQ(done.segment_type, kPlanDoneType);
  EXPECT_EQ(done.debug_name, "meilin_plan_done");
  EXPECT_EQ(done.index, 5);
}

TEST(ActionSequence, RefusesEachFaultWithItsText) {
  struct Case {
    std::vector<Row> rows;
    const char* text;
  };
  const Row to_front{0, 0, 1, 0, 0};
  for (const Case& one : {
           Case{{{kNan, 0, 1}}, "action type contains NaN/Inf"},
           Case{{{kInfinity, 0, 1}}, "action type contains NaN/Inf"},
           Case{{{2, 0, 1}}, "arg0 must be 0(move) or 1(fetch): 2"},
           Case{{{0.01, 0, 1}}, "arg0 must be 0(move) or 1(fetch)"},
           Case{{{0, kNan, 1}}, "row contains NaN/Inf"},
           Case{{{0, 0, -kInfinity}}, "col contains NaN/Inf"},
           Case{{{0, 0.5, 1}}, "row must be an integer grid index: 0.5"},
           Case{{{0, 0, 1.01}}, "col must be an integer grid index: 1.01"},
           Case{{{0, 0, 1, kNan}}, "arg3/yaw contains NaN/Inf"},
           Case{{{0, 0, 1, 0, kInfinity}}, "arg3/yaw contains NaN/Inf"},
           Case{{{0, 6, 1}}, "move grid out of range: (6, 1)"},
           Case{{{0, 0, -1}}, "move grid out of range: (0, -1)"},
           Case{{{0, 1e30, 0}}, "move grid out of range: (1e+30, 0)"},
           Case{{to_front, {0, 1, 1, 400}}, "move target_height mismatch: 400 mm"},
           Case{{{0, 1, 1}}, "move with height change requires adjacent target grid"},
           Case{{to_front, {0, 1, 1}, {0, 0, 1}}, "move does not support backward direction"},
           Case{{to_front, {1, 1, 3, 200}}, "fetch grid out of range: (1, 3)"},
           Case{{to_front, {1, 1, 1, 200}, {1, 0, 0, 0, -1.57}},
                "fetch requires robot pose at current cell center"},
           Case{{to_front, {1, 2, 1, 400}}, "fetch KFS grid must be adjacent to current grid"},
           Case{{to_front, {1, 0, 1, 0}}, "fetch KFS grid must be adjacent to current grid"},
           Case{{to_front, {0, 1, 1}, {1, 0, 1, 0, kPi}}, "fetch only supports forward/left/right"},
           Case{{to_front, {1, 1, 1, 200, 0.13}}, "fetch yaw mismatch: 0.13 rad"},
           Case{{to_front, {0, 1, 1}, {1, 1, 0, 200, 0}}, "fetch yaw mismatch: 0.00 rad"},
           Case{{to_front, {0, 1, 1}, {1, 2, 1, -200}}, "fetch suspension height is negative"},
           Case{{to_front, {1, 1, 1, 1e9}}, "fetch suspension height is out of range"},
           Case{{to_front, {0, 1, 1}, {0, 1, 2}, {1, 1, 1, -200, -kPi / 2}},
                "fetch KFS grid (1, 1) is already driven over by step 2"},
           Case{{to_front, {1, 1, 1, 400}},
                "fetch height_diff mismatch: 400 mm, the blue field has"},
           Case{{to_front, {1, 1, 1, 0}}, "fetch height_diff mismatch: 0 mm"},
           Case{{to_front, {1, 1, 1, 200}, to_front, {1, 1, 1, 200}},
                "fetch KFS grid (1, 1) a second time: step 2 has taken its box"},
           Case{{to_front, {0, 1, 1, 0, 0.5}}, "move climbs across its heading: 0.50 rad"},
           Case{{to_front, {0, 5, 1}},
                "move from (0, 1) to (5, 1) crosses (1, 1), which has 200 mm"},
       }) {
    const std::string message = Refusal(one.rows);
    EXPECT_THAT(message, StartsWith(one.text));
    const auto step = std::to_string(one.rows.size()) + " of " + std::to_string(one.rows.size());
    EXPECT_THAT(message, HasSubstr("(step " + step + ")"));
  }
}

TEST(ActionSequence, RefusesANumberOfNumbersThatIsNoPlan) {
  EXPECT_THAT(ReadActionSequence({}, {}, {}).message(), StartsWith("empty Float32MultiArray"));
  auto plan = PlanOf({{0, 0, 1}});
  plan.data.push_back(0);
  EXPECT_THAT(ReadActionSequence(plan, {}, {}).message(),
              StartsWith("Float32MultiArray length must be divisible by 8: 9"));
  plan.data.assign((kMostSteps + 1) * kNumbersPerStep, 0);
  EXPECT_THAT(ReadActionSequence(plan, {}, {}).message(), StartsWith("too many steps: 1001"));
}

TEST(ActionSequence, RefusesALayoutThatContradictsItsNumbers) {
  auto plan = PlanOf({{0, 0, 1}, {0, 0, 0}});
  EXPECT_TRUE(ReadActionSequence(plan, {}, {}).ok()) << "an empty layout says nothing";
  plan.layout.dim = {{"step", 2, 8}, {"field", 8, 1}};
  EXPECT_TRUE(ReadActionSequence(plan, {}, {}).ok()) << "the stride of the competition's planner";
  plan.layout.dim = {{"step", 2, 16}, {"field", 8, 8}};
  EXPECT_TRUE(ReadActionSequence(plan, {}, {}).ok()) << "strides as ROS explains them";
  plan.layout.dim = {{"step", 3, 8}, {"field", 8, 1}};
  EXPECT_EQ(ReadActionSequence(plan, {}, {}).message(),
            "layout contradicts the data: 3 x 8 is not 16 numbers");
  const std::uint32_t most = std::numeric_limits<std::uint32_t>::max();
  plan.layout.dim.assign(9, {"x", most, 1});
  EXPECT_THAT(ReadActionSequence(plan, {}, {}).message(),
              StartsWith("layout contradicts the data"));
  plan.layout.dim.clear();
  plan.layout.data_offset = 8;
  EXPECT_EQ(ReadActionSequence(plan, {}, {}).message(),
            "layout contradicts the data: data_offset is 8, expected 0");
}

TEST(ActionSequence, ReportsTheFaultsOfAllSteps) {
  const PlanReading reading =
      Read({{0, 9, 9}, {0, 0, 1}, {1, 1, 1, 200, 1}, {3, 0, 0}, {0, 1, 1, 100}});
  ASSERT_EQ(reading.faults.size(), 4U);
  EXPECT_EQ(reading.faults[0].step, 1);
  EXPECT_EQ(reading.faults[1].step, 3);
  EXPECT_EQ(reading.faults[2].step, 4);
  EXPECT_EQ(reading.faults[3].step, 5) << "after a step that cannot be read, no place is known";
  EXPECT_EQ(reading.message(), reading.faults[0].message);
}

TEST(ActionSequence, ReportsAtMostFiftyFaults) {
  EXPECT_EQ(Read(std::vector<Row>(100, Row{7})).faults.size(), kMostPlanFaults);
}

TEST(ActionSequence, MayMoveFlatAlongCellsOfOneHeight) {
  EXPECT_EQ(Read({{0, 0, 2}, {0, 0, 0}, {0, 0, 1}}).message(), "");
}

TEST(ActionSequence, RefusesAFlatMoveOverAPitOrAPlatform) {
  const PlanStart at{{1, 0}, 400, 0, true};
  EXPECT_THAT(Refusal({{0, 1, 2}}, at),
              StartsWith("move from (1, 0) to (1, 2) crosses (1, 1), which has 200 mm"));
  EXPECT_THAT(Refusal({{0, 2, 1}}, at), HasSubstr("crosses")) << "over the corner of two others";
  EXPECT_THAT(Refusal({{0, 0, 1}, {0, 5, 0}}), HasSubstr("crosses"));
  EXPECT_THAT(Refusal({{0, 0, 0}}, {{5, 0}, 0, 0, true}), HasSubstr("crosses")) << "backward";
}

TEST(ActionSequence, MayStayOnACellBetweenTwoFetches) {
  EXPECT_EQ(Read({{0, 0, 1},
                  {0, 1, 1},
                  {1, 1, 2, 200, kPi / 2},
                  {0, 1, 1, 200, kPi / 2},
                  {1, 1, 0, 200, -kPi / 2}})
                .message(),
            "");
}

TEST(ActionSequence, RoundsWithinAThousandth) {
  EXPECT_TRUE(Read({{0.0005, 0.0005, 0.9995}}).ok());
  EXPECT_TRUE(Read({{0, -0.0005, 0}}).ok());
}

TEST(ActionSequence, KeepsYawsInOneTurn) {
  EXPECT_NEAR(Read({{0, 0, 1, 0, 3 * kPi / 2}}).segments[0].target_yaw, -kPi / 2, 1e-5);
}

TEST(ActionSequence, IsCheckedAgainstTheSideOfTheField) {
  const auto plan = PlanOf({{0, 1, 0}, {0, 2, 0, 600}});
  PlanRules rules;
  const PlanStart start{{1, 0}, 400, 0, true};
  EXPECT_TRUE(ReadActionSequence(plan, rules, start).ok());
  rules.grid.side = Side::kRed;
  EXPECT_THAT(ReadActionSequence(plan, rules, start).message(),
              HasSubstr("the red field has 200 mm at (2, 0)"));
}

TEST(ActionSequence, IsCheckedFromWhereTheRobotIs) {
  const std::vector<Row> climb = {{0, 2, 1, 400}};
  EXPECT_THAT(Refusal(climb), StartsWith("move with height change requires adjacent"));
  EXPECT_EQ(Read(climb, {{1, 1}, 200, 0, true}).message(), "");
  const std::vector<Row> fetch = {{1, 2, 1, 200}};
  EXPECT_EQ(Read(fetch, {{1, 1}, 200, 0, true}).message(), "");
  EXPECT_THAT(Refusal(fetch, {{1, 1}, 200, 0, false}), StartsWith("fetch requires robot pose"));
}

TEST(ActionSequence, SetsTheWheelsFromTheNormalHeight) {
  const auto plan = PlanOf({{0, 1, 1}, {1, 2, 1, -20}});
  PlanRules rules;
  const PlanStart start{{1, 1}, 200, 0, true};
  EXPECT_THAT(ReadActionSequence(plan, rules, start).message(),
              StartsWith("fetch height_diff mismatch"));
  rules.normal_height_mm = 10;
  EXPECT_THAT(ReadActionSequence(plan, rules, start).message(),
              HasSubstr("10 mm of wheels and -20 mm of difference make -10 mm"));
}

TEST(PlanStart, IsTheLivePoseInsideTheGrid) {
  const Grid grid;
  const PlanStart initial{{0, 1}, 0, 0, true};
  EXPECT_EQ(StartOf(grid, initial, std::nullopt), initial);
  EXPECT_EQ(StartOf(grid, initial, Pose2{0.5, -0.2, 0}), initial) << "before the field";
  EXPECT_EQ(StartOf(grid, initial, Pose2{2.4, 2.4, kNan}), initial);
  EXPECT_EQ(StartOf(grid, initial, Pose2{kNan, 2.4, 0}), initial);
  const PlanStart live = StartOf(grid, initial, Pose2{2.5, 2.4, kPi / 2});
  EXPECT_EQ(live, (PlanStart{{1, 1}, 200, kPi / 2, true}));
  EXPECT_FALSE(StartOf(grid, initial, Pose2{2.6, 2.4, 0}).at_centre);
}

TEST(ActionSequence, GoesThereAndBackAsAMessage) {
  const std::vector<PlanStep> steps = {{false, {0, 1}, 0, 0}, {true, {1, 1}, 200, 0}};
  const msg::Float32MultiArray plan = ToActionSequence(steps);
  EXPECT_THAT(plan.data, ElementsAre(0, 0, 1, 0, 0, 0, 0, 0, 1, 1, 1, 200, 0, 0, 0, 0));
  ASSERT_EQ(plan.layout.dim.size(), 2U);
  EXPECT_EQ(plan.layout.dim[0], (msg::MultiArrayDimension{"step", 2, 8}));
  EXPECT_EQ(plan.layout.dim[1], (msg::MultiArrayDimension{"field", 8, 1}));
  EXPECT_TRUE(ReadActionSequence(plan, {}, {}).ok());
  EXPECT_EQ(PlanIdOf(3), "mf_action_seq_3");
}

}  // namespace
}  // namespace musher::meilin::action_sequence_test
