#pragma once
// musher-vision-manager, or the program with detectors controlled by the test, as a controller and
// the robot's other modules use it: the real program over DDS.

#include <gmock/gmock.h>
#include <sys/stat.h>

#include <fstream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "musher/messages/musher_msgs/heartbeats.hpp"
#include "musher/messages/sensor_msgs/image.hpp"
#include "musher/messages/stamp.hpp"
#include "musher/test/modules/module_process.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher::vision {

class VisionProcess : public test::ModuleProcess {
 protected:
  explicit VisionProcess(const std::string& program = "musher-vision-manager")
      : ModuleProcess("vision", program) {}

  // The latest message of a stream.
  template <msg::Message M>
  void Watch(const std::string& topic, std::optional<M>& last) {
    Listen(topic, last, transport::kSensorDataQos);
  }
};

// For the message of a failed expectation.
inline std::string HeartbeatText(const std::optional<msg::ActuatorHeartbeat>& heartbeat) {
  if (!heartbeat) return "no heartbeat; ";
  return "the last heartbeat, of " + heartbeat->name + ": work " + std::to_string(heartbeat->work) +
         " during '" + heartbeat->during + "', silent for " + std::to_string(heartbeat->silent_ns) +
         " ns, waited for " + std::to_string(heartbeat->waited_ns) + " ns; ";
}

// With a detector and a camera controlled by the test.
class FaultyVision : public VisionProcess {
 protected:
  FaultyVision() : VisionProcess("faulty_vision") {
    mkfifo((peer_.folder() / "gate").c_str(), 0600);
  }

  void SetDetector(const std::string& what) {
    std::ofstream(peer_.folder() / "detector.new") << what;
    rename((peer_.folder() / "detector.new").c_str(), (peer_.folder() / "detector").c_str());
  }
  void StartWithCamera(const std::string& file) {
    camera_ = Publisher<msg::Image>("image_rgb", transport::kSensorDataQos);
    Start(file);
    picture_.width = 8;
    picture_.height = 8;
    picture_.encoding = "mono8";
    picture_.step = 8;
    picture_.data.assign(64, 100);
    ticker_ = peer_.node().loop().Every(Milliseconds(20), [this] {
      picture_.header.stamp = msg::ToStamp(peer_.node().loop().Now().time_since_epoch());
      static_cast<void>(camera_->Publish(picture_));
    });
    ExpectDone("SelfCheck");
    ExpectDone("Active");
  }

  msg::Image picture_;
  std::unique_ptr<transport::Publisher<msg::Image>> camera_;
  transport::LoopHandlePtr ticker_;
};

}  // namespace musher::vision
