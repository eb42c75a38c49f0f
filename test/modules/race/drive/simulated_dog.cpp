#include "musher/test/modules/race/drive/simulated_dog.hpp"

#include <poll.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <stdexcept>
#include <utility>

#include "musher/modules/motion/lcm_backend.hpp"
#include "musher/modules/motion/motion_wire.hpp"
#include "musher/modules/world/process/world_board.hpp"
#include "musher/modules/world/process/world_messages.hpp"
#include "musher/test/modules/world/socket_node.hpp"
#include "musher/test/support/lcm_group.hpp"
#include "musher/test/support/paths.hpp"
#include "musher/transport/lcm_socket.hpp"
#include "musher/transport/sim/network.hpp"

namespace musher::race::testing {

using namespace motion;

namespace {

MotionTable TheTable() {
  auto reading = ReadTableFile(SourceDir() + "/config/motion/motions.toml");
  return std::move(*reading.table);
}

world::Scene OnLcm(world::Scene scene) {
  world::BoardSpec& board = scene.motion_board;
  board.lcm = true;
  board.command_url = transport::NextTestLcmUrl();
  board.response_url = transport::NextTestLcmUrl();
  board.localization_url = transport::NextTestLcmUrl();
  board.network_interface = "lo";
  return scene;
}

template <class T>
T Must(Result<T> result) {
  if (!result) throw std::runtime_error(result.error().message);
  return std::move(result).value();
}

// A datagram that has been sent is received, or on its way to the sockets of its group: this waits
// until it is there. Whatever was sent to the group before is there, too.
class Marker {
 public:
  explicit Marker(transport::EventLoop& loop, const std::string& url)
      : socket_(Must(transport::LcmSocket::Open(
            fds_.emplace(loop), {transport::ReadLcmUrl(url).value(), "lo", 0},
            [this](const transport::LcmSample& sample) {
              ++received_;
              if (sample.packet && sample.packet->channel == kChannel) has_come_ = true;
            }))) {}

  void Await() {
    has_come_ = false;
    if (!socket_->Send(kChannel, std::array<std::byte, 1>{}))
      throw std::runtime_error("a marker was not sent");
    ++sent_;
    constexpr int kMostMs = 120'000;
    while (!has_come_) {
      pollfd readable{fds_->fd, POLLIN, 0};
      if (poll(&readable, 1, kMostMs) <= 0) throw std::runtime_error("a marker has not come");
      fds_->read();
    }
  }
  // Of others, so far.
  std::size_t received() const { return received_ - sent_; }

 private:
  static constexpr const char* kChannel = "marker";

  // Keeps what the socket wants to be called for, and calls it when the test wants to.
  struct ByHand : musher::testing::WrappedLoop {
    using WrappedLoop::WrappedLoop;
    transport::LoopHandlePtr WhenReadable(int its_fd, std::function<void()> callback) override {
      fd = its_fd;
      read = std::move(callback);
      return std::make_unique<transport::LoopHandle>();
    }
    int fd = -1;
    std::function<void()> read;
  };

  std::size_t received_ = 0;
  std::size_t sent_ = 0;
  bool has_come_ = false;
  std::optional<ByHand> fds_;
  std::unique_ptr<transport::LcmSocket> socket_;
};

}  // namespace

// The motion manager's link and the world's motion board. Virtual time runs only in Step(), which
// ends when the datagrams of this step are there: a busy computer does not change the run.
class SimulatedDog::LcmWire {
 public:
  explicit LcmWire(SimulatedDog& dog)
      : board_(Must(world::WorldBoard::Open(
            world_node_.loop(), dog.world_,
            [&dog](const std::string& line) { dog.log_.push_back("board: " + line); }))) {
    LcmBackend::Events events;
    events.on_body = [&dog](const BodyState& body) {
      dog.body_ = body;
      dog.body_.motion.stamp = dog.world_.now();
      dog.Take(motion_event::BoardReported{body.report, body.age});
    };
    events.on_restart = [&dog] { dog.Take(motion_event::BoardRestarted{}); };
    events.on_held = [&dog](const std::string& why) { dog.Take(motion_event::BoardHeld{why}); };
    events.on_fault = [&dog](std::int32_t code, const std::string& text) {
      dog.Take(motion_event::BoardFault{code, text});
    };
    events.on_other_gait = [&dog](const std::string& why) {
      dog.Take(motion_event::OtherGait{why});
    };
    const world::BoardSpec& board = dog.world_.scene().motion_board;
    MotionConfig config;
    config.board = BoardKind::kLcm;
    config.lcm = {board.command_url, board.response_url, board.localization_url, "lo", 0, ""};
    backend_.emplace(robot_.loop(), *clock_, config, std::move(events));
    for (const std::string* url :
         {&board.command_url, &board.response_url, &board.localization_url}) {
      markers_.push_back(std::make_unique<Marker>(world_node_.loop(), *url));
    }
  }

  void Send(const BodyCommand& command) {
    backend_->Send(command);
    markers_.front()->Await();
  }

  // A step of the world has been done.
  void Step() {
    board_->OnStep();
    Settle();
    network_.RunFor(world::kStep);
    Settle();
  }
  std::size_t datagrams() const {
    std::size_t all = 0;
    for (const auto& marker : markers_) all += marker->received();
    return all;
  }

 private:
  void Settle() {
    for (const auto& marker : markers_) marker->Await();
  }

  transport::sim::Network network_{1};
  transport::SocketNode world_node_{network_.MakeNode("world")};
  transport::SocketNode robot_{network_.MakeNode("robot")};
  const std::unique_ptr<transport::Clock> clock_ = transport::Clock::Steady(robot_.loop());
  std::vector<std::unique_ptr<Marker>> markers_;  // first that of the commands
  const std::unique_ptr<world::WorldBoard> board_;
  std::optional<LcmBackend> backend_;
};

SimulatedDog::SimulatedDog(world::Scene scene, Wire wire)
    : table_(TheTable()), world_(wire == Wire::kLcm ? OnLcm(std::move(scene)) : std::move(scene)) {
  if (wire == Wire::kLcm) {
    wire_ = std::make_unique<LcmWire>(*this);
  } else {
    Report();
  }
  Take(motion_event::Opened{});
}

SimulatedDog::~SimulatedDog() = default;

void SimulatedDog::Servo(const msg::MotionServoCmd& frame) {
  Take(motion_event::ServoArrived{FromWire(frame)});
}

void SimulatedDog::Play(std::int32_t motion_id, OnDone on_done) {
  const RequestToken token = ++last_token_;
  waiting_[token] = std::move(on_done);
  Take(motion_event::PlayArrived{token, kFromAlgorithm, {MotionRequest{motion_id, {}}}});
}

void SimulatedDog::Step() {
  world_.Step();
  if (wire_) {
    wire_->Step();
  } else {
    Report();
  }
  Take(motion_event::TimePassed{});
}

void SimulatedDog::Report() {
  const world::Body& body = world_.body();
  BodyReport report;
  report.mode = static_cast<std::int8_t>(body.mode());
  report.gait = static_cast<std::int8_t>(body.gait());
  report.bar = static_cast<std::int8_t>(body.progress_percent());
  report.switch_status = static_cast<std::int8_t>(body.status());
  report.life_count = body.life_count();
  Take(motion_event::BoardReported{report});
}

void SimulatedDog::Take(const MotionEvent& event) {
  for (const MotionAction& action : motion::Step(Rules(), core_, event, now())) {
    if (const auto* send = std::get_if<motion_action::Send>(&action)) {
      if (wire_) {
        wire_->Send(send->command);
      } else if (const auto command = world::FromMessage(ToWire(send->command))) {
        static_cast<void>(world_.Command(command.value()));
      }
    } else if (const auto* answer = std::get_if<motion_action::Answer>(&action)) {
      const auto caller = waiting_.extract(answer->token);
      if (!caller.empty()) caller.mapped()(answer->code);
    } else if (const auto* reply = std::get_if<motion_action::ServoResponse>(&action)) {
      if (on_servo_reply) on_servo_reply(ToWire(*reply));
    } else if (const auto* line = std::get_if<motion_action::Log>(&action)) {
      log_.push_back(line->text);
    }
  }
}

std::int32_t SimulatedDog::present_motion() const {
  return PresentMotion(Rules(), core_);
}

int SimulatedDog::body_status() const {
  return wire_ ? body_.report.switch_status : static_cast<int>(world_.body().status());
}

msg::Odometry SimulatedDog::odometry() const {
  if (wire_) return OdometryOf({}, body_.motion, 0);
  BodyMotion motion;
  motion.stamp = world_.now();
  const world::Pose2& at = world_.body().odometry();
  motion.X_OB.translation() << at.position_m, 0;
  motion.X_OB.linear() = Eigen::AngleAxisd(at.yaw_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  motion.v_B = {world_.body().speed().x(), world_.body().speed().y(), 0};
  motion.w_B = world_.body().turn_rate();
  return OdometryOf({}, motion, 0);
}

std::size_t SimulatedDog::datagrams() const {
  return wire_ ? wire_->datagrams() : 0;
}

}  // namespace musher::race::testing
