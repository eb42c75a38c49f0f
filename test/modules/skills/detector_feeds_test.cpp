// A robot whose config names detectors of the vision module.

#include "musher/messages/musher_msgs/sighting.hpp"
#include "musher/test/modules/skills/robot_on_network.hpp"

namespace musher::skills::detector_feeds_test {

using ::testing::SizeIs;

class ARosRobotWithDetectors : public ARosRobot {
 protected:
  ARosRobotWithDetectors() : ARosRobot(WithDetectors()) {
    qr_ = Must(transport::MakePublisher<msg::Sighting>(peers_->node, "dog/qr/sighting"));
    arrow_ = Must(transport::MakePublisher<msg::Sighting>(peers_->node, "dog/arrow/sighting"));
    Run(500);
  }
  static SkillsConfig WithDetectors() {
    SkillsConfig config = ConfigOfR();
    config.detectors = {{"qr", "qr/sighting", 0.4, M_PI / 2, {}},
                        {"arrow", "arrow/sighting", 0.4, M_PI / 2, {}}};
    return config;
  }

  std::unique_ptr<transport::Publisher<msg::Sighting>> qr_;
  std::unique_ptr<transport::Publisher<msg::Sighting>> arrow_;
};

TEST_F(ARosRobotWithDetectors, DetectsWhatTheyHaveSeenOnceAllHaveLooked) {
  msg::Sighting sighting;
  sighting.seen = true;
  sighting.text = "A-1";
  sighting.x = 0.4F;
  sighting.width = 0.2F;
  sighting.distance_m = 2;
  EXPECT_FALSE(robot_.Detect());
  Run(500);
  Stand(1, 0);
  EXPECT_TRUE(qr_->Publish(sighting));
  Run(20);
  EXPECT_FALSE(robot_.Detect());
  EXPECT_TRUE(arrow_->Publish({}));
  Run(20);
  const auto seen = robot_.Detect();
  ASSERT_TRUE(seen);
  ASSERT_THAT(*seen, SizeIs(1));
  EXPECT_EQ(seen->front().name, "A-1");
  EXPECT_NEAR(seen->front().pose.at.x_m, 3, 1e-6);
  Run(1100);
  EXPECT_FALSE(robot_.Detect());
}

TEST_F(ARosRobotWithDetectors, TakesAPictureThatIsPublishedAgainForNone) {
  EXPECT_FALSE(robot_.Detect());
  Run(500);
  msg::Sighting sighting;
  sighting.header.stamp.sec = 7;
  for (int i = 0; i < 15; ++i) {
    Stand(1, 0);
    EXPECT_TRUE(qr_->Publish(sighting));
    EXPECT_TRUE(arrow_->Publish({}));
    Run(80);
    if (i == 0) {
      EXPECT_TRUE(robot_.Detect());
    }
  }
  EXPECT_FALSE(robot_.Detect()) << "the camera stands";
}

TEST_F(ARosRobotWithDetectors, AsksThemToLookOnlyWhileASkillDetects) {
  EXPECT_EQ(qr_->MatchedReaders(), 0U);
  EXPECT_FALSE(robot_.Detect());
  Run(500);
  EXPECT_EQ(qr_->MatchedReaders(), 1U);
  EXPECT_EQ(arrow_->MatchedReaders(), 1U);
  Run(6000);
  EXPECT_EQ(qr_->MatchedReaders(), 0U);
}

}  // namespace musher::skills::detector_feeds_test
