#include <array>
#include <limits>
#include <utility>
#include <variant>

#include "musher/base/toml/table_reader.hpp"
#include "musher/behavior/fsm/toml/finding_lines.hpp"
#include "musher/behavior/fsm/toml/places.hpp"
#include "musher/behavior/fsm/toml/snapshot_toml.hpp"

namespace musher::fsm {
namespace {

using config_toml::Findings;
using config_toml::Member;
using config_toml::Position;
using config_toml::TableReader;
using config_toml::Value;
using config_toml::Word;

constexpr auto kMost = std::numeric_limits<std::int64_t>::max();

// The words for an enum, from its first value to `last`.
template <class E>
std::vector<std::pair<std::string_view, E>> Words(E last) {
  std::vector<std::pair<std::string_view, E>> words;
  for (int i = 0; i <= static_cast<int>(last); ++i) {
    words.emplace_back(Name(static_cast<E>(i)), static_cast<E>(i));
  }
  return words;
}

// Reads a machine's table, with the position of each part by the keys of SnapshotFault.
class SnapshotReader {
 public:
  explicit SnapshotReader(Findings& findings) : findings_(findings) {}

  Snapshot Read(TableReader& table) {
    Snapshot snapshot;
    Note(table.path(), table.at());
    snapshot.machine = Text(table, "machine");
    if (const auto running = Needed(table, "running").Bool("running")) snapshot.running = *running;
    snapshot.paused = table.Bool("paused").value_or(false);
    if (const auto mode = Needed(table, "mode").Choice("mode", Words(Mode::kSafeStop))) {
      snapshot.mode = *mode;
    }
    Note(SnapshotKey(table.path(), "mode"), table.At("mode"));
    snapshot.state = Text(table, "state");
    snapshot.ticks = Count(table, "ticks");
    snapshot.time = Time(table, "time");
    snapshot.step = Time(table, "step");
    snapshot.elapsed = Time(table, "elapsed");
    if (const auto unsafe = table.String("unsafe")) snapshot.unsafe = unsafe->text;
    Note(SnapshotKey(table.path(), "unsafe"), table.At("unsafe"));
    ReadCommands(table, snapshot);
    ReadHistory(table, snapshot);
    ReadCounts(table, snapshot.counts);
    ReadTransition(table, snapshot);
    ReadFault(table, snapshot);
    snapshot.command_data = ReadParts(table, "command_data");
    snapshot.data = ReadParts(table, "data");
    snapshot.states = ReadParts(table, "states");
    ReadInside(table, snapshot);
    table.RefuseOthers();
    return snapshot;
  }

  Position Where(const std::string& key) const { return places_.Where(key); }

 private:
  void ReadCommands(TableReader& table, Snapshot& snapshot) {
    Note(SnapshotKey(table.path(), "commands"), table.At("commands"));
    const auto commands = table.Strings("commands", {.may_be_empty = true, .may_repeat = true});
    if (!commands) return;
    for (const Word& command : *commands) snapshot.commands.push_back(command.text);
  }

  void ReadHistory(TableReader& table, Snapshot& snapshot) {
    for (const Value* value : table.Tables("history")) {
      const std::string path =
          SnapshotKey(table.path(), "history[" + std::to_string(snapshot.history.size()) + "]");
      TableReader entry(*value->As<config_toml::Table>(), value->at, path, findings_);
      Note(path, value->at);
      Snapshot::PastChange change;
      change.tick = Count(entry, "tick");
      change.at = Time(entry, "at");
      change.from = Text(entry, "from");
      change.to = Text(entry, "to");
      if (const auto command = entry.String("command")) change.command = command->text;
      if (const auto cause = Needed(entry, "cause").Choice("cause", Words(Cause::kStopped))) {
        change.cause = *cause;
      }
      entry.RefuseOthers();
      snapshot.history.push_back(change);
    }
  }

  void ReadCounts(TableReader& table, Counts& counts) {
    auto entry = Below(table, "counts");
    if (!entry) return;
    counts.changes = Count(*entry, "changes");
    counts.unhandled = Count(*entry, "unhandled");
    counts.superseded = Count(*entry, "superseded");
    counts.refused = Count(*entry, "refused");
    counts.faults = Count(*entry, "faults");
    counts.listener_faults = Count(*entry, "listener_faults");
    entry->RefuseOthers();
  }

  void ReadTransition(TableReader& table, Snapshot& snapshot) {
    auto entry = Below(table, "transition");
    if (!entry) return;
    Snapshot::Transition transition;
    transition.to = Text(*entry, "to");
    if (const auto command = entry->String("command")) transition.command = command->text;
    Note(SnapshotKey(entry->path(), "command"), entry->At("command"));
    transition.elapsed = Time(*entry, "elapsed");
    transition.time =
        Duration(Needed(*entry, "time_ns").Integer("time_ns", -kMost, kMost).value_or(0));
    entry->RefuseOthers();
    snapshot.transition = std::move(transition);
  }

  void ReadFault(TableReader& table, Snapshot& snapshot) {
    auto entry = Below(table, "fault");
    if (!entry) return;
    Snapshot::PastFault fault;
    fault.state = Text(*entry, "state");
    if (const auto phase = Needed(*entry, "phase").Choice("phase", Words(Phase::kSafetyCheck))) {
      fault.phase = *phase;
    }
    fault.at = Time(*entry, "at");
    fault.what = Text(*entry, "what");
    fault.where = Text(*entry, "where");
    entry->RefuseOthers();
    snapshot.fault = std::move(fault);
  }

  std::vector<Snapshot::Part> ReadParts(TableReader& table, std::string_view kind) {
    std::vector<Snapshot::Part> parts;
    for (const Member& member : Members(table, kind)) {
      const std::string path = SnapshotKey(table.path(), std::string(kind) + "." + member.key);
      Note(path, member.at);
      const auto* fields = member.value.As<config_toml::Table>();
      if (fields == nullptr) {
        findings_.Error(member.value.at, path + ": expected a table");
        continue;
      }
      Snapshot::Part part{member.key, {}};
      for (const Member& field : *fields) {
        Note(SnapshotKey(path, field.key), field.at);
        if (const auto value = FieldValue(field.value)) {
          part.fields.push_back({field.key, *value});
        } else {
          findings_.Error(field.value.at,
                          SnapshotKey(path, field.key) + ": expected a bool, a number or a string");
        }
      }
      parts.push_back(std::move(part));
    }
    return parts;
  }

  static std::optional<Snapshot::Value> FieldValue(const Value& value) {
    if (const auto* boolean = value.As<bool>()) return *boolean;
    if (const auto* integer = value.As<std::int64_t>()) return *integer;
    if (const auto* number = value.As<double>()) return *number;
    if (const auto* text = value.As<std::string>()) return *text;
    return std::nullopt;
  }

  void ReadInside(TableReader& table, Snapshot& snapshot) {
    for (const Member& member : Members(table, "inside")) {
      const std::string path = SnapshotKey(table.path(), "inside." + member.key);
      const auto* machine = member.value.As<config_toml::Table>();
      if (machine == nullptr) {
        findings_.Error(member.value.at, path + ": expected a table");
        continue;
      }
      TableReader inside(*machine, member.at, path, findings_);
      snapshot.inside.push_back({member.key, Read(inside)});
    }
  }

  static const config_toml::Table& Members(TableReader& table, std::string_view key) {
    static const config_toml::Table none;
    const config_toml::Table* members = table.SubTable(key);
    return members == nullptr ? none : *members;
  }

  std::optional<TableReader> Below(TableReader& table, const std::string& key) {
    const config_toml::Table* below = table.SubTable(key);
    if (below == nullptr) return std::nullopt;
    Note(SnapshotKey(table.path(), key), table.At(key));
    return TableReader(*below, table.At(key), SnapshotKey(table.path(), key), findings_);
  }

  static TableReader& Needed(TableReader& table, std::string_view key) {
    table.Require(key, "what a saved machine has there");
    return table;
  }

  std::string Text(TableReader& table, const std::string& key) {
    const auto word = Needed(table, key).String(key);
    Note(SnapshotKey(table.path(), key), table.At(key));
    return word ? word->text : "";
  }
  static std::uint64_t Count(TableReader& table, std::string_view key) {
    return static_cast<std::uint64_t>(Needed(table, key).Integer(key, 0, kMost).value_or(0));
  }
  // The key "time_ns" of what a SnapshotFault calls "time".
  Duration Time(TableReader& table, const std::string& name) {
    const std::string key = name + "_ns";
    const auto ns = Needed(table, key).Integer(key, 0, kFarthestNs, " (nanoseconds)");
    Note(SnapshotKey(table.path(), name), table.At(key));
    return Duration(ns.value_or(0));
  }

  void Note(const std::string& key, Position at) { places_.Note(key, at); }

  Findings& findings_;
  Places places_;
};

}  // namespace

Result<> RestoreSnapshot(Machine& machine, std::string_view text, const std::string& file,
                         Time now) {
  Findings findings;
  const auto document = config_toml::ParseDocument(text);
  if (const auto* syntax = std::get_if<config_toml::SyntaxFault>(&document)) {
    findings.Error(syntax->at, syntax->message);
  } else {
    SnapshotReader reader(findings);
    TableReader root(std::get<config_toml::Table>(document), {1, 1}, "", findings);
    const Snapshot snapshot = reader.Read(root);
    if (!findings.HasErrors()) {
      for (const SnapshotFault& fault : machine.Restore(snapshot, now)) {
        findings.Error(reader.Where(fault.key),
                       fault.key + (fault.key.empty() ? "" : ": ") + fault.what);
      }
    }
  }
  if (!findings.HasErrors()) return Ok();
  return Error{kCodeParametersInvalid, FindingLines(std::move(findings), file, text)};
}

}  // namespace musher::fsm
