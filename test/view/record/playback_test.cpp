#include "musher/view/record/playback.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace musher::view::playback_test {

using ::testing::HasSubstr;

constexpr std::int64_t kFrom = 1'780'000'000'000'000'000;
constexpr std::int64_t kMs = 1'000'000;

TEST(PlaySchedule, TheGapsAreThoseOfTheRecording) {
  const Time begin = Time{} + std::chrono::hours(1);
  const PlaySchedule schedule(begin, kFrom, 1.0);
  EXPECT_EQ(schedule.DueAt(kFrom), begin);
  EXPECT_EQ(schedule.DueAt(kFrom + 250 * kMs), begin + Milliseconds(250));
  EXPECT_EQ(schedule.At(begin + Milliseconds(250)), kFrom + 250 * kMs);
}

TEST(PlaySchedule, TwiceAsFastHalvesTheGaps) {
  const Time begin{};
  const PlaySchedule schedule(begin, kFrom, 2.0);
  EXPECT_EQ(schedule.DueAt(kFrom + 1000 * kMs), begin + Milliseconds(500));
  EXPECT_EQ(schedule.At(begin + Milliseconds(500)), kFrom + 1000 * kMs);
}

TEST(PlaySchedule, WhatIsBeforeTheBeginningIsDueAtOnce) {
  const PlaySchedule schedule(Time{}, kFrom, 1.0);
  EXPECT_EQ(schedule.DueAt(kFrom - 5000 * kMs), Time{});
}

TEST(TopicNames, GivesATopicItsOtherName) {
  const TopicNames remapping = TopicNames::Of({"/chat:=/old/chat", "a:=b"}).value();
  EXPECT_EQ(remapping.NameOf("/chat"), "/old/chat");
  EXPECT_EQ(remapping.NameOf("/a"), "/b");
  EXPECT_EQ(remapping.NameOf("/other"), "/other");
}

TEST(TopicNames, RefusesARuleThatIsNone) {
  for (const std::string rule : {"/chat", "/chat=/b", ":=/b", "/a:=", "/a:=/b/", "/a b:=/c"}) {
    const auto remapping = TopicNames::Of({rule});
    ASSERT_FALSE(remapping) << rule;
    EXPECT_THAT(remapping.error().message, HasSubstr("'" + rule + "'; expected FROM:=TO"));
  }
  EXPECT_FALSE(TopicNames::Of({"/a:=/b", "a:=/c"}));
}

TEST(Playback, ARobotWouldObeyTheTopicsOfAMachine) {
  EXPECT_TRUE(IsOfMachine("/musher/emergency_stop", "musher_msgs/msg/EmergencyStop"));
  EXPECT_TRUE(IsOfMachine("/dog1/musher/machine_status", "musher_msgs/msg/MachineStatus"));
  EXPECT_TRUE(IsOfMachine("/elsewhere", "musher_msgs/msg/EmergencyStop"));
  EXPECT_FALSE(IsOfMachine("/image_rgb", "sensor_msgs/msg/Image"));
}

TEST(Playback, KnowsWhatADriverMovesByFromWhatIsOnlyLookedAt) {
  EXPECT_TRUE(IsCommand("/dog1/cmd_vel", "std_msgs::msg::dds_::String_"));
  EXPECT_TRUE(IsCommand("/teleop", "geometry_msgs::msg::dds_::Twist_"));
  EXPECT_TRUE(IsCommand("/arm/joint_trajectory", "any"));
  EXPECT_TRUE(IsCommand("/servo_cmd", "any"));
  EXPECT_TRUE(IsCommand("/position_controller/commands", "any"));
  for (const char* seen : {"/scan", "/odom", "/tf", "/camera/image_raw", "/joint_states", "/map",
                           "/clock", "/recommendation"}) {
    EXPECT_FALSE(IsCommand(seen, "sensor_msgs::msg::dds_::Image_")) << seen;
  }
}

TEST(Playback, AToolThatShowsWhatItReadsIsNoDriver) {
  EXPECT_TRUE(IsViewer("/rviz2"));
  EXPECT_TRUE(IsViewer("/dog1/foxglove_bridge"));
  EXPECT_TRUE(IsViewer("/rqt_gui_py_node_12"));
  EXPECT_TRUE(IsViewer("/foxglove_bridge, /rviz2"));
  EXPECT_FALSE(IsViewer("/base_controller_node, /foxglove_bridge"));
  EXPECT_FALSE(IsViewer("/foxglove_bridge, /base_controller_node"));
  EXPECT_FALSE(IsViewer("/rviz2, /rviz3 and 2 more"));
  EXPECT_FALSE(IsViewer("/base_driver"));
  EXPECT_FALSE(IsViewer("process 7 of rviz-host"));
  EXPECT_FALSE(IsViewer(""));
}

TEST(Playback, ReadsDurationsAndSizesWithTheirUnits) {
  EXPECT_EQ(DurationFrom("90s").value(), std::chrono::seconds(90));
  EXPECT_EQ(DurationFrom("1.5").value(), Milliseconds(1500));
  EXPECT_EQ(DurationFrom("5m").value(), std::chrono::minutes(5));
  EXPECT_EQ(BytesFrom("2G").value(), 2ULL << 30);
  EXPECT_EQ(BytesFrom("500").value(), 500U);
}

TEST(Playback, RefusesADurationOrSizeThatIsNone) {
  for (const std::string text : {"", "m", "0s", "-1s", "5 m", "1.2.3s", "5y", "nan", "1e99", "."}) {
    EXPECT_FALSE(DurationFrom(text)) << text;
    EXPECT_FALSE(BytesFrom(text)) << text;
  }
  EXPECT_THAT(DurationFrom("5y").error().message, HasSubstr("invalid duration '5y'; expected"));
}

}  // namespace musher::view::playback_test
