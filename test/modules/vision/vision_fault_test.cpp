// The vision manager under injected faults: pictures of people are received in Active only. A
// detector works on a thread of its own, in real time.

#include "musher/messages/stamp.hpp"
#include "musher/modules/vision/vision_manager.hpp"
#include "musher/test/modules/module_fault_test.hpp"
#include "musher/test/modules/vision/faces.hpp"

namespace musher::vision::vision_fault_test {

// A camera that films at all times.
class Camera {
 public:
  explicit Camera(transport::Node& desk)
      : pictures(transport::MakePublisher<msg::Image>(desk, "image_rgb", transport::kSensorDataQos)
                     .value()),
        infos_(transport::MakePublisher<msg::CameraInfo>(desk, "image_rgb/camera_info",
                                                         transport::kSensorDataQos)
                   .value()),
        ticker_(desk.loop().Every(Milliseconds(100), [this, &desk] {
          msg::Image picture = Picture(8, 6);
          picture.header.stamp = msg::ToStamp(desk.loop().Now().time_since_epoch());
          static_cast<void>(infos_->Publish(FrontInfo()));
          static_cast<void>(pictures->Publish(picture));
        })) {}

  const std::unique_ptr<transport::Publisher<msg::Image>> pictures;

 private:
  std::unique_ptr<transport::Publisher<msg::CameraInfo>> infos_;
  transport::LoopHandlePtr ticker_;
};

class NoFaces : public Detector {
 public:
  std::vector<FaceBox> Detect(const msg::Image& /*picture*/) override { return {}; }
};

TEST(TheVisionManager, LooksInActiveOnlyUnderInjectedFaults) {
  testing::ModuleFaultTest<VisionManager, Camera> test;
  test.make = [] {
    return std::make_unique<VisionManager>("vision", VisionConfig{},
                                           []() -> Result<std::unique_ptr<Detector>> {
                                             return std::unique_ptr<Detector>(new NoFaces);
                                           });
  };
  int looked = 0;
  int blind = 0;
  test.always = [&](const VisionManager&, const ActuatorReport& report) {
    test.Pass(Milliseconds(300));  // discovery
    const bool looks = report.state == kActive;
    ++(looks ? looked : blind);
    EXPECT_EQ(test.peers->pictures->MatchedReaders(), looks ? 1 : 0) << report.state;
  };
  test.Run();
  EXPECT_GT(looked, 50) << "or nothing has been tried";
  EXPECT_GT(blind, 50) << "or nothing has been tried";
}

}  // namespace musher::vision::vision_fault_test
