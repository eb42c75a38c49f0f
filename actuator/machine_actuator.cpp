#include "musher/actuator/machine_actuator.hpp"

#include <unistd.h>

#include <atomic>
#include <condition_variable>
#include <cstdlib>
#include <future>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "musher/actuator/actuator_shell.hpp"
#include "musher/actuator/callback_harness.hpp"
#include "musher/actuator/capability_gate.hpp"
#include "musher/actuator/exit_guard.hpp"
#include "musher/actuator/state_callbacks.hpp"
#include "musher/base/check.hpp"
#include "musher/base/code.hpp"
#include "musher/base/config_path.hpp"
#include "musher/base/host.hpp"
#include "musher/base/suggest.hpp"
#include "musher/lifecycle/config/config_toml.hpp"
#include "musher/transport/endpoints.hpp"
#include "musher/wire/dds_options.hpp"

namespace musher {
namespace {

Result<> FromCode(std::int32_t code) {
  return code == kCodeOk ? Ok() : Result<>(Error{code, ""});
}

}  // namespace

// See machine_actuator.hpp for what the calls do.
class MachineActuator::Impl {
 public:
  // Passes a self-check's report of a failed part from its thread to the loop. Threads: any.
  class DegradedReport {
   public:
    // The last one counts.
    void Put(const Error& why) {
      const std::lock_guard lock(mutex_);
      why_ = why;
    }
    // The report put since the last call; code 0: none.
    Error Take() {
      const std::lock_guard lock(mutex_);
      return std::exchange(why_, Error{kCodeOk, ""});
    }

   private:
    std::mutex mutex_;
    Error why_{kCodeOk, ""};
  };

  Impl(std::string name, std::function<void()> on_emergency_stop)
      : name_(std::move(name)), on_emergency_stop_(std::move(on_emergency_stop)) {}
  ~Impl() { Shutdown(); }

  const std::string& name() const { return name_; }

  Result<> Init(const std::string& file, std::shared_ptr<transport::NodeThread> node) {
    auto config = ReadValidConfig(ConfigPath(file));
    if (!config) return config.error();
    node_ = std::move(node);
    return Adopt(std::move(config).value());
  }

  Result<> Adopt(MachineConfig config) {
    config_ = std::move(config);
    index_ = config_->IndexOf(name_);
    if (!index_) {
      std::vector<std::string> names;
      for (const ActuatorConfig& actuator : config_->actuators) names.push_back(actuator.name);
      return Error{kCodeParametersInvalid,
                   config_->file + " has no actuator '" + name_ + "'" + DidYouMean(name_, names)};
    }
    return Ok();
  }

  StateCallbacks& callbacks() { return callbacks_; }

  Result<> Start() {
    Result<> result = TryStart();
    if (!result) {
      Finish(1);
      Shutdown();
    }
    return result;
  }

  Result<> TryStart() {
    if (auto fit = CheckCallbacks(); !fit) return fit;
    const transport::DdsOptions options = transport::OptionsFor(*config_, name_, name_);
    const auto profile = transport::Profile(options);
    if (!profile) return profile.error();
    config_->transport = profile.value();  // heartbeats depend on it, too
    const auto domain = transport::DomainId(options);
    if (!domain) return domain.error();
    auto lock = NameLock::Acquire(NameLock::NameOf(domain.value(), config_->name_space, name_));
    if (!lock) return lock.error();
    name_lock_.emplace(std::move(lock).value());
    if (node_ && node_->credentials() != options.credentials) {
      return Error{kCodeParametersInvalid,
                   "the node given to " + name_ + " has other keys than " + config_->file +
                       "; with [security] each actuator needs a node, and a process, of its own"};
    }
    if (node_) {
      auto own = node_->MakeNode(config_->name_space, name_);
      if (!own) return own.error();
      own_node_ = std::move(own).value();
    } else {
      auto started = transport::NodeThread::Start(options);
      if (!started) return started.error();
      SetNode(std::move(started).value());
    }
    worker_.emplace();
    std::future<Result<>> set_up = set_up_.get_future();
    started_ = true;
    node_->RunOnLoop([this] { StartShell(); });
    return set_up.get();
  }

  int Wait() {
    {
      std::unique_lock lock(mutex_);
      ended_.wait(lock, [this] { return finished_.has_value(); });
    }
    Shutdown();
    return *finished_;
  }

  bool started() const { return started_; }

  void GiveUp(const Error& why) {
    Log(LogLevel::kError, "gives up: " + why.message);
    Finish(1);
  }

  void Log(LogLevel level, const std::string& text) const { WriteLog(level, name_, text); }

  DegradedReport& degraded() { return degraded_; }
  void ReportFault(const Error& fault) {
    if (shell_ != nullptr) shell_->ReportFault(fault);
  }

  void ReportStopTrouble(const std::string& trouble) {
    const std::lock_guard lock(mutex_);
    stop_trouble_ = trouble;
    if (checkpoints_ != nullptr) shell_->CompareStopTrouble();
  }
  void SetStopTrouble(const std::string& trouble) {
    const std::lock_guard lock(mutex_);
    stop_trouble_ = trouble;
  }

  void Shutdown() {
    const std::lock_guard one_at_a_time(shutdown_mutex_);
    // A command that arrives meanwhile must not use the worker that is being stopped.
    if (node_) {
      node_->RunOnLoop([this] {
        if (started_) OwnNode(*node_).SetOnPeerFault({});
        if (shell_) shell_->Close();
      });
    }
    if (worker_) {
      stop_requested_ = true;
      worker_.reset();  // waits for a running callback
    }
    {
      const std::lock_guard lock(mutex_);
      checkpoints_ = nullptr;
    }
    if (node_) {
      node_->RunOnLoop([this] {
        endpoints_.reset();
        shell_.reset();
        own_node_.reset();
      });
    }
    SetNode(nullptr);
    name_lock_.reset();
    started_ = false;
    Finish(0);
  }

  void LeaveToParent() { name_lock_.reset(); }

  void Checkpoint(Duration allowance) {
    const std::lock_guard lock(mutex_);
    if (checkpoints_ == nullptr) return;  // not started yet, or stopped
    checkpoints_->Mark(gettid(), allowance, std::chrono::steady_clock::now());
  }

  bool stop_requested() const {
    if (on_poll_) on_poll_();
    return stop_requested_;
  }

  State current_state() const { return gate_.state(); }
  bool emergency_stopped() const { return gate_.emergency_stop(); }
  bool held_by_stop() const { return gate_.held_by_stop(); }

  Result<> Allowed(const std::string& capability, ModuleCode module) const {
    if (!config_) {
      return Error{MakeCode(module, KeyCode::kStateInvalid),
                   name_ + " is not initialised: Init has not succeeded"};
    }
    return gate_.Evaluate(*config_, name_, capability, module);
  }

  const MachineConfig& config() const {
    MUSHER_CHECK(config_.has_value());
    return *config_;
  }

  std::shared_ptr<transport::NodeThread> node() const {
    const std::lock_guard lock(mutex_);
    return node_;
  }

  Result<> OpenEndpoints(const std::function<void(transport::Endpoints&)>& open) {
    const auto node = this->node();
    if (!node) return Ok();
    Result<> opened;
    node->RunOnLoop([&] {
      endpoints_ = std::make_unique<transport::Endpoints>(OwnNode(*node), config_->name_space,
                                                          config_->clock);
      opened = RunGuarded([&]() -> Result<> {
        open(*endpoints_);
        return endpoints_->opened();
      });
      if (!opened) endpoints_.reset();
    });
    return opened;
  }

  void RunOnLoop(const std::function<void()>& work) {
    if (const auto node = this->node()) return node->RunOnLoop(work);
    work();
  }

  Result<> CheckCallbacks() const {
    if (!index_) return Error{kCodeUninitialized, "Init has not succeeded"};
    return callbacks_.Check(*config_, config_->actuators[*index_]);
  }

  // For a fault-injection test, which has no shell.
  Result<> RunEmergencyStop() {
    return RunGuarded([this]() -> Result<> {
      on_emergency_stop_();
      return Ok();
    });
  }
  void set_stop_requested(bool requested) { stop_requested_ = requested; }
  CapabilityGate& gate() { return gate_; }
  void set_on_poll(std::function<void()> on_poll) { on_poll_ = std::move(on_poll); }

  void SetNode(std::shared_ptr<transport::NodeThread> node) {
    const std::lock_guard lock(mutex_);
    node_.swap(node);  // the old one is destroyed here, or later by its other owners
  }

 private:
  transport::Node& OwnNode(transport::NodeThread& thread) const {
    return own_node_ ? *own_node_ : thread.node();
  }

  // Each fault of a participant once: it may send any number of samples.
  void LogPeerFault(const transport::PeerFault& fault) {
    constexpr std::size_t kMost = 32;
    const Time now = OwnNode(*node_).loop().Now();
    if (peer_faults_.size() >= kMost) {  // respawned processes may be others
      if (now - peer_faults_full_at_ < std::chrono::hours(1)) return;
      peer_faults_.clear();
    }
    const std::string what = fault.what + ", on " + fault.topic;
    if (!peer_faults_.emplace(fault.participant, what).second) return;
    if (peer_faults_.size() == kMost) peer_faults_full_at_ = now;
    const std::string name = transport::NameOf(OwnNode(*node_), fault.participant);
    Log(LogLevel::kWarning,
        (name.empty() ? "a participant without a name" : name) + " " + what + "; logged once");
  }

  void StartShell() {
    OwnNode(*node_).SetOnPeerFault(
        [this](const transport::PeerFault& fault) { LogPeerFault(fault); });
    ActuatorShell::Hooks hooks;
    hooks.run_callback = [this](const State& state) {
      shell_->checkpoints().OnWorker(gettid());
      degraded_.Take();
      std::optional<ExitGuard> guard;
      if (state == kTearDown) guard.emplace(name_);
      return callbacks_.Run(state);
    };
    hooks.take_degraded = [this] { return degraded_.Take(); };
    hooks.on_emergency_stop = [this] {
      SetStopTrouble("");  // not posted: that would come after what the function reports
      if (const Result<> result = RunEmergencyStop(); !result) {
        Log(LogLevel::kError, "OnEmergencyStop: " + result.error().message);
        SetStopTrouble("OnEmergencyStop has failed: " + result.error().message);
      }
    };
    hooks.stop_trouble = [this] {
      const std::lock_guard lock(mutex_);
      return stop_trouble_;
    };
    hooks.leads_here = [this](std::int32_t pid) {
      const auto domain = transport::DomainId(transport::OptionsFor(*config_, name_, name_));
      const std::string name =
          domain ? NameLock::NameOf(domain.value(), config_->name_space, "musher/controller") : "";
      return domain && NameLock::CheckHolder(name, pid).ok();
    };
    hooks.set_stop_requested = [this](bool requested) { set_stop_requested(requested); };
    hooks.on_report = [this](const ActuatorReport& report) { gate_.SetReport(report); };
    hooks.on_battery = [this](std::optional<int> percent) { gate_.SetBattery(percent); };
    hooks.on_set_up = [this] { SetSetUpResult(Ok()); };
    hooks.on_finished = [this](const Error& end) {
      if (end.code != kCodeOk) SetSetUpResult(end);
      Finish(end.code == kCodeOk ? 0 : 1);
    };
    hooks.on_remark = [this](const std::string& line) { Log(LogLevel::kWarning, line); };
    using Ros2 = ActuatorShell::Hooks::Ros2;
    hooks.ros2 = config_->ros2.managed_nodes ? Ros2::kManagedNode : Ros2::kNode;
    // The controller that starts this process sets both.
    const auto variable = [](const char* name) {
      const char* set = std::getenv(name);  // NOLINT(concurrency-mt-unsafe)
      return std::string(set == nullptr ? "" : set);
    };
    ActuatorIdentity identity{Incarnation(NewIncarnation()), getpid(), HostId(),
                              variable("MUSHER_MACHINE"), variable("MUSHER_MACHINE_ID")};
    auto shell = ActuatorShell::Make(OwnNode(*node_), *worker_, *config_, *index_,
                                     std::move(identity), std::move(hooks));
    if (!shell) return SetSetUpResult(shell.error());
    shell_ = std::move(shell).value();
    {
      const std::lock_guard lock(mutex_);
      checkpoints_ = &shell_->checkpoints();
    }
    shell_->Start();
  }

  void SetSetUpResult(Result<> result) {
    if (!std::exchange(set_up_reported_, true)) set_up_.set_value(std::move(result));
  }

  void Finish(int code) {
    const std::lock_guard lock(mutex_);
    if (finished_) return;
    finished_ = code;
    ended_.notify_all();
  }

  const std::string name_;
  const std::function<void()> on_emergency_stop_;
  std::optional<MachineConfig> config_;
  std::optional<ActuatorIndex> index_;
  StateCallbacks callbacks_;
  CapabilityGate gate_;
  DegradedReport degraded_;
  std::optional<NameLock> name_lock_;
  std::mutex shutdown_mutex_;
  std::atomic<bool> started_ = false;
  std::atomic<bool> stop_requested_ = false;
  std::set<std::pair<transport::ParticipantId, std::string>> peer_faults_;  // logged
  Time peer_faults_full_at_{};
  std::function<void()> on_poll_;  // of a fault-injection test; empty on a robot
  std::promise<Result<>> set_up_;
  bool set_up_reported_ = false;
  mutable std::mutex mutex_;  // guards the three below, and changes of node_
  std::optional<int> finished_;
  Checkpoints* checkpoints_ = nullptr;  // of the shell, which lives as long as this is set
  std::string stop_trouble_;
  std::condition_variable ended_;
  std::shared_ptr<transport::NodeThread> node_;
  std::unique_ptr<transport::Node> own_node_;  // by its name, on a thread that is shared
  std::optional<WorkerThread> worker_;
  std::unique_ptr<ActuatorShell> shell_;
  std::unique_ptr<transport::Endpoints> endpoints_;
};

MachineActuator::MachineActuator(const std::string& actuator_name)
    : impl_(std::make_unique<Impl>(actuator_name, [this] { OnEmergencyStop(); })) {}

MachineActuator::~MachineActuator() {
  MUSHER_CHECK(!impl_->started(), name(),
               "is destroyed while it is started, and its members are already destroyed; use "
               "Run(), Wait() or musher::ActuatorRunner");
}

Result<> MachineActuator::Init(const std::string& config_file,
                               std::shared_ptr<transport::NodeThread> node) {
  return impl_->Init(config_file, std::move(node));
}

void MachineActuator::RegisterStateCallback(const State& state,
                                            std::function<std::int32_t()> callback) {
  impl_->callbacks().Register(state,
                              [callback = std::move(callback)] { return FromCode(callback()); });
}

void MachineActuator::RegisterStateCallback(const State& state,
                                            std::function<Result<>()> callback) {
  impl_->callbacks().Register(state, std::move(callback));
}

void MachineActuator::RegisterStateCallback(std::function<std::int32_t(const State&)> callback) {
  impl_->callbacks().Register(
      [callback = std::move(callback)](const State& state) { return FromCode(callback(state)); });
}

void MachineActuator::RegisterStateCallback(std::function<Result<>(const State&)> callback) {
  impl_->callbacks().Register(std::move(callback));
}

Result<> MachineActuator::Start() {
  return impl_->Start();
}
bool MachineActuator::started() const {
  return impl_->started();
}
void MachineActuator::LeaveToParent() {
  impl_->LeaveToParent();
}
Result<> MachineActuator::CheckCallbacks() const {
  return impl_->CheckCallbacks();
}
int MachineActuator::Wait() {
  return impl_->Wait();
}
void MachineActuator::Log(const std::string& text) const {
  Log(LogLevel::kInfo, text);
}
void MachineActuator::Log(LogLevel level, const std::string& text) const {
  impl_->Log(level, text);
}
void MachineActuator::Log(const Error& error) const {
  const LogLevel level = error.code == kCodeOk ? LogLevel::kInfo : LogLevel::kWarning;
  Log(level, WithCode(error.message, error.code));
}
void MachineActuator::GiveUp(const Error& why) {
  impl_->GiveUp(why);
}
void MachineActuator::Shutdown() {
  impl_->Shutdown();
}
bool MachineActuator::StopRequested() const {
  return impl_->stop_requested();
}
void MachineActuator::Checkpoint(std::chrono::nanoseconds allowance) {
  impl_->Checkpoint(allowance);
}
State MachineActuator::CurrentState() const {
  return impl_->current_state();
}
Result<> MachineActuator::Allowed(const std::string& capability, ModuleCode module) const {
  return impl_->Allowed(capability, module);
}
void MachineActuator::ReportDegraded(const Error& why) {
  impl_->degraded().Put(why);
}
void MachineActuator::ReportFault(const Error& fault) {
  impl_->ReportFault(fault);
}
void MachineActuator::ReportStopTrouble(const std::string& trouble) {
  impl_->ReportStopTrouble(trouble);
}
bool MachineActuator::EmergencyStopped() const {
  return impl_->emergency_stopped();
}
bool MachineActuator::HeldByStop() const {
  return impl_->held_by_stop();
}
Result<> MachineActuator::OpenEndpoints(const std::function<void(transport::Endpoints&)>& open) {
  return impl_->OpenEndpoints(open);
}
void MachineActuator::RunOnLoop(const std::function<void()>& work) {
  impl_->RunOnLoop(work);
}
const std::string& MachineActuator::name() const {
  return impl_->name();
}
const MachineConfig& MachineActuator::machine_config() const {
  return impl_->config();
}
std::shared_ptr<transport::NodeThread> MachineActuator::node() const {
  return impl_->node();
}

CallbackHarness::CallbackHarness(MachineActuator& actuator) : actuator_(actuator) {}
std::vector<State> CallbackHarness::States() const {
  return actuator_.impl_->callbacks().States();
}
Result<> CallbackHarness::Adopt(const MachineConfig& config) {
  if (auto adopted = actuator_.impl_->Adopt(config); !adopted) return adopted;
  return actuator_.impl_->CheckCallbacks();
}
void CallbackHarness::SetNode(std::shared_ptr<transport::NodeThread> node) {
  actuator_.impl_->SetNode(std::move(node));
}
Result<> CallbackHarness::Run(const State& state) {
  return actuator_.impl_->callbacks().Run(state);
}
Result<> CallbackHarness::EmergencyStop() {
  return actuator_.impl_->RunEmergencyStop();
}
void CallbackHarness::SetStopRequested(bool requested) {
  actuator_.impl_->set_stop_requested(requested);
}
void CallbackHarness::SetReport(const ActuatorReport& report) {
  actuator_.impl_->gate().SetReport(report);
}
void CallbackHarness::SetBattery(std::optional<int> percent) {
  actuator_.impl_->gate().SetBattery(percent);
}
void CallbackHarness::OnPoll(std::function<void()> on_poll) {
  actuator_.impl_->set_on_poll(std::move(on_poll));
}

// --- a program that is one actuator: a failure is logged and becomes its exit code ---

int MachineActuator::Check(const std::string& config_file) {
  if (const auto read = Init(config_file); !read) {
    Log(LogLevel::kError, read.error().message);
    return kConfigurationError;
  }
  const auto fit = CheckCallbacks();
  if (!fit) Log(LogLevel::kError, fit.error().message);
  return fit ? 0 : kConfigurationError;
}

int MachineActuator::Run(const std::string& config_file) {
  if (const int faulty = Check(config_file); faulty != 0) return faulty;
  const auto started = Start();
  if (started) return Wait();
  Log(LogLevel::kError, "not started: " + ErrorText(started.error()));
  return 1;
}

}  // namespace musher
