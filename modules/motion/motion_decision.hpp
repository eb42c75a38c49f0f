#pragma once
// One step of the motion manager's decision, in three files: motion_core.cpp handles the events,
// motion_servo.cpp decides on servo commands, motion_job.cpp executes motions to their end.

#include <string>
#include <utility>
#include <vector>

#include "musher/modules/motion/motion_core.hpp"

namespace musher::motion {

class Decision {
 public:
  Decision(const MotionRules& rules, MotionCore& core, Time now)
      : rules_(rules), core_(core), now_(now) {}

  void Take(const motion_event::BoardReported& event);
  void Take(const motion_event::ServoArrived& event);
  void Take(const motion_event::PlayArrived& event);
  void Take(const motion_event::LieDown& event);
  void Take(const motion_event::Cancelled& event);
  void Take(const motion_event::Closed& event);
  void Take(const motion_event::Opened& event);
  void Take(const motion_event::EmergencyStop& event);
  void Take(const motion_event::WorldRestarted& event);
  void Take(const motion_event::TimePassed& event);

  MotionActions Actions() && { return std::move(actions_); }

 private:
  bool LooksAgain();

  // Checks.
  Result<> MayRun(const Motion& motion, const std::string& capability) const;
  Result<> CheckRequest(const MotionRequest& requested) const;
  Result<> CheckPlay(const motion_event::PlayArrived& event) const;
  Result<> CheckServo(const ServoCommand& command) const;
  Result<> CheckPriority(const ServoCommand& command) const;
  bool Dancing() const;

  // Servo.
  void EndServo(const ServoCommand& command);
  void FollowServo(const ServoCommand& command, const Motion& motion);
  void BeginServo();
  void StopServo(const std::string& why);
  void WatchServo();
  void ReportServo();
  void RefuseServo(const ServoCommand& command, const Error& error);

  // Jobs.
  void BeginEmergencyStop(RequestToken token);
  void BeginJob(Job job);
  void BeginMotion();
  std::vector<std::int32_t> WayTo(const Motion& motion) const;
  std::int32_t CodeOfRefusal() const;
  void AdvanceJob(bool time_passed);
  bool AdvanceWait(bool time_passed);
  void EndMotion();
  void EndJob(std::int32_t code, const std::string& message);
  void FailMotion(std::int32_t code, const std::string& message);
  void DropJob(std::int32_t code, const std::string& message);
  void HaltBody(const JobMotion& motion);
  bool Lies() const;

  // The board.
  void WatchBoard();
  const Motion* Present() const;
  bool Taken() const;
  JobMotion MotionOf(const Motion& motion, const MotionArguments& arguments) const;
  void Command(const BodyCommand& command, bool at_once);
  void Stand(const BodyCommand& last);
  void Quiet();
  void Transmit();
  void TransmitIfDue();

  void Answer(RequestToken token, std::int32_t motion_id, std::int32_t code,
              const std::string& message);
  void Log(std::int32_t code, const std::string& text);
  void ReportMotors(const BodyReport& before);
  void ReportEmergencyStop();

  const MotionRules& rules_;
  MotionCore& core_;
  const Time now_;
  MotionActions actions_;
};

}  // namespace musher::motion
