#include <array>
#include <charconv>
#include <cmath>
#include <utility>

#include "musher/base/toml/text.hpp"
#include "musher/behavior/fsm/toml/snapshot_toml.hpp"

namespace musher::fsm {
namespace {

class SnapshotWriter {
 public:
  Result<std::string> Write(const Snapshot& snapshot) && {
    text_ = "# A state machine between two ticks. Times are nanoseconds of machine time.\n";
    WriteMachine(snapshot, "");
    if (!unwritable_.empty()) {
      return Error{kCodeFailed, snapshot.machine + ": " + unwritable_ +
                                    " cannot be saved: it is not UTF-8, or has a NUL"};
    }
    return std::move(text_);
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
    WriteParts(snapshot.data, path + "data.");
    WriteParts(snapshot.states, path + "states.");
    for (const Snapshot::Inside& inside : snapshot.inside) {
      const std::string below = path + "inside." + Key(inside.state);
      Table(below);
      WriteMachine(inside.machine, below + ".");
    }
  }

  void WriteCommands(const Snapshot& snapshot) {
    text_ += "commands = [";
    for (std::size_t i = 0; i < snapshot.commands.size(); ++i) {
      text_ += (i == 0 ? "" : ", ") + Quoted(snapshot.commands[i], "commands");
    }
    text_ += "]\n";
  }

  void WriteHistory(const Snapshot& snapshot) {
    if (snapshot.history.empty()) return;
    text_ += "history = [\n";
    for (const Snapshot::PastChange& change : snapshot.history) {
      text_ += "  { tick = " + std::to_string(change.tick) +
               ", at_ns = " + std::to_string(change.at.count()) +
               ", from = " + Quoted(change.from, "history") +
               ", to = " + Quoted(change.to, "history") + ", cause = \"" +
               std::string(Name(change.cause)) + "\"";
      if (!change.command.empty()) text_ += ", command = " + Quoted(change.command, "history");
      text_ += " },\n";
    }
    text_ += "]\n";
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

  void Field(const std::string& name, bool value) { Bool(Key(name), value); }
  void Field(const std::string& name, std::int64_t value) {
    Line(Key(name), std::to_string(value));
  }
  void Field(const std::string& name, const std::string& value) { Text(Key(name), value); }
  void Field(const std::string& name, double value) {
    std::array<char, 32> digits{};
    const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr;
    std::string number(digits.data(), end);
    if (std::isfinite(value) && number.find_first_of(".e") == std::string::npos) number += ".0";
    Line(Key(name), number);
  }

  void Table(const std::string& path) { text_ += "\n[" + path + "]\n"; }
  void Bool(const std::string& key, bool value) { Line(key, value ? "true" : "false"); }
  void Number(const std::string& key, std::uint64_t value) { Line(key, std::to_string(value)); }
  void Time(const std::string& key, Duration value) { Line(key, std::to_string(value.count())); }
  void Text(const std::string& key, std::string_view value) { Line(key, Quoted(value, key)); }
  void Line(const std::string& key, const std::string& value) {
    text_ += key;
    text_ += " = ";
    text_ += value;
    text_ += '\n';
  }

  std::string Key(const std::string& name) {
    constexpr std::string_view kBare =
        "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-";
    const bool bare = !name.empty() && name.find_first_not_of(kBare) == std::string::npos;
    return bare ? name : Quoted(name, "a name");
  }

  std::string Quoted(std::string_view text, std::string_view key) {
    std::string quoted = "\"";
    while (!text.empty()) {
      const std::size_t size = config_toml::CharacterSize(text);
      if (size == 0 || text.front() == '\0') {
        unwritable_ = key;
        break;
      }
      quoted += size == 1 ? Escaped(text.front()) : std::string(text.substr(0, size));
      text.remove_prefix(size);
    }
    return quoted + "\"";
  }

  static std::string Escaped(char c) {
    constexpr std::string_view kHex = "0123456789ABCDEF";
    if (c == '"' || c == '\\') return {'\\', c};
    if (c == '\n') return "\\n";
    const auto byte = static_cast<unsigned char>(c);
    if (byte >= 0x20 && byte != 0x7f) return {c};
    return std::string("\\u00") + kHex[byte >> 4] + kHex[byte & 0xf];
  }

  std::string text_;
  std::string unwritable_;  // the key of a text that TOML cannot represent
};

}  // namespace

Result<std::string> WriteSnapshot(const Snapshot& snapshot) {
  return SnapshotWriter().Write(snapshot);
}

}  // namespace musher::fsm
