// The disk of these tests is a gate: work waits in it until the test opens it.

#include "musher/transport/disk_writer.hpp"

#include <gmock/gmock.h>

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <stdexcept>
#include <string>
#include <vector>

#include "musher/transport/linux_event_loop.hpp"

namespace musher::disk_writer_test {

using ::testing::ElementsAre;

// Shared with work that may outlive the test's body.
struct Gate {
  std::mutex mutex;
  std::condition_variable changed;
  bool open = false;
  std::vector<std::string> begun;
  Result<> outcome;

  Result<> Pass(const std::string& what) {
    std::unique_lock lock(mutex);
    begun.push_back(what);
    changed.notify_all();
    changed.wait(lock, [this] { return open; });
    return outcome;
  }
  void Open(const Result<>& result = Ok()) {
    const std::lock_guard lock(mutex);
    outcome = result;
    open = true;
    changed.notify_all();
  }
  void AwaitBegun(std::size_t count) {
    std::unique_lock lock(mutex);
    EXPECT_TRUE(
        changed.wait_for(lock, std::chrono::seconds(20), [&] { return begun.size() >= count; }));
  }
  std::vector<std::string> Begun() {
    const std::lock_guard lock(mutex);
    return begun;
  }
};

class Writer : public ::testing::Test {
 protected:
  ~Writer() override { gate_->Open(); }

  void Do(const std::string& key, const std::string& what) {
    writer_->Do(
        key, [gate = gate_, what] { return gate->Pass(what); },
        [this, what](const Result<>& result) {
          ended_.push_back(what + (result ? "" : ": " + result.error().message));
        });
  }
  bool AwaitEnds(std::size_t count) {
    return loop_.RunUntil([&] { return ended_.size() >= count; },
                          loop_.Now() + std::chrono::seconds(120));
  }
  static transport::DiskWriterOptions Options() {
    transport::DiskWriterOptions options;
    options.retry_period = Milliseconds(1);
    options.timeout = Milliseconds(20'000);
    return options;
  }

  transport::LinuxEventLoop loop_;
  std::shared_ptr<Gate> gate_ = std::make_shared<Gate>();
  std::vector<std::string> ended_;
  std::unique_ptr<transport::DiskWriter> writer_ =
      std::make_unique<transport::DiskWriter>(loop_, Options());
};

TEST_F(Writer, ReportsTheEndOnTheLoop) {
  gate_->Open();
  Do("policy", "one");
  EXPECT_TRUE(writer_->Flush(std::chrono::seconds(20)));
  EXPECT_THAT(ended_, ElementsAre()) << "the loop has not run yet";
  ASSERT_TRUE(AwaitEnds(1));
  EXPECT_THAT(ended_, ElementsAre("one"));
}

TEST_F(Writer, DoesNotHoldUpTheLoopWhileTheDiskStalls) {
  Do("emergency stop", "one");
  gate_->AwaitBegun(1);
  bool turned = false;
  loop_.Post([&] { turned = true; });
  EXPECT_TRUE(loop_.RunUntil([&] { return turned; }, loop_.Now() + std::chrono::seconds(120)));
  EXPECT_THAT(ended_, ElementsAre());
  gate_->Open();
  ASSERT_TRUE(AwaitEnds(1));
}

TEST_F(Writer, KeepsOnlyTheLastWaitingJobOfAKey) {
  Do("epoch", "epoch 1");
  gate_->AwaitBegun(1);
  for (int i = 0; i < 1000; ++i) Do("policy", "policy " + std::to_string(i));
  Do("emergency stop", "stop");
  gate_->Open();
  ASSERT_TRUE(AwaitEnds(3));
  EXPECT_THAT(gate_->Begun(), ElementsAre("epoch 1", "policy 999", "stop"));
  EXPECT_THAT(ended_, ElementsAre("epoch 1", "policy 999", "stop"));
}

TEST_F(Writer, ReportsNothingOfAJobThatWasReplacedWhileItRan) {
  Do("policy", "old");
  gate_->AwaitBegun(1);
  Do("policy", "new");
  gate_->Open();
  ASSERT_TRUE(AwaitEnds(1));
  EXPECT_TRUE(writer_->Flush(std::chrono::seconds(20)));
  loop_.RunUntil([] { return false; }, loop_.Now());
  EXPECT_THAT(ended_, ElementsAre("new")) << "the old value on disk is not the requested one";
}

TEST_F(Writer, ReportsAFailureOnceAndTheSuccessOfALaterAttempt) {
  gate_->Open(Error{kCodeFailed, "no space"});
  Do("policy", "one");
  gate_->AwaitBegun(5);
  ASSERT_TRUE(AwaitEnds(1));
  gate_->Open();
  ASSERT_TRUE(AwaitEnds(2));
  EXPECT_THAT(ended_, ElementsAre("one: no space", "one"));
}

TEST_F(Writer, TriesAFailedJobNoMoreOnceAnotherOfItsKeyCame) {
  gate_->Open(Error{kCodeFailed, "no space"});
  Do("policy", "old");
  ASSERT_TRUE(AwaitEnds(1));
  Do("policy", "new");
  ASSERT_TRUE(AwaitEnds(2));
  const std::size_t tried = gate_->Begun().size();
  gate_->AwaitBegun(tried + 3);
  EXPECT_EQ(gate_->Begun().back(), "new");
  EXPECT_THAT(ended_, ElementsAre("old: no space", "new: no space"));
}

TEST_F(Writer, TakesAnExceptionForAFailure) {
  std::string why;
  writer_->Do(
      "log", []() -> Result<> { throw std::runtime_error("out of memory"); },
      [&](const Result<>& result) { why = result ? "" : result.error().message; });
  EXPECT_TRUE(
      loop_.RunUntil([&] { return !why.empty(); }, loop_.Now() + std::chrono::seconds(120)));
  EXPECT_EQ(why, "out of memory");
}

TEST_F(Writer, ReportsThatAStalledDiskWasNotFlushed) {
  Do("policy", "one");
  gate_->AwaitBegun(1);
  EXPECT_FALSE(writer_->Flush(Milliseconds(1)));
  gate_->Open();
  EXPECT_TRUE(writer_->Flush(std::chrono::seconds(20)));
}

TEST_F(Writer, DoesWhatWaitsBeforeItIsDestroyed) {
  gate_->Open();
  Do("policy", "one");
  Do("emergency stop", "two");
  writer_.reset();
  EXPECT_THAT(gate_->Begun(), ElementsAre("one", "two"));
  loop_.RunUntil([] { return false; }, loop_.Now());
  EXPECT_THAT(ended_, ElementsAre()) << "a callback ran after the writer was destroyed";
}

TEST_F(Writer, IsDestroyedWhileTheDiskStalls) {
  transport::DiskWriterOptions options = Options();
  options.timeout = Milliseconds(1);
  writer_ = std::make_unique<transport::DiskWriter>(loop_, options);
  Do("policy", "one");
  gate_->AwaitBegun(1);
  writer_.reset();
  gate_->Open();
}

}  // namespace musher::disk_writer_test
