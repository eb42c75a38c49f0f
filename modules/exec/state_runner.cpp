#include "musher/modules/exec/state_runner.hpp"

#include <fcntl.h>

#include <chrono>
#include <cstdlib>
#include <utility>

namespace musher::exec {
namespace {

// Exit codes up to this one are keys of CyberDog's codes; higher ones are those of shells.
constexpr int kHighestKey = 99;

}  // namespace

std::string CommandText(const std::vector<std::string>& argv) {
  constexpr std::size_t kLongest = 60;
  const bool shell = argv.size() == 3 && argv[0].ends_with("sh") && argv[1] == "-c";
  std::string text = shell ? argv[2] : argv.front();
  for (std::size_t i = 1; i < argv.size() && !shell; ++i) text += ' ' + argv[i];
  return text.size() <= kLongest ? text : text.substr(0, kLongest) + "…";
}

StateRunner::StateRunner(std::string actuator, ExecConfig config, const Reaper& reaper)
    : actuator_(std::move(actuator)), config_(std::move(config)), reaper_(reaper) {}

bool StateRunner::HasCommand(const State& state) const {
  const auto found = config_.states.find(state);
  return found != config_.states.end() && !found->second.run.empty();
}

Result<> StateRunner::Run(const State& state, const StopRequested& stop_requested, bool stopped) {
  stopped_ = stopped;
  const auto found = config_.states.find(state);
  const StateActions actions = found == config_.states.end() ? StateActions() : found->second;
  if (state == kSetUp) return SetUp(actions, stop_requested);
  if (state == kTearDown) return TearDown(actions, stop_requested);
  return RunOne(state, actions, stop_requested);
}

Result<> StateRunner::RunEmergencyStop() {
  const EmergencyStopAction& action = *config_.emergency_stop;
  Result<> ran = RunStopCommand(action);
  if (action.end_program) {
    if (Result<> ended = EndProgram(); !ended) return ended;
  }
  return ran;
}

Result<> StateRunner::RunStopCommand(const EmergencyStopAction& action) {
  if (action.run.empty()) return Ok();
  const Time deadline = std::chrono::steady_clock::now() + action.time;
  const auto end =
      RunCommand(Spec(State("emergency_stop"), action.run), reaper_, config_.stop_time, [deadline] {
        return std::chrono::steady_clock::now() < deadline ? Wanted::kYes : Wanted::kNo;
      });
  if (!end) return Failure(KeyCode::kFailed, end.error().message);
  return ResultOf(
      end.value(), action.run,
      "has not ended within " + std::to_string(ToMilliseconds(action.time)) + " ms and was ended");
}

std::optional<Error> StateRunner::EndedByStop() const {
  if (!ended_by_stop_) return std::nullopt;
  return Failure(KeyCode::kStatusError,
                 "an emergency stop has ended its program; `musher restart " + actuator_ +
                     "` starts it again");
}

std::optional<ExitStatus> StateRunner::AwaitProgram() {
  const std::lock_guard lock(program_mutex_);
  if (!program_) return std::nullopt;
  program_pid_ = 0;
  return program_->Reap();
}

void StateRunner::StopProgram() {
  const std::lock_guard lock(program_mutex_);
  program_pid_ = 0;
  if (program_) program_->Stop(config_.stop_time);
}

// It is reaped at the end of this process. One that is not started yet will not be.
Result<> StateRunner::EndProgram() {
  const std::lock_guard lock(program_mutex_);
  ended_by_stop_ = true;
  return program_ ? program_->End(config_.stop_time) : Ok();
}

Result<> StateRunner::StartProgram(const std::vector<std::string>& argv) {
  const std::lock_guard lock(program_mutex_);
  if (argv.empty() || ended_by_stop_) return Ok();
  auto program = Child::Start(Spec(State(kSetUp), argv), reaper_);
  if (!program) return Failure(KeyCode::kFailed, program.error().message);
  program_.emplace(std::move(program).value());
  program_pid_ = program_->pid();
  program_watch_ = UniqueFd(fcntl(program_->pidfd(), F_DUPFD_CLOEXEC, 0));
  return Ok();
}

// It succeeds where an emergency stop has ended the program: the actuator remains, is stopped, and
// does not pass its self-check. A failure would start it again at once.
Result<> StateRunner::SetUp(const StateActions& actions, const StopRequested& stop_requested) {
  if (auto started = StartProgram(actions.start); !started) return started;
  const auto ended = [this] { return ended_by_stop_ || (program_ && program_->Ended()); };
  auto result = RunOne(State(kSetUp), actions, [&] { return stop_requested() || ended(); });
  const bool exited = program_ && program_->Ended();  // asked first: a stop says so before it ends
  if (ended_by_stop_) return Ok();
  if (exited) {
    return Failure(KeyCode::kFailed,
                   actions.start.front() + " ended during SetUp: " + AwaitProgram()->Text());
  }
  if (!result) StopProgram();
  return result;
}

Result<> StateRunner::TearDown(const StateActions& actions, const StopRequested& stop_requested) {
  tearing_down_ = true;
  auto result = RunOne(State(kTearDown), actions, stop_requested);
  if (result) StopProgram();
  tearing_down_ = result.ok();
  return result;
}

Result<> StateRunner::RunOne(const State& state, const StateActions& actions,
                             const StopRequested& stop_requested) {
  if (actions.run.empty()) return Ok();
  if (wanted_ != Wanted::kYes) return Failure(KeyCode::kStatusError, "the actuator is terminating");
  ChildSpec spec = Spec(state, actions.run);
  if (stopped_) spec.env["MUSHER_EMERGENCY_STOP"] = "1";
  const auto end = RunCommand(spec, reaper_, config_.stop_time, [&] {
    const Wanted wanted = wanted_;
    return wanted == Wanted::kYes && stop_requested() ? Wanted::kNo : wanted;
  });
  if (!end) return Failure(KeyCode::kFailed, end.error().message);
  return ResultOf(end.value(), actions.run, "was stopped, because its result is no longer needed");
}

// A command that was stopped and yet succeeded had just finished.
Result<> StateRunner::ResultOf(const CommandEnd& end, const std::vector<std::string>& argv,
                               const std::string& why_stopped) const {
  const ExitStatus& status = end.status;
  if (status.ok()) return Ok();
  const std::string reason = (end.stopped ? '`' + CommandText(argv) + "` " + why_stopped
                                          : status.Text() + " of `" + CommandText(argv) + '`') +
                             (end.last_line.empty() ? "" : "; last output: " + end.last_line);
  if (end.stopped) return Failure(KeyCode::kTimeout, reason);
  const bool is_key = !status.killed && status.number <= kHighestKey;
  return Failure(is_key ? static_cast<KeyCode>(status.number) : KeyCode::kFailed, reason);
}

ChildSpec StateRunner::Spec(const State& state, const std::vector<std::string>& argv) const {
  ChildSpec spec{argv, config_.cwd, config_.env};
  spec.env["MUSHER_STATE"] = state;
  spec.env["MUSHER_ACTUATOR"] = actuator_;
  // Output of a Python program is logged when it is printed, not when it exits.
  if (std::getenv("PYTHONUNBUFFERED") == nullptr) {  // NOLINT(concurrency-mt-unsafe)
    spec.env["PYTHONUNBUFFERED"] = "1";
  }
  if (const pid_t program = program_pid_; program != 0) {
    spec.env["MUSHER_PROGRAM_PID"] = std::to_string(program);
  }
  return spec;
}

Error StateRunner::Failure(KeyCode key, const std::string& message) const {
  return {config_.module + static_cast<std::int32_t>(key), message};
}

}  // namespace musher::exec
