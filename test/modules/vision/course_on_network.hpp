#pragma once
// The topics of a detector of a course on a simulated network, in virtual time, with a camera and
// subscribers on a node of their own, and a detector whose results the test sets.

#include <gmock/gmock.h>

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "musher/modules/vision/course/course_topics.hpp"
#include "musher/test/modules/module_on_network.hpp"
#include "musher/test/modules/vision/faces.hpp"

namespace musher::vision {

// Processes at once, or keeps the newest picture while it hangs.
class FakeCourseWorker : public DetectorWorker<CourseProcessor> {
 public:
  Result<> Load() override { return Ok(); }
  void Submit(CourseShot shot) override {
    shots.push_back(shot);
    if (!hangs) Finish(shot);
  }
  Duration Busy() const override { return busy; }
  void Finish(const CourseShot& shot) {
    Result<CourseFound> result = fault ? Result<CourseFound>(*fault) : found;
    if (!fault) {
      result.value().run = shot.run;
      if (shot.draws) result.value().drawing = msg::Image();
    }
    on_result({shot.stamp_ns, shot.picture.width, shot.picture.height, std::move(result), {}});
  }

  CourseFound found;
  std::optional<Error> fault;
  bool hangs = false;
  Duration busy{};
  std::vector<CourseShot> shots;
  std::function<void(DetectionResult<CourseProcessor>)> on_result;
};

class CourseTopicsTest : public test::ModuleOnNetwork {
 protected:
  CourseTopicsTest() {
    entry_.name = "qr_detector";
    entry_.publish = "/qr_detector/qr_info";
    entry_.rate_hz = 0;
    msg::Sighting sighting;
    sighting.seen = true;
    sighting.text = "A-1";
    worker_.found.sight = {sighting, std::nullopt, "A-1"};
    worker_.on_result = [this](const DetectionResult<CourseProcessor>& result) {
      topics_->OnResult(result);
    };
    pictures_ = Publisher<msg::Image>("robot1/image_rgb", transport::kSensorDataQos);
    infos_ = Publisher<msg::CameraInfo>("robot1/image_rgb/camera_info", transport::kSensorDataQos);
  }

  void Start(bool on = true) {
    topics_ = test::Must(CourseTopics::Make(
        {*robot_, *clock_, "robot1", [this] { return clock_->Now().time_since_epoch().count(); },
         [this](const Error& error) {
           log_.push_back(std::to_string(error.code) + " " + error.message);
         }},
        worker_, entry_, Milliseconds(2000)));
    EXPECT_TRUE(topics_->SetOn(on));
    Run(Milliseconds(500));  // discovery
  }
  // The camera sends so many, each 100 ms.
  void Shoot(int pictures = 1, const msg::Image& picture = Picture()) {
    for (int i = 0; i < pictures; ++i) {
      msg::Image shot = picture;
      shot.header.stamp = Stamp();
      EXPECT_TRUE(pictures_->Publish(shot));
      Run(Milliseconds(100));
    }
  }
  template <msg::Message M>
  std::unique_ptr<transport::Subscription> Listen(
      const std::string& topic, std::vector<M>& received,
      const transport::Qos& qos = transport::kDefaultQos) {
    auto subscription = ModuleOnNetwork::Listen(topic, received, qos);
    Run(Milliseconds(500));  // discovery
    return subscription;
  }
  std::string Failing() const {
    const Result<> checked = topics_->Check();
    EXPECT_EQ(checked ? 5909 : checked.error().code, 5909);
    return checked ? "" : checked.error().message;
  }

  CourseEntry entry_;
  FakeCourseWorker worker_;
  std::vector<std::string> log_;
  std::vector<msg::String> texts_;
  std::vector<msg::Sighting> sightings_;
  std::vector<msg::YellowLines> lines_;
  std::vector<msg::Image> drawings_;
  std::unique_ptr<transport::Publisher<msg::Image>> pictures_;
  std::unique_ptr<transport::Publisher<msg::CameraInfo>> infos_;
  std::unique_ptr<CourseTopics> topics_;
};

}  // namespace musher::vision
