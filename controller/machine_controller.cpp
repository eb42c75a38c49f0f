#include "musher/controller/machine_controller.hpp"

#include <cstdlib>
#include <future>
#include <iostream>
#include <optional>
#include <utility>
#include <vector>

#include "musher/base/config_path.hpp"
#include "musher/controller/controller.hpp"
#include "musher/lifecycle/config/config_toml.hpp"
#include "musher/wire/dds_options.hpp"

namespace musher {

class MachineController::Impl {
 public:
  explicit Impl(std::vector<ControllerExtension> extensions) : extensions_(std::move(extensions)) {}
  ~Impl() {
    if (!node_) return;
    node_->RunOnLoop([this] {
      alive_.reset();
      controller_.reset();
      own_node_.reset();
    });
  }

  Result<> Init(const std::string& config_file, std::shared_ptr<transport::NodeThread> node) {
    if (controller_) return Error{kCodeStateInvalid, "the controller is already initialised"};
    auto config = ReadValidConfig(ConfigPath(config_file));
    if (!config) return config.error();
    config_ = std::move(config).value();
    transport::DdsOptions options =
        transport::OptionsFor(*config_, transport::kControllerIdentity, transport::kControllerNode);
    options.discovery = transport::DiscoveryTiming::kOnceKnown;
    const auto profile = transport::Profile(options);
    if (!profile) return profile.error();
    config_->transport = profile.value();  // decisions about silent actuators depend on it, too
    const auto domain = transport::DomainId(options);
    if (!domain) return domain.error();
    node_ = std::move(node);
    if (node_) {
      auto own = node_->MakeNode(config_->name_space, transport::kControllerNode);
      if (!own) return own.error();
      own_node_ = std::move(own).value();
    } else {
      auto started = transport::NodeThread::Start(options);
      if (!started) return started.error();
      node_ = std::move(started).value();
    }
    Result<> result;
    node_->RunOnLoop([&] { result = Begin(domain.value()); });
    return result;
  }

  Result<> AwaitSetUp() {
    if (!controller_) return Error{kCodeUninitialized, "Init() has not succeeded"};
    std::promise<Result<>> promise;
    node_->loop().Post([&] {
      controller_->shell().AwaitSetUp([&](const Result<>& result) { promise.set_value(result); });
    });
    return promise.get_future().get();
  }

  SwitchResult Switch(const std::optional<std::string>& actuator, const State& target) {
    std::promise<SwitchResult> promise;
    SwitchAsync(actuator, target, [&](const SwitchResult& result) { promise.set_value(result); });
    return promise.get_future().get();
  }

  void SwitchAsync(std::optional<std::string> actuator, const State& target, OnEnd on_end) {
    if (!controller_) {
      SwitchResult refusal;
      refusal.target = target;
      refusal.outcome = SwitchOutcome::kRefused;
      refusal.code = kCodeUninitialized;
      refusal.reason = "Init() has not succeeded";
      return on_end(refusal);
    }
    node_->loop().Post([this, alive = std::weak_ptr(alive_), actuator = std::move(actuator), target,
                        on_end = std::move(on_end)] {
      if (alive.expired()) return;
      controller_->shell().SetState(target, actuator, on_end);
    });
  }

  // A copy of the machine's record now; before Init, of a machine without actuators.
  Machine Snapshot() const {
    Machine machine;
    if (controller_) node_->RunOnLoop([&] { machine = controller_->shell().machine(); });
    return machine;
  }

  const std::optional<MachineConfig>& config() const { return config_; }

 private:
  Result<> Begin(int domain_id) {
    ControllerOptions options;
    options.by_hand = true;
    options.extensions = extensions_;
    options.on_trouble = [](const std::string& message) { std::cerr << message << std::endl; };
    transport::Node& node = own_node_ ? *own_node_ : node_->node();
    auto controller = Controller::Make(node, domain_id, *config_, std::move(options));
    if (!controller) return controller.error();
    controller_ = std::move(controller).value();
    return Ok();
  }

  const std::vector<ControllerExtension> extensions_;
  std::optional<MachineConfig> config_;
  std::shared_ptr<transport::NodeThread> node_;
  std::unique_ptr<transport::Node> own_node_;  // by its name, on a thread that is shared
  std::unique_ptr<Controller> controller_;
  std::shared_ptr<int> alive_ = std::make_shared<int>();  // checked by what is posted to the loop
};

MachineController::MachineController() : MachineController(std::vector<ControllerExtension>{}) {}
MachineController::MachineController(std::vector<ControllerExtension> extensions)
    : impl_(std::make_unique<Impl>(std::move(extensions))) {}
MachineController::~MachineController() = default;

Result<> MachineController::Init(const std::string& config_file,
                                 std::shared_ptr<transport::NodeThread> node) {
  return impl_->Init(config_file, std::move(node));
}

Result<> MachineController::AwaitSetUp() {
  return impl_->AwaitSetUp();
}

std::map<std::string, State> MachineController::States() const {
  std::map<std::string, State> states;
  const Machine machine = impl_->Snapshot();
  for (const ActuatorIndex i : machine.actuators.Indices()) {
    states[impl_->config()->actuators[i].name] = machine.actuators[i].state();
  }
  return states;
}

std::optional<State> MachineController::StateOf(const std::string& actuator) const {
  const auto states = States();
  const auto found = states.find(actuator);
  return found == states.end() ? std::nullopt : std::optional(found->second);
}

State MachineController::GetMachineState() const {
  return impl_->Snapshot().state;
}

SwitchResult MachineController::Switch(const std::string& actuator, const State& target) {
  return impl_->Switch(actuator, target);
}

SwitchResult MachineController::Switch(const State& target) {
  return impl_->Switch(std::nullopt, target);
}

void MachineController::SwitchAsync(const std::string& actuator, const State& target,
                                    OnEnd on_end) {
  impl_->SwitchAsync(actuator, target, std::move(on_end));
}

void MachineController::SwitchAsync(const State& target, OnEnd on_end) {
  impl_->SwitchAsync(std::nullopt, target, std::move(on_end));
}

}  // namespace musher
