// A robot that moves only while `musher permit` runs.

#include <signal.h>

#include "musher/test/integration/cli/machine.hpp"

namespace musher::testing::permit_test {

using ::testing::HasSubstr;

class MovesByPermit : public MachineByCli {
 protected:
  MovesByPermit() { std::ofstream(config_, std::ios::app) << "[safety]\npermit_ms = 2000\n"; }

  std::unique_ptr<Process> Permit() {
    auto permit = std::make_unique<Process>(Command({"permit"}));
    EXPECT_NE(permit->LineWith("robot may move while this command runs; it stops 2000 ms after"),
              "");
    return permit;
  }
  // Without permits the start does not become Active: the machine is stopped by itself.
  void StartStopped() {
    up_ = std::make_unique<Process>(Command({"up", config_}));
    ASSERT_NE(up_->LineWith("emergency stop"), "");
    history_ = std::make_unique<Process>(Command({"history", "-f"}));
    ASSERT_TRUE(AwaitStop("no permit to move has arrived"));
  }
  // The next such stop in the history: each actuator may engage one of its own.
  bool AwaitStop(const std::string& reason) const {
    const std::string line = history_->LineWith(reason);
    EXPECT_THAT(line, HasSubstr("engaged by [safety] permit_ms"))
        << Musher({"history"}).out << Musher({"status"}).out;
    return !line.empty();
  }
  // Until all of it moves: an actuator of a later stage waits for a permit of its own. One that the
  // new permits have not reached at the release stops again.
  void Move() {
    Ended set;
    ASSERT_TRUE(Until([&] {
      Musher({"estop", "--release"});
      set = Musher({"set", "Active"});
      return set.exit == 0;
    })) << set.err;
    ASSERT_NE(history_->LineWith("eyes: Active done"), "");
  }

  std::unique_ptr<Process> up_;
  std::unique_ptr<Process> history_;
};

TEST_F(MovesByPermit, AndStopsWhenTheCommandIsKilledUntilAPersonReleasesIt) {
  ASSERT_NO_FATAL_FAILURE(StartStopped());
  auto permit = Permit();
  ASSERT_NO_FATAL_FAILURE(Move());
  kill(permit->pid(), SIGKILL);
  permit->Wait();
  ASSERT_TRUE(AwaitStop("has arrived for 2000 ms"));
  permit = Permit();
  EXPECT_EQ(Status()["emergency_stop"]["engaged"], true) << "permits alone end no stop";
  ASSERT_NO_FATAL_FAILURE(Move());
}

TEST_F(MovesByPermit, AndStopsWhenTheCommandIsSuspended) {
  ASSERT_NO_FATAL_FAILURE(StartStopped());
  const auto permit = Permit();
  ASSERT_NO_FATAL_FAILURE(Move());
  kill(permit->pid(), SIGSTOP);
  EXPECT_TRUE(AwaitStop("has arrived for 2000 ms"));
  kill(permit->pid(), SIGCONT);
  EXPECT_NE(permit->LineWith("robot is stopped by [safety] permit_ms"), "");
}

TEST_F(MovesByPermit, AndIsStoppedAgainWhenItIsReleasedWithoutOne) {
  ASSERT_NO_FATAL_FAILURE(StartStopped());
  auto permit = Permit();
  ASSERT_NO_FATAL_FAILURE(Move());
  kill(permit->pid(), SIGINT);
  EXPECT_EQ(permit->Wait().exit, 0);
  ASSERT_TRUE(AwaitStop("has arrived for 2000 ms"));
  Musher({"estop", "--release"});
  EXPECT_TRUE(AwaitStop("has arrived for 2000 ms"));
  EXPECT_EQ(Musher({"set", "Active"}).exit, 1);
}

class NeedsNoPermit : public MachineByCli {};

TEST_F(NeedsNoPermit, SoTheCommandSaysThatItHasNoEffect) {
  Process up(Command({"up", config_}));
  ASSERT_NE(up.LineWith("eyes: Active done"), "");
  const Ended permit = Musher({"permit"});
  EXPECT_EQ(permit.exit, 1);
  EXPECT_THAT(permit.err, HasSubstr("robot needs no permit to move: its config has no permit_ms"));
}

}  // namespace musher::testing::permit_test
