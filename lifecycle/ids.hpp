#pragma once
// The numbers that name things, each of its own type: two of them cannot be swapped. Values, from
// any thread; only a literal becomes one by itself, a number of a message or of a file by name.

#include <compare>
#include <concepts>
#include <cstdint>
#include <ostream>
#include <string>

namespace musher {

// The type of a literal. A std::uint64_t is none: that of a message or of a file has this type.
template <typename T>
concept LiteralNumber =
    std::integral<T> && !std::same_as<T, bool> && !std::same_as<T, std::uint64_t>;

// A number that converts to no other kind, and to no plain number: value() is the way back.
template <typename Kind>
class StrongNumber {
 public:
  constexpr StrongNumber() = default;
  // A literal converts by itself, `Epoch epoch = 0;`: its value is known to the compiler. Where a
  // template passes it on, it no longer is; there the kind has to be named.
  template <LiteralNumber T>
  consteval StrongNumber(T literal)  // NOLINT(google-explicit-constructor)
      : value_(static_cast<std::uint64_t>(literal)) {}
  // Any other number becomes one by name, `Epoch(message.epoch)`.
  constexpr explicit StrongNumber(std::uint64_t value) : value_(value) {}

  constexpr std::uint64_t value() const { return value_; }

  constexpr StrongNumber& operator++() {
    ++value_;
    return *this;
  }
  constexpr StrongNumber operator++(int) { return StrongNumber(value_++); }
  friend constexpr StrongNumber operator+(StrongNumber number, std::uint64_t more) {
    return StrongNumber(number.value_ + more);
  }
  friend constexpr StrongNumber operator-(StrongNumber number, std::uint64_t less) {
    return StrongNumber(number.value_ - less);
  }
  constexpr StrongNumber& operator+=(std::uint64_t more) { return *this = *this + more; }
  constexpr StrongNumber& operator-=(std::uint64_t less) { return *this = *this - less; }
  friend constexpr bool operator==(StrongNumber, StrongNumber) = default;
  friend constexpr auto operator<=>(StrongNumber, StrongNumber) = default;  // NOLINT(*-nullptr)
  friend std::ostream& operator<<(std::ostream& out, StrongNumber number) {
    return out << number.value_;
  }

 private:
  std::uint64_t value_ = 0;
};

template <typename Kind>
std::string ToString(StrongNumber<Kind> number) {
  return std::to_string(number.value());
}

// Number of a leading controller: the next one has a higher epoch.
using Epoch = StrongNumber<struct EpochKind>;
// Number of a switch or of a command to an actuator: both grow together in an epoch. 0: none.
using CommandNumber = StrongNumber<struct CommandKind>;
// Number of an actuator's process: grows with every start on a host. 0: not known.
using Incarnation = StrongNumber<struct IncarnationKind>;
// Number of a record, from 1 in a controller; as a cause, the record that another follows from. 0:
// none.
using RecordId = StrongNumber<struct RecordKind>;
// Id of a request to the controller, which gets exactly one reply; its shell has the client.
using RequestId = StrongNumber<struct RequestKind>;
// Id of a request to an actuator, which gets exactly one reply; its shell has the client.
using RequestToken = StrongNumber<struct TokenKind>;
// The participant that sent a sample, as the transport reports it. 0: unknown.
using Sender = StrongNumber<struct SenderKind>;
// Id of an emergency stop: random, from the participant that engaged it. 0: none.
using StopId = StrongNumber<struct StopKind>;
// Number of a save on disk, grows from 1 in a controller.
using SaveNumber = StrongNumber<struct SaveKind>;
// Which actuator, in the order of the config; indexes a PerActuator.
using ActuatorIndex = StrongNumber<struct ActuatorKind>;

}  // namespace musher
