#include "musher/controller/journal/replay.hpp"

#include <algorithm>
#include <utility>

#include "musher/controller/journal/record_data.hpp"
#include "musher/lifecycle/config/config_toml.hpp"
#include "musher/lifecycle/record/texts.hpp"

namespace musher::recording {
namespace {

// Whether two sentences are equal: the program that has written one may know other modules by name.
bool SameText(const std::string& a, const std::string& b) {
  return a == b || WithoutModuleNames(a) == WithoutModuleNames(b);
}

// Whether two decisions are equal: with a different config their numbers are not compared.
bool Same(const JournalEntry& a, const JournalEntry& b, bool with_numbers) {
  const bool same = a.kind == b.kind && a.actuator == b.actuator && a.code == b.code &&
                    SameText(a.message, b.message) && a.state == b.state && a.event == b.event;
  return same && (!with_numbers || (a.id == b.id && a.cause == b.cause && a.epoch == b.epoch &&
                                    a.switch_number == b.switch_number));
}

// The sentences in a machine.
template <class Each>
void ForEachSentence(Machine& machine, const Each& each) {
  for (auto& record : machine.actuators) {
    if (record.fault) each(record.fault->message);
  }
  if (!machine.current) return;
  for (auto* legs : {&machine.current->legs, &machine.current->rollback.legs}) {
    for (auto& leg : *legs) each(leg.message);
  }
  for (auto& other : machine.current->others) each(other.message);
}

// With the codes in its sentences as numbers only.
Machine WithoutNames(Machine machine) {
  ForEachSentence(machine, [](std::string& message) { message = WithoutModuleNames(message); });
  return machine;
}

// Without the requesters that the recorded machine lacks: an older version recorded fewer of them.
// Their names are for people.
Machine WithRequestersOf(const Machine& recorded, Machine machine) {
  const auto take = [](std::string& by, const std::string& recorded_by) {
    if (recorded_by.empty()) by.clear();
  };
  take(machine.requested_by, recorded.requested_by);
  if (machine.standing && recorded.standing) take(machine.standing->by, recorded.standing->by);
  if (machine.waiting && recorded.waiting) {
    take(machine.waiting->by.name, recorded.waiting->by.name);
  }
  if (machine.stopping && recorded.stopping) {
    take(machine.stopping->by.name, recorded.stopping->by.name);
  }
  auto& power = machine.policy.power;
  if (power && recorded.policy.power) take(power->by, recorded.policy.power->by);
  return machine;
}

// Whether the replayed machine is the recorded one.
bool SameMachine(const Machine& recorded, const Machine& replayed) {
  return recorded == replayed ||
         WithoutNames(recorded) == WithoutNames(WithRequestersOf(recorded, replayed));
}

bool IsOf(const std::vector<Leg>& legs, const Machine& machine) {
  const auto has = [&](ActuatorIndex i) { return machine.actuators.Has(i); };
  return std::all_of(legs.begin(), legs.end(), [&](const Leg& leg) {
    return has(leg.actuator) && std::all_of(leg.needs.begin(), leg.needs.end(), has);
  });
}

bool HasOnly(const Machine& machine, std::optional<ActuatorIndex> only) {
  return machine.actuators.Has(only.value_or(ActuatorIndex()));
}

// Whether a decoded machine is consistent: the right number of actuators, no part without the
// others. A journal may come from any source.
bool IsWhole(const Machine& machine, std::size_t actuators) {
  if (machine.actuators.size() != actuators) return false;
  if (const auto& s = machine.current) {
    if (!HasOnly(machine, s->only)) return false;
    if (!IsOf(s->legs, machine) || !IsOf(s->rollback.legs, machine)) return false;
  }
  if (machine.waiting && !HasOnly(machine, machine.waiting->only)) return false;
  const auto& stopping = machine.stopping;
  if (machine.phase == Phase::kStopping && !stopping) return false;
  return !stopping || machine.current || stopping->result || stopping->announced_by;
}

// Whether the config has the rules whose state the machine has.
bool HasRulesOf(const MachineConfig& config, const PolicyState& policy) {
  const bool battery = policy.battery || policy.level != BatteryLevel::kFree;
  if (battery && !(config.policy && config.policy->battery)) return false;
  if (policy.low_power && !(config.policy && config.policy->low_power)) return false;
  return config.policy || !policy.power;
}

class Replayer {
 public:
  explicit Replayer(const ReplayOptions& options) : options_(options) {}

  Result<ReplayReport> Run(const std::vector<JournalRow>& rows) {
    for (const JournalRow& row : rows) {
      if (auto taken = Take(row); !taken) return taken.error();
    }
    EndStep(true);
    if (report_.starts == 0 && report_.inputs == 0 && report_.notes.empty()) {
      report_.notes.emplace_back("it contains no start of a controller and no snapshot");
    }
    if (report_.inputs == 0 && options_.epoch && report_.starts > 0) {
      return Error{kCodeParametersInvalid,
                   "the journal has no decision of a controller with epoch " +
                       std::to_string(options_.epoch->value())};
    }
    if (report_.starts == 0) return Error{kCodeFailed, "nothing to replay: " + report_.notes[0]};
    if (machine_) report_.replayed_state = machine_->state;
    return std::move(report_);
  }

 private:
  Result<> Take(const JournalRow& row) {
    if (row.id != last_id_ + 1) EndSession(row.id);
    last_id_ = row.id;
    if (const auto* entry = std::get_if<JournalEntry>(&row.item)) {
      if (entry->id != 0) recorded_.push_back(*entry);  // 0: not from the decision code
      return Ok();
    }
    const auto& input = std::get<JournalInput>(row.item);
    const bool is_config = std::holds_alternative<ConfigText>(input.what);
    EndStep(is_config);
    wall_ns_ = input.wall_ns;
    auto taken = std::visit([&](const auto& what) { return On(what); }, input.what);
    begins_ = is_config;
    return taken;
  }

  // Rows are missing: waits for another start.
  void EndSession(std::int64_t next_id) {
    EndStep(true);
    begins_ = false;
    if (!machine_) return;
    const std::string first = std::to_string(last_id_ + 1);
    const std::string last = std::to_string(next_id - 1);
    report_.notes.push_back(first == last ? "number " + first + " of the journal is missing"
                                          : "numbers " + first + " to " + last +
                                                " of the journal are missing");
    machine_.reset();
  }

  // A controller begins, or its config is recorded once more.
  Result<> On(const ConfigText& text) {
    if (config_ && text.hash == recorded_hash_) return Ok();
    machine_.reset();
    config_.reset();
    recorded_hash_ = text.hash;
    auto recorded = ReadRecorded(text);
    if (options_.config) {
      if (recorded) {
        if (auto fits = Match(*recorded, *options_.config); !fits) return fits;
      }
      config_ = options_.config;
      other_config_ = config_->hash != text.hash;
      report_.other_config |= other_config_;
    } else {
      config_ = std::move(recorded);
    }
    return Ok();
  }

  std::optional<MachineConfig> ReadRecorded(const ConfigText& text) {
    if (text.text.empty()) {
      if (!options_.config) report_.notes.emplace_back("its config is not in the journal");
      return std::nullopt;
    }
    ConfigReading reading = ReadConfigText(text.text, text.file);
    if (!reading.config) {
      report_.notes.push_back("its config is no longer valid: " +
                              FormatDiagnostic(reading.diagnostics.front()));
    }
    return std::move(reading.config);
  }

  // The events number the actuators as the recorded config does.
  Result<> Match(const MachineConfig& recorded, const MachineConfig& other) {
    const auto missing = [](const ActuatorConfig& actuator, const std::string& where) {
      return Error{kCodeParametersInvalid, "actuator '" + actuator.name + "' is not in " + where};
    };
    for (const ActuatorConfig& actuator : other.actuators) {
      if (!recorded.IndexOf(actuator.name)) return missing(actuator, "the recorded config");
    }
    number_of_ = {};
    for (const ActuatorConfig& actuator : recorded.actuators) {
      const auto index = other.IndexOf(actuator.name);
      if (!index) return missing(actuator, other.file);
      number_of_.push_back(*index);
    }
    return Ok();
  }

  Result<> On(const SnapshotPtr& snapshot) {
    const bool same = machine_ && (other_config_ || SameMachine(snapshot->machine, *machine_));
    if (same) return Ok();
    if (!config_ || snapshot->config_hash != recorded_hash_ || !Fits(snapshot->machine)) {
      report_.notes.emplace_back("a snapshot is of a different config");
      return Ok();
    }
    if (machine_) {
      ++report_.differences;
      report_.notes.push_back("the replayed machine differs from the snapshot, number " +
                              std::to_string(last_id_));
    }
    const bool starts = !machine_;
    machine_ = snapshot->machine;
    if (starts) CountStart();
    return Ok();
  }

  // Whether a snapshot of the recorded config can continue with this one.
  bool Fits(const Machine& machine) const {
    return IsWhole(machine, config_->actuators.size()) &&
           std::is_sorted(number_of_.begin(), number_of_.end()) &&
           HasRulesOf(*config_, machine.policy) &&
           (!machine.fallback.target || config_->RankOf(*machine.fallback.target));
  }

  void CountStart() {
    ++report_.starts;
    report_.recorded_state = machine_->state;
  }

  Result<> On(const TimedEvent& timed) {
    if (begins_ && config_ && std::holds_alternative<event::Begin>(timed.event)) {
      machine_ = MakeMachine(*config_);
      CountStart();
    }
    if (!machine_) {
      ++report_.not_replayed;
      return Ok();
    }
    event_ = timed;
    if (!Renumber(event_->event)) {
      event_.reset();
      return Error{kCodeParametersInvalid,
                   "input " + std::to_string(last_id_) + " names an unknown actuator"};
    }
    for (Action& action : Step(*config_, *machine_, event_->event, timed.now)) {
      if (auto* record = std::get_if<action::Record>(&action))
        replayed_.push_back(EntryOf(*record));
    }
    return Ok();
  }

  // The event with the numbers of actuators that the config gives them.
  bool Renumber(Event& event) const {
    const auto& actuators = config_->actuators;
    return std::visit(
        [&](auto& e) {
          if constexpr (requires { e.running; }) {
            if (e.running.size() > actuators.size()) return false;
            e.running = Renumbered(e.running);
          }
          if constexpr (requires { e.processes; }) {
            if (e.processes.size() > actuators.size()) return false;
            e.processes = Renumbered(e.processes);
          }
          if constexpr (requires { actuators[e.actuator]; }) {
            if (!actuators.Has(e.actuator)) return false;
            e.actuator = NumberOf(e.actuator);
          }
          return true;
        },
        event);
  }
  template <class T>
  PerActuator<T> Renumbered(const PerActuator<T>& recorded) const {
    PerActuator<T> renumbered(config_->actuators.size());
    for (const ActuatorIndex i : recorded.Indices()) renumbered[NumberOf(i)] = recorded[i];
    return renumbered;
  }
  ActuatorIndex NumberOf(ActuatorIndex recorded) const {
    return number_of_.Has(recorded) ? number_of_[recorded] : recorded;
  }

  JournalEntry EntryOf(const action::Record& record) const {
    JournalEntry entry;
    entry.wall_ns = wall_ns_;
    entry.epoch = machine_->epoch;
    entry.switch_number = record.switch_number;
    entry.kind = record.kind;
    if (record.actuator) entry.actuator = config_->actuators[*record.actuator].name;
    entry.code = record.code;
    entry.message = record.message;
    entry.id = record.id;
    entry.cause = record.cause;
    entry.state = record.state;
    entry.event = NameOf(record.event);
    entry.data = DataOf(record);
    return entry;
  }

  // Compares a step once all its entries are read. `last`: the last step before a gap or the end;
  // the last entries of its decisions may not have reached the disk.
  void EndStep(bool last) {
    auto recorded = std::exchange(recorded_, {});
    auto replayed = std::exchange(replayed_, {});
    const auto event = std::exchange(event_, std::nullopt);
    if (!event) return;
    for (const JournalEntry& entry : recorded) {
      if (!entry.state.empty()) report_.recorded_state = entry.state;
    }
    const bool reported = wall_ns_ >= options_.since_wall_ns &&
                          (!options_.epoch || *options_.epoch == machine_->epoch);
    if (!reported) return;
    if (last) TakeForRecorded(recorded, replayed);
    ++report_.inputs;
    report_.decisions += replayed.size();
    Compare(recorded, replayed, *event);
  }

  void TakeForRecorded(std::vector<JournalEntry>& recorded,
                       const std::vector<JournalEntry>& replayed) const {
    if (recorded.size() >= replayed.size()) return;
    for (std::size_t i = 0; i < recorded.size(); ++i) {
      if (!Same(recorded[i], replayed[i], !other_config_)) return;
    }
    recorded = replayed;
  }

  void Compare(const std::vector<JournalEntry>& recorded, const std::vector<JournalEntry>& replayed,
               const TimedEvent& event) {
    const auto add = [&](ReplayLine::Mark mark, const JournalEntry& entry) {
      const bool same = mark == ReplayLine::Mark::kSame;
      if (!same) ++report_.differences;
      report_.lines.push_back({mark, entry, same ? "" : EncodeEvent(event.event, event.now)});
    };
    auto next = replayed.begin();
    for (const JournalEntry& entry : recorded) {
      const auto found = std::find_if(next, replayed.end(), [&](const JournalEntry& other) {
        return Same(entry, other, !other_config_);
      });
      if (found == replayed.end()) {
        add(ReplayLine::Mark::kRecorded, entry);
        continue;
      }
      for (; next != found; ++next) add(ReplayLine::Mark::kNew, *next);
      add(ReplayLine::Mark::kSame, entry);
      ++next;
    }
    for (; next != replayed.end(); ++next) add(ReplayLine::Mark::kNew, *next);
  }

  const ReplayOptions& options_;
  ReplayReport report_;
  std::optional<MachineConfig> config_;  // of the replayed machine
  std::string recorded_hash_;
  bool other_config_ = false;
  bool begins_ = false;                   // a controller's config was the last input
  PerActuator<ActuatorIndex> number_of_;  // of a recorded actuator in config_; empty: the same
  std::optional<Machine> machine_;        // nullopt: no start yet
  std::int64_t last_id_ = 0;
  std::int64_t wall_ns_ = 0;         // of the last input
  std::optional<TimedEvent> event_;  // the step that is being compared
  std::vector<JournalEntry> recorded_;
  std::vector<JournalEntry> replayed_;
};

}  // namespace

Result<ReplayReport> Replay(const std::vector<JournalRow>& rows, const ReplayOptions& options) {
  return Replayer(options).Run(rows);
}

}  // namespace musher::recording
