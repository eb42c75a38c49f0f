// What musher-skills costs: memory, threads and CPU at rest in Active, and while it runs one skill,
// which a flyer's hover is: feedback ten times a second, velocity at 20 Hz. The real program over
// DDS; odometry comes at 50 Hz.
//
//   benchmark_skill_process [SECONDS]    (20, of each)

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>

#include "musher/messages/nav_msgs/odometry.hpp"
#include "musher/messages/plan_msgs/skill.hpp"
#include "musher/test/benchmark/common/process.hpp"
#include "musher/test/benchmark/common/statistics.hpp"
#include "musher/test/modules/actuator_peer.hpp"
#include "musher/transport/action.hpp"

namespace musher::benchmark {
namespace {

class SkillsCost {
 public:
  bool Begin() {
    odometry_ = transport::MakePublisher<msg::Odometry>(peer_.node(), "r/odom").value();
    again_ = peer_.node().loop().Every(Milliseconds(20), [this] {
      msg::Odometry odometry;
      odometry.pose.pose.position.z = 1;
      odometry.pose.pose.orientation.w = 1;
      static_cast<void>(odometry_->Publish(odometry));
    });
    client_ =
        transport::MakeActionClient<msg::SkillExecution>(peer_.node(), "r/skill_execution").value();
    peer_.Start("robot = \"r\"\nkind = \"cf2x\"\nflies = true\nself_check_ms = 500\n");
    return peer_.AwaitVisible() && peer_.Switch("SelfCheck").ok() && peer_.Switch("Active").ok();
  }

  void Measure(const char* what, Duration time) {
    const Time end = Now() + time;
    const Time begin = Now();
    const Cost before = CostOf(peer_.pid());
    while (Now() < end) {
      const Time until = std::min(end, Now() + std::chrono::seconds(1));
      static_cast<void>(peer_.Until([&] { return Now() >= until; }));
    }
    const Cost after = CostOf(peer_.pid());
    std::printf("| %s | %.1f MB | %d | %.2f %% |\n", what, after.resident_mb, after.threads,
                100 * ToSeconds(after.cpu - before.cpu) / ToSeconds(Now() - begin));
  }

  bool Hover() {
    msg::SkillInfo skill;
    skill.skill = "hover";
    skill.params = {{"altitude", "1"}, {"duration", "500"}};
    transport::GoalEvents<msg::SkillExecution> events;
    events.on_feedback = [this](const auto&) { ++reports_; };
    events.on_end = [this](const auto& outcome) { end_ = outcome.result.message; };
    client_->SendGoal({{"r", {skill}}}, std::chrono::seconds(10), std::move(events));
    return peer_.Until([this] { return reports_ > 1 || !end_.empty(); }) && end_.empty();
  }
  const std::string& end() const { return end_; }

 private:
  Time Now() { return peer_.node().loop().Now(); }

  test::ActuatorPeer peer_{"r", {"SetUp", "TearDown", "SelfCheck", "Active"}, "musher-skills"};
  std::unique_ptr<transport::Publisher<msg::Odometry>> odometry_;
  std::unique_ptr<transport::ActionClient<msg::SkillExecution>> client_;
  transport::LoopHandlePtr again_;
  int reports_ = 0;
  std::string end_;  // of the skill
};

}  // namespace
}  // namespace musher::benchmark

int main(int argc, char** argv) {
  using musher::benchmark::SkillsCost;
  const int seconds = argc > 1 ? std::atoi(argv[1]) : 20;
  const std::chrono::seconds time(seconds > 0 ? seconds : 1);
  SkillsCost skills;
  if (!skills.Begin()) {
    std::fputs("benchmark_skill_process: musher-skills does not become Active\n", stderr);
    return 1;
  }
  std::puts("\nmusher-skills, odometry at 50 Hz\n\n| | RSS | threads | CPU |\n|---|---|---|---|");
  skills.Measure("Active, at rest", time);
  if (!skills.Hover()) {
    std::fprintf(stderr, "benchmark_skill_process: the skill does not run: %s\n",
                 skills.end().c_str());
    return 1;
  }
  skills.Measure("one skill runs", time);
  return 0;
}
