// The vision manager under injected faults: pictures of people are received in Active only.

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

// Sees no person, on the loop.
class NoFaces : public DetectorWorker<Detector> {
 public:
  explicit NoFaces(VisionManager::OnFaces on_result) : on_result_(std::move(on_result)) {}

  Result<> Load() override { return Ok(); }
  void Submit(Shot shot) override {
    on_result_(
        {shot.stamp_ns, shot.picture.width, shot.picture.height, std::vector<FaceBox>(), {}});
  }
  Duration Busy() const override { return {}; }

 private:
  const VisionManager::OnFaces on_result_;
};

TEST(TheVisionManager, LooksInActiveOnlyUnderInjectedFaults) {
  testing::ModuleFaultTest<VisionManager, Camera> test;
  test.make = [] {
    return std::make_unique<VisionManager>(
        "vision", VisionConfig{},
        VisionManager::FaceWorkerMaker([](VisionManager::OnFaces on_result) {
          return std::make_unique<NoFaces>(std::move(on_result));
        }));
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
