#pragma once
// The actuator `wedding`: the show on its topics. See README.md in this folder.
//
//   Active                                     the show runs, from IDLE: at once with `autostart`,
//                                              else from the command START on
//   DeActive, Protected, LowPower, OTA, Error  neutral pose, gaze ahead, paused
//   an emergency stop                          paused, and no output to the robot
//
// Threads: those of FsmActuator.

#include <memory>
#include <optional>
#include <string>

#include "musher/application/fsm_actuator.hpp"
#include "musher/application/fsm_recording.hpp"
#include "musher/messages/geometry_msgs/point_stamped.hpp"
#include "musher/messages/sensor_msgs/joint_state.hpp"
#include "musher/messages/std_msgs/string.hpp"
#include "musher/modules/wedding/photographer.hpp"
#include "musher/modules/wedding/second_generation.hpp"
#include "musher/modules/wedding/self_check.hpp"
#include "musher/modules/wedding/show.hpp"
#include "musher/transport/endpoints.hpp"

namespace musher::wedding {

class WeddingRobot : public FsmActuator, private ShowOutputs {
 public:
  WeddingRobot(const std::string& actuator_name, WeddingConfig config);
  ~WeddingRobot() override;

 private:
  // The endpoints while the topics are open.
  struct Wire {
    transport::Publisher<msg::String>* state = nullptr;
    transport::Publisher<msg::String>* pose = nullptr;
    transport::Publisher<msg::PointStamped>* look_at = nullptr;
    transport::Publisher<msg::String>* play = nullptr;
    transport::Subscription* target = nullptr;
    std::optional<Photographer> photographer;  // if the config names a camera
    std::optional<SecondGeneration> second;    // if the config enables its topics
  };

  Result<> BuildMachine(fsm::Machine& machine) override;
  void OpenTopics(transport::Endpoints& topics) override;
  Result<> SelfCheck() override;
  void AfterTick(Time /*now*/) override { show_.AfterTick(); }
  void OnPause() override { show_.Pause(Now(), EmergencyStopped()); }
  void OnResume() override { show_.Resume(Now()); }

  Result<> Record(fsm::Machine& machine);
  void Subscribe(transport::Endpoints& topics, Wire& wire);
  void SubscribeJoints(transport::Endpoints& topics);
  void Serve(transport::Endpoints& topics);
  MissingParts Look();
  void ShowFace();

  void TakePose(std::string_view pose) override;
  void LookAt(Gaze gaze) override;
  void Play(std::string_view sound) override;
  void TakePhoto() override;
  void RecordVideo(bool on) override;
  void SetMotion(std::string_view motion) override;
  void ShowState(std::string_view state) override;
  void Log(const std::string& line) override;

  const WeddingConfig config_;
  std::unique_ptr<FsmRecording> recording_;  // before the member that writes to it
  Show show_;
  std::weak_ptr<Wire> wire_;
  std::optional<Time> seen_at_;  // when vision last published
};

}  // namespace musher::wedding
