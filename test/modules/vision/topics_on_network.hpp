#pragma once
// The topics on a simulated network, in virtual time, with a camera and a subscriber on a node of
// its own, and a detector whose results the test sets.

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "musher/modules/vision/face_topics.hpp"
#include "musher/test/modules/module_on_network.hpp"
#include "musher/test/modules/vision/faces.hpp"

namespace musher::vision {

class FakeDetectorWorker : public DetectorWorker<Detector> {
 public:
  Result<> Load() override { return Ok(); }
  void Submit(Shot shot) override {
    looks.push_back(shot.stamp_ns);
    if (hangs) return;
    on_result({shot.stamp_ns, shot.picture.width, shot.picture.height, found, Milliseconds(1)});
  }
  Duration Busy() const override { return busy; }

  Result<std::vector<FaceBox>> found = std::vector<FaceBox>();
  bool hangs = false;
  Duration busy{};
  std::vector<std::int64_t> looks;
  std::function<void(DetectionResult<Detector>)> on_result;
};

class FaceTopicsTest : public test::ModuleOnNetwork {
 protected:
  FaceTopicsTest() {
    config_.rate_hz = 0;
    config_.still = {};
    worker_.on_result = [this](const DetectionResult<Detector>& result) {
      topics_->OnResult(result);
    };
    target_ = Listen<msg::PointStamped>("robot1/wedding/perception/target", targets_);
    too_close_ = Listen<msg::Bool>("robot1/wedding/perception/too_close", closes_);
    faces_ = test::Must(transport::MakeSubscription<msg::String>(
        *desk_, "robot1/wedding/perception/faces_json",
        [this](const msg::String& text, const auto&) {
          counts_.push_back(nlohmann::json::parse(text.data).at("count"));
        },
        transport::kSensorDataQos));
    pictures_ = Publisher<msg::Image>("robot1/image_rgb", transport::kSensorDataQos);
    infos_ = Publisher<msg::CameraInfo>("robot1/image_rgb/camera_info", transport::kSensorDataQos);
  }

  void Start(bool on = true) {
    topics_ = test::Must(FaceTopics::Make(
        {*robot_, *clock_, "robot1", [this] { return clock_->Now().time_since_epoch().count(); },
         [this](const Error& error) {
           log_.push_back(std::to_string(error.code) + " " + error.message);
         }},
        worker_, config_));
    EXPECT_TRUE(topics_->SetOn(on));
    Run(Milliseconds(500));  // discovery
  }
  // The camera sends so many, each 100 ms, with the lens.
  void Shoot(int pictures = 1, const msg::Image& picture = Picture()) {
    for (int i = 0; i < pictures; ++i) {
      msg::Image shot = picture;
      shot.header.stamp = Stamp();
      EXPECT_TRUE(infos_->Publish(info_));
      EXPECT_TRUE(pictures_->Publish(shot));
      Run(Milliseconds(100));
    }
  }
  void Forget() {
    targets_.clear();
    closes_.clear();
    counts_.clear();
    log_.clear();
  }
  std::string Failing() const {
    const Result<> checked = topics_->Check();
    EXPECT_EQ(checked ? 5909 : checked.error().code, 5909);
    return checked ? "" : checked.error().message;
  }

  VisionConfig config_;
  msg::CameraInfo info_ = FrontInfo();
  FakeDetectorWorker worker_;
  std::vector<std::string> log_;
  std::vector<msg::PointStamped> targets_;
  std::vector<msg::Bool> closes_;
  std::vector<int> counts_;
  std::unique_ptr<transport::Subscription> target_;
  std::unique_ptr<transport::Subscription> too_close_;
  std::unique_ptr<transport::Subscription> faces_;
  std::unique_ptr<transport::Publisher<msg::Image>> pictures_;
  std::unique_ptr<transport::Publisher<msg::CameraInfo>> infos_;
  std::unique_ptr<FaceTopics> topics_;
};

}  // namespace musher::vision
