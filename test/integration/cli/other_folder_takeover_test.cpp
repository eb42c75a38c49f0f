// A takeover by a controller that has another state folder than the one before it.

#include "musher/test/integration/cli/machine.hpp"

namespace musher::testing::other_folder_takeover_test {

class TakeoverFromAnotherFolder : public MachineByCli {
 protected:
  void Start() {
    first_ = std::make_unique<Process>(Command({"up", config_}));
    ASSERT_NE(first_->LineWith("eyes: Active done"), "");
    AwaitStatus(AllHaveArrived);
  }
  void Move(const std::string& from, const std::string& to) const {
    Replace("state_dir = \"" + from + "\"", "state_dir = \"" + to + "\"");
  }
  static Ended TakeOver(const std::string& config) {
    return Musher({"up", config, "--takeover", "--detach"});
  }
  std::unique_ptr<Process> first_;
};

// What a person has torn down alone is stored in the folder of the controller that is replaced. Of
// that folder only the list of processes, the stops and the level of the battery are read: the one
// that takes over starts it, and leads it to Active.
TEST_F(TakeoverFromAnotherFolder, StartsNoneThatAPersonHasTornDownAlone) {
  ASSERT_NO_FATAL_FAILURE(Start());
  ASSERT_EQ(Musher({"set", "TearDown", "voice"}).exit, 0);
  Move("state", "other");
  const Ended second = TakeOver(config_);
  ASSERT_EQ(second.exit, 0) << second.err;
  EXPECT_TRUE(Status()["actuators"]["voice"]["pid"].is_null());
  Musher({"down"});
}

// The list of processes in the first folder is as that controller left it. All of them were torn
// down by the second one, "done", exit code 0: the next start in the first folder says that each
// has ended in an unknown state; with restart = "no" it starts none, and the machine stays down.
TEST_F(TakeoverFromAnotherFolder, AndItsTearDownLeaveNoneThatIsGivenUp) {
  for (const char* actuator : {"legs", "voice", "eyes"}) {
    const std::string head = "[actuator." + std::string(actuator) + "]\n";
    Replace(head, head + "restart = \"no\"\n");
  }
  ASSERT_NO_FATAL_FAILURE(Start());
  Move("state", "other");
  ASSERT_EQ(TakeOver(config_).exit, 0);
  ASSERT_EQ(Musher({"down"}).exit, 0);
  Move("other", "state");
  const Ended next = Musher({"up", config_, "--restarted", "--detach"});
  EXPECT_EQ(next.exit, 0) << next.err;
  EXPECT_NE(Status()["actuators"]["legs"]["state"], "unknown");
  Musher({"down"});
}

}  // namespace musher::testing::other_folder_takeover_test
