// The published topics for the received pictures.

#include "musher/modules/vision/face_topics.hpp"

#include "musher/messages/stamp.hpp"
#include "musher/test/modules/vision/topics_on_network.hpp"

namespace musher::vision::face_topics_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

TEST_F(FaceTopicsTest, PublishTheTargetAndItsDistance) {
  worker_.found = std::vector{FaceAt(0.3, 0.4, HeightAt(1, 0.18))};
  Start();
  Shoot();
  EXPECT_THAT(targets_, IsEmpty()) << "one picture is not enough";
  Shoot();
  ASSERT_EQ(targets_.size(), 1U);
  EXPECT_NEAR(targets_[0].point.x, 0.3, 1e-9);
  EXPECT_NEAR(targets_[0].point.y, 0.4, 1e-9);
  EXPECT_NEAR(targets_[0].point.z, 1.03, 0.01) << "it is aside";
  EXPECT_EQ(targets_[0].header.frame_id, "camera");
  EXPECT_EQ(targets_[0].header.stamp, msg::ToStamp(Duration(worker_.looks.back())));
  EXPECT_EQ(closes_.back(), msg::Bool{false});
  EXPECT_THAT(counts_, ElementsAre(0, 1));
}

TEST_F(FaceTopicsTest, PublishThatAPersonIsTooClose) {
  worker_.found = std::vector{FaceAt(0.5, 0.5, HeightAt(0.4, 0.18))};
  Start();
  Shoot(2);
  EXPECT_EQ(closes_.back().data, true);
}

// Subscribers treat old ones as unknown.
TEST_F(FaceTopicsTest, DoNotPublishTooCloseWhilePicturesAreMissing) {
  worker_.found = std::vector{FaceAt(0.5, 0.5, HeightAt(2, 0.18))};
  Start();
  Shoot(3);
  Forget();
  Run(Milliseconds(7000));
  EXPECT_THAT(closes_, IsEmpty());
  EXPECT_THAT(targets_, IsEmpty());
  EXPECT_THAT(counts_, ElementsAre(0, 0, 0)) << "each 2 s";
  EXPECT_THAT(log_, ElementsAre("5907 no picture for 2000 ms: no usable picture on "
                                "robot1/image_rgb"));
  worker_.found = std::vector<FaceBox>();
  Shoot();
  EXPECT_THAT(log_, ElementsAre(HasSubstr("5907"), "0 receiving pictures again"));
  EXPECT_EQ(closes_.back().data, false);
}

TEST_F(FaceTopicsTest, RepeatTooCloseWhilePicturesAreMissing) {
  worker_.found = std::vector{FaceAt(0.5, 0.5, HeightAt(0.4, 0.18))};
  Start();
  Shoot(3);
  Forget();
  Run(Milliseconds(7000));
  EXPECT_THAT(closes_, ElementsAre(msg::Bool{true}, msg::Bool{true}, msg::Bool{true}))
      << "each 2 s: no person was seen to leave";
  worker_.found = std::vector<FaceBox>();
  Shoot();
  EXPECT_EQ(closes_.back().data, true) << "nor by the first picture";
  worker_.found = std::vector{FaceAt(0.85, 0.4, HeightAt(1.5, 0.18))};
  Shoot(8);
  EXPECT_EQ(closes_.back().data, true) << "this is another one, behind";
  for (const double distance_m : {0.7, 1.2}) {
    worker_.found = std::vector{FaceAt(0.5, 0.5, HeightAt(distance_m, 0.18))};
    Shoot(8);
  }
  EXPECT_EQ(closes_.back().data, false);
}

TEST_F(FaceTopicsTest, DoNotPublishTooCloseAfterAStartUntilTheHoldTimeHasPassed) {
  Start();
  Shoot(99);
  EXPECT_THAT(closes_, IsEmpty()) << "a face that fills the picture is not seen";
  EXPECT_EQ(counts_.size(), 99U);
  Shoot(4);
  EXPECT_FALSE(closes_.empty());
  EXPECT_THAT(closes_, ::testing::Each(msg::Bool{false}));
}

TEST_F(FaceTopicsTest, PublishThatNoPersonIsTooCloseAsSoonAsTheySeeOneFartherAway) {
  worker_.found = std::vector{FaceAt(0.5, 0.5, HeightAt(2, 0.18))};
  Start();
  Shoot(2);
  EXPECT_THAT(closes_, ElementsAre(msg::Bool{false}));
}

TEST_F(FaceTopicsTest, LogThatPicturesHaveNoPublisher) {
  pictures_.reset();
  Start();
  Run(Milliseconds(3000));
  EXPECT_THAT(log_, ElementsAre("5907 no picture for 2000 ms: no publisher of robot1/image_rgb"));
}

TEST_F(FaceTopicsTest, SubscribeToNoPictureWhileTheyAreOff) {
  Start(false);
  EXPECT_EQ(pictures_->MatchedReaders(), 0);
  EXPECT_TRUE(topics_->SetOn(true));
  Run(Milliseconds(100));
  EXPECT_EQ(pictures_->MatchedReaders(), 1);
  Shoot(2);
  EXPECT_EQ(worker_.looks.size(), 2U);
  Forget();
  EXPECT_TRUE(topics_->SetOn(false));
  Run(Milliseconds(5000));
  EXPECT_EQ(pictures_->MatchedReaders(), 0);
  EXPECT_THAT(counts_, ElementsAre(0)) << "once";
  EXPECT_THAT(closes_, IsEmpty());
  EXPECT_THAT(log_, IsEmpty()) << "silence is wanted";
}

TEST_F(FaceTopicsTest, RememberAfterAPauseThatAPersonWasTooClose) {
  worker_.found = std::vector{FaceAt(0.5, 0.5, HeightAt(0.4, 0.18))};
  Start();
  Shoot(2);
  EXPECT_TRUE(topics_->SetOn(false));
  Run(Milliseconds(20000));
  Forget();
  EXPECT_TRUE(topics_->SetOn(true));
  Run(Milliseconds(100));
  worker_.found = std::vector<FaceBox>();
  Shoot();
  EXPECT_THAT(closes_, ElementsAre(msg::Bool{true}));
}

TEST_F(FaceTopicsTest, DropAResultThatComesAfterTheyWereSwitchedOff) {
  worker_.hangs = true;
  Start();
  Shoot();
  EXPECT_TRUE(topics_->SetOn(false));
  Run(Milliseconds(100));
  Forget();
  topics_->OnResult({worker_.looks[0], 64, 48, std::vector{FaceAt(0.5, 0.5)}, {}});
  Run(Milliseconds(100));
  EXPECT_THAT(counts_, IsEmpty());
}

TEST_F(FaceTopicsTest, RefuseAnInvalidPictureAndLogItOnce) {
  Start();
  msg::Image broken = Picture();
  broken.data.pop_back();
  Shoot(3, broken);
  EXPECT_THAT(worker_.looks, IsEmpty());
  EXPECT_THAT(log_, ElementsAre("5910 9215 bytes of a picture of 64 x 48 with 192 in a row"));
  Shoot(1);
  EXPECT_THAT(log_, ElementsAre(HasSubstr("5910"), "0 pictures are ok again"));
}

TEST_F(FaceTopicsTest, SeeAFaceInRarePicturesAndLogOnceThatTheyAreRare) {
  worker_.found = std::vector{FaceAt(0.5, 0.5, HeightAt(0.4, 0.18))};
  Start();
  for (int i = 0; i < 20; ++i) {
    Shoot();
    Run(Milliseconds(500));
  }
  EXPECT_EQ(targets_.size(), 19U);
  EXPECT_EQ(closes_.back().data, true);
  EXPECT_THAT(log_, ElementsAre(HasSubstr("pictures are processed 600 ms apart, more than")));
  Shoot(2);
  EXPECT_THAT(log_.back(), HasSubstr("often enough again"));
}

TEST_F(FaceTopicsTest, DoNotFillTheLogWhenGoodAndBadPicturesAlternate) {
  Start();
  msg::Image strange = Picture();
  strange.encoding = "bayer_rggb8";
  for (int i = 0; i < 100; ++i) {
    Shoot(1);
    Shoot(1, strange);
  }
  EXPECT_THAT(log_, ElementsAre(HasSubstr("bayer_rggb8"), "0 pictures are ok again"));
  Run(Milliseconds(60'000));
  Shoot(1, strange);
  EXPECT_THAT(log_.back(), HasSubstr("bayer_rggb8")) << "after a minute it is news again";
}

// The world at twice the speed: 2 s of it are one of the detector's.
TEST_F(FaceTopicsTest, LogThatTheDetectorHangsAlsoWhenTimePassesFaster) {
  Start();
  Shoot(2);
  worker_.hangs = true;
  worker_.busy = Milliseconds(1100);
  Shoot();
  Run(Milliseconds(2000));
  EXPECT_THAT(log_, ElementsAre(HasSubstr("the detector has been processing one for 1100 ms")));
}

TEST_F(FaceTopicsTest, StampAPictureWithoutAStampWithTheTimeOfReception) {
  Start();
  const std::int64_t now_ns = clock_->Now().time_since_epoch().count();
  EXPECT_TRUE(pictures_->Publish(Picture()));
  Run(Milliseconds(100));
  ASSERT_EQ(worker_.looks.size(), 1U);
  EXPECT_NEAR(double(worker_.looks[0] - now_ns), 0, double(10 * kMs));
}

TEST_F(FaceTopicsTest, StartAgainWhenTheWorldIsRestarted) {
  worker_.found = std::vector{FaceAt(0.5, 0.5, HeightAt(0.4, 0.18))};
  Start();
  Run(Milliseconds(60000));
  Shoot(2);
  EXPECT_EQ(closes_.back().data, true);
  Forget();
  worker_.found = std::vector<FaceBox>();
  msg::Image early = Picture();
  early.header.stamp = {3, 0};
  EXPECT_TRUE(pictures_->Publish(early));
  Run(Milliseconds(100));
  EXPECT_THAT(closes_, IsEmpty()) << "no person was seen to leave";
  EXPECT_THAT(log_, ElementsAre(HasSubstr("0 time jumped back: all tracks are dropped")));
  topics_->OnResult({60'000 * kMs, 64, 48, std::vector{FaceAt(0.5, 0.5)}, {}});
  Run(Milliseconds(100));
  EXPECT_EQ(counts_.size(), 1U) << "a result of the old time is none any more";
}

TEST_F(FaceTopicsTest, DoNotFillTheLogWhenTwoCamerasWithTwoClocksSendOnOneTopic) {
  Start();
  Forget();
  for (int i = 0; i < 50; ++i) {
    msg::Image picture = Picture();
    picture.header.stamp = {i % 2 == 0 ? 10 : 1000, std::uint32_t(i) * 1'000'000};
    EXPECT_TRUE(pictures_->Publish(picture));
    Run(Milliseconds(10));
  }
  EXPECT_EQ(worker_.looks.size(), 50U);
  EXPECT_THAT(log_, ElementsAre(HasSubstr("two cameras on robot1/image_rgb")));
}

TEST_F(FaceTopicsTest, MeasureDistancesByTheConfiguredAngleWithoutCameraInfo) {
  infos_.reset();
  config_.hfov_rad = 2 * std::atan(320.0 / 600);
  worker_.found = std::vector{FaceAt(0.5, 0.5, HeightAt(0.4, 0.18))};
  Start();
  for (int i = 1; i <= 2; ++i) {
    msg::Image picture = Picture(640, 480);
    picture.header.stamp = {1, std::uint32_t(i) * 100'000'000U};
    EXPECT_TRUE(pictures_->Publish(picture));
    Run(Milliseconds(100));
  }
  ASSERT_EQ(targets_.size(), 1U);
  EXPECT_NEAR(targets_[0].point.z, 0.4, 0.001);
  EXPECT_EQ(closes_.back().data, true);
}

}  // namespace musher::vision::face_topics_test
