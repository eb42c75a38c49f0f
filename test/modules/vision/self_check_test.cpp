// The results of a self-check, which publishes nothing.

#include "musher/modules/vision/face_topics.hpp"

#include "musher/test/modules/vision/topics_on_network.hpp"

namespace musher::vision::self_check_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

TEST_F(FaceTopicsTest, CheckThemselves) {
  pictures_.reset();
  Start(false);
  EXPECT_TRUE(topics_->SetChecked(true));
  Run(Milliseconds(100));
  EXPECT_EQ(Failing(), "no publisher of robot1/image_rgb");
  pictures_ = test::Must(
      transport::MakePublisher<msg::Image>(*desk_, "robot1/image_rgb", transport::kSensorDataQos));
  Run(Milliseconds(100));
  EXPECT_EQ(Failing(), "no picture came on robot1/image_rgb");
  EXPECT_TRUE(pictures_->Publish(Picture()));
  Run(Milliseconds(100));
  EXPECT_EQ(Failing(),
            "no CameraInfo came on robot1/image_rgb/camera_info, and the config has no hfov_deg: "
            "distances are not known");
  info_.k[0] = 0;
  Shoot();
  EXPECT_EQ(Failing(), "CameraInfo: it has no focal length");
  info_ = FrontInfo();
  Shoot();
  EXPECT_EQ(Failing(), "");
  EXPECT_TRUE(topics_->SetChecked(false));
  EXPECT_FALSE(topics_->looks());
}

// A self-check of more than two pictures published a face to the show.
TEST_F(FaceTopicsTest, PublishNothingDuringACheck) {
  worker_.found = std::vector{FaceAt(0.3, 0.4, HeightAt(0.3, 0.18))};
  Start(false);
  EXPECT_TRUE(topics_->SetChecked(true));
  Shoot(5);
  EXPECT_EQ(Failing(), "");
  EXPECT_THAT(targets_, IsEmpty());
  EXPECT_THAT(closes_, IsEmpty());
  EXPECT_THAT(counts_, IsEmpty());
  EXPECT_TRUE(topics_->SetOn(true));
  EXPECT_TRUE(topics_->SetChecked(false));
  Shoot();
  EXPECT_EQ(targets_.size(), 1U);
}

TEST_F(FaceTopicsTest, FailTheirCheckWithADetectorThatHangsOrFails) {
  worker_.found = Error{5912, "the detector failed: out of luck"};
  Start();
  Shoot(2);
  EXPECT_EQ(Failing(), "the detector failed: out of luck");
  EXPECT_THAT(log_, ElementsAre("5912 the detector failed: out of luck"));
  EXPECT_THAT(counts_, IsEmpty());
  worker_.found = std::vector<FaceBox>();
  Shoot();
  EXPECT_EQ(Failing(), "");
  worker_.busy = Milliseconds(5001);
  EXPECT_EQ(Failing(), "the detector hangs: it has been processing one picture for 5001 ms");
  worker_.hangs = true;
  Shoot();
  Run(Milliseconds(3000));
  EXPECT_THAT(log_.back(), HasSubstr("the detector has been processing one for 5001 ms"));
}

}  // namespace musher::vision::self_check_test
