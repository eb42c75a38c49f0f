#include <limits>
#include <utility>

#include "musher/base/toml/table_reader.hpp"
#include "musher/behavior/fsm/toml/finding_lines.hpp"
#include "musher/behavior/fsm/toml/places.hpp"
#include "musher/behavior/skill/toml/read_value.hpp"
#include "musher/behavior/skill/toml/snapshot_toml.hpp"

namespace musher::skill {
namespace {

using config_toml::Findings;
using config_toml::Member;
using config_toml::Position;
using config_toml::TableReader;

constexpr auto kMost = std::numeric_limits<std::int64_t>::max();
constexpr auto kMostCount = std::numeric_limits<int>::max();

std::string Indexed(const std::string& key, std::size_t i) {
  return key + "[" + std::to_string(i) + "]";
}

// Reads the runs, with the position of each part by the keys of SnapshotFault.
class SkillsReader {
 public:
  explicit SkillsReader(Findings& findings) : findings_(findings) {}

  ManagerSnapshot Read(const config_toml::Table& root) {
    TableReader table(root, {1, 1}, "", findings_);
    ManagerSnapshot snapshot{ReadRuns(table, "run", "run")};
    table.RefuseOthers();
    return snapshot;
  }

  Position Where(const std::string& key) const { return places_.Where(key); }

 private:
  std::vector<Snapshot> ReadRuns(TableReader& table, std::string_view key,
                                 const std::string& path) {
    std::vector<Snapshot> runs;
    for (const config_toml::Value* value : table.Tables(key)) {
      const std::string own = Indexed(path, runs.size());
      places_.Note(own, value->at);
      TableReader run(*value->As<config_toml::Table>(), value->at, own, findings_);
      runs.push_back(ReadRun(run));
    }
    return runs;
  }

  Snapshot ReadRun(TableReader& table) {
    Snapshot run;
    run.skill = Text(table, "skill");
    run.state = Text(table, "state");
    run.entered = Flag(table, "entered");
    run.paused = Flag(table, "paused");
    run.pause_requested = table.Bool("pause_requested").value_or(false);
    if (const auto why = table.String("pause_why")) run.pause_why = why->text;
    run.ticks = static_cast<std::uint64_t>(Whole(table, "ticks", kMost));
    run.time = Time(table, "time");
    run.elapsed = Time(table, "elapsed");
    run.retries = static_cast<int>(Whole(table, "retries", kMostCount));
    run.replans = static_cast<int>(Whole(table, "replans", kMostCount));
    run.cancel_requested = Flag(table, "cancel_requested");
    run.cancel_passed = Flag(table, "cancel_passed");
    run.cancel_why = Text(table, "cancel_why");
    run.cancel_at = Time(table, "cancel_at");
    run.progress = static_cast<int>(Whole(table, "progress", 100));
    run.message = Text(table, "message");
    ReadHistory(table, run);
    ReadErrors(table, run);
    run.parameters = ReadValues(table, "parameters");
    run.data = ReadValues(table, "data");
    ReadFields(table, run);
    run.inside = ReadRuns(table, "inside", table.path() + ".inside");
    table.RefuseOthers();
    return run;
  }

  void ReadHistory(TableReader& table, Snapshot& run) {
    std::vector<std::pair<std::string_view, Cause>> causes;
    for (int i = 0; i <= static_cast<int>(Cause::kFault); ++i) {
      causes.emplace_back(Name(static_cast<Cause>(i)), static_cast<Cause>(i));
    }
    for (const config_toml::Value* value : table.Tables("history")) {
      const std::string path = Indexed(table.path() + ".history", run.history.size());
      places_.Note(path, value->at);
      TableReader entry(*value->As<config_toml::Table>(), value->at, path, findings_);
      Snapshot::PastChange change;
      change.at = Time(entry, "at");
      change.tick = static_cast<std::uint64_t>(Whole(entry, "tick", kMost));
      change.from = Text(entry, "from");
      change.to = Text(entry, "to");
      if (const auto cause = Needed(entry, "cause").Choice("cause", causes)) change.cause = *cause;
      if (const auto why = entry.String("why")) change.why = why->text;
      entry.RefuseOthers();
      run.history.push_back(std::move(change));
    }
  }

  void ReadErrors(TableReader& table, Snapshot& run) {
    for (const config_toml::Value* value : table.Tables("errors")) {
      const std::string path = Indexed(table.path() + ".errors", run.errors.size());
      TableReader entry(*value->As<config_toml::Table>(), value->at, path, findings_);
      const Duration at = Time(entry, "at");
      run.errors.push_back({at, Text(entry, "state"), Text(entry, "what")});
      entry.RefuseOthers();
    }
  }

  Values ReadValues(TableReader& table, const std::string& key) {
    Values values;
    const std::string path = table.path() + "." + key;
    for (const Member& member : Members(table, key)) {
      if (const auto value = ReadValue(member.value)) {
        values.Set(member.key, *value);
      } else {
        findings_.Error(member.value.at,
                        path + "." + member.key + ": expected a bool, a number, a text or numbers");
      }
    }
    return values;
  }

  void ReadFields(TableReader& table, Snapshot& run) {
    const std::string path = table.path() + ".fields";
    for (const Member& member : Members(table, "fields")) {
      places_.Note(path + "." + member.key, member.at);
      auto value = ReadValue(member.value);
      if (!value || KindOf(*value) == Kind::kNumbers) {
        findings_.Error(member.value.at,
                        path + "." + member.key + ": expected a bool, a number or a string");
        continue;
      }
      std::visit(
          [&](auto& content) {
            if constexpr (!std::is_same_v<std::decay_t<decltype(content)>, Numbers>) {
              run.fields.push_back({member.key, std::move(content)});
            }
          },
          *value);
    }
  }

  const config_toml::Table& Members(TableReader& table, const std::string& key) {
    static const config_toml::Table none;
    const config_toml::Table* members = table.SubTable(key);
    if (members != nullptr) places_.Note(table.path() + "." + key, table.At(key));
    return members == nullptr ? none : *members;
  }

  static TableReader& Needed(TableReader& table, std::string_view key) {
    table.Require(key, "what a saved skill has there");
    return table;
  }
  std::string Text(TableReader& table, const std::string& key) {
    const auto word = Needed(table, key).String(key);
    places_.Note(table.path() + "." + key, table.At(key));
    return word ? word->text : "";
  }
  bool Flag(TableReader& table, const std::string& key) {
    const auto flag = Needed(table, key).Bool(key);
    places_.Note(table.path() + "." + key, table.At(key));
    return flag.value_or(false);
  }
  std::int64_t Whole(TableReader& table, const std::string& key, std::int64_t most) {
    const auto number = Needed(table, key).Integer(key, 0, most);
    places_.Note(table.path() + "." + key, table.At(key));
    return number.value_or(0);
  }
  // The key "time_ns" of what a SnapshotFault calls "time".
  Duration Time(TableReader& table, const std::string& name) {
    const std::string key = name + "_ns";
    const auto ns = Needed(table, key).Integer(key, 0, kFarthestNs, " (nanoseconds)");
    places_.Note(table.path() + "." + name, table.At(key));
    return Duration(ns.value_or(0));
  }

  Findings& findings_;
  fsm::Places places_;
};

}  // namespace

Result<> RestoreSnapshot(Manager& manager, std::string_view text, const std::string& file) {
  Findings findings;
  const auto document = config_toml::ParseDocument(text);
  if (const auto* syntax = std::get_if<config_toml::SyntaxFault>(&document)) {
    findings.Error(syntax->at, syntax->message);
  } else {
    SkillsReader reader(findings);
    const ManagerSnapshot snapshot = reader.Read(std::get<config_toml::Table>(document));
    if (!findings.HasErrors()) {
      for (const SnapshotFault& fault : manager.Restore(snapshot)) {
        findings.Error(reader.Where(fault.key),
                       fault.key + (fault.key.empty() ? "" : ": ") + fault.what);
      }
    }
  }
  if (!findings.HasErrors()) return Ok();
  return Error{kCodeParametersInvalid, fsm::FindingLines(std::move(findings), file, text)};
}

}  // namespace musher::skill
