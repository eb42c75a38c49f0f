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
  void FeedReply(std::size_t i);   // the first one under way
  void FeedStatus(std::size_t i);  // with the actuator's present report
  void FeedEnd(std::size_t i);     // of its process

  // Events for actuators. `held_back`: the message is late, and its callback is overdue from the
  // start.
  void StartActuator(std::size_t i);
  void Deliver(const Message& message, bool held_back, bool introduced = true);
  void EndCallback(std::size_t i, std::int32_t code, const std::string& text);
  void ReceiveStop(std::size_t i);
  void Crash(std::size_t i);
  // All actuators but `except` receive it.
  void EngageStop(std::optional<std::size_t> except = std::nullopt);

  ActuatorReport Report(std::size_t i);  // with a new stamp
  void Log(const std::string& sentence);
  std::string Name(std::size_t i) const { return config_.actuators[i].name; }
  World& world() { return world_; }
  const MachineConfig& config() const { return config_; }
  const State& Target() const { return model_.target; }

 private:
  void StepActuator(std::size_t i, const ActuatorEvent& event, bool held_back = false);
  void Apply(std::size_t i, const ActuatorAction& action);
  void Apply(const Action& action);
  void Send(std::size_t i, std::variant<SwitchCommand, QueryCommand> what);
  void EndProcess(std::size_t i, bool clean);
  Sender Controller() const { return Sender(world_.generation + 1); }

  const Model& model_;
  const MachineConfig& config_;
  World& world_;
  Notes& notes_;
  std::deque<Event> queue_;
  bool handling_ = false;
};

}  // namespace musher::search
