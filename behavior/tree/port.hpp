#pragma once
// The ports of a node, as members of its class. The constructor of the node makes them with its
// Setup (setup.hpp); from then on each is a fixed text of the XML, already converted, or an entry
// of the blackboard.
//
// A read or a write through a port that can not be done throws PortError; the tree reports it with
// the path of the node.
//
// Threads: one at a time, like the tree.

#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include "musher/behavior/tree/board.hpp"

namespace musher::tree {

class PortError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

namespace internal {
[[noreturn]] void FailRead(const std::string& port, const Entry* entry);
[[noreturn]] void FailWrite(const std::string& port, const Entry& entry, const Error& error);
}  // namespace internal

template <class T>
class InPort {
 public:
  InPort() = default;
  InPort(std::string name, Entry* entry, std::optional<T> fixed)
      : name_(std::move(name)), entry_(entry), fixed_(std::move(fixed)) {}

  // Null: the port is not set, its entry is empty, or the value there can not become a T.
  const T* Find() const {
    if (entry_ == nullptr) return fixed_ ? &*fixed_ : nullptr;
    const T* value = entry_->value.template As<T>();
    return value != nullptr ? value : Converted();
  }
  const T& Get() const {
    const T* value = Find();
    if (value == nullptr) internal::FailRead(name_, entry_);
    return *value;
  }
  T Or(T otherwise) const {
    const T* value = Find();
    return value != nullptr ? *value : std::move(otherwise);
  }
  const Entry* entry() const { return entry_; }  // null: a fixed text, or not set
  // The stamp of the entry. A fixed text and a port that is not set have never been set.
  Stamp stamp() const { return entry_ != nullptr ? entry_->stamp() : Stamp{}; }
  const std::string& name() const { return name_; }

 private:
  const T* Converted() const {
    if (entry_->value.empty()) return nullptr;
    if (!converted_.SetAs(*TypeOf<T>(), entry_->value)) return nullptr;
    return converted_.template As<T>();
  }

  std::string name_;
  Entry* entry_ = nullptr;
  std::optional<T> fixed_;
  mutable Value converted_;
};

template <class T>
class OutPort {
 public:
  OutPort() = default;
  OutPort(std::string name, Entry* entry) : name_(std::move(name)), entry_(entry) {}

  // Does nothing where the XML does not connect the port.
  void Set(const T& value) {
    if (entry_ == nullptr) return;
    const Result<> set = entry_->Set(value);
    if (!set) internal::FailWrite(name_, *entry_, set.error());
  }
  bool connected() const { return entry_ != nullptr; }

 private:
  std::string name_;
  Entry* entry_ = nullptr;
};

// A port that reads an entry, then writes it. A fixed text of the XML is read; what is written to
// it is lost.
template <class T>
class InOutPort : public InPort<T> {
 public:
  InOutPort() = default;
  InOutPort(std::string name, Entry* entry, std::optional<T> fixed)
      : InPort<T>(name, entry, std::move(fixed)), out_(std::move(name), entry) {}
  void Set(const T& value) { out_.Set(value); }

 private:
  OutPort<T> out_;
};

}  // namespace musher::tree
