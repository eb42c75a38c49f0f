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
#include "musher/test/modules/actuator_peer.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher::vision {

class VisionProcess : public ::testing::Test {
 protected:
  explicit VisionProcess(const std::string& program = "musher-vision-manager")
      : peer_("vision",
              {"SetUp", "TearDown", "SelfCheck", "Active", "DeActive", "Protected", "LowPower",
               "OTA", "Error"},
              program) {}

  void Start(const std::string& file) {
    peer_.Start(file);
    ASSERT_TRUE(peer_.AwaitVisible()) << peer_.Output();
  }
  void ExpectDone(const State& state) {
    const auto done = peer_.Switch(state);
    ASSERT_TRUE(done) << state;
    EXPECT_EQ(done.value().verdict, msg::ActuatorCommand::kVerdictDone)
        << state << ": " << done.value().message << peer_.Output();
  }
  std::string Failure(const State& state) {
    const auto done = peer_.Switch(state);
    if (!done) return "no answer";
    EXPECT_EQ(done.value().verdict, msg::ActuatorCommand::kVerdictFailed);
    return std::to_string(done.value().code) + " " + done.value().message;
  }
  template <msg::Message M>
  void Listen(const std::string& topic, std::optional<M>& last) {
    subscriptions_.push_back(transport::MakeSubscription<M>(
                                 peer_.node(), topic,
                                 [&last](const M& message, const auto&) { last = message; },
                                 transport::kSensorDataQos)
                                 .value());
  }

  test::ActuatorPeer peer_;
  std::vector<std::unique_ptr<transport::Subscription>> subscriptions_;
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
    camera_ =
        transport::MakePublisher<msg::Image>(peer_.node(), "image_rgb", transport::kSensorDataQos)
            .value();
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
