// The sessions of the page on a disk that works, fails or hangs.

#include "musher/view/live/session_saver.hpp"

#include <gmock/gmock.h>

#include <future>
#include <string>
#include <utility>
#include <vector>

#include "musher/transport/linux_event_loop.hpp"

namespace musher::view::session_saver_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class SessionsOnDisk : public ::testing::Test {
 protected:
  ~SessionsOnDisk() override { Open(); }

  // The disk hangs until it is opened.
  void Open() {
    if (!std::exchange(open_, true)) gate_.set_value();
  }
  SessionSaver::Then Collect() {
    return
        [this](const Result<>& kept) { answers_.push_back(kept ? "kept" : kept.error().message); };
  }
  bool Answered(std::size_t count) {
    return loop_.RunUntil([&] { return answers_.size() >= count; },
                          loop_.Now() + std::chrono::seconds(120));
  }

  transport::LinuxEventLoop loop_;
  std::promise<void> gate_;
  bool open_ = false;
  std::vector<std::string> answers_;
  SessionSaver::Write write_ = [opened = gate_.get_future().share(), this](const auto&,
                                                                           std::int64_t) {
    opened.wait();
    return outcome_;
  };
  Result<> outcome_;  // of a write
};

// A view that was killed at that moment knew the session again.
TEST_F(SessionsOnDisk, AreSaidToHaveEndedOnceThatIsOnDisk) {
  SessionSaver saver(loop_, write_);
  saver.Save({}, 7, Collect());
  bool later = false;
  const auto timer = loop_.At(loop_.Now() + Milliseconds(20), [&later] { later = true; });
  ASSERT_TRUE(loop_.RunUntil([&later] { return later; }, loop_.Now() + std::chrono::seconds(120)))
      << "the loop does not wait for the disk";
  EXPECT_THAT(answers_, IsEmpty());
  Open();
  ASSERT_TRUE(Answered(1));
  EXPECT_THAT(answers_, ElementsAre("kept"));
}

TEST_F(SessionsOnDisk, AreAnsweredByALaterWrite) {
  SessionSaver saver(loop_, write_);
  saver.Save({}, 7, Collect());
  saver.Save({{"id", "anna", Duration{}}}, 8);
  Open();
  ASSERT_TRUE(Answered(1));
  EXPECT_THAT(answers_, ElementsAre("kept"));
}

TEST_F(SessionsOnDisk, AreAnsweredInTimeWhileTheDiskHangs) {
  SessionSaver saver(loop_, write_, Milliseconds(50));
  saver.Save({}, 7, Collect());
  ASSERT_TRUE(Answered(1));
  EXPECT_THAT(answers_, ElementsAre("the disk does not answer"));
  Open();
}

TEST_F(SessionsOnDisk, SayWhyTheyAreNotOnIt) {
  outcome_ = Error{kCodeFailed, "No space left on device"};
  Open();
  SessionSaver saver(loop_, write_);
  saver.Save({}, 7, Collect());
  ASSERT_TRUE(Answered(1));
  EXPECT_THAT(answers_, ElementsAre(HasSubstr("No space left")));
}

TEST_F(SessionsOnDisk, AreAnsweredAtOnceWhereNoneAreKept) {
  SessionSaver saver(loop_, nullptr);
  saver.Save({}, 7, Collect());
  EXPECT_THAT(answers_, ElementsAre("kept"));
}

}  // namespace musher::view::session_saver_test
