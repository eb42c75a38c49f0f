// Registration of states and events, and the names of a machine.

#include <algorithm>
#include <array>
#include <exception>
#include <utility>

#include "musher/base/check.hpp"
#include "musher/base/suggest.hpp"
#include "musher/behavior/fsm/check.hpp"
#include "musher/behavior/fsm/machine.hpp"

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

}  // namespace

// Collects the declarations of one state.
class Machine::Declaring : public Transitions {
 public:
  Declaring(Machine& machine, StateId state) : machine_(machine), state_(state) {}

  StateId To(std::string_view target, std::string_view when) override {
    const auto found = machine_.FindState(target);
    if (!found) {
      Refuse(Unknown("state", target, machine_.nodes_));
      return kNoState;
    }
    machine_.chart_.transitions.push_back({state_, *found, std::string(when)});
    machine_.declared_[Index(state_) * machine_.row_ + Index(*found) / 64] |=
        std::uint64_t{1} << (Index(*found) % 64);
    return *found;
  }
  EventId On(std::string_view event) override {
    const auto found = machine_.FindEvent(event);
    if (!found) Refuse(Unknown("event", event, machine_.events_));
    return found.value_or(kNoEvent);
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
  Machine& machine_;
  const StateId state_;
};

Machine::Machine(Options options)
    : options_(std::move(options)),
      unsafe_(0),
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
  nodes_.push_back({std::move(name), std::move(state), role});
  return id;
}

EventId Machine::AddEvent(std::string name, Urgency urgency) {
  MUSHER_CHECK(!built_);
  if (const auto fault = NameFault("event", name)) errors_.push_back(*fault);
  if (FindEvent(name)) errors_.push_back("event " + name + ": registered twice");
  events_.push_back({std::move(name), urgency});
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
  row_ = (nodes_.size() + 63) / 64;
  declared_.assign(nodes_.size() * row_, 0);
  chart_ = {.name = options_.name, .states = {}, .transitions = {}, .start = kNoState};
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    Declaring transitions(*this, static_cast<StateId>(i));
    try {
      nodes_[i].state->Declare(transitions);
    } catch (const std::exception& thrown) {
      transitions.Refuse(std::string("Declare: ") + thrown.what());
    }
    const Machine* inside = nodes_[i].state->inside();
    chart_.states.push_back({nodes_[i].name, nodes_[i].role, {}});
    if (inside != nullptr) chart_.states.back().inside.push_back(inside->chart());
  }
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
  for (const Problem& problem : Check(chart_)) {
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
    unsafe_ = checks_.size();
    return Ok();
  }
  std::string all;
  for (const std::string& fault : errors_) {
    all += (all.empty() ? "" : "\n") + options_.name + ": " + fault;
  }
  errors_.resize(registered);
  return Error{kCodeFailed, all};
}

bool Machine::Declared(StateId from, StateId to) const {
  return Index(to) < nodes_.size() &&
         (declared_[Index(from) * row_ + Index(to) / 64] >> (Index(to) % 64) & 1) != 0;
}

Result<> Machine::Send(std::string_view event) {
  const auto found = FindEvent(event);
  if (!found) return Error{kCodeFailed, name() + ": " + Unknown("event", event, events_)};
  return Send(*found);
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
  if (!in_tick_) std::erase(listeners_, nullptr);
}

std::optional<StateId> Machine::FindState(std::string_view name) const {
  return Find<StateId>(nodes_, name);
}

std::optional<EventId> Machine::FindEvent(std::string_view name) const {
  return Find<EventId>(events_, name);
}

std::optional<std::size_t> Machine::FindCheck(std::string_view name) const {
  return Find<std::size_t>(checks_, name);
}

std::string_view Machine::Name(StateId state) const {
  return Index(state) < nodes_.size() ? std::string_view(nodes_[Index(state)].name) : "";
}

std::string_view Machine::Name(EventId event) const {
  return Index(event) < events_.size() ? std::string_view(events_[Index(event)].name) : "";
}

std::string_view Machine::unsafe() const {
  return unsafe_ < checks_.size() ? std::string_view(checks_[unsafe_].name) : "";
}

std::string Machine::Path() const {
  if (current_ == kNoState) return "";
  const Machine* inside = present_->inside();
  const std::string below = inside == nullptr ? "" : inside->Path();
  return std::string(Name(current_)) + (below.empty() ? "" : "/" + below);
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

}  // namespace musher::fsm
