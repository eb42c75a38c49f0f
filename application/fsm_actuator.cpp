#include "musher/application/fsm_actuator.hpp"

#include <functional>
#include <optional>
#include <string_view>
#include <utility>

#include "musher/application/application_impl.hpp"
#include "musher/application/behavior_report.hpp"
#include "musher/application/refusal.hpp"
#include "musher/base/check.hpp"
#include "musher/messages/musher_msgs/behavior.hpp"
#include "musher/messages/std_msgs/string.hpp"
#include "musher/transport/endpoints.hpp"

namespace musher {

class FsmActuator::Impl final : public ApplicationImpl, private fsm::Listener {
 public:
  Impl(FsmActuator& owner, Options options)
      : ApplicationImpl(owner, options.rate_hz),
        owner_(owner),
        options_(std::move(options)),
        log_(owner) {
    if (options_.machine.name == fsm::Machine::Options{}.name) {
      options_.machine.name = owner.name();
    }
  }

  using ApplicationImpl::CheckNotLate;

  Result<> Send(std::string_view command) {
    if (waits_) {
      if (command == kStartCommand) {
        return BeginByCommand();
      }
      return Refused<ApplicationRefusal::kWaitsForStart>(owner_.name(), owner_.name());
    }
    const Result<> ready = CheckTicking();
    return ready ? machine_->Send(command) : ready;
  }

  // A command queued for hours would no longer be wanted.
  Result<> CheckTicking() const {
    if (ticking()) return Ok();
    return Refused<ApplicationRefusal::kPaused>(owner_.name(), Whereabouts());
  }

  // For calls that are on the loop only.
  Impl& OnLoop() {
    CheckThread();
    return *this;
  }

  fsm::Machine& machine() {
    MUSHER_CHECK(machine_ != nullptr, "SetUp of", owner_.name(), "has not run");
    return *machine_;
  }

 private:
  void OnChange(const fsm::Machine& machine, const fsm::Change& change) override {
    std::string line = std::string(machine.Name(change.from)) + " -> " +
                       std::string(machine.Name(change.to)) + ": " +
                       std::string(fsm::Name(change.cause));
    if (change.command != fsm::kNoEvent) line += " by " + std::string(machine.Name(change.command));
    if (change.cause == fsm::Cause::kUnsafe) line += ", " + std::string(machine.unsafe());
    log_(change.at, LogLevel::kInfo, line);
    if (!in_tick_) PublishSoon();
  }
  void OnKept(const fsm::Machine& machine, fsm::EventId command, fsm::StateId state) override {
    const std::string name(machine.Name(command));
    log_(machine.time(), LogLevel::kWarning,
         std::string(machine.Name(state)) + " keeps command " + name +
             ", and all later ones wait behind it; declare Defer(\"" + name +
             "\") to let them pass");
  }
  void OnUnhandled(const fsm::Machine& machine, fsm::EventId command, fsm::StateId state) override {
    log_(machine.time(), LogLevel::kWarning,
         "command " + std::string(machine.Name(command)) + " is not handled in " +
             std::string(machine.Name(state)));
  }
  void OnFault(const fsm::Machine& machine, const fsm::Fault& fault) override {
    log_(fault.at, LogLevel::kError, "fault: " + machine.Describe(fault));
  }

  Result<> SetUp() override {
    owner_.RunOnLoop([this] { commanded_ = ended_ = started_ = false; });
    machine_ = std::make_unique<fsm::Machine>(options_.machine);
    machine_->Listen(this);
    if (Result<> built = owner_.BuildMachine(*machine_); !built) return built;
    if (machine_->chart().start == fsm::kNoState) {
      return Error{kCodeFailed, "BuildMachine() has not called Build() of its machine"};
    }
    for (const std::string& warning : machine_->warnings()) owner_.Log(LogLevel::kWarning, warning);
    return Open([this](transport::Endpoints& topics) {
      publish_state_ = topics.PublishFunction<msg::String>(owner_.name() + "/behavior_state",
                                                           transport::kLatchedQos);
      topics.Serve<msg::GetBehavior>(owner_.name() + "/get_behavior",
                                     [this](const auto& request, auto reply) {
                                       auto report = ReportBehavior(*machine_, ticking(), request);
                                       report.held_by_stop = owner_.HeldByStop();
                                       reply(report);
                                     });
      ServeCommands(
          topics, [this](const std::string& command) { return Send(command); },
          [this](const std::string& command) { return machine_->IsUrgent(command); });
      published_.reset();
      Publish();
      owner_.OpenTopics(topics);
    });
  }
  Result<> SelfCheck() override { return owner_.SelfCheck(); }

  Result<> Activate() override {
    Result<> started = StartOrResume();
    if (!started) Pause();  // an incomplete start is not left running
    Publish();
    return started;
  }
  void Leave(const State& state) override {
    if (state == kTearDown) {
      End();
    } else {
      Pause();
    }
    Publish();
  }
  std::string StopAtOnce() override {
    Pause();
    return "";
  }

  void Pause() {
    PauseMachine();
    CallOnPause([&] { owner_.OnPause(); });
  }

  Result<> StartOrResume() {
    if (Result<> checked = CheckNoStop(); !checked) return checked;
    if (ticking()) return Ok();
    EndAfterBreak();
    ended_ |= started_ && !machine_->running();  // it was stopped in a pause
    waits_ = Waits();
    if (waits_) {
      owner_.Log("stands, and waits for START");
      return Ok();
    }
    if (const auto thrown = Thrown("OnResume", [&] { owner_.OnResume(); })) {
      return Error{kCodeFailed, *thrown};
    }
    if (!machine_->running()) {
      static_cast<void>(machine_->Start(Now()));  // a fault is reported by OnFault
      if (!machine_->running()) {
        return Error{kCodeFailed,
                     "the machine stopped at its start: " + machine_->Describe(*machine_->fault())};
      }
      started_ = true;
      // The first time received from /clock may have any value.
      if (Now() == Time{}) machine_->Pause();
    } else if (options_.resume == Resume::kFromStart) {
      static_cast<void>(machine_->Reset());
    }
    StartTicks();
    return Ok();
  }

  // A START that fails was not given.
  Result<> BeginByCommand() {
    static_cast<void>(EndAfterBreak());  // one of before START
    const bool commanded = std::exchange(commanded_, true);
    const bool ended = std::exchange(ended_, false);
    started_ = false;
    Result<> begun = StartOrResume();
    if (begun) return begun;
    Pause();  // an incomplete start is not left running
    commanded_ = commanded;
    ended_ = ended;
    waits_ = true;
    return begun;
  }

  // For START.
  bool Waits() const { return ended_ || (options_.begin == Begin::kOnCommand && !commanded_); }

  // What ran long ago does not go on by itself: the machine begins as after a restart of its
  // process. Whether it was ended.
  bool EndAfterBreak() {
    if (!options_.ends_after_break) return false;
    const auto could_not_run = TakeLongBreak();
    if (!could_not_run) return false;
    commanded_ = false;
    if (!machine_->running()) return false;
    owner_.Log(LogLevel::kWarning, "the machine is ended: " + *could_not_run);
    End();
    started_ = false;
    return true;
  }
  void BeginAfterBreak() {
    if (Result<> begun = StartOrResume(); !begun) {
      Pause();  // an incomplete start is not left running
      ended_ = waits_ = true;
      owner_.Log(LogLevel::kError, "waits for START: " + begun.error().message);
    }
    Publish();
  }

  void Tick() override {
    if (EndAfterBreak()) return BeginAfterBreak();
    const Time now = Now();
    in_tick_ = true;
    const bool well = GuardTick("BeforeTick", before_fault_, [&] { owner_.BeforeTick(now); });
    if (ticking()) machine_->RunOnce(now);
    if (!well) GoSafe();  // also when the tick has just left it
    GuardTick("AfterTick", after_fault_, [&] { owner_.AfterTick(now); });
    in_tick_ = false;
    Publish();
    if (!machine_->running()) Ended();
  }

  // The machine stopped: by a fault, or by the application.
  void Ended() {
    const bool by_fault = machine_->fault() && machine_->mode() == fsm::Mode::kSafeStop;
    Pause();
    if (!by_fault) {
      ended_ = waits_ = true;
      return owner_.Log("the machine has ended, and waits for START");
    }
    owner_.GiveUp({kCodeFailed, machine_->Describe(*machine_->fault())});
  }

  void End() {
    PauseMachine();
    static_cast<void>(machine_->Stop());  // a fault is reported by OnFault
    CallOnPause([&] { owner_.OnPause(); });
  }

  void PauseMachine() {
    StopTicks();
    waits_ = false;
    if (!machine_) return;
    const std::size_t waiting = machine_->waiting_commands();
    machine_->Pause();
    if (machine_->waiting_commands() == waiting) return;
    owner_.Log(LogLevel::kWarning, "paused; commands dropped from its queue: " +
                                       std::to_string(waiting - machine_->waiting_commands()));
  }

  // Calls a hook of the tick. An exception counts as a failed state; it is logged once as long as
  // it is the same.
  bool GuardTick(const char* name, std::string& last, const std::function<void()>& hook) {
    const auto thrown = Thrown(name, hook);
    const bool news = thrown && *thrown != last;
    last = thrown.value_or("");
    if (!thrown) return true;
    if (news) log_(machine_->time(), LogLevel::kError, "fault: " + *thrown);
    if (GoSafe()) return false;
    Pause();
    owner_.GiveUp({kCodeFailed, *thrown + "; and there is no safe state to go to"});
    return false;
  }
  // False when there is no safe state.
  bool GoSafe() {
    const auto& states = machine_->chart().states;
    for (std::size_t i = 0; i < states.size(); ++i) {
      if (states[i].role != fsm::Role::kSafe) continue;
      const bool there = machine_->mode() == fsm::Mode::kSafeStop;
      if (!there) static_cast<void>(machine_->Force(static_cast<fsm::StateId>(i)));
      return true;
    }
    return false;
  }

  // Publishes once the state has been entered: a machine in it has a state only then.
  void PublishSoon() {
    ticks_.Post([this] { Publish(); });
  }
  void Publish() {
    if (!ticks_.open()) return;
    std::string path = machine_->Path();
    if (published_ == path) return;
    publish_state_({path});
    published_ = std::move(path);
  }

  FsmActuator& owner_;
  Options options_;
  std::unique_ptr<fsm::Machine> machine_;
  std::function<void(const msg::String&)> publish_state_;  // while the ticks are open
  bool commanded_ = false;                                 // to begin, since SetUp
  bool started_ = false;                                   // since SetUp, or START
  bool ended_ = false;                                     // by itself, since START
  bool waits_ = false;                                     // for START, in Active
  bool in_tick_ = false;
  std::string before_fault_;  // the exception of BeforeTick() in the last tick
  std::string after_fault_;
  std::optional<std::string> published_;
  LimitedLog log_;
};

FsmActuator::FsmActuator(const std::string& actuator_name, Options options)
    : MachineActuator(actuator_name), impl_(std::make_unique<Impl>(*this, std::move(options))) {
  RegisterStateCallback([this](const State& state) { return impl_->Run(state); });
}

FsmActuator::~FsmActuator() {
  CheckStopped(name(), started());
}

fsm::Machine& FsmActuator::machine() {
  return impl_->OnLoop().machine();
}
Result<> FsmActuator::Send(std::string_view command) {
  return impl_->OnLoop().Send(command);
}
Result<> FsmActuator::CheckTicking() const {
  return impl_->OnLoop().CheckTicking();
}
bool FsmActuator::ticking() const {
  return impl_->OnLoop().ticking();
}
Time FsmActuator::Now() const {
  return impl_->OnLoop().Now();
}
msg::Stamp FsmActuator::Stamp() const {
  return impl_->OnLoop().Stamp();
}
Result<> FsmActuator::CheckNotLate() const {
  return impl_->OnLoop().CheckNotLate();
}

void FsmActuator::OnEmergencyStop() {
  impl_->OnEmergencyStop();
}

}  // namespace musher
