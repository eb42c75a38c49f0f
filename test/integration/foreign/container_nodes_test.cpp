// A container of ROS 2: two managed nodes in one process, which are two actuators. The peer has the
// lease of a ROS 2 process, 10 s.

#include <set>

#include "musher/test/integration/cli/machine.hpp"

namespace musher::testing::container_nodes_test {

class AContainer : public MachineByCli {
 protected:
  std::vector<std::string> Container() const {
    return {BinDir() + "/protocol_peer", "ros2", name_space_, "planner,smoother", "10000"};
  }
  // The controller starts the container for the planner, or does not start it.
  void Write(bool with_command) const {
    const std::string states =
        R"(["SetUp", "TearDown", "SelfCheck", "Active", "Protected", "LowPower"])";
    std::ofstream file(config_);
    file << "[controller]\nname = \"robot\"\nactuators = [\"planner\", \"smoother\"]\nstates = "
         << states << "\ndefault_time = 2000\ndefault_state = \"Uninitialized\"\nnamespace = \""
         << name_space_ << "\"\nstate_dir = \"state\"\n";
    for (const char* actuator : {"planner", "smoother"}) {
      file << "[actuator." << actuator << "]\nstates = " << states
           << "\ntimes = [20000, 20000, 20000, 20000, 20000, 20000]\nprotocol = "
              "\"ros2_lifecycle\"\n";
      if (!with_command || actuator == std::string("smoother")) continue;
      std::string words;
      for (const std::string& word : Container())
        words += (words.empty() ? "\"" : ", \"") + word + "\"";
      file << "command = [" << words << "]\n";
    }
  }
  // Once both are in that state. The process that the controller has started is not `not_in`.
  static nlohmann::json BothAre(const std::string& state, pid_t not_in = 0) {
    return AwaitStatus([&](const nlohmann::json& status) {
      const auto& planner = status["actuators"]["planner"];
      const auto& smoother = status["actuators"]["smoother"];
      return planner["degraded"] == false && smoother["degraded"] == false &&
             planner["state"] == state && smoother["state"] == state && planner["pid"] != not_in;
    });
  }
  // Kills the process, by which both are lost within that time.
  static void ExpectOneCrash(pid_t pid) {
    Process history(Command({"history", "-f"}));
    ASSERT_NE(history.LineWith("the machine is Active"), "");
    const auto begun = std::chrono::steady_clock::now();
    ASSERT_EQ(kill(pid, SIGKILL), 0);
    const std::string how = " is degraded: crashed: its process " + std::to_string(pid) + " ended";
    std::set<std::string> lost;
    while (lost.size() < 2) {
      const std::string line = history.LineWith(how);
      ASSERT_NE(line, "") << "lost so far: " << lost.size();
      for (const char* node : {"planner", "smoother"}) {
        if (line.find(node + how) != std::string::npos) lost.insert(node);
      }
    }
    EXPECT_LT(std::chrono::steady_clock::now() - begun, std::chrono::seconds(9))
        << "the lease of its participant is 10 s";
  }
};

TEST_F(AContainer, ThatTheControllerStartsForOneNodeIsTwoActuatorsAndComesBackWhole) {
  Write(true);
  const Ended up = UpDetached();
  ASSERT_EQ(up.exit, 0) << up.out << up.err;
  const pid_t pid = BothAre("Active")["actuators"]["planner"]["pid"];
  ASSERT_NO_FATAL_FAILURE(ExpectOneCrash(pid));
  BothAre("Active", pid);
  const std::string history = Musher({"history"}).out;
  const auto count = [&](const std::string& words) {
    int found = 0;
    for (std::size_t at = history.find(words); at != std::string::npos;
         at = history.find(words, at + 1)) {
      ++found;
    }
    return found;
  };
  EXPECT_EQ(count("restarting in"), 1) << history;
  EXPECT_EQ(Musher({"down"}).exit, 0);
}

TEST_F(AContainer, OfALaunchFileIsTwoActuatorsThatAreLostAtOnceWithIt) {
  Write(false);
  auto container = std::make_unique<Process>(Container());
  const Ended up = UpDetached();
  ASSERT_EQ(up.exit, 0) << up.out << up.err;
  BothAre("Active");
  ASSERT_NO_FATAL_FAILURE(ExpectOneCrash(container->pid()));
  container = std::make_unique<Process>(Container());
  BothAre("Active");
  EXPECT_EQ(Musher({"down"}).exit, 0);
}

}  // namespace musher::testing::container_nodes_test
