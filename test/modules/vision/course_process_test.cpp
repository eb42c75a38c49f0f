// musher-vision-manager with detectors of a course: the real program over DDS, with a camera
// controlled by the test.

#include <unistd.h>

#include <opencv2/imgproc.hpp>
#include <string>

#include "musher/messages/musher_msgs/sighting.hpp"
#include "musher/messages/musher_msgs/yellow_lines.hpp"
#include "musher/messages/std_msgs/string.hpp"
#include "musher/modules/vision/course/course_processor.hpp"
#include "musher/test/modules/vision/vision_process.hpp"

namespace musher::vision::course_process_test {

using ::testing::HasSubstr;

constexpr const char* kFaultyFile = R"(
detect_faces = false
[[detectors]]
name = "board"
kind = "qr"
rate_hz = 0
hang_ms = 1000
)";

TEST_F(FaultyVision, SubscribesToPicturesOnlyWhileTheTextHasASubscriber) {
  StartWithCamera(kFaultyFile);
  EXPECT_TRUE(peer_.Until([&] { return camera_->MatchedReaders() == 0; }));
  std::optional<msg::String> text;
  Watch("qr_detector/qr_info", text);
  EXPECT_TRUE(peer_.Until([&] { return text.has_value(); })) << peer_.Output();
  EXPECT_EQ(text->data, "found");
  ExpectDone("Protected");
  EXPECT_TRUE(peer_.Until([&] { return camera_->MatchedReaders() == 0; }));
  ExpectDone("Active");
  EXPECT_TRUE(peer_.Until([&] { return camera_->MatchedReaders() == 1; }));
  subscriptions_.clear();
  EXPECT_TRUE(peer_.Until([&] { return camera_->MatchedReaders() == 0; }));
  ExpectTornDown();
}

TEST_F(FaultyVision, ExitsWithOneWhenADetectorOfACourseFailsRepeatedly) {
  StartWithCamera(kFaultyFile);
  std::optional<msg::String> text;
  Watch("qr_detector/qr_info", text);
  SetDetector("throw");
  ASSERT_TRUE(AwaitOutput("detector is lost"));
  EXPECT_EQ(peer_.AwaitExit(), 1);
  EXPECT_THAT(peer_.Output(),
              HasSubstr("vision: warning: the detector is lost: board: 5 pictures in a row: the "
                        "detector failed: by the test (5912"));
}

TEST_F(FaultyVision, HangsWhenADetectorOfACourseDoesNotReturn) {
  std::optional<msg::ActuatorHeartbeat> heartbeat;
  Watch(transport::ActuatorHeartbeatTopic(""), heartbeat);
  StartWithCamera(kFaultyFile);
  std::optional<msg::String> text;
  Watch("qr_detector/qr_info", text);
  // It looks: the text's reader is discovered there, and then its reader of pictures here.
  ASSERT_TRUE(peer_.Until([&] { return text.has_value(); }))
      << "pictures have " << camera_->MatchedReaders() << " readers; " << peer_.Output();
  SetDetector("hang");
  ASSERT_TRUE(peer_.Until([&] {
    return heartbeat && heartbeat->work == msg::ActuatorHeartbeat::kWorkHung;
  })) << HeartbeatText(heartbeat)
      << peer_.Output();
  SetDetector("work");
  std::ofstream(peer_.folder() / "gate") << "go on";
  EXPECT_TRUE(peer_.Until([&] { return heartbeat->work == msg::ActuatorHeartbeat::kWorkWell; }));
  ExpectTornDown();
}

constexpr const char* kCourseFile = R"(
detect_faces = false
self_check_ms = 15000
still_ms = 0
[[detectors]]
name = "left"
kind = "lines"
picture = "image_left"
[[detectors]]
name = "green_arrow_detector"
kind = "arrow"
)";

// A lane between two yellow lines, and above it a green arrow to the left.
msg::Image Lane() {
  cv::Mat bgr(480, 640, CV_8UC3, cv::Scalar(90, 90, 90));
  const cv::Scalar yellow(0, 220, 230);
  cv::rectangle(bgr, cv::Rect(100, 300, 30, 180), yellow, cv::FILLED);
  cv::rectangle(bgr, cv::Rect(510, 300, 30, 180), yellow, cv::FILLED);
  const std::vector<cv::Point> arrow = {{220, 120}, {300, 60},  {300, 100}, {420, 100},
                                        {420, 140}, {300, 140}, {300, 180}};
  cv::fillPoly(bgr, std::vector{arrow}, cv::Scalar(40, 200, 40));
  return MessageOf(bgr);
}

class CourseProcess : public VisionProcess {
 protected:
  void StartCameras() {
    for (const char* topic : {"image_left", "image_rgb"}) {
      cameras_.push_back(Publisher<msg::Image>(topic, transport::kSensorDataQos));
    }
    ticker_ = peer_.node().loop().Every(Milliseconds(100), [this] {
      picture_.header.stamp = msg::ToStamp(peer_.node().loop().Now().time_since_epoch());
      left_looked_ = left_looked_ || cameras_.front()->MatchedReaders() > 0;
      for (const auto& camera : cameras_) static_cast<void>(camera->Publish(picture_));
    });
  }

  msg::Image picture_ = Lane();
  std::vector<std::unique_ptr<transport::Publisher<msg::Image>>> cameras_;
  transport::LoopHandlePtr ticker_;
  bool left_looked_ = false;  // before it got a picture
};

TEST_F(CourseProcess, SeesTheLinesAndTheArrow) {
  std::optional<msg::YellowLines> lines;
  std::optional<msg::Sighting> arrow;
  std::optional<msg::Image> drawing;
  Watch("yellow_line_detector/left", lines);
  Watch("green_arrow_detector/sighting", arrow);
  Watch("green_arrow_detector/debug_image", drawing);
  StartCameras();
  Start(kCourseFile);
  ExpectDone("SelfCheck");
  EXPECT_FALSE(lines) << "a check publishes nothing";
  ExpectDone("Active");
  ASSERT_TRUE(peer_.Until([&] { return lines && arrow && drawing; })) << peer_.Output();
  EXPECT_EQ(lines->contours, 2U);
  EXPECT_EQ(lines->ycy, "center");
  EXPECT_TRUE(arrow->seen);
  EXPECT_EQ(arrow->text, "left");
  EXPECT_EQ(drawing->width, 640U);
  EXPECT_EQ(drawing->encoding, "bgr8");
  ExpectTornDown();
}

TEST_F(CourseProcess, FailsItsSelfCheckWithTheDetectorThatHasNoPictures) {
  StartCameras();
  cameras_.pop_back();
  std::string file = kCourseFile;
  file.replace(file.find("15000"), 5, "8000");
  Start(file);
  EXPECT_THAT(Failure("SelfCheck"),
              HasSubstr("5909 green_arrow_detector: no publisher of image_rgb"));
}

// All of them look at once, and on a busy computer none gets the CPU that it needs.
TEST_F(CourseProcess, LooksInItsSelfCheckWithADetectorNoMoreOnceItHasPassed) {
  StartCameras();
  cameras_.pop_back();
  const auto watch = peer_.node().loop().Every(Milliseconds(20), [this] {
    const bool looks = cameras_.front()->MatchedReaders() > 0;
    if (left_looked_ && !looks && cameras_.size() == 1) {
      cameras_.push_back(Publisher<msg::Image>("image_rgb", transport::kSensorDataQos));
    }
  });
  Start(kCourseFile);
  ExpectDone("SelfCheck");
  EXPECT_EQ(cameras_.size(), 2U);
  ExpectTornDown();
}

TEST_F(CourseProcess, FailsItsSelfCheckWithTheNamesOfTwoPublishersOfOnePicture) {
  StartCameras();
  // At times of its own: of two pictures at the same instant only the second one is received.
  const auto second = Publisher<msg::Image>("image_rgb", transport::kSensorDataQos);
  const auto ticker = peer_.node().loop().Every(Milliseconds(70), [this, &second] {
    picture_.header.stamp = msg::ToStamp(peer_.node().loop().Now().time_since_epoch());
    static_cast<void>(second->Publish(picture_));
  });
  std::string file = kCourseFile;
  file.replace(file.find("15000"), 5, "8000");
  Start(file);
  EXPECT_THAT(
      Failure("SelfCheck"),
      HasSubstr("5909 green_arrow_detector: several publishers of image_rgb: /vision_test_" +
                std::to_string(getpid())));
}

TEST_F(CourseProcess, FailsItsSelfCheckWithoutTesseractsModel) {
  StartCameras();
  Start(R"(
detect_faces = false
[[detectors]]
name = "board"
kind = "qr"
parameters.language = "xyz"
)");
  const std::string failure = Failure("SelfCheck");
  EXPECT_THAT(failure, HasSubstr("5909 board: "));
  EXPECT_THAT(failure, HasSubstr("tesseract-ocr-xyz"));
}

}  // namespace musher::vision::course_process_test
