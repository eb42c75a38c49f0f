// The sockets to a motion board on LCM while the network comes and goes. In a thread with networks
// of its own, in which nothing is up: one of the computer, one of the boards.

#include <fcntl.h>
#include <gmock/gmock.h>
#include <sched.h>
#include <unistd.h>

#include <cstdlib>
#include <functional>
#include <future>

#include "musher/base/unique_fd.hpp"
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

// A network of its own for this thread: interfaces and sockets that are made from then on are in
// it, and so are those that are made after Enter(), until another one is entered.
class Network {
 public:
  Network() : made_(unshare(CLONE_NEWNET) == 0) {
    file_ = UniqueFd(open("/proc/thread-self/ns/net", O_RDONLY | O_CLOEXEC));
  }
  bool Enter() const { return made_ && file_.valid() && setns(file_.get(), CLONE_NEWNET) == 0; }
  // For `ip`.
  std::string name() const {
    return "/proc/" + std::to_string(getpid()) + "/fd/" + std::to_string(file_.get());
  }

 private:
  bool made_ = false;
  UniqueFd file_;
};

// A cable from the interface `own` of this computer to `theirs` of a board.
struct Cable {
  std::string own, own_address, theirs, their_address;
};
const Cable kToBoard = {"dog0", "10.77.0.1", "board0", "10.77.0.233"};
const Cable kToOther = {"wifi0", "10.88.0.1", "other0", "10.88.0.233"};

// This computer, and what is at the other ends of its cables.
class Networks {
 public:
  bool Made() const { return boards_.Enter() && computer_.Enter(); }
  bool PlugIn(const Cable& cable) const {
    const auto& [own, own_address, theirs, their_address] = cable;
    bool done =
        Ip("link add " + own + " type veth peer name " + theirs + " netns " + boards_.name()) &&
        Ip("address add " + own_address + "/24 dev " + own) &&
        Ip("link set " + own + " up multicast on");
    done = boards_.Enter() && done && Ip("address add " + their_address + "/24 dev " + theirs) &&
           Ip("link set " + theirs + " up multicast on");
    return computer_.Enter() && done;
  }
  // Of the board at the other end.
  Result<std::unique_ptr<transport::LcmSocket>> SocketOf(const Cable& cable,
                                                         transport::EventLoop& loop,
                                                         const std::string& url) const {
    EXPECT_TRUE(boards_.Enter());
    auto opened =
        transport::LcmSocket::Open(loop, {transport::ReadLcmUrl(url).value(), cable.theirs, 1},
                                   [](const transport::LcmSample&) {});
    EXPECT_TRUE(computer_.Enter());
    return opened;
  }

 private:
  Network computer_;
  Network boards_;
};

class Robot {
 public:
  // `by` empty: the interface of the route to the board.
  Robot(const Networks& networks, const std::string& by) : networks_(networks) {
    config_.lcm.network_interface = by;
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
  // That board responds, until one of its responses is taken.
  bool AwaitBody(const Cable& cable) {
    return Await(cable, [] { return false; });
  }
  // The same until the network is lost.
  bool AwaitBodyOrLoss(const Cable& cable) {
    return Await(cable, [this] { return !Reachable(); });
  }
  const std::string& log() const { return log_; }

 private:
  bool Await(const Cable& cable, const std::function<bool()>& ended) {
    const auto board = networks_.SocketOf(cable, loop_, config_.lcm.response_url);
    if (!board) return false;
    musher_lcm::robot_control_response_lcmt response{};
    response.mode = 7;
    const auto bytes = transport::EncodeLcm(response);
    const auto responding = loop_.Every(
        Milliseconds(20), [&] { static_cast<void>(board.value()->Send(kResponseChannel, bytes)); });
    bodies_ = 0;
    const bool in_time = loop_.RunUntil([&] { return bodies_ > 0 || ended(); }, InTime());
    EXPECT_TRUE(in_time);
    return bodies_ > 0;
  }
  static Time InTime() { return musher::testing::In(std::chrono::seconds(120)); }

  const Networks& networks_;
  transport::LinuxEventLoop loop_;
  std::unique_ptr<transport::Clock> clock_ = transport::Clock::Steady(loop_);
  MotionConfig config_;
  int bodies_ = 0;
  std::string log_;
  std::unique_ptr<LcmBackend> backend_;
};

// `test` returns why it cannot be done here; "": it is done.
void WithNetworks(const std::function<std::string(const Networks&)>& test) {
  const std::string skipped = std::async(std::launch::async, [&]() -> std::string {
                                const Networks networks;
                                if (!networks.Made()) return "a network namespace needs root";
                                return test(networks);
                              }).get();
  if (!skipped.empty()) GTEST_SKIP() << skipped;
}
constexpr const char* kNoVeth = "this kernel has no veth, or the command ip is missing";

TEST(LcmNetwork, IsUsedOnceItComesAndWhenItComesBackWithAnotherAddress) {
  WithNetworks([](const Networks& networks) -> std::string {
    Robot robot(networks, "dog0");
    EXPECT_FALSE(robot.Reachable());
    EXPECT_THAT(robot.Reachable().error().message, HasSubstr("'dog0'"));
    if (!networks.PlugIn(kToBoard)) return kNoVeth;
    EXPECT_TRUE(robot.AwaitReachable()) << robot.log();
    EXPECT_TRUE(robot.AwaitBody(kToBoard)) << "it came after the start";
    EXPECT_TRUE(Ip("link delete dog0"));
    Cable another = kToBoard;
    another.own_address = "10.77.0.2";
    EXPECT_TRUE(networks.PlugIn(another));
    EXPECT_TRUE(robot.AwaitBody(another)) << "it has come back";
    return "";
  });
}

// Once the board has responded. Else a robot in the same wireless network would be taken for it.
TEST(LcmNetwork, IsNotExchangedForAnotherOneWhenTheCableToTheBoardFails) {
  WithNetworks([](const Networks& networks) -> std::string {
    if (!networks.PlugIn(kToOther)) return kNoVeth;
    EXPECT_TRUE(Ip("route add default dev wifi0"));
    Robot robot(networks, "");
    EXPECT_TRUE(robot.Reachable()) << "by the default route";
    EXPECT_TRUE(networks.PlugIn(kToBoard));
    EXPECT_TRUE(Ip("route add 239.255.76.67/32 dev dog0"));
    EXPECT_TRUE(robot.AwaitBody(kToBoard)) << "nothing has responded before";
    EXPECT_TRUE(Ip("link delete dog0"));
    EXPECT_FALSE(robot.AwaitBodyOrLoss(kToOther)) << robot.log();
    EXPECT_FALSE(robot.Reachable());
    EXPECT_TRUE(networks.PlugIn(kToBoard));
    EXPECT_TRUE(robot.AwaitBody(kToBoard)) << "its own board is found again";
    return "";
  });
}

}  // namespace musher::motion::testing::lcm_network_test
