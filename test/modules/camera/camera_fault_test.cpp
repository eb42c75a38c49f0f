// The camera manager under injected faults: cameras are open in Active and Protected only, so that
// a robot that rests films no person.

#include "musher/modules/camera/camera_manager.hpp"
#include "musher/test/modules/module_fault_test.hpp"
#include "musher/test/support/temp_folder.hpp"

namespace musher::camera::camera_fault_test {

// A camera, which films as long as it has a subscriber.
class Camera {
 public:
  explicit Camera(transport::Node& desk)
      : pictures(transport::MakePublisher<msg::Image>(desk, "world/camera/front",
                                                      transport::kSensorDataQos)
                     .value()),
        ticker_(desk.loop().Every(Milliseconds(50), [this] {
          if (pictures->MatchedReaders() == 0) return;
          msg::Image picture;
          picture.width = picture.height = 2;
          picture.encoding = "mono8";
          picture.step = 2;
          picture.data.assign(4, 7);
          static_cast<void>(pictures->Publish(picture));
        })) {}

  const std::unique_ptr<transport::Publisher<msg::Image>> pictures;

 private:
  transport::LoopHandlePtr ticker_;
};

TEST(TheCameraManager, OpensCamerasInActiveAndProtectedOnlyUnderInjectedFaults) {
  const TempFolder folder;
  testing::ModuleFaultTest<CameraManager, Camera> test;
  test.make = [&] {
    CamerasConfig config;
    config.cameras.resize(1);
    config.cameras[0].name = "front";
    config.cameras[0].topic = "image_front";
    config.cameras[0].from = "world/camera/front";
    config.critical = {"front"};
    config.service.camera = "front";
    config.service.folder = folder.path();
    return std::make_unique<CameraManager>("camera_manager", config);
  };
  int open = 0;
  int closed = 0;
  test.always = [&](const CameraManager&, const ActuatorReport& report) {
    test.Pass(Milliseconds(300));  // discovery
    const bool on = report.state == kActive || report.state == kProtected;
    ++(on ? open : closed);
    EXPECT_EQ(test.peers->pictures->MatchedReaders(), on ? 1 : 0) << report.state;
  };
  test.Run();
  EXPECT_GT(open, 100) << "or nothing has been tried";
  EXPECT_GT(closed, 100) << "or nothing has been tried";
}

}  // namespace musher::camera::camera_fault_test
