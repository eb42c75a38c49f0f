// The robot of config/robot.toml with real processes: how soon the body executes a command, how
// soon it stops when commands cease, how fast its world can run, what the robot costs at rest, and
// which states a falling battery leads through.
//
//   benchmark_robot [ROUNDS [IDLE SECONDS [--smoke]]]

#include <cstdlib>
#include <iostream>
#include <string>

#include "musher/test/benchmark/common/process.hpp"
#include "musher/test/benchmark/common/statistics.hpp"
#include "musher/test/benchmark/robot/robot.hpp"
#include "musher/test/support/paths.hpp"

namespace musher::benchmark {
namespace {

constexpr Duration kFrame = Milliseconds(50);  // of a servo stream, 20 Hz
constexpr int kFrames = 6;                     // of one round

double Milli(Duration duration) {
  return Microseconds(duration) / 1000;
}

// The stream of a walker that crashes, again and again.
void Streams(Robot& robot, int rounds, const Table& table) {
  if (robot.Do(msg::MotionId::kRecoveryStand).code != kCodeOk) Fail("the robot does not stand up");
  std::vector<double> to_board;
  std::vector<double> to_body;
  std::vector<double> stop_sent;
  std::vector<double> stopped;
  for (int round = 0; round < rounds; ++round) {
    Time begun{};
    Time last{};
    for (int frame = 0; frame < kFrames; ++frame) {
      // Each frame is known by its speed. To and fro, for the yard has an end.
      const float speed = 0.2F + 0.001F * static_cast<float>((round * kFrames + frame) % 300);
      const float vx = round % 2 == 0 ? speed : -speed;
      last = robot.Walk(vx);
      if (frame == 0) begun = last;
      const Time received_at =
          robot.Await("the frame at the board", [&](const Robot::Received& received) {
            return !received.command.vel_des.empty() && received.command.vel_des[0] == vx;
          });
      to_board.push_back(Milli(received_at - last));
      if (frame + 1 < kFrames) robot.AwaitUntil(last + kFrame);
    }
    const Time received_at =
        robot.Await("the board to be stopped", [](const Robot::Received& received) {
          return received.command.vel_des.empty() || received.command.vel_des[0] == 0;
        });
    stop_sent.push_back(Milli(received_at - last));
    const Robot::Received walking = robot.Now();
    if (!walking.moves) Fail("the body does not move");
    to_body.push_back(Milli(walking.moves_since - begun));
    robot.Await("the body to stand",
                [](const Robot::Received& received) { return !received.moves; });
    stopped.push_back(Milli(robot.Now().moves_since - last));
  }
  table.Row("a servo frame → the board has it", to_board, "ms");
  table.Row("the first servo frame → the body moves", to_body, "ms");
  table.Row("the last servo frame → the board receives a stop", stop_sent, "ms");
  table.Row("the last servo frame → the body stands", stopped, "ms");
}

// At rest, for a while: what all its processes took together.
void Idle(Robot& robot, const State& state, int seconds, const Table& table) {
  const auto sum = [&] {
    Cost all;
    for (const pid_t pid : robot.Processes()) {
      const Cost cost = CostOf(pid);
      all.cpu += cost.cpu;
      all.proportional_mb += cost.proportional_mb;
      all.threads += cost.threads;
    }
    return all;
  };
  const auto each = [&] {
    std::vector<Cost> costs;
    const Robot::Received received = robot.Now();
    for (const auto& actuator : received.machine->actuators) {
      costs.push_back(CostOf(actuator.pid));
    }
    return costs;
  };
  const Cost before = sum();
  const std::vector<Cost> each_before = each();
  const Time begun = std::chrono::steady_clock::now();
  const Time ended = robot.AwaitUntil(begun + std::chrono::seconds(seconds));
  const Cost after = sum();
  table.Row("the whole robot in " + state + ": CPU",
            {100 * ToSeconds(after.cpu - before.cpu) / ToSeconds(ended - begun)}, "% of a core");
  table.Row("the whole robot in " + state + ": memory (PSS)", {after.proportional_mb}, "MB");
  const std::vector<Cost> each_after = each();
  const Robot::Received received = robot.Now();
  for (std::size_t i = 0; i < each_after.size(); ++i) {
    const std::string& name = received.machine->actuators[i].name;
    table.Row("  " + name + ": CPU",
              {100 * ToSeconds(each_after[i].cpu - each_before[i].cpu) / ToSeconds(ended - begun)},
              "% of a core");
    table.Row("  " + name + ": RSS", {each_after[i].resident_mb}, "MB");
  }
}

void Speeds(Robot& robot, bool smoke, const Table& table) {
  for (const int factor : {1, 5, 20, 100}) {
    robot.SetSpeed(static_cast<float>(factor));
    robot.AwaitUntil(std::chrono::steady_clock::now() + Milliseconds(smoke ? 50 : 500));
    robot.Forget();
    const Duration measured = Milliseconds(smoke ? 100 : 4000);
    robot.Await("the world's clock to go on", [&](const Robot::Received& received) {
      return received.clock_first_at != Time{} &&
             received.clock_at - received.clock_first_at >= measured;
    });
    const Robot::Received received = robot.Now();
    table.Row("requested world speed: " + std::to_string(factor) + "; reached",
              {ToSeconds(*received.clock - received.clock_first) /
               ToSeconds(received.clock_at - received.clock_first_at)},
              "×");
  }
  robot.SetSpeed(10);
}

// From 100 % to 1 %, and what the machine was in meanwhile.
void Fall(Robot& robot, int step) {
  robot.SetBattery(100);
  robot.Await("Active with a full battery",
              [](const Robot::Received& received) { return received.machine->state == kActive; });
  robot.Forget();
  for (int percent = 100; percent > 0; percent -= step) {
    robot.SetBattery(static_cast<float>(percent));
    // The device manager looks once in a world second, and twice at a jump.
    const Duration begun = *robot.Now().clock;
    robot.Await("the world to go on", [&](const Robot::Received& received) {
      return *received.clock - begun > Milliseconds(step > 1 ? 3000 : 1100);
    });
  }
  robot.SetBattery(1);
  robot.Await("LowPower with an empty battery", [](const Robot::Received& received) {
    return received.machine->state == kLowPower && received.machine->target.empty();
  });
  std::cout << "\nA battery that falls from 100 to 1 % in steps of " << step << " %: ";
  const std::vector<State> states = robot.Now().states;
  for (const State& state : states) std::cout << state << " ";
  std::cout << std::endl;
}

int Main(int rounds, int idle_s, bool smoke) {
  Robot robot(SourceDir() + "/config");
  const Table table("The robot");
  Streams(robot, rounds, table);
  Idle(robot, "Active, standing", idle_s, table);
  robot.Set(State(kLowPower));
  Idle(robot, "LowPower, lying", idle_s, table);
  robot.Set(State(kActive));
  Speeds(robot, smoke, table);
  Fall(robot, 30);
  if (!smoke) Fall(robot, 1);
  return EXIT_SUCCESS;
}

}  // namespace
}  // namespace musher::benchmark

int main(int argc, char** argv) {
  const int rounds = argc > 1 ? std::atoi(argv[1]) : 200;
  const int idle_s = argc > 2 ? std::atoi(argv[2]) : 20;
  return musher::benchmark::Main(rounds, idle_s, argc > 3);
}
