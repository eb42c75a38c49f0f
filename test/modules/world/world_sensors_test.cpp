// The sensors of a world on a network, in virtual time.

#include "musher/modules/world/process/world_sensors.hpp"

#include <gmock/gmock.h>

#include <cmath>

#include "musher/messages/stamp.hpp"
#include "musher/messages/std_msgs/string.hpp"
#include "musher/test/modules/world/scenes.hpp"
#include "musher/test/modules/world/world_on_network.hpp"

namespace musher::world::world_sensors_test {

using std::chrono::seconds;
using ::testing::IsEmpty;
using ::testing::SizeIs;

class WorldSensorsTest : public WorldOnNetwork {
 protected:
  WorldSensorsTest() : WorldOnNetwork("dog1") {}

  void Open(const Scene& scene) {
    StartWorld(scene);
    network_.RunFor(Milliseconds(500));
  }
  template <class M>
  std::unique_ptr<transport::Subscription> Listen(const std::string& topic,
                                                  std::vector<M>& received) {
    auto subscription =
        WorldOnNetwork::Listen(Name("world/" + topic), received, transport::kSensorDataQos);
    network_.RunFor(Milliseconds(500));
    received.clear();
    return subscription;
  }
};

TEST_F(WorldSensorsTest, PublishEachAtItsRateWithTheWorldsTime) {
  Scene scene = EmptyYard();
  scene.sensors.ultrasonic.reach.rate_hz = 15;  // not a multiple of a step
  Open(scene);
  std::vector<msg::LaserScan> scans;
  std::vector<msg::Range> ranges;
  std::vector<msg::SingleTofPayload> tofs;
  std::vector<msg::NavSatFix> fixes;
  const auto scan = Listen("scan", scans);
  const auto ultrasonic = Listen("ultrasonic", ranges);
  const auto tof = Listen("tof/right_rear", tofs);
  const auto gps = Listen("gps", fixes);
  for (auto* received : {&scans}) received->clear();
  ranges.clear();
  tofs.clear();
  fixes.clear();
  network_.RunFor(seconds(10));
  EXPECT_THAT(scans, SizeIs(100));
  EXPECT_NEAR(static_cast<double>(ranges.size()), 150, 1);
  EXPECT_THAT(tofs, SizeIs(100));
  EXPECT_THAT(fixes, SizeIs(10));
  EXPECT_EQ(tofs.front().tof_position, msg::SingleTofPayload::kRightRear);
  const auto stamp = [](const auto& message) { return msg::FromStamp(message.header.stamp); };
  EXPECT_EQ(stamp(scans[7]) - stamp(scans[6]), Milliseconds(100));
  EXPECT_LE(stamp(scans.back()), host_->world().now());
  EXPECT_GT(stamp(scans.back()), host_->world().now() - Milliseconds(120));
}

TEST_F(WorldSensorsTest, FallSilentByTheirFaultsUntilThereIsNone) {
  Open(EmptyYard());
  std::vector<msg::LaserScan> scans;
  std::vector<msg::SingleTofPayload> left, right;
  const auto scan = Listen("scan", scans);
  const auto left_head = Listen("tof/left_head", left);
  const auto right_head = Listen("tof/right_head", right);
  InjectFault("lidar");
  InjectFault("tof_left_head");
  EXPECT_THAT(log_, ::testing::ElementsAre("fault: lidar", "fault: tof_left_head"));
  scans.clear();
  left.clear();
  right.clear();
  network_.RunFor(seconds(1));
  EXPECT_THAT(scans, IsEmpty());
  EXPECT_THAT(left, IsEmpty());
  EXPECT_THAT(right, SizeIs(10));
  InjectFault("tof");
  right.clear();
  network_.RunFor(seconds(1));
  EXPECT_THAT(right, IsEmpty());
  InjectFault("none");
  scans.clear();
  left.clear();
  right.clear();
  network_.RunFor(seconds(1));
  EXPECT_THAT(scans, SizeIs(10));
  EXPECT_THAT(left, SizeIs(10));
  EXPECT_THAT(right, SizeIs(10));
}

TEST_F(WorldSensorsTest, FallSilentAsConfiguredInTheScene) {
  Scene scene = EmptyYard();
  scene.events = {{seconds(3), FaultOn{"gps", 0}}};
  Open(scene);
  std::vector<msg::NavSatFix> fixes;
  const auto gps = Listen("gps", fixes);
  network_.RunFor(seconds(10));
  ASSERT_FALSE(fixes.empty());
  EXPECT_LT(msg::FromStamp(fixes.back().header.stamp), seconds(3));
}

TEST_F(WorldSensorsTest, AreMissingWhereTheSceneHasNone) {
  Scene scene = EmptyYard();
  scene.sensors.lidar.enabled = false;
  Open(scene);
  std::vector<msg::LaserScan> scans;
  const auto scan = Listen("scan", scans);
  network_.RunFor(seconds(1));
  EXPECT_EQ(scan->MatchedWriters(), 0);
  EXPECT_THAT(scans, IsEmpty());
}

}  // namespace musher::world::world_sensors_test
