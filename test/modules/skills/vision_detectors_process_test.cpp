// musher-skills that detects with the detectors of musher-vision-manager: both real programs, with
// a camera and a body that the test plays.

#include <gmock/gmock.h>

#include <opencv2/imgproc.hpp>

#include "musher/messages/nav_msgs/odometry.hpp"
#include "musher/messages/stamp.hpp"
#include "musher/modules/vision/course/course_processor.hpp"
#include "musher/test/modules/skills/skills_machine.hpp"
#include "musher/transport/dds/node_thread.hpp"

namespace musher::skills::vision_detectors_process_test {

using ::testing::HasSubstr;

// A green arrow to the left: in the middle of the picture, 200 of its 640 pixels wide.
msg::Image Arrow() {
  cv::Mat bgr(480, 640, CV_8UC3, cv::Scalar(90, 90, 90));
  const std::vector<cv::Point> arrow = {{220, 240}, {300, 180}, {300, 220}, {420, 220},
                                        {420, 260}, {300, 260}, {300, 300}};
  cv::fillPoly(bgr, std::vector{arrow}, cv::Scalar(40, 200, 40));
  return vision::MessageOf(bgr);
}

class VisionDetectors : public SkillsMachine {
 protected:
  VisionDetectors()
      : SkillsMachine({{"vision", "[\"musher-vision-manager\", \"vision.toml\"]"},
                       {"r", "[\"musher-skills\", \"r.toml\"]"}}) {
    std::ofstream(folder_ / "vision.toml")
        << "detect_faces = false\nstill_ms = 0\n[[detectors]]\nname = \"arrow\"\nkind = \"arrow\"\n"
           "publish = \"/arrow/info\"\n";
    std::ofstream(folder_ / "r.toml")
        << "robot = \"r\"\nkind = \"jetbot\"\n[topics]\nobjects = \"\"\nscan = \"\"\n"
           "[cameras]\nfront = \"image_rgb\"\n"
           "[detector.arrow]\ntopic = \"/arrow/sighting\"\nwidth_m = 0.3125\nfov_deg = 90\n";
    node_->RunOnLoop([this] {
      camera_ = transport::MakePublisher<msg::Image>(node_->node(), "image_rgb",
                                                     transport::kSensorDataQos)
                    .value();
      odometry_ = transport::MakePublisher<msg::Odometry>(node_->node(), "r/odom").value();
      ticker_ = node_->loop().Every(Milliseconds(100), [this] { Publish(); });
    });
    Up();
  }
  ~VisionDetectors() override {
    node_->RunOnLoop([this] {
      ticker_.reset();
      camera_.reset();
      odometry_.reset();
    });
  }
  // From here on the camera sees this.
  void See(msg::Image picture) {
    node_->RunOnLoop([&] { picture_ = std::move(picture); });
  }

  void Publish() {
    picture_.header.stamp = msg::ToStamp(node_->loop().Now().time_since_epoch());
    static_cast<void>(camera_->Publish(picture_));
    msg::Odometry odometry;
    odometry.pose.pose.position.x = 1;
    odometry.pose.pose.orientation.w = 1;
    static_cast<void>(odometry_->Publish(odometry));
  }

  std::shared_ptr<transport::NodeThread> node_ = transport::NodeThread::Start().value();
  msg::Image picture_ = Arrow();
  std::unique_ptr<transport::Publisher<msg::Image>> camera_;
  std::unique_ptr<transport::Publisher<msg::Odometry>> odometry_;
  transport::LoopHandlePtr ticker_;
};

// 200 of 640 pixels of 90 degrees are 0.625 m at a distance of 1 m: 0.3125 m wide, it is 0.5 m
// away.
TEST_F(VisionDetectors, FindWhatTheCameraShowsAndNothingElse) {
  const testing::Ended found = Skill({"object_detection", "target_class=arrow"});
  EXPECT_EQ(found.exit, 0) << found.out << found.err;
  EXPECT_THAT(found.out, HasSubstr("Detected: 1 x arrow, nearest left at (1.5"));
  See(vision::MessageOf(cv::Mat(480, 640, CV_8UC3, cv::Scalar(90, 90, 90))));
  const testing::Ended none = Skill({"detect", "target_prim=arrow"});
  EXPECT_THAT(none.err, HasSubstr("arrow"));
  EXPECT_NE(none.exit, 0) << none.out;
}

}  // namespace musher::skills::vision_detectors_process_test
