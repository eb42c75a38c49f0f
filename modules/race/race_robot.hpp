#pragma once
// The actuator `race`: the race on its topics and services. See README.md in this folder.
//
//   Active                                     the race runs, or continues where it was
//   DeActive, Protected, LowPower, OTA, Error  it stands still: every servo stream is ended
//   an emergency stop                          the same
//
// Threads: those of FsmActuator.

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "musher/application/fsm_actuator.hpp"
#include "musher/application/fsm_recording.hpp"
#include "musher/messages/nav_msgs/odometry.hpp"
#include "musher/messages/protocol/audio.hpp"
#include "musher/messages/protocol/motion.hpp"
#include "musher/messages/std_msgs/string.hpp"
#include "musher/modules/race/detectors.hpp"
#include "musher/modules/race/race.hpp"
#include "musher/modules/race/self_check.hpp"
#include "musher/transport/endpoints.hpp"
#include "musher/transport/loop_breaks.hpp"
#include "musher/transport/publisher_turns.hpp"

namespace musher::race {

class RaceRobot : public FsmActuator, private RaceOutputs {
 public:
  RaceRobot(const std::string& actuator_name, Course course);
  ~RaceRobot() override;

 private:
  // The endpoints while the topics are open.
  struct Wire {
    explicit Wire(transport::EventLoop& loop) : breaks(loop) {}

    transport::LoopBreaks breaks;
    transport::Publisher<msg::String>* info = nullptr;
    transport::Publisher<msg::MotionServoCmd>* servo = nullptr;
    transport::Client<msg::MotionResultCmd>* motion = nullptr;
    transport::Client<msg::AudioTextPlay>* speech = nullptr;
    std::vector<transport::Publisher<msg::String>*> walkers;  // by walk
    std::vector<transport::Subscription*> walker_statuses;
    std::unique_ptr<Detectors> detectors;
  };

  Result<> BuildMachine(fsm::Machine& machine) override;
  void OpenTopics(transport::Endpoints& topics) override;
  Result<> SelfCheck() override;
  void BeforeTick(Time /*now*/) override { CheckBreak(); }
  void AfterTick(Time now) override;
  void OnPause() override { race_.Pause(Now()); }
  void OnResume() override {
    CheckBreak();  // one in the pause counts as part of it
    race_.Resume(Now());
  }

  void CheckBreak();
  Result<> Record(fsm::Machine& machine);
  void Subscribe(transport::Endpoints& topics);
  template <msg::Message M>
  void SubscribeToBody(transport::Endpoints& topics, const std::string& topic,
                       std::function<void(const M&)> handler,
                       const transport::Qos& qos = transport::kDefaultQos);
  void SubscribeToBattery(transport::Endpoints& topics);
  void OnOdometry(const msg::Odometry& sample);
  void OpenWalkers(transport::Endpoints& topics, Wire& wire);
  Detectors::Handlers DetectorHandlers();
  // The time of a picture, of the machine's clock.
  Time TakenAt(const msg::Stamp& stamp) const;
  MissingParts Look();

  void Walk(const ServoFrame& frame) override;
  void Move(std::int32_t motion_id, std::uint64_t number) override;
  void CommandWalker(const LaneWalk& walk, bool start) override;
  void Watch(const std::vector<bool>& detectors) override;
  void Speak(const std::string& text, std::uint64_t number) override;
  void ShowState(int number) override;
  void Log(const std::string& line) override { FsmActuator::Log(line); }

  std::unique_ptr<FsmRecording> recording_;  // before the member that writes to it
  Race race_;
  std::weak_ptr<Wire> wire_;
  std::optional<Index> lane_walk_;  // whose walker was started
  Time heartbeat_at_{};             // the last one to it
};

}  // namespace musher::race
