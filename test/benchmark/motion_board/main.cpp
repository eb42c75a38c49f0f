// A motion board on LCM behind the real motion manager, all on the loopback of this computer: from
// a servo frame to its datagram, from the last frame to the stop, what the motion manager costs by
// the rate of frames, and what 30 % of lost datagrams change. The board is in this process.
//
//   benchmark_motion_board [seconds of a stream]

#include <cstdlib>
#include <future>
#include <iostream>
#include <map>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "musher/modules/motion/board_message.hpp"
#include "musher/modules/motion/motion_table.hpp"
#include "musher/test/benchmark/common/process.hpp"
#include "musher/test/benchmark/common/statistics.hpp"
#include "musher/test/modules/motion/robot_rig.hpp"
#include "musher/test/support/lcm_group.hpp"
#include "musher/transport/lcm_socket.hpp"
#include "musher/transport/lcm_type.hpp"
#include "musher_lcm/robot_control_response_lcmt.hpp"

namespace musher::benchmark {
namespace {

using motion::BodyCommand;

constexpr std::int8_t kWalk = 11;
constexpr std::int8_t kStandGait = 1;

// The board, and the source of the frames, on one loop.
class Board {
 public:
  Board(transport::NodeThread& node, const std::vector<std::string>& urls) : node_(node) {
    node_.RunOnLoop([&] {
      const auto open = [&](const std::string& url, transport::LcmSocket::OnSample on_sample) {
        return transport::LcmSocket::Open(node_.loop(),
                                          {transport::ReadLcmUrl(url).value(), "lo", 0},
                                          std::move(on_sample))
            .value();
      };
      commands_ = open(urls[0], [this](const transport::LcmSample& sample) { Take(sample); });
      responses_ = open(urls[1], [](const transport::LcmSample&) {});
      respond_ = node_.loop().Every(Milliseconds(20), [this] { Respond(); });
      servo_ = transport::MakePublisher<msg::MotionServoCmd>(node_.node(), "motion_servo_cmd",
                                                             transport::kSystemDefaultQos)
                   .value();
    });
  }
  ~Board() {
    node_.RunOnLoop([this] {
      stream_.reset();
      respond_.reset();
      servo_.reset();
      commands_.reset();
      responses_.reset();
    });
  }

  // Frames at this rate for that time; then none, and it waits for the stop.
  void Stream(Duration period, Duration time) {
    std::promise<void> stopped;
    node_.RunOnLoop([&] {
      on_stop_ = [&] { stopped.set_value(); };
      streaming_ = true;
      stream_end_ = Now() + time;
      stream_ = node_.loop().Every(period, [this] { SendFrame(); });
    });
    stopped.get_future().wait();
  }
  void Lose(double share) {
    node_.RunOnLoop([&] { loss_ = share; });
  }

  std::vector<double> frame_us;  // from a servo frame to its datagram
  std::vector<double> stop_ms;   // from the last servo frame to the datagram of the stop
  int lay_down = 0;
  int taken = 0;

 private:
  Time Now() const { return node_.loop().Now(); }
  bool Lost() { return std::uniform_real_distribution<>()(random_) < loss_; }

  void SendFrame() {
    if (!streaming_) return;
    if (Now() >= stream_end_) {
      streaming_ = false;
      return;
    }
    constexpr int kSpeeds = 2000;
    constexpr float kStep = 1e-4F;
    msg::MotionServoCmd frame;
    frame.motion_id = motion::kUserTrot;
    frame.cmd_type = msg::MotionServoCmd::kData;
    speed_ = (speed_ + 1) % kSpeeds;
    frame.vel_des = {0.2F + kStep * static_cast<float>(speed_), 0, 0};
    last_frame_ = Now();
    sent_[frame.vel_des[0]] = last_frame_;
    static_cast<void>(servo_->Publish(frame));
  }

  void Take(const transport::LcmSample& sample) {
    if (!sample.packet || sample.packet->channel != motion::kCommandChannel || Lost()) return;
    const auto decoded = motion::DecodeCommand(sample.packet->data);
    if (!decoded) return;
    const BodyCommand& frame = decoded.value();
    frame_at_ = Now();
    if (frame.mode == -1 || frame.life_count == count_) return;
    count_ = frame.life_count;
    ++taken;
    mode_ = frame.mode;
    gait_ = frame.gait;
    if (mode_ != kWalk) return;
    if (gait_ == kStandGait) {
      if (streaming_ || !on_stop_) return;
      stop_ms.push_back(ToSeconds(Now() - last_frame_) * 1000);
      std::exchange(on_stop_, nullptr)();
    } else if (const auto found = sent_.extract(frame.vel[0])) {
      frame_us.push_back(Microseconds(Now() - found.mapped()));
    }
  }

  void Respond() {
    if (frame_at_ && Now() - *frame_at_ > Milliseconds(500) && mode_ != 7) {
      mode_ = 7;
      gait_ = 1;
      ++lay_down;
    }
    musher_lcm::robot_control_response_lcmt response{};
    response.mode = mode_;
    response.gait_id = gait_;
    response.contact = 15;
    response.order_process_bar = 100;
    if (Lost()) return;
    static_cast<void>(responses_->Send(motion::kResponseChannel, transport::EncodeLcm(response)));
  }

  transport::NodeThread& node_;
  std::unique_ptr<transport::LcmSocket> commands_;
  std::unique_ptr<transport::LcmSocket> responses_;
  std::unique_ptr<transport::Publisher<msg::MotionServoCmd>> servo_;
  std::mt19937 random_{7};
  double loss_ = 0;
  std::int8_t mode_ = 12;
  std::int8_t gait_ = 0;
  std::optional<std::int8_t> count_;
  std::optional<Time> frame_at_;
  int speed_ = 0;
  std::map<float, Time> sent_;
  Time last_frame_{};
  Time stream_end_{};
  bool streaming_ = false;
  std::function<void()> on_stop_;
  transport::LoopHandlePtr respond_;
  transport::LoopHandlePtr stream_;
};

int Main(int seconds) {
  const std::vector<std::string> urls = {transport::NextTestLcmUrl(), transport::NextTestLcmUrl(),
                                         transport::NextTestLcmUrl()};
  motion::testing::RobotRig robot("kind = \"lcm\"\nttl = 0\ninterface = \"lo\"\ncommand_url = \"" +
                                  urls[0] + "\"\nresponse_url = \"" + urls[1] +
                                  "\"\nlocalization_url = \"" + urls[2] + "\"\n");
  const auto node = transport::NodeThread::Start().value();
  Board board(*node, urls);
  if (!robot.BringUp()) {
    std::cerr << "the robot does not start\n" << robot.Log();
    return 1;
  }
  const std::chrono::seconds time(seconds);
  board.Stream(Milliseconds(50), std::chrono::seconds(1));  // the discovery of DDS
  const Table table("a motion board on LCM");
  std::vector<std::string> costs;
  for (const int rate : {20, 100, 500}) {
    board.frame_us.clear();
    board.stop_ms.clear();
    const Duration before = CostOf(robot.ManagerPid()).cpu;
    const Time begin = std::chrono::steady_clock::now();
    board.Stream(Duration(std::chrono::seconds(1)) / rate, time);
    const double wall = ToSeconds(std::chrono::steady_clock::now() - begin);
    const double cpu = ToSeconds(CostOf(robot.ManagerPid()).cpu - before);
    const std::string at = " at " + std::to_string(rate) + " Hz";
    table.Row("servo frame → datagram" + at, board.frame_us, "us");
    table.Row("last frame → stop" + at, board.stop_ms, "ms");
    costs.push_back("CPU of the motion manager" + at + ": " + std::to_string(100 * cpu / wall) +
                    " % of a core");
  }
  board.frame_us.clear();
  board.stop_ms.clear();
  board.lay_down = 0;
  constexpr double kLoss = 0.3;
  board.Lose(kLoss);
  constexpr int kStops = 10;
  for (int i = 0; i < kStops; ++i)
    board.Stream(Milliseconds(50), time / kStops + Milliseconds(500));
  table.Row("servo frame → taken, 30 % lost each way", board.frame_us, "us");
  table.Row("last frame → stop, 30 % lost each way", board.stop_ms, "ms");
  board.Lose(0);
  for (const std::string& cost : costs) std::cout << cost << "\n";
  std::cout << "times that the body lay down for lack of frames, 30 % lost: " << board.lay_down
            << "\n";
  return 0;
}

}  // namespace
}  // namespace musher::benchmark

int main(int argc, char** argv) {
  constexpr int kSeconds = 20;
  return musher::benchmark::Main(argc > 1 ? std::atoi(argv[1]) : kSeconds);
}
