// Untrusted rows of a journal with valid checksums: one on each line, behind "e" an event, behind
// "m" a machine, behind "c" a config as JSON; "g" is a gap. A decoded row can be encoded and
// decoded again, and a replay ends with a report or an error.

#include <memory>

#include "musher/cli/render/json.hpp"
#include "musher/controller/journal/replay.hpp"
#include "musher/test/controller/recorded_robot.hpp"
#include "musher/test/fuzz/fuzz.hpp"

namespace musher::recording {
namespace {

using fuzz::Require;

class Rows {
 public:
  Rows() { Add(ConfigText{"dog.toml", "1", RobotToml()}); }

  void Read(std::string_view line) {
    const char kind = line.empty() ? 'g' : line[0];
    const std::string_view text = line.substr(std::min<std::size_t>(line.size(), 1));
    if (kind == 'e') {
      if (auto event = DecodeEvent(text)) {
        const auto again = DecodeEvent(EncodeEvent(event.value().event, event.value().now));
        Require(again.ok() && again.value() == event.value(), "an event stays the same");
        Add(std::move(event).value());
      }
    } else if (kind == 'm') {
      if (auto snapshot = DecodeSnapshot(text)) {
        const auto again = DecodeSnapshot(EncodeSnapshot(snapshot.value()));
        Require(again.ok() && again.value() == snapshot.value(), "a machine stays the same");
        Add(std::make_shared<const MachineSnapshot>(std::move(snapshot).value()));
      }
    } else if (kind == 'c') {
      if (auto config = DecodeConfig(text)) {
        const auto again = DecodeConfig(EncodeConfig(config.value()));
        Require(again.ok() && again.value() == config.value(), "a config stays the same");
        Add(std::move(config).value());
      }
    } else if (kind == 'g') {
      ++id_;
    } else {
      JournalEntry entry;
      entry.id = 1;
      entry.kind = "machine";
      entry.message = text;
      rows_.push_back({++id_, std::move(entry)});
    }
  }

  void Replay() const {
    const auto report = recording::Replay(rows_, {});
    Require(report.ok() || !report.error().message.empty(), "either a report or an error");
    if (report.ok())
      Require(!cli::ReplayJson(report.value(), "").empty(), "the report can be rendered");
  }

 private:
  template <class T>
  void Add(T what) {
    rows_.push_back({++id_, JournalInput{id_, std::move(what)}});
  }

  std::vector<JournalRow> rows_;
  std::int64_t id_ = 0;
};

}  // namespace
}  // namespace musher::recording

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::string_view text(reinterpret_cast<const char*>(data), size);
  musher::recording::Rows rows;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    rows.Read(text.substr(0, end));
    text.remove_prefix(std::min(text.size(), end + 1));
  }
  rows.Replay();
  return 0;
}
