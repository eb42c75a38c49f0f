// The world on a network: its topics, services and its clock, in virtual time.

#include "musher/modules/world/process/world_host.hpp"

#include <gmock/gmock.h>

#include <filesystem>
#include <optional>

#include "musher/messages/geometry_msgs/geometry.hpp"
#include "musher/messages/musher_msgs/machine_status.hpp"
#include "musher/messages/protocol/motion.hpp"
#include "musher/messages/stamp.hpp"
#include "musher/messages/std_msgs/string.hpp"
#include "musher/messages/std_srvs/set_bool.hpp"
#include "musher/messages/std_srvs/trigger.hpp"
#include "musher/test/modules/world/scenes.hpp"
#include "musher/test/modules/world/world_on_network.hpp"
#include "musher/test/support/temp_folder.hpp"
#include "musher/transport/clock.hpp"

namespace musher::world::host_test {

using std::chrono::seconds;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class WorldHostTest : public WorldOnNetwork {
 protected:
  WorldHostTest() : WorldOnNetwork("dog1") {}

  void Open(const Scene& scene) {
    HostOptions options;
    options.picture_path = folder_ / "world.png";
    options.in_background = [](const std::function<void()>& work) { work(); };
    StartWorld(scene, &shooter_, std::move(options));
    clock_ = Listen<msg::Clock>("clock", clocks_, transport::kClockQos);
    bodies_ = Listen<msg::BodyState>("dog1/world/body_state", states_);
    batteries_ = Listen<msg::BatteryState>("dog1/world/battery", charges_);
    touching_ = Listen<msg::Int32>("dog1/world/touch", touches_);
    network_.RunFor(Milliseconds(50));
    Forget();
  }
  void Forget() {
    clocks_.clear();
    states_.clear();
    charges_.clear();
  }

  template <class M>
  void Say(const std::string& topic, const M& message) {
    auto publisher = transport::MakePublisher<M>(*desk_, "dog1/" + topic).value();
    network_.RunFor(Milliseconds(50));
    ASSERT_EQ(publisher->MatchedReaders(), 1) << topic;
    ASSERT_TRUE(publisher->Publish(message));
    network_.RunFor(Milliseconds(50));
  }

  template <class S>
  std::optional<typename S::Response> CallService(const std::string& service,
                                                  const typename S::Request& request = {}) {
    auto client = transport::MakeClient<S>(*desk_, "dog1/" + service).value();
    std::optional<typename S::Response> response;
    network_.RunFor(Milliseconds(50));
    client->Call(request, seconds(1), [&](const Result<typename S::Response>& answer) {
      if (answer) response = answer.value();
    });
    network_.RunFor(seconds(1));
    return response;
  }

  static msg::MotionCustomCommand Command(std::int8_t mode, std::int8_t gait,
                                          std::vector<float> speed = {}) {
    msg::MotionCustomCommand command;
    command.mode = mode;
    command.gait_id = gait;
    command.life_count = 1;
    command.vel_des = std::move(speed);
    command.duration = 3000;
    return command;
  }

  const TempFolder folder_;
  std::vector<msg::Clock> clocks_;
  std::vector<msg::BodyState> states_;
  std::vector<msg::BatteryState> charges_;
  std::vector<msg::Int32> touches_;
  std::unique_ptr<transport::Subscription> clock_, bodies_, batteries_, touching_;
};

TEST_F(WorldHostTest, PublishesAClockAndABodyEachStepAndABatteryEachSecond) {
  Open(EmptyYard());
  network_.RunFor(seconds(10));
  EXPECT_EQ(clocks_.size(), 500u);
  EXPECT_EQ(states_.size(), 500u);
  EXPECT_EQ(charges_.size(), 10u);
  EXPECT_EQ(FromStamp(clocks_[1].clock) - FromStamp(clocks_[0].clock), Milliseconds(20));
  EXPECT_EQ(states_.back().header.stamp, clocks_.back().clock);
}

TEST_F(WorldHostTest, RunsItsTimeAtTheFactorOfTheScene) {
  Scene scene = EmptyYard();
  scene.speed = 5;
  Open(scene);
  const auto clock = transport::Clock::FromTopic(*desk_).value();
  network_.RunFor(seconds(1));
  const Time begin = clock->Now();
  network_.RunFor(seconds(10));
  EXPECT_NEAR(static_cast<double>(ToMilliseconds(clock->Now() - begin)), 50'000, 40);
  EXPECT_NEAR(host_->pacer().reached(), 5, 0.01);
}

TEST_F(WorldHostTest, LosesTimeWhenItsProcessIsSuspendedAndDoesNotCatchUp) {
  Open(EmptyYard());
  network_.RunFor(seconds(1));
  network_.Pause(*world_node_);
  network_.RunFor(seconds(10));
  Forget();
  network_.Resume(*world_node_);
  network_.RunFor(seconds(1));
  EXPECT_LE(clocks_.size(), 53u);
  EXPECT_GE(clocks_.size(), 50u);
}

TEST_F(WorldHostTest, StepsTogetherWithTheProcessesThatUseItsClockInLockstep) {
  Scene scene = EmptyYard();
  scene.speed = 100;
  scene.lockstep = true;
  Open(scene);
  const auto follower = network_.MakeNode("follower");
  const auto clock = transport::Clock::FromTopic(*follower).value();
  network_.RunFor(seconds(1));
  Duration most_behind{};
  const auto timer = clock->Every(Milliseconds(20), [&] {
    most_behind = std::max(most_behind, host_->world().now() - clock->Now().time_since_epoch());
  });
  const Duration before = host_->world().now();
  network_.RunFor(seconds(1));
  EXPECT_GT(host_->world().now() - before, seconds(5)) << "it runs";
  EXPECT_EQ(most_behind, Duration::zero()) << "no step while the last one is being handled";
  network_.Pause(*follower);
  network_.RunFor(Milliseconds(50));
  const Duration paused_at = host_->world().now();
  network_.RunFor(Milliseconds(500));
  EXPECT_EQ(host_->world().now(), paused_at) << "time waits for it";
  network_.RunFor(seconds(2));
  EXPECT_GT(host_->world().now(), paused_at) << "but not for ever";
  EXPECT_THAT(log_, Contains(HasSubstr("time no longer waits for 1 of the processes")));
  network_.Resume(*follower);
  network_.RunFor(seconds(1));
  network_.Pause(*follower);
  network_.RunFor(Milliseconds(50));
  const Duration again_at = host_->world().now();
  network_.RunFor(Milliseconds(500));
  EXPECT_EQ(host_->world().now(), again_at) << "it is waited for again";
}

TEST_F(WorldHostTest, WaitsForNoProcessWithoutLockstep) {
  Open(EmptyYard());
  const auto follower = network_.MakeNode("follower");
  const auto clock = transport::Clock::FromTopic(*follower).value();
  network_.RunFor(seconds(1));
  network_.Pause(*follower);
  Forget();
  network_.RunFor(seconds(1));
  EXPECT_EQ(clocks_.size(), 50u);
}

TEST_F(WorldHostTest, ChangesItsSpeedAndStandsStillOnRequest) {
  Open(EmptyYard());
  Say("world/speed", msg::Float32{10});
  Forget();
  network_.RunFor(seconds(1));
  EXPECT_NEAR(static_cast<double>(clocks_.size()), 500, 2);
  EXPECT_TRUE(CallService<msg::SetBool>("world/pause", {true}).value().success);
  Forget();
  network_.RunFor(seconds(5));
  EXPECT_THAT(clocks_, IsEmpty());
  EXPECT_TRUE(CallService<msg::SetBool>("world/pause", {false}).value().success);
  Forget();
  network_.RunFor(seconds(1));
  EXPECT_NEAR(static_cast<double>(clocks_.size()), 500, 2);
}

TEST_F(WorldHostTest, MovesTheBodyAsItIsCommandedAndReportsIt) {
  Open(EmptyYard());
  Say("world/body_command", Command(11, 27, {0.5F, 0, 0}));
  network_.RunFor(seconds(2));
  const msg::BodyState& state = states_.back();
  EXPECT_EQ(state.mode, 11);
  EXPECT_EQ(state.gait_id, 27);
  EXPECT_EQ(state.life_count, 1);
  EXPECT_EQ(state.switch_status, 0);
  EXPECT_NEAR(state.order_process_bar, 68, 3);
  EXPECT_NEAR(state.twist.linear.x, 0.5, 0.001);
  EXPECT_NEAR(state.pose.position.x, 0.925, 0.05);
  EXPECT_NEAR(state.pose.position.z, 0.29, 1e-6);
  EXPECT_NEAR(state.pose.orientation.w, 1, 1e-6);
  EXPECT_EQ(state.contact, 15);
  EXPECT_GT(state.motor_temperature[2], 20);
}

TEST_F(WorldHostTest, MovesNothingForANanCommandAndLogsIt) {
  Open(EmptyYard());
  const float none = std::nanf("");
  Say("world/body_command", Command(11, 27, {none, 0, 0}));
  Say("world/body_command", Command(11, 27, {0.5F, 0}));
  auto command = Command(21, 0);
  command.rpy_des = {0, 1.0F / 0.0F, 0};
  Say("world/body_command", command);
  command = Command(21, 0);
  command.duration = -5;
  Say("world/body_command", command);
  EXPECT_THAT(log_,
              ElementsAre(HasSubstr("vel_des is not a number"), HasSubstr("vel_des has 2 values"),
                          HasSubstr("rpy_des is not a number"), HasSubstr("negative")));
  EXPECT_EQ(states_.back().mode, 12);
  EXPECT_EQ(states_.back().pose.position.x, 0);
}

TEST_F(WorldHostTest, SetsTheBatteryAndRefusesImpossibleLevels) {
  Open(EmptyYard());
  Say("world/set_battery", msg::Float32{15});
  network_.RunFor(seconds(1));
  EXPECT_NEAR(charges_.back().percentage, 0.15, 0.001);
  Say("world/set_battery", msg::Float32{101});
  Say("world/set_battery", msg::Float32{std::nanf("")});
  network_.RunFor(seconds(1));
  EXPECT_NEAR(charges_.back().percentage, 0.15, 0.001);
  EXPECT_THAT(log_, ElementsAre(HasSubstr("0 to 100"), HasSubstr("0 to 100")));
}

TEST_F(WorldHostTest, ChargesWhileTheCableIsIn) {
  Open(EmptyYard());
  EXPECT_TRUE(CallService<msg::SetBool>("world/charge", {true}).value().success);
  network_.RunFor(seconds(1));
  EXPECT_EQ(charges_.back().power_supply_status, msg::BatteryState::kStatusCharging);
  EXPECT_EQ(charges_.back().location, "cable");
  EXPECT_GT(charges_.back().current, 0);
  Say("world/set_battery", msg::Float32{100});
  network_.RunFor(seconds(1));
  EXPECT_EQ(charges_.back().power_supply_status, msg::BatteryState::kStatusFull);
  EXPECT_TRUE(CallService<msg::SetBool>("world/charge", {false}).value().success);
  network_.RunFor(seconds(1));
  EXPECT_EQ(charges_.back().power_supply_status, msg::BatteryState::kStatusDischarging);
  EXPECT_LT(charges_.back().current, 0);
}

TEST_F(WorldHostTest, PublishesATouchAndRefusesAnUnknownOne) {
  Scene scene = EmptyYard();
  scene.events = {{seconds(1), Touch{7}}};
  Open(scene);
  network_.RunFor(seconds(1));
  Say("world/press", msg::Int32{3});
  Say("world/press", msg::Int32{18});
  Say("world/press", msg::Int32{0});
  EXPECT_THAT(touches_, ElementsAre(msg::Int32{7}, msg::Int32{3}));
  EXPECT_EQ(log_.size(), 2u);
}

TEST_F(WorldHostTest, PlacesTheBodyWhereItCanBe) {
  Open(FullYard());
  msg::PoseStamped place;
  place.pose.position = {-5, 4, 0};
  place.pose.orientation = {0, 0, M_SQRT1_2, M_SQRT1_2};
  Say("world/place", place);
  const World world = host_->world();
  EXPECT_NEAR(world.body().pose().position_m.x(), -5, 1e-9);
  EXPECT_NEAR(world.body().pose().yaw_rad, M_PI / 2, 1e-9);
  EXPECT_EQ(states_.back().pose.position.x, 0);  // odometry was carried
  place.pose.position = {2, -2, 0};              // the tree
  Say("world/place", place);
  EXPECT_NEAR(host_->world().body().pose().position_m.x(), -5, 1e-9);
  EXPECT_THAT(log_, ElementsAre(HasSubstr("cannot be at")));
}

TEST_F(WorldHostTest, TakesMotorPowerAndFaultsFromItsTopics) {
  Open(EmptyYard());
  Say("world/fault", msg::String{"motor 3"});
  EXPECT_EQ(states_.back().switch_status, 13);
  EXPECT_NE(states_.back().motor_error[3], 0);
  Say("world/fault", msg::String{"none"});
  EXPECT_EQ(states_.back().switch_status, 0);
  for (const char* wrong :
       {"", "motor 12", "motor -1", "lifted 3", "motor 3 4", "lfted", "none "}) {
    Say("world/fault", msg::String{wrong});
    EXPECT_EQ(states_.back().switch_status, 0) << wrong;
    EXPECT_THAT(log_.back(), HasSubstr("is refused")) << wrong;
  }
  auto power =
      transport::MakePublisher<msg::Bool>(*desk_, "dog1/world/motor_power", transport::kLatchedQos)
          .value();
  ASSERT_TRUE(power->Publish({false}));
  network_.RunFor(Milliseconds(100));
  EXPECT_EQ(states_.back().mode, 0);
  EXPECT_EQ(states_.back().switch_status, 3);
}

TEST_F(WorldHostTest, DrawsMachineStateAndLightsAndRepliesWithThePath) {
  Open(EmptyYard());
  auto machine = transport::MakePublisher<msg::MachineStatus>(*desk_, "dog1/musher/machine_status",
                                                              transport::kLatchedQos)
                     .value();
  auto light =
      transport::MakePublisher<msg::LedState>(*desk_, "dog1/world/led", transport::kLatchedQos)
          .value();
  msg::MachineStatus status;
  status.state = "Protected";
  ASSERT_TRUE(machine->Publish(status));
  ASSERT_TRUE(light->Publish({1, 1, 0xA1, 0, 0, 0, "bms"}));
  network_.RunFor(seconds(2));
  const auto drawn = CallService<msg::Trigger>("world/draw");
  ASSERT_TRUE(drawn);
  EXPECT_TRUE(drawn->success);
  EXPECT_EQ(drawn->message, folder_ / "world.png");
  EXPECT_TRUE(std::filesystem::exists(drawn->message));
  const World world = host_->world();
  EXPECT_THAT(world.track().states(), ::testing::Contains("Protected"));
  EXPECT_EQ(world.track().lights().at(1).red, 255);
}

TEST_F(WorldHostTest, RepliesWhyItCannotDraw) {
  Open(EmptyYard());
  std::filesystem::create_directory(folder_ / "world.png");
  const auto drawn = CallService<msg::Trigger>("world/draw");
  ASSERT_TRUE(drawn);
  EXPECT_FALSE(drawn->success);
  EXPECT_THAT(drawn->message, HasSubstr("can't save"));
}

TEST_F(WorldHostTest, ShowsAndHidesABallByItsName) {
  Scene scene = EmptyYard();
  Ball lamp{{3, 0, 0.2}};
  lamp.name = "lamp";
  lamp.shown = false;
  scene.balls = {lamp};
  Open(scene);
  Say("world/show", msg::String{"lamp"});
  EXPECT_TRUE(host_->world().scene().balls[0].shown);
  Say("world/hide", msg::String{"lamp"});
  EXPECT_FALSE(host_->world().scene().balls[0].shown);
  Say("world/show", msg::String{"sun"});
  EXPECT_THAT(log_.back(), HasSubstr("no ball with the name \"sun\""));
}

TEST_F(WorldHostTest, RepliesWithTheRefereesReport) {
  Scene scene = EmptyYard();
  scene.zones = {{"GOAL", {5, 0}, {1, 1}}};
  scene.referee.order = {"GOAL"};
  Open(scene);
  const auto text = CallService<msg::Trigger>("world/referee");
  ASSERT_TRUE(text);
  EXPECT_TRUE(text->success);
  EXPECT_THAT(text->message, HasSubstr("still ahead: GOAL"));
  const auto json = CallService<msg::Trigger>("world/referee_json");
  ASSERT_TRUE(json);
  EXPECT_THAT(json->message, HasSubstr(R"("ahead":["GOAL"])"));
}

TEST_F(WorldHostTest, RefusesAnImpossibleSpeedOfTime) {
  Open(EmptyYard());
  for (const float factor : {0.0F, -1.0F, 1000.0F, std::nanf("")}) {
    Say("world/speed", msg::Float32{factor});
    EXPECT_THAT(log_.back(), HasSubstr("0.01 to 100"));
  }
  Forget();
  network_.RunFor(seconds(1));
  EXPECT_EQ(clocks_.size(), 50u);
}

}  // namespace musher::world::host_test
