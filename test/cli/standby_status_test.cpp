// `musher status` on a host that stands by for the controller of another one. It said nothing of
// it.

#include <gmock/gmock.h>
#include <unistd.h>

#include <string>
#include <thread>

#include "musher/controller/client/standby_call.hpp"
#include "musher/messages/musher_msgs/machine_services.hpp"
#include "musher/test/cli/fake_controller.hpp"
#include "musher/test/cli/program.hpp"
#include "musher/transport/dds/dds_node.hpp"
#include "musher/transport/linux_event_loop.hpp"

namespace musher::cli::standby_status_test {

using ::testing::HasSubstr;
using ::testing::Not;

class AHostThatStandsBy : public ::testing::Test {
 protected:
  AHostThatStandsBy() : loop_thread_([this] { loop_.Run(); }) {}
  ~AHostThatStandsBy() override {
    loop_.Stop();
    loop_thread_.join();
  }
  std::string Pid() const { return std::to_string(getpid()); }

  const std::string name_space_ = "standby_status_test_" + std::to_string(getpid());
  transport::LinuxEventLoop loop_;
  const std::unique_ptr<StandbyServer> server_ =
      StandbyServer::Make(loop_, StandbyName(transport::DomainId({}).value(), name_space_), [] {
        return StandbyReport{{"dog", "id-00001"}, "only 1 of 3 has lost it", 0};
      }).value();
  std::thread loop_thread_;
};

TEST_F(AHostThatStandsBy, SaysSoWithoutAController) {
  const Ran status = RunProgram({"--namespace", name_space_, "status"});
  EXPECT_EQ(status.exit, 3);
  EXPECT_THAT(status.err, HasSubstr("; this host stands by for dog (pid " + Pid() +
                                    "): only 1 of 3 has lost it\n"));
  const Ran json = RunProgram({"--namespace", name_space_, "--json", "status"});
  EXPECT_EQ(json.exit, 3);
  EXPECT_THAT(json.out, HasSubstr(R"("standby":{"machine":"dog","machine_id":"id-00001","pid":)" +
                                  Pid() + R"(,"why_not_leading":"only 1 of 3 has lost it"}})"));
}

TEST_F(AHostThatStandsBy, SaysSoBesideTheStatusOfTheController) {
  FakeController there(name_space_, "dog", "id-00001", "Active");
  there.Serve<msg::GetStatus>("get_status", [](const auto&, const auto& reply) {
    msg::GetStatus::Response now;
    now.status.machine = "dog";
    now.status.machine_id = "id-00001";
    now.status.state = "Active";
    now.status.phase = "running";
    reply(now);
  });
  const Ran status = RunProgram({"--namespace", name_space_, "status"});
  EXPECT_EQ(status.exit, 0) << status.err;
  EXPECT_THAT(status.out, HasSubstr("dog  Active"));
  EXPECT_THAT(status.out, HasSubstr("this host stands by for dog (pid " + Pid() +
                                    "): only 1 of 3 has lost it\n"));
}

TEST_F(AHostThatStandsBy, IsNotNamedWhereAnotherMachineIsMeant) {
  const Ran status = RunProgram({"--namespace", name_space_, "--machine", "cat", "status"});
  EXPECT_EQ(status.exit, 3);
  EXPECT_THAT(status.err, Not(HasSubstr("stands by")));
}

}  // namespace musher::cli::standby_status_test
