#include "musher/test/benchmark/robot/robot.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <future>
#include <utility>

#include "musher/messages/stamp.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher::benchmark {
namespace {

constexpr Duration kWaitLimit = std::chrono::seconds(120);
constexpr double kMoving_m_s = 0.02;

// Of the one robot that is up in a benchmark; empty: there is none.
std::filesystem::path folder_of_robot;

void TakeDown() {
  const std::filesystem::path folder = std::exchange(folder_of_robot, {});
  if (folder.empty()) return;
  Child({Program("musher"), "down"}, {}, Child::Output::kNowhere).Wait();
  std::error_code none;
  std::filesystem::remove_all(folder, none);
}

template <class T>
T Must(Result<T> made) {
  if (!made) Fail(made.error().message);
  return std::move(made).value();
}

std::string Describe(const Robot::Received& received) {
  std::string text = received.machine ? "the machine is in " + received.machine->state
                                      : std::string("no status of the machine");
  if (received.machine) {
    for (const auto& actuator : received.machine->actuators) {
      text += ", " + actuator.name + " in " + actuator.state;
    }
    for (const std::string& why : received.machine->degraded) text += "; degraded: " + why;
  }
  return text + (received.body ? "" : ", no state of the body") +
         (received.clock ? "" : ", no clock");
}

}  // namespace

Robot::Robot(const std::filesystem::path& configs) {
  folder_ = std::filesystem::temp_directory_path() / ("musher-robot-" + std::to_string(getpid()));
  std::filesystem::create_directories(folder_);
  std::filesystem::copy(configs, folder_ / "config", std::filesystem::copy_options::recursive);
  config_ = folder_ / "config" / "robot.toml";
  setenv("ROS_DOMAIN_ID", std::to_string(Domain()).c_str(), 1);
  setenv("XDG_STATE_HOME", (folder_ / "state").c_str(), 1);
  setenv(
      "PATH",
      (std::filesystem::path(Program("x")).parent_path().string() + ":" + getenv("PATH")).c_str(),
      1);
  node_ = Must(transport::NodeThread::Start());
  node_->RunOnLoop([this] { Listen(); });
  folder_of_robot = folder_;
  std::atexit(TakeDown);  // Fail() ends the process without destructors
  Run({"up", "--detach", config_});
  Run({"low-power", "off"});  // at a hundred times the speed half a minute is soon over
  Await("the machine and all its actuators in Active", [](const Received& received) {
    return received.machine && received.machine->state == kActive && received.body &&
           received.clock &&
           std::all_of(received.machine->actuators.begin(), received.machine->actuators.end(),
                       [](const auto& actuator) { return actuator.state == kActive; });
  });
  Await("the hand to reach the robot", [this](const Received&) {
    return servo_->MatchedReaders() > 0 && battery_->MatchedReaders() > 0 &&
           speed_->MatchedReaders() > 0;
  });
}

Robot::~Robot() {
  TakeDown();
  node_->RunOnLoop([this] {
    subscriptions_.clear();
    result_.reset();
    speed_.reset();
    battery_.reset();
    servo_.reset();
  });
  node_.reset();
}

void Robot::Listen() {
  transport::Node& node = node_->node();
  servo_ = Must(transport::MakePublisher<msg::MotionServoCmd>(node, "motion_servo_cmd"));
  battery_ = Must(transport::MakePublisher<msg::Float32>(node, "world/set_battery"));
  speed_ = Must(transport::MakePublisher<msg::Float32>(node, "world/speed"));
  result_ = Must(transport::MakeClient<msg::MotionResultCmd>(node, "motion_result_cmd"));
  const auto now = [this] { return node_->loop().Now(); };
  const auto subscribe = [&]<class M>(const std::string& topic, const transport::Qos& qos,
                                      std::function<void(Received&, const M&)> take) {
    subscriptions_.push_back(Must(transport::MakeSubscription<M>(
        node, topic,
        [this, take = std::move(take)](const M& message, const transport::SampleInfo&) {
          Change([&](Received& received) { take(received, message); });
        },
        qos)));
  };
  subscribe.operator()<msg::MachineStatus>(
      transport::MachineStatusTopic(""), transport::kLatchedQos,
      [](Received& received, const msg::MachineStatus& status) {
        if (!received.machine || received.machine->state != status.state) {
          received.states.emplace_back(status.state);
        }
        received.machine = status;
      });
  subscribe.operator()<msg::BodyState>("world/body_state", transport::kDefaultQos,
                                       [now](Received& received, const msg::BodyState& body) {
                                         received.body = body;
                                         const bool moves =
                                             std::abs(body.twist.linear.x) > kMoving_m_s;
                                         if (moves != received.moves) received.moves_since = now();
                                         received.moves = moves;
                                       });
  subscribe.operator()<msg::MotionCustomCommand>(
      "world/body_command", transport::kDefaultQos,
      [now](Received& received, const msg::MotionCustomCommand& command) {
        received.command = command;
        received.command_at = now();
      });
  subscribe.operator()<msg::Clock>("clock", transport::kHeartbeatQos,
                                   [now](Received& received, const msg::Clock& clock) {
                                     received.clock = msg::FromStamp(clock.clock);
                                     received.clock_at = now();
                                     if (received.clock_first_at == Time{}) {
                                       received.clock_first = *received.clock;
                                       received.clock_first_at = received.clock_at;
                                     }
                                   });
}

void Robot::Change(const std::function<void(Received&)>& change) {
  {
    const std::lock_guard lock(mutex_);
    change(received_);
  }
  changed_.notify_all();
}

Time Robot::Await(const std::string& what, const std::function<bool(const Received&)>& is_so) {
  std::unique_lock lock(mutex_);
  if (!changed_.wait_for(lock, kWaitLimit, [&] { return is_so(received_); })) {
    Fail("waited in vain for " + what + "; " + Describe(received_));
  }
  return std::chrono::steady_clock::now();
}

Time Robot::AwaitUntil(Time when) {
  std::promise<Time> reached;
  transport::LoopHandlePtr timer;
  node_->RunOnLoop(
      [&] { timer = node_->loop().At(when, [&] { reached.set_value(node_->loop().Now()); }); });
  const Time now = reached.get_future().get();
  node_->RunOnLoop([&] { timer.reset(); });
  return now;
}

Robot::Received Robot::Now() {
  const std::lock_guard lock(mutex_);
  return received_;
}

void Robot::Forget() {
  Change([](Received& received) {
    received.states.clear();
    received.clock_first_at = Time{};
  });
}

Time Robot::OnLoop(const std::function<Result<>()>& work) {
  const Time sent = std::chrono::steady_clock::now();
  node_->RunOnLoop([&] {
    if (const Result<> done = work(); !done) Fail(done.error().message);
  });
  return sent;
}

Time Robot::Walk(float vx) {
  msg::MotionServoCmd frame;
  frame.motion_id = msg::MotionId::kWalkUserTrot;
  frame.cmd_type = msg::MotionServoCmd::kData;
  frame.vel_des = {vx, 0, 0};
  frame.step_height = {0.05F, 0.05F};
  return OnLoop([&] { return servo_->Publish(frame); });
}

msg::MotionResultCmd::Response Robot::Do(std::int32_t motion_id) {
  msg::MotionResultCmd::Request request;
  request.motion_id = motion_id;
  std::promise<msg::MotionResultCmd::Response> answer;
  OnLoop([&]() -> Result<> {
    result_->Call(request, kWaitLimit,
                  [&](auto reply) { answer.set_value(Must(std::move(reply))); });
    return Ok();
  });
  return answer.get_future().get();
}

void Robot::SetBattery(float percent) {
  OnLoop([&] { return battery_->Publish({percent}); });
}

void Robot::SetSpeed(float factor) {
  OnLoop([&] { return speed_->Publish({factor}); });
}

void Robot::Set(const State& state) {
  Run({"set", state});
}

std::vector<pid_t> Robot::Processes() {
  const Received received = Now();
  std::vector<pid_t> pids = {received.machine->pid};
  for (const auto& actuator : received.machine->actuators) pids.push_back(actuator.pid);
  return pids;
}

void Robot::Run(const std::vector<std::string>& arguments) const {
  std::vector<std::string> argv = {Program("musher")};
  argv.insert(argv.end(), arguments.begin(), arguments.end());
  if (Child(argv, {}, Child::Output::kNowhere).Wait() != EXIT_SUCCESS) {
    Fail("`musher " + arguments.front() + "` failed");
  }
}

}  // namespace musher::benchmark
