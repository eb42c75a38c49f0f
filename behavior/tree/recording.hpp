#pragma once
// Reads the recording of a tree (recorder.hpp), and shows it at any time of it.
//
//   Result<Recording> recording = ReadRecording(text, "patrol.tree");
//   Playback playback(recording.value().trees.front());
//   playback.To(Milliseconds(12'500));
//   playback.status(3);

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/behavior/tree/trace.hpp"

namespace musher::tree {

struct RecordedNode {
  std::string name;
  std::string type;
  std::string kind;
  std::optional<NodeId> parent;  // a smaller id; nothing: the root
};

struct RecordedEvent {
  enum class Kind : std::uint8_t { kIs, kChange, kSet, kState, kFault, kLost };

  Kind kind = Kind::kChange;
  Duration at{};  // tree time
  Change change;  // of kIs and kChange; its time is kRecordedOrigin + at
  // Fields of kSet.
  std::string board;
  std::string key;
  std::string type;
  std::string text;  // the value; of kFault the fault
  // Fields of kState.
  bool ticking = false;
  Status result = Status::kIdle;
  std::uint64_t wall_us = 0;
  std::uint64_t lines = 0;  // of kLost
};

// The section of a file from the load of a tree, or the file's begin, to the load of another one.
struct RecordedTree {
  std::uint32_t revision = 0;
  std::string name;
  std::string xml;
  std::vector<RecordedNode> nodes;
  std::vector<RecordedEvent> events;

  Duration End() const { return events.empty() ? Duration{} : events.back().at; }
};

struct Recording {
  std::string file;  // for messages
  std::string actuator;
  std::vector<RecordedTree> trees;
  // The number of a last line that is incomplete and was left out: power was lost, or the process
  // crashed.
  std::optional<int> cut_at;
};

// Fails with the first line that is damaged or contradicts those before, as "file:line:column:
// error: ...".
Result<Recording> ReadRecording(std::string_view text, const std::string& file);

inline constexpr Time kRecordedOrigin{};

// One tree of a recording as it was at a time.
class Playback {
 public:
  struct Entry {
    std::string board;
    std::string key;
    std::string type;
    std::string value;
  };

  // `tree` must outlive this.
  explicit Playback(const RecordedTree& tree);

  // Forwards only; with everything of that time.
  void To(Duration at);
  // The next event; false: there is none.
  bool Step();

  const RecordedTree& tree() const { return tree_; }
  std::size_t position() const { return next_; }  // events so far
  Duration now() const { return now_; }
  Status status(NodeId node) const { return statuses_.at(node); }
  const NodeRuns& runs(NodeId node) const { return trace_.node(node); }
  Duration Spent(NodeId node) const;
  const std::vector<Entry>& entries() const { return entries_; }
  bool ticking() const { return ticking_; }
  Status result() const { return result_; }
  const std::string& fault() const { return fault_; }
  // µs since 1970 at a tree time, by the last state; 0: unknown.
  std::uint64_t WallAt(Duration at) const;

 private:
  void Apply(const RecordedEvent& event);
  void Set(const RecordedEvent& event);

  const RecordedTree& tree_;
  std::size_t next_ = 0;
  Duration now_{};
  std::vector<Status> statuses_;
  Trace trace_{0};
  std::vector<Entry> entries_;
  bool ticking_ = false;
  Status result_ = Status::kIdle;
  std::string fault_;
  std::uint64_t wall_us_ = 0;
  Duration wall_at_{};
};

// A tree of a recording as a log of BehaviorTree.CPP 4's FileLogger2 (.btlog), which Groot2 opens.
// Fails where it has more nodes than such a log can number.
Result<std::string> WriteBtlog(const RecordedTree& tree);

}  // namespace musher::tree
