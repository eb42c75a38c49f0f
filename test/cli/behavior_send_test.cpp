// `musher behavior --send` where the applications of two machines have one name.

#include <gmock/gmock.h>
#include <unistd.h>

#include <atomic>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "musher/lifecycle/machine/machine_identity.hpp"
#include "musher/messages/musher_msgs/actuator_status.hpp"
#include "musher/messages/musher_msgs/behavior.hpp"
#include "musher/test/cli/program.hpp"
#include "musher/test/support/domain.hpp"
#include "musher/transport/dds/node_thread.hpp"
#include "musher/transport/endpoints.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher::cli::behavior_send_test {

using ::testing::AllOf;
using ::testing::HasSubstr;

const MachineIdentity kDog{"dog", "d0900000-0000-4000-8000-000000000002"};
const MachineIdentity kCat{"cat", "cafe0000-0000-4000-8000-000000000001"};

// Longer than the application's other endpoints take.
constexpr Duration kDiscoveredLate = Milliseconds(700);

// Of a machine on another host, as the network sees it.
class FakeApplication {
 public:
  // `late`: its status is received so long after it has discovered a subscriber.
  FakeApplication(const std::string& name_space, const MachineIdentity& machine, Duration late = {})
      : thread_(transport::NodeThread::Start().value()) {
    thread_->RunOnLoop([&] {
      endpoints_ = std::make_unique<transport::Endpoints>(thread_->node(), name_space);
      endpoints_->Serve<msg::GetBehavior>("show/get_behavior",
                                          [](const auto&, const auto& reply) { reply({}); });
      endpoints_->Serve<msg::SendCommand>("show/send_command",
                                          [this](const auto&, const auto& reply) {
                                            ++commands_;
                                            msg::SendCommand::Response taken;
                                            taken.success = true;
                                            reply(taken);
                                          });
      msg::ActuatorStatus status;
      status.name = "show";
      status.state = "Active";
      status.host = "another boot/1";
      status.machine = machine.name;
      status.machine_id = machine.id;
      transport::WriterCallbacks callbacks;
      callbacks.on_match_changed = [this, late, status] {
        if (late == Duration{} || publish_late_) return;
        auto& loop = thread_->node().loop();
        publish_late_ = loop.At(loop.Now() + late, [this, status] { Publish(status); });
      };
      statuses_ = endpoints_->Advertise<msg::ActuatorStatus>(
          transport::ActuatorStatusTopic(""), transport::kLatchedQos, std::move(callbacks));
      if (late == Duration{}) Publish(status);
    });
  }
  ~FakeApplication() {
    thread_->RunOnLoop([this] {
      publish_late_.reset();
      endpoints_.reset();
    });
  }
  FakeApplication(const FakeApplication&) = delete;
  FakeApplication& operator=(const FakeApplication&) = delete;

  int commands() const { return commands_; }

 private:
  void Publish(const msg::ActuatorStatus& status) {
    EXPECT_TRUE(statuses_ != nullptr && statuses_->Publish(status).ok());
  }

  std::atomic<int> commands_ = 0;
  const std::shared_ptr<transport::NodeThread> thread_;
  std::unique_ptr<transport::Endpoints> endpoints_;
  transport::Publisher<msg::ActuatorStatus>* statuses_ = nullptr;  // of the endpoints
  transport::LoopHandlePtr publish_late_;
};

class ACommandForAnApplication : public ::testing::Test {
 protected:
  ACommandForAnApplication() {
    setenv("ROS_DOMAIN_ID", std::to_string(transport::TestDomain()).c_str(), 1);
  }
  ~ACommandForAnApplication() override { unsetenv("ROS_DOMAIN_ID"); }

  Ran Send(std::vector<std::string> options, const std::vector<std::string>& more = {}) const {
    options.insert(options.end(),
                   {"--namespace", name_space_, "behavior", "show", "--send", "START"});
    options.insert(options.end(), more.begin(), more.end());
    return RunProgram(options);
  }

  const std::string name_space_ = "behavior_send_test_" + std::to_string(getpid());
};

// Both robots began their show.
TEST_F(ACommandForAnApplication, IsNotSentWhereThatOfAnotherMachineWouldReceiveIt) {
  const FakeApplication of_dog(name_space_, kDog);
  const FakeApplication of_cat(name_space_, kCat);
  for (const std::vector<std::string>& options :
       std::vector<std::vector<std::string>>{{}, {"--machine", "dog"}}) {
    const Ran ran = Send(options);
    EXPECT_EQ(ran.exit, 2) << ran.out;
    EXPECT_THAT(ran.err, AllOf(HasSubstr("show is an actuator of several machines"),
                               HasSubstr("dog"), HasSubstr("cat"), HasSubstr("Nothing was done")));
  }
  EXPECT_EQ(of_dog.commands() + of_cat.commands(), 0);
}

TEST_F(ACommandForAnApplication, IsSentToThatOfTheMachineThatIsNamedOnly) {
  const FakeApplication of_cat(name_space_, kCat);
  const Ran other = Send({"--machine", "dog"});
  EXPECT_EQ(other.exit, 3) << other.out;
  EXPECT_THAT(other.err, HasSubstr("no actuator show of machine dog"));
  EXPECT_EQ(of_cat.commands(), 0);
  EXPECT_EQ(Send({"--machine", "cat"}).exit, 0);
  EXPECT_EQ(of_cat.commands(), 1);
}

// Both robots moved: they are discovered late with credentials, and --tree asks for nothing before
// the command is sent.
TEST_F(ACommandForAnApplication, WithATreeIsNotSentBeforeItsMachineIsDiscovered) {
  const FakeApplication of_dog(name_space_, kDog, kDiscoveredLate);
  const FakeApplication of_cat(name_space_, kCat, kDiscoveredLate);
  const Ran ran = Send({}, {"--tree"});
  EXPECT_EQ(ran.exit, 2) << ran.out;
  EXPECT_THAT(ran.err, AllOf(HasSubstr("show is an actuator of several machines"),
                             HasSubstr("Nothing was done")));
  EXPECT_EQ(of_dog.commands() + of_cat.commands(), 0);
}

TEST_F(ACommandForAnApplication, WithATreeIsSentToThatOfTheMachineThatIsNamedOnceItIsDiscovered) {
  const FakeApplication of_cat(name_space_, kCat, kDiscoveredLate);
  Send({"--machine", "cat"}, {"--tree"});  // it has no tree to show
  EXPECT_EQ(of_cat.commands(), 1);
}

}  // namespace musher::cli::behavior_send_test
