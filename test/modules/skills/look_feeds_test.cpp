// What the detectors of a robot show of a target, on its body.

#include "musher/messages/musher_msgs/sighting.hpp"
#include "musher/messages/stamp.hpp"
#include "musher/messages/tf2_msgs/tf_message.hpp"
#include "musher/test/modules/skills/robot_on_network.hpp"

namespace musher::skills::look_feeds_test {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

class ARosRobotThatLooks : public ARosRobot {
 protected:
  ARosRobotThatLooks() : ARosRobot(Config()) {
    detections_ =
        peers_->endpoints.Advertise<msg::ObjectStates>("r/detections", transport::kSensorDataQos);
    qr_ = Must(transport::MakePublisher<msg::Sighting>(peers_->node, "dog/qr/sighting"));
    Run(500);
    Stand(0, 0);
    EXPECT_FALSE(robot_.LookFor("dock"));
    Run(500);
    Stand(0, 0);
  }
  static SkillsConfig Config() {
    SkillsConfig config = ConfigOfR();
    config.detectors = {{"qr", "qr/sighting", 0.4, M_PI / 2, {{0.2, 0, 0}, 0}}};
    return config;
  }
  // At (x, 0) on the body; `stamp`: of the clock of the detector, 0: none.
  void Show(const std::vector<double>& xs, Duration stamp, const std::string& frame = "base_link") {
    msg::ObjectStates found;
    found.header = {msg::ToStamp(stamp), frame};
    for (const double x_m : xs) {
      msg::ObjectState dock;
      dock.name = "dock";
      dock.category = "station";
      dock.pose.position.x = x_m;
      dock.pose.orientation.w = 1;
      found.objects.push_back(dock);
    }
    EXPECT_TRUE(detections_->Publish(found));
    Run(20);
  }
  std::optional<skills::Look> Dock() { return robot_.LookFor("dock"); }

  transport::Publisher<msg::ObjectStates>* detections_ = nullptr;
  std::unique_ptr<transport::Publisher<msg::Sighting>> qr_;
};

TEST_F(ARosRobotThatLooks, KnowsWhereATargetIsOnItsBodyForOneSecond) {
  Stand(5, 1);  // where it is in the map does not matter
  Show({2}, {});
  ASSERT_TRUE(Dock());
  ASSERT_THAT(Dock()->seen, SizeIs(1));
  EXPECT_EQ(Dock()->seen[0].x_m, 2);
  EXPECT_LE(Now() - Dock()->at, Milliseconds(30));
  EXPECT_THAT(robot_.LookFor("station")->seen, SizeIs(1)) << "by its category, too";
  EXPECT_THAT(robot_.LookFor("cup")->seen, IsEmpty()) << "it has looked";
  Show({2, 3}, {});
  EXPECT_THAT(Dock()->seen, SizeIs(2));
  Show({}, {});
  EXPECT_THAT(Dock()->seen, IsEmpty());
  Run(1100);
  EXPECT_FALSE(Dock());
  EXPECT_EQ(robot_.WhyNoLook(), "no detections on r/detections");
}

TEST_F(ARosRobotThatLooks, CountsNoPictureTwiceAndKnowsHowLateOneCame) {
  const Duration base = std::chrono::hours(20);  // of another clock
  Show({2}, base);
  const Time first = Dock()->at;
  Run(300);
  Show({2}, base);
  EXPECT_EQ(Dock()->at, first) << "the picture is repeated";
  Show({2}, base - Milliseconds(100));
  EXPECT_EQ(Dock()->at, first) << "it is older than the last one";
  Run(300);
  Show({2.5}, base + Milliseconds(240));  // taken 240 ms after the first one, and held up
  EXPECT_NEAR(ToSeconds(Dock()->at - first), 0.24, 0.01);
}

TEST_F(ARosRobotThatLooks, PlacesAFrameByItsTransformAndRefusesOneWithout) {
  Show({2}, {}, "camera");
  EXPECT_FALSE(Dock());
  EXPECT_THAT(robot_.WhyNoLook(), HasSubstr("no detections with a place on the body"));
  Show({2}, {}, "map");
  EXPECT_FALSE(Dock()) << "no belief of a map";
  auto* const frames =
      peers_->endpoints.Advertise<msg::TfMessage>("/tf_static", transport::kLatchedQos);
  Run(300);
  msg::TransformStamped mount;
  mount.header.frame_id = "base_link";
  mount.child_frame_id = "camera";
  mount.transform.translation.x = 0.3;
  mount.transform.rotation.w = 1;
  EXPECT_TRUE(frames->Publish({{mount}}));
  Run(300);
  Stand(0, 0);
  Show({2}, {}, "camera");
  ASSERT_TRUE(Dock());
  EXPECT_NEAR(Dock()->seen[0].x_m, 2.3, 1e-9);
}

TEST_F(ARosRobotThatLooks, SeesWhatADetectorOfTheVisionModuleHasFound) {
  msg::Sighting sighting;
  sighting.seen = true;
  sighting.text = "A-1";
  sighting.x = 0.4F;
  sighting.width = 0.2F;
  sighting.distance_m = 1;
  EXPECT_TRUE(qr_->Publish(sighting));
  Show({2}, {});
  ASSERT_THAT(robot_.LookFor("A-1")->seen, SizeIs(1));
  EXPECT_NEAR(robot_.LookFor("A-1")->seen[0].x_m, 1.2, 1e-6);
  EXPECT_THAT(robot_.LookFor("qr")->seen, SizeIs(1));
  EXPECT_THAT(Dock()->seen, SizeIs(1));
}

TEST_F(ARosRobotThatLooks, AsksItsDetectorsOnlyWhileASkillLooks) {
  EXPECT_EQ(detections_->MatchedReaders(), 1U);
  EXPECT_EQ(qr_->MatchedReaders(), 1U);
  Run(6000);
  EXPECT_EQ(detections_->MatchedReaders(), 0U);
  EXPECT_EQ(qr_->MatchedReaders(), 0U);
}

}  // namespace musher::skills::look_feeds_test
