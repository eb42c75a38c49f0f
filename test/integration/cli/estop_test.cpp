// Emergency stops by hand, with a controller and without one.

#include <signal.h>
#include <sys/wait.h>

#include "musher/messages/musher_msgs/actuator_status.hpp"
#include "musher/messages/musher_msgs/heartbeats.hpp"
#include "musher/test/integration/cli/machine.hpp"
#include "musher/transport/dds/dds_node.hpp"
#include "musher/transport/dds/node_thread.hpp"
#include "musher/transport/linux_event_loop.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher::testing::estop_test {

using ::testing::AllOf;
using ::testing::HasSubstr;

class EmergencyStop : public MachineByCli {
 protected:
  void Start() {
    up_ = std::make_unique<Process>(Command({"up", config_}));
    ASSERT_NE(up_->LineWith("eyes: Active done"), "");
    ASSERT_EQ(Musher({"set", "LowPower"}).exit, 0);
  }
  // The controller exits, its actuators continue.
  void LoseController() {
    kill(Status()["pid"].get<pid_t>(), SIGKILL);
    EXPECT_EQ(up_->Wait().exit, 1);
  }
  static nlohmann::json Estop() {
    const Ended estop = Musher({"estop", "it", "smokes", "--json"});
    EXPECT_EQ(estop.exit, 0) << estop.err;
    return Json(estop.out);
  }
  static void ExpectNothingGoesUp() {
    const Ended set = Musher({"set", "Active", "--json"});
    EXPECT_EQ(set.exit, 1);
    EXPECT_EQ(Json(set.out)["code"], 113);  // ProtectedError
    EXPECT_THAT(set.err, HasSubstr("an emergency stop is engaged"));
  }

  // As systemd starts it then.
  Ended UpAtBoot() const {
    std::filesystem::remove(folder_ / "started");
    setenv("RUNTIME_DIRECTORY", folder_.path().c_str(), 1);
    const Ended up = Musher({"up", config_, "--detach", "--restarted"});
    unsetenv("RUNTIME_DIRECTORY");
    return up;
  }
  static std::string IdOf(const std::string& state_dir) {
    const std::string machine = ReadFile(state_dir + "/machine");
    const std::size_t at = machine.find("\nid ") + 4;
    return machine.substr(at, machine.find('\n', at) - at);
  }

  // Waits until the status of an actuator is so, half a minute at most; returns whether one was.
  bool AwaitReport(const std::function<bool(const msg::ActuatorStatus&)>& is_so) const {
    transport::LinuxEventLoop loop;
    const auto node = transport::MakeDdsNode(loop, {}).value();
    bool reported = false;
    const auto reports = transport::MakeSubscription<msg::ActuatorStatus>(
                             *node, transport::ActuatorStatusTopic(name_space_),
                             [&](const msg::ActuatorStatus& report, const auto&) {
                               reported = reported || is_so(report);
                             },
                             transport::kLatchedFromManyQos)
                             .value();
    return loop.RunUntil([&] { return reported; }, loop.Now() + std::chrono::seconds(30));
  }

  // Waits until a stop is published.
  bool AwaitStop() const {
    transport::LinuxEventLoop loop;
    const auto node = transport::MakeDdsNode(loop, {}).value();
    bool published = false;
    const auto stops =
        transport::SubscribeToStops(*node, name_space_, [&](const auto& stop, const auto&) {
          published = published || stop.engaged;
        }).value();
    return loop.RunUntil([&] { return published; }, loop.Now() + std::chrono::seconds(30));
  }
  void ExpectLatchedByAll(bool latched) const {
    for (const char* actuator : {"legs", "voice", "eyes"}) {
      EXPECT_TRUE(AwaitReport([&](const auto& report) {
        return report.name == actuator && (report.emergency_stop != 0) == latched;
      })) << actuator;
    }
  }

  std::unique_ptr<Process> up_;
};

TEST_F(EmergencyStop, IsLatchedByEveryActuatorAndLetsNothingGoUp) {
  ASSERT_NO_FATAL_FAILURE(Start());
  const auto report = Estop();
  EXPECT_EQ(report["complete"], true);
  EXPECT_EQ(report["earlier"], nullptr);
  for (const char* actuator : {"legs", "voice", "eyes"}) {
    EXPECT_EQ(report["actuators"][actuator]["stopped"], true) << actuator;
    EXPECT_EQ(report["actuators"][actuator]["before"], false) << actuator;
  }
  ExpectNothingGoesUp();
  const Ended refused = Musher({"set", "Active"});
  EXPECT_THAT(refused.err, AllOf(HasSubstr("engaged by " + report["by"].get<std::string>()),
                                 HasSubstr("(it smokes)")));
  EXPECT_EQ(Musher({"set", "OTA"}).exit, 0);  // down is allowed
  EXPECT_EQ(Status()["emergency_stop"]["reason"], "it smokes");
  EXPECT_THAT(Musher({"status"}).out, HasSubstr("EMERGENCY STOP by "));
}

// Two panels on the wall, which continue to publish "engaged", and a restarted controller.
TEST_F(EmergencyStop, AReleasedStopStaysReleasedForTheNextControllerThoughItsPanelsLiveOn) {
  ASSERT_NO_FATAL_FAILURE(Start());
  const auto panels = transport::NodeThread::Start({}).value();
  std::vector<std::unique_ptr<transport::Publisher<msg::EmergencyStop>>> buttons;
  for (const std::uint64_t id : {71, 72}) {
    panels->RunOnLoop([&] {
      buttons.push_back(
          transport::MakePublisher<msg::EmergencyStop>(
              panels->node(), transport::EmergencyStopTopic(name_space_), transport::kLatchedQos)
              .value());
      static_cast<void>(buttons.back()->Publish({id, true, "panel " + std::to_string(id), ""}));
    });
    ASSERT_NE(
        Process(Command({"history", "-f"})).LineWith("engaged by panel " + std::to_string(id)), "");
  }
  EXPECT_EQ(Musher({"estop", "--release"}).exit, 0);
  ExpectLatchedByAll(false);
  LoseController();
  Process next(Command({"up", config_}));
  ASSERT_NE(next.LineWith("the machine is adopted in LowPower"), "");
  EXPECT_EQ(Musher({"set", "Active"}).exit, 0);
  EXPECT_EQ(Status()["emergency_stop"]["engaged"], false);
  ExpectLatchedByAll(false);
  panels->RunOnLoop([&] { buttons.clear(); });
}

// As `ros2 topic pub` sends it.
TEST_F(EmergencyStop, AStopWithoutAnIdStopsAndIsReleasedAndStopsAgain) {
  ASSERT_NO_FATAL_FAILURE(Start());
  const auto panel = transport::NodeThread::Start({}).value();
  std::unique_ptr<transport::Publisher<msg::EmergencyStop>> button;
  panel->RunOnLoop([&] {
    button = transport::MakePublisher<msg::EmergencyStop>(
                 panel->node(), transport::EmergencyStopTopic(name_space_), transport::kLatchedQos)
                 .value();
  });
  for (int presses = 0; presses < 2; ++presses) {
    panel->RunOnLoop([&] { static_cast<void>(button->Publish({0, true, "", ""})); });
    ExpectLatchedByAll(true);
    ExpectNothingGoesUp();
    const Ended release = Musher({"estop", "--release"});
    EXPECT_EQ(release.exit, 0) << release.err;
    ExpectLatchedByAll(false);
  }
  panel->RunOnLoop([&] { button = nullptr; });
}

TEST_F(EmergencyStop, AMalformedMessageOnItsTopicStops) {
  ASSERT_NO_FATAL_FAILURE(Start());
  const auto panel = transport::NodeThread::Start({}).value();
  std::unique_ptr<transport::RawWriter> writer;
  panel->RunOnLoop([&] {
    writer =
        panel->node()
            .MakeRawWriter("rt/" + transport::EmergencyStopTopic(name_space_),
                           std::string(msg::EmergencyStop::kTypeName), transport::kLatchedQos, {})
            .value();
    const std::byte zero{0};
    static_cast<void>(writer->Write({zero, std::byte{1}, zero, zero, zero, zero, zero, zero}));
  });
  ExpectLatchedByAll(true);
  EXPECT_EQ(Musher({"estop", "--release"}).exit, 0);
  ExpectLatchedByAll(false);
  panel->RunOnLoop([&] { writer = nullptr; });
}

TEST_F(EmergencyStop, OneReleaseEndsSeventyStopsOfAsManyPanels) {
  ASSERT_NO_FATAL_FAILURE(Start());
  const auto panels = transport::NodeThread::Start({}).value();
  std::unique_ptr<transport::Publisher<msg::EmergencyStop>> buttons;
  panels->RunOnLoop([&] {
    transport::Qos qos = transport::kLatchedQos;
    qos.depth = 100;
    buttons = transport::MakePublisher<msg::EmergencyStop>(
                  panels->node(), transport::EmergencyStopTopic(name_space_), qos)
                  .value();
    for (std::uint64_t id = 1; id <= 70; ++id) {
      static_cast<void>(buttons->Publish({id, true, "panel " + std::to_string(id), ""}));
    }
  });
  ASSERT_NE(Process(Command({"history", "-f"})).LineWith("engaged by panel 70"), "");
  const Ended release = Musher({"estop", "--release"});
  EXPECT_EQ(release.exit, 0) << release.err;
  ExpectLatchedByAll(false);
  EXPECT_EQ(Status()["emergency_stop"]["engaged"], false);
  EXPECT_EQ(Musher({"set", "Active"}).exit, 0);
  panels->RunOnLoop([&] { buttons = nullptr; });
}

TEST_F(EmergencyStop, ReportsTheOriginOfTheEarlierStop) {
  ASSERT_NO_FATAL_FAILURE(Start());
  const auto first = Estop();
  const Ended second = Musher({"estop", "once more"});
  EXPECT_EQ(second.exit, 0) << second.err;
  EXPECT_THAT(second.out, HasSubstr("an emergency stop was already engaged by " +
                                    first["by"].get<std::string>() + ": it smokes\n"));
  EXPECT_THAT(second.out, HasSubstr("legs   stopped before\n"));
}

// Its files were elsewhere then, as with a start by systemd after one by hand: the stop was
// forgotten, and the robot went to Active.
TEST_F(EmergencyStop, HoldsWhenTheMachineIsStartedWithAnotherStateFolder) {
  setenv("XDG_STATE_HOME", (folder_ / "by_user").c_str(), 1);
  Drop("state_dir = \"state\"\n");
  ASSERT_EQ(UpDetached().exit, 0);
  Estop();
  ASSERT_EQ(Musher({"down"}).exit, 0);
  Replace("[controller]\n", "[controller]\nstate_dir = \"elsewhere\"\n");
  UpDetached();
  EXPECT_EQ(Status()["emergency_stop"]["reason"], "it smokes");
  EXPECT_EQ(Status()["state"], "SetUp");
  EXPECT_THAT(ReadFile(folder_ / "elsewhere/controller.log"),
              HasSubstr("an emergency stop is engaged in " + (folder_ / "by_user/musher/robot")));
  EXPECT_EQ(Musher({"estop", "--release"}).exit, 0);
  ASSERT_EQ(Musher({"down"}).exit, 0);
  ASSERT_EQ(UpDetached().exit, 0) << "a released stop does not come back from there";
  EXPECT_EQ(Musher({"down"}).exit, 0);
  unsetenv("XDG_STATE_HOME");
}

// Root's files, of a start by systemd, are closed to the person who starts the robot by hand: the
// stop was passed over, and the robot went to Active.
TEST_F(EmergencyStop, OfFilesThatThisUserMayNotReadKeepsTheMachineInSetUpUntilAPersonSetsAState) {
  namespace fs = std::filesystem;
  const auto as_another = [](std::vector<std::string> words) {
    words = Command(std::move(words));
    words.insert(words.begin(),
                 {"setpriv", "--reuid=65534", "--regid=65534", "--clear-groups", "--"});
    return RunToEnd(words);
  };
  if (geteuid() != 0 || as_another({"--version"}).exit != 0) {
    GTEST_SKIP() << "needs root, and programs that another user may run";
  }
  setenv("XDG_STATE_HOME", (folder_ / "by_service").c_str(), 1);
  Drop("state_dir = \"state\"\n");
  ASSERT_EQ(UpDetached().exit, 0);
  Estop();
  ASSERT_EQ(Musher({"down"}).exit, 0);
  for (const std::string& open :
       {folder_.path(), folder_ / "by_service", folder_ / "by_service/musher"}) {
    fs::permissions(open, fs::perms(0755));
  }
  Replace("[controller]\n", "[controller]\nstate_dir = \"by_hand\"\n");
  fs::create_directory(folder_ / "by_hand");
  ASSERT_EQ(chown((folder_ / "by_hand").c_str(), 65534, 65534), 0);
  const std::vector<std::string> up{"up", config_, "--detach"};
  const Ended held = as_another(up);
  EXPECT_EQ(held.exit, 1) << held.err;
  EXPECT_THAT(held.err, AllOf(HasSubstr("whether an emergency stop is engaged in " +
                                        (folder_ / "by_service/musher/robot")),
                              HasSubstr("this user may not read it")));
  EXPECT_EQ(Json(as_another({"status", "--json"}).out)["state"], "SetUp");
  EXPECT_EQ(as_another({"set", "SelfCheck"}).exit, 0);
  EXPECT_EQ(as_another({"set", "Active"}).exit, 0);
  ASSERT_EQ(as_another({"down"}).exit, 0);
  EXPECT_EQ(as_another(up).exit, 0) << "the person has answered it";
  EXPECT_EQ(as_another({"down"}).exit, 0);
  unsetenv("XDG_STATE_HOME");
}

// The stop is over, but the robot was not commanded since.
TEST_F(EmergencyStop, ThatIsReleasedKeepsAMachineWithAnotherStateFolderDownAtBoot) {
  setenv("XDG_STATE_HOME", (folder_ / "by_user").c_str(), 1);
  Drop("state_dir = \"state\"\n");
  ASSERT_EQ(UpDetached().exit, 0);
  Estop();
  ASSERT_EQ(Musher({"estop", "--release"}).exit, 0);
  ASSERT_EQ(Musher({"down"}).exit, 0);
  Replace("[controller]\n", "[controller]\nstate_dir = \"elsewhere\"\n");
  EXPECT_EQ(UpAtBoot().exit, 1);
  EXPECT_EQ(Status()["state"], "SetUp");
  EXPECT_THAT(ReadFile(folder_ / "elsewhere/controller.log"),
              HasSubstr("no state was requested since the last emergency stop in " +
                        (folder_ / "by_user/musher/robot")));
  EXPECT_EQ(Musher({"set", "SelfCheck"}).exit, 0);
  EXPECT_EQ(Musher({"set", "Active"}).exit, 0);
  ASSERT_EQ(Musher({"down"}).exit, 0);
  EXPECT_EQ(UpAtBoot().exit, 0) << "that was the request";
  EXPECT_EQ(Musher({"down"}).exit, 0);
  unsetenv("XDG_STATE_HOME");
}

// Another user may not look into the processes of root's robot. By the robot.toml where that person
// stands the machine has no other hosts, and the exit code was 0.
TEST_F(EmergencyStop, OfARobotWhoseProcessesThisUserMayNotReadIsNotReportedAsComplete) {
  if (geteuid() != 0) GTEST_SKIP() << "only root can be another user";
  ASSERT_NO_FATAL_FAILURE(Start());
  LoseController();
  std::filesystem::permissions(folder_.path(), std::filesystem::perms::all);
  const Ended estop =
      RunToEnd({"setpriv", "--reuid=65534", "--regid=65534", "--clear-groups", "sh", "-c",
                "cd " + folder_.path() + " && exec " + BinDir() + "/musher estop --timeout 5"});
  EXPECT_EQ(estop.exit, 1) << estop.out << estop.err;
  EXPECT_THAT(estop.err, HasSubstr("eyes, legs, voice run as processes of another user, whose "
                                   "config is not read"));
  ExpectLatchedByAll(true);
}

TEST_F(EmergencyStop, ReachesTheMachineWhoseIdBeginsAsAPersonSays) {
  ASSERT_NO_FATAL_FAILURE(Start());
  const std::string id = IdOf(folder_ / "state");
  const Ended estop = Musher({"estop", "smoke", "--machine", id.substr(0, 8)});
  EXPECT_EQ(estop.exit, 0) << estop.err;
  ExpectLatchedByAll(true);
  ASSERT_EQ(Musher({"estop", "--release"}).exit, 0);
  const Ended other = Musher({"estop", "--machine", "0000-of-none", "--timeout", "1"});
  EXPECT_EQ(other.exit, 1) << "what runs here may be of it, as far as is known";
  ExpectLatchedByAll(false);
}

TEST_F(EmergencyStop, ReachesTheMachineWhoseIdBeginsSoWithoutAController) {
  ASSERT_NO_FATAL_FAILURE(Start());
  LoseController();
  const std::string id = IdOf(folder_ / "state");
  const Ended estop = Musher({"estop", "smoke", "--machine", id.substr(0, 8)});
  EXPECT_EQ(estop.exit, 0) << estop.err;
  ExpectLatchedByAll(true);
}

TEST_F(EmergencyStop, IsReleasedByHandWhichChangesNoState) {
  ASSERT_NO_FATAL_FAILURE(Start());
  Estop();
  const Ended release = Musher({"estop", "--release"});
  EXPECT_EQ(release.exit, 0) << release.err;
  EXPECT_THAT(release.out, AllOf(HasSubstr("states are unchanged"),
                                 HasSubstr("robot is in LowPower (running)")));
  EXPECT_EQ(Status()["emergency_stop"]["engaged"], false);
  EXPECT_EQ(Musher({"set", "Active"}).exit, 0);
  const Ended again = Musher({"estop", "--release"});
  EXPECT_EQ(again.exit, 1);
  EXPECT_EQ(again.err, "musher: no emergency stop is engaged\n");
}

// The power of Active is off, although the state is Active still.
TEST_F(EmergencyStop, HoldsAnActiveRobotUntilItsStateIsSetAgainAfterTheRelease) {
  ASSERT_NO_FATAL_FAILURE(Start());
  ASSERT_EQ(Musher({"set", "Active"}).exit, 0);
  Estop();
  const Ended during = Musher({"set", "Active"});
  EXPECT_EQ(during.exit, 1);
  EXPECT_THAT(during.err, HasSubstr("until it is released it holds Active"));
  const Ended release = Musher({"estop", "--release"});
  EXPECT_THAT(release.out,
              HasSubstr("held by the stop until `musher set Active`: legs, voice, eyes"));
  EXPECT_EQ(Status()["held_by_stop"], (nlohmann::json{"legs", "voice", "eyes"}));
  const Ended again = Musher({"set", "Active"});
  EXPECT_EQ(again.exit, 0) << again.err;
  EXPECT_THAT(again.out, Not(HasSubstr("was already in that state")));
  EXPECT_EQ(Status()["held_by_stop"], nlohmann::json::array());
}

TEST_F(EmergencyStop, SurvivesACrashOfTheController) {
  ASSERT_NO_FATAL_FAILURE(Start());
  const auto report = Estop();
  LoseController();
  ASSERT_EQ(UpDetached().exit, 0);
  EXPECT_EQ(Status()["emergency_stop"]["by"], report["by"]);
  ExpectNothingGoesUp();
  EXPECT_EQ(Musher({"estop", "--release"}).exit, 0);
  EXPECT_EQ(Musher({"set", "Active"}).exit, 0);
}

TEST_F(EmergencyStop, IsLatchedByAnActuatorThatIsRestartedMeanwhile) {
  ASSERT_NO_FATAL_FAILURE(Start());
  Estop();
  const pid_t voice = Status()["actuators"]["voice"]["pid"];
  kill(voice, SIGKILL);
  ASSERT_NE(up_->LineWith("voice: SelfCheck done"), "");
  ASSERT_TRUE(AwaitReport([voice](const msg::ActuatorStatus& report) {
    return report.name == "voice" && report.pid != voice && report.emergency_stop != 0;
  })) << "it has not latched the stop that was engaged when it was matched";
  const auto second = Estop();
  EXPECT_EQ(second["actuators"]["voice"]["before"], true) << second;
  EXPECT_EQ(Status()["actuators"]["voice"]["state"], "SelfCheck");  // it does not come up
}

TEST_F(EmergencyStop, ReachesTheActuatorsWithoutAController) {
  ASSERT_NO_FATAL_FAILURE(Start());
  LoseController();
  const auto report = Estop();
  EXPECT_EQ(report["controller"], false);
  EXPECT_EQ(report["complete"], true);
  EXPECT_EQ(report["actuators"].size(), 3U);
  const Ended release = Musher({"estop", "--release", "--timeout", "0.5"});
  EXPECT_EQ(release.exit, 3);
  EXPECT_THAT(release.err, HasSubstr("only a controller can release an emergency stop"));
  EXPECT_THAT(Musher({"status"}).out, HasSubstr(": it smokes"));
  ASSERT_EQ(UpDetached().exit, 0);
  EXPECT_EQ(Status()["emergency_stop"]["engaged"], true);
  EXPECT_EQ(Status()["emergency_stop"]["reason"], "it smokes") << "the actuators have kept it";
  ExpectNothingGoesUp();
}

TEST_F(EmergencyStop, NamesAnActuatorThatDoesNotSayThatItHasStopped) {
  ASSERT_NO_FATAL_FAILURE(Start());
  const pid_t eyes = Status()["actuators"]["eyes"]["pid"];
  kill(eyes, SIGSTOP);
  const Ended estop = Musher({"estop", "--timeout", "1"});
  EXPECT_EQ(estop.exit, 1);
  EXPECT_THAT(estop.err, HasSubstr("stop not confirmed: eyes"));
  EXPECT_THAT(estop.out, HasSubstr("legs   stopped after "));
}

// The program that keeps a stop published for a minute went on after the release: a module that was
// restarted in that minute latched the released stop, and stayed degraded beside an Active machine.
TEST_F(EmergencyStop, IsPublishedNoLongerAfterItsReleaseAndHoldsNoModuleThatIsRestarted) {
  ASSERT_NO_FATAL_FAILURE(Start());
  const auto pid_of = [](const char* name) {
    return Status()["actuators"][name]["pid"].get<pid_t>();
  };
  const pid_t eyes = pid_of("eyes");
  kill(eyes, SIGSTOP);
  const Ended estop = Musher({"estop", "--timeout", "1"});
  kill(eyes, SIGCONT);
  EXPECT_EQ(estop.exit, 1);
  const std::string kept = "the stop stays published for a minute (pid ";
  ASSERT_THAT(estop.err, HasSubstr(kept));
  const pid_t publisher = std::stoi(estop.err.substr(estop.err.find(kept) + kept.size()));
  ExpectLatchedByAll(true);
  const Ended release = Musher({"estop", "--release"});
  ASSERT_EQ(release.exit, 0) << release.err;
  EXPECT_TRUE(Until([&] { return waitpid(publisher, nullptr, WNOHANG) == publisher; },
                    std::chrono::seconds(30)))
      << "it is published for the whole minute";
  ASSERT_EQ(Musher({"set", "Active"}).exit, 0);
  const pid_t voice = pid_of("voice");
  kill(voice, SIGKILL);
  AwaitStatus([voice](const nlohmann::json& now) {
    const nlohmann::json& one = now["actuators"]["voice"];
    return one["pid"] != voice && one["state"] == "Active" && now["degraded"].empty();
  });
}

// It said that no controller led, and to start one.
TEST_F(EmergencyStop, BesideAStoppedControllerNamesItAndHowItContinues) {
  ASSERT_NO_FATAL_FAILURE(Start());
  const pid_t controller = Status()["pid"];
  kill(controller, SIGSTOP);
  const Ended estop = Musher({"estop"});
  kill(controller, SIGCONT);
  EXPECT_EQ(estop.exit, 1);
  EXPECT_THAT(estop.err, HasSubstr("the controller has not confirmed it: process " +
                                   std::to_string(controller)));
  EXPECT_THAT(estop.err, HasSubstr("kill -CONT " + std::to_string(controller)));
}

TEST_F(EmergencyStop, KeepsANextStartFromGoingUpUntilItIsReleased) {
  ASSERT_NO_FATAL_FAILURE(Start());
  Estop();
  ASSERT_EQ(Musher({"down"}).exit, 0);
  const Ended up = UpDetached();
  EXPECT_EQ(up.exit, 1);
  EXPECT_THAT(up.err, HasSubstr("an emergency stop is engaged; run `musher estop --release`"));
  const Ended release = Musher({"estop", "--release"});
  EXPECT_THAT(release.out, HasSubstr("`musher set SelfCheck`, then `musher set Active`"));
  EXPECT_EQ(Musher({"set", "SelfCheck"}).exit, 0);
  EXPECT_EQ(Musher({"set", "Active"}).exit, 0);
}

// Its actuators are discovered only after the command has ended, as on a bad link.
TEST_F(EmergencyStop, IsPublishedForAMinuteAfterACommandThatReachedNoActuator) {
  const Ended estop = Musher({"estop", "it", "smokes", "--timeout", "0.2"});
  EXPECT_EQ(estop.exit, 3);
  EXPECT_THAT(estop.err, AllOf(HasSubstr("no controller or actuator in namespace '" + name_space_),
                               HasSubstr("the stop stays published for a minute")));
  const Ended up = UpDetached();
  EXPECT_EQ(up.exit, 1);
  EXPECT_THAT(up.err, HasSubstr("an emergency stop is engaged"));
  EXPECT_EQ(Status()["emergency_stop"]["reason"], "it smokes");
}

TEST_F(EmergencyStop, IsPublishedAfterItsCommandWasKilled) {
  Process estop(Command({"estop", "it", "smokes", "--timeout", "30"}));
  ASSERT_TRUE(AwaitStop());
  kill(estop.pid(), SIGKILL);
  estop.Wait();
  const Ended up = UpDetached();
  EXPECT_EQ(up.exit, 1);
  EXPECT_THAT(up.err, HasSubstr("an emergency stop is engaged"));
}

TEST_F(EmergencyStop, IsNotReportedAsCompleteBesideAControllerThatDoesNotAnswer) {
  ASSERT_NO_FATAL_FAILURE(Start());
  const pid_t controller = Status()["pid"];
  kill(controller, SIGSTOP);
  const Ended estop = Musher({"estop", "--timeout", "1"});
  kill(controller, SIGCONT);
  EXPECT_EQ(estop.exit, 1);
  EXPECT_THAT(estop.err, HasSubstr("but does not answer"));
  EXPECT_THAT(estop.out, HasSubstr("legs   stopped after "));
}

}  // namespace musher::testing::estop_test
