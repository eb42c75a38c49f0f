#pragma once
// The last entries of a list that grows: the changes of a machine, the failures of a skill.
// Allocates its places once.

#include <algorithm>
#include <cstddef>
#include <new>
#include <type_traits>
#include <vector>

#include "musher/base/check.hpp"

namespace musher {

template <class T>
class Recent {
 public:
  explicit Recent(std::size_t capacity)
      : capacity_(capacity), ring_(std::max<std::size_t>(1, capacity)) {}

  void Add(const T& entry) {
    if (capacity_ == 0) return;
    ring_[next_] = entry;
    Advance();
  }
  // The same of its fields, in its place: to make it elsewhere and copy it takes much longer. The
  // entry stays there until the next one; also with a capacity of 0, which has a place for it.
  template <class... Fields>
  requires std::is_trivially_destructible_v<T>
  const T& Emplace(Fields... fields) {
    const T& entry = *::new (static_cast<void*>(&ring_[next_])) T{fields...};
    Advance();
    return entry;
  }
  void Clear() { next_ = added_ = 0; }

  std::size_t size() const { return std::min(added_, capacity_); }
  bool empty() const { return size() == 0; }
  std::size_t capacity() const { return capacity_; }
  // 0 is the oldest.
  const T& operator[](std::size_t i) const {
    MUSHER_CHECK(i < size());
    return ring_[(next_ + capacity_ - size() + i) % capacity_];
  }
  const T& back() const { return (*this)[size() - 1]; }

 private:
  void Advance() {
    next_ = next_ + 1 < capacity_ ? next_ + 1 : 0;
    ++added_;
  }

  std::size_t capacity_;
  std::vector<T> ring_;
  std::size_t next_ = 0;
  std::size_t added_ = 0;  // since it was empty
};

}  // namespace musher
