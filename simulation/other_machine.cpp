#include "musher/simulation/other_machine.hpp"

#include <algorithm>
#include <utility>

namespace musher::simulation {
namespace {

constexpr const char* kId = "22222222-0000-4000-8000-000000000000";
constexpr std::uint64_t kFirstStop = 1'000'000;
constexpr Epoch kHighEpoch = 1000;

}  // namespace

Layout OtherMachine::LayoutOn(const SimRobot& beside, std::size_t host) {
  Layout layout;
  layout.hosts = beside.layout().hosts;
  layout.host_of = PerActuator<std::size_t>(beside.config().actuators.size(), host);
  layout.controllers = {host, host};
  layout.machine_id = kId;
  layout.prefix = "other/";
  return layout;
}

// An actuator that is started by hand knows its machine by name only. The battery's topic has no
// identity, so this machine has no policy. Nor does a console permit it to move. It has one host.
MachineConfig OtherMachine::ConfigOf(const SimRobot& beside, bool same_name) {
  MachineConfig config = beside.config();
  const bool by_hand =
      std::any_of(config.actuators.begin(), config.actuators.end(),
                  [](const ActuatorConfig& actuator) { return actuator.command.empty(); });
  if (!same_name || by_hand) config.name = "other";
  config.policy.reset();
  config.permit.reset();
  config.hosts.clear();
  for (ActuatorConfig& actuator : config.actuators) actuator.host.clear();
  return config;
}

OtherMachine::OtherMachine(SimRobot& beside, Checker& beside_checker, std::size_t host,
                           transport::sim::Random random)
    : beside_(beside),
      beside_checker_(beside_checker),
      host_(host),
      random_(random),
      robot_(beside, ConfigOf(beside, random_.Bernoulli(0.5)), {}, LayoutOn(beside, host)),
      checker_(robot_) {
  robot_.on_record = [this](const action::Record& record) {
    checker_.OnRecord(record);
    if (on_record) on_record(record);
  };
  robot_.on_killed = [this](const SimulatedController& controller) {
    checker_.OnControllerKilled(controller);
  };
  checker_.SetOther(beside_);
  beside_checker_.SetOther(robot_);
  checker_.TakeStopsOf(beside_checker_);
  SetInRange(false);
  if (random_.Bernoulli(0.5)) robot_.disk(0).epoch = kHighEpoch;
  for (const ActuatorConfig& actuator : robot_.config().actuators) {
    if (actuator.command.empty()) robot_.StartActuator(actuator.name);
  }
  StartController(Starter::kPerson);
}

OtherMachine::~OtherMachine() {
  robot_.on_killed = {};
}

void OtherMachine::SetInRange(bool in_range) {
  if (std::exchange(in_range_, in_range) == in_range) return;
  for (std::size_t host = 0; host < host_; ++host) {
    beside_.hosts().SetHostBlocked(host, host_, !in_range);
    beside_.hosts().SetHostBlocked(host_, host, !in_range);
  }
}

void OtherMachine::StartController(Starter starter) {
  if (!robot_.MayStartFirst()) return;
  robot_.LaunchController(0, starter == Starter::kPerson, robot_.ListenTime(), starter);
}

State OtherMachine::SampleState() {
  std::vector<State> states;
  for (const State& state : robot_.config().states) {
    if (state != kSetUp && state != kTearDown) states.push_back(state);
  }
  if (states.empty() || random_.Bernoulli(0.05)) return State(kTearDown);
  return states[random_.Next() % states.size()];
}

void OtherMachine::Act() {
  const PerActuator<ActuatorConfig>& actuators = robot_.config().actuators;
  switch (random_.Next() % 8) {
    case 0:
      return robot_.CrashController();
    case 1:
      return EngageStop();
    case 2:
      return robot_.ReleaseEmergencyStop();
    case 3: {
      const std::string& name = actuators[ActuatorIndex(random_.Next() % actuators.size())].name;
      checker_.OnCrash(name);
      return robot_.CrashActuator(name);
    }
    case 4:
    case 5: {
      const State target = SampleState();
      SimulatedController* leader = robot_.leader();
      if (leader == nullptr) return;
      const std::uint64_t request = checker_.OnRequest(*leader, target);
      return leader->shell().SetState(
          target, std::nullopt,
          [this, request](const SwitchResult& result) { checker_.OnReply(request, result); });
    }
    default: {
      const State target = SampleState();
      checker_.OnClientRequest(target);
      return robot_.ClientOn(host_).SetState(target, "");
    }
  }
}

// A person at this machine stops it, and it alone.
void OtherMachine::EngageStop() {
  const StopId id(kFirstStop + ++stops_);
  const MachineIdentity meant = robot_.EngageByProgram(id, host_, {}, false);
  checker_.OnStopEngaged(kFirstStop + stops_, id);
  robot_.on_stop_program = [this](StopId stop, bool confirmed) {
    // One by the name may reach and confirm the other machine only.
    if (confirmed && !stops_by_name_.contains(stop)) checker_.OnStopConfirmed(stop);
  };
  robot_.on_stop_withdrawn = [this](StopId stop) { checker_.OnStopWithdrawn(stop); };
  if (meant.id.empty()) stops_by_name_.insert(id);
  if (!meant.id.empty()) return beside_checker_.OnStopOfOther(id);
  beside_checker_.OnStopEngaged(kFirstStop + stops_, id);
  beside_checker_.OnStopWithdrawn(id);  // it may be out of range
}

}  // namespace musher::simulation
