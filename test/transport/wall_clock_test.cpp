// Cyclone and a wall clock that is set.

#include <gtest/gtest.h>
#include <pthread.h>

#include <atomic>
#include <optional>
#include <string>

#include "musher/messages/std_msgs/string.hpp"
#include "musher/test/support/domain.hpp"
#include "musher/transport/dds/dds_node.hpp"
#include "musher/transport/linux_event_loop.hpp"

namespace {

std::atomic<int> waits_by_the_wall_clock = 0;

}  // namespace

// In place of the one of the C library: Cyclone's own waits end with it. A wait of the C++ library
// is one of the steady clock, and does not call it.
extern "C" int pthread_cond_timedwait(pthread_cond_t* cond, pthread_mutex_t* mutex,
                                      const timespec* until) {
  ++waits_by_the_wall_clock;
  return pthread_cond_clockwait(cond, mutex, CLOCK_REALTIME, until);
}

namespace musher::transport::wall_clock_test {

TEST(Cyclone, DoesNotWaitForATimeOfTheWallClockWhichMayBeSetBack) {
  waits_by_the_wall_clock = 0;
  LinuxEventLoop loop;
  const auto node = MakeDdsNode(loop, {.domain_id = TestDomain()});
  ASSERT_TRUE(node) << node.error().message;
  std::optional<std::string> received;
  const auto reader = MakeSubscription<msg::String>(
      *node.value(), "chat", [&](const msg::String& text, const auto&) { received = text.data; });
  const auto writer = MakePublisher<msg::String>(*node.value(), "chat");
  ASSERT_TRUE(reader && writer);
  const auto repeat = loop.Every(
      Milliseconds(10), [&] { static_cast<void>(writer.value()->Publish(msg::String{"hello"})); });
  loop.RunUntil([&] { return received.has_value(); }, loop.Now() + std::chrono::seconds(60));
  EXPECT_EQ(received, "hello");
  EXPECT_EQ(waits_by_the_wall_clock, 0);
}

}  // namespace musher::transport::wall_clock_test
