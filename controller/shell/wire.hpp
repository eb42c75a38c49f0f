#pragma once
// Results, plans and records of the decision code as messages.

#include "musher/controller/journal/journal.hpp"
#include "musher/lifecycle/machine/machine.hpp"
#include "musher/lifecycle/switch/plan.hpp"
#include "musher/messages/musher_msgs/machine_services.hpp"
#include "musher/messages/musher_msgs/machine_status.hpp"

namespace musher {

msg::SetState::Response ToMessage(const SwitchResult& result);
msg::GetPlan::Response ToMessage(const MachineConfig& config, const Plan& plan);
msg::HistoryEntry ToMessage(const JournalEntry& entry);
// The entries and their events, without the error.
msg::GetHistory::Response ToMessage(const std::vector<JournalEntry>& entries);

// Without the controller's own pid and host.
msg::MachineStatus ToMessage(const MachineConfig& config, const Machine& machine);

}  // namespace musher
