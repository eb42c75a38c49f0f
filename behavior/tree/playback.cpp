#include <algorithm>
#include <cstddef>

#include "musher/behavior/tree/recording.hpp"

namespace musher::tree {
namespace {

constexpr std::string_view kBtlogMagic = "BTCPP4-FileLogger2";
constexpr char kBtlogProtocol = 1;

// The low bytes of a number, the lowest first.
void AppendBytes(std::string& text, std::uint64_t number, int bytes) {
  for (int i = 0; i < bytes; ++i) text += static_cast<char>((number >> (8 * i)) & 0xff);
}

}  // namespace

Playback::Playback(const RecordedTree& tree)
    : tree_(tree), statuses_(tree.nodes.size(), Status::kIdle) {
  trace_.Resize(tree.nodes.size());
}

void Playback::To(Duration at) {
  while (next_ < tree_.events.size() && tree_.events[next_].at <= at) Step();
  now_ = std::max(now_, at);
}

bool Playback::Step() {
  if (next_ == tree_.events.size()) return false;
  const RecordedEvent& event = tree_.events[next_++];
  now_ = std::max(now_, event.at);
  Apply(event);
  return true;
}

Duration Playback::Spent(NodeId node) const {
  const NodeRuns& runs = trace_.node(node);
  const bool runs_now = statuses_[node] == Status::kRunning;
  return runs_now ? runs.spent + (kRecordedOrigin + now_ - runs.since) : runs.spent;
}

std::uint64_t Playback::WallAt(Duration at) const {
  if (wall_us_ == 0) return 0;
  const std::int64_t us =
      std::chrono::duration_cast<std::chrono::microseconds>(at - wall_at_).count();
  return wall_us_ + static_cast<std::uint64_t>(us);
}

void Playback::Apply(const RecordedEvent& event) {
  using Kind = RecordedEvent::Kind;
  switch (event.kind) {
    case Kind::kIs:
    case Kind::kChange: {
      const Change& change = event.change;
      statuses_[change.node] = change.to;
      // The reset of a node that has ended is none of its runs.
      if (!IsCompleted(change.from) || change.to != Status::kIdle) trace_.Add(change);
      return;
    }
    case Kind::kSet:
      return Set(event);
    case Kind::kState:
      ticking_ = event.ticking;
      result_ = event.result;
      wall_us_ = event.wall_us;
      wall_at_ = event.at;
      return;
    case Kind::kFault:
      fault_ = event.text;
      return;
    case Kind::kLost:
      return;
  }
}

void Playback::Set(const RecordedEvent& event) {
  const auto found = std::ranges::find_if(entries_, [&](const Entry& entry) {
    return entry.board == event.board && entry.key == event.key;
  });
  if (found == entries_.end()) {
    entries_.push_back({event.board, event.key, event.type, event.text});
  } else {
    found->type = event.type;
    found->value = event.text;
  }
}

Result<std::string> WriteBtlog(const RecordedTree& tree) {
  if (tree.nodes.size() >= UINT16_MAX || tree.xml.size() > INT32_MAX) {
    return Error{kCodeParametersInvalid, "the tree has more nodes than a .btlog can number"};
  }
  std::string log(kBtlogMagic);
  log += kBtlogProtocol;
  AppendBytes(log, tree.xml.size(), 4);
  log += tree.xml;
  Playback playback(tree);
  std::uint64_t first_us = 0;
  for (const RecordedEvent& event : tree.events) {
    if (event.kind == RecordedEvent::Kind::kState && first_us == 0) first_us = event.wall_us;
  }
  AppendBytes(log, first_us, 8);
  while (playback.Step()) {
    const RecordedEvent& event = tree.events[playback.position() - 1];
    const bool is = event.kind == RecordedEvent::Kind::kIs;
    if (!is && event.kind != RecordedEvent::Kind::kChange) continue;
    const std::uint64_t wall_us = playback.WallAt(event.at);
    AppendBytes(log, wall_us > first_us ? wall_us - first_us : 0, 6);
    AppendBytes(log, event.change.node + 1, 2);
    log += static_cast<char>(event.change.to);
  }
  return log;
}

}  // namespace musher::tree
