// The event loop, real and simulated.

#include <gmock/gmock.h>

#include <string>
#include <vector>

#include "musher/test/contract/world.hpp"

namespace musher::transport::loop_test {

using ::testing::ElementsAre;

class Loop : public Contract {};
MUSHER_ON_EVERY_TRANSPORT(Loop);

TEST_P(Loop, RunsTimersInTheOrderTheyBecomeDue) {
  const Time now = loop().Now();
  std::vector<int> order;
  const auto third = loop().At(now + Milliseconds(3), [&] { order.push_back(3); });
  const auto first = loop().At(now + Milliseconds(1), [&] { order.push_back(1); });
  const auto second = loop().At(now + Milliseconds(2), [&] { order.push_back(2); });
  const auto same = loop().At(now + Milliseconds(2), [&] { order.push_back(20); });
  ASSERT_TRUE(RunUntil([&] { return order.size() == 4; }));
  EXPECT_THAT(order, ElementsAre(1, 2, 20, 3));
  EXPECT_GE(loop().Now(), now + Milliseconds(3));
}

TEST_P(Loop, RunsATimerOfThePastAtOnceButNotInsideAt) {
  bool ran = false;
  const auto timer = loop().At(loop().Now() - Milliseconds(5), [&] { ran = true; });
  EXPECT_FALSE(ran);
  EXPECT_TRUE(RunUntil([&] { return ran; }));
}

TEST_P(Loop, RepeatsAnEveryTimerUntilItIsDropped) {
  int ticks = 0;
  LoopHandlePtr ticker;
  ticker = loop().Every(Milliseconds(2), [&] {
    if (++ticks == 3) ticker.reset();
  });
  bool later = false;
  const Time began = loop().Now();
  const auto end = loop().At(began + Milliseconds(30), [&] { later = true; });
  ASSERT_TRUE(RunUntil([&] { return later; }));
  EXPECT_EQ(ticks, 3);
}

TEST_P(Loop, DoesNotRunADroppedTimerThatWasAlreadyDue) {
  const Time now = loop().Now();
  bool ran = false;
  LoopHandlePtr second;
  const auto first = loop().At(now, [&] { second.reset(); });
  second = loop().At(now, [&] { ran = true; });
  bool later = false;
  const auto third = loop().At(now, [&] { later = true; });
  ASSERT_TRUE(RunUntil([&] { return later; }));
  EXPECT_FALSE(ran);
}

TEST_P(Loop, RunsPostedWorkInOrderAndNotInsidePost) {
  std::vector<int> order;
  loop().Post([&] {
    order.push_back(1);
    loop().Post([&] { order.push_back(3); });
    order.push_back(2);
  });
  EXPECT_TRUE(order.empty());
  ASSERT_TRUE(RunUntil([&] { return order.size() == 3; }));
  EXPECT_THAT(order, ElementsAre(1, 2, 3));
}

TEST_P(Loop, RunUntilChecksAfterEveryEvent) {
  int ran = 0;
  for (int i = 0; i < 3; ++i) loop().Post([&] { ++ran; });
  ASSERT_TRUE(RunUntil([&] { return ran == 2; }));
  EXPECT_EQ(ran, 2);
  EXPECT_TRUE(RunUntil([&] { return ran == 3; }));
}

TEST_P(Loop, RunUntilGivesUpAtItsDeadline) {
  const Time deadline = loop().Now() + Milliseconds(10);
  EXPECT_FALSE(loop().RunUntil([] { return false; }, deadline));
  EXPECT_GE(loop().Now(), deadline);
}

TEST_P(Loop, StopEndsRunAlsoBeforehandAndOnlyOnce) {
  loop().Stop();
  loop().Run();
  bool ran = false;
  loop().Post([&] {
    ran = true;
    loop().Stop();
  });
  loop().Run();
  EXPECT_TRUE(ran);
}

}  // namespace musher::transport::loop_test
