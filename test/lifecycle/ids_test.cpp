// Most of it is checked by the compiler: a number of one kind, or a plain number that is not a
// literal, cannot be given where another is expected.
#include "musher/lifecycle/ids.hpp"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <tuple>
#include <type_traits>
#include <vector>

#include "musher/lifecycle/per_actuator.hpp"

namespace musher::ids_test {

// One of each, so that a new kind is compared with all others.
using Kinds = std::tuple<Epoch, CommandNumber, Incarnation, RecordId, RequestId, RequestToken,
                         Sender, StopId, SaveNumber, ActuatorIndex>;

template <typename From, typename... To>
constexpr int ConversionsOf(std::tuple<To...>*) {
  return (static_cast<int>(std::is_convertible_v<From, To>) + ...);
}
template <typename... From>
constexpr int Conversions(std::tuple<From...>* kinds) {
  return (ConversionsOf<From>(kinds) + ...);
}
static_assert(Conversions(static_cast<Kinds*>(nullptr)) == std::tuple_size_v<Kinds>,
              "a kind of number converts to itself and to no other");

template <typename... Number>
constexpr bool ArePlain(std::tuple<Number...>*) {
  return (std::is_convertible_v<Number, std::uint64_t> || ...);
}
static_assert(!ArePlain(static_cast<Kinds*>(nullptr)), "no kind converts to a plain number");

template <typename Number>
constexpr bool kBecomesByItself =
    std::is_convertible_v<std::uint64_t, Number> || std::is_assignable_v<Number&, std::uint64_t>;
template <typename... Number>
constexpr bool BecomeByThemselves(std::tuple<Number...>*) {
  return (kBecomesByItself<Number> || ...);
}
static_assert(!BecomeByThemselves(static_cast<Kinds*>(nullptr)),
              "the field of a message converts to no kind by itself");

template <typename... Number>
constexpr bool BecomeByName(std::tuple<Number...>*) {
  return (std::is_constructible_v<Number, std::uint64_t> && ...);
}
static_assert(BecomeByName(static_cast<Kinds*>(nullptr)));
static_assert(!std::is_convertible_v<bool, StopId>, "a truth is no number");

constexpr Epoch kOfALiteral = 7;
static_assert(kOfALiteral == Epoch(std::uint64_t{7}) && kOfALiteral > 6);

template <typename... Arguments>
constexpr bool kTakesCommand = std::is_invocable_v<void (*)(Epoch, CommandNumber), Arguments...>;
static_assert(kTakesCommand<Epoch, CommandNumber> && !kTakesCommand<CommandNumber, Epoch>,
              "swapped arguments do not compile");

template <typename Values, typename Index>
concept IsIndexedBy = requires(Values& values, Index index) {
  values[index];
};
static_assert(IsIndexedBy<PerActuator<int>, ActuatorIndex>);
static_assert(!IsIndexedBy<PerActuator<int>, std::size_t> &&
              !IsIndexedBy<const PerActuator<int>, std::size_t>);
static_assert(!IsIndexedBy<std::vector<int>, ActuatorIndex>);

TEST(StrongNumber, CountsAndComparesAsItsValue) {
  Epoch epoch = 6;
  EXPECT_EQ(++epoch, Epoch(7));
  EXPECT_EQ((epoch + 3).value(), 10U);
  EXPECT_LT(epoch - 1, epoch);
  EXPECT_EQ(ToString(epoch), "7");
}

TEST(PerActuator, HasOneValueForEachIndex) {
  PerActuator<int> values = {5, 6};
  values.push_back(7);
  values[1] = 8;
  std::vector<int> found;
  for (const ActuatorIndex i : values.Indices()) found.push_back(values[i]);
  EXPECT_EQ(found, std::vector<int>({5, 8, 7}));
  EXPECT_EQ(std::vector<int>(values.begin(), values.end()), found);
  EXPECT_TRUE(values.Has(2));
  EXPECT_FALSE(values.Has(3));
  EXPECT_FALSE(PerActuator<int>().Has(0));
}

TEST(PerActuator, HoldsTruthValues) {
  PerActuator<bool> running(2, false);
  running[1] = true;
  EXPECT_EQ(running, PerActuator<bool>({false, true}));
  running.resize(3);
  EXPECT_FALSE(running[2]);
}

}  // namespace musher::ids_test
