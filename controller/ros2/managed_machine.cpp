#include "musher/controller/ros2/managed_machine.hpp"

#include <utility>

#include "musher/base/code.hpp"
#include "musher/lifecycle/refusal.hpp"
#include "musher/lifecycle/switch/plan.hpp"
#include "musher/lifecycle/switch/requests.hpp"

namespace musher {
namespace {

constexpr const char* kMachineNode = "musher";

std::string ChangeStateOf(const MachineConfig& config) {
  return transport::ResolveName(config.name_space, kMachineNode) + "/change_state";
}

// Done-degraded is a success: the machine is in the target; the log names the missing actuators.
Result<> ToResult(const SwitchResult& result) {
  if (result.done() || result.outcome == SwitchOutcome::kDoneDegraded) return Ok();
  return Error{result.code, std::string(OutcomeName(result.outcome)) + ": " + result.reason};
}

}  // namespace

Result<std::unique_ptr<ManagedMachine>> ManagedMachine::Make(transport::Node& node,
                                                             ControllerShell& shell,
                                                             const transport::RosNodes& ros_nodes,
                                                             const std::string& instance) {
  std::unique_ptr<ManagedMachine> machine(new ManagedMachine(shell, ros_nodes));
  ManagedMachine* self = machine.get();
  transport::ManagedNodeEndpoints::Hooks hooks;
  hooks.refusal = [self](const Ros2Transition* transition, transport::ParticipantId caller) {
    return self->WhyRefused(transition, caller);
  };
  hooks.postpone = [self](const Ros2Transition& transition, transport::ParticipantId caller,
                          std::function<void()> again) {
    return self->Postpone(transition, caller, std::move(again));
  };
  hooks.change = [self](const Ros2Transition& transition, transport::ParticipantId caller,
                        const Done& done) {
    self->Change(transition, self->RequesterOf(caller), done);
  };
  hooks.log = [self](const std::string& line) {
    self->shell_.Remark(kCodeStatusError, std::string(kMachineNode) + ": " + line);
  };
  hooks.parameters = transport::ParametersOf(shell.config());
  auto endpoints = transport::ManagedNodeEndpoints::Make(node, shell.config().name_space,
                                                         kMachineNode, instance, std::move(hooks));
  if (!endpoints) return endpoints.error();
  machine->endpoints_ = std::move(endpoints).value();
  machine->OnRecord();
  return machine;
}

void ManagedMachine::OnRecord() {
  const Machine& machine = shell_.machine();
  const bool moves = machine.current && !machine.current->only;
  endpoints_->Observe(machine.state, moves ? machine.current->target : State());
}

std::string ManagedMachine::NodeOf(transport::ParticipantId caller) const {
  return ros_nodes_.CallersOf(ChangeStateOf(shell_.config()), caller);
}

// The nodes of the command `ros2` have this prefix: a person has typed it. In a process with other
// nodes one of these may have sent the request.
Requester ManagedMachine::RequesterOf(transport::ParticipantId caller) const {
  const std::string node = NodeOf(caller);
  const bool person = node.starts_with("/_ros2cli") && node.find(", ") == std::string::npos;
  if (person) return {"ros2 lifecycle (" + node + ")", false};
  return {node.empty() ? "a ROS 2 manager" : node, true};
}

std::optional<Error> ManagedMachine::WhyRefusedToManager(const Ros2Transition& transition) const {
  const auto target = TargetOf(transition, shell_.config());
  if (!target || NeedsNoSwitch(*target)) return std::nullopt;
  return RefusalOfManager(shell_.config(), shell_.machine(), *target);
}

bool ManagedMachine::Postpone(const Ros2Transition& transition, transport::ParticipantId caller,
                              std::function<void()> again) const {
  const bool decided = shell_.machine().current || !WhyRefusedToManager(transition);
  if (decided || !NodeOf(caller).empty()) return false;
  return ros_nodes_.WhenKnown(ChangeStateOf(shell_.config()), caller, std::move(again));
}

// The requests that the decision code would refuse, without a record of each: there may be many.
std::optional<Error> ManagedMachine::WhyRefused(const Ros2Transition* transition,
                                                transport::ParticipantId caller) const {
  const Machine& machine = shell_.machine();
  if (machine.current) {
    return Refused<Refusal::kMachineSwitching>(machine.current->number, machine.current->target);
  }
  if (machine.phase == Phase::kStarting && !machine.start_up.by_hand) {
    return Refused<Refusal::kStartsByItself>();
  }
  if (transition == nullptr) return std::nullopt;
  const auto target = TargetOf(*transition, shell_.config());
  if (!target || NeedsNoSwitch(*target)) return std::nullopt;
  if (auto late = shell_.MayBeLate(*target, std::nullopt)) return late;
  if (!machine.start_up.set_up) return std::nullopt;
  auto overridden = WhyRefusedToManager(*transition);
  if (overridden && RequesterOf(caller).manager) return overridden;
  const Plan plan = MakePlan(shell_.config(), machine, *target);
  return plan.free_by ? std::nullopt : plan.refusal;
}

bool ManagedMachine::NeedsNoSwitch(const State& target) const {
  return target.empty() || (target == kTearDown && shell_.machine().state == kTearDown);
}

void ManagedMachine::Change(const Ros2Transition& transition, const Requester& by,
                            const Done& done) {
  const auto target = TargetOf(transition, shell_.config());
  if (!target) return done(Refused<Refusal::kNoStateOfMachine>());
  if (NeedsNoSwitch(*target)) return done(Ok());
  if (shell_.machine().start_up.set_up) return Switch(*target, by, done);
  // Its services are available before its actuators are set up. What becomes of an actuator that
  // is not set up is the switch's decision, as after the set-up.
  shell_.AwaitSetUp(
      [this, target = *target, by, done, alive = std::weak_ptr<bool>(alive_)](const Result<>&) {
        if (alive.expired()) return;
        Switch(target, by, done);
      });
}

void ManagedMachine::Switch(const State& target, const Requester& by, const Done& done) {
  shell_.SetState(
      target, std::nullopt,
      [this, done, alive = std::weak_ptr<bool>(alive_)](const SwitchResult& result) {
        if (!alive.expired()) OnRecord();
        done(ToResult(result));
      },
      by);
}

}  // namespace musher
