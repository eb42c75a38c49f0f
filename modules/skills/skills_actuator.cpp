#include "musher/modules/skills/skills_actuator.hpp"

#include <algorithm>
#include <memory>
#include <utility>

#include "musher/actuator/program/await.hpp"

namespace musher::skills {
namespace {

constexpr std::int32_t kSelfCheckFailed = RobotCode(KeyCode::kSelfCheckFailed);

Result<> Verdict(const RosRobot::MissingInterfaces& missing) {
  std::string all = missing.odometry;
  for (const std::string& other : missing.others) all += (all.empty() ? "" : "; ") + other;
  if (all.empty()) return Ok();
  return Error{kSelfCheckFailed, all};
}

}  // namespace

SkillsActuator::SkillsActuator(const std::string& actuator_name, RosRobot& robot,
                               std::vector<skill::Entry> entries)
    : SkillActuator(actuator_name, {.action = robot.config().robot + "/skill_execution",
                                    .robot = robot.config().robot,
                                    .after_restart = robot.config().goes_on_after_restart
                                                         ? Options::AfterRestart::kContinued
                                                         : Options::AfterRestart::kFailed}),
      robot_(robot),
      entries_(std::move(entries)) {}

Result<> SkillsActuator::RegisterSkills(skill::Registry& registry) {
  skill::Config settings;
  for (const skill::Entry& entry : entries_) {
    if (Result<> added = registry.Add(entry.name, entry.make); !added) return added;
    settings.settings.emplace_back(entry.name, entry.settings);
  }
  return registry.Configure(settings);
}

void SkillsActuator::OpenTopics(transport::Endpoints& topics) {
  const auto log = [this](LogLevel level, const std::string& line) { Log(level, line); };
  robot_.Open(topics, machine_config().name_space, log,
              machine_config().state_dir + "/" + name() + "_flight.toml");
  const auto nav2 = std::make_shared<Nav2Goals>(
      Nav2Goals::Context{robot_, manager(), [this] { return CheckMayMove(); }, log},
      robot_.config().names, topics);
  topics.Keep(nav2);
  nav2_ = nav2;
  if (signals_ == nullptr) return;
  topics.Keep(std::shared_ptr<transport::LoopHandle>(signals_->Watch(topics.node().loop(), [this] {
    CancelSkills("its process ends");  // and OnPause()
    robot_.StandStill();
  })));
}

Result<> SkillsActuator::CheckMayMove() const {
  Result<> may = CheckMayStart();
  const std::string low = robot_.LowBattery();
  if (may && !low.empty()) may = Error{kCodeProtectedError, low};
  return may;
}

void SkillsActuator::BeforeTick(Time now) {
  robot_.BeginStep(now);
  if (const std::string low = robot_.LowBattery(); !low.empty()) EndMotions(low);
}

void SkillsActuator::EndMotions(const std::string& why) {
  for (const skill::Run* run : manager().Runs()) {
    const bool moves = std::ranges::any_of(
        run->parts(), [](const std::string& part) { return part == kBase || part == kArm; });
    if (!run->running() || !moves || run->name() == "land") continue;
    static_cast<void>(manager().FailNow(run->name(), run->name() + " has ended: " + why));
    robot_.StopMotion();  // `land` commands it again in its next step
  }
}

void SkillsActuator::AfterTick(Time /*now*/) {
  if (const auto nav2 = nav2_.lock()) nav2->Update();
}

void SkillsActuator::OnPause() {
  if (const auto nav2 = nav2_.lock()) nav2->Update();
  robot_.StandStill();
}

Result<> SkillsActuator::SelfCheck() {
  const auto here = node();
  if (!here) return Ok();  // a fault-injection test: there is no transport
  RosRobot::MissingInterfaces missing;
  static_cast<void>(program::AwaitOnLoop(
      *here, robot_.config().self_check_time,
      [&] {
        missing = robot_.Look();
        return Verdict(missing);
      },
      [this] { return StopRequested(); }));
  RunOnLoop([this] { robot_.CancelEarlierDrives(); });
  Result<> verdict = Verdict(missing);
  if (!missing.odometry.empty() || verdict) return verdict;
  ReportDegraded(verdict.error());
  return Ok();
}

}  // namespace musher::skills
