#include "musher/cli/machine/cpu_shortage.hpp"

#include <gtest/gtest.h>

namespace musher::cli::cpu_shortage_test {

// A process of one thread that has waited for a CPU for so long, at a time.
ProcessSample Sample(Duration at, Duration waited) {
  ProcessSample sample;
  sample.at = Time(at);
  sample.threads[1] = {{Duration{}, waited}, false};
  return sample;
}

constexpr Duration kBegin = std::chrono::seconds(100);
constexpr Duration kEnd = kBegin + kShortageWindow;
constexpr Duration kLittle = Milliseconds(20);
constexpr Duration kMuch = Milliseconds(400);

ShortageSample Before() {
  return {Sample(kBegin, Duration{}), Sample(kBegin, Duration{})};
}

TEST(ShortageOfCpu, IsOfAControllerThatWaitedForACpuForAPartOfTheTime) {
  const ShortageSample after{Sample(kEnd, kMuch), Sample(kEnd, kLittle)};
  EXPECT_EQ(FindShortage(Before(), after), CpuShortage::kOfController);
}

TEST(ShortageOfCpu, IsOfTheHostWhereTheCommandItselfWaited) {
  const ShortageSample after{Sample(kEnd, kLittle), Sample(kEnd, kMuch)};
  EXPECT_EQ(FindShortage(Before(), after), CpuShortage::kOfCommand);
}

TEST(ShortageOfCpu, IsNoneWhereBothGotACpuWhenTheyWanted) {
  const ShortageSample after{Sample(kEnd, kLittle), Sample(kEnd, kLittle)};
  EXPECT_EQ(FindShortage(Before(), after), CpuShortage::kNone);
}

TEST(ShortageOfCpu, IsNoneOfAControllerThatHasExitedOrIsStoppedHoweverBusyTheHostIs) {
  const ShortageSample after{std::nullopt, Sample(kEnd, kMuch)};
  EXPECT_EQ(FindShortage(Before(), after), CpuShortage::kNone);
}

}  // namespace musher::cli::cpu_shortage_test
