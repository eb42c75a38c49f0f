// The invariants of two machines in one network: nothing that is meant for one changes the other.

#include "musher/simulation/checker.hpp"

namespace musher::simulation {

// The engaged stops of panels have no identity, and are latched: they reach a machine that comes
// later, too.
void Checker::TakeStopsOf(const Checker& other) {
  constexpr std::size_t kPanels = 2;
  for (const auto& [panel, id] : other.last_of_panel_) {
    if (panel < kPanels) OnStopEngaged(panel, id);
  }
}

// A controller acts on a client's request. Clients name themselves after the machine they mean.
void Checker::CheckMeant(const action::Record& record) {
  if (other_ == nullptr) return;
  const std::string theirs = Client::Name(other_->identity().id);
  if (record.message.find(theirs) == std::string::npos) return;
  ReportViolation(
      Invariant::kReachesMeantMachine,
      "machine " + robot_.identity().id + " acts on a request of another: " + record.message);
}

// An actuator obeys the controllers of its own machine.
void Checker::CheckControllerOf(const std::string& name, Sender controller) {
  if (other_ == nullptr || controller == 0) return;
  if (!other_->IsController(transport::ParticipantId(controller.value()))) return;
  ReportViolation(Invariant::kReachesMeantMachine,
                  name + " obeys a controller of machine " + other_->identity().id);
}

// A controller is fenced. A controller of its own machine must have begun beside it, or has
// requested that as a process of the same host.
void Checker::CheckFence(const ControllerProcess& controller, const action::Record& record) {
  if (record.event != EventName::kControllerFenced || other_ == nullptr) return;
  const bool requested = record.message.find("of this host") != std::string::npos;
  const bool has_rival = word_of_.size() > word_of_.count(controller.serial());
  if (requested || has_rival) return;
  ReportViolation(
      Invariant::kOtherMachineNeverFences,
      "the only controller of machine " + robot_.identity().id + " is fenced: " + record.message);
}

}  // namespace musher::simulation
