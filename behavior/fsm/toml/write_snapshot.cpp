#include <utility>

#include "musher/behavior/fsm/toml/snapshot_toml.hpp"
#include "musher/behavior/fsm/toml/toml_writer.hpp"

namespace musher::fsm {
namespace {

class SnapshotWriter : private TomlWriter {
 public:
  Result<std::string> Write(const Snapshot& snapshot) && {
    Append("# A state machine between two ticks. Times are nanoseconds of machine time.\n");
    WriteMachine(snapshot, "");
    return Written(snapshot.machine);
  }

 private:
  // `path` is "" or "inside.SHOW.".
  void WriteMachine(const Snapshot& snapshot, const std::string& path) {
    Text("machine", snapshot.machine);
    Bool("running", snapshot.running);
    Bool("paused", snapshot.paused);
    Text("mode", Name(snapshot.mode));
    Text("state", snapshot.state);
    Number("ticks", snapshot.ticks);
    Time("time_ns", snapshot.time);
    Time("step_ns", snapshot.step);
    Time("elapsed_ns", snapshot.elapsed);
    Text("unsafe", snapshot.unsafe);
    WriteCommands(snapshot);
    WriteHistory(snapshot);
    WriteCounts(snapshot.counts, path);
    WriteTransition(snapshot, path);
    WriteFault(snapshot, path);
    WriteParts(snapshot.command_data, path + "command_data.");
    WriteParts(snapshot.data, path + "data.");
    WriteParts(snapshot.states, path + "states.");
    for (const Snapshot::Inside& inside : snapshot.inside) {
      const std::string below = path + "inside." + Key(inside.state);
      Table(below);
      WriteMachine(inside.machine, below + ".");
    }
  }

  void WriteCommands(const Snapshot& snapshot) {
    Append("commands = [");
    for (std::size_t i = 0; i < snapshot.commands.size(); ++i) {
      Append((i == 0 ? "" : ", ") + Quoted(snapshot.commands[i], "commands"));
    }
    Append("]\n");
  }

  void WriteHistory(const Snapshot& snapshot) {
    if (snapshot.history.empty()) return;
    Append("history = [\n");
    for (const Snapshot::PastChange& change : snapshot.history) {
      Append("  { tick = " + std::to_string(change.tick) + ", at_ns = " +
             std::to_string(change.at.count()) + ", from = " + Quoted(change.from, "history") +
             ", to = " + Quoted(change.to, "history") + ", cause = \"" +
             std::string(Name(change.cause)) + "\"");
      if (!change.command.empty()) Append(", command = " + Quoted(change.command, "history"));
      Append(" },\n");
    }
    Append("]\n");
  }

  void WriteCounts(const Counts& counts, const std::string& path) {
    Table(path + "counts");
    Number("changes", counts.changes);
    Number("unhandled", counts.unhandled);
    Number("superseded", counts.superseded);
    Number("refused", counts.refused);
    Number("faults", counts.faults);
    Number("listener_faults", counts.listener_faults);
  }

  void WriteTransition(const Snapshot& snapshot, const std::string& path) {
    if (!snapshot.transition) return;
    Table(path + "transition");
    Text("to", snapshot.transition->to);
    Text("command", snapshot.transition->command);
    Time("elapsed_ns", snapshot.transition->elapsed);
    Time("time_ns", snapshot.transition->time);
  }

  void WriteFault(const Snapshot& snapshot, const std::string& path) {
    if (!snapshot.fault) return;
    Table(path + "fault");
    Text("state", snapshot.fault->state);
    Text("phase", Name(snapshot.fault->phase));
    Time("at_ns", snapshot.fault->at);
    Text("what", snapshot.fault->what);
    Text("where", snapshot.fault->where);
  }

  void WriteParts(const std::vector<Snapshot::Part>& parts, const std::string& path) {
    for (const Snapshot::Part& part : parts) {
      Table(path + Key(part.name));
      for (const Snapshot::Field& field : part.fields) {
        std::visit([&](const auto& value) { Field(field.name, value); }, field.value);
      }
    }
  }
};

}  // namespace

Result<std::string> WriteSnapshot(const Snapshot& snapshot) {
  return SnapshotWriter().Write(snapshot);
}

}  // namespace musher::fsm
