#pragma once
// One value for each actuator, in the order of the config. Only the index of an actuator, or a
// literal, gives one of them: a computed count, or an index into something else, does not compile.

#include <cstddef>
#include <initializer_list>
#include <iterator>
#include <utility>
#include <vector>

#include "musher/lifecycle/ids.hpp"

namespace musher {

// The indices of the first actuators, for a range-based loop.
class ActuatorIndices {
 public:
  class Iterator {
   public:
    using iterator_category = std::input_iterator_tag;
    using value_type = ActuatorIndex;
    using difference_type = std::ptrdiff_t;
    using pointer = const ActuatorIndex*;
    using reference = ActuatorIndex;

    constexpr Iterator() = default;
    explicit constexpr Iterator(ActuatorIndex at) : at_(at) {}

    constexpr ActuatorIndex operator*() const { return at_; }
    constexpr Iterator& operator++() {
      ++at_;
      return *this;
    }
    constexpr Iterator operator++(int) {
      const Iterator before = *this;
      ++at_;
      return before;
    }
    friend constexpr bool operator==(Iterator, Iterator) = default;

   private:
    ActuatorIndex at_;
  };

  explicit constexpr ActuatorIndices(std::size_t count) : end_(count) {}

  constexpr Iterator begin() const { return Iterator(); }
  constexpr Iterator end() const { return Iterator(end_); }

 private:
  ActuatorIndex end_;
};

template <typename T>
class PerActuator {
 public:
  using value_type = T;
  using reference = typename std::vector<T>::reference;
  using const_reference = typename std::vector<T>::const_reference;
  using iterator = typename std::vector<T>::iterator;
  using const_iterator = typename std::vector<T>::const_iterator;

  PerActuator() = default;
  PerActuator(std::initializer_list<T> values) : values_(values) {}
  explicit PerActuator(std::size_t count) : values_(count) {}
  PerActuator(std::size_t count, const T& value) : values_(count, value) {}

  reference operator[](ActuatorIndex actuator) { return values_[actuator.value()]; }
  const_reference operator[](ActuatorIndex actuator) const { return values_[actuator.value()]; }

  std::size_t size() const { return values_.size(); }
  bool empty() const { return values_.empty(); }
  bool Has(ActuatorIndex actuator) const { return actuator.value() < values_.size(); }
  ActuatorIndices Indices() const { return ActuatorIndices(values_.size()); }

  iterator begin() { return values_.begin(); }
  iterator end() { return values_.end(); }
  const_iterator begin() const { return values_.begin(); }
  const_iterator end() const { return values_.end(); }

  reference back() { return values_.back(); }
  const_reference back() const { return values_.back(); }
  void push_back(T value) { values_.push_back(std::move(value)); }
  void resize(std::size_t count) { values_.resize(count); }

  friend bool operator==(const PerActuator&, const PerActuator&) = default;

 private:
  std::vector<T> values_;
};

}  // namespace musher
