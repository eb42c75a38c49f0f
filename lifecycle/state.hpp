#pragma once
// The states of a machine and of its actuators. A state has a name; the built-in ones have
// CyberDog's names. A config may add its own, with a rank.

#include <compare>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <ostream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace musher {

// The name of a built-in state, a constant. It is read as a text by itself.
class BuiltInState {
 public:
  explicit constexpr BuiltInState(std::string_view name) : name_(name) {}

  constexpr std::string_view name() const { return name_; }
  constexpr operator std::string_view() const {  // NOLINT(google-explicit-constructor)
    return name_;
  }

  friend constexpr bool operator==(BuiltInState, BuiltInState) = default;
  friend constexpr bool operator==(BuiltInState state, std::string_view name) {
    return state.name_ == name;
  }
  friend std::ostream& operator<<(std::ostream& out, BuiltInState state) {
    return out << state.name_;
  }

 private:
  std::string_view name_;
};

inline constexpr BuiltInState kUninitialized{"Uninitialized"};
inline constexpr BuiltInState kSetUp{"SetUp"};
inline constexpr BuiltInState kTearDown{"TearDown"};
inline constexpr BuiltInState kSelfCheck{"SelfCheck"};
inline constexpr BuiltInState kActive{"Active"};
inline constexpr BuiltInState kDeActive{"DeActive"};
inline constexpr BuiltInState kProtected{"Protected"};
inline constexpr BuiltInState kLowPower{"LowPower"};
inline constexpr BuiltInState kOta{"OTA"};
inline constexpr BuiltInState kError{"Error"};
// The state of an ended process whose last report was not received. No state of a machine.
inline constexpr BuiltInState kUnknownState{"unknown"};

// A state by its name; empty: none. A built-in state and a literal become one by themselves; any
// other text, such as the field of a message, by State(text), so that it cannot be taken for one by
// mistake. It is read as a text by itself.
class State {
 public:
  State() = default;
  State(BuiltInState state) : name_(state.name()) {}  // NOLINT(google-explicit-constructor)
  template <std::size_t kSize>
  State(const char (&literal)[kSize]) : name_(literal) {}  // NOLINT(google-explicit-constructor)
  explicit State(std::string name) : name_(std::move(name)) {}
  explicit State(std::string_view name) : name_(name) {}
  explicit State(const char* name) : name_(name) {}

  const std::string& name() const { return name_; }
  bool empty() const { return name_.empty(); }
  State Shortened() const { return State(name_.substr(0, 64)); }  // for records

  operator const std::string&() const { return name_; }  // NOLINT(google-explicit-constructor)
  operator std::string_view() const { return name_; }    // NOLINT(google-explicit-constructor)

  friend bool operator==(const State&, const State&) = default;
  friend bool operator==(const State& state, BuiltInState other) {
    return state.name_ == other.name();
  }
  friend bool operator==(const State& state, std::string_view name) { return state.name_ == name; }
  template <std::size_t kSize>
  friend bool operator==(const State& state, const char (&literal)[kSize]) {
    return state.name_ == literal;
  }
  friend auto operator<=>(const State&, const State&) = default;  // NOLINT(*-nullptr)
  friend std::string operator+(std::string before, const State& state) {
    return std::move(before) + state.name_;
  }
  friend std::string operator+(const State& state, const std::string& after) {
    return state.name_ + after;
  }
  friend std::ostream& operator<<(std::ostream& out, const State& state) {
    return out << state.name_;
  }

 private:
  std::string name_;
};

// How active a robot is in a state: TearDown 0, Error 1, OTA 2, LowPower 3, DeActive 4, Protected
// 5, Active 6. Uninitialized, SetUp and SelfCheck have none: they are steps of a start, not places
// to stay. A switch to a higher rank goes up, to a lower one down.
using Rank = int;
std::optional<Rank> BuiltInRank(std::string_view state);

// Whether the callback of a state of rank `to` raises nothing and switches nothing on of what is in
// a state of rank `from`: it leads down, or no higher than both `from` and DeActive, such as that
// of LowPower once more. nullopt is a step of a start, which counts as DeActive.
bool RaisesNothing(std::optional<Rank> from, Rank to);

// All built-in states in CyberDog's numbering, Uninitialized first.
const std::vector<BuiltInState>& BuiltInStates();
bool IsBuiltInState(std::string_view state);

// CyberDog's MachineState number, as FsMachine's `current_state` carries it: Uninitialized 0, SetUp
// 1, TearDown 2, SelfCheck 3, Active 4, DeActive 5, Protected 6, LowPower 7, OTA 8, Error 9, any
// other 10.
std::uint8_t MachineStateNumber(std::string_view state);

}  // namespace musher
