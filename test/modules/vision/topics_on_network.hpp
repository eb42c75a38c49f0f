#pragma once
// The topics on a simulated network, in virtual time, with a camera and a subscriber on a node of
// its own, and a detector whose results the test sets.

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "musher/messages/stamp.hpp"
#include "musher/modules/vision/face_topics.hpp"
#include "musher/test/modules/vision/faces.hpp"
#include "musher/transport/sim/network.hpp"

namespace musher::vision {

template <class T>
T Must(Result<T> result) {
  if (!result) ADD_FAILURE() << result.error().message;
  return std::move(result).value();
}

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

class FaceTopicsTest : public ::testing::Test {
 protected:
  FaceTopicsTest() {
    config_.rate_hz = 0;
    worker_.on_result = [this](const DetectionResult<Detector>& result) {
      topics_->OnResult(result);
    };
    target_ = Listen<msg::PointStamped>("wedding/perception/target", targets_);
    too_close_ = Listen<msg::Bool>("wedding/perception/too_close", closes_);
    faces_ = Must(transport::MakeSubscription<msg::String>(
        *desk_, "wedding/perception/faces_json",
        [this](const msg::String& text, const auto&) {
          counts_.push_back(nlohmann::json::parse(text.data).at("count"));
        },
        transport::kSensorDataQos));
    pictures_ = Must(transport::MakePublisher<msg::Image>(*desk_, "robot1/image_rgb",
                                                          transport::kSensorDataQos));
    infos_ = Must(transport::MakePublisher<msg::CameraInfo>(*desk_, "robot1/image_rgb/camera_info",
                                                            transport::kSensorDataQos));
  }

  void Start(bool on = true) {
    topics_ = Must(FaceTopics::Make(
        {*robot_, *clock_, "robot1", [this] { return clock_->Now().time_since_epoch().count(); },
         [this](const Error& error) {
           log_.push_back(std::to_string(error.code) + " " + error.message);
         }},
        worker_, config_));
    EXPECT_TRUE(topics_->SetOn(on));
    Run(Milliseconds(500));  // discovery
  }
  void Run(Duration duration) { network_.RunFor(duration); }
  // The camera sends so many, each 100 ms, with the lens.
  void Shoot(int pictures = 1, const msg::Image& picture = Picture()) {
    for (int i = 0; i < pictures; ++i) {
      msg::Image shot = picture;
      shot.header.stamp = msg::ToStamp(network_.now().time_since_epoch());
      EXPECT_TRUE(infos_->Publish(info_));
      EXPECT_TRUE(pictures_->Publish(shot));
      Run(Milliseconds(100));
    }
  }
  template <msg::Message M>
  std::unique_ptr<transport::Subscription> Listen(const std::string& topic,
                                                  std::vector<M>& received) {
    return Must(transport::MakeSubscription<M>(
        *desk_, topic,
        [&received](const M& message, const auto&) { received.push_back(message); }));
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

  transport::sim::Network network_{1};
  std::unique_ptr<transport::Node> robot_ = network_.MakeNode("robot");
  std::unique_ptr<transport::Node> desk_ = network_.MakeNode("desk");
  std::unique_ptr<transport::Clock> clock_ = transport::Clock::Steady(robot_->loop());
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
