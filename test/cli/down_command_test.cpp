// `musher down` beside a controller that has taken its machine down, and does not exit.

#include <gmock/gmock.h>
#include <unistd.h>

#include <cstdlib>

#include "musher/base/host.hpp"
#include "musher/messages/musher_msgs/machine_services.hpp"
#include "musher/test/cli/fake_controller.hpp"
#include "musher/test/cli/program.hpp"
#include "musher/test/support/domain.hpp"

namespace musher::cli::down_command_test {

using ::testing::HasSubstr;

// It was said, and the exit code was 0: a script that started the machine again was refused.
TEST(Down, IsNotDoneWhileTheControllerHasNotExited) {
  setenv("ROS_DOMAIN_ID", std::to_string(transport::TestDomain()).c_str(), 1);
  const std::string name_space = "down_command_test_" + std::to_string(getpid());
  FakeController dog(name_space, "dog", "d0900000-0000-4000-8000-000000000002", "Active",
                     {HostId(), getpid()});
  dog.Serve<msg::SetState>("set_state", [](const auto& request, const auto& reply) {
    msg::SetState::Response done;
    done.switch_number = 1;
    done.target = request.target;
    done.outcome = "done";
    done.state = "TearDown";
    reply(done);
  });
  const Ran ran = RunProgram({"--namespace", name_space, "down"});
  unsetenv("ROS_DOMAIN_ID");
  EXPECT_EQ(ran.exit, 1) << ran.out << ran.err;
  EXPECT_THAT(ran.err, HasSubstr("the controller (pid " + std::to_string(getpid()) +
                                 ") has not exited yet"));
}

}  // namespace musher::cli::down_command_test
