// The commands of a developer, as real processes: doctor, diff against the running machine, and a
// new robot.

#include "musher/test/integration/cli/machine.hpp"

namespace musher::testing::developer_test {

using ::testing::HasSubstr;

class Developer : public MachineByCli {
 protected:
  static nlohmann::json CheckOf(const nlohmann::json& report, const std::string& name) {
    for (const auto& check : report["checks"]) {
      if (check["check"] == name) return check;
    }
    ADD_FAILURE() << "no check '" << name << "' in " << report;
    return {};
  }
};

TEST_F(Developer, DoctorExchangesASampleBetweenTwoProcessesAndFindsTheRunningMachine) {
  ASSERT_EQ(UpDetached().exit, 0);
  const Ended doctor = Musher({"doctor", config_, "--json"});
  const auto report = Json(doctor.out);
  for (const char* name : {"DDS exchange", "network interface", "state folder", "programs",
                           "machine", "version", "open files", "lock file", "log folder"}) {
    EXPECT_EQ(CheckOf(report, name)["result"], "ok") << CheckOf(report, name);
  }
  EXPECT_THAT(CheckOf(report, "machine")["reason"], HasSubstr("robot (pid "));
  EXPECT_EQ(CheckOf(report, "lock file")["reason"],
            "held by the controller (pid " + Status()["pid"].dump() + ")");
  EXPECT_EQ(doctor.exit, report["result"] == "error" ? 1 : 0);
}

TEST_F(Developer, DoctorNamesTheMachineThatTheStateFolderBelongsTo) {
  ASSERT_EQ(UpDetached().exit, 0);
  ASSERT_EQ(Musher({"down"}).exit, 0);
  const std::string other = OtherRobot("cat", name_space_, folder_ / "state");
  const Ended doctor = Musher({"doctor", other, "--json"});
  EXPECT_EQ(doctor.exit, 1);
  const auto lock = CheckOf(Json(doctor.out), "lock file");
  EXPECT_EQ(lock["result"], "error");
  EXPECT_THAT(lock["reason"], HasSubstr("belongs to another machine, robot of " + config_));
  EXPECT_THAT(lock["fix"], HasSubstr("state_dir of its own"));
  EXPECT_EQ(CheckOf(Json(Musher({"doctor", config_, "--json"}).out), "lock file")["result"], "ok");
}

TEST_F(Developer, DoctorNamesABadInterfaceAndExitsWithOne) {
  setenv("CYCLONEDDS_URI",
         "<CycloneDDS><Domain><General><Interfaces><NetworkInterface name=\"nosuch0\"/>"
         "</Interfaces></General></Domain></CycloneDDS>",
         1);
  const Ended doctor = Musher({"doctor"});
  unsetenv("CYCLONEDDS_URI");
  EXPECT_EQ(doctor.exit, 1);
  EXPECT_THAT(doctor.out, HasSubstr("it names the interface nosuch0, which does not exist"));
  EXPECT_THAT(doctor.out, HasSubstr("unset CYCLONEDDS_URI"));
}

TEST_F(Developer, DiffComparesWithWhatTheMachineWasStartedWith) {
  EXPECT_EQ(Musher({"diff", config_}).exit, 3);
  ASSERT_EQ(UpDetached().exit, 0);
  const Ended same = Musher({"diff", config_});
  EXPECT_EQ(same.exit, 0) << same.out << same.err;
  // The file was edited meanwhile: the journal has the text of the start.
  Replace("stage = 2\nafter = [\"legs\"]", "stage = 1\nafter = [\"legs\"]");
  const Ended differs = Musher({"diff", config_});
  EXPECT_EQ(differs.exit, 1) << differs.err;
  EXPECT_EQ(differs.out,
            "[actuator.eyes]\n  stage: 2 → 1\nwhile the robot runs: `musher up "
            "--detach --takeover " +
                config_ + "`\n");
}

TEST_F(Developer, ANewRobotStartsAtOnce) {
  const std::string rover = folder_ / "rover";
  ASSERT_EQ(Musher({"new", "robot", "rover", "--folder", rover}).exit, 0);
  setenv("XDG_STATE_HOME", (folder_ / "state_home").c_str(), 1);
  unsetenv("MUSHER_NAMESPACE");
  const Ended up = Musher({"up", rover + "/robot.toml", "--detach"});
  EXPECT_EQ(up.exit, 0) << up.err;
  EXPECT_TRUE(std::filesystem::exists(rover + "/light"));
  EXPECT_EQ(Musher({"down"}).exit, 0);
  EXPECT_FALSE(std::filesystem::exists(rover + "/light"));
  // In its folder its logs are found, also with the machine down.
  const Ended logs =
      RunToEnd({"sh", "-c", "cd " + rover + " && " + BinDir() + "/musher logs controller"});
  EXPECT_EQ(logs.exit, 0) << logs.err;
  EXPECT_THAT(logs.out, HasSubstr("the machine is Active"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "state_home"));
  unsetenv("XDG_STATE_HOME");
}

// Each was called rover_robot in one state folder: the second one was refused.
TEST_F(Developer, TwoNewRobotsOfOneNameDoNotMeet) {
  unsetenv("MUSHER_NAMESPACE");
  for (const char* folder : {"first", "second"}) {
    const std::string rover = folder_ / folder;
    ASSERT_EQ(Musher({"new", "robot", "rover", "--folder", rover}).exit, 0);
    const Ended up = Musher({"up", rover + "/robot.toml", "--detach"});
    EXPECT_EQ(up.exit, 0) << up.err;
    EXPECT_EQ(Musher({"down"}).exit, 0);
    EXPECT_TRUE(std::filesystem::exists(rover + "/.musher/controller.log"));
  }
}

}  // namespace musher::testing::developer_test
