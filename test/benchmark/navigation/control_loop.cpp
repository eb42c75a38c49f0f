// The 60 Hz loop of musher-controller: how many of its commands a subscriber misses. The real
// program drives a simulated robot to and fro over DDS, in real time by the steady clock; a gap
// between two commands of a drive that is longer than one and a half cycles counts as missed ones.
//
//   benchmark_control_loop [SECONDS]    (600)

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "musher/test/benchmark/common/process.hpp"
#include "musher/test/benchmark/common/statistics.hpp"
#include "musher/test/modules/actuator_peer.hpp"
#include "musher/test/modules/navigation/simulated_robot.hpp"
#include "musher/test/navigation/maps.hpp"
#include "musher/transport/action.hpp"

namespace musher::benchmark {
namespace {

using navigation::testing::At;

constexpr double kCycleMs = 1000.0 / 60;

class ControlLoop {
 public:
  bool Begin() {
    peer_.Start("self_check_ms = 15000\nmap = \"\"\n[[robot]]\nname = \"jetbot_0\"\n");
    if (!peer_.AwaitVisible()) return false;
    client_ =
        transport::MakeActionClient<msg::FollowPath>(peer_.node(), "jetbot_0/follow_path").value();
    commands_ = transport::MakeSubscription<msg::Twist>(
                    peer_.node(), "jetbot_0/cmd_vel",
                    [this](const msg::Twist&, const auto&) { OnCommand(); })
                    .value();
    return peer_.Switch("SelfCheck").ok() && peer_.Switch("Active").ok();
  }

  void RunFor(Duration time) {
    const Time end = Now() + time;
    const Cost before = CostOf(peer_.pid());
    const Time begin = Now();
    while (Now() < end) {
      if (!Drive()) return static_cast<void>(std::printf("a drive has not ended\n"));
      ++drives_;
    }
    const Cost after = CostOf(peer_.pid());
    cpu_share_ = ToSeconds(after.cpu - before.cpu) / ToSeconds(Now() - begin);
  }

  void Report() const {
    std::printf(
        "\nThe 60 Hz loop of musher-controller, one robot, real time\n\n| what | figure "
        "|\n|---|---|\n"
        "| drives; commands in them | %d; %zu |\n| missed cycles | %d |\n"
        "| time between two commands, median, p99, longest | %.1f, %.1f, %.1f ms |\n"
        "| CPU of the process while it drives | %.1f %% |\n",
        drives_, gaps_ms_.size(), missed_, Median(gaps_ms_), Quantile(gaps_ms_, 0.99),
        Quantile(gaps_ms_, 1), 100 * cpu_share_);
  }

 private:
  Time Now() { return peer_.node().loop().Now(); }

  void OnCommand() {
    const Time now = Now();
    if (last_) {
      const double gap_ms = 1e3 * ToSeconds(now - *last_);
      gaps_ms_.push_back(gap_ms);
      if (gap_ms > 1.5 * kCycleMs) missed_ += static_cast<int>(std::lround(gap_ms / kCycleMs)) - 1;
    }
    last_ = now;
  }

  // To the other end of the hall. Commands between two drives do not count.
  bool Drive() {
    const navigation::Pose& pose = robot_.pose();
    msg::FollowPath::Goal goal;
    goal.path.header.frame_id = "map";
    goal.path.poses = {At(pose.at.x_m, pose.at.y_m), At(pose.at.x_m < 10 ? 17 : 3, 2)};
    bool ended = false;
    transport::GoalEvents<msg::FollowPath> events;
    events.on_end = [&](const auto&) {
      ended = true;
      last_.reset();
    };
    last_.reset();
    client_->SendGoal(goal, std::chrono::seconds(10), std::move(events));
    return peer_.Until([&] { return ended; }) || peer_.Until([&] { return ended; });
  }

  navigation::Clearance walls_{navigation::testing::Drawn(
      {"####################", "#..................#", "#..................#",
       "#..................#", "####################"},
      1, 20)};
  test::ActuatorPeer peer_{
      "controller_server", {"SetUp", "TearDown", "SelfCheck", "Active"}, "musher-controller"};
  navigation::testing::SimulatedRobot robot_{
      peer_.node(), walls_, {"jetbot_0", {{3, 2, 0}, 0}, true, 0}};
  std::unique_ptr<transport::ActionClient<msg::FollowPath>> client_;
  std::unique_ptr<transport::Subscription> commands_;
  std::optional<Time> last_;
  std::vector<double> gaps_ms_;
  int missed_ = 0;
  int drives_ = 0;
  double cpu_share_ = 0;
};

}  // namespace
}  // namespace musher::benchmark

int main(int argc, char** argv) {
  const int seconds = argc > 1 ? std::atoi(argv[1]) : 600;
  musher::benchmark::ControlLoop loop;
  if (!loop.Begin()) {
    std::fputs("benchmark_control_loop: musher-controller does not become Active\n", stderr);
    return 1;
  }
  loop.RunFor(std::chrono::seconds(seconds > 0 ? seconds : 1));
  loop.Report();
  return 0;
}
