#pragma once
// The last entries of a list that grows: the changes of a machine, the failures of a skill.
// Allocates its places once.

#include <cstddef>
#include <new>
#include <type_traits>
#include <vector>

#include "musher/base/check.hpp"

namespace musher {

template <class T>
class Recent {
 public:
  explicit Recent(std::size_t capacity) : ring_(capacity) {}

  void Add(const T& entry) {
    if (ring_.empty()) return;
    ring_[next_] = entry;
    Advance();
  }
  // The same of its fields, in its place: to make it elsewhere and copy it takes much longer.
  template <class... Fields>
  requires std::is_trivially_destructible_v<T>
  void Emplace(Fields... fields) {
    if (ring_.empty()) return;
    ::new (static_cast<void*>(&ring_[next_])) T{fields...};
    Advance();
  }
  void Clear() { next_ = size_ = 0; }

  std::size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  std::size_t capacity() const { return ring_.size(); }
  // 0 is the oldest.
  const T& operator[](std::size_t i) const {
    MUSHER_CHECK(i < size_);
    return ring_[(next_ + ring_.size() - size_ + i) % ring_.size()];
  }
  const T& back() const { return (*this)[size_ - 1]; }

 private:
  void Advance() {
    next_ = next_ + 1 == ring_.size() ? 0 : next_ + 1;
    if (size_ < ring_.size()) ++size_;
  }

  std::vector<T> ring_;
  std::size_t next_ = 0;
  std::size_t size_ = 0;
};

}  // namespace musher
