// A search of the host holds up nothing, however long it takes.

#include "musher/view/live/host_search.hpp"

#include <gmock/gmock.h>

#include <future>

#include "musher/transport/linux_event_loop.hpp"

namespace musher::view::host_search_test {

using std::chrono::seconds;

TEST(AHostSearch, RunsBesideTheLoopAndItsResultOnTheLoop) {
  transport::LinuxEventLoop loop;
  std::promise<void> answers;
  HostSearch search(loop, [answer = answers.get_future().share()] {
    answer.wait();
    return HostSearch::Machines{{{"dog", "uuid-a"}}};
  });
  std::vector<HostSearch::Machines> found;
  for (int i = 0; i < 2; ++i) {
    search.Begin([&found](HostSearch::Machines machines) { found.push_back(std::move(machines)); });
  }
  bool ran = false;
  loop.Post([&ran] { ran = true; });
  EXPECT_TRUE(loop.RunUntil([&ran] { return ran; }, loop.Now() + seconds(120)));
  EXPECT_TRUE(found.empty());
  answers.set_value();
  EXPECT_TRUE(loop.RunUntil([&found] { return found.size() == 2; }, loop.Now() + seconds(120)));
  EXPECT_EQ(found.front().front().identity.name, "dog");
}

TEST(AHostSearch, ThatHangsIsLeftBehind) {
  std::promise<void> begun;
  std::promise<void> answers;
  std::promise<void> ended;
  bool reported = false;
  {
    transport::LinuxEventLoop loop;
    HostSearch search(loop, [answer = answers.get_future().share(), &begun, &ended] {
      begun.set_value();
      answer.wait();
      ended.set_value();
      return HostSearch::Machines{};
    });
    search.Begin([&reported](const HostSearch::Machines&) { reported = true; });
    begun.get_future().wait();
  }
  answers.set_value();
  ended.get_future().wait();
  EXPECT_FALSE(reported);
}

}  // namespace musher::view::host_search_test
