// The controller's disk lets it down while the robot runs.

#include <signal.h>
#include <sys/resource.h>

#include <filesystem>

#include "musher/test/integration/cli/machine.hpp"

namespace musher::testing::disk_test {

using ::testing::HasSubstr;

class Disk : public MachineByCli {
 protected:
  void Start() {
    up_ = std::make_unique<Process>(Command({"up", config_, "--json"}));
    ASSERT_NE(up_->LineWith("eyes: Active done"), "");
  }
  // Of legs, which is restarted on failure.
  void ExpectACrashedActuatorIsRestarted() const {
    const pid_t before = Status()["actuators"]["legs"]["pid"];
    kill(before, SIGKILL);
    ASSERT_NE(up_->LineWith("legs: Active done"), "");
    const auto after = Status()["actuators"]["legs"];
    EXPECT_NE(after["pid"], before);
    EXPECT_EQ(after["state"], "Active");
  }

  std::unique_ptr<Process> up_;
};

TEST_F(Disk, WithAFileSizeLimitIsReportedAndDoesNotEndTheController) {
  ASSERT_NO_FATAL_FAILURE(Start());
  const pid_t controller = Status()["pid"];
  rlimit limit{};
  prlimit(controller, RLIMIT_FSIZE, nullptr, &limit);
  limit.rlim_cur = 1;
  ASSERT_EQ(prlimit(controller, RLIMIT_FSIZE, &limit, nullptr), 0);
  EXPECT_EQ(Musher({"set", "LowPower"}).exit, 0);
  EXPECT_NE(up_->LineWith("the journal is not on disk: "), "");
  EXPECT_EQ(Musher({"set", "Active"}).exit, 0);
  EXPECT_EQ(Status()["pid"], controller);
}

TEST_F(Disk, ThatIsFullIsInTheStatusAndTheHistoryAndForTheNextController) {
  ASSERT_NO_FATAL_FAILURE(Start());
  const pid_t controller = Status()["pid"];
  rlimit limit{};
  prlimit(controller, RLIMIT_FSIZE, nullptr, &limit);
  limit.rlim_cur = 4096;  // as on a full disk, a block that is there can be written
  ASSERT_EQ(prlimit(controller, RLIMIT_FSIZE, &limit, nullptr), 0);
  ASSERT_EQ(Musher({"set", "LowPower"}).exit, 0);
  ASSERT_EQ(Musher({"set", "Active"}).exit, 0);
  const auto status = AwaitStatus([](const auto& s) { return !s["not_on_disk"].empty(); });
  EXPECT_THAT(status["not_on_disk"][0].get<std::string>(), HasSubstr("journal ("));

  const Ended history = Musher({"history"});
  EXPECT_THAT(history.err, HasSubstr("the journal is not on disk since 2"));
  EXPECT_THAT(history.out, HasSubstr("LowPower → Active"));
  const Ended why = Musher({"history", "--why"});
  EXPECT_THAT(why.err, HasSubstr("the journal is not on disk since 2"));
  const std::string last = "(switch " + std::to_string(status["switch"].get<int>()) + ")";
  EXPECT_THAT(why.out, HasSubstr(last));

  kill(controller, SIGKILL);
  EXPECT_EQ(up_->Wait().exit, 1);
  const Ended file = Musher({"history", "--journal", folder_ / "state/journal.sqlite"});
  EXPECT_THAT(file.err, HasSubstr("the journal lacks the newest entries"));
  ASSERT_EQ(UpDetached().exit, 0);
  EXPECT_THAT(Musher({"history"}).out, HasSubstr("entries are missing before this one"));
}

TEST_F(Disk, ThatIsFullIsSaidByAnEmergencyStop) {
  ASSERT_NO_FATAL_FAILURE(Start());
  const pid_t controller = Status()["pid"];
  rlimit limit{};
  prlimit(controller, RLIMIT_FSIZE, nullptr, &limit);
  limit.rlim_cur = 1;
  ASSERT_EQ(prlimit(controller, RLIMIT_FSIZE, &limit, nullptr), 0);
  const Ended estop = Musher({"estop"});
  EXPECT_EQ(estop.exit, 0) << "every actuator is stopped";
  EXPECT_THAT(estop.err, HasSubstr("not on disk: emergency stop ("));
}

TEST_F(Disk, ThatCannotBeWrittenAtTheStartKeepsTheMachineFromActive) {
  Replace("state_dir = \"state\"", "state_dir = \"/proc/robot\"");
  const Ended up = UpDetached();
  EXPECT_EQ(up.exit, 1);
  EXPECT_THAT(up.err, HasSubstr("the state folder cannot be written"));
  EXPECT_EQ(Status()["state"], "SelfCheck");
  EXPECT_EQ(Musher({"set", "Active"}).exit, 0) << "a person may";
}

TEST_F(Disk, WithoutItsStateFolderStillLetsAnActuatorBeStartedAgain) {
  ASSERT_NO_FATAL_FAILURE(Start());
  // What runs may make a file in a folder that is being removed: then once more.
  std::error_code failed;
  for (int i = 0; i < 100 && std::filesystem::exists(folder_ / "state"); ++i) {
    std::filesystem::remove_all(folder_ / "state", failed);
  }
  ExpectACrashedActuatorIsRestarted();
  // The controller looks once a second.
  EXPECT_TRUE(AwaitFile(folder_ / "state/logs/legs.log"));
}

TEST_F(Disk, WithoutWritableLogsIsReportedAndActuatorsAreStillRestarted) {
  ASSERT_NO_FATAL_FAILURE(Start());
  std::filesystem::remove_all(folder_ / "state/logs");
  std::ofstream(folder_ / "state/logs") << "in the way";
  const pid_t before = Status()["actuators"]["legs"]["pid"];
  kill(before, SIGKILL);
  EXPECT_THAT(up_->LineWith("actuator output is lost"), HasSubstr("Not a directory"));
  AwaitStatus([before](const auto& s) {
    const auto& legs = s["actuators"]["legs"];
    return legs["pid"] != before && legs["state"] == "Active";
  });
}

// It went on for ever into files that no name led to, with an empty `not_on_disk`.
TEST_F(Disk, WhoseStateFolderIsReplacedHasTheJournalAndAllSmallFilesAgain) {
  ASSERT_NO_FATAL_FAILURE(Start());
  const std::string state = folder_ / "state";
  std::filesystem::rename(state, state + ".before");  // as another volume is mounted there
  EXPECT_NE(up_->LineWith("had been removed, or another volume was mounted there; saved again"),
            "");
  for (const char* file : {"machine", "epoch", "config", "processes"}) {
    EXPECT_TRUE(std::filesystem::exists(state + "/" + file)) << file;
  }
  // It is looked for once a second, as they are.
  Process history(Command({"history", "-f"}));
  EXPECT_NE(history.LineWith("the journal's file was removed while it was written"), "");
  ASSERT_EQ(Musher({"set", "LowPower"}).exit, 0);
  EXPECT_NE(history.LineWith("Active → LowPower"), "");
}

}  // namespace musher::testing::disk_test
