#pragma once
// The last changes of a machine. Allocates once.

#include <vector>

#include "musher/base/check.hpp"
#include "musher/behavior/fsm/listener.hpp"

namespace musher::fsm {

class History {
 public:
  explicit History(std::size_t capacity) : ring_(capacity) {}

  void Add(const Change& change) {
    if (ring_.empty()) return;
    ring_[next_] = change;
    next_ = next_ + 1 == ring_.size() ? 0 : next_ + 1;
    if (size_ < ring_.size()) ++size_;
  }
  void Clear() { next_ = size_ = 0; }

  std::size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  std::size_t capacity() const { return ring_.size(); }
  // 0 is the oldest.
  const Change& operator[](std::size_t i) const {
    MUSHER_CHECK(i < size_);
    return ring_[(next_ + ring_.size() - size_ + i) % ring_.size()];
  }
  const Change& back() const { return (*this)[size_ - 1]; }

 private:
  std::vector<Change> ring_;
  std::size_t next_ = 0;
  std::size_t size_ = 0;
};

}  // namespace musher::fsm
