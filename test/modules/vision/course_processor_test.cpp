// The conversion of pictures, and a detector on its thread.

#include "musher/modules/vision/course/course_processor.hpp"

#include <gmock/gmock.h>

#include <atomic>
#include <future>
#include <stdexcept>

#include "musher/messages/stamp.hpp"
#include "musher/modules/vision/picture/detector_thread.hpp"
#include "musher/test/modules/vision/faces.hpp"
#include "musher/transport/linux_event_loop.hpp"

namespace musher::vision::course_processor_test {

using ::testing::ElementsAre;

// Reports the first pixel as text, and how many pictures it has got as the width.
class FakeCourseDetector : public CourseDetector {
 public:
  CourseSight Look(const cv::Mat& bgr, std::int64_t, const std::optional<Lens>&) override {
    if (throws) throw std::runtime_error("out of luck");
    if (std::promise<void>* waits = gate.exchange(nullptr)) waits->get_future().wait();
    const auto pixel = bgr.at<cv::Vec3b>(0, 0);
    CourseSight sight;
    sight.sighting.emplace();
    sight.sighting->width = static_cast<float>(++looks_);
    sight.text =
        std::to_string(pixel[0]) + " " + std::to_string(pixel[1]) + " " + std::to_string(pixel[2]);
    return sight;
  }
  void Draw(cv::Mat& bgr) const override { bgr.setTo(cv::Scalar(1, 2, 3)); }

  static inline std::atomic<bool> throws = false;
  // The next picture is processed when it has a value.
  static inline std::atomic<std::promise<void>*> gate = nullptr;

 private:
  int looks_ = 0;
};

class CourseProcessorTest : public ::testing::Test {
 protected:
  CourseProcessorTest() {
    FakeCourseDetector::throws = false;
    FakeCourseDetector::gate = nullptr;
  }
  static Result<std::unique_ptr<CourseDetector>> Made() {
    return std::unique_ptr<CourseDetector>(new FakeCourseDetector);
  }
  // One pixel of it.
  static CourseShot ShotOf(const std::string& encoding, std::vector<std::uint8_t> pixel) {
    CourseShot shot;
    shot.stamp_ns = 1'500'000'000;
    shot.picture.encoding = encoding;
    shot.picture.width = 1;
    shot.picture.height = 1;
    shot.picture.step = static_cast<std::uint32_t>(pixel.size());
    shot.picture.data = std::move(pixel);
    EXPECT_TRUE(CheckPicture(shot.picture));
    return shot;
  }

  std::unique_ptr<CourseProcessor> processor_ = CourseProcessor::Make(Made).value();
};

TEST_F(CourseProcessorTest, ConvertsEveryAcceptedPictureToBgr) {
  const auto bgr = [&](const std::string& encoding, std::vector<std::uint8_t> pixel) {
    return *processor_->Process(ShotOf(encoding, std::move(pixel))).sight.text;
  };
  EXPECT_EQ(bgr("bgr8", {1, 2, 3}), "1 2 3");
  EXPECT_EQ(bgr("rgb8", {1, 2, 3}), "3 2 1");
  EXPECT_EQ(bgr("rgba8", {1, 2, 3, 9}), "3 2 1");
  EXPECT_EQ(bgr("bgra8", {1, 2, 3, 9}), "1 2 3");
  EXPECT_EQ(bgr("mono8", {7}), "7 7 7");
  EXPECT_EQ(bgr("bgr8", {1, 2, 3, 0, 0, 0, 0}), "1 2 3") << "a row may be padded";
}

TEST_F(CourseProcessorTest, GivesThePicturesHeaderAndDrawsOnRequest) {
  CourseShot shot = ShotOf("mono8", {7});
  shot.picture.header.frame_id = "camera_rgb";
  CourseFound found = processor_->Process(shot);
  EXPECT_EQ(found.sight.sighting->header.stamp, msg::ToStamp(Milliseconds(1500)));
  EXPECT_EQ(found.sight.sighting->header.frame_id, "camera_rgb");
  EXPECT_FALSE(found.drawing);
  shot.draws = true;
  found = processor_->Process(shot);
  ASSERT_TRUE(found.drawing);
  EXPECT_EQ(found.drawing->encoding, "bgr8");
  EXPECT_EQ(found.drawing->header, found.sight.sighting->header);
  EXPECT_THAT(found.drawing->data, ElementsAre(1, 2, 3));
}

TEST_F(CourseProcessorTest, StartsTheDetectorAgainForEachRun) {
  CourseShot shot = ShotOf("mono8", {7});
  shot.run = 3;
  const auto looks = [&] { return processor_->Process(shot).sight.sighting->width; };
  EXPECT_EQ(looks(), 1);
  EXPECT_EQ(looks(), 2);
  shot.run = 4;
  EXPECT_EQ(looks(), 1);
}

// The rest of the thread is the same for every kind of detector: detector_thread_test.cpp.
class CourseThreadTest : public CourseProcessorTest {
 protected:
  void Start() {
    thread_.emplace(
        loop_, [] { return CourseProcessor::Make(Made); }, DetectorLimits{Milliseconds(700), 2},
        DetectorThreadEvents<CourseProcessor>{
            [this](DetectionResult<CourseProcessor> result) {
              results_.push_back(std::move(result));
            },
            [this] { ++left_out_; }, [](Duration) {},
            [this](const Error& error) { lost_.set_value(error.message); }});
  }
  bool AwaitResults(std::size_t count) {
    return loop_.RunUntil([&] { return results_.size() >= count; },
                          loop_.Now() + std::chrono::seconds(120));
  }

  transport::LinuxEventLoop loop_;
  std::vector<DetectionResult<CourseProcessor>> results_;
  int left_out_ = 0;
  std::promise<std::string> lost_;
  std::optional<DetectorThread<CourseProcessor>> thread_;
};

TEST_F(CourseThreadTest, ReplacesADetectorThatThrewAndGivesItUpAfterSeveral) {
  Start();
  auto lost = lost_.get_future();
  thread_->Submit(ShotOf("mono8", {7}));
  ASSERT_TRUE(AwaitResults(1));
  FakeCourseDetector::throws = true;
  thread_->Submit(ShotOf("mono8", {7}));
  ASSERT_TRUE(AwaitResults(2));
  FakeCourseDetector::throws = false;
  thread_->Submit(ShotOf("mono8", {7}));
  ASSERT_TRUE(AwaitResults(3));
  EXPECT_EQ(results_[1].found.error().message, "the detector failed: out of luck");
  EXPECT_EQ(results_[2].found.value().sight.sighting->width, 1) << "a new one";
  FakeCourseDetector::throws = true;
  for (const std::size_t count : {4, 5}) {
    thread_->Submit(ShotOf("mono8", {7}));
    ASSERT_TRUE(AwaitResults(count));
  }
  EXPECT_EQ(lost.get(), "2 pictures in a row: the detector failed: out of luck");
}

TEST_F(CourseThreadTest, ProcessesTheNewestPictureOnly) {
  std::promise<void> gate;
  FakeCourseDetector::gate = &gate;
  Start();
  thread_->Submit(ShotOf("mono8", {1}));
  while (FakeCourseDetector::gate != nullptr) std::this_thread::yield();
  for (int grey = 2; grey <= 4; ++grey) {
    thread_->Submit(ShotOf("mono8", {static_cast<std::uint8_t>(grey)}));
  }
  EXPECT_EQ(left_out_, 2);
  gate.set_value();
  ASSERT_TRUE(AwaitResults(2));
  EXPECT_EQ(results_[1].found.value().sight.text, "4 4 4");
}

}  // namespace musher::vision::course_processor_test
