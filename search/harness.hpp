#pragma once
// The fake robot of a World: what is sent waits there for a choice.

#include <functional>
#include <string>

#include "musher/search/world.hpp"

namespace musher::search {

bool FromActuator(const Late& late);

class Harness : public FakeRobot {
 public:
  Harness(const Model& model, World& world, Notes& notes)
      : FakeRobot(model.config, world), model_(model), world_(world), notes_(notes) {}

  // Events for the controller.
  void RequestSwitch(const State& target);
  // The controller is killed, and another starts.
  void RestartController(bool by_person);
  void FeedBattery();
  void FeedReply(ActuatorIndex i);   // the first one under way
  void FeedStatus(ActuatorIndex i);  // with the actuator's present report
  void FeedStatus(event::StatusSeen seen);
  void FeedEnd(ActuatorIndex i);  // of its process
  // Events of a link to another host, and of the actuators there.
  void NoticeCut(std::size_t host);
  void Reach(std::size_t host);
  void FeedUnitReport(ActuatorIndex i);
  void FeedWaits(ActuatorIndex i);  // for its host
  void FeedHeartbeat(ActuatorIndex i);

  // Time passes until EndOfWait().
  void Wait();
  // After each step of the controller, and after each choice.
  void CheckTimedRules();

  // Events for actuators.
  void StartActuator(ActuatorIndex i);
  void Transmit(const Message& message);     // unless its host is out of reach
  void DeliverLate(const Message& message);  // its callback is overdue from the start
  void EndCallback(ActuatorIndex i, std::int32_t code, const std::string& text);
  void ReceiveStop(ActuatorIndex i);
  void Crash(ActuatorIndex i);
  void HangWorkThread(ActuatorIndex i);
  void FeedHang(ActuatorIndex i);
  void TakeBacktrace(ActuatorIndex i);
  void MakeProgress(ActuatorIndex i);
  void CutLink(std::size_t host);
  void RebootHost(std::size_t host);
  // What another machine sends it.
  void ReceiveOtherCommand(ActuatorIndex i, const State& target);
  void ReceiveOtherRelease(ActuatorIndex i);
  // All actuators but `except` receive it.
  void EngageStop(std::optional<ActuatorIndex> except = std::nullopt);

  void Log(const std::string& sentence);
  std::string Name(ActuatorIndex i) const { return config_.actuators[i].name; }
  World& world() { return world_; }
  const MachineConfig& config() const { return config_; }
  const State& Target() const { return model_.target; }
  // The other host that it runs on; kHere: none.
  std::size_t HostOf(ActuatorIndex i) const { return model_.host_of[i]; }
  const std::string& HostName(ActuatorIndex i) const { return model_.hosts[model_.host_of[i]]; }
  bool IsOut(ActuatorIndex i) const { return IsOutOfReach(model_, world_, i); }

 private:
  void StepController(const Event& event) override;
  void StepActuator(ActuatorIndex i, const ActuatorEvent& event) override;
  FakeActuator& Actuator(ActuatorIndex i) override { return world_.actuators[i]; }
  RequestToken TokenOf(Sender sender, CommandNumber number, bool query) override;
  void Send(const Message& message) override { world_.outbox.push_back(message); }
  void Save(Stored what, SaveNumber save, std::function<void(Disk&)> write) override;
  void Do(const Action& action) override;
  void Do(ActuatorIndex i, const ActuatorAction& action);

  void StepWith(const Event& event);
  bool IsMonitored(ActuatorIndex i) const;
  event::Begin BeginHere(const event::Begin& begin) const;
  event::ProcessesFound FindProcesses() const;
  void StartUnit(ActuatorIndex i);
  void StartLate(ActuatorIndex i);  // not in a TearDown
  void FeedUnitEnd(ActuatorIndex i, bool clean);
  void SignalProcess(const action::SignalProcess& signal);
  bool IsElsewhere(ActuatorIndex i) const { return model_.host_of[i] != kHere; }

  void PublishToActuators(const action::PublishEmergencyStop& published);
  void EndProcess(ActuatorIndex i, bool clean);

  const Model& model_;
  World& world_;
  Notes& notes_;
};

}  // namespace musher::search
