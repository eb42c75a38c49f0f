// A robot, dog, whose person types a command in a shell without its namespace, or with another
// domain, while another robot, cat, on another host is in range there: two network and pid
// namespaces of this computer, with a link between them.

#include <memory>
#include <regex>

#include "musher/test/fault_injection/host/isolation.hpp"
#include "musher/test/fault_injection/host/link.hpp"
#include "musher/test/integration/cli/host.hpp"
#include "musher/test/integration/cli/machine.hpp"

namespace musher::testing::machine_beside_test {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

class MachineBeside : public MachineByCli {
 protected:
  void SetUp() override {
    if (geteuid() != 0 || access("/dev/net/tun", R_OK | W_OK) != 0) {
      GTEST_SKIP() << "two hosts need root and /dev/net/tun";
    }
    setenv("XDG_STATE_HOME", folder_.path().c_str(), 1);  // without machines of other tests
    dog_host_ = std::make_unique<Host>();
    cat_host_ = std::make_unique<Host>();
    ASSERT_TRUE(dog_host_->up() && cat_host_->up());
    cat_host_->InNetwork([] { fault_injection::BringUp("lo"); });
    dog_host_->InNetwork([this] {
      fault_injection::BringUp("lo");
      link_ = std::make_unique<fault_injection::Link>(cat_host_->init());
    });
    setenv("CYCLONEDDS_URI",
           "<CycloneDDS><Domain><General><Interfaces><NetworkInterface name=\"link\"/></Interfaces>"
           "</General></Domain></CycloneDDS>",
           1);
    Replace("name = \"robot\"", "name = \"dog\"");
  }
  void TearDown() override {
    unsetenv("CYCLONEDDS_URI");
    unsetenv("XDG_STATE_HOME");
    unsetenv("PYTHONPATH");
  }

  // dog in its namespace, and cat where `shell` looks, which are words for `env`.
  void Start(std::vector<std::string> shell, const std::string& cat_name_space) {
    shell_ = std::move(shell);
    const std::string cat = OtherRobot("cat", cat_name_space, folder_ / "cat_state");
    const std::string toml = std::regex_replace(ReadFile(cat), std::regex("legs_of_dog"), "legs");
    std::ofstream(cat) << toml;
    ASSERT_EQ(dog_host_->Run({"up", config_, "--detach"}).exit, 0);
    ASSERT_EQ(InShell(*cat_host_, {"up", cat, "--detach"}).exit, 0);
    ASSERT_TRUE(Until([this] { return Cat()["state"] == "Active"; }));
    ASSERT_TRUE(Until([this] { return Dog()["state"] == "Active"; }));
  }
  // `legs`: what that actuator of dog alone does.
  void StartInTheDefaultNamespace(const std::string& legs = "") {
    if (!legs.empty()) {
      Replace("legs.toml", "legs_of_dog.toml");
      Does("legs_of_dog", legs);
    }
    Start({"-u", "MUSHER_NAMESPACE"}, "");
  }
  Ended InShell(const Host& host, std::vector<std::string> words) const {
    std::vector<std::string> line = {"env", "--chdir=" + folder_.path()};
    line.insert(line.end(), shell_.begin(), shell_.end());
    for (std::string& word : Command(std::move(words))) line.push_back(std::move(word));
    return host.Do(std::move(line));
  }
  // What a person types on the robot.
  Ended Type(std::vector<std::string> words) const { return InShell(*dog_host_, std::move(words)); }
  // A program of that line, with a Machine() of these words.
  Ended Python(const std::string& line, const std::string& words = "") const {
    std::vector<std::string> program = {"env", "--chdir=" + folder_.path()};
    program.insert(program.end(), shell_.begin(), shell_.end());
    program.insert(program.end(), {"python3", "-c",
                                   "import musher\nwith musher.Machine(" + words +
                                       ") as robot:\n    " + line + "\n"});
    return dog_host_->Do(std::move(program));
  }
  std::string OfDog(const std::string& actuator) const { return name_space_ + "/" + actuator; }
  // The page of the other robot, which a person on this one has opened; null: it shows none.
  std::unique_ptr<Process> OpenPage() const {
    std::vector<std::string> words = {"env", "--chdir=" + folder_.path()};
    words.insert(words.end(), shell_.begin(), shell_.end());
    words.insert(words.end(), {BinDir() + "/musher-view", "--no-link", "--port", "8765"});
    auto view = std::make_unique<Process>(dog_host_->Here(std::move(words)));
    if (view->LineWith("The page is at").empty()) return nullptr;
    const bool follows =
        Until([this] { return Post("plan", R"({"target":"LowPower"})")["status"] == 200; });
    return follows ? std::move(view) : nullptr;
  }
  nlohmann::json Post(const std::string& what, const std::string& body) const {
    return Json(dog_host_
                    ->Do({"python3", SourceDir() + "/test/integration/network/http_request.py",
                          "POST", "http://127.0.0.1:8765/api/" + what, body})
                    .out);
  }
  nlohmann::json Press() const { return Post("estop", R"({"machine":"cat","reason":"smoke"})"); }
  nlohmann::json Dog() const { return dog_host_->Status(); }
  nlohmann::json Cat() const {
    const Ended status = InShell(*cat_host_, {"status", "--json"});
    return status.exit == 0 ? Json(status.out) : nlohmann::json::object();
  }
  // `how`: the option that speaks to dog.
  void ExpectNoCommandActsOnTheCat(const std::string& how) const {
    nlohmann::json before = Cat();
    ASSERT_TRUE(Until(
        [this, &before] {
          before = Cat();  // its last stage starts by itself
          return before.contains("actuators") && before["actuators"]["eyes"]["state"] == "Active";
        },
        std::chrono::minutes(2)));
    for (const std::vector<std::string>& words :
         std::vector<std::vector<std::string>>{{"set", "LowPower"},
                                               {"down"},
                                               {"down", "--without-controller"},
                                               {"restart", "legs"},
                                               {"wake"},
                                               {"wait", "Active", "--timeout", "3"},
                                               {"estop", "--release"}}) {
      const Ended ended = Type(words);
      EXPECT_EQ(ended.exit, 3) << words[0] << ": " << ended.out << ended.err;
      EXPECT_THAT(ended.err, AllOf(HasSubstr("the machine of this host, dog"), HasSubstr("cat"),
                                   HasSubstr(how), HasSubstr("--machine NAME")))
          << words[0];
    }
    const nlohmann::json after = Cat();
    for (const char* what : {"state", "epoch", "switch", "actuators", "emergency_stop"}) {
      EXPECT_EQ(before[what], after[what]) << what;
    }
  }

  std::unique_ptr<Host> dog_host_;
  std::unique_ptr<Host> cat_host_;
  std::unique_ptr<fault_injection::Link> link_;
  std::vector<std::string> shell_;
};

// It rose, and its motors went on, with exit code 0.
TEST_F(MachineBeside, IsNotActedOnInPlaceOfTheRobotOfAnotherNamespaceThatRunsHere) {
  ASSERT_NO_FATAL_FAILURE(StartInTheDefaultNamespace());
  ExpectNoCommandActsOnTheCat("--namespace " + name_space_ + ", or MUSHER_NAMESPACE, speaks to it");
  EXPECT_EQ(Dog()["state"], "Active");
  const Ended status = Type({"status"});
  EXPECT_EQ(status.exit, 0);
  EXPECT_THAT(status.err, AllOf(HasSubstr("the machine of this host, dog"), HasSubstr("cat")));
  EXPECT_EQ(Type({"--namespace", name_space_, "set", "LowPower"}).exit, 0);
  EXPECT_EQ(Dog()["state"], "LowPower");
  EXPECT_EQ(Type({"--namespace", "", "set", "LowPower"}).exit, 0) << "named expressly";
  EXPECT_EQ(Cat()["state"], "LowPower");
  EXPECT_EQ(Type({"--machine", "cat", "set", "Active"}).exit, 0) << "named expressly";
}

TEST_F(MachineBeside, IsNotActedOnInPlaceOfTheRobotOfAnotherNamespaceThatIsDownHere) {
  ASSERT_NO_FATAL_FAILURE(StartInTheDefaultNamespace());
  ASSERT_EQ(dog_host_->Run({"down"}).exit, 0);
  ExpectNoCommandActsOnTheCat("--namespace " + name_space_);
}

TEST_F(MachineBeside, IsNotActedOnInPlaceOfTheRobotOfAnotherDomainThatRunsHere) {
  const int own = transport::TestDomain();
  ASSERT_NO_FATAL_FAILURE(Start({"ROS_DOMAIN_ID=" + std::to_string(own % 101 + 1)}, name_space_));
  ExpectNoCommandActsOnTheCat("--domain " + std::to_string(own) +
                              ", or ROS_DOMAIN_ID, speaks to it");
  EXPECT_EQ(Dog()["state"], "Active");
  const Ended stop = Type({"estop", "smoke"});
  EXPECT_EQ(stop.exit, 0) << stop.out << stop.err;
  EXPECT_EQ(Dog()["emergency_stop"]["engaged"], true);
}

// "the machine of this host, old, does not run": the files of a machine that had been tried there
// hid the robot that runs.
TEST_F(MachineBeside, IsNotHiddenByTheFilesOfAMachineThatDoesNotRun) {
  const std::string toml = ReadFile(OtherRobot("old", "", folder_ / "musher/old"));
  std::ofstream(folder_ / "old.toml") << toml;
  const std::vector<std::string> shell = {"env", "-u", "MUSHER_NAMESPACE"};
  for (const std::vector<std::string>& words :
       {std::vector<std::string>{"up", folder_ / "old.toml", "--detach"}, {"down"}}) {
    std::vector<std::string> line = shell;
    for (std::string& word : Command(words)) line.push_back(std::move(word));
    ASSERT_EQ(dog_host_->Do(line).exit, 0);
  }
  ASSERT_NO_FATAL_FAILURE(StartInTheDefaultNamespace());
  ExpectNoCommandActsOnTheCat("--namespace " + name_space_ + ", or MUSHER_NAMESPACE, speaks to it");
  EXPECT_THAT(Type({"status"}).err, HasSubstr("the machine of this host, dog"));
}

// "2 actuators are stopped", of the other robot, and the motors of this one went on.
TEST_F(MachineBeside, IsNotStoppedInPlaceOfTheRobotOfAnotherNamespaceThatRunsHere) {
  ASSERT_NO_FATAL_FAILURE(StartInTheDefaultNamespace());
  const Ended stop = Type({"estop", "smoke"});
  EXPECT_EQ(stop.exit, 0) << stop.out << stop.err;
  EXPECT_EQ(Dog()["emergency_stop"]["engaged"], true);
  EXPECT_THAT(stop.out, HasSubstr("in namespace '" + name_space_ + "' (--namespace " + name_space_ +
                                  "):\nemergency stop engaged"));
  EXPECT_THAT(stop.out, HasSubstr("\non other hosts in the default namespace:\n"))
      << "it may be the one that is meant";
  EXPECT_EQ(Cat()["emergency_stop"]["engaged"], true);
  const Ended json = Type({"estop", "--json"});
  EXPECT_EQ(json.exit, 0) << json.err;
  EXPECT_EQ(Json(json.out)["namespace"], name_space_);
  EXPECT_EQ(Json(json.out)["beside"][0]["namespace"], "");
}

// It ended with 3, though it named the robot.
TEST_F(MachineBeside, ThatIsOutOfRangeLeavesTheStopToTheRobotThatRunsHere) {
  ASSERT_NO_FATAL_FAILURE(StartInTheDefaultNamespace());
  ASSERT_EQ(InShell(*cat_host_, {"down"}).exit, 0);
  const Ended stop = Type({"estop", "smoke"});
  EXPECT_EQ(stop.exit, 0) << stop.out << stop.err;
  EXPECT_EQ(stop.err, "");
  EXPECT_EQ(Dog()["emergency_stop"]["engaged"], true);
}

// `estop()` returned the actuators of the other robot, and the motors of this one went on.
TEST_F(MachineBeside, IsNotStoppedByAProgramInPythonInPlaceOfTheRobotThatRunsHere) {
  setenv("PYTHONPATH", (BinDir() + "/../python").c_str(), 1);
  if (RunToEnd({"python3", "-c", "import musher"}).exit != 0) {
    GTEST_SKIP() << "this build has no Python package";
  }
  ASSERT_NO_FATAL_FAILURE(StartInTheDefaultNamespace());
  const Ended stop = Python("print(*robot.estop('smoke', timeout_s=60))");
  EXPECT_EQ(stop.out,
            "legs voice eyes " + OfDog("legs") + " " + OfDog("voice") + " " + OfDog("eyes") + "\n")
      << stop.err;
  EXPECT_EQ(Dog()["emergency_stop"]["engaged"], true);
  EXPECT_EQ(Cat()["emergency_stop"]["engaged"], true) << "it may be the one that is meant";
}

// "no controller in the default namespace", beside the robot that went on.
TEST_F(MachineBeside, ThatIsOutOfRangeLeavesTheStopOfAProgramInPythonToTheRobotThatRunsHere) {
  setenv("PYTHONPATH", (BinDir() + "/../python").c_str(), 1);
  if (RunToEnd({"python3", "-c", "import musher"}).exit != 0) {
    GTEST_SKIP() << "this build has no Python package";
  }
  ASSERT_NO_FATAL_FAILURE(StartInTheDefaultNamespace());
  ASSERT_EQ(InShell(*cat_host_, {"down"}).exit, 0);
  const Ended stop = Python("print(*robot.estop('smoke', timeout_s=4))");
  EXPECT_EQ(stop.out, OfDog("legs") + " " + OfDog("voice") + " " + OfDog("eyes") + "\n")
      << stop.err;
  EXPECT_EQ(Dog()["emergency_stop"]["engaged"], true);
}

TEST_F(MachineBeside, IsTheOnlyOneThatAProgramInPythonStopsWhichNamesIt) {
  setenv("PYTHONPATH", (BinDir() + "/../python").c_str(), 1);
  if (RunToEnd({"python3", "-c", "import musher"}).exit != 0) {
    GTEST_SKIP() << "this build has no Python package";
  }
  ASSERT_NO_FATAL_FAILURE(StartInTheDefaultNamespace());
  EXPECT_EQ(Python("print(*robot.estop('smoke', timeout_s=60))", "machine='cat'").out,
            "legs voice eyes\n");
  EXPECT_EQ(Dog()["emergency_stop"]["engaged"], false);
  EXPECT_EQ(Cat()["emergency_stop"]["engaged"], true);
  EXPECT_EQ(Python("print(*robot.estop('smoke', timeout_s=4))", "machine='dog'").out,
            OfDog("legs") + " " + OfDog("voice") + " " + OfDog("eyes") + "\n");
  EXPECT_EQ(Dog()["emergency_stop"]["engaged"], true);
}

// The button said that the robot is stopped: the other one was.
TEST_F(MachineBeside, IsNotStoppedByThePageInPlaceOfTheRobotThatRunsHere) {
  ASSERT_NO_FATAL_FAILURE(StartInTheDefaultNamespace());
  const auto view = OpenPage();
  ASSERT_NE(view, nullptr);
  const nlohmann::json stop = Press();
  EXPECT_EQ(stop["status"], 200);
  EXPECT_THAT(stop["body"].dump(), HasSubstr("\\\"code\\\":0")) << stop;
  EXPECT_EQ(Dog()["emergency_stop"]["engaged"], true);
  EXPECT_EQ(Cat()["emergency_stop"]["engaged"], true) << "it may be the one that is meant";
}

// They confirmed what the other robot had done.
TEST_F(MachineBeside, IsNamedByThePageAndByPythonWhereItDoesNotConfirmTheStop) {
  ASSERT_NO_FATAL_FAILURE(StartInTheDefaultNamespace(
      "[emergency_stop]\nrun = [\"false\"]\n[state.OTA]\nrun = [\"true\"]\n"));
  const auto view = OpenPage();
  ASSERT_NE(view, nullptr);
  EXPECT_THAT(Press()["body"].dump(),
              AllOf(HasSubstr("in namespace '" + name_space_ + "': not stopped: legs"),
                    Not(HasSubstr("\\\"code\\\":0"))));
  setenv("PYTHONPATH", (BinDir() + "/../python").c_str(), 1);
  if (RunToEnd({"python3", "-c", "import musher"}).exit != 0) return;
  const Ended program = Python("robot.estop('smoke')");
  EXPECT_EQ(program.exit, 1) << program.out;
  EXPECT_THAT(program.err, AllOf(HasSubstr("in namespace '" + name_space_ + "'"),
                                 HasSubstr("not confirmed by legs")));
}

// "found '' (cat), 'dogs' (dog) - use --machine cat".
TEST_F(MachineBeside, IsNotProposedWhereTheRobotThatRunsHereIsNamed) {
  ASSERT_NO_FATAL_FAILURE(StartInTheDefaultNamespace());
  const Ended set = Type({"--machine", "dog", "set", "LowPower"});
  EXPECT_EQ(set.exit, 3) << set.out;
  EXPECT_THAT(set.err, AllOf(HasSubstr("use --namespace " + name_space_), Not(HasSubstr("cat"))));
  const Ended stop = Type({"--machine", "dog", "estop", "smoke"});
  EXPECT_EQ(stop.exit, 0) << stop.out << stop.err;
  EXPECT_EQ(Dog()["emergency_stop"]["engaged"], true);
  EXPECT_EQ(Cat()["emergency_stop"]["engaged"], false);
}

}  // namespace musher::testing::machine_beside_test
