#include "musher/behavior/fsm/machine.hpp"

#include <algorithm>
#include <array>
#include <exception>
#include <stdexcept>
#include <utility>

#include "musher/base/check.hpp"
#include "musher/base/suggest.hpp"
#include "musher/behavior/fsm/check.hpp"
#include "musher/behavior/fsm/nested.hpp"

namespace musher::fsm {
namespace {

template <class Id, class Things>
std::optional<Id> Find(const Things& things, std::string_view name) {
  const auto found = std::ranges::find(
      things, name, [](const auto& thing) -> std::string_view { return thing.name; });
  if (found == things.end()) return std::nullopt;
  return static_cast<Id>(found - things.begin());
}

template <class Things>
std::string Unknown(std::string_view kind, std::string_view name, const Things& things) {
  std::vector<std::string_view> names;
  names.reserve(things.size());
  for (const auto& thing : things) names.push_back(thing.name);
  return "there is no " + std::string(kind) + " " + std::string(name) + DidYouMean(name, names);
}

// Names are used in paths ("SHOW/PHOTO") and in lines of text.
std::optional<std::string> NameFault(const std::string& kind, const std::string& name) {
  if (name.empty()) return (kind == "event" ? "an " : "a ") + kind + " has no name";
  const bool plain = std::ranges::all_of(
      name, [](char c) { return c != '/' && c != 0x7f && static_cast<unsigned char>(c) >= 0x20; });
  if (plain) return std::nullopt;
  return kind + " " + name + ": a name has no slash and no control characters";
}

Error CallError(const std::string& machine, const char* why) {
  return {kCodeFailed, machine + ": " + why};
}

// The text of the exception that is being handled.
std::string WhatWasThrown() {
  try {
    throw;
  } catch (const std::exception& thrown) {
    return thrown.what();
  } catch (...) {
    return "threw something that is not a std::exception";
  }
}

constexpr const char* kInTick = "a state or a listener cannot change the machine; it may Send()";

}  // namespace

// While this exists, calls that change the machine fail.
class Machine::InTick {
 public:
  explicit InTick(Machine& machine, TickKind ticking = TickKind::kAny) : machine_(machine) {
    machine_.ticking_ = ticking;
  }
  ~InTick() {
    if (machine_.ticking_ != TickKind::kNoPlainNext) machine_.ticking_ = TickKind::kNo;
  }
  InTick(const InTick&) = delete;
  InTick& operator=(const InTick&) = delete;

 private:
  Machine& machine_;
};

// --- the build: states, events, checks and the chart of all that they declare ---

// Collects the declarations of one state.
class Machine::Declaration : public Transitions {
 public:
  Declaration(Machine& machine, StateId state) : machine_(machine), state_(state) {}

  using Transitions::To;
  StateId To(std::string_view target, std::string_view when, Into into) override {
    auto route = machine_.FindRoute(target);
    if (!route) {
      Refuse(Unknown("state", target, machine_.nodes_));
      return kNoState;
    }
    const MachineState last =
        route->down.empty() ? MachineState{route->at, route->to} : route->down.back();
    if (into != Into::kStart && last.machine->nodes_[Index(last.state)].inside.empty()) {
      Refuse(std::string(target) + " holds no machine, and has no history");
    }
    if (route->at != &machine_ || !route->down.empty() || into != Into::kStart) {
      return Declare(std::move(*route), when, into);
    }
    const StateId found = route->to;
    machine_.chart_.transitions.push_back({state_, found, std::string(when)});
    machine_.declared_[Index(state_) * machine_.nodes_.size() + Index(found)] = 1;
    return found;
  }
  EventId On(std::string_view event) override {
    const auto found = machine_.FindEvent(event);
    if (!found) {
      Refuse(Unknown("event", event, machine_.events_));
      return kNoEvent;
    }
    Note(machine_.nodes_[Index(state_)].handles, *found);
    return *found;
  }
  EventId OnType(std::string_view event, const EventType* type) override {
    const EventId found = On(event);
    if (found == kNoEvent || machine_.events_[Index(found)].type == type) return found;
    Refuse("event " + std::string(event) + " carries other data than this state expects");
    return kNoEvent;
  }
  EventId Defer(std::string_view event) override {
    const auto found = machine_.FindEvent(event);
    if (!found) {
      Refuse(Unknown("event", event, machine_.events_));
      return kNoEvent;
    }
    Note(machine_.nodes_[Index(state_)].defers, *found);
    for (Machine* machine = &machine_; machine != nullptr; machine = machine->around_) {
      machine->defers_any_ = true;
    }
    return *found;
  }
  std::optional<EventId> Find(std::string_view event) const override {
    return machine_.FindEvent(event);
  }
  // Each line becomes an error of this state.
  void Refuse(std::string_view why) override {
    const std::size_t end = why.find('\n');
    const std::string state(machine_.Name(state_));
    machine_.errors_.push_back(state + ": " + std::string(why.substr(0, end)));
    if (end != std::string_view::npos) Refuse(why.substr(end + 1));
  }

 private:
  static void Note(std::vector<EventId>& events, EventId event) {
    if (std::ranges::find(events, event) == events.end()) events.push_back(event);
  }
  StateId Declare(Route route, std::string_view when, Into into) {
    route.from = state_;
    route.into = into;
    route.name = route.target;
    if (into != Into::kStart) route.name += into == Into::kHistory ? "/H" : "/H*";
    const StateId to = route.at == &machine_ ? route.to : kNoState;
    machine_.chart_.transitions.push_back({state_, to, std::string(when), route.target, into});
    machine_.routes_.push_back(std::move(route));
    return static_cast<StateId>(machine_.nodes_.size() + machine_.routes_.size() - 1);
  }

  Machine& machine_;
  const StateId state_;
};

Machine::Machine(Options options)
    : options_(std::move(options)),
      commands_(std::max<std::size_t>(1, options_.commands)),
      history_(options_.history) {}

Machine::~Machine() = default;

StateId Machine::Add(std::string name, std::unique_ptr<State> state, Role role) {
  MUSHER_CHECK(!built_ && state != nullptr);
  if (const auto fault = NameFault("state", name)) errors_.push_back(*fault);
  if (FindState(name)) errors_.push_back(name + ": registered twice");
  if (role == Role::kSafe && safe_ != kNoState) {
    errors_.push_back(name + ": a second safe state; " + std::string(Name(safe_)) + " is one");
  }
  const auto id = static_cast<StateId>(nodes_.size());
  MUSHER_CHECK(id < kNoState);
  if (role == Role::kSafe) safe_ = id;
  const auto inside = state->inside();
  for (const auto& machine : inside) {
    machine->around_ = this;
    machine->around_state_ = id;
  }
  nodes_.push_back({std::move(name), std::move(state), role, inside});
  return id;
}

EventId Machine::AddEvent(std::string name, Urgency urgency, const EventType* type) {
  MUSHER_CHECK(!built_);
  if (const auto fault = NameFault("event", name)) errors_.push_back(*fault);
  if (FindEvent(name)) errors_.push_back("event " + name + ": registered twice");
  events_.push_back({std::move(name), urgency, type});
  return static_cast<EventId>(events_.size() - 1);
}

void Machine::AddSafetyCheck(std::string name, std::function<bool(const Tick&)> is_safe) {
  MUSHER_CHECK(!built_ && is_safe);
  if (FindCheck(name)) errors_.push_back("safety check " + name + ": registered twice");
  checks_.push_back({std::move(name), std::move(is_safe)});
}

void Machine::AddData(std::string name, std::function<void(Archive&)> persist) {
  MUSHER_CHECK(!built_ && persist);
  if (Find<std::size_t>(data_, name)) errors_.push_back("data " + name + ": registered twice");
  data_.push_back({std::move(name), std::move(persist)});
}

void Machine::DeclareStates() {
  declared_.assign(nodes_.size() * nodes_.size(), 0);
  routes_.clear();
  first_route_ = nodes_.size();
  chart_ = {.name = options_.name, .states = {}, .transitions = {}, .start = kNoState};
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    Declaration transitions(*this, static_cast<StateId>(i));
    nodes_[i].handles.clear();
    nodes_[i].defers.clear();
    const InTick guard(*this);  // a state that calls its machine here gets an error
    try {
      nodes_[i].state->Declare(transitions);
    } catch (const std::exception& thrown) {
      transitions.Refuse(std::string("Declare: ") + thrown.what());
    }
    chart_.states.push_back({nodes_[i].name, nodes_[i].role, {}});
    for (const auto& inside : nodes_[i].inside) {
      chart_.states.back().inside.push_back(inside->chart());
    }
    for (const EventId event : nodes_[i].handles) {
      chart_.states.back().handles.emplace_back(Name(event));
    }
    for (const EventId event : nodes_[i].defers) {
      chart_.states.back().defers.emplace_back(Name(event));
    }
  }
}

// A target of `from` by Name(): a state, or the end of a route.
std::optional<StateId> Machine::FindTarget(StateId from, std::string_view name) const {
  if (const auto state = FindState(name)) return state;
  for (std::size_t i = 0; i < routes_.size(); ++i) {
    if (routes_[i].from != from || routes_[i].name != name) continue;
    return static_cast<StateId>(nodes_.size() + i);
  }
  return std::nullopt;
}

// The steps to a state by its path from this machine down; the machines inside need not be built.
std::optional<std::vector<Machine::MachineState>> Machine::FindBelow(std::string_view path) {
  const std::size_t slash = path.find('/');
  const auto found = FindState(path.substr(0, slash));
  if (!found) return std::nullopt;
  const MachineState step{this, *found};
  if (slash == std::string_view::npos) return std::vector{step};
  for (const auto& inside : nodes_[Index(*found)].inside) {
    auto steps = inside->FindBelow(path.substr(slash + 1));
    if (!steps) continue;
    steps->insert(steps->begin(), step);
    return steps;
  }
  return std::nullopt;
}

// From a state of this machine to `target`, as Transitions::To() searches it.
std::optional<Machine::Route> Machine::FindRoute(std::string_view target) {
  Machine* first = this;  // where the path of the target begins
  if (target.starts_with('/')) {
    target.remove_prefix(1);
    while (first->around_ != nullptr) first = first->around_;
  }
  const std::string_view name = target.substr(0, target.find('/'));
  while (first != nullptr && !first->FindState(name)) first = first->around_;
  auto steps = first == nullptr ? std::nullopt : first->FindBelow(target);
  if (!steps) return std::nullopt;
  for (const Machine* below = first; below->around_ != nullptr; below = below->around_) {
    steps->insert(steps->begin(), {below->around_, below->around_state_});
  }
  Route route{kNoState, this, nullptr, kNoState, {}, Into::kStart, {}, {}};
  const auto is_around = [this](const Machine* machine) {
    const Machine* around = this;
    while (around != nullptr && around != machine) around = around->around_;
    return around != nullptr;
  };
  for (const MachineState& step : *steps) {
    route.target +=
        (route.target.empty() ? "" : "/") + step.machine->nodes_[Index(step.state)].name;
    if (is_around(step.machine)) {
      route.at = step.machine;
      route.to = step.state;
    } else {
      route.down.push_back(step);
    }
  }
  return route;
}

const Machine::Route* Machine::RouteOf(StateId target) const {
  if (Index(target) < first_route_) return nullptr;
  const std::size_t index = Index(target) - first_route_;
  return index < routes_.size() ? &routes_[index] : nullptr;
}

void Machine::CheckAll(std::string_view start) {
  if (nodes_.empty()) {
    errors_.emplace_back("no states are registered");
  } else if (const auto found = FindState(start)) {
    chart_.start = *found;
  } else {
    errors_.push_back("the start state: " + Unknown("state", start, nodes_));
  }
  if (!checks_.empty() && safe_ == kNoState) {
    errors_.push_back("the safety check " + checks_.front().name + " has no safe state to go to");
  }
  if (!errors_.empty()) return;  // missing states would look like dead ends
  for (const Problem& problem : Check(chart_, Place())) {
    auto& lines = problem.severity == Severity::kError ? errors_ : warnings_;
    lines.push_back(problem.where + ": " + problem.what);
  }
}

Result<> Machine::Build(std::string_view start) {
  MUSHER_CHECK(!built_);
  const std::size_t registered = errors_.size();  // the errors found before Build()
  warnings_.clear();
  DeclareStates();
  CheckAll(start);
  if (errors_.empty()) {
    built_ = true;
    return Ok();
  }
  std::string all;
  for (const std::string& fault : errors_) {
    all += (all.empty() ? "" : "\n") + options_.name + ": " + fault;
  }
  errors_.resize(registered);
  return Error{kCodeFailed, all};
}

// --- names, listeners and texts ---

bool Machine::Declared(StateId from, StateId to) const {
  if (Index(to) >= first_route_) [[unlikely]] {
    const Route* const route = RouteOf(to);
    return route != nullptr && route->from == from;
  }
  return declared_[Index(from) * first_route_ + Index(to)] != 0;
}

Result<EventId> Machine::EventOf(std::string_view event) const {
  const auto found = FindEvent(event);
  if (!found) return Error{kCodeFailed, name() + ": " + Unknown("event", event, events_)};
  return *found;
}

Result<> Machine::Send(std::string_view event) {
  const Result<EventId> found = EventOf(event);
  return found ? Send(found.value()) : found.error();
}

std::shared_ptr<EventData> Machine::NewData(EventId event) const {
  const EventType* const type =
      Index(event) < events_.size() ? events_[Index(event)].type : nullptr;
  return type == nullptr ? nullptr : type->make();
}

Result<> Machine::Force(std::string_view target) {
  const auto found = FindState(target);
  if (!found) return Error{kCodeFailed, name() + ": " + Unknown("state", target, nodes_)};
  return Force(*found);
}

void Machine::Listen(Listener* listener) {
  MUSHER_CHECK(listener != nullptr);
  listeners_.push_back(listener);
}

void Machine::Forget(Listener* listener) {
  std::ranges::replace(listeners_, listener, nullptr);
  if (!in_tick()) std::erase(listeners_, nullptr);
}

void Machine::ListenToInputs(InputListener* listener) {
  MUSHER_CHECK(listener != nullptr);
  input_listeners_.push_back(listener);
  EndPlain();
}

void Machine::ForgetInputs(InputListener* listener) {
  std::ranges::replace(input_listeners_, listener, nullptr);
  if (!in_tick()) std::erase(input_listeners_, nullptr);
}

std::optional<StateId> Machine::FindState(std::string_view name) const {
  return Find<StateId>(nodes_, name);
}

std::optional<EventId> Machine::FindEvent(std::string_view name) const {
  return Find<EventId>(events_, name);
}

bool Machine::IsUrgent(std::string_view event) const {
  const auto found = FindEvent(event);
  return found && events_[Index(*found)].urgency == Urgency::kUrgent;
}

std::optional<std::size_t> Machine::FindCheck(std::string_view name) const {
  return Find<std::size_t>(checks_, name);
}

std::string_view Machine::Name(StateId state) const {
  if (Index(state) < nodes_.size()) return nodes_[Index(state)].name;
  const Route* const route = RouteOf(state);
  return route == nullptr ? std::string_view() : route->name;
}

std::string_view Machine::Name(EventId event) const {
  return Index(event) < events_.size() ? std::string_view(events_[Index(event)].name) : "";
}

std::string_view Machine::unsafe() const {
  return unsafe_ != kNoCheck ? std::string_view(checks_[unsafe_].name) : "";
}

std::string Machine::Path() const {
  if (current_ == kNoState) return "";
  std::string below;
  for (const auto& inside : nodes_[Index(current_)].inside) {
    const std::string path = inside->Path();
    if (!path.empty()) below += (below.empty() ? "" : "|") + path;
  }
  if (nodes_[Index(current_)].inside.size() > 1 && !below.empty()) below = "(" + below + ")";
  return std::string(Name(current_)) + (below.empty() ? "" : "/" + below);
}

std::string Machine::Place() const {
  if (around_ == nullptr) return "";
  const std::string place = around_->Place();
  return (place.empty() ? "" : place + "/") + std::string(around_->Name(around_state_));
}

std::string Machine::Describe(const Fault& fault) const {
  return fault.where + ": " + std::string(fsm::Name(fault.phase)) + ": " + fault.what;
}

std::string_view Name(Mode mode) {
  constexpr std::array<std::string_view, 3> kNames{"NORMAL", "TRANSITIONING", "SAFE_STOP"};
  return kNames[static_cast<std::size_t>(mode)];
}

std::string_view Name(Cause cause) {
  constexpr std::array<std::string_view, 7> kNames{"started", "decided", "forced", "reset",
                                                   "unsafe",  "fault",   "stopped"};
  return kNames[static_cast<std::size_t>(cause)];
}

std::string_view Name(Phase phase) {
  constexpr std::array<std::string_view, 6> kNames{"OnEnter",    "Run",    "CheckTransition",
                                                   "Transition", "OnExit", "safety check"};
  return kNames[static_cast<std::size_t>(phase)];
}

// --- the run: ticks, transitions, and the handling of a failed state ---

// Calls a function of the current state; false when it threw, which has then been handled.
template <class Call>
bool Machine::Guard(Phase phase, Call&& call) {
  try {
    call();
    return true;
  } catch (...) {
    FailByException(phase);
    return false;
  }
}

// Fails with the exception that is being handled.
void Machine::FailByException(Phase phase) {
  try {
    throw;
  } catch (const InnerFault& inner) {
    Note(inner.fault().phase, inner.fault().what, inner.fault().where);
    LeaveFailed(phase);
  } catch (...) {
    Fail(phase, WhatWasThrown());
  }
}

// By index: a listener may remove itself, or add another, which gets the following calls.
template <class Interface, class Call>
void Machine::NotifyAll(const std::vector<Interface*>& listeners, Call&& call) {
  const std::size_t count = listeners.size();
  for (std::size_t i = 0; i < count; ++i) {
    if (listeners[i] == nullptr) continue;
    try {
      call(*listeners[i]);
    } catch (...) {
      ++counts_.listener_faults;
    }
  }
}

// Machine time stops at its maximum, so that no sum of times overflows.
void Machine::Advance(Time last, Time now) {
  const auto ns = [](auto time) { return static_cast<std::uint64_t>(time.count()); };
  std::uint64_t passed = 0;
  if (now > last) [[likely]] {
    passed = ns(now.time_since_epoch()) - ns(last.time_since_epoch());
  }
  tick_.step = Duration(std::min(passed, kFarthestNs - ns(tick_.now)));
  tick_.now += tick_.step;
  tick_.elapsed += tick_.step;
  ++ticks_;
}

void Machine::NotifyInput(const Input& input) {
  NotifyAll(input_listeners_, [&](InputListener& each) { each.OnInput(*this, input); });
}

Result<> Machine::StartAt(StateId state, Time now) {
  return StartIn(state, now, {});
}

Result<> Machine::StartIn(StateId state, Time now, const Entry& entry) {
  if (in_tick()) return CallError(name(), kInTick);
  if (!built_) return CallError(name(), "cannot start before Build() has succeeded");
  if (running_) return CallError(name(), "runs already");
  if (Index(state) >= nodes_.size()) return CallError(name(), "has no such state");
  const InTick guard(*this);
  NotifyInput({.kind = Input::Kind::kStart, .time = now, .state = state});
  running_ = true;
  ticks_ = 0;
  tick_ = {};
  last_tick_ = now;
  DropCommands();
  unsafe_ = kNoCheck;
  history_.Clear();
  fault_.reset();
  Enter(state, Cause::kStarted, kNoEvent, entry);
  return Reached(state);
}

void Machine::Pause() {
  if (in_tick() || !running_) return;
  const InTick guard(*this);
  NotifyInput({.kind = Input::Kind::kPause});
  last_tick_.reset();
  DropNormalCommands();
}

// All but the urgent ones, here and in the machines inside.
void Machine::DropNormalCommands() {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < waiting_; ++i) {
    if (events_[Index(Queued(i).event)].urgency != Urgency::kUrgent) continue;
    if (i != kept) Queued(kept) = std::move(Queued(i));
    ++kept;
  }
  counts_.superseded += waiting_ - kept;
  waiting_ = kept;
  if (current_ == kNoState) return;
  for (const auto& inside : nodes_[Index(current_)].inside) inside->DropNormalCommands();
}

// [[unlikely]] moves rare code out of the path of the common tick: the state decides to stay, and
// runs. What ends a tick otherwise is called last, and has its own InTick: an InTick and a frame
// here would cost each tick.
void Machine::RunOnce(Time now) {
  if (ticking_ != TickKind::kNoPlainNext) [[unlikely]] {
    return RunAny(now);
  }
  ticking_ = TickKind::kPlain;
  Advance(std::exchange(*last_tick_, now), now);
  Next next = Next::Stay();
  try {
    next = present_->CheckTransition(tick_);
  } catch (...) {
    return FinishFailed(Phase::kCheck);
  }
  if (ticking_ != TickKind::kPlain) [[unlikely]] {
    return FinishAny(next);
  }
  if (!next.stays()) [[unlikely]] {
    return Finish(next);
  }
  try {
    present_->Run(tick_);
  } catch (...) {
    return FinishFailed(Phase::kRun);
  }
  if (ticking_ != TickKind::kPlain) [[unlikely]] {
    return FinishRun();
  }
  ticking_ = TickKind::kNoPlainNext;
}

// The rest of a plain tick, where the state goes elsewhere. There is no command, and no safety
// check. All of it is in line here: the frames of its functions would take as long as the work in
// them.
[[gnu::flatten]] void Machine::Finish(Next next) {
  const InTick guard(*this, TickKind::kPlain);
  Begin(next);
  if (ticking_ == TickKind::kPlain) [[likely]] {
    ticking_ = TickKind::kNoPlainNext;
    return;
  }
  use_ = Use::kDone;
  EndTick();
}

// The same where the check of the state has sent something.
void Machine::FinishAny(Next next) {
  const InTick guard(*this);
  use_ = Use::kDone;
  stays_ = Conclude(next);
  if (stays_) Run();
  EndTick();
}

// The same where the state has run, and has sent something.
void Machine::FinishRun() {
  const InTick guard(*this);
  use_ = Use::kDone;
  EndTick();
}

// The same where the state failed with the exception that is being handled.
void Machine::FinishFailed(Phase phase) {
  const InTick guard(*this);
  FailByException(phase);
  FinishRun();
}

// A tick that may have checks, commands or a transition under way.
void Machine::RunAny(Time now) {
  if (in_tick()) {
    throw std::logic_error("RunOnce() of " + name() + " inside of its own tick does nothing");
  }
  if (!running_) return;
  const InTick guard(*this);
  if (!BeginTick(now)) return;
  stays_ = Step();
  if (stays_) Run();
  EndTick();
}

// False: it went to its safe state.
bool Machine::BeginTick(Time now) {
  NotifyInput({.kind = Input::Kind::kTick, .time = now});
  Advance(last_tick_.value_or(now), now);
  last_tick_ = now;
  if (mode_ == Mode::kTransitioning) tick_.transition_elapsed += tick_.step;
  return checks_.empty() || PassesChecks();
}

void Machine::EndTick() {
  if (requested_ != nullptr && requested_->at == this) Follow();
  if (waiting_ > 0 && options_.commands_per_tick > 1) Drain();
  if (!checks_.empty() && running_) PassesChecks();
  if (running_ && mode_ != Mode::kTransitioning && waiting_ == 0 && requested_ == nullptr &&
      checks_.empty() && input_listeners_.empty()) {
    ticking_ = TickKind::kNoPlainNext;
  }
}

// Handles further commands, as in ticks at the same time.
void Machine::Drain() {
  for (std::size_t n = 1; n < options_.commands_per_tick; ++n) {
    if (!running_ || mode_ == Mode::kTransitioning || (stays_ && use_ == Use::kKept)) return;
    if (requested_ != nullptr || FirstWaiting() == waiting_) return;
    tick_.step = {};
    RunStep();
  }
}

void Machine::RunStep() {
  stays_ = Step();
  if (stays_) Run();
  if (requested_ != nullptr && requested_->at == this) [[unlikely]] {
    Follow();
  }
}

// For a state that lets the machines inside decide first: the half of a tick until it is decided
// whether the state stays. The tick ends with RunDecided(), or with the stop of this machine.
Machine::Use Machine::Decide(Time now, EventId command, const std::shared_ptr<EventData>& data) {
  stays_ = false;
  if (!running_) return Use::kNothing;
  const InTick guard(*this);
  if (!BeginTick(now)) return command == kNoEvent ? Use::kDone : Use::kKept;
  // Its own commands come first.
  const bool busy = mode_ == Mode::kTransitioning || FirstWaiting() < waiting_;
  offered_ = busy ? kNoEvent : command;
  if (offered_ != kNoEvent) event_data_ = data;
  stays_ = Step();
  if (requested_ != nullptr && requested_->at == this) Follow();
  if (busy) return command == kNoEvent ? Use::kDone : Use::kKept;
  offered_ = kNoEvent;
  return use_;
}

void Machine::RunDecided() {
  if (!running_) return;
  const InTick guard(*this);
  if (std::exchange(stays_, false)) Run();
  if (requested_ != nullptr && requested_->at == this) Follow();
  if (!checks_.empty() && running_) PassesChecks();
}

// Whether the state stays, so that it runs.
bool Machine::Step() {
  use_ = Use::kDone;
  if (mode_ == Mode::kTransitioning) [[unlikely]] {
    Proceed();
    return false;
  }
  if (waiting_ > 0) [[unlikely]] {
    tick_.command = TakeCommand();
  }
  if (offered_ != kNoEvent) [[unlikely]] {
    tick_.command = offered_;
    tick_.data = event_data_.get();
  }
  Next next = Next::Stay();
  if (!Guard(Phase::kCheck, [&] { next = present_->CheckTransition(tick_); })) return false;
  return Conclude(next);
}

// The state has decided. Whether it stays, so that it runs.
bool Machine::Conclude(Next next) {
  if (requested_ != nullptr) [[unlikely]] {  // a state inside goes elsewhere
    const EventId command = std::exchange(tick_.command, kNoEvent);
    if (command != kNoEvent && next.keeps()) {
      use_ = Use::kKept;
      if (offered_ == kNoEvent) GiveBack(command);
    }
    return false;
  }
  if (!next.stays() || tick_.command != kNoEvent) [[unlikely]] {
    return Execute(next);
  }
  if (!next.handles()) use_ = Use::kNothing;
  return true;
}

// Executes the decision of the state, with or without a command. Whether the state stays.
bool Machine::Execute(Next next) {
  // The safe state is not left while a check fails.
  const bool held = mode_ == Mode::kSafeStop && unsafe_ != kNoCheck;
  const bool leaves = !next.stays() && !held;
  const EventId command = tick_.command;
  if (command != kNoEvent) {
    if (next.keeps()) {
      tick_.command = kNoEvent;
      if (!leaves) Keeps(command, next);
      if (offered_ == kNoEvent) GiveBack(command);
      use_ = Use::kKept;
    } else {
      kept_ = kNoEvent;
      if (!leaves && !(next.stays() && next.handles())) {
        use_ = Use::kNothing;
        if (offered_ == kNoEvent) Unhandled(command);
      }
    }
  }
  if (leaves) Begin(next);
  return !leaves;
}

// The state stays, and keeps the command.
void Machine::Keeps(EventId command, const Next& next) {
  if (next.waits() || kept_ == command) return;
  kept_ = command;
  NotifyAll(listeners_, [&](Listener& each) { each.OnKept(*this, command, current_); });
}

void Machine::Run() {
  if (Guard(Phase::kRun, [&] { present_->Run(tick_); })) tick_.command = kNoEvent;
}

// Whether every check passes. Goes to the safe state when one fails or throws.
bool Machine::PassesChecks() {
  for (const SafetyCheck& check : checks_) {
    try {
      if (check.is_safe(tick_)) continue;
    } catch (...) {
      return HandleUnsafe(check, WhatWasThrown());
    }
    return HandleUnsafe(check, std::nullopt);
  }
  if (mode_ == Mode::kSafeStop) unsafe_ = kNoCheck;
  return true;
}

// `check` failed, or threw. A machine in its safe state continues anyway.
bool Machine::HandleUnsafe(const SafetyCheck& check, const std::optional<std::string>& thrown) {
  const auto index = static_cast<std::size_t>(&check - checks_.data());
  const bool news = unsafe_ != index;
  unsafe_ = index;
  if (thrown && news) Note(Phase::kSafetyCheck, check.name + ": " + *thrown);
  if (mode_ == Mode::kSafeStop) return true;
  Switch(safe_, thrown ? Cause::kFault : Cause::kUnsafe, kNoEvent, {});
  return false;
}

void Machine::Begin(Next next) {
  if (!Declared(current_, next.target())) return FailUndeclared(next.target());
  mode_ = Mode::kTransitioning;
  cause_ = std::exchange(tick_.command, kNoEvent);
  tick_.target = next.target();
  tick_.transition_time = next.time();
  Proceed();
}

void Machine::Proceed() {
  bool done = false;
  if (!Guard(Phase::kTransition, [&] { done = present_->Transition(tick_); })) return;
  if (done) {
    GoTo(tick_.target);
    return;
  }
  EndPlain();
  if (tick_.transition_elapsed > options_.longest_transition) FailEndless();
}

// The transition of the current state is complete.
void Machine::GoTo(StateId target) {
  static constexpr Entry kByStart{};  // not to be made for each change
  const Route* const route = RouteOf(target);
  if (route == nullptr) return Switch(target, Cause::kDecided, cause_, kByStart);
  for (Machine* machine = this; machine != route->at; machine = machine->around_) {
    machine->Request(*route);
  }
  route->at->Request(*route);
}

// Goes along the requested route, which begins in this machine or in one inside.
void Machine::Follow() {
  const Route& route = *std::exchange(requested_, nullptr);
  EventId command = std::exchange(route.owner->cause_, kNoEvent);
  if (command != kNoEvent && route.owner != this) {
    command = FindEvent(route.owner->Name(command)).value_or(kNoEvent);
  }
  Switch(route.to, Cause::kDecided, command, {.route = &route});
}

// A state was left or entered meanwhile: the one that requested the route is no longer present.
void Machine::CancelRequest() {
  const Route* const route = requested_;
  for (Machine* machine = this; machine != nullptr; machine = machine->around_) {
    if (machine->requested_ == route) machine->requested_ = nullptr;
  }
}

// For the machines in the current state, before it starts them.
void Machine::SetEntries(const Entry& entry) {
  const bool on = entry.route != nullptr && entry.depth < entry.route->down.size();
  for (const auto& inside : nodes_[Index(current_)].inside) {
    if (!on) {
      inside->entry_ = {.into = entry.route == nullptr ? entry.into : entry.route->into};
    } else if (entry.route->down[entry.depth].machine == inside.get()) {
      inside->entry_ = entry;
    }
  }
}

// From the current state to `target`.
void Machine::Switch(StateId target, Cause cause, EventId command, const Entry& entry) {
  if (Guard(Phase::kExit, [&] { present_->OnExit(tick_); })) Enter(target, cause, command, entry);
}

// The current state was left, by a change with `command`, if there was one. Ends what it has left
// unfinished: the machine inside, where its function threw before it stopped that machine, and an
// aborted transition, whose command was not handled.
void Machine::EndPresent(EventId command) {
  if (holds_machines_) StopInside();
  if (requested_ != nullptr) CancelRequest();
  kept_ = kNoEvent;
  const EventId behind = std::exchange(cause_, kNoEvent);
  if (behind != kNoEvent && behind != command) Unhandled(behind);
}

void Machine::StopInside() {
  for (const auto& inside : nodes_[Index(current_)].inside) static_cast<void>(inside->Stop());
}

void Machine::SetPresent(StateId state) {
  const Node& node = nodes_[Index(state)];
  current_ = state;
  present_ = node.state.get();
  holds_machines_ = !node.inside.empty();
}

void Machine::SetAbsent() {
  current_ = kNoState;
  present_ = nullptr;
  holds_machines_ = false;
}

// The current state has been left, or there was none.
void Machine::Enter(StateId target, Cause cause, EventId command, const Entry& entry) {
  EndPresent(command);
  const Change& change = Remember(target, command, cause);
  SetPresent(target);
  tick_ = {.now = tick_.now, .step = tick_.step};
  mode_ = target == safe_ ? Mode::kSafeStop : Mode::kNormal;
  if (mode_ == Mode::kNormal) unsafe_ = kNoCheck;
  NotifyChange(change);
  if (holds_machines_) [[unlikely]] {
    return EnterInside(entry);
  }
  Guard(Phase::kEnter, [&] { present_->OnEnter(tick_); });
}

// Enters the current state, which starts the machines in it.
void Machine::EnterInside(const Entry& entry) {
  const Node& node = nodes_[Index(current_)];
  SetEntries(entry);
  Guard(Phase::kEnter, [&] { present_->OnEnter(tick_); });
  for (const auto& inside : node.inside) inside->entry_ = {};  // OnEnter may have failed before it
}

void Machine::Note(Phase phase, std::string what, const std::string& inner) {
  ++counts_.faults;
  std::string where(Name(current_));
  if (!inner.empty()) where += "/" + inner;
  fault_ = Fault{current_, phase, tick_.now, std::move(what), std::move(where)};
  NotifyAll(listeners_, [&](Listener& each) { each.OnFault(*this, *fault_); });
}

void Machine::Fail(Phase phase, std::string what) {
  Note(phase, std::move(what));
  LeaveFailed(phase);
}

void Machine::FailUndeclared(StateId target) {
  const std::string name(Name(target));
  Fail(Phase::kCheck,
       "it went to " + (name.empty() ? "an unknown state" : name) + ", which it has not declared");
}

void Machine::FailEndless() {
  Fail(Phase::kTransition,
       "the transition to " + std::string(Name(tick_.target)) + " does not end");
}

// The current state failed in `phase`. The machine goes to the safe state; where that has failed,
// or there is none, the machine stops.
void Machine::LeaveFailed(Phase phase) {
  const EventId command = std::exchange(tick_.command, kNoEvent);
  if (phase == Phase::kCheck && command != kNoEvent) Unhandled(command);
  if (safe_ == kNoState || current_ == safe_) return Halt(Cause::kFault);
  if (phase != Phase::kEnter && phase != Phase::kExit) {
    try {
      present_->OnExit(tick_);
    } catch (...) {
      ++counts_.faults;  // it is being left because it failed; the first failure is reported
    }
  }
  Enter(safe_, Cause::kFault, kNoEvent, {});
}

void Machine::Halt(Cause cause) {
  EndPresent(kNoEvent);
  DropCommands();
  const Change& change = Remember(kNoState, kNoEvent, cause);
  running_ = false;
  EndPlain();
  mode_ = cause == Cause::kFault ? Mode::kSafeStop : Mode::kNormal;
  SetAbsent();
  NotifyChange(change);
}

Result<> Machine::Stop() {
  if (in_tick()) return CallError(name(), kInTick);
  if (!running_) return Ok();
  const InTick guard(*this);
  NotifyInput({.kind = Input::Kind::kStop});
  bool left = false;
  try {
    present_->OnExit(tick_);
    left = true;
  } catch (const InnerFault& inner) {
    Note(inner.fault().phase, inner.fault().what, inner.fault().where);
  } catch (...) {
    Note(Phase::kExit, WhatWasThrown());
  }
  Halt(Cause::kStopped);
  return left ? Ok() : Failure();
}

Result<> Machine::Force(StateId target) {
  if (in_tick()) return CallError(name(), kInTick);
  if (!running_) return CallError(name(), "does not run");
  if (Index(target) >= nodes_.size()) return CallError(name(), "has no such state");
  const InTick guard(*this);
  NotifyInput({.kind = Input::Kind::kForce, .state = target});
  Switch(target, Cause::kForced, kNoEvent, {});
  return Reached(target);
}

Result<> Machine::Reset() {
  if (in_tick()) return CallError(name(), kInTick);
  if (!running_) return CallError(name(), "does not run");
  const InTick guard(*this);
  NotifyInput({.kind = Input::Kind::kReset});
  DropCommands();
  fault_.reset();
  Switch(chart_.start, Cause::kReset, kNoEvent, {});
  return Reached(chart_.start);
}

Result<> Machine::Reached(StateId target) const {
  return current_ == target ? Ok() : Failure();
}

Error Machine::Failure() const {
  return {kCodeFailed, name() + ": " + Describe(*fault_)};
}

Result<> Machine::SendData(EventId event, std::shared_ptr<EventData> data) {
  if (Index(event) >= events_.size()) return CallError(name(), "has no such event");
  if (events_[Index(event)].type != (data == nullptr ? nullptr : data->type())) {
    return Error{kCodeFailed,
                 name() + ": event " + events_[Index(event)].name +
                     (data == nullptr ? " carries data, which is missing" : " carries other data")};
  }
  if (!running_) return CallError(name(), "does not run");
  if (!in_tick()) {  // a command of a state or a listener is not an input from outside
    const InTick guard(*this);
    NotifyInput({.kind = Input::Kind::kCommand, .command = event, .data = data.get()});
  }
  EndPlain();
  if (events_[Index(event)].urgency == Urgency::kUrgent) DropCommands();
  if (waiting_ == commands_.size()) {
    ++counts_.refused;
    return Error{kCodeFailed, name() + ": " + std::to_string(waiting_) + " commands are queued; " +
                                  events_[Index(event)].name + " is refused: the queue is full"};
  }
  Queued(waiting_) = {event, std::move(data)};
  ++waiting_;
  return Ok();
}

// The oldest command that is not deferred; none: kNoEvent.
EventId Machine::TakeCommand() {
  const std::size_t first = FirstWaiting();
  if (first == waiting_) return kNoEvent;
  Command command = std::move(Queued(first));
  for (std::size_t i = first; i > 0; --i) Queued(i) = std::move(Queued(i - 1));
  event_data_ = std::move(command.data);
  tick_.data = event_data_.get();
  first_command_ = first_command_ + 1 == commands_.size() ? 0 : first_command_ + 1;
  --waiting_;
  return command.event;
}

// Its place in the queue; the number of those that wait: there is none.
std::size_t Machine::FirstWaiting() const {
  if (!defers_any_) return 0;
  std::size_t i = 0;
  while (i < waiting_ && WordOf(Queued(i).event) == Word::kDefers) ++i;
  return i;
}

Machine::Word Machine::WordOf(EventId command) const {
  if (current_ == kNoState || command == kNoEvent) return Word::kNothing;
  const Node& node = nodes_[Index(current_)];
  Word word = Word::kNothing;
  for (const auto& inside : node.inside) {
    const Word innermost = inside->WordOf(inside->InsideOf(command));
    if (innermost == Word::kHandles) return innermost;
    if (innermost == Word::kDefers) word = innermost;
  }
  if (word != Word::kNothing) return word;
  if (std::ranges::find(node.handles, command) != node.handles.end()) return Word::kHandles;
  const bool defers = std::ranges::find(node.defers, command) != node.defers.end();
  return defers ? Word::kDefers : Word::kNothing;
}

// The event of this machine by that of the machine around it.
EventId Machine::InsideOf(EventId outer) const {
  return Index(outer) < by_outer_.size() ? by_outer_[Index(outer)] : kNoEvent;
}

// Back to the front of the queue, unless an urgent command was sent meanwhile or the queue is full.
void Machine::GiveBack(EventId event) {
  const bool swept = waiting_ > 0 && events_[Index(Queued(0).event)].urgency == Urgency::kUrgent;
  if (swept || waiting_ == commands_.size()) {
    ++counts_.superseded;
    return;
  }
  first_command_ = (first_command_ == 0 ? commands_.size() : first_command_) - 1;
  commands_[first_command_] = {event, std::move(event_data_)};
  ++waiting_;
}

void Machine::Unhandled(EventId command) {
  ++counts_.unhandled;
  NotifyAll(listeners_, [&](Listener& each) { each.OnUnhandled(*this, command, current_); });
}

// The change from the current state. It stays where it is until the next one is remembered.
const Change& Machine::Remember(StateId to, EventId command, Cause cause) {
  ++counts_.changes;
  return history_.Emplace(tick_.now, ticks_, current_, to, command, cause);
}

void Machine::NotifyChange(const Change& change) {
  NotifyAll(listeners_, [&](Listener& each) { each.OnChange(*this, change); });
  if (around_ != nullptr) [[unlikely]] {
    NotifyAround(change);
  }
}

void Machine::NotifyAround(const Change& change) {
  for (Machine* outer = around_; outer != nullptr; outer = outer->around_) {
    outer->NotifyAll(outer->listeners_,
                     [&](Listener& each) { each.OnChangeInside(*outer, *this, change); });
  }
}

}  // namespace musher::fsm
