// What comes wrong from outside while a robot drives, or asks for a path: each drive has a definite
// end, within a bound, the robot stands then and touches nothing, and the reason is said.

#include <cmath>
#include <limits>

#include "musher/messages/rosgraph_msgs/clock.hpp"
#include "musher/messages/sensor_msgs/laser_scan.hpp"
#include "musher/test/modules/navigation/navigation_rig.hpp"

namespace musher::navigation::bad_input_test {

using testing::At;
using testing::GridOf;
using testing::TwoRooms;
using transport::GoalEnd;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr double kHuge = 1e308;

class Rig : public testing::NavigationRig {
 public:
  void TestBody() override {}

  using NavigationRig::AwaitEnd;
  using NavigationRig::CodeOf;
  using NavigationRig::controller_clock_;
  using NavigationRig::controller_node_;
  using NavigationRig::drives_;
  using NavigationRig::Follow;
  using NavigationRig::map_;
  using NavigationRig::Must;
  using NavigationRig::peers_;
  using NavigationRig::Plan;
  using NavigationRig::robot_;
  using NavigationRig::Run;
  using NavigationRig::StartServers;
  using NavigationRig::walls_;

  // Beside what the robot itself publishes.
  void PublishScan(std::vector<float> ranges, Duration stamp_off = {}, bool turns = true) {
    if (!scans_) {
      scans_ = Must(transport::MakePublisher<msg::LaserScan>(*peers_, "jetbot_0/scan",
                                                             transport::kSensorDataQos));
      Run(300);
    }
    msg::LaserScan scan;
    scan.header.frame_id = "map";
    scan.header.stamp = msg::ToStamp(peers_->loop().Now().time_since_epoch() + stamp_off);
    scan.angle_min = -3.14F;
    scan.angle_increment = ranges.empty() || !turns ? 0 : 6.28F / static_cast<float>(ranges.size());
    scan.range_min = 0.05F;
    scan.range_max = 8;
    scan.ranges = std::move(ranges);
    EXPECT_TRUE(scans_->Publish(scan));
  }
  void PublishMap(const std::function<void(msg::OccupancyGrid&)>& change) {
    msg::OccupancyGrid map = GridOf(walls_.map());
    change(map);
    EXPECT_TRUE(map_->Publish(map));
  }
  void PublishOdometry(const std::function<void(msg::Odometry&)>& change) {
    if (!odometry_) {
      odometry_ = Must(transport::MakePublisher<msg::Odometry>(*peers_, "jetbot_0/odom"));
      Run(300);
    }
    msg::Odometry odometry;
    odometry.header.frame_id = "map";
    odometry.header.stamp = msg::ToStamp(peers_->loop().Now().time_since_epoch());
    odometry.pose.pose = ToMessage(robot_.pose());
    change(odometry);
    EXPECT_TRUE(odometry_->Publish(odometry));
  }
  // Repeated until the end of the test.
  void Each(Duration period, std::function<void()> what) {
    timers_.push_back(peers_->loop().Every(period, std::move(what)));
  }

  std::size_t DriveAway() {
    StartServers();
    msg::Path path;
    path.header.frame_id = "map";
    path.poses = {At(1, 2), At(6.5, 2)};
    const std::size_t drive = Follow(path);
    EXPECT_TRUE(RunUntil([&] { return robot_.speed_m_s() > 0.8; }, 5000));
    return drive;
  }
  // Within twice the trajectory's time and what obstacles may cost.
  void ExpectDefiniteEnd(std::size_t drive) {
    ASSERT_TRUE(AwaitEnd(drive, 150'000));
    const auto& end = *drives_.ends[drive];
    if (end.end != GoalEnd::kSucceeded) {
      EXPECT_NE(end.result.error_code, 0);
      EXPECT_NE(end.result.error_msg, "");
      EXPECT_LT(end.result.error_msg.size(), 300U) << "a sentence, not a number of 300 digits";
    } else {
      EXPECT_NEAR(robot_.pose().at.x_m, 6.5, 0.3);
    }
    Run(1500);
    EXPECT_EQ(robot_.last_command(), msg::Twist{});
    EXPECT_NEAR(robot_.speed_m_s(), 0, 0.01);
    EXPECT_GT(robot_.least_room_m(), 0) << end.result.error_msg;
  }

  std::unique_ptr<transport::Publisher<msg::LaserScan>> scans_;
  std::unique_ptr<transport::Publisher<msg::Odometry>> odometry_;
  std::vector<transport::LoopHandlePtr> timers_;
};

struct BadInput {
  const char* name;
  std::function<void(Rig&)> happens;  // in the middle of a drive
};

void PrintTo(const BadInput& input, std::ostream* out) {
  *out << input.name;
}

class ADrive : public ::testing::TestWithParam<BadInput> {};

TEST_P(ADrive, HasADefiniteEndAtAStandWithItsReason) {
  Rig rig;
  const std::size_t drive = rig.DriveAway();
  GetParam().happens(rig);
  rig.ExpectDefiniteEnd(drive);
}

const BadInput kMaps[] = {
    {"MapOfNoCells",
     [](Rig& r) {
       r.PublishMap([](auto& map) {
         map.info.width = map.info.height = 0;
         map.data.clear();
       });
     }},
    {"MapOfOtherFrame",
     [](Rig& r) { r.PublishMap([](auto& map) { map.header.frame_id = "odom"; }); }},
    {"MapWithTooFewCells", [](Rig& r) { r.PublishMap([](auto& map) { map.data.resize(5); }); }},
    {"MapWithAnOriginThatIsNotANumber",
     [](Rig& r) { r.PublishMap([](auto& map) { map.info.origin.position.x = kNan; }); }},
    {"MapWithHugeCells",
     [](Rig& r) { r.PublishMap([](auto& map) { map.info.resolution = 1e30F; }); }},
    {"MapThatIsAllBlocked",
     [](Rig& r) { r.PublishMap([](auto& map) { map.data.assign(map.data.size(), 100); }); }},
    {"MapThatIsAllFree",
     [](Rig& r) { r.PublishMap([](auto& map) { map.data.assign(map.data.size(), 0); }); }},
    {"MapThatMoves",
     [](Rig& r) {
       r.Each(Milliseconds(200), [&r, i = 0]() mutable {
         r.PublishMap([&](auto& map) { map.info.origin.position.x = 0.3 * (++i % 7); });
       });
     }},
};

const BadInput kScans[] = {
    {"ScanOfNoRays", [](Rig& r) { r.Each(Milliseconds(50), [&r] { r.PublishScan({}); }); }},
    {"ScanOfNotANumber",
     [](Rig& r) {
       r.robot_.scan_silent = true;
       r.Each(Milliseconds(50), [&r] { r.PublishScan(std::vector<float>(180, std::nanf(""))); });
     }},
    {"ScanOfZeros",
     [](Rig& r) {
       r.robot_.scan_silent = true;
       r.Each(Milliseconds(50), [&r] { r.PublishScan(std::vector<float>(180, 0)); });
     }},
    {"ScanOfNegativeRanges",
     [](Rig& r) {
       r.robot_.scan_silent = true;
       r.Each(Milliseconds(50), [&r] { r.PublishScan(std::vector<float>(180, -3)); });
     }},
    {"ScanFromTheFuture",
     [](Rig& r) {
       r.robot_.scan_silent = true;
       r.Each(Milliseconds(50),
              [&r] { r.PublishScan(std::vector<float>(180, 7.9F), std::chrono::hours(1)); });
     }},
    {"ScanFromThePast",
     [](Rig& r) {
       r.robot_.scan_silent = true;
       r.Each(Milliseconds(50),
              [&r] { r.PublishScan(std::vector<float>(180, 7.9F), -std::chrono::seconds(5)); });
     }},
    {"ScanThatIsSilent", [](Rig& r) { r.robot_.scan_silent = true; }},
    {"ScanOfAWallAllAround",
     [](Rig& r) {
       r.robot_.scan_silent = true;
       r.Each(Milliseconds(50), [&r] { r.PublishScan(std::vector<float>(180, 0.3F)); });
     }},
};

const BadInput kOdometries[] = {
    {"OdometryThatJumps",
     [](Rig& r) {
       r.robot_.odometry_off = {30, 0, 0};
     }},
    {"OdometryThatJumpsToAndFro",
     [](Rig& r) {
       r.Each(Milliseconds(300), [&r, i = 0]() mutable {
         r.robot_.odometry_off = {++i % 2 ? 1.0 : 0.0, 0, 0};
       });
     }},
    {"OdometryThatDrifts",
     [](Rig& r) { r.Each(Milliseconds(20), [&r] { r.robot_.odometry_off.y_m += 0.004; }); }},
    {"OdometryThatStandsWithFreshStamps", [](Rig& r) { r.robot_.odometry_frozen = true; }},
    {"OdometryWithStampsThatStand", [](Rig& r) { r.robot_.stamps_stand = true; }},
    {"OdometryThatIsSilent", [](Rig& r) { r.robot_.odometry_silent = true; }},
    {"OdometryThatGoesBackInTime",
     [](Rig& r) {
       r.robot_.odometry_silent = true;
       r.Each(Milliseconds(20), [&r, i = 0]() mutable {
         r.PublishOdometry([&](auto& odometry) {
           odometry.header.stamp = msg::ToStamp(std::chrono::seconds(500) - Milliseconds(++i));
         });
       });
     }},
    {"OdometryOfNotANumber",
     [](Rig& r) {
       r.robot_.odometry_silent = true;
       r.Each(Milliseconds(20), [&r] {
         r.PublishOdometry([](auto& odometry) { odometry.pose.pose.position.y = kNan; });
       });
     }},
    {"OdometryOfHugeNumbers",
     [](Rig& r) {
       r.Each(Milliseconds(20), [&r] {
         r.PublishOdometry([](auto& odometry) { odometry.pose.pose.position.y = kHuge; });
       });
     }},
    {"OdometryOfAnotherFrame", [](Rig& r) { r.robot_.odometry_frame = "odom"; }},
    {"WheelsThatSlip", [](Rig& r) { r.robot_.stuck = true; }},
};

std::string NameOf(const ::testing::TestParamInfo<BadInput>& info) {
  return info.param.name;
}

INSTANTIATE_TEST_SUITE_P(WithAMap, ADrive, ::testing::ValuesIn(kMaps), NameOf);
INSTANTIATE_TEST_SUITE_P(WithAScan, ADrive, ::testing::ValuesIn(kScans), NameOf);
INSTANTIATE_TEST_SUITE_P(WithOdometry, ADrive, ::testing::ValuesIn(kOdometries), NameOf);

// Such a drive went on.
struct UselessInput {
  const char* name;
  std::function<void(Rig&)> happens;
  const char* reason;
};

void PrintTo(const UselessInput& input, std::ostream* out) {
  *out << input.name;
}

class ADriveWithUselessInput : public ::testing::TestWithParam<UselessInput> {};

TEST_P(ADriveWithUselessInput, EndsAtAStandWithItsReason) {
  Rig rig;
  const std::size_t drive = rig.DriveAway();
  GetParam().happens(rig);
  rig.ExpectDefiniteEnd(drive);
  EXPECT_GT(rig.CodeOf(drive), 0);
  EXPECT_THAT(rig.drives_.ends[drive]->result.error_msg, ::testing::HasSubstr(GetParam().reason));
}

const UselessInput kUselessInputs[] = {
    {"ScanWithAnAngleStepOf0",
     [](Rig& r) {
       r.robot_.scan_silent = true;
       r.Each(Milliseconds(50), [&r] { r.PublishScan(std::vector<float>(180, 7.9F), {}, false); });
     },
     "its angle step is 0"},
    {"ScanFromTheFutureAndThePastInTurn",
     [](Rig& r) {
       r.robot_.scan_silent = true;
       r.Each(Milliseconds(50), [&r, i = 0]() mutable {
         const Duration off = ++i % 2 == 0 ? i * std::chrono::minutes(1) : Duration{};
         r.PublishScan(std::vector<float>(180, 7.9F), off - i * Milliseconds(60));
       });
     },
     "its stamp does not follow that of the one before"},
    {"OdometryThatGoesBackByTwoSecondsEachTime",
     [](Rig& r) {
       r.robot_.odometry_silent = true;
       r.Each(Milliseconds(20), [&r, i = 0]() mutable {
         r.PublishOdometry([&](auto& odometry) {
           odometry.header.stamp = msg::ToStamp(std::chrono::seconds(50'000 - 2 * ++i));
         });
       });
     },
     "its stamps do not go on"},
};

INSTANTIATE_TEST_SUITE_P(Any, ADriveWithUselessInput, ::testing::ValuesIn(kUselessInputs),
                         [](const auto& one) { return one.param.name; });

class AClock : public ::testing::TestWithParam<double> {};

// The controller follows /clock, which is slower or faster than the body: the two do not agree
// about speeds.
TEST_P(AClock, ThatIsWrongByTenTimesEndsADriveAtAStandWithItsReason) {
  Rig rig;
  rig.controller_clock_ = Rig::Must(transport::Clock::FromTopic(*rig.controller_node_, [] {}));
  const auto clock = Rig::Must(transport::MakePublisher<msg::Clock>(
      *rig.peers_, transport::kClockTopic, transport::kClockQos));
  Duration shown = std::chrono::seconds(1000);
  rig.Each(Milliseconds(10), [&] {
    shown += FromSeconds(0.01 * GetParam());
    static_cast<void>(clock->Publish({msg::ToStamp(shown)}));
  });
  rig.Run(1000);
  rig.StartServers();
  msg::Path path;
  path.header.frame_id = "map";
  path.poses = {At(1, 2), At(6.5, 2)};
  rig.ExpectDefiniteEnd(rig.Follow(path));
}

INSTANTIATE_TEST_SUITE_P(TooSlowOrTooFast, AClock, ::testing::Values(0.1, 10.0),
                         [](const auto& one) { return one.param < 1 ? "Slow" : "Fast"; });

// Time stands with it: nothing is sent, and no limit comes nearer.
TEST(AClockThatStands, HoldsADriveWhichThenArrives) {
  Rig rig;
  rig.controller_clock_ = Rig::Must(transport::Clock::FromTopic(*rig.controller_node_, [] {}));
  const auto clock = Rig::Must(transport::MakePublisher<msg::Clock>(
      *rig.peers_, transport::kClockTopic, transport::kClockQos));
  Duration shown = std::chrono::seconds(1000);
  bool stands = false;
  rig.Each(Milliseconds(10), [&] {
    if (!stands) shown += Milliseconds(10);
    static_cast<void>(clock->Publish({msg::ToStamp(shown)}));
  });
  rig.Run(1000);
  const std::size_t drive = rig.DriveAway();
  stands = true;
  rig.Run(700);
  EXPECT_NEAR(rig.robot_.speed_m_s(), 0, 0.01);
  const int commands = rig.robot_.commands();
  rig.Run(5000);
  EXPECT_EQ(rig.robot_.commands(), commands);
  stands = false;
  rig.ExpectDefiniteEnd(drive);
  EXPECT_EQ(rig.drives_.ends[drive]->end, GoalEnd::kSucceeded);
}

struct BadGoal {
  const char* name;
  msg::PoseStamped start;
  msg::PoseStamped goal;
};

void PrintTo(const BadGoal& goal, std::ostream* out) {
  *out << goal.name;
}

class APath : public ::testing::TestWithParam<BadGoal> {};

// A path may begin anywhere on the map; the robot does not follow one that begins far from it.
TEST_P(APath, IsRefusedOrNotFollowedAndTheRobotStands) {
  Rig rig;
  rig.StartServers();
  msg::ComputePathToPose::Goal goal{.goal = GetParam().goal, .start = GetParam().start};
  goal.use_start = true;
  const auto plan = rig.Plan(goal);
  std::string why = plan.result.error_msg;
  if (plan.end == GoalEnd::kSucceeded) {
    const std::size_t drive = rig.Follow(plan.result.path);
    ASSERT_TRUE(rig.AwaitEnd(drive));
    EXPECT_EQ(rig.CodeOf(drive), 103);
    why = rig.drives_.ends[drive]->result.error_msg;
  }
  EXPECT_NE(why, "");
  EXPECT_LT(why.size(), 300U) << why;
  EXPECT_EQ(rig.robot_.pose(), (Pose{{1, 2, 0}, 0}));
}

INSTANTIATE_TEST_SUITE_P(Bad, APath,
                         ::testing::Values(BadGoal{"StartFarAway", At(6.5, 2), At(5, 2)},
                                           BadGoal{"StartOutsideOfTheMap", At(-50, 2), At(5, 2)},
                                           BadGoal{"StartThatIsHuge", At(kHuge, 2), At(5, 2)},
                                           BadGoal{"GoalThatIsHuge", At(1, 2), At(kHuge, -kHuge)},
                                           BadGoal{"GoalThatIsInfinite", At(1, 2), At(kInf, 2)},
                                           BadGoal{"GoalThatIsNotANumber", At(1, 2), At(2, kNan)},
                                           BadGoal{"GoalInAWall", At(1, 2), At(3.8, 0.6)}),
                         [](const auto& one) { return one.param.name; });

}  // namespace musher::navigation::bad_input_test
