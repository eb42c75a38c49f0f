#pragma once
// The segments that a mission has still to do, in order. A std::shared_ptr<SegmentQueue> is the
// value of the blackboard key segment_queue. Threads: one at a time, like the tree.

#include <cstddef>
#include <deque>
#include <iterator>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "musher/modules/meilin/plan/segment.hpp"

namespace musher::meilin {

class SegmentQueue {
 public:
  SegmentQueue() = default;
  explicit SegmentQueue(std::vector<Segment> segments, std::string plan_id = "") {
    Replace(std::move(segments), std::move(plan_id));
  }

  // The next segment, which leaves the queue; nothing when it is empty.
  std::optional<Segment> Pop() {
    if (segments_.empty()) return std::nullopt;
    std::optional<Segment> next = std::move(segments_.front());
    segments_.pop_front();
    return next;
  }
  // Drops what is left and takes the segments of another plan.
  void Replace(std::vector<Segment> segments, std::string plan_id = "") {
    total_ = segments.size();
    segments_.assign(std::make_move_iterator(segments.begin()),
                     std::make_move_iterator(segments.end()));
    plan_id_ = std::move(plan_id);
  }
  void Clear() { Replace({}); }

  std::size_t size() const { return segments_.size(); }  // left
  std::size_t total() const { return total_; }           // of the plan
  bool empty() const { return segments_.empty(); }
  const std::string& plan_id() const { return plan_id_; }

 private:
  std::deque<Segment> segments_;
  std::size_t total_ = 0;
  std::string plan_id_;
};

}  // namespace musher::meilin
