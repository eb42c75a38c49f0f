#include "musher/cli/start/progress.hpp"

#include <gtest/gtest.h>
#include <sys/socket.h>

#include <optional>
#include <vector>

#include "musher/transport/linux_event_loop.hpp"

namespace musher::cli::progress_test {

class ProgressConnection : public ::testing::Test {
 protected:
  void Receive() {
    receiver_.emplace(
        loop_, std::move(front_), [this](const Progress& p) { received_.push_back(p); },
        [this] { ++ends_; });
  }
  bool RunUntil(const std::function<bool()>& done) {
    return loop_.RunUntil(done, loop_.Now() + std::chrono::seconds(120));
  }
  static Progress Numbered(int number) {
    return {number, "switch", "legs", 7, 107, "a sentence of some length, number"};
  }

  transport::LinuxEventLoop loop_;
  UniqueFd front_;
  UniqueFd controller_;
  std::optional<ProgressReceiver> receiver_;
  std::vector<Progress> received_;
  int ends_ = 0;

  ProgressConnection() { std::tie(front_, controller_) = MakeProgressPair(); }
};

TEST_F(ProgressConnection, DeliversEachMessageWholeAndInOrder) {
  ProgressSender sender(loop_, std::move(controller_));
  Receive();
  for (int i = 0; i < 3; ++i) sender.Send(Numbered(i));
  ASSERT_TRUE(RunUntil([this] { return received_.size() == 3; }));
  for (int i = 0; i < 3; ++i) EXPECT_EQ(received_[i], Numbered(i));
}

TEST_F(ProgressConnection, NotifiesTheLauncherOnceThatTheControllerHasExited) {
  {
    ProgressSender sender(loop_, std::move(controller_));
    sender.Send(Numbered(1));
  }
  Receive();
  ASSERT_TRUE(RunUntil([this] { return ends_ > 0; }));
  EXPECT_EQ(received_.size(), 1U);
  EXPECT_EQ(ends_, 1);
}

TEST_F(ProgressConnection, DeliversTheMachineBehindTheMessagesAndOnlyItsLastState) {
  ProgressSender sender(loop_, std::move(controller_));
  for (int i = 0; i < 1000; ++i) sender.Send(Numbered(i));  // more than the socket takes
  msg::MachineStatus machine;
  for (const char* state : {"SetUp", "SelfCheck", "Active"}) {
    machine.state = state;
    sender.Send(machine);
    sender.Send(machine);
  }
  Receive();
  ASSERT_TRUE(RunUntil([this] { return received_.size() == 1001; }));
  EXPECT_EQ(received_[999], Numbered(999));
  EXPECT_EQ(received_.back().kind, Progress::kMachine);
  EXPECT_EQ(received_.back().machine, machine);
  machine.state = "LowPower";
  sender.Send(machine);
  ASSERT_TRUE(RunUntil([this] { return received_.size() == 1002; }));
  EXPECT_EQ(received_.back().machine, machine);
}

// Ctrl-Z in the terminal must not stop a robot.
TEST_F(ProgressConnection, NeverBlocksAndLosesNothingWhileTheLauncherIsStopped) {
  constexpr int kMany = 5000;  // more than the socket takes
  ProgressSender sender(loop_, std::move(controller_));
  for (int i = 0; i < kMany; ++i) sender.Send(Numbered(i));
  Receive();
  ASSERT_TRUE(RunUntil([this] { return received_.size() == kMany; }));
  EXPECT_EQ(received_.front(), Numbered(0));
  EXPECT_EQ(received_.back(), Numbered(kMany - 1));
}

TEST_F(ProgressConnection, ContinuesWithoutALauncher) {
  ProgressSender sender(loop_, std::move(controller_));
  front_ = {};
  sender.Send(Numbered(1));  // neither a signal nor an exception
  sender.Send(Numbered(2));
}

TEST_F(ProgressConnection, IgnoresWhatIsNoMessage) {
  ASSERT_EQ(send(controller_.get(), "x", 1, 0), 1);
  ProgressSender sender(loop_, std::move(controller_));
  sender.Send(Numbered(1));
  Receive();
  ASSERT_TRUE(RunUntil([this] { return !received_.empty(); }));
  EXPECT_EQ(received_.front(), Numbered(1));
}

}  // namespace musher::cli::progress_test
