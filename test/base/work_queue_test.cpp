#include "musher/base/work_queue.hpp"

#include <gmock/gmock.h>
#include <pthread.h>

#include <condition_variable>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

namespace musher::work_queue_test {

using ::testing::ElementsAre;
using Given = WorkQueue::Given;

constexpr auto kDeadline = std::chrono::seconds(120);

Time Now() {
  return std::chrono::steady_clock::now();
}

// What has run. Work that passes the gate waits until the test opens it.
class Board {
 public:
  void Add(const std::string& what) {
    const std::lock_guard lock(mutex_);
    begun_.push_back(what);
    changed_.notify_all();
  }
  void Pass(const std::string& what) {
    Add(what);
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return open_; });
  }
  void Open() {
    const std::lock_guard lock(mutex_);
    open_ = true;
    changed_.notify_all();
  }
  bool Await(std::size_t count) {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, kDeadline, [&] { return begun_.size() >= count; });
  }
  std::vector<std::string> Begun() {
    const std::lock_guard lock(mutex_);
    return begun_;
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  bool open_ = false;
  std::vector<std::string> begun_;
};

class Queue : public ::testing::Test {
 protected:
  ~Queue() override { board_->Open(); }

  // A queue whose thread is in the gate.
  void Begin(WorkQueueOptions options = {}) {
    queue_ = std::make_unique<WorkQueue>(std::move(options));
    queue_->Do([board = board_] { board->Pass("first"); });
    ASSERT_TRUE(board_->Await(1));
  }
  Given Do(const std::string& what, Work how = {}) {
    return queue_->Do([board = board_, what] { board->Add(what); }, std::move(how));
  }

  std::shared_ptr<Board> board_ = std::make_shared<Board>();
  std::unique_ptr<WorkQueue> queue_;
};

TEST_F(Queue, RunsWorkInItsOrderAndAllOfItBeforeItEnds) {
  Begin();
  Do("second");
  Do("third");
  board_->Open();
  queue_.reset();
  EXPECT_THAT(board_->Begun(), ElementsAre("first", "second", "third"));
}

TEST_F(Queue, DropsWhatWaitsAtItsEndIfThatIsItsOption) {
  Begin({.at_end = WorkQueueOptions::AtEnd::kDrop, .end_timeout = Milliseconds(1)});
  Do("second");
  queue_->End();
  EXPECT_EQ(Do("third"), Given::kRefused);
  board_->Open();
  queue_.reset();
  EXPECT_THAT(board_->Begun(), ElementsAre("first"));
}

TEST_F(Queue, KeepsOnlyTheLatestWorkOfAKey) {
  Begin();
  EXPECT_EQ(Do("old picture", {.key = "picture"}), Given::kAccepted);
  EXPECT_EQ(Do("sound", {.key = "sound"}), Given::kAccepted);
  EXPECT_EQ(Do("new picture", {.key = "picture"}), Given::kReplaced);
  board_->Open();
  EXPECT_TRUE(queue_->Flush(kDeadline));
  EXPECT_EQ(Do("next picture", {.key = "picture"}), Given::kAccepted);
  EXPECT_TRUE(queue_->Flush(kDeadline));
  EXPECT_THAT(board_->Begun(), ElementsAre("first", "sound", "new picture", "next picture"));
}

TEST_F(Queue, RefusesWorkBeyondItsLimitUntilThereIsRoom) {
  Begin({.most = 10});
  EXPECT_EQ(Do("six", {.size = 6}), Given::kAccepted);
  EXPECT_EQ(Do("five", {.size = 5}), Given::kRefused);
  EXPECT_EQ(Do("four", {.size = 4}), Given::kAccepted);
  EXPECT_EQ(Do("no size"), Given::kAccepted);
  board_->Open();
  EXPECT_TRUE(queue_->Flush(kDeadline));
  EXPECT_EQ(Do("eleven", {.size = 11}), Given::kAccepted) << "alone it is never too large";
  EXPECT_TRUE(queue_->Flush(kDeadline));
  EXPECT_THAT(board_->Begun(), ElementsAre("first", "six", "four", "no size", "eleven"));
}

TEST_F(Queue, RoomOfReplacedWorkIsFreeAgain) {
  Begin({.most = 10});
  EXPECT_EQ(Do("old", {.key = "picture", .size = 6}), Given::kAccepted);
  EXPECT_EQ(Do("new", {.key = "picture", .size = 1}), Given::kReplaced);
  EXPECT_EQ(Do("nine", {.size = 9}), Given::kAccepted);
}

TEST_F(Queue, WorkThatIsNotDueDoesNotDelayTheRest) {
  Begin();
  Do("later", {.not_before = Now() + Milliseconds(3'600'000)});
  Do("now");
  Do("soon", {.not_before = Now() + Milliseconds(1)});
  board_->Open();
  ASSERT_TRUE(board_->Await(3));
  EXPECT_THAT(board_->Begun(), ElementsAre("first", "now", "soon"));
}

TEST_F(Queue, RunsAgainWhatIsNotDone) {
  Begin();
  board_->Open();
  queue_->DoUntilDone([board = board_, left = 3]() mutable -> std::optional<Time> {
    board->Add(std::to_string(left));
    if (--left == 0) return std::nullopt;
    return Now() + Milliseconds(1);
  });
  ASSERT_TRUE(board_->Await(4));
  queue_.reset();
  EXPECT_THAT(board_->Begun(), ElementsAre("first", "3", "2", "1"));
}

TEST_F(Queue, DoesNotRunAgainWhatWasReplacedMeanwhile) {
  queue_ = std::make_unique<WorkQueue>(WorkQueueOptions{});
  queue_->DoUntilDone(
      [board = board_]() -> std::optional<Time> {
        board->Pass("old");
        return Now();
      },
      {.key = "policy"});
  ASSERT_TRUE(board_->Await(1));
  Do("new", {.key = "policy"});
  board_->Open();
  queue_.reset();
  EXPECT_THAT(board_->Begun(), ElementsAre("old", "new"));
}

TEST_F(Queue, AFlushTriesAtOnceWhatWaitsForAnotherAttempt) {
  Begin();
  board_->Open();
  queue_->DoUntilDone([board = board_]() -> std::optional<Time> {
    board->Add("try");
    return Now() + Milliseconds(3'600'000);
  });
  // Its first attempt may come before the flush, which tries again then, or by it.
  EXPECT_TRUE(queue_->Flush(kDeadline));
  const std::size_t before = board_->Begun().size();
  EXPECT_TRUE(queue_->Flush(kDeadline));
  EXPECT_EQ(board_->Begun().size(), before + 1);
}

TEST_F(Queue, RunsAtItsEndWhatIsNotDueAndTriesNothingAgain) {
  Begin();
  queue_->DoUntilDone([board = board_]() -> std::optional<Time> {
    board->Add("try");
    return Now() + Milliseconds(3'600'000);
  });
  board_->Open();
  ASSERT_TRUE(board_->Await(2));
  Do("late", {.not_before = Now() + Milliseconds(3'600'000)});
  queue_.reset();
  EXPECT_THAT(board_->Begun(), ElementsAre("first", "try", "late"));
}

TEST_F(Queue, AFlushReportsThatWorkDoesNotEndInTime) {
  Begin();
  EXPECT_FALSE(queue_->Flush(Milliseconds(1)));
  board_->Open();
  EXPECT_TRUE(queue_->Flush(kDeadline));
}

TEST_F(Queue, EndsWhileAThreadStaysInADevice) {
  Begin({.end_timeout = Milliseconds(1)});
  queue_.reset();
  board_->Open();
}

TEST_F(Queue, ItsThreadHasAName) {
  queue_ = std::make_unique<WorkQueue>(WorkQueueOptions{.name = "photos"});
  queue_->Do([board = board_] {
    char name[16] = {};
    pthread_getname_np(pthread_self(), name, sizeof name);
    board->Add(name);
  });
  queue_.reset();
  EXPECT_THAT(board_->Begun(), ElementsAre("photos"));
}

// A destructor of work that was replaced may give work itself.
TEST_F(Queue, WhatReplacedWorkOwnsMayUseTheQueue) {
  Begin();
  queue_->Do([board = board_, owned = std::shared_ptr<int>(new int(0),
                                                           [this](const int* number) {
                                                             delete number;
                                                             Do("destroyed");
                                                           })] { board->Add("old"); },
             {.key = "picture"});
  Do("new", {.key = "picture"});
  board_->Open();
  EXPECT_TRUE(queue_->Flush(kDeadline));
  EXPECT_THAT(board_->Begun(), ElementsAre("first", "new", "destroyed"));
}

}  // namespace musher::work_queue_test
