// The actuator of a robot's skills with its controller, over DDS in one process, on /clock.

#include "musher/modules/skills/skills_actuator.hpp"

#include <fstream>

#include "musher/messages/musher_msgs/heartbeats.hpp"
#include "musher/messages/nav2_msgs/navigate_to_pose.hpp"
#include "musher/messages/nav_msgs/odometry.hpp"
#include "musher/messages/plan_msgs/skill.hpp"
#include "musher/messages/sensor_msgs/battery_state.hpp"
#include "musher/modules/skills/load_skills.hpp"
#include "musher/modules/skills/robot/conversions.hpp"
#include "musher/test/application/show.hpp"
#include "musher/test/application/suspended_thread.hpp"
#include "musher/test/support/refusals.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher::skills::skills_actuator_test {

using testing::Harness;
using testing::HasRefusal;
using ::testing::HasSubstr;
using ::testing::SizeIs;

// Drives ahead until it is cancelled; leaves the velocity to the actuator.
class Go : public skill::Skill {
 public:
  explicit Go(Robot& robot) : robot_(robot) {}
  void Declare(skill::Table& table) override {
    table.Does("Drives ahead");
    table.UsesWhen(kBase, [](const skill::Values& values) { return values.Number("speed") > 0; });
    table.Takes("speed", 0.5, "m/s");
    table.Takes("names", skill::Numbers{}, "");
    table.To(table.State("GOING"), skill::kSucceeded, "never");
  }
  skill::Next Step(skill::Tick& tick) override {
    robot_.SetVelocity({tick.parameters.Number("speed"), 0, 0, 0});
    return skill::Next::Stay();
  }

 private:
  Robot& robot_;
};

Result<> RegisterTestSkills(skill::Registry& registry, Robot& robot) {
  if (Result<> added = registry.Add<Go>("go", robot); !added) return added;
  return registry.Add<Go>("run", robot);
}

// What a goal of nav2 starts. Without a skill of that name its actions are not served.
class GoTo : public Go {
 public:
  using Go::Go;
  void Declare(skill::Table& table) override {
    Go::Declare(table);
    table.Takes("goal_pos", skill::Numbers{}, "m");
    table.Takes("goal_quat_wxyz", skill::Numbers{}, "");
  }
};

Result<> RegisterGoTo(skill::Registry& registry, Robot& robot) {
  return registry.Add<GoTo>("navigate_to", robot);
}

SkillsConfig Config(const std::string& more = "") {
  return *ReadSkillsText("robot = \"r\"\nkind = \"jetbot\"\nself_check_ms = 300\n" + more +
                             "\n[topics]\nscan = \"\"\n",
                         "/tmp/r.toml")
              .config;
}

// With the name of the harness's config.
class TestSkills : public SkillsActuator {
 public:
  explicit TestSkills(RosRobot& robot, const RegisterFunction& skills = RegisterTestSkills)
      : SkillsActuator("show", robot, *LoadSkills(robot.config(), robot, skills).entries) {}
  template <class Look>
  auto Of(Look look) {
    decltype(look(*this)) found{};
    RunOnLoop([&] { found = look(*this); });
    return found;
  }
  using SkillsActuator::CheckMayStart;
  using SkillsActuator::manager;
  using SkillsActuator::Now;
};

class ASkillsActuator : public ::testing::Test {
 protected:
  using Client = transport::ActionClient<msg::SkillExecution>;

  ASkillsActuator() {
    Loop([this] {
      transport::Node& node = harness_.node().node();
      odometry_ = transport::MakePublisher<msg::Odometry>(node, "r/odom").value();
      commands_in_ =
          transport::MakeSubscription<msg::Twist>(
              node, "r/cmd_vel",
              [this](const msg::Twist& twist, const auto&) { commands_.push_back(twist); })
              .value();
      client_ = transport::MakeActionClient<msg::SkillExecution>(node, "r/skill_execution").value();
    });
  }
  ~ASkillsActuator() override {
    Loop([this] {
      again_.reset();
      odometry_.reset();
      commands_in_.reset();
      client_.reset();
      button_.reset();
      battery_again_.reset();
      battery_.reset();
    });
  }

  void Loop(const std::function<void()>& work) { harness_.node().RunOnLoop(work); }
  // Also where the actuator is degraded: there is no planner.
  bool Switch(const State& state) {
    const SwitchOutcome outcome = harness_.controller().Switch(state).outcome;
    return outcome == SwitchOutcome::kDone || outcome == SwitchOutcome::kDoneDegraded;
  }
  void BeginOdometry() {
    Loop([this] {
      again_ = harness_.node().loop().Every(Milliseconds(20),
                                            [this] { static_cast<void>(odometry_->Publish({})); });
    });
  }
  void BeginActive() { BeginActive(skills_); }
  // `node`: its own.
  void BeginActive(ActuatorRunner<TestSkills>& skills,
                   std::shared_ptr<transport::NodeThread> node = nullptr) {
    harness_.Open(skills, std::move(node));
    BeginOdometry();
    ASSERT_TRUE(Switch("SelfCheck"));
    ASSERT_TRUE(Switch("Active"));
  }
  template <class Condition>
  void Await(Condition condition) {
    ASSERT_TRUE(testing::Until([&] {
      bool met = false;
      Loop([&] { met = condition(); });
      return met;
    }));
  }
  // Runs `go`, and waits until the robot is commanded to move.
  void BeginMoving() {
    ASSERT_TRUE(skills_.Of([](TestSkills& s) { return s.manager().Start("go").ok(); }));
    harness_.Tick(skills_, 10);
    Await([this] { return !commands_.empty() && commands_.back().linear.x == 0.5; });
  }
  // The last command is 0, and none comes in a second of the clock.
  void ExpectStand() {
    Await([this] { return commands_.back() == msg::Twist{}; });
    std::size_t count = 0;
    Loop([&] { count = commands_.size(); });
    harness_.Tick(skills_, 50);
    Loop([&] { EXPECT_EQ(commands_.size(), count); });
  }
  std::string ReasonOf(const std::vector<std::string>& skills, const std::string& key = "",
                       const std::string& value = "") {
    msg::SkillExecution::Goal goal;
    for (const std::string& name : skills) {
      msg::SkillInfo skill;
      skill.skill = name;
      if (!key.empty()) skill.params.push_back({key, value});
      goal.skill_request.skill_list.push_back(skill);
    }
    auto reason = std::make_shared<std::optional<std::string>>();
    transport::GoalEvents<msg::SkillExecution> events;
    events.on_end = [reason](const auto& outcome) { *reason = outcome.result.message; };
    Loop([&] { client_->SendGoal(goal, std::chrono::seconds(20), events); });
    Await([&] { return reason->has_value(); });
    return reason->value_or("");
  }
  void PressEmergencyStop() {
    Loop([this] {
      button_ =
          transport::MakePublisher<msg::EmergencyStop>(
              harness_.node().node(), transport::EmergencyStopTopic(""), transport::kLatchedQos)
              .value();
      static_cast<void>(button_->Publish({7, true, "a test", ""}));
    });
  }

  Harness harness_;
  std::vector<msg::Twist> commands_;
  std::unique_ptr<transport::Publisher<msg::Odometry>> odometry_;
  std::unique_ptr<transport::Publisher<msg::EmergencyStop>> button_;
  std::unique_ptr<transport::Publisher<msg::BatteryState>> battery_;
  std::unique_ptr<transport::Subscription> commands_in_;
  std::unique_ptr<Client> client_;
  transport::LoopHandlePtr again_, battery_again_;
  RosRobot robot_{Config()};
  ActuatorRunner<TestSkills> skills_{robot_};
};

TEST_F(ASkillsActuator, FailsItsSelfCheckWithoutOdometry) {
  harness_.Open(skills_);
  const SwitchResult failed = harness_.controller().Switch("SelfCheck");
  ASSERT_THAT(failed.actuators, SizeIs(1));
  EXPECT_EQ(failed.actuators[0].code, 109);
  EXPECT_NE(failed.actuators[0].state, "SelfCheck");
  EXPECT_THAT(failed.actuators[0].message, HasSubstr("no odometry on r/odom"));
  BeginOdometry();
  const SwitchResult degraded = harness_.controller().Switch("SelfCheck");
  EXPECT_EQ(degraded.outcome, SwitchOutcome::kDoneDegraded) << degraded.reason;
  ASSERT_THAT(degraded.actuators, SizeIs(1));
  EXPECT_THAT(degraded.actuators[0].message, HasSubstr("no server of r/compute_path_to_pose"));
}

TEST_F(ASkillsActuator, StandsInEveryStateButActive) {
  BeginActive();
  for (const BuiltInState state : {kLowPower, kProtected, kDeActive, kOta, kError}) {
    BeginMoving();
    ASSERT_TRUE(Switch(state)) << state;
    ExpectStand();
    const bool paused = state != "OTA" && state != "Error";
    EXPECT_EQ(skills_.Of([](TestSkills& s) { return s.manager().running(); }), paused) << state;
    if (state == "Error") continue;  // it is not left for Active
    skills_.RunOnLoop([this] { skills_.manager().ResetAll(); });
    ASSERT_TRUE(Switch("Active")) << state;
  }
}

TEST_F(ASkillsActuator, StandsInActiveAfterItsStartWithoutAGoal) {
  BeginActive();
  harness_.Tick(skills_, 50);
  Loop([this] { EXPECT_THAT(commands_, ::testing::Each(msg::Twist{})); });
}

TEST_F(ASkillsActuator, StandsAtAnEmergencyStop) {
  BeginActive();
  BeginMoving();
  PressEmergencyStop();
  ExpectStand();
  EXPECT_FALSE(skills_.Of([](TestSkills& s) { return s.manager().running(); }));
}

TEST_F(ASkillsActuator, StandsWhenItsProcessEnds) {
  BeginActive();
  BeginMoving();
  skills_.Shutdown();  // as at SIGTERM
  Await([this] { return commands_.back() == msg::Twist{}; });
}

TEST_F(ASkillsActuator, RefusesAGoalWithTheReason) {
  BeginActive();
  EXPECT_EQ(ReasonOf({}), "expected one skill in skill_list, found 0");
  EXPECT_EQ(ReasonOf({"go", "run"}), "expected one skill in skill_list, found 2");
  EXPECT_EQ(ReasonOf({"og"}), "there is no skill 'og'; did you mean 'go'? There are go and run");
  EXPECT_EQ(ReasonOf({"go"}, "sped", "1"), "go: there is no parameter sped; did you mean 'speed'?");
  for (const std::string value : {"nan", "inf", "1e999", "", "fast", "{\"speed\": 1"}) {
    EXPECT_THAT(ReasonOf({"go"}, "speed", value), HasSubstr("go: parameter speed: ")) << value;
  }
  for (const std::string value : {"[1, 2", "1, 2]", "[1, nan]", "[[1]]", "{}"}) {
    EXPECT_THAT(ReasonOf({"go"}, "names", value), HasSubstr("go: parameter names: ")) << value;
  }
}

// A goal that waited in the kernel drove the robot when its computer ran again.
TEST_F(ASkillsActuator, BeginsNoGoalOfNav2ThatWaitedWhileTheComputerWasSuspended) {
  const auto thread = std::make_shared<testing::SuspendedThread>();
  RosRobot robot(Config());
  ActuatorRunner<TestSkills> skills(robot, RegisterGoTo);
  BeginActive(skills, thread);
  std::unique_ptr<transport::ActionClient<msg::NavigateToPose>> client;
  Loop([&] {
    client = transport::MakeActionClient<msg::NavigateToPose>(harness_.node().node(),
                                                              "r/navigate_to_pose")
                 .value();
  });
  std::optional<std::string> reason;
  const auto send = [&] {
    transport::GoalEvents<msg::NavigateToPose> events;
    events.on_end = [&](const auto& outcome) { reason = outcome.result.error_msg; };
    Loop([&] {
      client->SendGoal({.pose = ToMessage(navigation::Pose{{4, 3, 0}, 0}, {}), .behavior_tree = {}},
                       std::chrono::seconds(20), events);
    });
  };
  const auto runs = [&] { return skills.Of([](TestSkills& s) { return s.manager().running(); }); };
  thread->SuspendEachTime(std::chrono::seconds(9));
  send();
  Await([&] { return reason.has_value(); });
  EXPECT_THAT(reason.value_or(""), HasRefusal(ApplicationRefusal::kMayBeLate));
  EXPECT_FALSE(runs());
  thread->SuspendEachTime({});
  // The same goal, once it cannot be late any more.
  EXPECT_TRUE(testing::Until(
      [&] { return skills.Of([](TestSkills& s) { return s.CheckMayStart().ok(); }); }));
  send();
  EXPECT_TRUE(testing::Until(runs));
  Loop([&] { client.reset(); });
}

TEST_F(ASkillsActuator, EndsWhatMovesTheRobotWithALowBatteryAndNamesIt) {
  BeginActive();
  BeginMoving();
  Loop([this] {
    battery_ =
        transport::MakePublisher<msg::BatteryState>(harness_.node().node(), "r/battery").value();
    msg::BatteryState battery;
    battery.power_supply_status = msg::BatteryState::kStatusDischarging;
    battery.present = true;
    battery_again_ = harness_.node().loop().Every(
        Milliseconds(50), [this, battery] { static_cast<void>(battery_->Publish(battery)); });
  });
  const auto status_of = [this](const std::string& skill) {
    return skills_.Of([&](TestSkills& s) {
      const skill::Run* run = s.manager().Find(skill);
      return run == nullptr ? std::string() : skill::ToText(run->feedback());
    });
  };
  EXPECT_TRUE(testing::Until([&] {
    harness_.Tick(skills_, 5);
    return status_of("go").starts_with("failed");
  })) << status_of("go");
  EXPECT_EQ(status_of("go"),
            "failed: go has ended: the battery of r is at 0 %, its limit is 0 % (0%)");
  ExpectStand();
  EXPECT_TRUE(skills_.Of([](TestSkills& s) { return s.manager().Start("go").ok(); }));
  EXPECT_TRUE(skills_.Of([](TestSkills& s) {
    return s.manager().Start("run", {{"speed", 0.0}}).ok();
  }));
  harness_.Tick(skills_, 10);
  EXPECT_THAT(status_of("go"), HasSubstr("the battery of r is at 0 %"));
  EXPECT_THAT(status_of("run"), HasSubstr("processing")) << "it does not move the robot";
}

class ASkillConfig : public ::testing::Test {
 protected:
  std::vector<std::string> ErrorsOf(const std::string& text, const std::string& kind = "jetbot") {
    std::ofstream(folder_ / "skills.toml") << text;
    RosRobot robot(
        *ReadSkillsText("robot = \"r\"\nkind = \"" + kind + "\"\nskill_config = \"skills.toml\"\n",
                        folder_ / "r.toml")
             .config);
    LoadedSkills loaded = LoadSkills(robot.config(), robot, RegisterTestSkills);
    names_.clear();
    if (loaded.entries) {
      for (const auto& entry : *loaded.entries) names_.push_back(entry.name);
    }
    std::vector<std::string> lines;
    for (const auto& found : loaded.diagnostics) lines.push_back(FormatDiagnostic(found));
    return lines;
  }

  const TempFolder folder_;
  std::vector<std::string> names_;
};

TEST_F(ASkillConfig, ChoosesTheSkillsOfTheKind) {
  const std::string text =
      "[group.a]\nrobots = [\"jetbot\"]\nskills = [\"go\"]\n[group.b]\nrobots = [\"cf2x\"]\n"
      "skills = [\"run\"]\n[skill.go]\nparameters = { speed = 0.25 }\n";
  EXPECT_THAT(ErrorsOf(text), SizeIs(0));
  EXPECT_THAT(names_, ::testing::ElementsAre("go"));
}

TEST_F(ASkillConfig, ReportsItsErrorsAndAnUnknownKind) {
  const std::string text = "[group.a]\nrobots = [\"jetbot\"]\nskills = [\"og\"]\n";
  ASSERT_THAT(ErrorsOf(text), SizeIs(1));
  EXPECT_THAT(ErrorsOf(text)[0], HasSubstr("skills.toml:3:11: error: "));
  EXPECT_THAT(ErrorsOf(text)[0], HasSubstr("did you mean \"go\"?"));
  const auto unknown = ErrorsOf("[group.a]\nrobots = [\"jetbot\"]\nskills = [\"go\"]\n", "jetbt");
  ASSERT_THAT(unknown, SizeIs(1));
  EXPECT_THAT(unknown[0], HasSubstr("r.toml:2:8: error: kind: "));
  EXPECT_THAT(unknown[0], HasSubstr("jetbot"));
}

}  // namespace musher::skills::skills_actuator_test
