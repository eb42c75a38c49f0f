#include "musher/view/live/page_queue.hpp"

#include <gmock/gmock.h>

namespace musher::view::page_queue_test {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

SharedText Text(std::string text) {
  return std::make_shared<const std::string>(std::move(text));
}

std::vector<std::string> Taken(PageQueue& queue) {
  std::vector<std::string> texts;
  for (const SharedText& text : queue.TakeAll()) texts.push_back(*text);
  return texts;
}

TEST(PageQueueTest, KeepsTheNewestOfEachKindInTheOrderInWhichTheyCame) {
  PageQueue queue;
  EXPECT_TRUE(queue.empty());
  queue.Put("status", Text("1"));
  queue.Put("topics", Text("2"));
  queue.Put("status", Text("3"));
  EXPECT_FALSE(queue.empty());
  EXPECT_THAT(Taken(queue), ElementsAre("3", "2"));
  EXPECT_TRUE(queue.empty());
  EXPECT_THAT(Taken(queue), IsEmpty());
}

TEST(PageQueueTest, KeepsEveryEntryOfTheHistory) {
  PageQueue queue;
  queue.PutEntry(Text("{\"id\":1}"));
  queue.PutEntry(Text("{\"id\":2}"));
  EXPECT_THAT(Taken(queue),
              ElementsAre(R"({"op":"history","reset":false,"entries":[{"id":1},{"id":2}]})"));
}

TEST(PageQueueTest, DropsTheEntriesOfAPageThatSleepsAndReportsIt) {
  PageQueue queue;
  for (std::size_t i = 0; i < 100 * PageQueue::kMostEntries; ++i) queue.PutEntry(Text("{}"));
  EXPECT_TRUE(queue.history_lost());
  EXPECT_FALSE(queue.empty());
  EXPECT_THAT(Taken(queue), IsEmpty());
  EXPECT_FALSE(queue.history_lost());
}

}  // namespace musher::view::page_queue_test
