// What RViz gets of the robots of a world, in virtual time: their URDF, and where their links are.

#include "musher/modules/world/process/world_frames.hpp"

#include <gmock/gmock.h>

#include <map>
#include <regex>
#include <set>

#include "musher/modules/world/body/camera_model.hpp"
#include "musher/modules/world/body/humanoid_kinematics.hpp"
#include "musher/test/modules/world/rooms.hpp"
#include "musher/test/modules/world/scenes.hpp"
#include "musher/test/modules/world/world_on_network.hpp"

namespace musher::world::world_frames_test {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using std::chrono::seconds;
using ::testing::HasSubstr;

constexpr double kTiny = 1e-6;

// Every match of the expression's first group.
std::set<std::string> All(const std::string& text, const std::string& expression) {
  const std::regex regex(expression);
  std::set<std::string> found;
  for (std::sregex_iterator at(text.begin(), text.end(), regex), end; at != end; ++at) {
    found.insert((*at)[1]);
  }
  return found;
}

class WorldFramesTest : public WorldOnNetwork {
 protected:
  void Open(const Scene& scene) {
    StartWorld(scene);
    for (const char* topic : {"tf", "tf_static"}) {
      const bool fixed = topic == std::string("tf_static");
      kept_.push_back(transport::MakeSubscription<msg::TfMessage>(
                          *desk_, topic,
                          [this, fixed](const msg::TfMessage& message, const auto&) {
                            ++(fixed ? static_samples_ : samples_);
                            for (const auto& one : message.transforms) Take(one);
                          },
                          fixed ? transport::kLatchedQos : transport::kDefaultQos)
                          .value());
    }
    network_.RunFor(seconds(1));
  }
  // The latched URDF of a topic.
  std::string Description(const std::string& topic) {
    std::string urdf;
    const auto subscription = transport::MakeSubscription<msg::String>(
        *desk_, topic, [&](const msg::String& text, const auto&) { urdf = text.data; },
        transport::kLatchedQos);
    network_.RunFor(Milliseconds(200));
    return urdf;
  }
  // Where the frame is in the root of its tree.
  Isometry3d Find(const std::string& frame, const std::string& root) const {
    Isometry3d placement = Isometry3d::Identity();
    std::string at = frame;
    for (int depth = 0; at != root && depth < 20; ++depth) {
      const auto found = parents_.find(at);
      if (found == parents_.end()) break;
      placement = found->second.second * placement;
      at = found->second.first;
    }
    EXPECT_EQ(at, root) << frame << " has no such ancestor";
    return placement;
  }
  // Each link but the root is the child of one joint, and has a transform from its parent.
  void ExpectATree(const std::string& urdf, const std::string& root) const {
    std::set<std::string> links = All(urdf, "<link name=\"([^\"]+)\"");
    const std::set<std::string> children = All(urdf, "<child link=\"([^\"]+)\"");
    EXPECT_EQ(links.erase(root), 1U) << urdf;
    EXPECT_EQ(links, children);
    for (const std::string& link : links) Find(link, root);
  }

  std::map<std::string, std::pair<std::string, Isometry3d>> parents_;  // by the child
  int samples_ = 0;
  int static_samples_ = 0;

 private:
  void Take(const msg::TransformStamped& one) {
    const auto& t = one.transform.translation;
    const auto& r = one.transform.rotation;
    Isometry3d placement = Isometry3d::Identity();
    placement.translate(Vector3d(t.x, t.y, t.z));
    placement.rotate(Eigen::Quaterniond(r.w, r.x, r.y, r.z));
    const auto [known, is_new] = parents_.try_emplace(one.child_frame_id);
    if (!is_new) {
      EXPECT_EQ(known->second.first, one.header.frame_id) << "a frame has one parent";
    }
    known->second = {one.header.frame_id, placement};
  }
};

TEST_F(WorldFramesTest, HaveARobotWhereItsOdometryHasIt) {
  Scene scene = RobotYard();
  scene.robots[0].start_m = {1, 2, 0};
  scene.robots[0].start_yaw_rad = 0.5;
  Open(scene);
  for (const char* frame : {"jetbot_0/base_link", "jetbot_0"}) {
    const Isometry3d placement = Find(frame, "map");
    EXPECT_TRUE(placement.translation().isApprox(Vector3d(1, 2, 0), kTiny)) << frame;
    EXPECT_NEAR(std::atan2(placement(1, 0), placement(0, 0)), 0.5, kTiny) << frame;
  }
  EXPECT_EQ(parents_.at("jetbot_0/base_link").first, "jetbot_0/odom");
  samples_ = 0;
  network_.RunFor(seconds(2));
  EXPECT_NEAR(samples_, 40, 1);
  EXPECT_EQ(static_samples_, 1);
}

TEST_F(WorldFramesTest, HaveARobotWhereAFaultOfItsOdometryHasIt) {
  Scene scene = RobotYard();
  scene.robots[0].start_m = {1, 2, 0};
  Open(scene);
  const auto fault =
      transport::MakePublisher<msg::String>(*desk_, "world/jetbot_0/odometry").value();
  network_.RunFor(seconds(1));
  msg::String jump;
  jump.data = "jump 1 0.5";
  ASSERT_TRUE(fault->Publish(jump));
  network_.RunFor(seconds(1));
  EXPECT_TRUE(Find("jetbot_0/base_link", "map").translation().isApprox(Vector3d(2, 2.5, 0), kTiny));
}

TEST_F(WorldFramesTest, DescribeARobotWithItsSensorsAndHand) {
  Open(RobotYard());
  const std::string urdf = Description("jetbot_0/robot_description");
  ExpectATree(urdf, "jetbot_0/base_link");
  EXPECT_THAT(urdf, HasSubstr("<link name=\"jetbot_0/hand\">"));
  EXPECT_THAT(urdf, HasSubstr("<cylinder radius=\"0.2"));
  EXPECT_TRUE(
      Find("jetbot_0/hand", "jetbot_0/base_link").translation().isApprox(Vector3d(0.35, 0, 0.4)));
}

TEST_F(WorldFramesTest, HaveTheBodyWithItsSensorsByItsOdometry) {
  Open(EmptyYard());
  ExpectATree(Description("robot_description"), "base_link");
  const World world = host_->world();
  const CameraSpec& camera = world.scene().cameras.cameras[0];
  const Isometry3d expected =
      CameraInPlace(camera, world.body().odometry(), world.body().attitude(), {});
  EXPECT_TRUE(Find("camera_front", "odom").isApprox(expected, kTiny));
}

// Its odometry begins where it was switched on; a localisation knows where that is.
TEST_F(WorldFramesTest, HaveTheBodyInTheMapOfALocalisedScene) {
  Scene scene = EmptyYard();
  scene.localised = true;
  scene.start = {{1, 2}, 0.5};
  Open(scene);
  const World world = host_->world();
  const Isometry3d expected = BodyInPlace(world.body().pose(), world.body().attitude());
  EXPECT_TRUE(Find("base_link", "map").isApprox(expected, kTiny));
  EXPECT_FALSE(Find("base_link", "odom").isApprox(expected, kTiny));
}

TEST_F(WorldFramesTest, MoveTheLimbsOfAHumanoidByItsJoints) {
  Scene scene = EmptyYard();
  scene.start_standing = true;
  scene.cameras.cameras[0].on = CameraMount::kHead;
  scene.humanoid.emplace();
  PoseSpec pose{{"wave"}, {}, {}, {}};
  for (std::size_t i = 0; i < kJoints; ++i) {
    pose.angles[i] = (JointTable()[i].least_rad + 2 * JointTable()[i].most_rad) / 3;
  }
  scene.humanoid->poses.push_back(pose);
  Open(scene);
  const auto publisher =
      transport::MakePublisher<msg::String>(*desk_, "wedding/motion/pose").value();
  const auto gaze =
      transport::MakePublisher<msg::PointStamped>(*desk_, "wedding/motion/look_at").value();
  std::vector<msg::JointState> states;
  const auto subscription = transport::MakeSubscription<msg::JointState>(
      *desk_, "joint_states",
      [&](const msg::JointState& state, const auto&) { states.push_back(state); });
  network_.RunFor(Milliseconds(100));
  ASSERT_TRUE(publisher->Publish({"wave"}));
  msg::PointStamped look;
  look.point.x = 0.2;
  look.point.y = 0.8;
  ASSERT_TRUE(gaze->Publish(look));
  network_.RunFor(seconds(30));

  const std::string urdf = Description("robot_description");
  ExpectATree(urdf, "base_link");
  const std::set<std::string> turning = All(urdf, "<joint name=\"([^\"]+)\" type=\"revolute\"");
  ASSERT_FALSE(states.empty());
  EXPECT_EQ(turning, std::set(states.back().name.begin(), states.back().name.end()));
  EXPECT_NEAR(static_cast<double>(states.size()), 20 * 30, 6);

  const World world = host_->world();
  Angles angles{};
  for (std::size_t i = 0; i < kJoints; ++i) angles[i] = world.humanoid()->joints()[i].position_rad;
  EXPECT_NEAR(angles[15], pose.angles[15], 0.01) << "it has taken the pose";
  EXPECT_GT(angles[kHeadYaw], 0.1) << "it looks to the left";
  const Skeleton skeleton = SkeletonOf(angles);
  const double scale = world.scene().body.stand_height_m / kTrunkM;
  const auto expect_at = [&](const std::string& link, const Vector3d& at_m) {
    EXPECT_TRUE(Find(link, "base_link").translation().isApprox(at_m * scale, 1e-5))
        << link << " is at " << Find(link, "base_link").translation().transpose() << ", not at "
        << (at_m * scale).transpose();
  };
  expect_at("hand_l", skeleton.arms[0].hand_m);
  expect_at("hand_r", skeleton.arms[1].hand_m);
  expect_at("ankle_roll_l", skeleton.legs[0].ankle_m);
  expect_at("ankle_roll_r", skeleton.legs[1].ankle_m);
  expect_at("head_yaw", skeleton.head.translation());
  EXPECT_TRUE(Find("ankle_roll_l", "base_link").linear().isApprox(skeleton.legs[0].foot, 1e-5));
  EXPECT_TRUE(Find("hand_r", "base_link").linear().isApprox(skeleton.arms[1].hand, 1e-5));
  EXPECT_TRUE(Find("camera_front", "odom")
                  .isApprox(CameraInPlace(world.scene().cameras.cameras[0], world.body().odometry(),
                                          world.body().attitude(), world.humanoid()->gaze()),
                            1e-5));
}

// A world publishes them once to whatever subscribes later, and computes no transform for nothing.
TEST_F(WorldFramesTest, ComeToALateSubscriberOnceAndAreNotPublishedWithoutOne) {
  Open(RobotYard());
  kept_.clear();
  network_.RunFor(seconds(1));
  const int before = samples_;
  network_.RunFor(seconds(1));
  EXPECT_EQ(samples_, before);
  EXPECT_THAT(Description("jetbot_1/robot_description"), HasSubstr("jetbot_1/base_link"));
}

}  // namespace musher::world::world_frames_test
