#pragma once
// Results and plans of the rules as messages, and back.

#include "musher/controller/journal.hpp"
#include "musher/lifecycle/machine.hpp"
#include "musher/lifecycle/plan.hpp"
#include "musher/messages/musher_msgs/machine_services.hpp"

namespace musher {

msg::SetState::Response ToMessage(const SwitchResult& result);
msg::GetPlan::Response ToMessage(const MachineConfig& config, const Plan& plan);
msg::HistoryEntry ToMessage(const JournalEntry& entry);

}  // namespace musher
