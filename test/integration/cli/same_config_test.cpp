// One robot.toml that is started a second time, with another name, namespace or domain: the motors
// are the same.

#include <signal.h>

#include "musher/test/integration/cli/machine.hpp"

namespace musher::testing::same_config_test {

using ::testing::AllOf;
using ::testing::HasSubstr;

class SameConfig : public MachineByCli {
 protected:
  SameConfig() {
    setenv("XDG_STATE_HOME", folder_.path().c_str(), 1);
    Drop("state_dir = \"state\"\n");  // which another machine cannot use
  }
  ~SameConfig() override {
    unsetenv("XDG_STATE_HOME");
    unsetenv("RUNTIME_DIRECTORY");
  }

  void Rename(const std::string& key, const std::string& from, const std::string& to) const {
    Replace(key + " = \"" + from + "\"", key + " = \"" + to + "\"");
  }
  // As a power cut ends everything; no actuator of the namespace runs afterwards.
  static void CutThePower() {
    const nlohmann::json status = Status();
    std::vector<pid_t> pids = {status["pid"]};
    for (const auto& [name, one] : status["actuators"].items()) {
      if (one["pid"].is_number() && one["pid"] > 0) pids.push_back(one["pid"]);
    }
    for (const pid_t pid : pids) kill(pid, SIGKILL);
    for (const pid_t pid : pids) EXPECT_TRUE(AwaitEnd(pid));
  }
  // As systemd starts it then.
  Ended UpAtBoot() const {
    std::filesystem::remove(folder_ / "started");
    setenv("RUNTIME_DIRECTORY", folder_.path().c_str(), 1);
    return Musher({"up", config_, "--detach", "--restarted"});
  }
  static std::string OtherDomain() { return std::to_string(transport::TestDomain() % 101 + 1); }
};

// Two processes of each actuator ran, and the second ones went to Active under the engaged stop.
TEST_F(SameConfig, IsNotStartedInAnotherDomainBesideItselfAndNotToActiveUnderItsStop) {
  ASSERT_EQ(UpDetached().exit, 0);
  ASSERT_EQ(Musher({"estop", "fire"}).exit, 0);
  const std::string domain = std::to_string(transport::TestDomain());
  const std::string pid = std::to_string(Status()["pid"].get<int>());
  const std::string down = "musher --namespace " + name_space_ + " --domain " + domain + " down";
  const Ended second = Musher({"--domain", OtherDomain(), "up", config_, "--detach"});
  EXPECT_EQ(second.exit, 2) << second.out;
  EXPECT_THAT(second.err,
              AllOf(HasSubstr("process " + pid + " leads robot"), HasSubstr("domain " + domain),
                    HasSubstr("domain " + OtherDomain()),
                    HasSubstr("would run each actuator twice. `" + down + "` ends the first")));
  EXPECT_EQ(Musher({"--domain", OtherDomain(), "status"}).exit, 3);
  ASSERT_EQ(Musher({"--namespace", name_space_, "--domain", domain, "down"}).exit, 0);
  EXPECT_NE(Musher({"--domain", OtherDomain(), "up", config_, "--detach"}).exit, 0);
  const Ended status = Musher({"--domain", OtherDomain(), "status", "--json"});
  ASSERT_EQ(status.exit, 0) << status.err;
  EXPECT_EQ(Json(status.out)["emergency_stop"]["reason"], "fire");
  EXPECT_EQ(Json(status.out)["state"], "SetUp");
  EXPECT_EQ(Musher({"--domain", OtherDomain(), "down"}).exit, 0);
}

TEST_F(SameConfig, IsNotStartedInAnotherNamespaceBesideItsActuatorsWithoutAController) {
  ASSERT_EQ(UpDetached().exit, 0);
  const pid_t controller = Status()["pid"];
  kill(controller, SIGKILL);
  ASSERT_TRUE(AwaitEnd(controller));
  Rename("namespace", name_space_, name_space_ + "_other");
  const Ended second = UpDetached();
  EXPECT_EQ(second.exit, 2) << second.out;
  EXPECT_THAT(second.err, AllOf(HasSubstr("legs (pid "), HasSubstr("run without a controller as"),
                                HasSubstr("down --without-controller` ends them")));
  EXPECT_EQ(Musher({"down", "--without-controller"}).exit, 0);
  setenv("MUSHER_NAMESPACE", (name_space_ + "_other").c_str(), 1);
  EXPECT_EQ(UpDetached().exit, 0);
  EXPECT_EQ(Musher({"down"}).exit, 0);
}

// It came up Active.
TEST_F(SameConfig, StaysStoppedAndItsActuatorTornDownAtABootUnderAnotherNameAndNamespace) {
  ASSERT_EQ(UpDetached().exit, 0);
  ASSERT_EQ(Musher({"set", "TearDown", "voice"}).exit, 0);
  ASSERT_EQ(Musher({"estop", "fire"}).exit, 0);
  CutThePower();
  Rename("name", "robot", "renamed");
  Rename("namespace", name_space_, name_space_ + "_other");
  UpAtBoot();
  setenv("MUSHER_NAMESPACE", (name_space_ + "_other").c_str(), 1);
  const nlohmann::json status = Status();
  EXPECT_EQ(status["emergency_stop"]["reason"], "fire");
  EXPECT_EQ(status["state"], "SetUp");
  EXPECT_EQ(status["actuators"]["voice"]["state"], "TearDown") << status["actuators"]["voice"];
  // Once: a person has released it and has started the actuator.
  ASSERT_EQ(Musher({"down"}).exit, 0);
  ASSERT_NE(UpDetached().exit, 0) << "under the stop";
  ASSERT_EQ(Musher({"estop", "--release"}).exit, 0);
  CutThePower();
  UpAtBoot();
  const nlohmann::json again = Status();
  EXPECT_EQ(again["emergency_stop"]["engaged"], false);
  EXPECT_NE(again["actuators"]["voice"]["state"], "TearDown") << again["actuators"]["voice"];
}

}  // namespace musher::testing::same_config_test
