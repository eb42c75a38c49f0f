// An actuator that the systemd of another host runs: started, watched and ended from one config.

#include <gmock/gmock.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <iostream>
#include <string>
#include <vector>

#include "musher/test/integration/hosts/robot_and_board.hpp"

namespace musher::testing::board_test {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

using Board = RobotAndBoard;

std::size_t Count(const std::string& text, const std::string& words) {
  std::size_t count = 0;
  for (std::size_t at = text.find(words); at != std::string::npos; at = text.find(words, at + 1)) {
    ++count;
  }
  return count;
}

TEST_F(Board, RunsTheActuatorAsAUnitUntilTheMachineIsTornDown) {
  ASSERT_NO_FATAL_FAILURE(StartUp());
  const pid_t pid = PidOfEyes();
  EXPECT_EQ(Property("MainPID"), std::to_string(pid));
  EXPECT_EQ(Property("ActiveState"), "active");
  EXPECT_THAT(History(), HasSubstr("eyes started on host board (pid " + std::to_string(pid)));
  const Ended down = robot_->Run({"down"});
  EXPECT_EQ(down.exit, 0) << down.err;
  EXPECT_THAT(Units(), IsEmpty());
}

TEST_F(Board, ReportsTheExitOfAProcessWithItsReasonAndItIsStartedAgain) {
  ASSERT_NO_FATAL_FAILURE(StartUp());
  const pid_t before = PidOfEyes();
  EXPECT_EQ(OnBoard({"kill", "-KILL", std::to_string(before)}).exit, 0);
  ASSERT_TRUE(Until([&] { return PidOfEyes() != before && PidOfEyes() != 0; }));
  ASSERT_TRUE(AwaitActive());
  EXPECT_EQ(Property("MainPID"), std::to_string(PidOfEyes()));
  EXPECT_THAT(History(),
              HasSubstr("eyes's process " + std::to_string(before) + " ended: killed by SIGKILL"));
  EXPECT_EQ(robot_->Run({"restart", "eyes"}).exit, 0);
  EXPECT_EQ(robot_->Run({"down"}).exit, 0);
  EXPECT_THAT(Units(), IsEmpty());
}

TEST_F(Board, KeepsItsProcessWhileTheLinkIsCutAndItIsFoundAgain) {
  ASSERT_NO_FATAL_FAILURE(StartUp());
  const pid_t before = PidOfEyes();
  Cut();
  ASSERT_TRUE(
      Until([this] { return History().find("What runs there runs on") != std::string::npos; },
            std::chrono::seconds(30)))
      << History();
  Heal();
  ASSERT_TRUE(Until([this] { return History().find("host board is reached") != std::string::npos; },
                    std::chrono::seconds(30)));
  ASSERT_TRUE(AwaitActive());
  EXPECT_EQ(PidOfEyes(), before);
  EXPECT_EQ(Property("MainPID"), std::to_string(before));
  EXPECT_EQ(Count(History(), "eyes started on host board"), 1U);
  EXPECT_EQ(robot_->Run({"down"}).exit, 0);
  EXPECT_THAT(Units(), IsEmpty());
}

TEST_F(Board, KeepsItsProcessWhenTheControllerIsKilledAndTheNextOneEndsIt) {
  ASSERT_NO_FATAL_FAILURE(StartUp());
  const pid_t before = PidOfEyes();
  const nlohmann::json status = robot_->Status();
  ASSERT_EQ(robot_->Do({"kill", "-KILL", std::to_string(status["pid"].get<int>())}).exit, 0);
  ASSERT_TRUE(Until([this] { return robot_->Status().is_null(); }));
  EXPECT_EQ(Property("MainPID"), std::to_string(before));
  ASSERT_NO_FATAL_FAILURE(StartUp());
  EXPECT_EQ(PidOfEyes(), before);
  ASSERT_TRUE(Until(
      [this] { return History().find("eyes runs on host board already") != std::string::npos; }));
  EXPECT_EQ(robot_->Run({"down"}).exit, 0);
  EXPECT_THAT(Units(), IsEmpty());
}

TEST_F(Board, IsBootedAgainAndItsActuatorIsStartedAndDrivenAgain) {
  ASSERT_NO_FATAL_FAILURE(StartUp());
  PowerOff();
  Boot();
  ASSERT_TRUE(AwaitBoard());
  ASSERT_TRUE(Until([this] { return Count(History(), "eyes started on host board") == 2; },
                    std::chrono::seconds(60)))
      << History();
  ASSERT_TRUE(AwaitActive());
  EXPECT_THAT(History(), HasSubstr("has been booted again"));
  EXPECT_EQ(Property("MainPID"), std::to_string(PidOfEyes()));
}

// musher-exec exits with code 0 on the SIGTERM of the shutdown.
TEST_F(Board, IsShutDownInOrderAndItsActuatorIsStartedAndDrivenAgain) {
  ASSERT_NO_FATAL_FAILURE(StartUp());
  OnBoard({"systemctl", "poweroff"});
  board_->Wait();
  Boot();
  ASSERT_TRUE(AwaitBoard());
  ASSERT_TRUE(Until([&] { return Count(History(), "eyes started on host board") == 2; },
                    std::chrono::seconds(60)))
      << History();
  ASSERT_TRUE(AwaitActive());
  EXPECT_THAT(History(), HasSubstr("its host went down"));
  EXPECT_LE(robot_->Status()["actuators"]["eyes"]["restarts"], 1);
}

TEST_F(Board, ThatIsOutOfReachIsNamedWhenTheMachineIsTornDown) {
  ASSERT_NO_FATAL_FAILURE(StartUp());
  Cut();
  const Time begin = std::chrono::steady_clock::now();
  const Ended down = robot_->Run({"down"});
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(15));
  EXPECT_EQ(down.exit, 1);
  EXPECT_THAT(down.out + down.err, HasSubstr("eyes: host board is out of reach"));
  Heal();
  ASSERT_TRUE(AwaitBoard());
  // The next start finds what was left, and its end ends it.
  ASSERT_NO_FATAL_FAILURE(StartUp());
  EXPECT_EQ(robot_->Run({"down"}).exit, 0);
  EXPECT_THAT(Units(), IsEmpty());
}

TEST_F(Board, ThatRefusesTheKeyIsNamedWithWhatToDo) {
  ASSERT_EQ(OnBoard({"rm", "/root/.ssh/authorized_keys"}).exit, 0);
  const Ended up = Up();
  EXPECT_THAT(up.out + up.err + History(),
              AllOf(HasSubstr("host board (root@10.77.3.2)"), HasSubstr("Permission denied"),
                    HasSubstr("authorized_keys")));
  std::filesystem::copy_file(root_->Key() + ".pub", root_->path() + "/root/.ssh/authorized_keys");
}

TEST_F(Board, WithoutTheProgramSaysSo) {
  Replace(BinDir() + "/musher-exec\", \"" + (folder_ / "eyes"), "/opt/none\", \"x");
  const Ended up = Up();
  EXPECT_THAT(up.out + up.err + History(),
              AllOf(HasSubstr("/opt/none could not be executed there"),
                    HasSubstr("journalctl -u musher-robot-eyes.service")));
  EXPECT_EQ(robot_->Run({"down"}).exit, 0);
  EXPECT_THAT(Units(), IsEmpty());
}

// Its systemd skips the unit, as one that is started too late.
TEST_F(Board, WithoutTheFolderOfAnActuatorSaysSo) {
  Replace("host = \"board\"\n", "host = \"board\"\ncwd = \"/opt/none\"\n");
  const Ended up = Up();
  EXPECT_THAT(up.out + up.err + History(),
              HasSubstr("its folder /opt/none (`cwd`) may be missing there"));
  EXPECT_EQ(robot_->Run({"down"}).exit, 0);
  EXPECT_THAT(robot_->Run({"check", "--hosts", config_}).out,
              HasSubstr("the working directory is not there for eyes: /opt/none"));
}

TEST_F(Board, WithAUnitOfThatNameOfAnotherMachineIsNotTouched) {
  ASSERT_EQ(OnBoard({"systemd-run", "--unit=musher-robot-eyes", "sleep", "1000"}).exit, 0);
  const std::string before = Property("MainPID");
  const Ended up = Up();
  EXPECT_THAT(up.out + up.err + History(), HasSubstr("for another machine of this name"));
  robot_->Run({"down"});
  EXPECT_EQ(Property("MainPID"), before);
}

TEST_F(Board, ThatBootsAfterTheMachineHasStartedIsWaitedFor) {
  PowerOff();
  Up();
  ASSERT_TRUE(Until(
      [this] {
        const nlohmann::json status = robot_->Status();
        return !status.is_null() && status["state"] == "Active";
      },
      std::chrono::seconds(60)));
  const nlohmann::json eyes = robot_->Status()["actuators"]["eyes"];
  EXPECT_THAT(eyes["message"].get<std::string>(),
              AllOf(HasSubstr("host board (root@10.77.3.2): "),
                    HasSubstr("it is started once its host is reached")));
  EXPECT_EQ(eyes["restarts"], 0);
  Boot();
  ASSERT_TRUE(AwaitBoard());
  ASSERT_TRUE(AwaitActive());
  EXPECT_EQ(Property("MainPID"), std::to_string(PidOfEyes()));
  EXPECT_THAT(History(), Not(HasSubstr("eyes: restarting")));
  EXPECT_EQ(robot_->Run({"down"}).exit, 0);
}

TEST_F(Board, GivesTheProcessItsLimits) {
  ASSERT_EQ(OnBoard({"id", "-u", "games"}).exit, 0);
  Replace("host = \"board\"\n", "host = \"board\"\nmemory_max_mb = 512\ncpus = 0.5\nnice = 7\n");
  ASSERT_NO_FATAL_FAILURE(StartUp());
  EXPECT_EQ(Property("MemoryMax"), std::to_string(512 << 20));
  EXPECT_EQ(Property("CPUQuotaPerSecUSec"), "500ms");
  EXPECT_EQ(OnBoard({"cut", "-d\\ ", "-f19", "/proc/" + std::to_string(PidOfEyes()) + "/stat"}).out,
            "7\n");
  EXPECT_EQ(robot_->Run({"down"}).exit, 0);
}

TEST_F(Board, RunsTheProcessAsItsUser) {
  Replace("host = \"board\"\n", "host = \"board\"\nuser = \"robot-there\"\n");
  const Ended up = Up();
  EXPECT_THAT(up.out + up.err + History(),
              HasSubstr("its user robot-there (`user`) may be missing there"));
  EXPECT_EQ(robot_->Run({"down"}).exit, 0);
  EXPECT_THAT(robot_->Run({"check", "--hosts", config_}).out,
              HasSubstr("it has no user robot-there; ssh root@10.77.3.2 useradd --system"));
}

TEST_F(Board, EndsAProcessThatDoesNotHandleSigterm) {
  ASSERT_NO_FATAL_FAILURE(StartUp());
  const pid_t before = PidOfEyes();
  ASSERT_EQ(OnBoard({"kill", "-STOP", std::to_string(before)}).exit, 0);
  EXPECT_EQ(robot_->Run({"restart", "eyes"}).exit, 0) << History();
  ASSERT_TRUE(AwaitActive());
  EXPECT_NE(PidOfEyes(), before);
  EXPECT_EQ(Property("MainPID"), std::to_string(PidOfEyes()));
  EXPECT_THAT(History(), Not(HasSubstr("was refused")));
}

// A signal that arrives late is for a start of the unit that there is no more.
TEST_F(Board, EndsNoProcessByTheSignalToAnEarlierOne) {
  const auto kill_by = [this](const std::string& invocation) {
    const std::string first = invocation.substr(0, 1);
    const std::string label = first < "a" ? "_3" + first : first;
    return OnBoard({"busctl call org.freedesktop.systemd1 /org/freedesktop/systemd1/unit/" + label +
                    invocation.substr(1) + " org.freedesktop.systemd1.Unit Kill si all 9"});
  };
  ASSERT_NO_FATAL_FAILURE(StartUp());
  const std::string earlier = Property("InvocationID");
  ASSERT_EQ(robot_->Run({"restart", "eyes"}).exit, 0);
  ASSERT_TRUE(AwaitActive());
  const std::string before = Property("MainPID");
  EXPECT_NE(Property("InvocationID"), earlier);
  EXPECT_NE(kill_by(earlier).exit, 0);
  EXPECT_EQ(Property("MainPID"), before);
  EXPECT_EQ(kill_by(Property("InvocationID")).exit, 0);
  EXPECT_TRUE(Until([&] { return Property("MainPID") != before; }));
}

TEST_F(Board, KeepsTheSandboxOfAProcess) {
  Replace("host = \"board\"\n", "host = \"board\"\nsandbox = \"read-only\"\n");
  std::ofstream(folder_ / "eyes.toml")
      << "[state.SetUp]\nstart = [\"sh\", \"-c\", \"touch /opt/seen && echo wrote files; touch "
         "/tmp/seen && echo wrote tmp; ls /root/.ssh >/dev/null && echo saw homes; exec sleep "
         "1000\"]\n";
  ASSERT_NO_FATAL_FAILURE(StartUp());
  EXPECT_THAT(robot_->Run({"logs", "eyes"}).out,
              AllOf(Not(HasSubstr("wrote files")), HasSubstr("wrote tmp"), HasSubstr("saw homes")));
  EXPECT_EQ(robot_->Run({"down"}).exit, 0);

  ASSERT_EQ(OnBoard({"rm -rf /opt/eyes && cp -r " + folder_.path() + " /opt/eyes"}).exit, 0);
  Replace((folder_ / "eyes") + ".toml\"]\n",
          "/opt/eyes/eyes.toml\"]\nenv = { MUSHER_CONFIG = \"/opt/eyes/robot.toml\" }\n");
  Replace("\"read-only\"", "\"strict\"\ndevices = [\"/dev/video0\"]");
  ASSERT_NO_FATAL_FAILURE(StartUp());
  EXPECT_EQ(Property("DevicePolicy"), "closed");
  EXPECT_THAT(robot_->Run({"logs", "eyes", "-n", "3"}).out,
              AllOf(HasSubstr("wrote tmp"), Not(HasSubstr("saw homes"))));
  EXPECT_EQ(robot_->Run({"down"}).exit, 0);
}

// The kernel ends it; systemd knows why from the counts of its cgroup of version 2.
TEST_F(Board, EndsAProcessThatNeedsMoreMemoryThanItsLimitAndStartsItAgain) {
  if (OnBoard({"grep", "-q", "memory", "/sys/fs/cgroup/cgroup.controllers"}).exit != 0) {
    GTEST_SKIP() << "no memory controller in cgroups of version 2 here";
  }
  Replace("host = \"board\"\n", "host = \"board\"\nmemory_max_mb = 64\n");
  std::ofstream(folder_ / "eyes.toml")
      << "[state.LowPower]\nrun = [\"sh\", \"-c\", \"tail -c 200M /dev/zero | tail\"]\n";
  ASSERT_NO_FATAL_FAILURE(StartUp());
  robot_->Run({"set", "LowPower"});
  ASSERT_TRUE(Until([this] { return Count(History(), "eyes started on host board") == 2; },
                    std::chrono::seconds(60)));
  EXPECT_THAT(History(), HasSubstr("out of memory: its limit (memory_max_mb = 64)"));
}

TEST_F(Board, ShowsItsLogAndWhatItsProcessUses) {
  std::ofstream(folder_ / "eyes.toml")
      << "[state.SetUp]\nstart = [\"sh\", \"-c\", \"echo from the board; exec sleep 1000\"]\n";
  std::ofstream(folder_ / "legs.toml")
      << "[state.SetUp]\nstart = [\"sh\", \"-c\", \"echo from here; exec sleep 1000\"]\n";
  ASSERT_NO_FATAL_FAILURE(StartUp());
  const pid_t pid = PidOfEyes();
  EXPECT_THAT(robot_->Run({"logs", "--config", config_}).out,
              AllOf(HasSubstr("from the board"), HasSubstr("from here")));
  const nlohmann::json top = Json(robot_->Run({"top", "--once", "--json"}).out);
  bool found = false;
  for (const nlohmann::json& row : top["processes"]) {
    if (row["actuator"] != "eyes") continue;
    found = true;
    EXPECT_EQ(row["pid"], pid);
    EXPECT_GT(row["memory_bytes"], 0);
  }
  EXPECT_TRUE(found) << top;
  // It has the clock of this computer.
  const nlohmann::json hosts = Json(robot_->Run({"status", "--hosts", "--json"}).out)["hosts"];
  EXPECT_NEAR(hosts["board"]["clock_ahead_s"].get<double>(), 0, 30) << hosts;
  EXPECT_EQ(hosts["board"]["runs"], nlohmann::json::array({"eyes"}));
  Cut();
  const Ended without = robot_->Run({"logs", "--config", config_});
  EXPECT_EQ(without.exit, 0);
  EXPECT_THAT(without.err, HasSubstr("host board (root@10.77.3.2): "));
  EXPECT_THAT(without.out, HasSubstr("from here"));
  const Ended only = robot_->Run({"logs", "eyes", "--config", config_});
  EXPECT_EQ(only.exit, 1);
  Heal();
}

TEST_F(Board, WhoseJournalTheUserMayNotReadSaysSo) {
  ASSERT_NO_FATAL_FAILURE(StartUp());
  OnBoard({"useradd", "-m", "looker"});
  ASSERT_EQ(OnBoard({"cp -r /root/.ssh /home/looker/; chown -R looker /home/looker/.ssh"}).exit, 0);
  Replace("user = \"root\"", "user = \"looker\"");
  const Ended logs = robot_->Run({"logs", "eyes", "--config", config_});
  EXPECT_EQ(logs.exit, 1);
  EXPECT_THAT(logs.err, HasSubstr("host board (looker@10.77.3.2): user looker may not read its "
                                  "journal: lines are missing; permit it there by `usermod -aG "
                                  "systemd-journal looker`"));
  ASSERT_EQ(OnBoard({"usermod", "-aG", "systemd-journal", "looker"}).exit, 0);
  const Ended permitted = robot_->Run({"logs", "eyes", "--config", config_});
  EXPECT_EQ(permitted.exit, 0);
  EXPECT_THAT(permitted.err, Not(HasSubstr("may not read")));
}

// The numbers of the lines "count N" in a log.
std::vector<int> Counts(const std::string& log) {
  std::vector<int> counts;
  const std::string word = "count ";
  for (std::size_t at = log.find(word); at != std::string::npos; at = log.find(word, at + 1)) {
    counts.push_back(std::atoi(log.c_str() + at + word.size()));
  }
  return counts;
}

TEST_F(Board, LosesNoLineOfALogThatIsFollowedOverACutLink) {
  std::ofstream(folder_ / "eyes.toml")
      << "[state.SetUp]\nstart = [\"sh\", \"-c\", \"i=0; while :; do i=$((i + 1)); echo count "
         "$i; sleep 0.05; done\"]\n";
  ASSERT_NO_FATAL_FAILURE(StartUp());
  const std::string log = folder_ / "followed";
  const Process follow(robot_->Here({"sh", "-c",
                                     "exec " + BinDir() + "/musher logs -f -n 5 eyes --config " +
                                         config_ + " > " + log + " 2>&1"}));
  const auto newest = [&] {
    const std::vector<int> counts = Counts(ReadFile(log));
    return counts.empty() ? 0 : counts.back();
  };
  ASSERT_TRUE(Until([&] { return newest() > 0; }));
  const int shown = newest();
  ASSERT_TRUE(Until([&] { return newest() > shown + 20; })) << ReadFile(log);
  Cut();
  ASSERT_TRUE(Until([&] { return ReadFile(log).find("its lines follow") != std::string::npos; },
                    std::chrono::seconds(30)))
      << ReadFile(log);
  const int before = newest();
  Heal();
  ASSERT_TRUE(Until([&] { return newest() > before + 100; }, std::chrono::seconds(60)))
      << ReadFile(log);
  const std::vector<int> counts = Counts(ReadFile(log));
  for (std::size_t i = 1; i < counts.size(); ++i) ASSERT_EQ(counts[i], counts[i - 1] + 1);
}

// What its kernel keeps, is asked of the board itself.
TEST_F(Board, WhoseKernelDoesNotKeepALimitIsNamedByCheck) {
  const bool keeps =
      OnBoard({"grep", "-qs", "memory", "/sys/fs/cgroup/cgroup.controllers"}).exit == 0;
  const bool old = OnBoard({"grep", "-q", "'cgroup rw,.*memory'", "/proc/mounts"}).exit == 0;
  Replace("host = \"board\"\n", "host = \"board\"\nmemory_max_mb = 512\n");
  const Ended check = robot_->Run({"check", "--hosts", config_});
  EXPECT_EQ(check.exit, keeps || old ? 0 : 2) << check.out;
  if (keeps) return;
  EXPECT_THAT(check.out, HasSubstr(old ? "it has cgroups of version 1: eyes is ended above"
                                       : "its kernel does not keep `memory_max_mb` of eyes: its "
                                         "cgroups have no memory controller"));
}

// A version of eyes for `musher deploy`.
class DeployedBoard : public RobotAndBoard {
 protected:
  void SetUp() override {
    RobotAndBoard::SetUp();
    if (IsSkipped() || HasFatalFailure()) return;
    ASSERT_EQ(OnBoard({"rm -rf /opt/robot /opt/robot.*; ln -sf " + BinDir() +
                       "/musher /usr/local/bin/musher"})
                  .exit,
              0);
    Replace(BinDir() + "/musher-exec\", \"" + (folder_ / "eyes") + ".toml\"]\n",
            "/opt/robot/current/bin/eyes\", \"eyes.toml\"]\ncwd = \"/opt/robot/current\"\nenv = { "
            "MUSHER_CONFIG = \"/opt/robot/current/robot.toml\" }\n");
    ASSERT_EQ(robot_->Run({"ota", "keygen", folder_ / "robot"}).exit, 0);
  }
  void MakeVersion(const std::string& text) const {
    std::filesystem::create_directories(folder_ / "bin");
    const std::string file = folder_ / "bin/eyes";
    std::ofstream(file) << "#!/bin/sh\necho " << text << "\nexec " << BinDir()
                        << "/musher-exec \"$@\"\n";
    std::filesystem::permissions(file, std::filesystem::perms::owner_all);
  }
  Ended Deploy(const std::string& version, const std::vector<std::string>& more = {}) const {
    std::vector<std::string> words = {"deploy", config_, "--version",
                                      version,  "--key", folder_ / "robot.key"};
    words.insert(words.end(), more.begin(), more.end());
    return robot_->Run(words);
  }
  std::string Current() const {
    return OnBoard({"readlink", "-f", "/opt/robot/current/bin/eyes"}).out;
  }
};

TEST_F(DeployedBoard, RunsTheVersionThatWasCopiedToIt) {
  MakeVersion("the first version");
  const Ended first = Deploy("1.0.0");
  ASSERT_EQ(first.exit, 0) << first.err;
  EXPECT_EQ(Current(), "/opt/robot/slots/a/bin/eyes\n");
  ASSERT_NO_FATAL_FAILURE(StartUp());
  EXPECT_THAT(robot_->Run({"logs", "eyes"}).out, HasSubstr("the first version"));

  MakeVersion("the second version");
  const pid_t before = PidOfEyes();
  const Ended second = Deploy("1.1.0");
  ASSERT_EQ(second.exit, 0) << second.err;
  EXPECT_EQ(Current(), "/opt/robot/slots/b/bin/eyes\n");
  EXPECT_EQ(Property("MainPID"), std::to_string(before));
  EXPECT_EQ(robot_->Run({"restart", "eyes"}).exit, 0);
  ASSERT_TRUE(AwaitActive());
  EXPECT_THAT(robot_->Run({"logs", "eyes"}).out, HasSubstr("the second version"));

  MakeVersion("the third version");
  const pid_t second_process = PidOfEyes();
  const Ended third = Deploy("1.2.0", {"--restart"});
  ASSERT_EQ(third.exit, 0) << third.err;
  EXPECT_THAT(third.out, HasSubstr("restarted: eyes"));
  EXPECT_NE(PidOfEyes(), second_process);
  ASSERT_TRUE(AwaitActive());
  EXPECT_THAT(robot_->Run({"logs", "eyes"}).out, HasSubstr("the third version"));
  EXPECT_EQ(robot_->Run({"down"}).exit, 0);
}

TEST_F(DeployedBoard, WithoutSpaceOrOutOfReachKeepsItsVersion) {
  MakeVersion("the first version");
  ASSERT_EQ(Deploy("1.0.0").exit, 0);
  const std::string before = Current();
  ASSERT_EQ(OnBoard({"mkdir /opt/small && mount -t tmpfs -o "
                     "size=5m tmpfs /opt/small"})
                .exit,
            0);
  std::string toml = ReadFile(config_);
  for (std::size_t at = 0; (at = toml.find("/opt/robot", at)) != std::string::npos;) {
    toml.replace(at, 10, "/opt/small/robot");
    at += 16;
  }
  const std::string small = folder_ / "small.toml";
  std::ofstream(small) << toml;
  std::ofstream(folder_ / "eyes.toml") << "# " << std::string(1 << 20, 'x') << "\n";
  const Ended full =
      robot_->Run({"deploy", small, "--version", "1.1.0", "--key", folder_ / "robot.key"});
  EXPECT_EQ(full.exit, 1);
  EXPECT_THAT(full.err, AllOf(HasSubstr("host board (root@10.77.3.2): it needs 7 MiB for "
                                        "/opt/small/robot, there are 5"),
                              HasSubstr("version 1.1.0 is on no host")));
  EXPECT_EQ(OnBoard({"ls", "/opt/small"}).out, "");
  OnBoard({"umount /opt/small; rm -rf /opt/small"});

  Cut();
  const Time begin = std::chrono::steady_clock::now();
  const Ended cut = Deploy("1.1.0");
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(20));
  EXPECT_EQ(cut.exit, 1);
  EXPECT_THAT(cut.err, HasSubstr("host board (root@10.77.3.2): "));
  Heal();
  ASSERT_TRUE(AwaitBoard());
  EXPECT_EQ(Current(), before);
}

TEST_F(Board, IsLookedAtByDoctorAndByCheck) {
  const Ended well = robot_->Run({"check", "--hosts", config_});
  EXPECT_EQ(well.exit, 0) << well.out;
  EXPECT_THAT(robot_->Run({"doctor", config_}).out,
              ::testing::ContainsRegex("host board +ok +root@10.77.3.2, [a-z0-9_]+, systemd 2"));
  Replace(BinDir() + "/musher-exec\", \"" + (folder_ / "eyes"), "/opt/none\", \"x");
  const Ended missing = robot_->Run({"check", "--hosts", config_});
  EXPECT_EQ(missing.exit, 2);
  EXPECT_THAT(missing.out, HasSubstr(":12:1: error: host board (root@10.77.3.2): eyes: program "
                                     "not found there: /opt/none; copy the programs"));
  Cut();
  const Time begin = std::chrono::steady_clock::now();
  EXPECT_THAT(robot_->Run({"check", "--hosts", config_}).out,
              AllOf(HasSubstr("error: host board (root@10.77.3.2): "),
                    HasSubstr("`ssh root@10.77.3.2 true` works without a question")));
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(20));
  Heal();
}

// From the signal on the board to the record of the controller, which has the clock of the same
// computer.
TEST_F(Board, ReportsAnExitWithinMilliseconds) {
  Replace("host = \"board\"\n",
          "host = \"board\"\nrestart_delay_ms = 1\nrestart_growth = 1.0\nrestart_limit = 100\n");
  ASSERT_NO_FATAL_FAILURE(StartUp());
  std::vector<double> delays_ms;
  for (int kills = 0; kills < 20; ++kills) {
    const pid_t pid = PidOfEyes();
    ASSERT_NE(pid, 0);
    const std::string killed =
        OnBoard({"sh", "-c", "'date +%s%N; kill -KILL " + std::to_string(pid) + "'"}).out;
    ASSERT_TRUE(Until([&] { return PidOfEyes() != pid && PidOfEyes() != 0; }));
    ASSERT_TRUE(AwaitActive());
    const std::string what = "eyes's process " + std::to_string(pid) + " ended: killed by SIGKILL";
    const nlohmann::json history = Json(robot_->Run({"history", "--json"}).out);
    for (const nlohmann::json& entry : history["entries"]) {
      if (entry["message"] != what) continue;
      const Ended seen = RunToEnd({"date", "-d", entry["time"].get<std::string>(), "+%s%N"});
      delays_ms.push_back((std::stod(seen.out) - std::stod(killed)) / 1e6);
    }
  }
  ASSERT_EQ(delays_ms.size(), 20U);
  std::sort(delays_ms.begin(), delays_ms.end());
  std::cout << "exit seen: p50 " << delays_ms[10] << " ms, most " << delays_ms.back() << " ms\n";
  EXPECT_LT(delays_ms[10], 50);
  EXPECT_EQ(robot_->Run({"down"}).exit, 0);
}

}  // namespace musher::testing::board_test
