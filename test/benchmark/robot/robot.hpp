#pragma once
// The robot of config/robot.toml as real processes, with a publisher and subscribers in its domain.
//
// Threads: calls from the benchmark's thread; samples arrive on the loop and are kept behind a
// mutex. Errors: what does not come in time ends the benchmark with a message.

#include <condition_variable>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "musher/lifecycle/state.hpp"
#include "musher/messages/musher_msgs/body.hpp"
#include "musher/messages/musher_msgs/machine_status.hpp"
#include "musher/messages/protocol/motion.hpp"
#include "musher/messages/rosgraph_msgs/clock.hpp"
#include "musher/messages/std_msgs/basic.hpp"
#include "musher/test/benchmark/common/child.hpp"
#include "musher/transport/dds/node_thread.hpp"
#include "musher/transport/service.hpp"

namespace musher::benchmark {

class Robot {
 public:
  // Brings the robot of that folder of configs up, to Active.
  explicit Robot(const std::filesystem::path& configs);
  // Takes it down. So does the end of the benchmark, whatever ends it.
  ~Robot();
  Robot(const Robot&) = delete;
  Robot& operator=(const Robot&) = delete;

  // The last samples, and when they were received.
  struct Received {
    std::optional<msg::MachineStatus> machine;
    std::vector<State> states;  // of the machine, each change
    std::optional<msg::BodyState> body;
    bool moves = false;  // the body, to or fro …
    Time moves_since{};  // … or stands
    msg::MotionCustomCommand command;
    Time command_at{};
    std::optional<Duration> clock;  // the world's time
    Time clock_at{};
    Duration clock_first{};
    Time clock_first_at{};
  };
  // Waits until it is so, and returns when that was received.
  Time Await(const std::string& what, const std::function<bool(const Received&)>& is_so);
  // Waits for a timer of the loop: the pace of a stream, and how long is measured. Not for anything
  // that the robot does.
  Time AwaitUntil(Time when);
  Received Now();
  // Forgets the states and the beginning of the clock.
  void Forget();

  Time Walk(float vx);  // one servo frame; gives when it was sent
  msg::MotionResultCmd::Response Do(std::int32_t motion_id);
  void SetBattery(float percent);
  void SetSpeed(float factor);
  void Set(const State& state);  // the machine

  std::vector<pid_t> Processes();

 private:
  void Run(const std::vector<std::string>& arguments) const;
  void Change(const std::function<void(Received&)>& change);
  void Listen();
  Time OnLoop(const std::function<Result<>()>& work);

  std::filesystem::path folder_;
  std::string config_;
  std::shared_ptr<transport::NodeThread> node_;
  std::mutex mutex_;
  std::condition_variable changed_;
  Received received_;
  std::unique_ptr<transport::Publisher<msg::MotionServoCmd>> servo_;
  std::unique_ptr<transport::Publisher<msg::Float32>> battery_;
  std::unique_ptr<transport::Publisher<msg::Float32>> speed_;
  std::unique_ptr<transport::Client<msg::MotionResultCmd>> result_;
  std::vector<std::unique_ptr<transport::Subscription>> subscriptions_;
};

}  // namespace musher::benchmark
