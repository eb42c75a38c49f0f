// The motion manager on its topics and services, with a body behind two topics; in virtual time.

#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <map>

#include "musher/modules/motion/motion_shell.hpp"
#include "musher/modules/motion/motion_wire.hpp"
#include "musher/modules/motion/topic_backend.hpp"
#include "musher/test/modules/motion/harness.hpp"
#include "musher/test/modules/motion/topic_board.hpp"
#include "musher/transport/sim/network.hpp"

namespace musher::motion::testing::motion_shell_test {

using ::testing::Contains;
using ::testing::HasSubstr;

class MotionShellTest : public ::testing::Test {
 protected:
  explicit MotionShellTest(TfConfig tf = {}) {
    config_.tf = std::move(tf);
    const Motion& stand = *TheTable().Find(kRecoveryStand);
    board_.board.report.mode = stand.mode;
    board_.board.report.bar = 100;
    auto shell = MotionShell::Make(
        {*node_, *clock_, TheTable(), config_, "dog1",
         [this](const std::string& capability) -> Result<> {
           if (capability == refused_) return Error{3013, "the battery is low"};
           return Ok();
         },
         [this](const std::string& text) { log_.push_back(text); }},
        [this](MotionBackend::OnBody on_body) -> Result<std::unique_ptr<MotionBackend>> {
          auto backend = TopicBackend::Make(*node_, "dog1", std::move(on_body));
          return std::unique_ptr<MotionBackend>(std::move(backend).value());
        });
    shell_ = std::move(shell).value();
    Listen<msg::MotionServoResponse>("motion_servo_response", responses_);
    Listen<msg::MotionStatus>("motion_status", status_);
    Listen<msg::Odometry>("odom_out", odometry_);
    Listen<msg::Imu>("imu", imu_);
    servo_ = transport::MakePublisher<msg::MotionServoCmd>(*user_, "dog1/motion_servo_cmd",
                                                           transport::kSystemDefaultQos)
                 .value();
    shell_->Do(motion_event::Opened{});
    network_.RunFor(Milliseconds(200));
  }

  template <msg::Message M>
  void Listen(const std::string& topic, std::vector<M>& messages) {
    ListenResolved("dog1/" + topic, messages, transport::kDefaultQos);
  }
  template <msg::Message M>
  void ListenResolved(const std::string& topic, std::vector<M>& messages,
                      const transport::Qos& qos) {
    subscriptions_.push_back(transport::MakeSubscription<M>(
                                 *user_, topic,
                                 [&messages](const M& message, const transport::SampleInfo&) {
                                   messages.push_back(message);
                                 },
                                 qos)
                                 .value());
  }

  template <msg::Service S>
  typename S::Response Call(const std::string& service, const typename S::Request& request) {
    auto client = transport::MakeClient<S>(*user_, "dog1/" + service).value();
    std::optional<Result<typename S::Response>> reply;
    client->Call(request, std::chrono::seconds(300), [&](auto result) { reply = result; });
    network_.RunUntil([&] { return reply.has_value(); }, network_.now() + std::chrono::hours(1));
    return reply->value();
  }

  msg::MotionResultCmd::Response RequestMotion(std::int32_t id) {
    msg::MotionResultCmd::Request request;
    request.motion_id = id;
    return Call<msg::MotionResultCmd>("motion_result_cmd", request);
  }

  void Stream(std::int32_t id, std::vector<float> vel, Duration duration) {
    msg::MotionServoCmd command;
    command.motion_id = id;
    command.cmd_type = msg::MotionServoCmd::kData;
    command.vel_des = std::move(vel);
    for (Duration t{}; t < duration; t += Milliseconds(50)) {
      ASSERT_TRUE(servo_->Publish(command));
      network_.RunFor(Milliseconds(50));
    }
  }

  transport::sim::Network network_{1};
  std::unique_ptr<transport::Node> node_ = network_.MakeNode("dog");
  std::unique_ptr<transport::Node> body_ = network_.MakeNode("dog");
  std::unique_ptr<transport::Node> user_ = network_.MakeNode("desk");
  std::unique_ptr<transport::Clock> clock_ = transport::Clock::Steady(node_->loop());
  TopicBoard board_{*body_, "dog1"};
  MotionConfig config_;
  std::string refused_;
  std::vector<std::string> log_;
  std::unique_ptr<MotionShell> shell_;
  std::vector<msg::MotionServoResponse> responses_;
  std::vector<msg::MotionStatus> status_;
  std::vector<msg::Odometry> odometry_;
  std::vector<msg::Imu> imu_;
  std::vector<std::unique_ptr<transport::Subscription>> subscriptions_;
  std::unique_ptr<transport::Publisher<msg::MotionServoCmd>> servo_;
};

TEST_F(MotionShellTest, ReportsAnEmergencyStopToTheManagerAndAnnouncesALowBattery) {
  std::vector<msg::NodeError> errors;
  std::vector<msg::AudioPlayExtend> speech;
  Listen<msg::NodeError>("node_errors", errors);
  Listen<msg::AudioPlayExtend>("speech_play_extend", speech);
  network_.RunFor(Milliseconds(200));
  refused_ = "back_flip";
  EXPECT_EQ(RequestMotion(121).code, 3013);
  EXPECT_EQ(RequestMotion(kEmergencyStop).code, kCodeOk);
  network_.RunFor(Milliseconds(200));
  ASSERT_EQ(errors.size(), 1U);
  EXPECT_EQ(errors[0], (msg::NodeError{"motion_manager", 3088}));
  ASSERT_EQ(speech.size(), 1U);
  EXPECT_TRUE(speech[0].is_online);
  EXPECT_EQ(speech[0].text, kChargeFirst);
}

TEST_F(MotionShellTest, AnswersAResultCommandWhenItsMotionIsDone) {
  const Time begin = network_.now();
  EXPECT_EQ(RequestMotion(121), (msg::MotionResultCmd::Response{121, true, 0}));
  EXPECT_GE(network_.now() - begin, board_.board.transition + board_.board.motion);
  EXPECT_EQ(board_.last.mode, 17);
}

// Its caller has given up.
TEST_F(MotionShellTest, BeginsNoMotionThatWasRequestedWhileItsProcessStoodStill) {
  auto client =
      transport::MakeClient<msg::MotionResultCmd>(*user_, "dog1/motion_result_cmd").value();
  network_.RunFor(Milliseconds(500));
  msg::MotionResultCmd::Request flip;
  flip.motion_id = 121;
  network_.Pause(*node_);
  bool given_up = false;
  client->Call(flip, Milliseconds(1000), [&](const auto& reply) { given_up = !reply; });
  network_.RunFor(std::chrono::seconds(20));
  EXPECT_TRUE(given_up);
  network_.Resume(*node_);
  network_.RunFor(Milliseconds(500));
  EXPECT_EQ(board_.commands, 0);
  EXPECT_THAT(log_, Contains(HasSubstr("stood still for a while")));
  network_.RunFor(Milliseconds(1000));
  EXPECT_TRUE(RequestMotion(121).result);
}

TEST_F(MotionShellTest, CarriesOutAStopThatWasRequestedWhileItsProcessStoodStill) {
  auto client =
      transport::MakeClient<msg::MotionResultCmd>(*user_, "dog1/motion_result_cmd").value();
  network_.RunFor(Milliseconds(500));
  msg::MotionResultCmd::Request stop;
  stop.motion_id = kEmergencyStop;
  network_.Pause(*node_);
  client->Call(stop, Milliseconds(1000), [](const auto&) {});
  network_.RunFor(std::chrono::seconds(20));
  network_.Resume(*node_);
  network_.RunFor(Milliseconds(500));
  EXPECT_TRUE(shell_->core().emergency_stop);
}

TEST_F(MotionShellTest, AnswersARefusedResultCommandWithItsCodeAndLogsTheReason) {
  refused_ = "back_flip";
  EXPECT_EQ(RequestMotion(121), (msg::MotionResultCmd::Response{121, false, 3013}));
  EXPECT_EQ(board_.commands, 0);
  EXPECT_THAT(log_, Contains(HasSubstr("the battery is low")));
}

TEST_F(MotionShellTest, WalksByServoCommandsAndStopsWhenTheyStop) {
  Stream(303, {0.5F, 0, 0}, Milliseconds(2000));
  EXPECT_EQ(board_.last.gait, 27);
  EXPECT_FLOAT_EQ(board_.last.vel[0], 0.5F);
  EXPECT_EQ(responses_.back().motion_id, 303);
  EXPECT_TRUE(responses_.back().result);
  network_.RunFor(Milliseconds(400));
  EXPECT_EQ(board_.last.gait, 1) << "WALK_STAND";
  EXPECT_FLOAT_EQ(board_.last.vel[0], 0);
}

TEST_F(MotionShellTest, AnswersARefusedServoCommand) {
  refused_ = "walk";
  Stream(303, {0.5F, 0, 0}, Milliseconds(50));
  ASSERT_EQ(responses_.size(), 1U);
  EXPECT_EQ(responses_[0].code, 3013);
  EXPECT_FALSE(responses_[0].result);
}

TEST_F(MotionShellTest, PublishesItsStatusTenTimesASecond) {
  status_.clear();
  network_.RunFor(std::chrono::seconds(2));
  EXPECT_NEAR(static_cast<double>(status_.size()), 20, 1);
  EXPECT_EQ(status_.back().motion_id, kRecoveryStand);
  EXPECT_EQ(status_.back().motor_error.size(), 12U);
}

TEST_F(MotionShellTest, PublishesInItsStatusThatTheBoardIsSilent) {
  board_.board.silent = true;
  network_.RunFor(std::chrono::seconds(1));
  EXPECT_EQ(status_.back().motion_id, kNoMotion);
  EXPECT_EQ(Call<msg::MotorTemp>("motor_temp", {}).code, 3035);
}

TEST_F(MotionShellTest, PublishesOdometryAndImuFiftyTimesASecond) {
  Stream(303, {0.5F, 0, 0.4F}, Milliseconds(1000));
  odometry_.clear();
  imu_.clear();
  Stream(303, {0.5F, 0, 0.4F}, Milliseconds(1000));
  EXPECT_NEAR(static_cast<double>(odometry_.size()), 50, 1);
  EXPECT_NEAR(static_cast<double>(imu_.size()), 50, 1);
  const msg::Odometry& odometry = odometry_.back();
  EXPECT_EQ(odometry.header.frame_id, "odom");
  EXPECT_EQ(odometry.child_frame_id, "base_link_leg");
  EXPECT_GT(odometry.pose.pose.position.x, 0.5);
  EXPECT_FLOAT_EQ(static_cast<float>(odometry.twist.twist.linear.x), 0.5F);
  EXPECT_GT(odometry.pose.pose.orientation.z, 0.1) << "left is positive";
  EXPECT_EQ(imu_.back().orientation, odometry.pose.pose.orientation);
}

// As nav2 and RViz have it; the frame of `odom_out` is one of the tree.
class MotionShellWithFrames : public MotionShellTest {
 protected:
  MotionShellWithFrames()
      : MotionShellTest(
            {true, "odom", "base_link", {{"laser_link", "base_link", {0.2, 0, 0.1}, {0, 0, 1}}}}) {
    ListenResolved("tf", moving_, transport::kDefaultQos);
    ListenResolved("tf_static", fixed_, transport::kLatchedQos);
    network_.RunFor(Milliseconds(200));
  }
  std::vector<msg::TfMessage> moving_;
  std::vector<msg::TfMessage> fixed_;
};

TEST_F(MotionShellWithFrames, PublishesTheBodyWithEachOdometry) {
  Stream(303, {0.5F, 0, 0.4F}, Milliseconds(1000));
  odometry_.clear();
  moving_.clear();
  Stream(303, {0.5F, 0, 0.4F}, Milliseconds(1000));
  EXPECT_EQ(moving_.size(), odometry_.size());
  ASSERT_EQ(moving_.back().transforms.size(), 1U);
  const msg::TransformStamped& body = moving_.back().transforms[0];
  const msg::Odometry& odometry = odometry_.back();
  EXPECT_EQ(body.header, odometry.header) << "the same time and frame: odom";
  EXPECT_EQ(body.child_frame_id, "base_link");
  EXPECT_GT(body.transform.translation.x, 0.5);
  EXPECT_EQ(body.transform.rotation, odometry.pose.pose.orientation);
}

TEST_F(MotionShellWithFrames, LatchesWhatIsFixedOnTheBody) {
  ASSERT_EQ(fixed_.size(), 1U);
  std::map<std::string, msg::TransformStamped> frames;
  for (const auto& one : fixed_[0].transforms) frames[one.child_frame_id] = one;
  ASSERT_EQ(frames.size(), 3U);
  for (const char* frame : {"base_link_leg", "imu_link", "laser_link"}) {
    EXPECT_EQ(frames[frame].header.frame_id, "base_link") << frame;
  }
  EXPECT_EQ(frames["base_link_leg"].transform.rotation.w, 1);
  EXPECT_EQ(frames["laser_link"].transform.translation.z, 0.1);
  EXPECT_NEAR(frames["laser_link"].transform.rotation.z, std::sin(0.5), 1e-9);
}

// Of two robots on one network: both had fixed "base_link_leg" and "imu_link" on their bodies.
class MotionShellOfOneOfTwoRobots : public MotionShellTest {
 protected:
  MotionShellOfOneOfTwoRobots()
      : MotionShellTest(
            {true, "dog1/odom", "dog1/base_link", {{"dog1/imu_link", "dog1/base_link", {}, {}}}}) {}
};

TEST_F(MotionShellOfOneOfTwoRobots, PublishesItsOwnFramesOnly) {
  std::vector<msg::TfMessage> fixed;
  ListenResolved("tf_static", fixed, transport::kLatchedQos);
  Stream(303, {0.5F, 0, 0}, Milliseconds(200));
  ASSERT_EQ(fixed.size(), 1U);
  std::vector<std::string> frames;
  for (const auto& one : fixed[0].transforms) frames.push_back(one.child_frame_id);
  EXPECT_THAT(frames, ::testing::ElementsAre("dog1/base_link_leg", "dog1/imu_link"));
  EXPECT_EQ(odometry_.back().header.frame_id, "dog1/odom");
  EXPECT_EQ(odometry_.back().child_frame_id, "dog1/base_link_leg");
  EXPECT_EQ(imu_.back().header.frame_id, "dog1/imu_link");
}

TEST_F(MotionShellTest, PublishesNoFrameUnlessItsConfigSaysSo) {
  std::vector<msg::TfMessage> frames;
  ListenResolved("tf", frames, transport::kDefaultQos);
  ListenResolved("tf_static", frames, transport::kLatchedQos);
  Stream(303, {0.5F, 0, 0}, Milliseconds(1000));
  EXPECT_TRUE(frames.empty());
}

TEST_F(MotionShellTest, ReportsTheTemperatureOfItsMotors) {
  board_.board.report.motor_temperature.fill(41.5F);
  network_.RunFor(Milliseconds(100));
  const auto answer = Call<msg::MotorTemp>("motor_temp", {});
  EXPECT_TRUE(answer.result);
  EXPECT_EQ(answer.motor_temp, std::vector<float>(12, 41.5F));
}

TEST_F(MotionShellTest, ExecutesAMotionOfTheTableAsACustomOneAndDefinesNone) {
  using Custom = msg::MotionCustomCmd;
  EXPECT_EQ(Call<Custom>("motion_custom_cmd", {Custom::kExecution, 0, 140}),
            (Custom::Response{140, true, 0}));
  EXPECT_EQ(Call<Custom>("motion_custom_cmd", {Custom::kDefinition, 0, 140}).code, 3008);
  EXPECT_EQ(Call<Custom>("motion_custom_cmd", {7, 0, 140}).code, 3010);
}

TEST_F(MotionShellTest, PlaysAQueueOfTheBoardsCommands) {
  msg::MotionCustomCommand jump;
  jump.mode = 16;
  msg::MotionCustomCommand stand;
  stand.mode = 12;
  EXPECT_EQ(Call<msg::MotionQueueCustomCmd>("motion_queue_cmd", {{jump, stand}}).code, 0);
  EXPECT_EQ(board_.last.mode, 12);
  const int before = board_.commands;
  jump.gait_id = 99;
  EXPECT_EQ(Call<msg::MotionQueueCustomCmd>("motion_queue_cmd", {{stand, jump}}).code, 3008);
  EXPECT_EQ(Call<msg::MotionQueueCustomCmd>("motion_queue_cmd", {}).code, 3010);
  EXPECT_EQ(board_.commands, before) << "nothing of it was begun";
}

// In the original a queue that the state forbade was refused without a reply.
TEST_F(MotionShellTest, AnswersARefusedQueueWithItsCode) {
  refused_ = "jump";
  msg::MotionCustomCommand jump;
  jump.mode = 16;
  const auto answer = Call<msg::MotionQueueCustomCmd>("motion_queue_cmd", {{jump}});
  EXPECT_EQ(answer, (msg::MotionQueueCustomCmd::Response{false, 3013}));
  EXPECT_THAT(log_, Contains(HasSubstr("is refused")));
}

TEST_F(MotionShellTest, PlaysASequenceOfPaces) {
  msg::MotionSequenceShow::Request request;
  request.motion_id = 400;
  msg::MotionSequencePace pace;
  pace.duration = 1000;
  pace.twist.linear.x = 0.3;
  request.pace_list = {pace, pace};
  request.pace_list[1].twist.angular.z = 0.5;
  const auto answer = Call<msg::MotionSequenceShow>("motion_sequence_cmd", request);
  EXPECT_EQ(answer, (msg::MotionSequenceShow::Response{true, 0, "", 400}));
  network_.RunFor(Milliseconds(200));
  EXPECT_EQ(board_.last.gait, 1) << "it ends standing";
}

TEST_F(MotionShellTest, RefusesASequenceThatItCannotPlayWithTheReason) {
  using Show = msg::MotionSequenceShow;
  Show::Request gaits;
  gaits.motion_id = 400;
  gaits.gait_list.emplace_back();
  Show::Request feet;
  feet.pace_list.emplace_back();
  feet.pace_list[0].duration = 100;
  feet.pace_list[0].centroid.position.z = 0.1;
  for (const Show::Request& request : {gaits, feet}) {
    const auto answer = Call<Show>("motion_sequence_cmd", request);
    EXPECT_EQ(answer.code, 3008);
    EXPECT_THAT(answer.describe, HasSubstr("board"));
  }
  Show::Request endless;
  endless.pace_list.emplace_back();
  EXPECT_EQ(Call<Show>("motion_sequence_cmd", endless).code, 3031);
  EXPECT_EQ(Call<Show>("motion_sequence_cmd", {}).code, 3031);
  EXPECT_EQ(board_.commands, 0);
}

TEST_F(MotionShellTest, ChecksThatTheBoardReportsAndNoMotorHasAnError) {
  EXPECT_TRUE(shell_->Check());
  board_.board.report.motor_error[7] = 13;
  network_.RunFor(Milliseconds(100));
  EXPECT_EQ(shell_->Check().error().code, 3009);
  EXPECT_THAT(shell_->Check().error().message,
              HasSubstr("motor 7 (rear right hip) reports: too hot, offline, fault"));
  board_.board.silent = true;
  network_.RunFor(Milliseconds(600));
  EXPECT_THAT(shell_->Check().error().message, HasSubstr("silent"));
}

TEST_F(MotionShellTest, SendsAnEmergencyStopToTheBoardAtOnce) {
  Stream(303, {0.5F, 0, 0}, Milliseconds(1000));
  const Time begin = network_.now();
  shell_->Do(motion_event::EmergencyStop{});
  EXPECT_TRUE(network_.RunUntil([&] { return board_.last.mode == 0; }, begin + Milliseconds(5)));
}

// An invalid pose must not be published in the odometry.
TEST_F(MotionShellTest, TreatsAnInvalidRotationAsIdentity) {
  EXPECT_TRUE(FromWire(msg::BodyState{}).motion.X_OB.isApprox(Eigen::Isometry3d::Identity()));
  msg::BodyState state;
  state.pose.orientation = {0, 0, 0, 0};
  EXPECT_TRUE(FromWire(state).motion.X_OB.isApprox(Eigen::Isometry3d::Identity()));
  state.pose.orientation.x = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(FromWire(state).motion.X_OB.isApprox(Eigen::Isometry3d::Identity()));
}

}  // namespace musher::motion::testing::motion_shell_test
