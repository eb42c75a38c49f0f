// Which machine a command speaks to where several answer, and none of them is of this host: none,
// until a person names one.

#include <gmock/gmock.h>
#include <unistd.h>

#include <atomic>
#include <cstdlib>

#include "musher/base/host.hpp"
#include "musher/cli/machine/link.hpp"
#include "musher/controller/storage/state_store.hpp"
#include "musher/messages/musher_msgs/machine_services.hpp"
#include "musher/messages/musher_msgs/machine_status.hpp"
#include "musher/test/cli/fake_controller.hpp"
#include "musher/test/cli/program.hpp"
#include "musher/test/support/domain.hpp"
#include "musher/test/support/temp_folder.hpp"
#include "musher/transport/dds/dds_node.hpp"
#include "musher/transport/linux_event_loop.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher::cli::machine_choice_test {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr const char* kCat = "cafe0000-0000-4000-8000-000000000001";
constexpr const char* kDog = "d0900000-0000-4000-8000-000000000002";
constexpr const char* kOtherDog = "d0900000-0000-4000-8000-000000000003";

// What the controller of a machine on another host publishes of it.
class FarController {
 public:
  FarController(const std::string& name_space, const std::string& machine, const std::string& id,
                std::uint64_t participant = 0) {
    publisher_ = transport::MakePublisher<msg::MachineInfo>(
                     *node_, std::string(transport::kMachinesTopic), transport::kLatchedQos)
                     .value();
    EXPECT_TRUE(publisher_->Publish({machine, name_space, "another boot/1", 7, id, participant}));
  }

 private:
  transport::LinuxEventLoop loop_;
  std::unique_ptr<transport::Node> node_ = transport::MakeDdsNode(loop_, {}).value();
  std::unique_ptr<transport::Publisher<msg::MachineInfo>> publisher_;
};

class AMachine : public ::testing::Test {
 protected:
  AMachine() { setenv("ROS_DOMAIN_ID", std::to_string(transport::TestDomain()).c_str(), 1); }
  ~AMachine() override { unsetenv("ROS_DOMAIN_ID"); }

  FarController Far(const std::string& machine, const std::string& id) const {
    return {name_space_, machine, id};
  }
  Ran Command(std::vector<std::string> words) const {
    words.insert(words.begin(), {"--namespace", name_space_});
    return RunProgram(words);
  }

  const std::string name_space_ = "machine_choice_test_" + std::to_string(getpid());
};

TEST_F(AMachine, IsNotChosenOfSeveralThatAnswerFromOtherHosts) {
  const FarController cat = Far("cat", kCat);
  const FarController dog = Far("dog", kDog);
  for (const std::vector<std::string>& words :
       std::vector<std::vector<std::string>>{{"set", "Active"}, {"down"}, {"plan", "Active"}}) {
    const Ran ran = Command(words);
    EXPECT_EQ(ran.exit, 2) << words[0];
    EXPECT_EQ(ran.out, "") << words[0];
    EXPECT_THAT(ran.err, AllOf(HasSubstr("several machines answer in namespace '" + name_space_ +
                                         "', none of them on this host: "),
                               HasSubstr("cat (id cafe0000), pid 7 of another host"),
                               HasSubstr("dog (id d0900000), pid 7 of another host"),
                               HasSubstr("Nothing was done; --machine NAME speaks to one of them")))
        << words[0];
  }
}

TEST_F(AMachine, IsNotChosenOfTwoOfTheNameThatAPersonNames) {
  const FarController cat = Far("cat", kCat);
  const FarController dog = Far("dog", kDog);
  const FarController other_dog = Far("dog", kOtherDog);
  const Ran ran = Command({"set", "Active", "--machine", "dog"});
  EXPECT_EQ(ran.exit, 2);
  EXPECT_THAT(ran.err, AllOf(HasSubstr("several machines are named dog: "),
                             HasSubstr("Nothing was done"), Not(HasSubstr("cat"))));
}

// A bridge that repeats what a controller has latched serves nothing: a command waited for it.
TEST_F(AMachine, IsNotSoughtAtAParticipantThatRepeatsItsAnnouncement) {
  const FarController bridge{name_space_, "dog", kDog, 12345};
  const Ran ran = Command({"set", "Active", "--machine", "dog"});
  EXPECT_EQ(ran.exit, 3);
  EXPECT_THAT(ran.err,
              HasSubstr("no controller of machine dog in namespace '" + name_space_ + "'"));
}

// The controller of a machine on this host, as far as a command looks: its name, its state folder,
// and what it publishes.
class NearController {
 public:
  NearController(const std::string& name_space, const std::string& machine, const std::string& id)
      : name_(NameLock::Acquire(
            NameLock::NameOf(transport::TestDomain(), name_space, "musher/controller"))),
        store_(StateStore::Open(folder_ / "state", {machine, name_space, transport::TestDomain(),
                                                    folder_ / "robot.toml", id})) {
    EXPECT_TRUE(name_);
    EXPECT_TRUE(store_);
    store_.value().SetMachineId(id);
    EXPECT_TRUE(store_.value().SaveMachineId());
    publisher_ = transport::MakePublisher<msg::MachineInfo>(
                     *node_, std::string(transport::kMachinesTopic), transport::kLatchedQos)
                     .value();
    EXPECT_TRUE(publisher_->Publish({machine, name_space, HostId(), getpid(), id}));
  }

 private:
  const TempFolder folder_;
  const Result<NameLock> name_;
  Result<StateStore> store_;
  transport::LinuxEventLoop loop_;
  std::unique_ptr<transport::Node> node_ = transport::MakeDdsNode(loop_, {}).value();
  std::unique_ptr<transport::Publisher<msg::MachineInfo>> publisher_;
};

// A copy of the robot on another host, with its name: `--machine NAME` refused on the robot itself,
// in C++ only.
TEST_F(AMachine, OfThisHostIsMeantByItsNameBesideACopyOfItOnAnotherHost) {
  const FarController copy = Far("dog", kOtherDog);
  const NearController dog(name_space_, "dog", kDog);
  for (const std::string& named : {std::string("dog"), std::string(kDog).substr(0, 8)}) {
    GlobalOptions global;
    global.name_space = name_space_;
    global.machine = named;
    const auto link = Link::Open(global);
    ASSERT_TRUE(link) << link.error().message;
    const auto open = link.value()->ChooseMachine();
    EXPECT_FALSE(open) << named << ": " << open->error.message;
    EXPECT_EQ(link.value()->machine().id, kDog) << named;
  }
}

TEST_F(AMachine, OfAnotherHostIsMeantByItsNameBesideTheOneOfThisHost) {
  const FarController cat = Far("cat", kCat);
  const NearController dog(name_space_, "dog", kDog);
  GlobalOptions global;
  global.name_space = name_space_;
  global.machine = "cat";
  const auto link = Link::Open(global);
  ASSERT_TRUE(link);
  EXPECT_FALSE(link.value()->ChooseMachine());
  EXPECT_EQ(link.value()->machine().id, kCat);
}

// Both of its controllers, for example during a takeover.
TEST_F(AMachine, ThatTwoControllersAnswerForIsOne) {
  const FarController first = Far("dog", kDog);
  const FarController second = Far("dog", kDog);
  for (const std::vector<std::string>& words : std::vector<std::vector<std::string>>{
           {"plan", "Active", "--timeout", "1"},
           {"plan", "Active", "--timeout", "1", "--machine", "dog"}}) {
    EXPECT_THAT(Command(words).err, Not(HasSubstr("several machines")));
  }
}

// `down` on a robot that was down took down the first robot that answered after the search.
TEST_F(AMachine, ThatAnswersOnlyAfterTheSearchIsNotActedOn) {
  GlobalOptions global;
  global.name_space = name_space_;
  const auto link = Link::OpenForCalls(global);
  const auto none = link->ChooseMachine(Link::Purpose::kAct);
  EXPECT_TRUE(none && none->exit == ExitCode::kNoController);
  std::atomic<int> released = 0;
  FakeController cat(name_space_, "cat", kCat, "Active");
  cat.Serve<msg::ReleaseEmergencyStop>("release_emergency_stop",
                                       [&released](const auto&, const auto& reply) {
                                         ++released;
                                         reply({});
                                       });
  ASSERT_TRUE(link->RunUntil([&link] { return link->HasMachine(); }, std::chrono::seconds(120)));
  const auto answer = link->Call<msg::ReleaseEmergencyStop>("release_emergency_stop", {"a test"},
                                                            std::chrono::seconds(5));
  const auto* failure = std::get_if<Failure>(&answer);
  EXPECT_TRUE(failure != nullptr && failure->exit == ExitCode::kNoController);
  EXPECT_THAT(failure == nullptr ? "" : failure->error.message,
              HasSubstr("found '" + name_space_ + "' (cat) - use --machine cat"));
  EXPECT_EQ(released, 0);
}

TEST_F(AMachine, OfTheNameThatIsGivenIsNotActedOnIfItAnswersOnlyAfterTheSearch) {
  GlobalOptions global;
  global.name_space = name_space_;
  global.machine = "dog";
  const auto link = Link::OpenForCalls(global);
  const auto none = link->ChooseMachine(Link::Purpose::kAct);
  ASSERT_TRUE(none);
  EXPECT_EQ(none->exit, ExitCode::kNoController);
  EXPECT_THAT(none->error.message, HasSubstr("no controller of machine dog"));
}

// The files of a machine that ran on this host, without a controller.
class Stopped {
 public:
  Stopped(const std::string& name_space, const std::string& machine, const std::string& id) {
    setenv("XDG_STATE_HOME", place_.path().c_str(), 1);
    auto store =
        StateStore::Open(place_ / "musher/stopped",
                         {machine, name_space, transport::TestDomain(), place_ / "robot.toml", id});
    EXPECT_TRUE(store);
    store.value().SetMachineId(id);
    EXPECT_TRUE(store.value().SaveMachineId());
  }
  ~Stopped() { unsetenv("XDG_STATE_HOME"); }

 private:
  const TempFolder place_;
};

// The robot was booting, another one was Active, and `musher wait Active` returned 0.
TEST_F(AMachine, OfAnotherHostIsNotWaitedForInPlaceOfTheOneOfThisHost) {
  const Stopped dog(name_space_, "dog", kDog);
  const FakeController cat(name_space_, "cat", kCat, "Active");
  const Ran ran = Command({"wait", "Active", "--timeout", "3"});
  EXPECT_EQ(ran.exit, 3) << ran.out;
  EXPECT_THAT(ran.err, AllOf(HasSubstr("the machine of this host, dog (id d0900000), does not run"),
                             HasSubstr("--machine NAME")));
  EXPECT_EQ(Command({"wait", "Active", "--timeout", "60", "--machine", "cat"}).exit, 0);
}

// While its controller is restarted beside its actuators.
TEST_F(AMachine, IsWaitedForWhileOnlyItsActuatorsRunAndAnotherOneAnswers) {
  const auto legs =
      NameLock::Acquire(NameLock::NameOf(transport::TestDomain(), name_space_, "legs"));
  ASSERT_TRUE(legs);
  const FakeController cat(name_space_, "cat", kCat, "Active");
  const auto begun = std::chrono::steady_clock::now();
  const Ran ran = Command({"wait", "Active", "--timeout", "3"});
  EXPECT_EQ(ran.exit, 3) << ran.out;
  EXPECT_THAT(ran.err, HasSubstr("no controller of it answers"));
  EXPECT_GE(std::chrono::steady_clock::now() - begun, std::chrono::seconds(3));
}

// It has answered the request, and not what followed: that was reported as no answer.
TEST_F(AMachine, WhoseStopIsReleasedIsReportedSoThoughItsStatusIsNotKnown) {
  FakeController cat(name_space_, "cat", kCat, "Active");
  std::atomic<bool> answered = false;
  cat.Serve<msg::GetStatus>("get_status", [&answered](const auto&, const auto& reply) {
    if (!answered.exchange(true)) reply({});
  });
  cat.Serve<msg::ReleaseEmergencyStop>("release_emergency_stop",
                                       [](const auto&, const auto& reply) { reply({}); });
  const Ran ran = Command({"estop", "--release", "--timeout", "10"});
  EXPECT_EQ(ran.exit, 4) << ran.out;
  EXPECT_THAT(
      ran.err,
      HasSubstr("the emergency stop is released, but the machine's status is not known: the "
                "controller of cat (pid 7) did not answer within 10 s"));
}

// A stop that another person had just engaged was released, too.
TEST_F(AMachine, IsReleasedFromTheStopsThatTheOutputHasShown) {
  FakeController cat(name_space_, "cat", kCat, "Active");
  cat.Serve<msg::GetStatus>("get_status", [](const auto&, const auto& reply) {
    msg::GetStatus::Response now;
    now.status.machine = "cat";
    now.status.emergency_stop = true;
    now.status.emergency_stop_by = "anna";
    now.status.emergency_stop_reason = "smoke";
    now.status.stop_ids = {"00000000000000a1", "00000000000000b2"};
    reply(now);
  });
  std::vector<std::string> seen;
  cat.Serve<msg::ReleaseEmergencyStop>("release_emergency_stop",
                                       [&seen](const auto& request, const auto& reply) {
                                         seen = request.seen_stops;
                                         reply({});
                                       });
  const Ran ran = Command({"estop", "--release", "--timeout", "60"});
  EXPECT_EQ(ran.exit, 0) << ran.err;
  EXPECT_THAT(ran.out, HasSubstr("releasing the emergency stop by anna: smoke and 1 more (ids "
                                 "00000000000000a1, 00000000000000b2)\n"));
  EXPECT_THAT(seen, ElementsAre("00000000000000a1", "00000000000000b2"));
}

TEST_F(AMachine, WhoseStopsAreNotKnownIsNotReleased) {
  FakeController cat(name_space_, "cat", kCat, "Active");
  std::atomic<int> released = 0;
  cat.Serve<msg::ReleaseEmergencyStop>("release_emergency_stop",
                                       [&released](const auto&, const auto& reply) {
                                         ++released;
                                         reply({});
                                       });
  const Ran ran = Command({"estop", "--release", "--timeout", "2"});
  EXPECT_EQ(ran.exit, 4) << ran.out;
  EXPECT_THAT(ran.err, HasSubstr("not released, because the engaged stops are not known: "));
  EXPECT_EQ(released, 0);
}

TEST_F(AMachine, WhoseActuatorIsRestartedIsReportedSoThoughItsStatusIsNotKnown) {
  FakeController cat(name_space_, "cat", kCat, "Active");
  cat.Serve<msg::RestartActuator>("restart_actuator",
                                  [](const auto&, const auto& reply) { reply({}); });
  const Ran ran = Command({"restart", "legs", "--timeout", "10"});
  EXPECT_EQ(ran.exit, 4) << ran.out;
  EXPECT_THAT(ran.err, HasSubstr("legs is restarted, but its status is not known: the controller "
                                 "of cat (pid 7) did not answer within 10 s"));
}

}  // namespace musher::cli::machine_choice_test
