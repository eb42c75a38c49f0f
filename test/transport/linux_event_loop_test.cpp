// What only the real loop can do: other threads, file descriptors, sleeping.

#include "musher/transport/linux_event_loop.hpp"

#include <gmock/gmock.h>
#include <sys/eventfd.h>
#include <sys/resource.h>
#include <unistd.h>

#include <thread>
#include <vector>

#include "musher/base/unique_fd.hpp"
#include "musher/messages/std_srvs/trigger.hpp"
#include "musher/test/support/domain.hpp"
#include "musher/transport/dds/dds_node.hpp"
#include "musher/transport/dds/node_thread.hpp"
#include "musher/transport/service.hpp"

namespace musher::transport::linux_event_loop_test {

constexpr Duration kLong = std::chrono::seconds(20);

class LinuxLoop : public ::testing::Test {
 protected:
  bool RunUntil(const std::function<bool()>& done) {
    return loop_.RunUntil(done, loop_.Now() + kLong);
  }
  static void Signal(const UniqueFd& event) {
    const std::uint64_t one = 1;
    ASSERT_EQ(write(event.get(), &one, sizeof(one)), static_cast<ssize_t>(sizeof(one)));
  }
  static UniqueFd MakeEvent() { return UniqueFd(eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)); }

  LinuxEventLoop loop_;
};

TEST_F(LinuxLoop, RunsWorkPostedFromOtherThreadsOnItsOwn) {
  constexpr int kThreads = 4, kEach = 2000;
  const auto loop_thread = std::this_thread::get_id();
  std::vector<int> next(kThreads, 0);
  std::vector<std::jthread> threads;
  for (int t = 0; t < kThreads; ++t) {
    threads.emplace_back([&, t] {
      for (int i = 0; i < kEach; ++i) {
        loop_.Post([&, t, i] {
          EXPECT_EQ(std::this_thread::get_id(), loop_thread);
          EXPECT_EQ(next[t]++, i) << "the order of a thread is kept";
        });
      }
    });
  }
  EXPECT_TRUE(RunUntil([&] { return next == std::vector<int>(kThreads, kEach); }));
}

TEST_F(LinuxLoop, WakesUpForWorkFromAnotherThread) {
  // Each side waits for the other, so that a wake-up which is lost shows as a stall.
  int rounds = 0;
  std::atomic<int> seen = 0;
  std::jthread other([&] {
    for (int i = 0; i < 500; ++i) {
      loop_.Post([&] {
        ++rounds;
        seen = rounds;
        seen.notify_one();
      });
      seen.wait(i);
    }
  });
  EXPECT_TRUE(RunUntil([&] { return rounds == 500; }));
}

using LinuxLoopDeathTest = LinuxLoop;

// Such a call would race with the loop.
TEST_F(LinuxLoopDeathTest, EndsTheProgramWhenAnotherThreadUsesItWhileItRuns) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_DEATH(
      {
        std::thread other;
        loop_.Post([&] { other = std::thread([&] { (void)loop_.At(Time::max(), [] {}); }); });
        RunUntil([] { return false; });
      },
      "called on another thread than the loop's");
}

// It would wait for ever.
TEST_F(LinuxLoopDeathTest, EndsTheProgramWhenAHandlerWaitsForItsOwnLoop) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_DEATH(
      {
        DdsOptions options;
        options.domain_id = TestDomain();
        const auto node = NodeThread::Start(options).value();
        node->RunOnLoop([&] { node->RunOnLoop([] {}); });
      },
      "called on the loop itself");
}

// A service's reply may be kept and given later, but on the loop only.
TEST_F(LinuxLoopDeathTest, EndsTheProgramWhenAnotherThreadReplies) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_DEATH(
      {
        DdsOptions options;
        options.domain_id = TestDomain();
        const auto node = MakeDdsNode(loop_, options).value();
        std::thread other;
        const auto server = MakeServer<msg::Trigger>(*node, "reset", [&](const auto&, auto reply) {
                              other = std::thread([reply] { reply({true, "done"}); });
                            }).value();
        const auto client = MakeClient<msg::Trigger>(*node, "reset").value();
        client->Call({}, std::chrono::seconds(10), [](const auto&) {});
        RunUntil([] { return false; });
      },
      "called on another thread than the loop's");
}

TEST_F(LinuxLoop, MayBeUsedByAnyThreadWhileNoneRunsIt) {
  LoopHandlePtr timer;
  std::thread([&] { timer = loop_.At(Time::max(), [] {}); }).join();
  EXPECT_NE(timer, nullptr);
}

TEST_F(LinuxLoop, StopsFromAnotherThread) {
  std::jthread other([&] { loop_.Stop(); });
  loop_.Run();
}

TEST_F(LinuxLoop, RunsACallbackWhileItsFileDescriptorIsReadable) {
  const UniqueFd event = MakeEvent();
  int calls = 0;
  const auto watch = loop_.WhenReadable(event.get(), [&] {
    if (++calls < 3) return;  // not read yet: called again
    std::uint64_t value = 0;
    EXPECT_EQ(read(event.get(), &value, sizeof(value)), static_cast<ssize_t>(sizeof(value)));
  });
  EXPECT_FALSE(loop_.RunUntil([&] { return calls > 0; }, loop_.Now() + Milliseconds(5)));
  Signal(event);
  ASSERT_TRUE(RunUntil([&] { return calls == 3; }));
  EXPECT_FALSE(loop_.RunUntil([&] { return calls > 3; }, loop_.Now() + Milliseconds(5)));
}

TEST_F(LinuxLoop, DoesNotCallAWatchThatAnotherHasDropped) {
  const UniqueFd one = MakeEvent(), two = MakeEvent();
  int calls = 0;
  LoopHandlePtr first, second;
  first = loop_.WhenReadable(one.get(), [&] {
    ++calls;
    first.reset();
    second.reset();
  });
  second = loop_.WhenReadable(two.get(), [&] {
    ++calls;
    first.reset();
    second.reset();
  });
  Signal(one);
  Signal(two);
  ASSERT_TRUE(RunUntil([&] { return calls > 0; }));
  EXPECT_FALSE(loop_.RunUntil([&] { return calls > 1; }, loop_.Now() + Milliseconds(5)));
}

TEST_F(LinuxLoop, LetsNeitherWorkNorTimersNorFilesStarveTheOthers) {
  const UniqueFd event = MakeEvent();
  Signal(event);  // stays readable
  int posted = 0, ticks = 0, reads = 0;
  std::function<void()> again = [&] {
    ++posted;
    loop_.Post(again);
  };
  loop_.Post(again);
  const auto ticker = loop_.Every(std::chrono::microseconds(1), [&] { ++ticks; });
  const auto watch = loop_.WhenReadable(event.get(), [&] { ++reads; });
  EXPECT_TRUE(RunUntil([&] { return posted > 100 && ticks > 100 && reads > 100; }));
}

TEST_F(LinuxLoop, DoesNotWakeUpWhileThereIsNothingToDo) {
  const auto far = loop_.At(loop_.Now() + std::chrono::hours(1), [] {});
  rusage before{}, after{};
  getrusage(RUSAGE_THREAD, &before);
  EXPECT_FALSE(loop_.RunUntil([] { return false; }, loop_.Now() + Milliseconds(100)));
  getrusage(RUSAGE_THREAD, &after);
  EXPECT_LE(after.ru_nvcsw - before.ru_nvcsw, 2) << "it went to sleep more than once";
}

TEST_F(LinuxLoop, DoesNotMakeUpForMissedPeriods) {
  int ticks = 0;
  const Time start = loop_.Now();
  const auto ticker = loop_.Every(Milliseconds(1), [&] {
    if (++ticks > 1) return;
    while (loop_.Now() < start + Milliseconds(20)) {  // a callback that takes too long
    }
  });
  ASSERT_TRUE(RunUntil([&] { return ticks == 2; }));
  EXPECT_GE(loop_.Now(), start + Milliseconds(20));
  EXPECT_FALSE(loop_.RunUntil([&] { return ticks >= 15; }, start + Milliseconds(26)));
}

}  // namespace musher::transport::linux_event_loop_test
