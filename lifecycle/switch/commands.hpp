#pragma once
// One command to one actuator, with a definite outcome; and the loss of an actuator, which ends its
// command.

#include <cstdint>
#include <string>

#include "musher/lifecycle/step/emergency_stops.hpp"
#include "musher/lifecycle/step/processes.hpp"

namespace musher {

// How long an actuator has to answer the query for the outcome of a command, and how often it is
// queried. An actuator answers from its loop, whatever its callback does: without an answer for
// 3 × 300 ms the connection is lost.
inline constexpr Duration kQueryTimeout = Milliseconds(300);
inline constexpr int kQueryAttempts = 3;

// How one command ended.
struct CommandResult {
  ActuatorOutcome outcome = ActuatorOutcome::kDone;
  std::int32_t code = kCodeOk;
  RecordText text;
  bool ran = false;    // the callback ran, or may have run
  RecordId cause = 0;  // the record with the reason; 0: the switch it was part of
};

class Commands : StepPart {
 public:
  Commands(StepContext& step, EmergencyStops& stops, Processes& processes)
      : StepPart(step), stops_(stops), processes_(processes) {}

  void Issue(ActuatorIndex i, CommandNumber number, const State& target, Duration budget,
             bool detached = false);
  // Sends the command again if its actuator has refused it as too old although it was not. Returns
  // whether it does.
  bool SendAgain(ActuatorIndex i);
  // Stores a newer report.
  void Accept(ActuatorIndex i, const ActuatorReport& report);
  // The deadline of the command under way has passed.
  void QueryOrLose(ActuatorIndex i);
  // The outcome of the command by the latched status of a queried actuator.
  CommandResult EvaluateReport(ActuatorIndex i, const PendingCommand& command) const;
  // The actuator reports that the command is done; its own status may contradict that.
  CommandResult DoneUnlessContradicted(ActuatorIndex i, const std::string& message) const;
  // Ends the command under way, and the leg of the switch that waits for it.
  void End(ActuatorIndex i, const CommandResult& given);

  void Lose(ActuatorIndex i, const RecordText& how, RecordId cause = 0,
            std::int32_t code = kCodeNetError);
  // The connection to the actuator is lost. The state of a process that this controller started is
  // determined: if it has exited or hangs, it is restarted.
  void LoseConnection(ActuatorIndex i, const RecordText& how, RecordId cause = 0);
  // A hung actuator is killed if it may be restarted, once its backtrace was taken. An actuator
  // that the controller may not restart is left as it is: it may recover.
  void MarkHung(ActuatorIndex i, bool silent, const RecordText& how);
  // The exit of a process can overtake its last sample.
  void AssumeTornDown(ActuatorIndex i);
  // Its process has ended in a TearDown that a person has requested of it alone, and how is not
  // known, or not well: what it has switched on may be on, but nothing brings it back by itself.
  void StayDown(ActuatorIndex i);
  // Records that the actuator has not passed a self-check: it was found in Error, has reached its
  // state without a check, or its check was superseded. It is not driven up without a request.
  void ReportUnchecked(ActuatorIndex i);

 private:
  void Drifted(ActuatorIndex i);
  void RecordDoubles(ActuatorIndex i, const ActuatorReport& report);
  void NoteCheck(ActuatorIndex i, const CommandResult& end);
  CommandResult Tolerate(ActuatorIndex i, const PendingCommand& command, const CommandResult& end);
  Leg* LegUnderWay(ActuatorIndex i);
  State MostActiveOf(ActuatorIndex i) const;
  void EndOwn(ActuatorIndex i, const PendingCommand& command, const CommandResult& end);
  void EndTornDown(ActuatorIndex i, const CommandResult& end);

  EmergencyStops& stops_;
  Processes& processes_;
};

void EndLeg(Leg& leg, const CommandResult& end, Time now);

}  // namespace musher
