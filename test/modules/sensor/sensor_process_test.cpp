// musher-sensor-manager as a controller drives it, with a real musher-world: programs over DDS.

#include <cmath>
#include <fstream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "musher/messages/protocol/manager.hpp"
#include "musher/messages/protocol/motion.hpp"
#include "musher/messages/protocol/sensor.hpp"
#include "musher/messages/sensor_msgs/laser_scan.hpp"
#include "musher/messages/std_msgs/string.hpp"
#include "musher/test/modules/module_process.hpp"
#include "musher/test/support/paths.hpp"

namespace musher::sensor::sensor_process_test {

using msg::ActuatorCommand;
using msg::SensorOperation;
using ::testing::HasSubstr;
using ::testing::StartsWith;

// The robot looks at a wall across the place, 2 m ahead.
constexpr const char* kScene = R"(
speed = 2
start.standing = true
body.noise = 0
lidar.noise_m = 0
[[wall]]
from_m = [2.0, -3.0]
to_m = [2.0, 3.0]
thickness_m = 0.02
)";

constexpr const char* kFile = R"(
self_check_ms = 30000
start_ms = 15000
critical = ["lidar"]
stamp_tolerance_ms = 2000
[lidar]
source = "world/scan"
silence_ms = 3000
[ultrasonic]
source = "world/ultrasonic"
silence_ms = 3000
[tof]
silence_ms = 3000
left_head = "world/tof/left_head"
right_head = "world/tof/right_head"
left_rear = "world/tof/left_rear"
right_rear = "world/tof/right_rear"
[gps]
source = "world/gps"
silence_ms = 3000
)";

// The machine goes by the world's clock.
class SensorManagerProcess : public test::ModuleProcess {
 protected:
  SensorManagerProcess() : ModuleProcess("sensor_manager", "musher-sensor-manager") {}

  void StartBoth() {
    StartWorld(kScene);
    StartOnWorldTime(kFile);
  }
  void InjectFault(const std::string& fault) {
    const auto faults = Publisher<msg::String>("world/fault");
    ASSERT_TRUE(peer_.Until([&] { return faults->MatchedReaders() > 0; }));
    ASSERT_TRUE(faults->Publish({fault}));
    ASSERT_TRUE(faults->Flush(std::chrono::seconds(120)));
  }
};

TEST_F(SensorManagerProcess, SeesTheWallComeNearerWhileTheRobotWalks) {
  std::optional<msg::LaserScan> scan;
  std::optional<msg::Range> range;
  std::optional<msg::HeadTofPayload> head;
  std::optional<msg::GpsPayload> gps;
  Listen("scan", scan);
  Listen("ultrasonic_payload", range);
  Listen("head_tof_payload", head);
  Listen("gps_payload", gps);
  StartBoth();
  ExpectDone("SelfCheck");
  ExpectDone("Active");
  ASSERT_TRUE(peer_.Until([&] {
    return scan && range && head && gps && head->left_head.data_available &&
           head->right_head.data_available;
  })) << peer_.Output();
  const float before = scan->ranges[scan->ranges.size() / 2];
  EXPECT_NEAR(before, 1.83, 0.1);
  EXPECT_TRUE(std::isinf(range->range));
  EXPECT_EQ(gps->fix_type, 3);

  const auto board = Publisher<msg::MotionCustomCommand>("world/body_command");
  ASSERT_TRUE(peer_.Until([&] { return board->MatchedReaders() > 0; }));
  msg::MotionCustomCommand walk;
  walk.mode = 11;
  walk.gait_id = 27;
  walk.life_count = 1;
  walk.vel_des = {0.5F, 0, 0};
  walk.duration = 2400;
  ASSERT_TRUE(board->Publish(walk));
  ASSERT_TRUE(peer_.Until([&] { return scan->ranges[scan->ranges.size() / 2] < before - 0.8F; }));
  EXPECT_TRUE(peer_.Until([&] { return std::isfinite(range->range); })) << peer_.Output();
  EXPECT_LT(range->range, 1);
}

TEST_F(SensorManagerProcess, LetsTheWorldRestInLowPowerAndWakesItAgain) {
  int scans = 0;
  Subscribe<msg::LaserScan>("scan", [&](const msg::LaserScan&) { ++scans; });
  StartBoth();
  // A world's publisher without a subscriber makes no readings: the test's publisher replaces it.
  const auto probe = Publisher<msg::LaserScan>("world/scan", transport::kSensorDataQos);
  const auto tof =
      Publisher<msg::SingleTofPayload>("world/tof/left_rear", transport::kSensorDataQos);
  ASSERT_TRUE(peer_.Until([&] { return probe->MatchedReaders() == 1; }));
  ExpectDone("Active");
  ASSERT_TRUE(peer_.Until([&] { return scans > 0; })) << peer_.Output();
  ExpectDone("LowPower");
  EXPECT_TRUE(
      peer_.Until([&] { return probe->MatchedReaders() == 0 && tof->MatchedReaders() == 0; }));
  ExpectDone("Active");
  ASSERT_TRUE(peer_.Until([&] { return probe->MatchedReaders() == 1; }));
  const int before = scans;
  EXPECT_TRUE(peer_.Until([&] { return scans > before; }));
  ExpectTornDown();
}

TEST_F(SensorManagerProcess, RunsThroughAllStates) {
  StartBoth();
  for (const BuiltInState state :
       {kSelfCheck, kActive, kDeActive, kProtected, kOta, kError, kSelfCheck}) {
    ExpectDone(state);
  }
  ExpectTornDown();
}

TEST_F(SensorManagerProcess, ChecksSleepingSensorsToo) {
  StartBoth();
  ExpectDone("LowPower");
  ExpectDone("SelfCheck");
}

TEST_F(SensorManagerProcess, FailsItsSelfCheckWithTheCriticalCodeAlone) {
  StartOnWorldTime("self_check_ms = 200\ncritical = [\"tof\"]\n" +
                   std::string(kFile).substr(std::string(kFile).find("[lidar]")));
  EXPECT_THAT(
      Failure(kSelfCheck),
      ::testing::AllOf(StartsWith("2209 "), HasSubstr("tof (critical): left_head: no reading"),
                       ::testing::Not(HasSubstr("lidar"))));
}

TEST_F(SensorManagerProcess, PassesItsSelfCheckDegradedWithoutSensorsThatAreNotCritical) {
  StartOnWorldTime("self_check_ms = 200\nskip = [\"ultrasonic\"]\n" +
                   std::string(kFile).substr(std::string(kFile).find("[lidar]")));
  const auto checked = peer_.Switch("SelfCheck");
  ASSERT_TRUE(checked);
  EXPECT_EQ(checked.value().verdict, ActuatorCommand::kVerdictDone);
  EXPECT_EQ(checked.value().status.degraded_code, 2109);
  EXPECT_THAT(checked.value().status.degraded_reason,
              ::testing::AllOf(HasSubstr("lidar: no reading received yet, 2109; tof: "),
                               HasSubstr("gps: "), ::testing::Not(HasSubstr("ultrasonic"))));
}

TEST_F(SensorManagerProcess, ReportsALidarThatFallsSilentAndDoesNotGetUpWithoutIt) {
  std::optional<msg::NodeError> error;
  Listen("node_errors", error);
  StartBoth();
  ExpectDone("Active");
  InjectFault("lidar");
  ASSERT_TRUE(peer_.Until([&] { return error && error->code == 2107; })) << peer_.Output();
  EXPECT_EQ(error->name, "sensor_manager");
  EXPECT_TRUE(AwaitOutput("lidar: silent for 3000 ms (2107 Lidar: Timeout)")) << peer_.Output();
  ExpectDone("LowPower");
  const auto up = peer_.Switch("Active");
  ASSERT_TRUE(up);
  EXPECT_EQ(up.value().verdict, ActuatorCommand::kVerdictFailed);
  EXPECT_EQ(up.value().code, 2101);
  EXPECT_EQ(up.value().status.state, "LowPower");
  InjectFault("none");
  ExpectDone("Active");
}

TEST_F(SensorManagerProcess, IsOperatedByTheService) {
  StartBoth();
  const auto operate = [this](std::uint16_t id, std::uint8_t operation) {
    return Call<SensorOperation>("sensor_operation", {id, operation}).code;
  };
  EXPECT_EQ(operate(SensorOperation::kLidar, SensorOperation::kClose), 2103);
  EXPECT_EQ(operate(SensorOperation::kAll, SensorOperation::kStop), 0);
  EXPECT_EQ(operate(SensorOperation::kAll, SensorOperation::kClose), 0);
  EXPECT_EQ(operate(SensorOperation::kTof, SensorOperation::kStart), 2203);
}

}  // namespace musher::sensor::sensor_process_test
