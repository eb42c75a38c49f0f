#include "musher/behavior/skill/manager.hpp"

#include <algorithm>
#include <exception>
#include <utility>

#include "musher/base/suggest.hpp"

namespace musher::skill {
namespace {

constexpr std::int32_t kBusy = RobotCode(KeyCode::kTargetBusy);

// The run and all runs inside of it.
void AddNames(const Run& run, std::vector<std::string>& names) {
  names.push_back(run.name());
  for (const Run* inside : run.inside()) AddNames(*inside, names);
}

std::vector<std::string> NamesIn(const Run& run) {
  std::vector<std::string> names;
  AddNames(run, names);
  return names;
}

// What both steps of time may be: a clock that jumps over everything counts once.
Duration Between(Time last, Time now) {
  if (now <= last) return {};
  const auto ns = [](Time time) {
    return static_cast<std::uint64_t>(time.time_since_epoch().count());
  };
  const std::uint64_t passed = ns(now) - ns(last);
  return Duration(static_cast<std::int64_t>(std::min<std::uint64_t>(passed, kFarthestNs)));
}

Result<std::unique_ptr<Run>> MakeRun(const Entry& entry) {
  try {
    std::unique_ptr<Skill> skill = entry.make ? entry.make() : nullptr;
    if (!skill) return Error{kCodeFailed, entry.name + ": its factory returns no skill"};
    auto run = std::make_unique<Run>(entry.name, std::move(skill), entry.settings);
    if (!run->built()) return run->built().error();
    return run;
  } catch (const std::exception& thrown) {
    return Error{kCodeFailed, entry.name + ": its factory: " + thrown.what()};
  }
}

using Texts = std::vector<std::pair<std::string, std::string>>;

// Takes `timeout` out of the parameters, unless the skill has one of that name. Nullopt: it is not
// given.
Result<std::optional<Duration>> TakeTimeout(const Run& run, Texts& parameters) {
  constexpr std::string_view kTimeout = "timeout";
  constexpr double kLongestS = 1e9;
  const auto is_timeout = [&](const auto& named) { return named.first == kTimeout; };
  const auto found = std::ranges::find_if(parameters, is_timeout);
  const bool own = std::ranges::any_of(
      run.table().parameters(), [&](const auto& parameter) { return parameter.name == kTimeout; });
  if (own || found == parameters.end()) return std::optional<Duration>();
  const Result<Value> value = Parse(Kind::kNumber, found->second);
  const double* number = value ? std::get_if<double>(&value.value()) : nullptr;
  const double seconds = number == nullptr ? 0 : *number;
  if (!(seconds > 0 && seconds <= kLongestS)) {
    return Error{kCodeParametersInvalid, run.name() + ": timeout is '" +
                                             found->second.substr(0, 40) +
                                             "'; expected seconds, more than 0"};
  }
  std::erase_if(parameters, is_timeout);
  return std::optional(FromSeconds(seconds));
}

class InStep {
 public:
  explicit InStep(bool& flag) : flag_(flag), before_(std::exchange(flag, true)) {}
  ~InStep() { flag_ = before_; }
  InStep(const InStep&) = delete;
  InStep& operator=(const InStep&) = delete;

 private:
  bool& flag_;
  const bool before_;
};

}  // namespace

Manager::Manager(std::vector<Entry> entries) : entries_(std::move(entries)) {}

Manager::~Manager() = default;

Result<const Entry*> Manager::Lookup(std::string_view skill) const {
  const auto found = std::ranges::find(entries_, skill, &Entry::name);
  if (found == entries_.end()) {
    return Error{kCodeParametersInvalid, NoSuch("skill", skill, Names())};
  }
  return &*found;
}

// A run of the skill that has not begun.
Result<std::unique_ptr<Run>> Manager::Make(std::string_view skill) const {
  const Result<const Entry*> entry = Lookup(skill);
  if (!entry) return entry.error();
  return MakeRun(*entry.value());
}

Result<> Manager::Allowed(std::string_view skill) const {
  if (!in_step_) return Ok();
  return Error{
      kCodeStateInvalid,
      std::string(skill) + ": skills are not started, paused, cancelled or reset within a step"};
}

// None of its skills runs, and no running skill uses one of these parts of the robot. Those that
// are paused by a request use none.
Result<> Manager::Free(const Run& run, const std::vector<std::string>& parts) const {
  const std::vector<std::string> wanted = NamesIn(run);
  for (const auto& other : runs_) {
    if (!other->running() || other.get() == &run) continue;
    for (const std::string& name : NamesIn(*other)) {
      if (std::ranges::find(wanted, name) == wanted.end()) continue;
      std::string message = name + " is running already";
      if (name != other->name()) message += ", as a part of " + other->name();
      if (name != run.name()) message += "; " + run.name() + " needs it";
      return Error{kBusy, message};
    }
    if (other->pause_requested()) continue;
    const std::vector<std::string> used = other->parts();
    if (const std::string* part = SharedPart(parts, used)) {
      return Error{kBusy, run.name() + " needs the " + *part + ", which " + other->name() +
                              " is using; cancel " + other->name() + " first or wait for its end"};
    }
  }
  return Ok();
}

Result<> Manager::Begin(std::unique_ptr<Run> run, const Values& parameters, Origin origin) {
  const Result<Values> complete = run->table().Complete(parameters);
  const auto parts = run->table().PartsFor(complete ? complete.value() : parameters);
  if (Result<> free = Free(*run, parts); !free) return free;
  if (Result<> begun = run->Begin(parameters); !begun) return begun;
  Remove(run->name());
  run->origin_ = std::move(origin);
  Keep(std::move(run));
  if (changed_) changed_(*runs_.back(), runs_.back()->history().back());
  return Ok();
}

void Manager::Keep(std::unique_ptr<Run> run) {
  run->number_ = ++last_number_;
  run->changed_ = [this](const Run& of, const Change& change) {
    if (changed_) changed_(of, change);
  };
  runs_.push_back(std::move(run));
}

Result<> Manager::Start(std::string_view skill, const Values& parameters, Origin origin) {
  if (Result<> allowed = Allowed(skill); !allowed) return allowed;
  Result<std::unique_ptr<Run>> run = Make(skill);
  if (!run) return run.error();
  return Begin(std::move(run).value(), parameters, std::move(origin));
}

Result<> Manager::StartWithTexts(std::string_view skill, const Texts& parameters, Origin origin) {
  if (Result<> allowed = Allowed(skill); !allowed) return allowed;
  Result<std::unique_ptr<Run>> run = Make(skill);
  if (!run) return run.error();
  Texts given = parameters;
  const auto timeout = TakeTimeout(*run.value(), given);
  if (!timeout) return timeout.error();
  if (timeout.value()) {
    Entry limited = *Lookup(skill).value();
    limited.settings.run = *timeout.value();
    run = MakeRun(limited);
    if (!run) return run.error();
  }
  const Run& made = *run.value();
  const Result<Values> values = made.table().Parse(given);
  if (!values) return Error{values.error().code, made.name() + ": " + values.error().message};
  return Begin(std::move(run).value(), values.value(), std::move(origin));
}

void Manager::RunOnce(Time now) {
  if (in_step_) return;
  const InStep guard(in_step_);
  const Duration step = Between(last_.value_or(now), now);
  last_ = now;
  for (const auto& run : runs_) run->Step(step);
}

void Manager::Pause() {
  if (in_step_) return;
  const InStep guard(in_step_);
  last_.reset();
  for (const auto& run : runs_) run->Pause();
}

Result<> Manager::Pause(std::string_view skill, const std::string& why) {
  const Result<Run*> run = Running(skill);
  if (!run) return run.error();
  const InStep guard(in_step_);
  return run.value()->PauseUntilResumed(why);
}

Result<> Manager::Resume(std::string_view skill) {
  const Result<Run*> found = Running(skill);
  if (!found) return found.error();
  Run& run = *found.value();
  if (run.pause_requested()) {
    if (const Result<> free = Free(run, run.parts()); !free) {
      return Error{free.error().code, run.name() + " stays paused: " + free.error().message};
    }
  }
  const InStep guard(in_step_);
  return run.Resume();
}

Result<Run*> Manager::Running(std::string_view skill) const {
  if (Result<> allowed = Allowed(skill); !allowed) return allowed.error();
  const Result<const Entry*> entry = Lookup(skill);
  if (!entry) return entry.error();
  const auto found = std::ranges::find(
      runs_, skill, [](const auto& run) -> std::string_view { return run->name(); });
  if (found == runs_.end() || !(*found)->running()) {
    return Error{kCodeStateInvalid, std::string(skill) + " does not run"};
  }
  return found->get();
}

Result<> Manager::Cancel(std::string_view skill, const std::string& why) {
  const Result<Run*> run = Running(skill);
  if (!run) return run.error();
  const InStep guard(in_step_);  // it may end, and calls its skill then
  run.value()->Cancel(why);
  return Ok();
}

Result<> Manager::CancelNow(std::string_view skill, const std::string& why) {
  const Result<Run*> run = Running(skill);
  if (!run) return run.error();
  const InStep guard(in_step_);
  run.value()->CancelNow(why);
  return Ok();
}

Result<> Manager::FailNow(std::string_view skill, const std::string& why) {
  const Result<Run*> run = Running(skill);
  if (!run) return run.error();
  const InStep guard(in_step_);
  run.value()->FailNow(why);
  return Ok();
}

void Manager::CancelAll(const std::string& why) {
  const InStep guard(in_step_);
  for (const auto& run : runs_) run->Cancel(why);
}

void Manager::CancelAllNow(const std::string& why) {
  if (in_step_) return CancelAll(why);
  const InStep guard(in_step_);
  for (const auto& run : runs_) run->CancelNow(why);
}

void Manager::Remove(std::string_view skill) {
  const Run* removed = Find(skill);
  if (removed != nullptr && removal_) removal_(*removed);
  std::erase_if(runs_, [&](const auto& run) { return run->name() == skill; });
}

Result<> Manager::Reset(std::string_view skill) {
  if (Result<> allowed = Allowed(skill); !allowed) return allowed;
  const Result<const Entry*> entry = Lookup(skill);
  if (!entry) return entry.error();
  if (Running(skill)) static_cast<void>(CancelNow(skill, "it is reset"));
  Remove(skill);
  return Ok();
}

void Manager::ResetAll() {
  if (in_step_) return;
  CancelAllNow("all skills are reset");
  while (!runs_.empty()) Remove(std::string(runs_.back()->name()));
}

const Run* Manager::Find(std::string_view skill) const {
  const auto found = std::ranges::find(
      runs_, skill, [](const auto& run) -> std::string_view { return run->name(); });
  return found == runs_.end() ? nullptr : found->get();
}

std::vector<const Run*> Manager::Runs() const {
  std::vector<const Run*> runs;
  runs.reserve(runs_.size());
  for (const auto& run : runs_) runs.push_back(run.get());
  return runs;
}

bool Manager::running() const {
  return std::ranges::any_of(runs_, [](const auto& run) { return run->running(); });
}

std::optional<std::string> Manager::StateOf(std::string_view skill) const {
  if (const Run* run = Find(skill)) return run->Path();
  if (!Lookup(skill)) return std::nullopt;
  return "IDLE";
}

std::vector<std::string> Manager::Names() const {
  std::vector<std::string> names;
  names.reserve(entries_.size());
  for (const Entry& entry : entries_) names.push_back(entry.name);
  return names;
}

}  // namespace musher::skill
