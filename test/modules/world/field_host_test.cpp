// A field on a network: its hardware topics, in virtual time.

#include "musher/modules/world/process/world_field.hpp"

#include <gmock/gmock.h>

#include <limits>

#include "musher/messages/std_msgs/string.hpp"
#include "musher/messages/std_srvs/trigger.hpp"
#include "musher/test/modules/world/climber.hpp"
#include "musher/test/modules/world/scenes.hpp"
#include "musher/test/modules/world/world_on_network.hpp"

namespace musher::world::field_host_test {

using std::chrono::seconds;
using ::testing::Contains;
using ::testing::Each;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;
using Floats = msg::Float32MultiArray;

class FieldHostTest : public WorldOnNetwork {
 protected:
  FieldHostTest() {
    Scene scene;
    scene.name = "stairs";
    scene.has_body = false;
    scene.field = Stairs({0, 200});
    scene.field->boxes = {{"box", KfsKind::kKfs1, {1, 0}}};
    scene.field->robot.start_m = {0.2, 0};
    StartWorld(scene, &shooter_);
    network_.RunFor(Milliseconds(200));
  }
  void Send(const std::string& topic, const std::vector<float>& numbers,
            Duration time = Milliseconds(100)) {
    WorldOnNetwork::Send<Floats>(topic, {{}, numbers}, time);
  }
  void Fault(const std::string& fault) { InjectFault(fault, Milliseconds(100)); }
};

TEST_F(FieldHostTest, PublishesItsSensorsAtTheirRates) {
  std::vector<Floats> suspension, distances, arm, spear;
  std::vector<msg::PoseStamped> poses;
  std::vector<msg::Bool> ready;
  Keep("r0x0201", suspension);
  Keep("sensor_distances", distances);
  Keep("r0x0203", arm);
  Keep("r0x0204", spear);
  Keep("transformed/pose", poses);
  Keep("r1_ready", ready);
  for (auto* floats : {&suspension, &distances, &arm, &spear}) floats->clear();
  poses.clear();
  ready.clear();
  network_.RunFor(seconds(2));
  EXPECT_THAT(suspension, SizeIs(200));
  EXPECT_THAT(distances, SizeIs(200));
  EXPECT_THAT(arm, SizeIs(200));
  EXPECT_THAT(spear, SizeIs(200));
  EXPECT_THAT(poses, SizeIs(100));
  EXPECT_THAT(ready, SizeIs(10));
  EXPECT_EQ(suspension.back().data, (std::vector<float>{1, 1, 1, 1, 20, 20, 20, 20, 0, 0, 0, 0}));
  EXPECT_THAT(distances.back().data, SizeIs(8));
  EXPECT_EQ(arm.back().data, std::vector<float>(9, 0));
  EXPECT_EQ(poses.back().header.frame_id, "map");
  EXPECT_NEAR(poses.back().pose.position.x, 0.2, 1e-9);
  EXPECT_FALSE(ready.back().data);
}

TEST_F(FieldHostTest, DrivesAndLiftsByTheHardwareTopics) {
  Send("t0x0102_action", {230, 230, 230, 230}, seconds(1));
  EXPECT_EQ(host_->world().field()->robot().height_mm(), 230);
  Send("t0x0101_pid", {-0.5F, 0, 0}, seconds(2));
  EXPECT_LT(host_->world().field()->robot().position_m().x(), -0.5);
}

TEST_F(FieldHostTest, ReportsThatACommandOfTheArmIsDone) {
  Send("t0x0102_action", {230, 230, 230, 230}, seconds(1));
  std::vector<Floats> arm;
  Keep("r0x0203", arm);
  Send("t0x0103_", {1, 0, 0, 0});
  EXPECT_EQ(arm.back().data[0], 0);
  network_.RunFor(seconds(3));
  EXPECT_EQ(arm.back().data[0], 1);
  EXPECT_EQ(host_->world().field()->boxes()[0].where, KfsBox::Where::kGripper);
}

TEST_F(FieldHostTest, PublishesThatThePartnerIsReadyAfterTheDocking) {
  std::vector<msg::Bool> ready;
  Keep("r1_ready", ready);
  Send("t0x0104_", {3, 0, 0, 0});
  network_.RunFor(seconds(4));
  EXPECT_FALSE(ready.back().data);
  network_.RunFor(seconds(2));
  EXPECT_TRUE(ready.back().data);
}

TEST_F(FieldHostTest, RefusesInvalidNumbersAndLogsItOnce) {
  Send("t0x0101_pid", {1, std::numeric_limits<float>::quiet_NaN(), 0}, seconds(1));
  Send("t0x0102_action", {100, 100}, seconds(1));
  Send("t0x0103_", {9, 0, 0, 0});
  EXPECT_THAT(log_, SizeIs(3));
  EXPECT_THAT(log_, Contains("t0x0101_pid: a velocity that is not a number is refused"));
  EXPECT_THAT(log_, Contains("t0x0102_action: expected 4 numbers, found 2"));
  EXPECT_THAT(log_, Contains(HasSubstr("t0x0103_: arm: the command 9 is refused")));
  EXPECT_EQ(host_->world().field()->robot().wheels_mm()[0], 20);
}

TEST_F(FieldHostTest, KeepsFaultySensorsSilentUntilTheFaultEnds) {
  std::vector<Floats> suspension, distances, arm;
  std::vector<msg::PoseStamped> poses;
  Keep("r0x0201", suspension);
  Keep("sensor_distances", distances);
  Keep("r0x0203", arm);
  Keep("transformed/pose", poses);
  for (const char* fault : {"suspension silent", "arm silent", "pose silent", "distances lost"}) {
    Fault(fault);
  }
  suspension.clear();
  arm.clear();
  poses.clear();
  network_.RunFor(seconds(1));
  EXPECT_THAT(suspension, IsEmpty());
  EXPECT_THAT(arm, IsEmpty());
  EXPECT_THAT(poses, IsEmpty());
  EXPECT_THAT(distances.back().data, Each(::testing::IsNan()));
  Fault("none");
  network_.RunFor(seconds(1));
  EXPECT_THAT(suspension.size(), ::testing::Ge(100u));
  EXPECT_THAT(poses.size(), ::testing::Ge(50u));
  EXPECT_NEAR(distances.back().data[0], 30, 1e-3);
}

TEST_F(FieldHostTest, RepliesWithItsReport) {
  auto client = transport::MakeClient<msg::Trigger>(*desk_, "world/field").value();
  network_.RunFor(Milliseconds(100));
  std::string report;
  client->Call({}, seconds(1), [&](const Result<msg::Trigger::Response>& answer) {
    if (answer) report = answer.value().message;
  });
  network_.RunFor(seconds(1));
  EXPECT_THAT(report, HasSubstr(R"({"name":"stairs","side":"blue",)"));
}

}  // namespace musher::world::field_host_test
