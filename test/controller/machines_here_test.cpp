// Which machines this host has: by its configs, state folders and running actuators, and what is
// said of those that the user may not read.

#include "musher/controller/storage/machines_here.hpp"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <signal.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <functional>

#include "musher/base/host.hpp"
#include "musher/controller/storage/state_store.hpp"
#include "musher/test/support/temp_folder.hpp"

namespace musher::machines_here_test {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

// A process that holds a name, and was started with this environment.
class RunningActuator {
 public:
  RunningActuator(const std::string& name, std::vector<std::string> environment) {
    int ends[2] = {-1, -1};
    if (pipe2(ends, O_CLOEXEC) != 0) return;
    std::vector<char*> variables;
    for (std::string& variable : environment) variables.push_back(variable.data());
    variables.push_back(nullptr);
    pid_ = fork();
    if (pid_ == 0) {
      const auto lock = NameLock::Acquire(name);
      if (lock && dup(lock.value().fd()) >= 0) {  // which the program inherits
        execle("/bin/sleep", "sleep", "600", nullptr, variables.data());
      }
      _exit(1);
    }
    close(ends[1]);
    char none = 0;
    static_cast<void>(read(ends[0], &none, 1));  // until the program runs
    close(ends[0]);
  }
  RunningActuator(const RunningActuator&) = delete;
  RunningActuator& operator=(const RunningActuator&) = delete;
  ~RunningActuator() {
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
  }

 private:
  pid_t pid_ = -1;
};

// In a namespace of its own, with the default places and the working directory in a folder.
class Machines : public ::testing::Test {
 protected:
  Machines() {
    fs::permissions(folder_.path(), fs::perms::all);
    setenv("XDG_STATE_HOME", (folder_ / "state").c_str(), 1);
    unsetenv("ROS_DOMAIN_ID");
    fs::create_directories(place_);
    fs::create_directory(folder_ / "work");
    fs::current_path(folder_ / "work");
  }
  ~Machines() override {
    fs::current_path(before_);
    unsetenv("XDG_STATE_HOME");
  }

  std::string Config(const std::string& file, const std::string& profile,
                     const std::string& name = "robot") const {
    std::ofstream out(folder_ / file);
    out << "[controller]\nname = \"" << name << "\"\nnamespace = \"" << name_space_
        << "\"\nactuators = [\"legs\", \"arm\"]\nstates = [\"SetUp\", \"Active\"]\n"
        << "default_time = 100\ndefault_state = \"Uninitialized\"\n"
        << "[transport]\nprofile = \"" << profile << "\"\n";
    for (const char* actuator : {"legs", "arm"}) {
      out << "[actuator." << actuator
          << "]\nstates = [\"SetUp\", \"Active\"]\ntimes = [100, 100]\n";
    }
    return folder_ / file;
  }
  std::string NameOf(const std::string& actuator) const {
    return NameLock::NameOf(0, name_space_, actuator);
  }
  std::vector<MachineHere> Found(const std::vector<std::string>& configs = {}) const {
    return MachinesHere(0, name_space_, configs);
  }
  // What a user finds who may not look into the processes and folders of this one; one line each.
  std::string FoundByAnotherUser() const {
    return AsAnotherUser([this] {
      std::string text;
      for (const MachineHere& machine : Found()) {
        text += machine.identity.name + (machine.lan ? " lan " : " local ") + machine.unread;
        for (const std::string& actuator : machine.actuators) text += " " + actuator;
        text += "\n";
      }
      return text;
    });
  }

  const TempFolder folder_;
  const std::string place_ = folder_ / "state/musher";
  const std::string name_space_ = "machines_here_" + std::to_string(getpid());
  const fs::path before_ = fs::current_path();

 private:
  static std::string AsAnotherUser(const std::function<std::string()>& work) {
    int ends[2] = {-1, -1};
    if (pipe(ends) != 0) return "no pipe";
    const pid_t child = fork();
    if (child == 0) {
      constexpr uid_t kOtherUid = 65534;
      const bool other = setresuid(kOtherUid, kOtherUid, kOtherUid) == 0;
      const std::string text = other ? work() : "could not become another user";
      _exit(write(ends[1], text.data(), text.size()) == static_cast<ssize_t>(text.size()) ? 0 : 1);
    }
    close(ends[1]);
    std::string text;
    char byte = 0;
    while (read(ends[0], &byte, 1) == 1) text += byte;
    close(ends[0]);
    waitpid(child, nullptr, 0);
    return text;
  }
};

TEST_F(Machines, AreThoseOfTheWorkingDirectoryAndOfConfigsThatAreGiven) {
  EXPECT_THAT(Found(), IsEmpty());
  Config("work/robot.toml", "local");
  const auto found = Found({Config("other.toml", "lan", "other")});
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0].identity.name, "other");
  EXPECT_TRUE(found[0].lan);
  EXPECT_EQ(found[1].identity.name, "robot");
  EXPECT_FALSE(found[1].lan);
  EXPECT_THAT(found[1].actuators, ElementsAre("legs", "arm"));
  EXPECT_TRUE(found[1].HasOneOf({"eyes", "arm"}));
  EXPECT_FALSE(found[1].HasOneOf({"eyes"}));
}

TEST_F(Machines, OfAnotherNamespaceAreNone) {
  const std::string config = Config("work/robot.toml", "lan");
  EXPECT_THAT(MachinesHere(0, name_space_ + "_2", {config}), IsEmpty());
}

TEST_F(Machines, OfAStateFolderHaveTheirIdAndTheActuatorsThatWereOnOtherHosts) {
  const std::string config = Config("robot.toml", "lan");
  {
    auto store = StateStore::Open(place_ + "/robot", {"robot", name_space_, 0, config, "an id"});
    ASSERT_TRUE(store) << store.error().message;
    store.value().SetMachineId("an id");
    ASSERT_TRUE(store.value().SaveMachineId());
    ASSERT_TRUE(store.value().SaveRemoteActuators({{"arm", "another/1"}}, HostId()));
    ASSERT_TRUE(store.value().SaveActuators(
        {{"legs", StaysDown::kGivenUp, State("Active")}, {"arm", StaysDown::kTornDown, {}}},
        HostId()));
  }
  const auto found = Found();
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].identity, (MachineIdentity{"robot", "an id"}));
  EXPECT_TRUE(found[0].lan);
  EXPECT_THAT(found[0].elsewhere, ElementsAre("arm"));
  EXPECT_THAT(found[0].lost,
              ElementsAre(StoredActuator{"legs", StaysDown::kGivenUp, State("Active")}));
  EXPECT_THAT(MachinesHere(1, name_space_), IsEmpty()) << "of another domain";
}

TEST_F(Machines, OfRunningActuatorsAreThoseThatTheirProcessesName) {
  const std::string config = Config("robot.toml", "local");
  const RunningActuator legs(NameOf("legs"), {"MUSHER_CONFIG=" + config});
  const RunningActuator arm(NameOf("arm"), {"MUSHER_CONFIG=" + config});
  auto found = Found();
  ASSERT_EQ(found.size(), 1U) << "one of both";
  EXPECT_EQ(found[0].identity.name, "robot");
  EXPECT_FALSE(found[0].lan);
  EXPECT_EQ(found[0].unread, "");
}

TEST_F(Machines, OfAProcessWhoseProfileIsLanMayHaveOtherHostsWhateverItsConfigSays) {
  const std::string config = Config("robot.toml", "local");
  const RunningActuator legs(NameOf("legs"), {"MUSHER_CONFIG=" + config, "MUSHER_TRANSPORT=lan"});
  const auto found = Found();
  ASSERT_EQ(found.size(), 1U);
  EXPECT_TRUE(found[0].lan);
}

TEST_F(Machines, OfAProcessWhoseConfigIsRemovedMayHaveOtherHosts) {
  Config("work/robot.toml", "local");
  const RunningActuator legs(NameOf("legs"), {"MUSHER_CONFIG=" + (folder_ / "removed.toml")});
  const auto found = Found();
  ASSERT_EQ(found.size(), 2U);
  EXPECT_TRUE(found[0].lan);
  EXPECT_THAT(found[0].actuators, ElementsAre("legs"));
  EXPECT_THAT(found[0].unread, HasSubstr("removed.toml, the config of legs, is not read"));
}

// Any process of the host may name any file.
TEST_F(Machines, DoNotWaitForAPipeThatIsNamedAsAConfig) {
  const std::string pipe = folder_ / "robot.toml";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_THAT(Found({pipe, "/dev/stdin"}), IsEmpty());
}

// By the config in the working directory it had no other hosts, and a stop that had reached this
// one was reported as complete.
TEST_F(Machines, WhoseProcessesThisUserMayNotReadMayHaveOtherHosts) {
  if (geteuid() != 0) GTEST_SKIP() << "only root can be another user";
  Config("work/robot.toml", "local");
  const RunningActuator legs(NameOf("legs"), {});
  const RunningActuator arm(NameOf("arm"), {});
  EXPECT_EQ(FoundByAnotherUser(),
            " lan arm, legs run as processes of another user, whose config is not read arm legs\n"
            "robot local  legs arm\n");
}

TEST_F(Machines, WhoseControllerThisUserMayNotReadMayHaveOtherHosts) {
  if (geteuid() != 0) GTEST_SKIP() << "only root can be another user";
  const RunningActuator controller(NameOf("musher/controller"), {});
  EXPECT_EQ(FoundByAnotherUser(), " lan its controller is a process of another user\n");
}

TEST_F(Machines, WhoseStateFolderThisUserMayNotReadMayHaveOtherHosts) {
  if (geteuid() != 0) GTEST_SKIP() << "only root can be another user";
  const std::string own = place_ + "/robot@" + name_space_;
  fs::create_directory(own);
  fs::create_directory(place_ + "/robot@another");
  EXPECT_EQ(FoundByAnotherUser(), "") << "empty folders";
  for (const char* folder : {"/robot@another", own.c_str() + place_.size()}) {
    fs::permissions(place_ + folder, fs::perms::owner_all);
  }
  EXPECT_EQ(FoundByAnotherUser(), "robot lan " + own + " is not read\n");
}

}  // namespace musher::machines_here_test
