// The sockets to a motion board on LCM while the network comes and goes. In a thread with a network
// of its own, in which nothing is up.

#include <gmock/gmock.h>
#include <sched.h>

#include <cstdlib>
#include <future>

#include "musher/modules/motion/lcm_backend.hpp"
#include "musher/test/support/wait.hpp"
#include "musher/transport/lcm_type.hpp"
#include "musher/transport/linux_event_loop.hpp"
#include "musher_lcm/robot_control_response_lcmt.hpp"

namespace musher::motion::testing::lcm_network_test {

using ::testing::HasSubstr;

bool Ip(const std::string& arguments) {
  return std::system(("ip " + arguments + " 2>/dev/null").c_str()) == 0;
}

// A network interface to the board with that address.
bool PlugIn(const std::string& address) {
  return Ip("link add dog0 type veth peer name board0") &&
         Ip("address add " + address + "/24 dev dog0") && Ip("link set board0 up") &&
         Ip("link set dog0 up multicast on");
}

class Robot {
 public:
  Robot() {
    config_.lcm.network_interface = "dog0";
    config_.lcm.ttl = 0;
    LcmBackend::Events events;
    events.on_body = [this](const BodyState&) { ++bodies_; };
    events.on_restart = [] {};
    events.on_held = [](const std::string&) {};
    events.on_fault = [this](std::int32_t, const std::string& text) { log_ += text + "\n"; };
    events.on_other_gait = [](const std::string&) {};
    backend_ = std::make_unique<LcmBackend>(loop_, *clock_, config_, std::move(events));
  }

  Result<> Reachable() const { return backend_->Reachable(); }
  bool AwaitReachable() {
    return loop_.RunUntil([&] { return backend_->Reachable().ok(); }, InTime());
  }
  // The board responds, by its present network, until one of its responses is received.
  bool AwaitBody() {
    const auto board = transport::LcmSocket::Open(
        loop_, {transport::ReadLcmUrl(config_.lcm.response_url).value(), "dog0", 0},
        [](const transport::LcmSample&) {});
    if (!board) return false;
    musher_lcm::robot_control_response_lcmt response{};
    response.mode = 7;
    const auto bytes = transport::EncodeLcm(response);
    const auto responding = loop_.Every(
        Milliseconds(20), [&] { static_cast<void>(board.value()->Send(kResponseChannel, bytes)); });
    bodies_ = 0;
    return loop_.RunUntil([&] { return bodies_ > 0; }, InTime());
  }
  const std::string& log() const { return log_; }

 private:
  static Time InTime() { return musher::testing::In(std::chrono::seconds(20)); }

  transport::LinuxEventLoop loop_;
  std::unique_ptr<transport::Clock> clock_ = transport::Clock::Steady(loop_);
  MotionConfig config_;
  int bodies_ = 0;
  std::string log_;
  std::unique_ptr<LcmBackend> backend_;
};

TEST(LcmNetwork, IsUsedOnceItComesAndWhenItComesBackWithAnotherAddress) {
  const std::string skipped = std::async(std::launch::async, []() -> std::string {
                                if (unshare(CLONE_NEWNET) != 0)
                                  return "a network namespace needs root";
                                Robot robot;
                                EXPECT_FALSE(robot.Reachable());
                                EXPECT_THAT(robot.Reachable().error().message, HasSubstr("'dog0'"));
                                if (!PlugIn("10.77.0.1"))
                                  return "this kernel has no veth, or the command ip is missing";
                                EXPECT_TRUE(robot.AwaitReachable()) << robot.log();
                                EXPECT_TRUE(robot.AwaitBody()) << "it came after the start";
                                EXPECT_TRUE(Ip("link delete dog0"));
                                EXPECT_TRUE(PlugIn("10.77.0.2"));
                                EXPECT_TRUE(robot.AwaitBody()) << "it has come back";
                                return "";
                              }).get();
  if (!skipped.empty()) GTEST_SKIP() << skipped;
}

}  // namespace musher::motion::testing::lcm_network_test
