// The published topics of a detector of a course for the received pictures.

#include "musher/modules/vision/course/course_topics.hpp"

#include "musher/test/modules/vision/course_on_network.hpp"

namespace musher::vision::course_topics_test {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

TEST_F(CourseTopicsTest, SubscribeToPicturesOnlyWhileAnOutputHasASubscriber) {
  Start();
  EXPECT_EQ(pictures_->MatchedReaders(), 0);
  auto text = Listen("qr_detector/qr_info", texts_);
  EXPECT_EQ(pictures_->MatchedReaders(), 1);
  Shoot(2);
  EXPECT_THAT(texts_, ElementsAre(msg::String{"A-1"}, msg::String{"A-1"}));
  text.reset();
  Run(Milliseconds(500));
  EXPECT_EQ(pictures_->MatchedReaders(), 0);
  const auto sighting = Listen("qr_detector/sighting", sightings_);
  EXPECT_EQ(pictures_->MatchedReaders(), 1);
  Shoot();
  ASSERT_THAT(sightings_, SizeIs(1));
  EXPECT_EQ(sightings_[0].text, "A-1");
}

TEST_F(CourseTopicsTest, SubscribeToNoPictureWhileTheyAreOff) {
  Start(false);
  const auto text = Listen("qr_detector/qr_info", texts_);
  EXPECT_EQ(pictures_->MatchedReaders(), 0);
  EXPECT_TRUE(topics_->SetOn(true));
  Run(Milliseconds(100));
  EXPECT_EQ(pictures_->MatchedReaders(), 1);
  EXPECT_TRUE(topics_->SetOn(false));
  Run(Milliseconds(5000));
  EXPECT_EQ(pictures_->MatchedReaders(), 0);
  EXPECT_THAT(log_, IsEmpty()) << "silence is wanted";
}

TEST_F(CourseTopicsTest, DrawOnlyWhileTheDebugImageHasASubscriber) {
  Start();
  const auto text = Listen("qr_detector/qr_info", texts_);
  Shoot();
  EXPECT_FALSE(worker_.shots.back().draws);
  auto drawing = Listen("qr_detector/debug_image", drawings_, transport::kSensorDataQos);
  Shoot(2);
  EXPECT_TRUE(worker_.shots.back().draws);
  EXPECT_THAT(drawings_, SizeIs(2));
  drawing.reset();
  Run(Milliseconds(500));
  Shoot();
  EXPECT_FALSE(worker_.shots.back().draws);
}

TEST_F(CourseTopicsTest, LookForADebugImageAlone) {
  Start();
  const auto drawing = Listen("qr_detector/debug_image", drawings_, transport::kSensorDataQos);
  Shoot();
  EXPECT_THAT(drawings_, SizeIs(1));
}

TEST_F(CourseTopicsTest, OfLinesPublishNoText) {
  entry_.kind = CourseKind::kLines;
  entry_.publish = "/yellow_line_detector/left";
  worker_.found.sight = {std::nullopt, msg::YellowLines(), std::nullopt};
  worker_.found.sight.lines->contours = 2;
  Start();
  const auto lines = Listen("yellow_line_detector/left", lines_);
  Shoot();
  ASSERT_THAT(lines_, SizeIs(1));
  EXPECT_EQ(lines_[0].contours, 2U);
  const auto drawing =
      Listen("yellow_line_detector/left/debug_image", drawings_, transport::kSensorDataQos);
  Shoot();
  EXPECT_THAT(drawings_, SizeIs(1));
}

TEST_F(CourseTopicsTest, PublishNoTextWhileTheDetectorIsSilent) {
  worker_.found.sight.text = std::nullopt;
  Start();
  const auto text = Listen("qr_detector/qr_info", texts_);
  const auto sighting = Listen("qr_detector/sighting", sightings_);
  Shoot();
  EXPECT_THAT(texts_, IsEmpty());
  EXPECT_THAT(sightings_, SizeIs(1));
}

// A race that waited for a sighting knew no reason.
TEST_F(CourseTopicsTest, SayWhyAPictureHasNoSighting) {
  worker_.found.sight = {};
  worker_.found.sight.doubt = "a near round thing may shine";
  Start();
  std::vector<msg::String> doubts;
  const auto doubt = Listen("qr_detector/doubt", doubts);
  const auto sighting = Listen("qr_detector/sighting", sightings_);
  Shoot(2);
  ASSERT_THAT(doubts, SizeIs(2));
  EXPECT_EQ(doubts[0].data, "a near round thing may shine");
  EXPECT_THAT(sightings_, IsEmpty());
}

// What was seen a minute ago, in another place, is nothing that is tracked.
TEST_F(CourseTopicsTest, StartTheDetectorAgainAfterEachPauseAndJump) {
  Start();
  auto text = Listen("qr_detector/qr_info", texts_);
  Shoot(2);
  const std::uint32_t first = worker_.shots[0].run;
  EXPECT_EQ(worker_.shots[1].run, first);
  text.reset();
  Run(Milliseconds(500));
  text = Listen("qr_detector/qr_info", texts_);
  Shoot();
  EXPECT_EQ(worker_.shots[2].run, first + 1);
  Run(Milliseconds(60'000));
  Shoot();
  EXPECT_EQ(worker_.shots[3].run, first + 1);
  msg::Image early = Picture();
  early.header.stamp = {3, 0};
  EXPECT_TRUE(pictures_->Publish(early));
  Run(Milliseconds(100));
  EXPECT_EQ(worker_.shots[4].run, first + 2);
}

TEST_F(CourseTopicsTest, DropAResultFromBeforeAPause) {
  Start();
  auto text = Listen("qr_detector/qr_info", texts_);
  worker_.hangs = true;
  Shoot();
  text.reset();
  Run(Milliseconds(500));
  text = Listen("qr_detector/qr_info", texts_);
  worker_.Finish(worker_.shots[0]);
  Run(Milliseconds(100));
  EXPECT_THAT(texts_, IsEmpty());
}

// It passed for one of the pictures since then.
TEST_F(CourseTopicsTest, CheckThemselvesWithoutAResultFromBeforeAPause) {
  Start();
  auto text = Listen("qr_detector/qr_info", texts_);
  worker_.hangs = true;
  Shoot();
  text.reset();
  Run(Milliseconds(500));
  text = Listen("qr_detector/qr_info", texts_);
  worker_.Finish(worker_.shots[0]);
  EXPECT_EQ(Failing(), "no picture came on robot1/image_rgb");
  worker_.fault = Error{5912, "the detector failed: out of luck"};
  worker_.Finish(worker_.shots[0]);
  EXPECT_EQ(Failing(), "no picture came on robot1/image_rgb");
  worker_.fault.reset();
  worker_.hangs = false;
  Shoot();
  EXPECT_EQ(Failing(), "");
}

TEST_F(CourseTopicsTest, RefuseInvalidPicturesAndLogItOnce) {
  Start();
  const auto text = Listen("qr_detector/qr_info", texts_);
  msg::Image deep = Picture();
  deep.encoding = "mono16";
  msg::Image cut = Picture();
  cut.data.pop_back();
  msg::Image narrow = Picture();
  narrow.step = 10;
  for (const msg::Image& picture : {deep, cut, narrow, msg::Image()}) Shoot(2, picture);
  EXPECT_THAT(worker_.shots, IsEmpty());
  EXPECT_THAT(log_, ElementsAre("5910 pictures are rgb8, bgr8, rgba8, bgra8 or mono8, this one is "
                                "'mono16'"));
  Shoot();
  EXPECT_THAT(log_.back(), "0 pictures are ok again");
  EXPECT_THAT(texts_, SizeIs(1));
}

// A driver that repeats its last buffer: each with a stamp of its own.
TEST_F(CourseTopicsTest, PassOnNoPictureOfACameraThatStandsStill) {
  entry_.still = Milliseconds(300);
  Start();
  const auto text = Listen("qr_detector/qr_info", texts_);
  Shoot(20);
  EXPECT_THAT(texts_, SizeIs(3));
  EXPECT_THAT(log_, ElementsAre("5907 the picture stands still: only old ones for 300 ms on "
                                "robot1/image_rgb"));
  EXPECT_THAT(Failing(), HasSubstr("the picture stands still"));
  Run(Milliseconds(2000));
  EXPECT_THAT(log_.back(),
              "5907 no picture for 2000 ms: the picture stands still on "
              "robot1/image_rgb");
  msg::Image other = Picture();
  other.data[0] ^= 1;
  Shoot(1, other);
  EXPECT_THAT(log_, Contains("0 the picture changes again"));
  EXPECT_THAT(texts_, SizeIs(4));
  EXPECT_EQ(Failing(), "");
}

// A ring of two buffers passed as a camera that works.
TEST_F(CourseTopicsTest, PassOnNoPictureOfACameraThatRepeatsARingOfBuffers) {
  entry_.still = Milliseconds(300);
  Start();
  const auto text = Listen("qr_detector/qr_info", texts_);
  msg::Image other = Picture();
  other.data[0] ^= 1;
  for (int i = 0; i < 20; ++i) Shoot(1, i % 2 == 0 ? Picture() : other);
  EXPECT_THAT(texts_, SizeIs(::testing::Le(5)));
  EXPECT_THAT(Failing(), HasSubstr("the picture stands still"));
}

TEST_F(CourseTopicsTest, CheckThemselvesByPicturesThatChange) {
  entry_.still = Milliseconds(300);
  Start(false);
  EXPECT_TRUE(topics_->SetChecked(true));
  Run(Milliseconds(500));
  Shoot(20);
  EXPECT_TRUE(topics_->SetChecked(false));
  EXPECT_TRUE(topics_->SetChecked(true));
  Run(Milliseconds(500));
  Shoot();
  EXPECT_THAT(Failing(), HasSubstr("the picture stands still"));
}

// Two cameras, or two drivers of one, on one topic: their pictures are of two places.
TEST_F(CourseTopicsTest, PassOnNoPictureWhileTheTopicHasTwoPublishers) {
  Start();
  const auto text = Listen("qr_detector/qr_info", texts_);
  Shoot(2);
  auto first = std::move(pictures_);
  auto second = Publisher<msg::Image>("robot1/image_rgb", transport::kSensorDataQos);
  Run(Milliseconds(500));
  for (int i = 0; i < 6; ++i) {
    pictures_ = std::move(second);
    Shoot();
    second = std::move(pictures_);
    pictures_ = std::move(first);
    Shoot();
    first = std::move(pictures_);
  }
  EXPECT_THAT(texts_, SizeIs(3)) << "one of the second, which may have taken over";
  EXPECT_THAT(log_, ElementsAre("5910 several publishers of robot1/image_rgb"));
  EXPECT_EQ(Failing(), "several publishers of robot1/image_rgb");
  Run(Milliseconds(2000));
  EXPECT_THAT(log_.back(), HasSubstr("no picture for 2000 ms: several publishers of"));
  second.reset();
  pictures_ = std::move(first);
  Shoot();
  EXPECT_THAT(log_, Contains("0 one publisher of robot1/image_rgb again"));
  EXPECT_THAT(texts_, SizeIs(4));
  EXPECT_EQ(Failing(), "");
}

TEST_F(CourseTopicsTest, TakeAnotherPublisherThatTakesOver) {
  Start();
  const auto text = Listen("qr_detector/qr_info", texts_);
  Shoot(2);
  pictures_ = Publisher<msg::Image>("robot1/image_rgb", transport::kSensorDataQos);
  Run(Milliseconds(500));
  Shoot(2);
  EXPECT_THAT(texts_, SizeIs(4));
  EXPECT_THAT(log_, IsEmpty());
}

TEST_F(CourseTopicsTest, CheckThemselvesByThePicturesOfOnePublisher) {
  Start(false);
  EXPECT_TRUE(topics_->SetChecked(true));
  const auto second = Publisher<msg::Image>("robot1/image_rgb", transport::kSensorDataQos);
  Run(Milliseconds(500));
  Shoot();
  EXPECT_EQ(Failing(), "several publishers of robot1/image_rgb");
  Shoot(20);
  EXPECT_EQ(Failing(), "") << "the other one sends nothing";
}

TEST_F(CourseTopicsTest, KnowTheLensOfCameraInfoOrOfTheConfig) {
  entry_.hfov_rad = 1.0;
  Start();
  const auto text = Listen("qr_detector/qr_info", texts_);
  Shoot();
  ASSERT_TRUE(worker_.shots.back().lens);
  EXPECT_NEAR(worker_.shots.back().lens->focal_x, 0.5 / std::tan(0.5), 1e-9);
  EXPECT_TRUE(infos_->Publish(FrontInfo()));
  Run(Milliseconds(100));
  Shoot();
  EXPECT_EQ(worker_.shots.back().lens, FrontLens());
}

TEST_F(CourseTopicsTest, LogMissingPicturesOnceWhileAnOutputHasASubscriber) {
  Start();
  Run(Milliseconds(5000));
  EXPECT_THAT(log_, IsEmpty());
  const auto text = Listen("qr_detector/qr_info", texts_);
  Run(Milliseconds(7000));
  EXPECT_THAT(log_, ElementsAre("5907 no picture for 2000 ms: no usable picture on "
                                "robot1/image_rgb"));
  Shoot();
  EXPECT_THAT(log_.back(), "0 receiving pictures again");
}

TEST_F(CourseTopicsTest, LogADetectorThatFailsAndThatHangs) {
  Start();
  const auto text = Listen("qr_detector/qr_info", texts_);
  worker_.fault = Error{5912, "the detector failed: out of luck"};
  Shoot(3);
  EXPECT_THAT(log_, ElementsAre("5912 the detector failed: out of luck"));
  EXPECT_EQ(Failing(), "the detector failed: out of luck");
  worker_.fault.reset();
  Shoot();
  EXPECT_THAT(log_.back(), "0 the detector is ok again");
  worker_.hangs = true;
  worker_.busy = Milliseconds(6000);
  Shoot();
  Run(Milliseconds(3000));
  EXPECT_THAT(log_.back(), HasSubstr("the detector has been processing one for 6000 ms"));
  EXPECT_EQ(Failing(), "the detector hangs: it has been processing one picture for 6000 ms");
}

TEST_F(CourseTopicsTest, CheckThemselvesWithoutASubscriber) {
  pictures_.reset();
  Start(false);
  EXPECT_TRUE(topics_->SetChecked(true));
  Run(Milliseconds(100));
  EXPECT_EQ(Failing(), "no publisher of robot1/image_rgb");
  pictures_ = test::Must(
      transport::MakePublisher<msg::Image>(*desk_, "robot1/image_rgb", transport::kSensorDataQos));
  Run(Milliseconds(100));
  EXPECT_EQ(Failing(), "no picture came on robot1/image_rgb");
  Shoot();
  EXPECT_EQ(Failing(), "") << "also without a CameraInfo";
  EXPECT_TRUE(topics_->SetChecked(false));
  EXPECT_FALSE(topics_->looks());
}

// What was wrong before a pause was given as the reason, where the camera is off by now.
TEST_F(CourseTopicsTest, CheckThemselvesWithoutTheFaultsFromBeforeAPause) {
  entry_.still = Milliseconds(300);
  Start(false);
  EXPECT_TRUE(topics_->SetChecked(true));
  Run(Milliseconds(500));
  worker_.fault = Error{5912, "the detector failed: out of luck"};
  Shoot(20);
  msg::Image deep = Picture();
  deep.encoding = "mono16";
  Shoot(1, deep);
  EXPECT_EQ(Failing(), "the detector failed: out of luck");
  EXPECT_TRUE(topics_->SetChecked(false));
  pictures_.reset();
  EXPECT_TRUE(topics_->SetChecked(true));
  Run(Milliseconds(500));
  EXPECT_EQ(Failing(), "no publisher of robot1/image_rgb");
}

// It was "no picture came", as of a camera that sends none.
TEST_F(CourseTopicsTest, SayOfAPictureThatIsNotProcessedYetThatItCame) {
  Start(false);
  EXPECT_TRUE(topics_->SetChecked(true));
  Run(Milliseconds(100));
  worker_.hangs = true;
  Shoot();
  EXPECT_EQ(
      Failing(),
      "no picture of robot1/image_rgb is processed yet: the detector is slow, or the computer "
      "busy");
  worker_.Finish(worker_.shots[0]);
  EXPECT_EQ(Failing(), "");
}

TEST_F(CourseTopicsTest, PublishNothingInACheck) {
  Start(false);
  const auto text = Listen("qr_detector/qr_info", texts_);
  EXPECT_TRUE(topics_->SetChecked(true));
  Shoot(3);
  EXPECT_EQ(Failing(), "");
  EXPECT_THAT(texts_, IsEmpty());
}

TEST_F(CourseTopicsTest, OfTwoDetectorsOnOneCameraAreIndependent) {
  Start();
  CourseEntry arrow;
  arrow.name = "green_arrow_detector";
  arrow.publish = "/green_arrow_detector/direction";
  FakeCourseWorker second;
  second.found.sight = {msg::Sighting(), std::nullopt, "left"};
  std::unique_ptr<CourseTopics> topics;
  second.on_result = [&](const DetectionResult<CourseProcessor>& result) {
    topics->OnResult(result);
  };
  topics = test::Must(CourseTopics::Make(
      {*robot_, *clock_, "robot1", [] { return std::int64_t{1}; }, [](const Error&) {}}, second,
      arrow, Milliseconds(2000)));
  EXPECT_TRUE(topics->SetOn(true));
  std::vector<msg::String> directions;
  const auto direction = Listen("green_arrow_detector/direction", directions);
  Shoot();
  EXPECT_THAT(directions, ElementsAre(msg::String{"left"}));
  EXPECT_THAT(worker_.shots, IsEmpty());
  const auto text = Listen("qr_detector/qr_info", texts_);
  worker_.hangs = true;
  Shoot();
  EXPECT_THAT(directions, SizeIs(2)) << "one that hangs does not delay the other";
  EXPECT_THAT(worker_.shots, SizeIs(1));
}

}  // namespace musher::vision::course_topics_test
