#include "musher/test/benchmark/common/observed_controller.hpp"

#include <signal.h>
#include <sys/wait.h>

#include <cstdio>
#include <thread>
#include <utility>

#include "musher/lifecycle/config/config_toml.hpp"
#include "musher/test/benchmark/common/child.hpp"

namespace musher::benchmark {
namespace {

constexpr auto kWaitLimit = std::chrono::minutes(2);

MachineConfig ConfigOf(const std::string& file) {
  auto config = ReadValidConfig(file);
  if (!config) Fail(config.error().message);
  return std::move(config).value();
}

}  // namespace

ObservedController::ObservedController(const std::string& config_file)
    : config_(ConfigOf(config_file)) {
  transport::DdsOptions dds;
  dds.profile = config_.transport;
  dds.discovery = transport::DiscoveryTiming::kOnceKnown;
  auto node = transport::NodeThread::Start(dds);
  if (!node) Fail(node.error().message);
  node_ = std::move(node).value();
  node_->RunOnLoop([this, &dds] {
    ControllerOptions options;
    options.hooks.on_record = [this](const action::Record& record) { OnRecord(record); };
    options.hooks.on_fenced = [](const std::string& why) { Fail(why); };
    options.on_trouble = [](const std::string& what) {
      std::fprintf(stderr, "%s\n", what.c_str());
    };
    auto made = Controller::Make(node_->node(), transport::DomainId(dds).value(), config_,
                                 std::move(options));
    if (!made) Fail(made.error().message);
    controller_ = std::move(made).value();
  });
}

// The next controller of this benchmark may start others of the same names at once.
ObservedController::~ObservedController() {
  Machine machine;
  node_->RunOnLoop([&] {
    machine = controller_->shell().machine();
    controller_.reset();
  });
  for (const KnownActuator& actuator : machine.actuators) {
    if (actuator.process.pid <= 0) continue;
    kill(actuator.process.pid, SIGKILL);
    waitpid(actuator.process.pid, nullptr, 0);
  }
}

void ObservedController::OnRecord(const action::Record& record) {
  if (!controller_) return;  // the first words of its beginning
  const Machine& machine = controller_->shell().machine();
  waiting_.remove_if([&](const Condition& condition) { return condition(record, machine); });
}

std::future<Time> ObservedController::Next(Condition condition) {
  auto promise = std::make_shared<std::promise<Time>>();
  std::future<Time> moment = promise->get_future();
  node_->RunOnLoop([&] {
    waiting_.emplace_back([promise, condition = std::move(condition)](const action::Record& record,
                                                                      const Machine& machine) {
      const Time now = std::chrono::steady_clock::now();
      if (!condition(record, machine)) return false;
      promise->set_value(now);
      return true;
    });
  });
  return moment;
}

void ObservedController::Watch(
    std::function<void(const action::Record& record, const Machine& machine)> watcher) {
  node_->RunOnLoop([&] {
    waiting_.emplace_back(
        [watcher = std::move(watcher)](const action::Record& record, const Machine& machine) {
          watcher(record, machine);
          return false;
        });
  });
}

void ObservedController::Await(const std::string& what,
                               const std::function<bool(const Machine&)>& is_so) {
  const auto deadline = std::chrono::steady_clock::now() + kWaitLimit;
  while (!is_so(Snapshot())) {
    if (std::chrono::steady_clock::now() > deadline) Fail("it does not come about: " + what);
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
}

void ObservedController::AwaitAllThere() {
  Await("all actuators are present", [](const Machine& machine) {
    for (const ActuatorIndex i : machine.actuators.Indices()) {
      if (!IsThere(machine, i)) return false;
    }
    return true;
  });
}

Machine ObservedController::Snapshot() {
  Machine machine;
  node_->RunOnLoop([&] { machine = controller_->shell().machine(); });
  return machine;
}

SwitchResult ObservedController::Switch(const State& target) {
  std::promise<SwitchResult> promise;
  node_->loop().Post([&] {
    controller_->shell().SetState(target, std::nullopt,
                                  [&](const SwitchResult& result) { promise.set_value(result); });
  });
  return promise.get_future().get();
}

Time MomentOf(std::future<Time>& moment, const std::string& what) {
  if (moment.wait_for(kWaitLimit) != std::future_status::ready) Fail("not on record: " + what);
  return moment.get();
}

bool IsThere(const Machine& machine, ActuatorIndex actuator) {
  const KnownActuator& known = machine.actuators[actuator];
  return machine.phase == Phase::kRunning && !machine.current &&
         known.presence == Presence::kPresent && known.state() == machine.state &&
         known.health == Health::kWell && known.checked && !known.due && !known.command;
}

ObservedController::Condition IsOnRecord(ActuatorIndex actuator, Health health) {
  return [=](const action::Record& record, const Machine& machine) {
    return record.actuator == actuator && machine.actuators[actuator].health == health;
  };
}

}  // namespace musher::benchmark
