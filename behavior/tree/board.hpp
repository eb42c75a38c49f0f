#pragma once
// Blackboards: named values that the nodes of a tree share. A tree has one for its main tree and
// one for each subtree; a remapped key of a subtree is an entry of the board around it. Keys become
// entries when the tree is built, so that a tick looks nothing up.
//
// A program may make the board of the main tree itself (BuildOptions::board), and one around it
// that several trees share: "@key" is a key of the outermost board.
//
//   auto robot = std::make_shared<tree::Board>();
//   auto patrol = Build(document, factory, {.board = std::make_shared<tree::Board>(robot)});
//   auto watch = Build(other, factory, {.board = std::make_shared<tree::Board>(robot)});
//
// Threads: one at a time, like the tree; trees that share a board are ticked by one thread.

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "musher/base/time.hpp"
#include "musher/behavior/tree/value.hpp"

namespace musher::tree {

// When an entry was set, and how many times.
struct Stamp {
  std::uint64_t sequence = 0;  // 0: never
  Time at{};                   // time of the tick; between two ticks of the last one
};

template <class T>
struct Stamped {
  T value;
  Stamp stamp;
};

namespace internal {
inline constexpr Time kNoTime{};
}  // namespace internal

struct Entry {
  std::string key;
  // Type of the ports that use it. Null: any, or ports with two types use it, one of them a text.
  const Type* type = nullptr;
  Value value{};
  bool declared = false;                   // a port uses it, and UnsetBlackboard has not cleared it
  std::uint64_t sequence = 0;              // how many times it was set
  Time set_at{};                           // the last time
  const Time* clock = &internal::kNoTime;  // of its board

  Stamp stamp() const { return {sequence, set_at}; }
  // Converts to `type` where it has one; fails and keeps the value where that is impossible.
  Result<> Assign(const Value& from);
  Result<> AssignNumber(double number);
  Result<> AssignText(std::string_view text);
  template <class T>
  Result<> Set(const T& from);

 private:
  void NoteSet() {
    ++sequence;
    set_at = *clock;
  }
};

class Board {
 public:
  Board() = default;
  Board(const Board&) = delete;
  Board& operator=(const Board&) = delete;

  // Board of a main tree within `outer`, which it keeps.
  explicit Board(std::shared_ptr<Board> outer)
      : parent_(outer.get()), kept_(std::move(outer)), clock_(parent_->clock_) {}
  // Board of a subtree. With `autoremap`, a key that does not begin with '_' is the parent's.
  Board(Board& parent, bool autoremap)
      : parent_(&parent), autoremap_(autoremap), clock_(parent.clock_) {}

  // The entry of a key, which is made where it is missing. "@key" is a key of the outermost board.
  Entry& At(std::string_view key);
  // Null: there is no such entry.
  Entry* Find(std::string_view key);
  // `key` here is `outer` of the parent.
  void Remap(std::string_view key, std::string_view outer);
  // Makes a key of this board, whatever is remapped.
  Entry& Own(std::string_view key);

  template <class T>
  Result<> Set(std::string_view key, const T& value) {
    return At(key).Set(value);
  }
  Result<> Set(std::string_view key, const char* text) { return At(key).AssignText(text); }
  // Fails where the entry is missing or empty, or its value can not become a T.
  template <class T>
  Result<T> Get(std::string_view key);
  template <class T>
  Result<Stamped<T>> GetStamped(std::string_view key);
  // The time of what is set from now on, in this board and all around it. A tree does this.
  void SetTime(Time now) { *clock_ = now; }

  // Sorted. Those of the outermost board around a main tree begin with '@'.
  std::vector<std::string> Keys() const;
  std::size_t size() const;
  // Whether a key is an entry of this board, and not of another one.
  bool Owns(std::string_view key) const;
  Board* parent() const { return parent_; }

 private:
  Board& Outermost() { return const_cast<Board&>(std::as_const(*this).Outermost()); }
  const Board& Outermost() const;

  Board* parent_ = nullptr;
  std::shared_ptr<Board> kept_;  // the parent, of a main tree
  bool autoremap_ = false;
  Time now_{};
  Time* clock_ = &now_;  // of the outermost board
  std::vector<std::unique_ptr<Entry>> own_;
  std::map<std::string, Entry*, std::less<>> entries_;
};

template <class T>
Result<> Entry::Set(const T& from) {
  if (type == TypeOf<T>() || type == nullptr) {
    value.Set(from);
    NoteSet();
    return Ok();
  }
  Value made;
  made.Set(from);
  return Assign(made);
}

template <class T>
Result<T> Board::Get(std::string_view key) {
  const Entry* entry = Find(key);
  if (entry == nullptr || entry->value.empty()) {
    return Error{kCodeFailed, "the blackboard has no value of '" + std::string(key) + "'"};
  }
  if (const T* value = entry->value.As<T>()) return *value;
  Value made;
  const Result<> converted = made.SetAs(*TypeOf<T>(), entry->value);
  if (!converted) return converted.error();
  return *made.As<T>();
}

template <class T>
Result<Stamped<T>> Board::GetStamped(std::string_view key) {
  Result<T> value = Get<T>(key);
  if (!value) return value.error();
  return Stamped<T>{std::move(value).value(), Find(key)->stamp()};
}

}  // namespace musher::tree
