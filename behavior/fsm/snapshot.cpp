#include "musher/behavior/fsm/snapshot.hpp"

#include <algorithm>
#include <exception>
#include <utility>

namespace musher::fsm {
namespace {

template <class Persist>
void SavePart(const std::string& name, std::vector<Snapshot::Part>& parts, Persist&& persist) {
  Snapshot::Part part{name, SaveFields(persist)};
  if (!part.fields.empty()) parts.push_back(std::move(part));
}

using Faults = std::vector<SnapshotFault>;

constexpr Duration kFarthest{kFarthestNs};

}  // namespace

// --- Machine::Save() ---

// "SHOW" of the first machine inside of SHOW, "SHOW/face" of another one.
std::string Machine::InsideName(const Node& node, const Machine& inside) {
  const bool first = node.inside.front().get() == &inside;
  return first ? node.name : node.name + "/" + inside.name();
}

// The persisted fields of states and data, and the machines inside.
Result<> Machine::SaveParts(Snapshot& saved) const {
  const std::string* at = nullptr;
  try {
    for (const Data& data : data_) SavePart(*(at = &data.name), saved.data, data.persist);
    for (const Node& node : nodes_) {
      SavePart(*(at = &node.name), saved.states,
               [&](Archive& archive) { node.state->Persist(archive); });
    }
  } catch (const std::exception& thrown) {
    return Error{kCodeFailed, name() + ": " + *at + ": Persist: " + thrown.what()};
  }
  for (const Node& node : nodes_) {
    for (const auto& inside : node.inside) {
      Result<Snapshot> inner = inside->Save();
      if (!inner) {
        return Error{kCodeFailed, name() + ": " + node.name + ": " + inner.error().message};
      }
      saved.inside.push_back({InsideName(node, *inside), std::move(inner).value()});
    }
  }
  return Ok();
}

Result<Snapshot> Machine::Save() const {
  if (in_tick() || !built_) {
    return Error{kCodeFailed, name() + ": can be saved once it is built, and between ticks"};
  }
  const auto text = [this](auto id) { return std::string(Name(id)); };
  Snapshot saved;
  saved.machine = name();
  saved.running = running_;
  saved.paused = running_ && !last_tick_;
  saved.mode = mode_;
  saved.state = text(current_);
  saved.ticks = ticks_;
  saved.time = tick_.now;
  saved.step = tick_.step;
  saved.elapsed = elapsed();
  saved.unsafe = unsafe();
  if (mode_ == Mode::kTransitioning) {
    saved.transition = {text(tick_.target), text(cause_), tick_.transition_elapsed,
                        tick_.transition_time};
  }
  for (std::size_t i = 0; i < waiting_; ++i) {
    saved.commands.push_back(text(Queued(i).event));
    EventData* const data = Queued(i).data.get();
    if (data == nullptr) continue;
    SavePart(std::to_string(i), saved.command_data,
             [data](Archive& archive) { data->Persist(archive); });
  }
  saved.counts = counts_;
  if (fault_) {
    saved.fault = {text(fault_->state), fault_->phase, fault_->at, fault_->what, fault_->where};
  }
  for (std::size_t i = 0; i < history_.size(); ++i) {
    const Change& change = history_[i];
    saved.history.push_back({change.at, change.tick, text(change.from), text(change.to),
                             text(change.command), change.cause});
  }
  if (const Result<> parts = SaveParts(saved); !parts) return parts.error();
  return saved;
}

// --- Machine::Restore(): checks a snapshot, restores the fields of states and data, and only when
// all of it is valid takes over the rest ---

// Checks a snapshot against a machine, and restores it.
class Machine::Restorer {
 public:
  Restorer(Machine& machine, const Snapshot& saved, std::string prefix, Faults& faults)
      : machine_(machine), saved_(saved), prefix_(std::move(prefix)), faults_(faults) {}

  void Validate() {
    if (saved_.machine != machine_.name()) {
      return Fail("machine",
                  "it was saved from " + saved_.machine + ", not from " + machine_.name());
    }
    if (machine_.running_) return Fail("running", machine_.name() + " runs already");
    CheckState();
    EvaluateTimes();
    Events("commands", saved_.commands);
    if (std::ranges::find(saved_.commands, "") != saved_.commands.end()) {
      Fail("commands", "one has no name");
    }
    CheckCommandData();
    if (saved_.commands.size() > machine_.commands_.size()) {
      Fail("commands", "more than " + std::to_string(machine_.commands_.size()) + " cannot wait");
    }
    if (!saved_.unsafe.empty() && !machine_.FindCheck(saved_.unsafe)) {
      Fail("unsafe", "there is no safety check " + saved_.unsafe);
    }
    if (saved_.fault) State("fault.state", saved_.fault->state);
    for (std::size_t i = 0; i < saved_.history.size(); ++i) {
      const std::string key = "history[" + std::to_string(i) + "].";
      State(key + "from", saved_.history[i].from);
      State(key + "to", saved_.history[i].to);
      Events(key + "command", {saved_.history[i].command});
    }
    CheckParts("data", saved_.data);
    CheckParts("states", saved_.states);
    for (const Snapshot::Inside& inside : saved_.inside) {
      const std::string state = inside.state.substr(0, inside.state.find('/'));
      if (!machine_.FindState(state)) {
        Fail(SnapshotKey("inside", inside.state), UnknownState(state));
      }
    }
    const auto present = machine_.FindState(saved_.state);
    ForInside([&](Restorer& inside) {
      inside.Validate();
      if (!present && !saved_.state.empty()) return;
      inside.EvaluateRunning(present == inside.machine_.around_state_);
    });
  }

  // Restores states and data.
  void RestoreParts() {
    for (const Data& data : machine_.data_) GivePart("data", saved_.data, data.name, data.persist);
    for (const Node& node : machine_.nodes_) {
      GivePart("states", saved_.states, node.name,
               [&](Archive& archive) { node.state->Persist(archive); });
    }
    ForInside([](Restorer& inside) { inside.RestoreParts(); });
  }

  void Become(Time now) {
    machine_.Become(saved_, now);
    // The clock of a machine inside is the machine time of the one around it.
    ForInside([&](Restorer& inside) { inside.Become(Time(saved_.time)); });
  }

 private:
  void CheckState() {
    State("state", saved_.state);
    if (saved_.running == saved_.state.empty()) {
      Fail("state", saved_.running ? "is missing" : "is set, although the machine does not run");
    }
    if (saved_.transition) {
      const auto from = machine_.FindState(saved_.state).value_or(kNoState);
      if (!machine_.FindTarget(from, saved_.transition->to)) {
        State("transition.to", saved_.transition->to);
      }
      Events("transition.command", {saved_.transition->command});
    }
    const bool goes = saved_.mode == Mode::kTransitioning;
    if (goes && saved_.transition && saved_.transition->to.empty()) {
      Fail("transition.to", "is missing");
    }
    if (goes != saved_.transition.has_value() || (goes && !saved_.running)) {
      Fail("mode", std::string(fsm::Name(saved_.mode)) +
                       (goes ? " has a transition, which is missing" : " has no transition"));
    }
    const auto state = machine_.FindState(saved_.state);
    if (!goes && state && (saved_.mode == Mode::kSafeStop) != (*state == machine_.safe_)) {
      Fail("mode", std::string(fsm::Name(saved_.mode)) + " is not that of " + saved_.state);
    }
  }

  // A machine inside runs while the state around it is the present one.
  void EvaluateRunning(bool runs) {
    if (saved_.running == runs) return;
    Fail("running", runs ? "is false, though the state around it is the present one"
                         : "is true, though the state around it is not the present one");
  }

  void EvaluateTimes() {
    Within("time", saved_.time, kFarthest);
    Within("step", saved_.step, saved_.time);
    Within("elapsed", saved_.elapsed, saved_.time);
    if (!saved_.transition) return;
    Within("transition.elapsed", saved_.transition->elapsed, saved_.elapsed);
  }

  // From 0 to `most`.
  void Within(const std::string& key, Duration time, Duration most) {
    if (time >= Duration{} && time <= most) return;
    Fail(key, "has to be between 0 and " + std::to_string(most.count()) + " ns");
  }

  void State(const std::string& key, const std::string& name) {
    if (!name.empty() && !machine_.FindState(name)) Fail(key, UnknownState(name));
  }
  std::string UnknownState(const std::string& name) const {
    std::vector<std::string> known;
    known.reserve(machine_.nodes_.size());
    for (const Node& node : machine_.nodes_) known.push_back(node.name);
    return UnknownName("state", name, known);
  }

  void Events(const std::string& key, const std::vector<std::string>& names) {
    std::vector<std::string> known;
    known.reserve(machine_.events_.size());
    for (const Event& event : machine_.events_) known.push_back(event.name);
    for (const std::string& name : names) {
      if (!name.empty() && !machine_.FindEvent(name)) Fail(key, UnknownName("event", name, known));
    }
  }

  void CheckCommandData() {
    for (const Snapshot::Part& part : saved_.command_data) {
      const std::string key = SnapshotKey("command_data", part.name);
      std::size_t i = 0;
      while (i < saved_.commands.size() && std::to_string(i) != part.name) ++i;
      if (i == saved_.commands.size()) {
        Fail(key, "there is no such command");
      } else if (const auto event = machine_.FindEvent(saved_.commands[i])) {
        if (machine_.NewData(*event) == nullptr) Fail(key, saved_.commands[i] + " carries no data");
      }
    }
    for (std::size_t i = 0; i < saved_.commands.size(); ++i) {
      const auto event = machine_.FindEvent(saved_.commands[i]);
      const auto data = event ? machine_.NewData(*event) : nullptr;
      if (data == nullptr) continue;
      GivePart("command_data", saved_.command_data, std::to_string(i),
               [&](Archive& archive) { data->Persist(archive); });
    }
  }

  void CheckParts(const std::string& key, const std::vector<Snapshot::Part>& parts) {
    std::vector<std::string> known;
    known.reserve(machine_.data_.size());
    for (const Data& data : machine_.data_) known.push_back(data.name);
    for (const Snapshot::Part& part : parts) {
      if (key == "states" && !machine_.FindState(part.name)) {
        Fail(SnapshotKey(key, part.name), UnknownState(part.name));
      } else if (key == "data" && std::ranges::find(known, part.name) == known.end()) {
        Fail(SnapshotKey(key, part.name), UnknownName("data", part.name, known));
      }
    }
  }

  template <class Persist>
  void GivePart(const std::string& kind, const std::vector<Snapshot::Part>& parts,
                const std::string& name, Persist&& persist) {
    const std::string local = SnapshotKey(kind, name);
    const std::string key = SnapshotKey(prefix_, local);
    const auto part = std::ranges::find(parts, name, &Snapshot::Part::name);
    Faults own;
    const std::vector<SavedField> none;
    const bool has_any =
        RestoreFields(part == parts.end() ? none : part->fields, key, persist, own);
    if (part == parts.end() && has_any) Fail(local, "is missing");
    faults_.insert(faults_.end(), own.begin(), own.end());
  }

  // Calls `Do` for each machine inside; an error for each that only one of the two has.
  template <class Do>
  void ForInside(Do&& act) {
    std::vector<std::string> known;
    for (const Node& node : machine_.nodes_) {
      for (const auto& machine : node.inside) {
        known.push_back(InsideName(node, *machine));
        const auto saved = std::ranges::find(saved_.inside, known.back(), &Snapshot::Inside::state);
        const std::string local = SnapshotKey("inside", known.back());
        if (saved == saved_.inside.end()) {
          Fail(local, "is missing");
          continue;
        }
        Restorer inside(*machine, saved->machine, SnapshotKey(prefix_, local), faults_);
        act(inside);
      }
    }
    for (const Snapshot::Inside& saved : saved_.inside) {
      const std::string state = saved.state.substr(0, saved.state.find('/'));
      if (!machine_.FindState(state)) continue;  // reported already
      if (std::ranges::find(known, saved.state) != known.end()) continue;
      const bool second = state.size() != saved.state.size();
      Fail(SnapshotKey("inside", saved.state),
           state + (second ? " holds no such machine" : " holds no machine"));
    }
  }

  void Fail(const std::string& key, std::string what) {
    faults_.push_back({SnapshotKey(prefix_, key), std::move(what)});
  }

  Machine& machine_;
  const Snapshot& saved_;
  const std::string prefix_;
  Faults& faults_;
};

std::vector<SnapshotFault> Machine::Restore(const Snapshot& saved, Time now) {
  if (!built_ || in_tick()) {
    return {{"", name() + ": can be restored once it is built, and between ticks"}};
  }
  Faults faults;
  Restorer restorer(*this, saved, "", faults);
  restorer.Validate();
  if (!faults.empty()) return faults;
  const Result<Snapshot> before = Save();
  if (!before) return {{"", before.error().message}};
  restorer.RestoreParts();
  if (faults.empty()) {
    restorer.Become(now);
    return faults;
  }
  Faults none;  // undoes what was restored
  Restorer(*this, before.value(), "", none).RestoreParts();
  return faults;
}

void Machine::Become(const Snapshot& saved, Time now) {
  const auto state = [this](const std::string& name) { return FindState(name).value_or(kNoState); };
  const auto event = [this](const std::string& name) { return FindEvent(name).value_or(kNoEvent); };
  EndPlain();
  running_ = saved.running;
  mode_ = saved.mode;
  if (running_) {
    SetPresent(state(saved.state));
  } else {
    SetAbsent();
  }
  ticks_ = saved.ticks;
  tick_ = {.now = saved.time, .step = saved.step, .elapsed = saved.elapsed};
  last_tick_ = saved.paused ? std::nullopt : std::optional(now);
  unsafe_ = FindCheck(saved.unsafe).value_or(kNoCheck);
  const Snapshot::Transition transition = saved.transition.value_or(Snapshot::Transition{});
  tick_.target = FindTarget(current_, transition.to).value_or(kNoState);
  tick_.transition_elapsed = transition.elapsed;
  tick_.transition_time = transition.time;
  cause_ = event(transition.command);
  first_command_ = waiting_ = 0;
  for (const std::string& command : saved.commands) {
    const auto data = NewData(event(command));
    const auto part =
        std::ranges::find(saved.command_data, std::to_string(waiting_), &Snapshot::Part::name);
    if (data != nullptr && part != saved.command_data.end()) {
      Faults none;  // they were checked
      RestoreFields(
          part->fields, "", [&](Archive& archive) { data->Persist(archive); }, none);
    }
    commands_[waiting_++] = {event(command), data};
  }
  counts_ = saved.counts;
  fault_.reset();
  if (const auto& fault = saved.fault) {
    fault_ = Fault{state(fault->state), fault->phase, fault->at, fault->what, fault->where};
  }
  history_.Clear();
  for (const Snapshot::PastChange& change : saved.history) {
    history_.Add({change.at, change.tick, state(change.from), state(change.to),
                  event(change.command), change.cause});
  }
}

}  // namespace musher::fsm
