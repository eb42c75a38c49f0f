// Emergency stops by hand, with a controller and without one.

#include <fcntl.h>
#include <signal.h>
#include <sys/mount.h>
#include <sys/wait.h>

#include <atomic>

#include "musher/base/unique_fd.hpp"
#include "musher/lifecycle/machine/machine_identity.hpp"
#include "musher/messages/musher_msgs/actuator_status.hpp"
#include "musher/messages/musher_msgs/heartbeats.hpp"
#include "musher/messages/musher_msgs/machine_status.hpp"
#include "musher/test/integration/cli/machine.hpp"
#include "musher/transport/dds/dds_node.hpp"
#include "musher/transport/dds/node_thread.hpp"
#include "musher/transport/linux_event_loop.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher::testing::estop_test {

using ::testing::AllOf;
using ::testing::HasSubstr;

// A robot of another host, with one actuator.
class FarRobot {
 public:
  // `appears_after`: so long after it has received a stop it is discovered; nullopt: at once.
  FarRobot(std::string name_space, std::string machine, std::string id, std::string actuator,
           std::optional<Duration> appears_after = std::nullopt,
           std::string host = "another boot/1")
      : name_space_(std::move(name_space)),
        machine_{std::move(machine), std::move(id)},
        actuator_(std::move(actuator)),
        host_(std::move(host)) {
    thread_->RunOnLoop([&] {
      stops_ = transport::SubscribeToStops(thread_->node(), name_space_,
                                           [this, appears_after](const auto& stop, const auto&) {
                                             transport::EventLoop& loop = thread_->node().loop();
                                             if (appears_after && !appears_) {
                                               appears_ = loop.At(loop.Now() + *appears_after,
                                                                  [this] { Appear(); });
                                             }
                                             OnStop(stop);
                                           })
                   .value();
      if (!appears_after) Appear();
    });
  }
  ~FarRobot() {
    thread_->RunOnLoop([this] {
      appears_ = nullptr;
      stops_ = nullptr;
      infos_ = nullptr;
      heartbeats_ = nullptr;
      controllers_ = nullptr;
      actuators_ = nullptr;
    });
  }
  FarRobot(const FarRobot&) = delete;
  FarRobot& operator=(const FarRobot&) = delete;

  bool stopped() const { return stopped_; }
  void ConfirmNothing() { confirms_ = false; }

 private:
  template <class Message>
  std::unique_ptr<transport::Publisher<Message>> Publish(const std::string& topic,
                                                         const Message& message) {
    auto publisher =
        transport::MakePublisher<Message>(thread_->node(), topic, transport::kLatchedQos).value();
    EXPECT_TRUE(publisher->Publish(message));
    return publisher;
  }
  void Appear() {
    const std::uint64_t participant = thread_->node().participant().value();
    msg::ControllerHeartbeat heartbeat;
    heartbeat.machine = machine_.name;
    heartbeat.machine_id = machine_.id;
    heartbeat.epoch = 1;
    heartbeat.host = host_;
    heartbeat.pid = 7;
    heartbeat.participant = participant;
    heartbeat.period_ns = Duration(std::chrono::seconds(10)).count();
    heartbeats_ = Publish(transport::ControllerHeartbeatTopic(name_space_), heartbeat);
    actuator_status_.name = actuator_;
    actuator_status_.machine = machine_.name;
    actuator_status_.machine_id = machine_.id;
    actuator_status_.host = host_;
    actuator_status_.participant = participant;
    actuators_ = Publish(transport::ActuatorStatusTopic(name_space_), actuator_status_);
    status_.machine = machine_.name;
    status_.machine_id = machine_.id;
    status_.name_space = name_space_;
    status_.host = host_;
    status_.pid = 7;
    status_.epoch = 1;
    status_.participant = participant;
    msg::ActuatorInfo& actuator = status_.actuators.emplace_back();
    actuator.name = actuator_;
    actuator.presence = "present";
    actuator.health = "well";
    actuator.protocol = "musher";
    controllers_ = Publish(transport::MachineStatusTopic(name_space_), status_);
    infos_ = Publish(std::string(transport::kMachinesTopic),
                     msg::MachineInfo{machine_.name, name_space_, host_, 7, machine_.id});
  }
  void OnStop(const msg::EmergencyStop& stop) {
    if (!SameMachine(machine_, {stop.machine, stop.machine_id})) return;
    stopped_ = true;
    if (!actuators_ || !confirms_) return;
    actuator_status_.emergency_stop = stop.id;
    status_.emergency_stop = true;
    status_.emergency_stop_by = stop.by;
    status_.emergency_stop_reason = stop.reason;
    EXPECT_TRUE(actuators_->Publish(actuator_status_));
    EXPECT_TRUE(controllers_->Publish(status_));
  }

  const std::string name_space_;
  const MachineIdentity machine_;
  const std::string actuator_;
  const std::string host_;
  std::atomic<bool> stopped_ = false;
  std::atomic<bool> confirms_ = true;
  msg::ActuatorStatus actuator_status_;
  msg::MachineStatus status_;
  const std::shared_ptr<transport::NodeThread> thread_ = transport::NodeThread::Start({}).value();
  transport::LoopHandlePtr appears_;
  std::unique_ptr<transport::Subscription> stops_;
  std::unique_ptr<transport::Publisher<msg::MachineInfo>> infos_;
  std::unique_ptr<transport::Publisher<msg::ControllerHeartbeat>> heartbeats_;
  std::unique_ptr<transport::Publisher<msg::MachineStatus>> controllers_;
  std::unique_ptr<transport::Publisher<msg::ActuatorStatus>> actuators_;
};

// A descriptor of this process on a file system that does not answer, as on a network file system
// whose server is lost: each process that looks at it waits.
class HungDescriptor {
 public:
  explicit HungDescriptor(std::string folder)
      : folder_(std::move(folder)), server_(open("/dev/fuse", O_RDWR | O_CLOEXEC)) {
    std::filesystem::create_directory(folder_);
    const std::string options =
        "fd=" + std::to_string(server_.get()) + ",rootmode=40000,user_id=0,group_id=0";
    mounted_ = server_.valid() && mount("hung", folder_.c_str(), "fuse", 0, options.c_str()) == 0;
    if (mounted_) file_ = UniqueFd(open(folder_.c_str(), O_PATH | O_CLOEXEC));
  }
  ~HungDescriptor() {
    server_ = {};
    file_ = {};
    if (mounted_) umount2(folder_.c_str(), MNT_DETACH);
  }
  HungDescriptor(const HungDescriptor&) = delete;
  HungDescriptor& operator=(const HungDescriptor&) = delete;

  bool valid() const { return file_.valid(); }

 private:
  const std::string folder_;
  UniqueFd server_;
  bool mounted_ = false;
  UniqueFd file_;
};

class EmergencyStop : public MachineByCli {
 protected:
  void Start() {
    up_ = std::make_unique<Process>(Command({"up", config_}));
    ASSERT_NE(up_->LineWith("eyes: Active done"), "");
    ASSERT_EQ(Musher({"set", "LowPower"}).exit, 0);
  }
  // A stopped process that may be restarted is killed: on a busy computer before a command has
  // ended, and its successor confirms the stop.
  void KeepEyesThatAreStopped() const {
    Replace("[actuator.eyes]\n", "[actuator.eyes]\nrestart = \"no\"\n");
  }
  // The controller exits, its actuators continue.
  void LoseController() {
    kill(Status()["pid"].get<pid_t>(), SIGKILL);
    EXPECT_EQ(up_->Wait().exit, 1);
  }
  static nlohmann::json Estop() {
    const Ended estop = Musher({"estop", "it", "smokes", "--json", "--timeout", "60"});
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

  // Waits until the status of an actuator is so, two minutes at most; returns whether one was.
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
    return loop.RunUntil([&] { return reported; }, loop.Now() + std::chrono::seconds(120));
  }

  // Waits until a stop is published; returns the first one, with the id 0 if there is none.
  msg::EmergencyStop AwaitStop() const {
    transport::LinuxEventLoop loop;
    const auto node = transport::MakeDdsNode(loop, {}).value();
    msg::EmergencyStop published;
    const auto stops =
        transport::SubscribeToStops(*node, name_space_, [&](const auto& stop, const auto&) {
          if (stop.engaged && published.id == 0) published = stop;
        }).value();
    loop.RunUntil([&] { return published.id != 0; }, loop.Now() + std::chrono::seconds(120));
    return published;
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
  EXPECT_THAT(second.out,
              HasSubstr("an emergency stop was already engaged by " +
                        first["by"].get<std::string>() + ": it smokes; then: once more\n"));
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
  EXPECT_THAT(held.err, AllOf(HasSubstr("an emergency stop may be engaged in " +
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
                "cd " + folder_.path() + " && exec " + BinDir() + "/musher estop --timeout 10"});
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

// The search of the processes of this host came first.
TEST_F(EmergencyStop, GoesOutBeforeASearchThatADescriptorOfAnotherProcessHoldsUp) {
  ASSERT_NO_FATAL_FAILURE(Start());
  const std::string id = IdOf(folder_ / "state").substr(0, 8);
  for (const std::vector<std::string>& words : std::vector<std::vector<std::string>>{
           {"estop", "--machine", "robot"}, {"estop"}, {"estop", "--machine", id}}) {
    std::optional<HungDescriptor> hung(std::in_place, folder_ / "hung");
    if (!hung->valid()) GTEST_SKIP() << "a file system that hangs needs root and /dev/fuse";
    Process estop(Command(words));
    ExpectLatchedByAll(true);
    hung.reset();
    EXPECT_EQ(estop.Wait().exit, 0) << words.back();
    ASSERT_EQ(Musher({"estop", "--release"}).exit, 0);
    ExpectLatchedByAll(false);
  }
}

// It looked for the name of its user first.
TEST_F(EmergencyStop, GoesOutThoughTheDatabaseOfUsersDoesNotAnswer) {
  ASSERT_NO_FATAL_FAILURE(Start());
  for (const bool with_controller : {true, false}) {
    if (!with_controller) {
      ASSERT_EQ(Musher({"estop", "--release"}).exit, 0);
      ExpectLatchedByAll(false);
      LoseController();
    }
    std::ofstream(folder_ / "lost") << "remove this file to end it\n";
    std::vector<std::string> words = Command({"estop"});
    words.insert(words.begin(),
                 {"sh", "-c",
                  "ASAN_OPTIONS=\"$ASAN_OPTIONS:verify_asan_link_order=0\" LD_PRELOAD=\"$0\" "
                  "MUSHER_USERS_LOST_WHILE=\"$1\" && export ASAN_OPTIONS LD_PRELOAD "
                  "MUSHER_USERS_LOST_WHILE && shift && exec \"$@\"",
                  BinDir() + "/cli_lost_user_database.so", folder_ / "lost"});
    Process estop(words);
    ExpectLatchedByAll(true);
    std::filesystem::remove(folder_ / "lost");
    const Ended ended = estop.Wait();
    EXPECT_EQ(ended.exit, 0) << ended.err;
  }
}

// Where the command is typed in the folder of an unrelated robot, it was taken for the named one.
TEST_F(EmergencyStop, ByNameIsCompleteInTheFolderOfAnotherMachineOfTheProfileLan) {
  ASSERT_NO_FATAL_FAILURE(Start());
  LoseController();
  OtherRobot("cat", name_space_, folder_ / "cat_state");
  std::ofstream(folder_ / "other/robot.toml", std::ios::app)
      << "[transport]\nprofile = \"lan\"\ninterfaces = [\"tether0\"]\n";
  const auto estop_in_folder = [this](const std::string& timeout_s, const std::string& machine) {
    return RunToEnd({"sh", "-c",
                     "cd " + (folder_ / "other") + " && exec " + BinDir() +
                         "/musher estop --timeout " + timeout_s + " --machine " + machine});
  };
  const Ended by_name = estop_in_folder("60", "robot");
  EXPECT_EQ(by_name.exit, 0) << by_name.out << by_name.err;
  const Ended by_id = estop_in_folder("3", "0000beef");
  EXPECT_THAT(by_id.err, Not(HasSubstr("tether0"))) << "it may be cat, or another one";
}

TEST_F(EmergencyStop, OfANameThatTwoMachinesHaveStopsBothAndReportsNoOtherOne) {
  const FarRobot cat(name_space_, "cat", "cafe0000-0000-4000-8000-000000000001", "tail");
  const FarRobot dog(name_space_, "dog", "d0900000-0000-4000-8000-000000000002", "legs");
  const FarRobot other_dog(name_space_, "dog", "d0910000-0000-4000-8000-000000000003", "arms");
  const Ended estop = Musher({"estop", "--machine", "dog"});
  EXPECT_EQ(estop.exit, 1) << estop.out << estop.err;
  EXPECT_THAT(estop.err, AllOf(HasSubstr("several machines have received the stop"),
                               HasSubstr("dog (id d0900000)"), HasSubstr("dog (id d0910000)"),
                               HasSubstr("--machine ID"), Not(HasSubstr("tail"))));
  EXPECT_THAT(estop.out, Not(HasSubstr("tail")));
  EXPECT_TRUE(dog.stopped() && other_dog.stopped());
  EXPECT_FALSE(cat.stopped());
}

// Its controller was not followed, so the stop was not confirmed.
TEST_F(EmergencyStop, ByTheBeginningOfAnIdIsConfirmedByAMachineThatIsDiscoveredLate) {
  const FarRobot dog(name_space_, "dog", "5982c7ee-0000-4000-8000-000000000002", "legs",
                     Milliseconds(3000));
  const Ended estop = Musher({"--transport", "lan", "estop", "--machine", "5982"});
  EXPECT_EQ(estop.exit, 0) << estop.out << estop.err;
  EXPECT_TRUE(dog.stopped());
}

// Only the machine of this host had it.
TEST_F(EmergencyStop, ReachesEachMachineThatIsMeantAlsoWhereOneOfThemRunsHere) {
  ASSERT_NO_FATAL_FAILURE(Start());
  const std::string id = IdOf(folder_ / "state").substr(0, 4);
  const FarRobot named(name_space_, id, "cafe0000-0000-4000-8000-000000000001", "tail");
  const FarRobot begins_so(name_space_, "dog", id + "0000-0000-4000-8000-000000000002", "head");
  const Ended estop = Musher({"estop", "--machine", id});
  EXPECT_EQ(estop.exit, 1) << estop.out << estop.err;
  EXPECT_THAT(estop.err, HasSubstr("several machines have received the stop"));
  EXPECT_TRUE(named.stopped());
  EXPECT_TRUE(begins_so.stopped());
  ExpectLatchedByAll(true);
}

// Two machines of one name were refused, and each command waited for the second one.
TEST_F(EmergencyStop, OfTwoMachinesOfANameACommandSpeaksToTheOneOfItsHost) {
  ASSERT_NO_FATAL_FAILURE(Start());
  const FarRobot other(name_space_, "robot", "cafe0000-0000-4000-8000-000000000001", "tail");
  const Ended set = Musher({"set", "Active", "--machine", "robot"});
  EXPECT_EQ(set.exit, 0) << set.err;
  EXPECT_EQ(Status()["state"], "Active");
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

// It is on no disk: `down` or a loss of power ends the actuators, which have it, and the next start
// goes to Active. The command did not say so.
TEST_F(EmergencyStop, WithoutAControllerSaysThatItIsOnNoDiskAndStaysPublished) {
  ASSERT_NO_FATAL_FAILURE(Start());
  LoseController();
  const Ended estop = Musher({"estop", "it", "smokes"});
  EXPECT_EQ(estop.exit, 0) << "every actuator is stopped";
  EXPECT_THAT(estop.err, AllOf(HasSubstr("not on disk: no controller leads that saves it"),
                               HasSubstr("the stop is lost if the actuators end; the stop stays "
                                         "published for a minute (pid ")));
}

// It names no machine, which every release left published for the whole minute.
TEST_F(EmergencyStop, WithoutAControllerNamesTheMachineAndIsPublishedNoLongerAfterItsRelease) {
  ASSERT_NO_FATAL_FAILURE(Start());
  LoseController();
  const Ended estop = Musher({"estop", "it", "smokes"});
  EXPECT_EQ(estop.exit, 0) << estop.err;
  EXPECT_THAT(estop.out, HasSubstr("\nmachine: "));
  EXPECT_THAT(estop.err, HasSubstr("), for every machine that receives it"));
  const pid_t publisher = PublisherOf(estop);
  ASSERT_NE(publisher, 0);
  ASSERT_EQ(UpDetached().exit, 0);
  const Ended release = Musher({"estop", "--release"});
  ASSERT_EQ(release.exit, 0) << release.err;
  EXPECT_TRUE(Until([&] { return waitpid(publisher, nullptr, WNOHANG) == publisher; },
                    std::chrono::seconds(30)))
      << "it is published for the whole minute";
}

TEST_F(EmergencyStop, NamesAnActuatorThatDoesNotSayThatItHasStopped) {
  KeepEyesThatAreStopped();
  ASSERT_NO_FATAL_FAILURE(Start());
  const pid_t eyes = Status()["actuators"]["eyes"]["pid"];
  kill(eyes, SIGSTOP);
  const Ended estop = Musher({"estop", "--timeout", "4"});  // for the others
  EXPECT_EQ(estop.exit, 1);
  EXPECT_THAT(estop.err, HasSubstr("stop not confirmed: eyes"));
  EXPECT_THAT(estop.out, HasSubstr("legs   stopped after "));
}

// It said "stopped" of a program that drove on.
TEST_F(EmergencyStop, NamesAProgramThatNothingStopsAndEndsOneThatSaysSo) {
  const std::string start = "[state.SetUp]\nstart = [\"sleep\", \"infinity\"]\n";
  Does("legs", start + "[emergency_stop]\nend_program = true\n");
  Does("voice", start);
  ASSERT_NO_FATAL_FAILURE(Start());
  const std::string none = "voice.toml has no [emergency_stop]: nothing stops its program";
  EXPECT_THAT(Musher({"check", config_}).out, HasSubstr("warning: " + none));
  const Ended estop = Musher({"estop", "--timeout", "10"});
  EXPECT_EQ(estop.exit, 1);
  EXPECT_THAT(estop.err, HasSubstr("stop not confirmed: voice"));
  EXPECT_THAT(estop.out, AllOf(HasSubstr("legs   stopped after "), HasSubstr("voice  " + none)));

  ASSERT_EQ(Musher({"estop", "--release"}).exit, 0);
  const Ended again = Musher({"set", "Active"});
  EXPECT_NE(again.exit, 0);
  EXPECT_THAT(again.out, HasSubstr("`musher restart legs` starts it again"));
  const Ended restart = Musher({"restart", "legs"});
  EXPECT_EQ(restart.exit, 0) << restart.err;
  EXPECT_THAT(restart.out, HasSubstr("legs is back in LowPower"));
  EXPECT_EQ(Musher({"set", "Active"}).exit, 0);
}

// The program that keeps a stop published for a minute went on after the release: a module that was
// restarted in that minute latched the released stop, and stayed degraded beside an Active machine.
TEST_F(EmergencyStop, IsPublishedNoLongerAfterItsReleaseAndHoldsNoModuleThatIsRestarted) {
  KeepEyesThatAreStopped();
  ASSERT_NO_FATAL_FAILURE(Start());
  const auto pid_of = [](const char* name) {
    return Status()["actuators"][name]["pid"].get<pid_t>();
  };
  const pid_t eyes = pid_of("eyes");
  kill(eyes, SIGSTOP);
  const Ended estop = Musher({"estop", "--timeout", "1"});
  kill(eyes, SIGCONT);
  EXPECT_EQ(estop.exit, 1);
  const pid_t publisher = PublisherOf(estop);
  ASSERT_NE(publisher, 0);
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

// The command aborted.
TEST_F(EmergencyStop, InADomainThatIsNoneSaysSo) {
  const std::string domain = getenv("ROS_DOMAIN_ID");
  setenv("ROS_DOMAIN_ID", "abc", 1);
  const Ended estop = Musher({"estop"});
  setenv("ROS_DOMAIN_ID", domain.c_str(), 1);
  EXPECT_EQ(estop.exit, 2);
  EXPECT_THAT(estop.err, HasSubstr("the DDS domain must be 0 to 232, but it is \"abc\""));
}

// A controller ends the processes of an actuator with it, and finds them by these: the stop that an
// actuator had engaged ended with its restart.
TEST_F(EmergencyStop, IsPublishedByAProcessWithoutTheMarksOfTheActuatorThatEngagedIt) {
  const std::map<std::string, std::string> marks = {{"MUSHER_PROCESS", "1/2"},
                                                    {"MUSHER_STARTED_AS", "0000000001/legs"},
                                                    {"MUSHER_CONFIG", "/nowhere/robot.toml"}};
  for (const auto& [name, value] : marks) setenv(name.c_str(), value.c_str(), 1);
  const Ended estop = Musher({"estop", "it", "smokes", "--timeout", "0.2"});
  for (const auto& [name, value] : marks) unsetenv(name.c_str());
  const pid_t publisher = PublisherOf(estop);
  ASSERT_NE(publisher, 0);
  const std::string environment = ReadFile("/proc/" + std::to_string(publisher) + "/environ");
  EXPECT_NE(environment.find("ROS_DOMAIN_ID="), std::string::npos);
  for (const auto& [name, value] : marks) {
    EXPECT_EQ(environment.find(name + "="), std::string::npos) << name;
  }
  End(publisher);
}

// It stopped each robot of that name which was started in the minute.
TEST_F(EmergencyStop, ByNameIsPublishedForAMinuteToTheRobotsThatWereFound) {
  const std::string id = "d0900000-0000-4000-8000-000000000002";
  std::optional<FarRobot> dog(std::in_place, name_space_, "dog", id, "legs");
  dog->ConfirmNothing();
  const Ended estop = Musher({"estop", "--machine", "dog", "--timeout", "10"});
  EXPECT_EQ(estop.exit, 1) << estop.out << estop.err;
  const pid_t publisher = PublisherOf(estop);
  ASSERT_NE(publisher, 0);
  EXPECT_TRUE(dog->stopped());
  dog.reset();
  const FarRobot next(name_space_, "dog", "d0910000-0000-4000-8000-000000000003", "legs",
                      std::nullopt, "third boot/1");
  const msg::EmergencyStop stop = AwaitStop();
  EXPECT_EQ(stop.machine, "dog");
  EXPECT_EQ(stop.machine_id, id);
  EXPECT_FALSE(next.stopped());
  End(publisher);
}

TEST_F(EmergencyStop, IsPublishedAfterItsCommandWasKilled) {
  Process estop(Command({"estop", "it", "smokes", "--timeout", "30"}));
  ASSERT_NE(AwaitStop().id, 0U);
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
  const Ended estop = Musher({"estop", "--timeout", "4"});
  kill(controller, SIGCONT);
  EXPECT_EQ(estop.exit, 1);
  EXPECT_THAT(estop.err, HasSubstr("but does not answer"));
  EXPECT_THAT(estop.out, HasSubstr("legs   stopped after "));
}

}  // namespace musher::testing::estop_test
