#pragma once
// Brings the machine up: processes in the order of `stage` and `after`, the first stage through
// SelfCheck to Active, or adoption of running actuators; later stages while the machine is in use.

#include <cstdint>
#include <string>
#include <vector>

#include "musher/lifecycle/switch/tear_down.hpp"

namespace musher {

class StartUp : StepPart {
 public:
  StartUp(StepContext& step, Saver& saver, EmergencyStops& stops, Switches& switches,
          TearDown& tear_down)
      : StepPart(step), saver_(saver), stops_(stops), switches_(switches), tear_down_(tear_down) {}

  void Begin(const event::Begin& begin);
  void On(const event::SetUpAwaited& awaited);
  // Gives the examined actuator up if it is overdue, and records why.
  void On(const event::StartExamined& examined);
  // A switch of the start-up has ended, or a requested switch that makes the machine usable.
  void OnSwitchEnded(const EndedSwitch& ended);
  // Each returns whether something changed.
  bool StartProcesses();
  bool Advance();
  // Gives up the actuators that were not set up in time, without knowing why. An actuator with a
  // process may have been examined before.
  void CheckDeadlines();

 private:
  std::vector<StoredActuator> WithEnded(const event::Begin& begin) const;
  void TakeUp(const std::vector<StoredActuator>& actuators);
  void StartStage(int stage, RecordId cause);
  void EndFirstStage();
  void WaitForManager(std::size_t present, std::vector<std::string> missing, RecordId cause);
  void AdoptFrom(const State& lowest, RecordId cause);
  bool AwaitsHost() const;
  bool FailOnCriticalFault();
  void FailWithoutRequest(RecordId cause);
  void Activate(RecordId cause);
  std::string WhyNotSaved(Stored what) const;
  void Fail(const std::string& why, RecordId cause);
  void BecomeRunning(const RecordText& text, RecordId cause);
  void AnswerSetUpRequests();
  std::string FirstTrouble() const;
  void GiveUpIfOverdue(ActuatorIndex i, StartProgress progress);
  RecordText NotSetUp(ActuatorIndex i, StartProgress progress) const;

  Saver& saver_;
  EmergencyStops& stops_;
  Switches& switches_;
  TearDown& tear_down_;
};

}  // namespace musher
