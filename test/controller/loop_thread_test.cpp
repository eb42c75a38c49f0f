// What is promised for the loop's thread only is checked there.

#include <gtest/gtest.h>

#include <chrono>
#include <optional>
#include <thread>

#include "musher/controller/controller.hpp"
#include "musher/lifecycle/config/config_toml.hpp"
#include "musher/test/actuator/robot_file.hpp"
#include "musher/test/support/domain.hpp"
#include "musher/transport/dds/dds_node.hpp"
#include "musher/transport/linux_event_loop.hpp"

namespace musher::loop_thread_test {

// Such a call would race with the decisions.
TEST(ControllerDeathTest, EndsTheProgramWhenAnotherThreadCallsItWhileItsLoopRuns) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const testing::RobotFile file({"arm"}, testing::kAllStates, {}, "command = [\"true\"]\n");
  const MachineConfig config = *ReadConfigFile(file.path()).config;
  EXPECT_DEATH(
      {
        transport::LinuxEventLoop loop;
        const auto node = transport::MakeDdsNode(loop, {}).value();
        ControllerOptions options;
        options.by_hand = true;
        const auto controller =
            Controller::Make(*node, transport::TestDomain(), config, options).value();
        std::thread other;
        loop.Post([&] {
          other = std::thread([&] { controller->shell().SetState(kActive, std::nullopt, {}); });
        });
        loop.RunUntil([] { return false; }, loop.Now() + std::chrono::seconds(10));
      },
      "called on another thread than the loop's");
}

}  // namespace musher::loop_thread_test
