#pragma once
// Connects the actions of the two decision codes in a World, as the shells do.

#include <deque>
#include <string>

#include "musher/test/search/world.hpp"

namespace musher::search {

bool FromActuator(const Late& late);

class Harness {
 public:
  Harness(const Model& model, World& world, Notes& notes)
      : model_(model), config_(model.config), world_(world), notes_(notes) {}

  // Events for the controller.
  void Feed(const Event& event);
  void RequestSwitch(const State& target);
  void BeginController(bool by_hand);
  void RestartController();
  void FeedReply(ActuatorIndex i);   // the first one under way
  void FeedStatus(ActuatorIndex i);  // with the actuator's present report
  void FeedEnd(ActuatorIndex i);     // of its process

  // Events for actuators. `held_back`: the message is late, and its callback is overdue from the
  // start.
  void StartActuator(ActuatorIndex i);
  void Deliver(const Message& message, bool held_back, bool introduced = true);
  void EndCallback(ActuatorIndex i, std::int32_t code, const std::string& text);
  void ReceiveStop(ActuatorIndex i);
  void Crash(ActuatorIndex i);
  // All actuators but `except` receive it.
  void EngageStop(std::optional<ActuatorIndex> except = std::nullopt);

  ActuatorReport Report(ActuatorIndex i);  // with a new stamp
  void Log(const std::string& sentence);
  std::string Name(ActuatorIndex i) const { return config_.actuators[i].name; }
  World& world() { return world_; }
  const MachineConfig& config() const { return config_; }
  const State& Target() const { return model_.target; }

 private:
  void StepActuator(ActuatorIndex i, const ActuatorEvent& event, bool held_back = false);
  void Apply(ActuatorIndex i, const ActuatorAction& action);
  void Apply(const Action& action);
  void Send(ActuatorIndex i, std::variant<SwitchCommand, QueryCommand> what);
  void EndProcess(ActuatorIndex i, bool clean);
  Sender Controller() const { return Sender(world_.generation + 1); }

  const Model& model_;
  const MachineConfig& config_;
  World& world_;
  Notes& notes_;
  std::deque<Event> queue_;
  bool handling_ = false;
};

}  // namespace musher::search
