#pragma once
// Results and plans of the rules as messages, and back.

#include "musher/controller/journal.hpp"
#include "musher/lifecycle/machine.hpp"
#include "musher/lifecycle/plan.hpp"
#include "musher/messages/musher_msgs/machine_services.hpp"
#include "musher/messages/musher_msgs/machine_status.hpp"

namespace musher {

msg::SetState::Response ToMessage(const SwitchResult& result);
msg::GetPlan::Response ToMessage(const MachineConfig& config, const Plan& plan);
msg::HistoryEntry ToMessage(const JournalEntry& entry);

// Without the controller's own process and host.
msg::MachineStatus ToMessage(const MachineConfig& config, const Machine& machine);

}  // namespace musher
