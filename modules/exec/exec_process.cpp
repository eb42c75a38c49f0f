#include "musher/modules/exec/exec_process.hpp"

#include <poll.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include <thread>
#include <utility>

#include "musher/cyberdog/codes/module_codes.hpp"  // names modules in texts
#include "musher/lifecycle/config/flow.hpp"

namespace musher::exec {
namespace {

UniqueFd TakeSignals() {
  static_cast<void>(std::signal(SIGPIPE, SIG_IGN));
  static_cast<void>(std::signal(SIGXFSZ, SIG_IGN));  // a log at its size limit ends no module
  sigset_t signals;
  sigemptyset(&signals);
  for (const int signal : {SIGTERM, SIGINT, SIGHUP}) sigaddset(&signals, signal);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  return UniqueFd(signalfd(-1, &signals, SFD_CLOEXEC | SFD_NONBLOCK));
}

std::string WhyNotConfirmed(const ExecConfig& config) {
  if (!config.emergency_stop) return WhyNothingStops(config);
  const std::vector<std::string>& run = config.emergency_stop->run;
  return "[emergency_stop] has not ended" + (run.empty() ? "" : ": `" + CommandText(run) + '`');
}

bool IsReadable(int fd) {
  pollfd source{fd, POLLIN, 0};
  return poll(&source, 1, 0) > 0;
}

}  // namespace

ExecProcess::ExecProcess(const std::string& actuator_name, ExecConfig config, const Reaper& reaper)
    : confirmation_(WhyNotConfirmed(config)),
      has_stop_action_(config.emergency_stop.has_value()),
      runner_(actuator_name, std::move(config), reaper),
      signals_(TakeSignals()),
      actuator_(actuator_name, [this] { OnEmergencyStop(); }) {
  actuator_.RegisterStateCallback([this](const State& state) { return RunState(state); });
}

// What switches on waits for the action of a stop that was released before its end. Without the
// program that it has ended, the commands of states that lead down still run.
Result<> ExecProcess::RunState(const State& state) {
  const bool down = state == kSetUp || state == kTearDown ||
                    Falls(actuator_.machine_config(), actuator_.CurrentState(), state);
  if (!down) stop_thread_.Flush();
  const std::optional<Error> ended = down ? std::nullopt : runner_.EndedByStop();
  Result<> result = Ok();
  if (ended) {
    result = *ended;
  } else {
    const bool stopped = BeginCommand(state);
    result = runner_.Run(
        state, [this] { return actuator_.StopRequested(); }, stopped);
    EndCommand(state == kTearDown && result.ok());  // after a TearDown nothing is left
  }
  loop_.Post([this] { EvaluateProgram(); });
  return result;
}

// EmergencyStopped() is read under the mutex: the action of a stop that is engaged later finds the
// command. SetUp and a self-check must not switch on, so a later stop is confirmed beside them.
// What switches on is not begun by the core below a stop: one that is engaged has come since.
bool ExecProcess::BeginCommand(const State& state) {
  const std::lock_guard lock(stops_mutex_);
  if (!runner_.HasCommand(state)) return false;
  const bool stopped = actuator_.EmergencyStopped();
  if (!stopped && (state == kSetUp || state == kSelfCheck)) return false;
  const bool since =
      state != kSetUp && MaySwitchOn(actuator_.machine_config(), actuator_.CurrentState(), state);
  confirmation_.BeginCommand(state, !stopped ? StopAtBegin::kNone
                                    : since  ? StopAtBegin::kSince
                                             : StopAtBegin::kBefore);
  actuator_.ReportStopTrouble(confirmation_.Trouble());
  return stopped;
}

void ExecProcess::EndCommand(bool nothing_left) {
  const std::lock_guard lock(stops_mutex_);
  if (confirmation_.EndCommand(nothing_left)) return BeginStopAction();
  actuator_.ReportStopTrouble(confirmation_.Trouble());
}

void ExecProcess::OnEmergencyStop() {
  const std::lock_guard lock(stops_mutex_);
  BeginStopAction();
}

void ExecProcess::BeginStopAction() {
  const std::uint64_t number = confirmation_.BeginAction();
  actuator_.ReportStopTrouble(confirmation_.Trouble());
  if (!has_stop_action_) return;
  stop_thread_.Do([this, number] { RunStopAction(number); }, {.key = "stop"});
}

void ExecProcess::RunStopAction(std::uint64_t number) {
  const Result<> result = runner_.RunEmergencyStop();
  const std::string error = result ? "" : "[emergency_stop]: " + result.error().message;
  if (!result) actuator_.Log(LogLevel::kError, error);
  const std::lock_guard lock(stops_mutex_);
  confirmation_.EndAction(number, error);
  actuator_.ReportStopTrouble(confirmation_.Trouble());
}

int ExecProcess::Run(const std::string& state_config) {
  if (const auto begun = actuator_.Init(state_config); !begun) {
    actuator_.Log(LogLevel::kError, begun.error().message);
    return 1;
  }
  signal_watch_ = loop_.WhenReadable(signals_.get(), [this] { OnSignal(); });
  std::thread actuator_thread([this] { RunActuator(); });
  loop_.Run();
  actuator_.Shutdown();
  actuator_thread.join();
  stop_thread_.End();
  if (program_lost_) {
    actuator_.Log(LogLevel::kWarning,
                  "the program exited by itself: " + runner_.AwaitProgram()->Text());
  }
  runner_.StopProgram();
  return *exit_code_;
}

void ExecProcess::RunActuator() {
  const auto started = actuator_.Start();
  if (!started) {
    actuator_.Log(LogLevel::kError, "not started: " + ErrorText(started.error()));
  }
  loop_.Post([this, ok = started.ok()] { OnSetUp(ok); });
  if (!started) return;
  const int exit_code = actuator_.Wait();
  loop_.Post([this, exit_code] { End(exit_code, Wanted::kNo); });
}

void ExecProcess::OnSetUp(bool ok) {
  set_up_ended_ = true;
  if (!ok) End(1, Wanted::kNo);
  if (exit_code_) return loop_.Stop();
  if (const int watch = runner_.program_watch(); watch >= 0) {
    program_watch_ = loop_.WhenReadable(watch, [this] {
      program_watch_.reset();
      EvaluateProgram();
    });
  }
}

void ExecProcess::OnSignal() {
  signalfd_siginfo signal{};
  if (read(signals_.get(), &signal, sizeof(signal)) != sizeof(signal)) return;
  // Exit code 0 would say that the TearDown had ended.
  const bool cut_off = runner_.tearing_down() && actuator_.CurrentState() != kTearDown;
  End(cut_off ? 1 : 0, Wanted::kNo);
}

// Called when the program has exited and after each callback: an exit that looked like part of
// TearDown is unexpected if that TearDown failed.
void ExecProcess::EvaluateProgram() {
  const int watch = runner_.program_watch();
  if (!set_up_ended_ || exit_code_ || watch < 0 || runner_.tearing_down()) return;
  if (runner_.EndedByStop()) return;
  if (!IsReadable(watch)) return;
  program_lost_ = true;
  End(1, Wanted::kGetDone);
}

// The first reason to end counts. During SetUp its end is awaited: it stops as well.
void ExecProcess::End(int exit_code, Wanted wanted) {
  if (exit_code_) return;
  exit_code_ = exit_code;
  runner_.Hurry(wanted);
  if (set_up_ended_) loop_.Stop();
}

}  // namespace musher::exec
