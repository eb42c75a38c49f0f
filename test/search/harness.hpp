#pragma once
// Inside of the world: connects the actions of the two decision codes as the shells do.

#include <deque>
#include <string>

#include "musher/test/search/world.hpp"

namespace musher::search {

bool FromActuator(const Late& late);

class Harness {
 public:
  Harness(const Model& model, World& world, Notes& notes)
      : model_(model), config_(model.config), world_(world), notes_(notes) {}

  // To the controller.
  void Tell(const Event& event);
  void Ask(const State& target);
  void BeginController(bool by_hand);
  void RestartController();
  void TellReply(std::size_t i);   // the first on its way
  void TellStatus(std::size_t i);  // as the actuator stands now
  void TellEnd(std::size_t i);     // of its process

  // To actuators. `held_back`: it comes late, and what it begins is overdue from the start.
  void StartActuator(std::size_t i);
  void Deliver(const Message& message, bool held_back, bool introduced = true);
  void EndCallback(std::size_t i, std::int32_t code, const std::string& text);
  void HearStop(std::size_t i);
  void Crash(std::size_t i);
  // All actuators hear of it but this one.
  void EngageStop(std::optional<std::size_t> but = std::nullopt);

  ActuatorReport Report(std::size_t i);  // with a new stamp
  void Say(const std::string& sentence);
  std::string Name(std::size_t i) const { return config_.actuators[i].name; }
  World& world() { return world_; }
  const MachineConfig& config() const { return config_; }
  const State& Wanted() const { return model_.target; }

 private:
  void Perform(std::size_t i, const ActuatorEvent& event, bool held_back = false);
  void Do(std::size_t i, const ActuatorAction& action);
  void Do(const Action& action);
  void Send(std::size_t i, std::variant<SwitchCommand, AskCommand> what);
  void EndProcess(std::size_t i, bool clean);
  Sender Controller() const { return world_.generation + 1; }

  const Model& model_;
  const MachineConfig& config_;
  World& world_;
  Notes& notes_;
  std::deque<Event> queue_;
  bool handling_ = false;
};

}  // namespace musher::search
