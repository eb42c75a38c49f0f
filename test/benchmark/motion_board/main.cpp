// A motion board on LCM behind the real motion manager, all on the loopback of this computer: from
// a servo frame to its datagram, from the last frame to the stop, what the motion manager costs by
// the rate of frames and in a flood, and what 30 % of lost datagrams change. The board is in this
// process.
//
// Two more programs answer frames of their own between those of the motion manager, to compare with
// what the computer needs at that hour. The first program passes a frame on, by DDS, the event loop
// and LCM. The second one has two threads without DDS: one receives a datagram, the other one sends
// it, by a plain queue. A time ends when the kernel has the datagram for the board.
// Where this user may, this process is before all others, so that no time is its own, and the
// motion manager is measured with `realtime_priority` as well, in turns.
//
//   benchmark_motion_board [seconds of a stream]

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sched.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
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
#include "musher/test/benchmark/common/child.hpp"
#include "musher/test/benchmark/common/process.hpp"
#include "musher/test/benchmark/common/statistics.hpp"
#include "musher/test/benchmark/common/thread_queue.hpp"
#include "musher/test/modules/motion/robot_rig.hpp"
#include "musher/test/support/lcm_group.hpp"
#include "musher/transport/lcm_socket.hpp"
#include "musher/transport/lcm_type.hpp"
#include "musher/transport/linux_event_loop.hpp"
#include "musher_lcm/robot_control_response_lcmt.hpp"

namespace musher::benchmark {
namespace {

using motion::BodyCommand;

constexpr std::int8_t kWalk = 11;
constexpr std::int8_t kStandGait = 1;
constexpr const char* kProbeTopic = "benchmark_servo_cmd";

// --- the programs to compare with ---

std::unique_ptr<transport::LcmSocket> OpenGroup(transport::EventLoop& loop, const std::string& url,
                                                transport::LcmSocket::OnSample on_sample) {
  const transport::LcmOptions options{transport::ReadLcmUrl(url).value(), "lo", 0};
  return transport::LcmSocket::Open(loop, options, std::move(on_sample)).value();
}

// Passes each frame on, until it is killed.
int RunPassing(const std::string& url) {
  const auto node = transport::NodeThread::Start().value();
  std::unique_ptr<transport::LcmSocket> out;
  std::unique_ptr<transport::Subscription> frames;
  node->RunOnLoop([&] {
    out = OpenGroup(node->loop(), url, [](const transport::LcmSample&) {});
    frames =
        transport::MakeSubscription<msg::MotionServoCmd>(
            node->node(), kProbeTopic,
            [&](const msg::MotionServoCmd& frame, const transport::SampleInfo&) {
              BodyCommand command;
              command.vel[0] = frame.vel_des[0];
              static_cast<void>(out->Send(motion::kCommandChannel, motion::EncodeCommand(command)));
            },
            transport::kSystemDefaultQos)
            .value();
  });
  std::cout << "ready" << std::endl;
  pause();
  return 0;
}

sockaddr_in AddressOf(const std::string& host, std::uint16_t port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  inet_pton(AF_INET, host.c_str(), &address.sin_addr);
  return address;
}

// What comes to the group `from` goes to the group `to` by another thread, until it is killed.
int RunPlain(const std::string& from, const std::string& to) {
  const transport::LcmUrl in = transport::ReadLcmUrl(from).value();
  const transport::LcmUrl out = transport::ReadLcmUrl(to).value();
  const UniqueFd receiver(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  const sockaddr_in own = AddressOf(in.group, in.port);
  const sockaddr_in group = AddressOf(out.group, out.port);
  const ip_mreqn membership{own.sin_addr, {htonl(INADDR_LOOPBACK)}, 0};
  const UniqueFd sender(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  const int on = 1;  // the board is in the group, too
  setsockopt(receiver.get(), SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  if (bind(receiver.get(), reinterpret_cast<const sockaddr*>(&own), sizeof own) != 0 ||
      setsockopt(receiver.get(), IPPROTO_IP, IP_ADD_MEMBERSHIP, &membership, sizeof membership) !=
          0 ||
      setsockopt(sender.get(), IPPROTO_IP, IP_MULTICAST_IF, &membership, sizeof membership) != 0) {
    Fail("the sockets of the plain program");
  }
  ThreadQueue second;
  std::cout << "ready" << std::endl;
  while (true) {
    std::array<char, 512> bytes{};
    const ssize_t size = recv(receiver.get(), bytes.data(), bytes.size(), 0);
    if (size < 0) return 1;
    second.Give([&sender, &group, bytes, size] {
      sendto(sender.get(), bytes.data(), static_cast<std::size_t>(size), 0,
             reinterpret_cast<const sockaddr*>(&group), sizeof group);
    });
  }
}

// --- the board ---

struct Urls {
  std::string command = transport::NextTestLcmUrl();
  std::string response = transport::NextTestLcmUrl();
  std::string localization = transport::NextTestLcmUrl();
  std::string passed = transport::NextTestLcmUrl();
  std::string plain = transport::NextTestLcmUrl();
  std::string to_plain = transport::NextTestLcmUrl();
};

// The times of frames of one kind, each of which is known by its speed.
class Probe {
 public:
  float Begin(Time now) {
    constexpr int kSpeeds = 2000;
    constexpr float kStep = 1e-4F;
    number_ = (number_ + 1) % kSpeeds;
    const float speed = 0.2F + kStep * static_cast<float>(number_);
    sent_[speed] = now;
    return speed;
  }
  void End(float speed, Time now) {
    if (const auto found = sent_.extract(speed))
      times_us.push_back(Microseconds(now - found.mapped()));
  }

  std::vector<double> times_us;

 private:
  int number_ = 0;
  std::map<float, Time> sent_;
};

// The board, and the source of the frames, on one loop.
class Board {
 public:
  Board(transport::NodeThread& node, const Urls& urls) : node_(node) {
    node_.RunOnLoop([&] {
      const auto open = [&](const std::string& url, transport::LcmSocket::OnSample on_sample) {
        return OpenGroup(node_.loop(), url, std::move(on_sample));
      };
      const auto ends = [this](Probe& probe) {
        return [this, &probe](const transport::LcmSample& sample) {
          if (!sample.packet) return;
          const auto frame = motion::DecodeCommand(sample.packet->data);
          if (frame) probe.End(frame.value().vel[0], Now() - sample.age);
        };
      };
      commands_ = open(urls.command, [this](const transport::LcmSample& s) { Take(s); });
      responses_ = open(urls.response, [](const transport::LcmSample&) {});
      passed_ = open(urls.passed, ends(passed));
      plain_ = open(urls.plain, ends(plain));
      to_plain_ = open(urls.to_plain, [](const transport::LcmSample&) {});
      respond_ = node_.loop().Every(Milliseconds(20), [this] { Respond(); });
      const auto publisher = [&](const char* topic) {
        return transport::MakePublisher<msg::MotionServoCmd>(node_.node(), topic,
                                                             transport::kSystemDefaultQos)
            .value();
      };
      servo_ = publisher("motion_servo_cmd");
      to_passing_ = publisher(kProbeTopic);
    });
  }
  ~Board() {
    node_.RunOnLoop([this] {
      stream_.reset();
      respond_.reset();
      servo_.reset();
      to_passing_.reset();
      for (auto* socket : {&commands_, &responses_, &passed_, &plain_, &to_plain_}) socket->reset();
    });
  }

  // Frames at this rate for that time; then none, and it waits for the stop.
  void Stream(Duration period, Duration time) {
    std::promise<void> stopped;
    node_.RunOnLoop([&] {
      on_stop_ = [&] { stopped.set_value(); };
      streaming_ = true;
      stream_end_ = Now() + time;
      turn_ = 0;
      stream_ = node_.loop().Every(period / 3, [this] { SendNext(); });
    });
    stopped.get_future().wait();
  }
  void Lose(double share) {
    node_.RunOnLoop([&] { loss_ = share; });
  }

  Probe servo;                  // from a servo frame to its datagram
  Probe passed;                 // the same, by the program that passes it on
  Probe plain;                  // from a datagram to that of the program of two threads
  std::vector<double> stop_ms;  // from the last servo frame to the datagram of the stop
  int lay_down = 0;
  int taken = 0;

 private:
  Time Now() const { return node_.loop().Now(); }
  bool Lost() { return std::uniform_real_distribution<>()(random_) < loss_; }

  // A frame of each kind, one after the other.
  void SendNext() {
    const int kind = turn_++ % 3;
    if (kind == 0) return SendFrame();
    if (!streaming_) return;
    if (kind == 1) {
      static_cast<void>(to_passing_->Publish(FrameOf(passed.Begin(Now()))));
    } else {
      BodyCommand command;
      command.vel[0] = plain.Begin(Now());
      static_cast<void>(to_plain_->Send(motion::kCommandChannel, motion::EncodeCommand(command)));
    }
  }
  static msg::MotionServoCmd FrameOf(float speed) {
    msg::MotionServoCmd frame;
    frame.motion_id = motion::kUserTrot;
    frame.cmd_type = msg::MotionServoCmd::kData;
    frame.vel_des = {speed, 0, 0};
    return frame;
  }
  void SendFrame() {
    if (!streaming_) return;
    if (Now() >= stream_end_) {
      streaming_ = false;
      return;
    }
    last_frame_ = Now();
    static_cast<void>(servo_->Publish(FrameOf(servo.Begin(last_frame_))));
  }

  void Take(const transport::LcmSample& sample) {
    if (!sample.packet || sample.packet->channel != motion::kCommandChannel || Lost()) return;
    const auto decoded = motion::DecodeCommand(sample.packet->data);
    if (!decoded) return;
    const BodyCommand& frame = decoded.value();
    frame_at_ = Now() - sample.age;
    if (frame.mode == -1 || frame.life_count == count_) return;
    count_ = frame.life_count;
    ++taken;
    mode_ = frame.mode;
    gait_ = frame.gait;
    if (mode_ != kWalk) return;
    if (gait_ == kStandGait) {
      if (streaming_ || !on_stop_) return;
      stop_ms.push_back(ToSeconds(*frame_at_ - last_frame_) * 1000);
      std::exchange(on_stop_, nullptr)();
    } else {
      servo.End(frame.vel[0], *frame_at_);
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
  std::unique_ptr<transport::LcmSocket> passed_;
  std::unique_ptr<transport::LcmSocket> plain_;
  std::unique_ptr<transport::LcmSocket> to_plain_;
  std::unique_ptr<transport::Publisher<msg::MotionServoCmd>> servo_;
  std::unique_ptr<transport::Publisher<msg::MotionServoCmd>> to_passing_;
  std::mt19937 random_{7};
  double loss_ = 0;
  std::int8_t mode_ = 12;
  std::int8_t gait_ = 0;
  std::optional<std::int8_t> count_;
  std::optional<Time> frame_at_;
  int turn_ = 0;
  Time last_frame_{};
  Time stream_end_{};
  bool streaming_ = false;
  std::function<void()> on_stop_;
  transport::LoopHandlePtr respond_;
  transport::LoopHandlePtr stream_;
};

// All threads of a process; 0: not before others. Whether this user may.
bool SetRealtime(pid_t pid, int priority) {
  const sched_param parameters{priority};
  const std::string tasks = "/proc/" + std::to_string(pid) + "/task";
  for (const auto& task : std::filesystem::directory_iterator(tasks)) {
    const pid_t thread = std::atoi(task.path().filename().c_str());
    const int policy = priority > 0 ? SCHED_FIFO : SCHED_OTHER;
    if (sched_setscheduler(thread, policy, &parameters) != 0) return false;
  }
  return true;
}

std::string RatioText(const std::vector<double>& above, const std::vector<double>& below) {
  constexpr double kMost = 0.99;
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), "p50 %.2f x, p99 %.2f x", Median(above) / Median(below),
                Quantile(above, kMost) / Quantile(below, kMost));
  return text.data();
}

// Streams of this rate, in turns without and with realtime priority, if that is permitted.
void Measure(Board& board, pid_t manager, int rate, std::chrono::seconds time, const Table& table,
             std::vector<std::string>& notes) {
  constexpr int kPriority = 40;
  constexpr int kTurns = 4;
  const std::string at = " at " + std::to_string(rate) + " Hz";
  const bool permitted = SetRealtime(manager, kPriority);
  std::vector<double> realtime_us;
  board.stop_ms.clear();
  board.passed.times_us.clear();
  board.plain.times_us.clear();
  std::vector<double> normal_us;
  Duration cpu{};
  const Time begin = std::chrono::steady_clock::now();
  const Duration before = CostOf(manager).cpu;
  for (int turn = 0; turn < (permitted ? 2 * kTurns : kTurns); ++turn) {
    const bool realtime = permitted && turn % 2 == 1;
    if (permitted) SetRealtime(manager, realtime ? kPriority : 0);
    board.servo.times_us.clear();
    board.Stream(Duration(std::chrono::seconds(1)) / rate, Duration(time) / kTurns);
    auto& all = realtime ? realtime_us : normal_us;
    all.insert(all.end(), board.servo.times_us.begin(), board.servo.times_us.end());
  }
  cpu = CostOf(manager).cpu - before;
  const double wall = ToSeconds(std::chrono::steady_clock::now() - begin);
  if (permitted) SetRealtime(manager, 0);
  table.Row("servo frame → datagram" + at, normal_us, "us");
  if (permitted) table.Row("the same, realtime_priority" + at, realtime_us, "us");
  table.Row("passed on by DDS, loop, LCM" + at, board.passed.times_us, "us");
  table.Row("two plain threads" + at, board.plain.times_us, "us");
  table.Row("last frame → stop" + at, board.stop_ms, "ms");
  notes.push_back("motion manager / passed on" + at + ": " +
                  RatioText(normal_us, board.passed.times_us));
  notes.push_back("motion manager / two plain threads" + at + ": " +
                  RatioText(normal_us, board.plain.times_us));
  notes.push_back("CPU of the motion manager" + at + ": " +
                  std::to_string(100 * ToSeconds(cpu) / wall) + " % of a core");
}

// What the motion manager uses while another host, which is another address of this one, sends
// 10,000 responses a second.
std::string CostOfFlood(const Urls& urls, pid_t manager, std::chrono::seconds time) {
  const transport::RawLcmSender other(urls.response, "127.0.0.2");
  const auto data = transport::EncodeLcm(musher_lcm::robot_control_response_lcmt{});
  transport::LinuxEventLoop loop;
  std::uint32_t number = 0;
  const auto flood = loop.Every(Milliseconds(1), [&] {
    for (int i = 0; i < 10; ++i) {
      const auto bytes =
          transport::WriteLcmPacket({number++, motion::kResponseChannel, data}).value();
      other.Send({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
    }
  });
  const Duration before = CostOf(manager).cpu;
  const Time begin = loop.Now();
  loop.RunUntil([&] { return loop.Now() >= begin + time; }, begin + time);
  const Duration cpu = CostOf(manager).cpu - before;
  return "CPU of the motion manager in a flood of " +
         std::to_string(static_cast<int>(number / ToSeconds(loop.Now() - begin))) +
         " responses a second of another host: " +
         std::to_string(100 * ToSeconds(cpu) / ToSeconds(loop.Now() - begin)) + " % of a core";
}

int Main(int seconds) {
  const Urls urls;
  motion::testing::RobotRig robot("kind = \"lcm\"\nttl = 0\ninterface = \"lo\"\ncommand_url = \"" +
                                  urls.command + "\"\nresponse_url = \"" + urls.response +
                                  "\"\nlocalization_url = \"" + urls.localization + "\"\n");
  const auto node = transport::NodeThread::Start().value();
  Board board(*node, urls);
  if (!robot.BringUp()) {
    std::cerr << "the robot does not start\n" << robot.Log();
    return 1;
  }
  const std::string self = Program("benchmark_motion_board");
  const Child passing({self, "passing", urls.passed}, {}, Child::Output::kPiped);
  const Child plain({self, "plain", urls.to_plain, urls.plain}, {}, Child::Output::kPiped);
  passing.AwaitOutput();
  plain.AwaitOutput();
  const std::chrono::seconds time(seconds);
  board.Stream(Milliseconds(50), std::chrono::seconds(1));  // the discovery of DDS
  const Table table("a motion board on LCM");
  std::vector<std::string> notes;
  constexpr int kFirst = 50;
  SetRealtime(getpid(), kFirst);
  for (const int rate : {20, 100, 500}) {
    Measure(board, robot.ManagerPid(), rate, time, table, notes);
  }
  board.servo.times_us.clear();
  board.stop_ms.clear();
  board.lay_down = 0;
  constexpr double kLoss = 0.3;
  board.Lose(kLoss);
  constexpr int kStops = 10;
  for (int i = 0; i < kStops; ++i)
    board.Stream(Milliseconds(50), time / kStops + Milliseconds(500));
  table.Row("servo frame → taken, 30 % lost each way", board.servo.times_us, "us");
  table.Row("last frame → stop, 30 % lost each way", board.stop_ms, "ms");
  board.Lose(0);
  notes.push_back("times that the body lay down for lack of frames, 30 % lost: " +
                  std::to_string(board.lay_down));
  notes.push_back(CostOfFlood(urls, robot.ManagerPid(), time));
  for (const std::string& note : notes) std::cout << note << "\n";
  return 0;
}

}  // namespace
}  // namespace musher::benchmark

int main(int argc, char** argv) {
  namespace benchmark = musher::benchmark;
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  const auto at = [&](std::size_t i) { return i < arguments.size() ? arguments[i] : ""; };
  const bool child = at(0) == "passing" || at(0) == "plain";
  if (child) setsid();  // the kernel weighs sessions: one of its own, as the motion manager has
  if (at(0) == "passing") return benchmark::RunPassing(at(1));
  if (at(0) == "plain") return benchmark::RunPlain(at(1), at(2));
  constexpr int kSeconds = 20;
  return benchmark::Main(at(0).empty() ? kSeconds : std::atoi(at(0).c_str()));
}
