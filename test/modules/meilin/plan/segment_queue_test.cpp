// The segments that a mission has still to do.

#include "musher/modules/meilin/plan/segment_queue.hpp"

#include <gtest/gtest.h>

namespace musher::meilin::segment_queue_test {
namespace {

std::vector<Segment> Some(int count) {
  std::vector<Segment> segments(static_cast<std::size_t>(count));
  for (int index = 0; index < count; ++index) {
    segments[static_cast<std::size_t>(index)].index = index;
  }
  return segments;
}

TEST(SegmentQueue, HandsOutEachSegmentOnceInOrder) {
  SegmentQueue queue(Some(3), "plan_1");
  EXPECT_EQ(queue.size(), 3U);
  EXPECT_EQ(queue.Pop()->index, 0);
  EXPECT_EQ(queue.Pop()->index, 1);
  EXPECT_EQ(queue.size(), 1U);
  EXPECT_EQ(queue.total(), 3U);
  EXPECT_EQ(queue.Pop()->index, 2);
  EXPECT_EQ(queue.Pop(), std::nullopt);
  EXPECT_TRUE(queue.empty());
}

TEST(SegmentQueue, DropsTheRestForAnotherPlan) {
  SegmentQueue queue(Some(3), "plan_1");
  queue.Pop();
  queue.Replace(Some(2), "plan_2");
  EXPECT_EQ(queue.size(), 2U);
  EXPECT_EQ(queue.plan_id(), "plan_2");
  EXPECT_EQ(queue.Pop()->index, 0);
  queue.Clear();
  EXPECT_TRUE(queue.empty());
  EXPECT_EQ(queue.plan_id(), "");
}

}  // namespace
}  // namespace musher::meilin::segment_queue_test
