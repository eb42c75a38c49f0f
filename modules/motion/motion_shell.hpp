#pragma once
// The motion manager on the wire: turns topics, services and timers into events for the decision
// code (motion_core.hpp), and its actions into messages. README.md lists the topics.
//
// Threads: the loop's only, but for in_background. Clock, table and config outlive it.

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "musher/messages/nav_msgs/odometry.hpp"
#include "musher/messages/protocol/audio.hpp"
#include "musher/messages/protocol/manager.hpp"
#include "musher/messages/protocol/motion.hpp"
#include "musher/messages/protocol/motion_sequence.hpp"
#include "musher/messages/sensor_msgs/imu.hpp"
#include "musher/messages/tf2_msgs/tf_message.hpp"
#include "musher/modules/motion/motion_backend.hpp"
#include "musher/modules/motion/motion_core.hpp"
#include "musher/modules/motion/motion_sequence.hpp"
#include "musher/transport/clock.hpp"
#include "musher/transport/endpoints.hpp"
#include "musher/transport/loop_breaks.hpp"
#include "musher/wire/other_machines.hpp"

namespace musher::motion {

class MotionShell {
 public:
  // Runs beside the loop, and returns what is to run on the loop then.
  using Background = std::function<std::function<void()>()>;
  struct Dependencies {
    transport::Node& node;
    transport::Clock& clock;
    const MotionTable& table;
    const MotionConfig& config;
    std::string name_space;
    Gate allowed;
    std::function<void(const std::string&)> log;
    std::string name = "motion_manager";  // in node_errors
    // StopTrouble() has changed. On the loop.
    std::function<void(const std::string& trouble)> on_stop_trouble = [](const std::string&) {};
    bool with_keys = false;  // of the machine: then other machines are not known
    // For what waits for a disk: the board and a stop do not. This one runs it at once.
    std::function<void(Background work)> in_background = [](const Background& work) { work()(); };
  };
  using MakeBackend =
      std::function<Result<std::unique_ptr<MotionBackend>>(MotionBackend::OnBody on_body)>;
  using OnAnswer = std::function<void(const motion_action::Answer&)>;

  static Result<std::unique_ptr<MotionShell>> Make(Dependencies dependencies,
                                                   const MakeBackend& make_backend);

  void Do(const MotionEvent& event);
  // The body lies down; `on_answer` gets the outcome, unless the shell is destroyed before.
  RequestToken LieDown(std::int32_t id, int tries, OnAnswer on_answer);
  // Runs `then` with the next report of the body.
  void OnNextReport(std::function<void()> then) {
    next_report_callbacks_.push_back(std::move(then));
  }

  const MotionCore& core() const { return core_; }
  // Where the board's reports come from, in messages.
  std::string board() const { return backend_->Source(); }
  Result<> reachable() const { return backend_->Reachable(); }
  bool knows_commanders() const { return backend_->KnowsCommanders(); }
  // Why the emergency stop that is set has not stopped the body; "": it has, or none is set.
  const std::string& stop_trouble() const { return stop_trouble_; }
  // The result of SelfCheck: the board reports, and no motor has an error.
  Result<> Check() const;

 private:
  explicit MotionShell(Dependencies dependencies);

  Result<> Open(const MakeBackend& make_backend);
  void OpenTopics();
  void OpenFrames();
  void OpenServices();

  void OnBody(const BodyState& body);
  void MeasureWay(const BodyMotion& motion);
  // Fails where what is read now may have waited while this process could not run.
  Result<> CheckFresh();
  // Whether a process of another robot of this namespace has sent the command, which was meant for
  // that one. Logged.
  bool IsForAnother(transport::ParticipantId caller);
  // That its commands are ignored, because it is not known whose process it is.
  void LogUnknown(transport::ParticipantId caller);
  // Takes a request that was meant for this robot: once its caller is known, unless the body was
  // stopped meanwhile. A stop is meant for each robot that it reaches.
  void TakeIfMeant(transport::ParticipantId caller, std::int32_t source,
                   const Result<MotionRequests>& requests, const OnAnswer& on_answer,
                   std::function<void()> take);
  // Fails where the body was stopped after `stops_` was this.
  Result<> CheckNotStopped(std::uint64_t stops) const;
  void Play(std::int32_t source, const Result<MotionRequests>& requests, OnAnswer on_answer);
  void Define(std::int32_t source, std::int32_t id, const Result<UserGait>& gait,
              MotionBackend::OnDefined then);
  void DefineFromFiles(const msg::MotionCustomCmd::Request& request, OnAnswer on_answer);
  // A board that takes gaits executes the one that it was given last.
  Result<> CheckDefined(const MotionRequests& requests) const;
  // Fails with `code` while the gait of this motion is read from its files: the board has an older
  // one, and another definition would be replaced by it.
  Result<> CheckRead(std::int32_t id, std::int32_t code) const;
  void PlayUserGait(const msg::MotionSequenceShow::Request& sequence, OnAnswer on_answer);
  void PublishStatus();
  msg::MotorTemp::Response Temperatures() const;
  void Perform(const MotionAction& action);
  void Arm();
  MotionRules Rules() const {
    return {dependencies_.table, dependencies_.config, dependencies_.allowed};
  }

  const Dependencies dependencies_;
  MotionCore core_;
  std::optional<Eigen::Vector2d> position_;  // up to which the way is measured
  double way_m_ = 0;                         // since it began
  std::optional<std::int32_t> defined_;      // the motion whose gait the board has
  std::set<std::int32_t> reading_;           // the motions whose gaits are read from files
  std::string stop_trouble_;                 // as reported
  std::uint64_t stops_ = 0;                  // so far: requested, of the machine, of the board
  RequestToken token_ = 0;
  std::map<RequestToken, OnAnswer> waiting_;
  std::vector<std::function<void()>> next_report_callbacks_;
  std::optional<Time> other_robot_logged_;
  std::optional<Time> unknown_since_;  // frames of a sender that is not known are ignored
  Time unknown_last_{};                // such a frame
  std::optional<Time> unknown_logged_;
  const std::shared_ptr<bool> alive_ = std::make_shared<bool>(true);  // used on the loop only
  std::unique_ptr<MotionBackend> backend_;
  transport::Publisher<msg::MotionServoResponse>* servo_responses_ = nullptr;
  transport::Publisher<msg::MotionStatus>* status_ = nullptr;
  transport::Publisher<msg::Odometry>* odometry_ = nullptr;
  transport::Publisher<msg::Imu>* imu_ = nullptr;
  transport::Publisher<msg::TfMessage>* tf_ = nullptr;  // null: not published
  transport::Publisher<msg::NodeError>* errors_ = nullptr;
  transport::Publisher<msg::AudioPlayExtend>* speech_ = nullptr;
  transport::LoopBreaks breaks_;
  std::unique_ptr<transport::OtherMachines> other_machines_;  // null: with keys
  transport::LoopHandlePtr status_timer_;
  transport::LoopHandlePtr timer_;
  transport::Endpoints endpoints_;  // last: its callbacks use the rest
};

}  // namespace musher::motion
