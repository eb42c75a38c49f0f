#pragma once
// The status of a behaviour tree as messages. Plain functions, no IO.

#include <cstdint>
#include <string>
#include <vector>

#include "musher/behavior/tree/tree.hpp"
#include "musher/messages/musher_msgs/tree.hpp"

namespace musher {

// Tree time: since the first tick, without the pauses.
class TreeTime {
 public:
  // The clock's time at a tick: it counts from here, where it was paused.
  void Continue(Time now);
  void Pause() { counts_ = false; }

  // The tree time at a time of the clock. Times before the last kMostSpans pauses have the tree
  // time at which the oldest of these spans began.
  Duration At(Time when) const;
  Duration Now() const { return At(last_); }
  Time last() const { return last_; }  // of the last tick

 private:
  static constexpr std::size_t kMostSpans = 64;
  struct Span {
    Time begin;
    Time end;
    Duration before;  // tree time at its begin
  };

  bool counts_ = false;
  Time last_{};
  std::vector<Span> spans_;
};

// A tree with what its actuator knows of it.
struct TreeView {
  tree::Tree* tree = nullptr;                // null: none is loaded
  const tree::Document* document = nullptr;  // of the tree
  std::uint32_t revision = 0;
  bool ticking = false;
  std::uint64_t ticks = 0;
  tree::Status result = tree::Status::kIdle;  // of the root, also after its end
  const std::string* last_fault = nullptr;
  const TreeTime* time = nullptr;
};

// Into a message that may have been used before: nothing is allocated then.
void ReportState(const TreeView& view, msg::TreeState& state);

// The reply of get_tree. It has an `error` when the request has an unknown format.
msg::GetTree::Response ReportTree(const TreeView& view, const msg::GetTree::Request& request);

}  // namespace musher
