// A humanoid and its guests on a network, in virtual time.

#include "musher/modules/world/process/world_show.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>

#include "musher/messages/stamp.hpp"
#include "musher/test/modules/world/scenes.hpp"
#include "musher/test/modules/world/world_on_network.hpp"

namespace musher::world::world_show_test {

using std::chrono::seconds;
using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

// A humanoid before which a guest makes a heart from 2 s to 4 s.
Scene Show() {
  Scene scene = EmptyYard();
  scene.humanoid.emplace();
  scene.humanoid->poses.push_back({{"heart"}, {}, {}});
  scene.humanoid->poses.back().angles[18] = -0.4;
  scene.cameras.cameras[0].on = CameraMount::kHead;
  GuestSpec guest;
  guest.from_m = {2, 0};
  guest.height_m = 0.5;
  guest.yaw_rad = M_PI;
  guest.acts.resize(3);
  guest.acts[0].look = GuestLook{GuestLook::At::kRobot};
  guest.acts[1].at = Seconds(2);
  guest.acts[1].gesture = Gesture::kHeart;
  guest.acts[2].at = Seconds(4);
  guest.acts[2].gesture = Gesture::kNone;
  scene.guests = {guest};
  return scene;
}

class WorldShowTest : public WorldOnNetwork {
 protected:
  WorldShowTest() : WorldOnNetwork("robot1") {}

  void Open(const Scene& scene) { StartWorld(scene); }
  template <class M>
  void Say(const std::string& topic, const std::vector<M>& messages) {
    const auto say = transport::MakePublisher<M>(*desk_, topic).value();
    network_.RunFor(Milliseconds(50));
    ASSERT_EQ(say->MatchedReaders(), 1);
    for (const M& message : messages) ASSERT_TRUE(say->Publish(message));
    network_.RunFor(Milliseconds(50));
  }
  static msg::PointStamped Point(double x, double y) {
    msg::PointStamped message;
    message.header.frame_id = "camera";
    message.point.x = x;
    message.point.y = y;
    return message;
  }
};

TEST_F(WorldShowTest, PublishesItsJointsEachStepWithTheWorldsTime) {
  Open(Show());
  std::vector<msg::JointState> states, commands;
  const auto reading = Listen("robot1/wedding/motion/joint_states", states);
  const auto subscription = Listen("robot1/wedding/motion/joint_commands", commands);
  network_.RunFor(Milliseconds(100));
  states.clear();
  commands.clear();
  network_.RunFor(seconds(1));
  EXPECT_THAT(states, SizeIs(50));
  EXPECT_THAT(commands, SizeIs(50));
  ASSERT_THAT(states[0].name, SizeIs(kJoints));
  EXPECT_EQ(states[0].name[kHeadYaw], "j23_head_yaw");
  EXPECT_THAT(states[0].position, SizeIs(kJoints));
  EXPECT_THAT(states[0].velocity, SizeIs(kJoints));
  EXPECT_EQ(msg::FromStamp(states[1].header.stamp) - msg::FromStamp(states[0].header.stamp), kStep);
}

TEST_F(WorldShowTest, TakesTheCommandedPose) {
  Open(Show());
  std::vector<msg::JointState> states;
  const auto reading = Listen("robot1/wedding/motion/joint_states", states);
  Say<msg::String>("robot1/wedding/motion/pose", {{"heart"}});
  network_.RunFor(seconds(4));
  EXPECT_NEAR(states.back().position[18], -0.4, 1e-9);
  EXPECT_EQ(host_->world().humanoid()->pose(), "heart");
  EXPECT_THAT(log_, IsEmpty());
}

TEST_F(WorldShowTest, RefusesAnUnknownPoseAndLogsIt) {
  Open(Show());
  Say<msg::String>("robot1/wedding/motion/pose", {{"heart"}, {"hart"}, {""}});
  EXPECT_EQ(host_->world().humanoid()->pose(), "heart");
  EXPECT_THAT(log_, ElementsAre(HasSubstr("\"hart\" is refused"), HasSubstr("\"\" is refused")));
}

TEST_F(WorldShowTest, LooksAtTheCommandedPoint) {
  Open(Show());
  Say<msg::PointStamped>("robot1/wedding/motion/look_at", {Point(0.25, 0.5)});
  network_.RunFor(seconds(5));
  EXPECT_NEAR(host_->world().gaze().yaw_rad * 180 / M_PI, 60, 1e-6);
}

TEST_F(WorldShowTest, RefusesNanGazesAndLogsItOnce) {
  Open(Show());
  Say<msg::PointStamped>("robot1/wedding/motion/look_at",
                         std::vector(100, Point(std::numeric_limits<double>::quiet_NaN(), 0.5)));
  network_.RunFor(seconds(1));
  EXPECT_EQ(host_->world().gaze().yaw_rad, 0);
  EXPECT_THAT(log_, ElementsAre(HasSubstr("refused")));
}

TEST_F(WorldShowTest, PublishesTheGestureOfAGuestTenTimesASecondAndItsEnd) {
  Open(Show());
  std::vector<msg::String> gestures;
  const auto subscription = Listen("robot1/wedding/perception/gesture", gestures);
  network_.RunFor(Milliseconds(1900));
  EXPECT_THAT(gestures, IsEmpty());
  network_.RunFor(Milliseconds(4000));
  ASSERT_THAT(gestures, SizeIs(21));
  EXPECT_EQ(gestures.back().data, "none");
  gestures.pop_back();
  EXPECT_THAT(gestures, Each(msg::String{"heart"}));
}

TEST_F(WorldShowTest, UsesTheTopicsOfItsScene) {
  Scene scene = Show();
  scene.humanoid->pose_topic = "arms/pose";
  Open(scene);
  Say<msg::String>("robot1/arms/pose", {{"heart"}});
  EXPECT_EQ(host_->world().humanoid()->pose(), "heart");
}

TEST_F(WorldShowTest, PublishesNothingWithoutAHumanoidAndGuests) {
  Open(EmptyYard());
  const auto say =
      transport::MakePublisher<msg::String>(*desk_, "robot1/wedding/motion/pose").value();
  std::vector<msg::JointState> states;
  const auto reading = Listen("robot1/wedding/motion/joint_states", states);
  network_.RunFor(seconds(1));
  EXPECT_EQ(say->MatchedReaders(), 0);
  EXPECT_EQ(reading->MatchedWriters(), 0);
}

}  // namespace musher::world::world_show_test
