#pragma once
// Records what a tree does, a line each, for a replay (recording.hpp).
//
// clang-format off
//   musher-tree-recording 2 patrol #5c8a06f1    the first line, with the name of the actuator
//   tree 3 Patrol "<root …"                     a tree begins: its revision, name, and XML with the
//                                               ids of its nodes
//   node Patrol Sequence Control -1             each node in the order of the ids: name, type, kind,
//                                               parent (-1: the root)
//   is 0 1 RUNNING                              its state at the begin, where the node is not IDLE
//   set 0 "" goal_m double 5                    an entry: board ("": the main one), key, type, value
//   change 0.02 1 IDLE RUNNING                  tree time, id, from, to; a reset to IDLE, too
//   state 0.02 ticking RUNNING 1772366405000000 or paused; the result of the root, and the wall time
//                                               in µs; each second while it ticks, so that the
//                                               recording of a crash shows what lasted until then
//   fault 1.5 "Patrol/there: it is stuck"
//   lost 1.5 20                                 so many lines are missing; the tree begins again
// clang-format on
//
// The last word of each line is a checksum of what is before it and of the checksum of the line
// above: a line that is missing, doubled or at another place is detected. The chain begins with the
// first line of a file, and again with a line "lost". Values are cut to kMostValue.
//
// Threads: that of the tree.

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "musher/behavior/tree/tree.hpp"

namespace musher::tree {

inline constexpr std::string_view kRecordingFormat = "musher-tree-recording 2";
inline constexpr std::string_view kLostLine = "lost";

// The checksum of the line above; empty: the line begins a chain.
using RecordingChain = std::string;
// The checksum as the last word, and the end of the line.
void EndRecordingLine(std::string& line, RecordingChain& chain);
// Without it; nothing: it does not match, and the chain is as it was.
std::optional<std::string_view> WithoutChecksum(std::string_view line, RecordingChain& chain);

class Recorder : public ChangeListener {
 public:
  static constexpr std::size_t kMostValue = 500;  // bytes
  static constexpr Duration kStatePeriod = std::chrono::seconds(1);

  // Takes complete lines.
  using Sink = std::function<void(std::string_view lines)>;
  struct Recorded {
    Tree* tree = nullptr;
    const Document* document = nullptr;
    const Factory* factory = nullptr;
    std::uint32_t revision = 0;
    std::function<Duration(Time)> time;  // of the tree, for one of a change
  };
  struct State {
    Time at{};  // of the last tick
    std::uint64_t wall_us = 0;
    bool ticking = false;
    Status result = Status::kIdle;
    std::string fault;
  };

  explicit Recorder(Sink sink) : sink_(std::move(sink)) {}

  // The first line of a file.
  void Head(std::string_view actuator);
  // A tree, with its present state; what it refers to must outlive the next Begin() or End().
  void Begin(Recorded recorded, std::uint64_t wall_us);
  // The same again: in a new file, or where lines were lost.
  void BeginAgain(std::uint64_t wall_us);
  void End() { recorded_ = {}; }
  // After a tick, a pause, a halt: what has changed beside the nodes.
  void Note(const State& state);
  void Lost(std::uint64_t lines);
  void OnChange(const Change& change) override;

 private:
  struct Watched {
    std::string board;
    std::string key;
    const Entry* entry = nullptr;
    std::uint64_t sequence = 0;
    std::string text;  // as it was recorded
  };

  void FindEntries();
  std::size_t Keys() const;
  void WriteEntries(bool all);
  void WriteState();
  void Write(std::string line);
  Duration Now(Time at);

  const Sink sink_;
  Recorded recorded_;
  std::vector<std::string> description_;  // the lines of tree and nodes, without checksums
  RecordingChain chain_;
  std::vector<const Board*> boards_;
  std::size_t keys_ = 0;  // of all boards, when entries_ were found
  std::vector<Watched> entries_;
  State state_;
  Duration state_at_{};  // when it was written
  Duration last_{};
};

}  // namespace musher::tree
