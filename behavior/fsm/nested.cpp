#include "musher/behavior/fsm/nested.hpp"

#include <algorithm>
#include <utility>

#include "musher/base/check.hpp"

namespace musher::fsm {
namespace {

std::vector<Nested::Region> One(std::unique_ptr<Machine> inner, std::string start) {
  std::vector<Nested::Region> regions;
  regions.push_back({std::move(inner), std::move(start)});
  return regions;
}

}  // namespace

Nested::Nested(std::unique_ptr<Machine> inner, std::string start)
    : Nested(std::move(inner), std::move(start), Options{}) {}

Nested::Nested(std::unique_ptr<Machine> inner, std::string start, Options options)
    : Nested(One(std::move(inner), std::move(start)), std::move(options)) {}

Nested::Nested(std::vector<Region> regions, Options options) : options_(std::move(options)) {
  MUSHER_CHECK(!regions.empty());
  for (Region& region : regions) {
    MUSHER_CHECK(region.machine != nullptr);
    machines_.push_back(std::move(region.machine));
    places_.push_back({.start = std::move(region.start)});
  }
}

Nested::~Nested() = default;

void Nested::Declare(Transitions& transitions) {
  for (std::size_t i = 0; i < machines_.size(); ++i) {
    if (places_[i].built) continue;  // Build() of the outer machine may be repeated
    if (const Result<> built = machines_[i]->Build(places_[i].start); !built)
      return transitions.Refuse(built.error().message);
    places_[i].built = true;
  }
  RefuseSameNames(transitions);
  if (!options_.finished.empty()) {
    finished_transition_ = transitions.To(options_.finished, "finished");
    const auto is_final = [](const Chart::Node& node) { return node.role == Role::kFinal; };
    for (const auto& machine : machines_) {
      if (std::ranges::any_of(machine->chart().states, is_final)) continue;
      transitions.Refuse("never goes to " + options_.finished + ": " + machine->name() +
                         " has no final state");
    }
  }
  for (const auto& machine : machines_) {
    for (std::size_t i = 0; i < machine->event_count(); ++i) {
      const auto event = static_cast<EventId>(i);
      const std::optional<EventId> outer = transitions.Find(machine->Name(event));
      if (!outer) continue;
      if (machine->events_[i].type != machine->around_->events_[Index(*outer)].type) {
        transitions.Refuse("event " + std::string(machine->Name(event)) + " of " + machine->name() +
                           " carries other data than around it");
      }
      std::vector<EventId>& events = machine->by_outer_;
      events.resize(std::max(events.size(), Index(*outer) + 1), kNoEvent);
      events[Index(*outer)] = event;
    }
  }
}

// The path of a state names its state, not its machine.
void Nested::RefuseSameNames(Transitions& transitions) const {
  for (std::size_t m = 1; m < machines_.size(); ++m) {
    for (const Chart::Node& node : machines_[m]->chart().states) {
      for (std::size_t before = 0; before < m; ++before) {
        if (!machines_[before]->FindState(node.name)) continue;
        transitions.Refuse("both " + machines_[before]->name() + " and " + machines_[m]->name() +
                           " have a state " + node.name);
      }
    }
  }
}

void Nested::OnEnter(const Tick& tick) {
  for (std::size_t i = 0; i < machines_.size(); ++i) {
    Machine& machine = *machines_[i];
    const Machine::Entry entry = std::exchange(machine.entry_, {});
    const bool by_history = options_.resumes || entry.into != Into::kStart;
    StateId at =
        by_history ? places_[i].left_in.value_or(machine.chart().start) : machine.chart().start;
    Machine::Entry below;
    if (entry.route != nullptr) {
      at = entry.route->down[entry.depth].state;
      below = {.route = entry.route, .depth = entry.depth + 1};
    } else if (entry.into == Into::kDeepHistory && places_[i].left_in) {
      below.into = Into::kDeepHistory;
    }
    if (!machine.StartIn(at, Time(tick.now), below)) ThrowIfStopped(machine);
  }
}

void Nested::Run(const Tick& tick) {
  for (const auto& machine : machines_) {
    if (options_.inner_first) {
      machine->RunDecided();
    } else {
      machine->RunOnce(Time(tick.now));
    }
    ThrowIfStopped(*machine);
    if (machine->requested_ != nullptr) return;  // this state is left
  }
}

Next Nested::CheckTransition(const Tick& tick) {
  if (options_.inner_first) {
    const Machine::Use use = DecideInside(tick);
    if (use == Machine::Use::kKept) return Next::Wait();
    if (use == Machine::Use::kDone) return Next::Handle();
  }
  const Next decided = Decide(tick);
  if (!decided.stays()) return decided;
  if (finished_transition_ != kNoState && finished()) {
    const Next on = Next::To(finished_transition_);
    return decided.handles() ? on : on.KeepCommand();
  }
  if (tick.command == kNoEvent || decided.handles() || decided.keeps()) return decided;
  return options_.inner_first ? decided : Pass(tick.command);
}

// What the machines inside make of the command; of none, whether one of them did something.
Machine::Use Nested::DecideInside(const Tick& tick) {
  using Use = Machine::Use;
  Use all = Use::kNothing;
  for (const auto& machine : machines_) {
    EventId event = machine->InsideOf(tick.command);
    if (machine->WordOf(event) == Machine::Word::kDefers) event = kNoEvent;
    const Use use = machine->Decide(Time(tick.now), event, machine->around_->event_data_);
    ThrowIfStopped(*machine);
    if (use == Use::kDone || all == Use::kNothing) all = use;
    if (machine->requested_ != nullptr) break;  // this state is left
  }
  return all;
}

// Passes a command to all machines inside that have it.
Next Nested::Pass(EventId command) {
  // A transition may lead to a final state, in which the command would not be handled.
  for (const auto& machine : machines_) {
    const bool has = machine->InsideOf(command) != kNoEvent;
    if (has && machine->mode() == Mode::kTransitioning) return Next::Wait();
  }
  bool passed = false;
  for (const auto& machine : machines_) {
    const EventId event = machine->InsideOf(command);
    if (event == kNoEvent || machine->WordOf(event) == Machine::Word::kDefers) continue;
    if (machine->SendData(event, machine->around_->event_data_)) passed = true;
  }
  return passed ? Next::Handle() : Next::Stay();
}

// The last one is left first, each innermost state before the one around it.
void Nested::OnExit(const Tick& /*tick*/) {
  for (std::size_t i = machines_.size(); i-- > 0;) {
    Machine& machine = *machines_[i];
    places_[i].left_in.reset();
    if (machine.running() && RoleOf(machine) == Role::kNormal) {
      places_[i].left_in = machine.current();
    }
    if (!machine.Stop()) throw InnerFault(*machine.fault());
  }
}

void Nested::Persist(Archive& archive) {
  for (std::size_t i = 0; i < machines_.size(); ++i) {
    std::optional<StateId>& left_in = places_[i].left_in;
    std::string name(left_in ? machines_[i]->Name(*left_in) : "");
    archive.Field(i == 0 ? "left_in" : "left_in " + machines_[i]->name(), name);
    left_in = machines_[i]->FindState(name);
  }
}

bool Nested::finished() const {
  return std::ranges::all_of(machines_, [](const auto& machine) {
    return machine->running() && RoleOf(*machine) == Role::kFinal;
  });
}

Role Nested::RoleOf(const Machine& machine) {
  return machine.chart().states[Index(machine.current())].role;
}

void Nested::ThrowIfStopped(const Machine& machine) {
  if (!machine.running() && machine.fault()) throw InnerFault(*machine.fault());
}

}  // namespace musher::fsm
