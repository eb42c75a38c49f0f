// SocketCAN: frames as the kernel has them by a pair of sockets, and a virtual bus (vcan) in a
// network of its own where this kernel has it.

#include "musher/modules/device/can_socket.hpp"

#include <gmock/gmock.h>
#include <linux/can.h>
#include <linux/can/error.h>
#include <sched.h>
#include <sys/socket.h>

#include <cstdlib>
#include <functional>
#include <future>

#include "musher/test/support/wait.hpp"
#include "musher/transport/linux_event_loop.hpp"

namespace musher::device::can_socket_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

const CanFrame kLong{{0x834100, true}, 3, {1, 2, 3}, false};
const CanFrame kShort{{0x1F2, false}, 8, {8, 7, 6, 5, 4, 3, 2, 1}, false};

// Collects what a socket reports.
struct Receiver {
  CanBus::Events Events() {
    return {[this](const CanFrame& frame) { frames.push_back(frame); },
            [this](const std::string& why) { faults.push_back(why); }, [this] { ++recovered; },
            [this](const std::string& why) { lost.push_back(why); }};
  }
  std::vector<CanFrame> frames;
  std::vector<std::string> faults;
  int recovered = 0;
  std::vector<std::string> lost;
};

class CanFrames : public ::testing::Test {
 protected:
  CanFrames() {
    int ends[2] = {-1, -1};
    EXPECT_EQ(socketpair(AF_UNIX, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0, ends), 0);
    other_ = UniqueFd(ends[1]);
    socket_ = std::make_unique<CanSocket>(loop_, "can0", UniqueFd(ends[0]), receiver_.Events());
  }
  void Write(canid_t id, std::initializer_list<std::uint8_t> bytes) {
    can_frame raw{};
    raw.can_id = id;
    for (const std::uint8_t byte : bytes) raw.data[raw.can_dlc++] = byte;
    ASSERT_EQ(send(other_.get(), &raw, sizeof raw, 0), static_cast<ssize_t>(sizeof raw));
  }
  bool Until(const std::function<bool()>& holds) {
    return loop_.RunUntil(holds, musher::testing::In(std::chrono::seconds(120)));
  }

  transport::LinuxEventLoop loop_;
  Receiver receiver_;
  UniqueFd other_;
  std::unique_ptr<CanSocket> socket_;
};

TEST_F(CanFrames, AreReceivedWithTheirIds) {
  Write(0x834100U | CAN_EFF_FLAG, {1, 2, 3});
  Write(0x1F2, {8, 7, 6, 5, 4, 3, 2, 1});
  Write(0x1F2U | CAN_RTR_FLAG, {});
  ASSERT_TRUE(Until([this] { return receiver_.frames.size() == 3; }));
  EXPECT_EQ(receiver_.frames[0], kLong);
  EXPECT_EQ(receiver_.frames[1], kShort);
  EXPECT_TRUE(receiver_.frames[2].remote);
}

TEST_F(CanFrames, AreSentWithTheirIds) {
  ASSERT_TRUE(socket_->Send(kLong));
  can_frame raw{};
  ASSERT_EQ(recv(other_.get(), &raw, sizeof raw, 0), static_cast<ssize_t>(sizeof raw));
  EXPECT_EQ(raw.can_id, 0x834100U | CAN_EFF_FLAG);
  EXPECT_EQ(raw.can_dlc, 3);
  EXPECT_EQ(raw.data[2], 3);
}

TEST_F(CanFrames, ThatAreNoFramesOfCan20AreIgnored) {
  ASSERT_GT(send(other_.get(), "x", 1, 0), 0);
  Write(0x1F2, {8, 7, 6, 5, 4, 3, 2, 1});
  ASSERT_TRUE(Until([this] { return !receiver_.frames.empty(); }));
  EXPECT_THAT(receiver_.frames, ElementsAre(kShort));
}

TEST_F(CanFrames, OfErrorsSayWhatToLookAt) {
  Write(CAN_ERR_FLAG | CAN_ERR_BUSOFF, {0, 0, 0, 0, 0, 0, 0, 0});
  Write(CAN_ERR_FLAG | CAN_ERR_CRTL, {0, CAN_ERR_CRTL_TX_PASSIVE, 0, 0, 0, 0, 0, 0});
  Write(CAN_ERR_FLAG | CAN_ERR_CRTL, {0, CAN_ERR_CRTL_TX_WARNING, 0, 0, 0, 0, 0, 0});
  Write(CAN_ERR_FLAG | CAN_ERR_RESTARTED, {0, 0, 0, 0, 0, 0, 0, 0});
  ASSERT_TRUE(Until([this] { return receiver_.recovered == 2; }));
  EXPECT_THAT(receiver_.faults, ElementsAre(HasSubstr("can0 is off after too many errors"),
                                            HasSubstr("no other device takes its frames")));
}

TEST_F(CanFrames, ThatFindTheQueueFullAreRefused) {
  Result<> sent;
  for (int i = 0; i < 10'000 && sent; ++i) sent = socket_->Send(kShort);
  ASSERT_FALSE(sent);
  EXPECT_THAT(sent.error().message, HasSubstr("can0: its queue is full"));
}

TEST_F(CanFrames, AreRefusedWhenTheInterfaceIsGone) {
  other_ = UniqueFd();
  EXPECT_FALSE(socket_->Send(kShort));
}

TEST(CanInterface, ThatThisComputerDoesNotHaveIsNamed) {
  transport::LinuxEventLoop loop;
  Receiver receiver;
  const auto opened = CanSocket::Open(loop, "nocan7", receiver.Events());
  ASSERT_FALSE(opened);
  if (opened.error().message.find("SocketCAN") != std::string::npos) {
    GTEST_SKIP() << opened.error().message;
  }
  EXPECT_EQ(opened.error().message,
            "this computer has no network interface 'nocan7'; `ip -brief link` lists them");
}

bool Ip(const std::string& arguments) {
  return std::system(("ip " + arguments + " 2>/dev/null").c_str()) == 0;
}

// `test` runs with a bus vcan0 in a network of its own, and returns "", or why it cannot be done.
std::string WithVirtualBus(const std::function<std::string()>& test) {
  return std::async(std::launch::async,
                    [&]() -> std::string {
                      if (unshare(CLONE_NEWNET) != 0) return "a network namespace needs root";
                      if (!Ip("link add vcan0 type vcan")) return "this kernel has no vcan";
                      return test();
                    })
      .get();
}

std::string ReceivesAndSends() {
  transport::LinuxEventLoop loop;
  Receiver robot;
  Receiver board;
  const auto until = [&](const std::function<bool()>& holds) {
    return loop.RunUntil(holds, musher::testing::In(std::chrono::seconds(120)));
  };
  const auto down = CanSocket::Open(loop, "vcan0", robot.Events());
  const std::string why = down ? "" : down.error().message;
  EXPECT_THAT(why, HasSubstr("vcan0 is down; type: sudo ip link set"));
  EXPECT_TRUE(Ip("link set vcan0 up"));
  auto own = CanSocket::Open(loop, "vcan0", robot.Events());
  auto other = CanSocket::Open(loop, "vcan0", board.Events());
  if (!own || !other) {
    ADD_FAILURE() << (own ? other.error().message : own.error().message);
    return "";
  }
  EXPECT_TRUE(own.value()->Send(kLong));
  EXPECT_TRUE(until([&] { return !board.frames.empty(); }));
  EXPECT_THAT(board.frames, ElementsAre(kLong));
  EXPECT_TRUE(robot.frames.empty()) << "its own";
  own.value()->Filter({kShort.id});
  EXPECT_TRUE(other.value()->Send(kLong));
  EXPECT_TRUE(other.value()->Send(kShort));
  EXPECT_TRUE(until([&] { return !robot.frames.empty(); }));
  EXPECT_THAT(robot.frames, ElementsAre(kShort));
  EXPECT_TRUE(Ip("link set vcan0 down"));
  EXPECT_TRUE(until([&] { return !robot.lost.empty(); }));
  EXPECT_THAT(robot.lost, ElementsAre(HasSubstr("vcan0 is down")));
  EXPECT_FALSE(own.value()->Send(kLong));
  return "";
}

TEST(CanInterface, OfAVirtualBusReceivesAndSends) {
  const std::string skipped = WithVirtualBus(ReceivesAndSends);
  if (!skipped.empty()) GTEST_SKIP() << skipped;
}

}  // namespace musher::device::can_socket_test
