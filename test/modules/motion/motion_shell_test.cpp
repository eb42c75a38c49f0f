// The motion manager on its topics and services, with a body behind two topics; in virtual time.

#include <gmock/gmock.h>

#include <cmath>
#include <functional>
#include <limits>
#include <map>

#include "musher/messages/musher_msgs/actuator_status.hpp"
#include "musher/messages/musher_msgs/heartbeats.hpp"
#include "musher/modules/motion/motion_shell.hpp"
#include "musher/modules/motion/motion_wire.hpp"
#include "musher/modules/motion/topic_backend.hpp"
#include "musher/test/modules/motion/harness.hpp"
#include "musher/test/modules/motion/topic_board.hpp"
#include "musher/test/support/paths.hpp"
#include "musher/test/transport/suspended_node.hpp"
#include "musher/transport/sim/network.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher::motion::testing::motion_shell_test {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

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
          auto backend = TopicBackend::Make(*node_, "dog1", std::move(on_body),
                                            [this](std::int32_t code, const std::string& text) {
                                              shell_->Do(motion_event::BoardFault{code, text});
                                            });
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
  std::unique_ptr<musher::testing::SuspendedNode> node_ =
      std::make_unique<musher::testing::SuspendedNode>(network_.MakeNode("dog"));
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

TEST_F(MotionShellTest, DropsAReportWithANumberThatIsNotFiniteAndLogsThatOnce) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const auto faulty = transport::MakePublisher<msg::BodyState>(*body_, "dog1/world/body_state");
  network_.RunFor(Milliseconds(200));
  board_.board.silent = true;
  network_.RunFor(Milliseconds(100));
  odometry_.clear();
  imu_.clear();
  msg::BodyState good;
  good.mode = board_.board.report.mode;
  good.pose.orientation.w = 1;
  std::vector<msg::BodyState> bad(6, good);
  bad[0].pose.position.x = kNaN;
  bad[1].pose.orientation.w = kNaN;
  bad[2].twist.linear.y = kInfinity;
  bad[3].twist.angular.z = -kInfinity;
  bad[4].linear_acceleration.z = kNaN;
  bad[5].motor_temperature[11] = static_cast<float>(kNaN);
  for (const msg::BodyState& state : bad) ASSERT_TRUE(faulty.value()->Publish(state));
  network_.RunFor(Milliseconds(100));
  EXPECT_THAT(odometry_, IsEmpty());
  EXPECT_THAT(imu_, IsEmpty());
  const std::string dropped =
      "a report on dog1/world/body_state is dropped: a number is NaN or infinite (3010)";
  EXPECT_THAT(log_, ElementsAre(dropped));
  ASSERT_TRUE(faulty.value()->Publish(good));
  network_.RunFor(Milliseconds(100));
  EXPECT_EQ(odometry_.size(), 1U) << "the next one counts";
  network_.RunFor(std::chrono::minutes(3));
  ASSERT_TRUE(faulty.value()->Publish(bad[0]));
  network_.RunFor(Milliseconds(100));
  EXPECT_THAT(log_, Contains(dropped).Times(2)) << "once in three minutes";
}

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
TEST_F(MotionShellTest, BeginsNoMotionThatWasRequestedWhileItsProcessCouldNotRun) {
  auto client =
      transport::MakeClient<msg::MotionResultCmd>(*user_, "dog1/motion_result_cmd").value();
  network_.RunFor(Milliseconds(500));
  msg::MotionResultCmd::Request flip;
  flip.motion_id = 121;
  network_.Pause(node_->simulated());
  bool given_up = false;
  client->Call(flip, Milliseconds(1000), [&](const auto& reply) { given_up = !reply; });
  network_.RunFor(std::chrono::seconds(20));
  EXPECT_TRUE(given_up);
  network_.Resume(node_->simulated());
  network_.RunFor(Milliseconds(500));
  EXPECT_EQ(board_.commands, 0);
  EXPECT_THAT(log_, Contains(HasSubstr("the motion manager could not run for 20 s")));
  network_.RunFor(Milliseconds(2000));
  EXPECT_TRUE(RequestMotion(121).result);
}

// A writer repeats each second what was not received.
TEST_F(MotionShellTest, BeginsNoMotionByARequestThatIsRepeatedAfterItsProcessCouldNotRun) {
  network_.Pause(node_->simulated());
  network_.RunFor(std::chrono::seconds(20));
  network_.Resume(node_->simulated());
  network_.RunFor(Milliseconds(1500));
  EXPECT_EQ(RequestMotion(121).code, MotionCode(KeyCode::kTimeout));
  EXPECT_EQ(board_.commands, 0);
}

TEST_F(MotionShellTest, BeginsNoMotionThatWasRequestedWhileItsComputerWasSuspended) {
  auto client =
      transport::MakeClient<msg::MotionResultCmd>(*user_, "dog1/motion_result_cmd").value();
  network_.RunFor(Milliseconds(500));
  msg::MotionResultCmd::Request flip;
  flip.motion_id = 121;
  node_->loop().suspended += std::chrono::hours(1);
  std::int32_t code = kCodeOk;
  client->Call(flip, Milliseconds(1000), [&](const auto& reply) { code = reply.value().code; });
  network_.RunFor(Milliseconds(500));
  EXPECT_EQ(code, MotionCode(KeyCode::kTimeout));
  EXPECT_EQ(board_.commands, 0);
  network_.RunFor(Milliseconds(2000));
  EXPECT_TRUE(RequestMotion(121).result);
}

// A body that lay stood up for a stream that was over.
TEST_F(MotionShellTest, BeginsNoMotionByAFrameThatWaitedWhileItsProcessCouldNotRun) {
  network_.Pause(node_->simulated());
  Stream(303, {0.5F, 0, 0}, Milliseconds(500));
  network_.RunFor(std::chrono::seconds(20));
  network_.Resume(node_->simulated());
  network_.RunFor(Milliseconds(2500));
  EXPECT_EQ(board_.commands, 0);
  ASSERT_FALSE(responses_.empty());
  EXPECT_EQ(responses_.back().code, MotionCode(KeyCode::kTimeout));
  Stream(303, {0.5F, 0, 0}, Milliseconds(1000));
  EXPECT_EQ(board_.last.gait, 27);
}

TEST_F(MotionShellTest, CarriesOutAStopThatWasRequestedWhileItsProcessCouldNotRun) {
  auto client =
      transport::MakeClient<msg::MotionResultCmd>(*user_, "dog1/motion_result_cmd").value();
  network_.RunFor(Milliseconds(500));
  msg::MotionResultCmd::Request stop;
  stop.motion_id = kEmergencyStop;
  network_.Pause(node_->simulated());
  client->Call(stop, Milliseconds(1000), [](const auto&) {});
  network_.RunFor(std::chrono::seconds(20));
  network_.Resume(node_->simulated());
  network_.RunFor(Milliseconds(500));
  EXPECT_TRUE(shell_->core().emergency_stop);
}

// Another robot of the same image is in reach: `user_` is a program of it.
class MotionShellBesideAnotherRobot : public MotionShellTest {
 protected:
  MotionShellBesideAnotherRobot() { PublishStatus(*node_, own_, "dog", "boot of dog"); }

  using StatusPublisher = std::unique_ptr<transport::Publisher<msg::ActuatorStatus>>;
  void Advertise(transport::Node& node, StatusPublisher& publisher) {
    publisher = transport::MakePublisher<msg::ActuatorStatus>(
                    node, transport::ActuatorStatusTopic("dog1"), transport::kLatchedQos)
                    .value();
  }
  void PublishStatus(transport::Node& node, StatusPublisher& publisher, const std::string& machine,
                     const std::string& host) {
    if (!publisher) Advertise(node, publisher);
    msg::ActuatorStatus status;
    status.name = "program";
    status.state = "Active";
    status.machine = machine;
    status.host = host;
    status.participant = node.participant().value();
    ASSERT_TRUE(publisher->Publish(status));
    network_.RunFor(Milliseconds(200));
  }

  // Whether it was answered.
  bool RequestsMotion(std::int32_t id) {
    msg::MotionResultCmd::Request request;
    request.motion_id = id;
    bool answered = false;
    calls_.push_back(
        transport::MakeClient<msg::MotionResultCmd>(*user_, "dog1/motion_result_cmd").value());
    calls_.back()->Call(request, std::chrono::seconds(20),
                        [&answered](const auto& reply) { answered = reply.ok(); });
    network_.RunFor(std::chrono::seconds(25));
    return answered;
  }

  StatusPublisher own_;
  StatusPublisher theirs_;
  std::vector<std::unique_ptr<transport::Client<msg::MotionResultCmd>>> calls_;
};

TEST_F(MotionShellBesideAnotherRobot, IsNotMovedByItsStream) {
  PublishStatus(*user_, theirs_, "another dog", "boot of another dog");
  const int mode = board_.last.mode;
  Stream(303, {0.3F, 0, 0}, std::chrono::seconds(3));
  EXPECT_FALSE(shell_->core().servo);
  EXPECT_EQ(board_.last.mode, mode);
  EXPECT_TRUE(responses_.empty());  // its program would take them for those of its own robot
  EXPECT_THAT(log_, Contains(HasSubstr("another dog")));
}

TEST_F(MotionShellBesideAnotherRobot, NeitherExecutesItsRequestsNorAnswersThem) {
  PublishStatus(*user_, theirs_, "another dog", "boot of another dog");
  EXPECT_FALSE(RequestsMotion(121));
  EXPECT_TRUE(shell_->core().Idle());
}

TEST_F(MotionShellBesideAnotherRobot, IsStoppedByItsStop) {
  PublishStatus(*user_, theirs_, "another dog", "boot of another dog");
  EXPECT_TRUE(RequestsMotion(kEmergencyStop));
  EXPECT_TRUE(shell_->core().emergency_stop);
}

TEST_F(MotionShellBesideAnotherRobot, IsNotMovedByItsController) {
  auto heartbeats = transport::MakePublisher<msg::ControllerHeartbeat>(
                        *user_, transport::ControllerHeartbeatTopic("dog1"), transport::kLatchedQos)
                        .value();
  msg::ControllerHeartbeat heartbeat;
  heartbeat.machine = "another dog";
  heartbeat.host = "boot of another dog";
  heartbeat.participant = user_->participant().value();
  ASSERT_TRUE(heartbeats->Publish(heartbeat));
  network_.RunFor(Milliseconds(200));
  EXPECT_FALSE(RequestsMotion(121));
}

// The status of a program arrives after its first frames: two robots have just come into reach.
TEST_F(MotionShellBesideAnotherRobot, IsNotMovedBeforeItIsKnownWhoseProgramItIs) {
  Advertise(*user_, theirs_);
  network_.RunFor(Milliseconds(200));
  Stream(303, {0.3F, 0, 0}, Milliseconds(500));
  EXPECT_FALSE(shell_->core().servo);
  PublishStatus(*user_, theirs_, "dog", "boot of a second computer");
  Stream(303, {0.3F, 0, 0}, Milliseconds(500));
  EXPECT_TRUE(shell_->core().servo);
}

TEST_F(MotionShellBesideAnotherRobot, ExecutesARequestOnceItsCallerIsKnownToBeOfThisRobot) {
  Advertise(*user_, theirs_);
  network_.RunFor(Milliseconds(200));
  const auto known = user_->loop().At(user_->loop().Now() + Milliseconds(500), [this] {
    msg::ActuatorStatus status;
    status.name = "program";
    status.machine = "dog";
    status.participant = user_->participant().value();
    static_cast<void>(theirs_->Publish(status));
  });
  EXPECT_TRUE(RequestsMotion(121));
}

TEST_F(MotionShellBesideAnotherRobot, ExecutesNoRequestWhoseCallerWasNotKnownForTooLong) {
  Advertise(*user_, theirs_);
  network_.RunFor(Milliseconds(200));
  const auto known = user_->loop().At(user_->loop().Now() + std::chrono::seconds(5), [this] {
    msg::ActuatorStatus status;
    status.name = "program";
    status.machine = "dog";
    status.participant = user_->participant().value();
    static_cast<void>(theirs_->Publish(status));
  });
  EXPECT_FALSE(RequestsMotion(121));
}

TEST_F(MotionShellBesideAnotherRobot, SaysOnceWhyItIgnoresTheStreamOfAProgramThatIsNotKnown) {
  Advertise(*user_, theirs_);
  network_.RunFor(Milliseconds(200));
  Stream(303, {0.3F, 0, 0}, Milliseconds(1500));
  EXPECT_THAT(log_, Not(Contains(HasSubstr("none has arrived"))));
  Stream(303, {0.3F, 0, 0}, Milliseconds(5000));
  EXPECT_FALSE(shell_->core().servo);
  EXPECT_THAT(log_, Contains(HasSubstr("none has arrived")).Times(1));
}

TEST_F(MotionShellBesideAnotherRobot, SaysWhyItIgnoresTheRequestOfAProgramThatIsNotKnown) {
  Advertise(*user_, theirs_);
  network_.RunFor(Milliseconds(200));
  EXPECT_FALSE(RequestsMotion(121));
  EXPECT_THAT(log_, Contains(HasSubstr("none has arrived")));
}

// Its status came once. Many processes with a status were restarted after it.
TEST_F(MotionShellBesideAnotherRobot, IsMovedByAProgramOfItsOwnAfterManyOthersHaveCome) {
  PublishStatus(*user_, theirs_, "dog", "boot of a second computer");
  for (int round = 0; round < 5; ++round) {
    std::vector<std::unique_ptr<transport::Node>> guests(60);
    std::vector<StatusPublisher> statuses(guests.size());
    for (std::size_t i = 0; i < guests.size(); ++i) {
      guests[i] = network_.MakeNode("guest");
      PublishStatus(*guests[i], statuses[i], "another dog", "boot of another dog");
    }
  }
  network_.RunFor(std::chrono::seconds(1));
  Stream(303, {0.3F, 0, 0}, Milliseconds(500));
  EXPECT_TRUE(shell_->core().servo);
}

// The status of its sender arrives after a stop that came later than the request: the body stood
// up.
class MotionShellThatIsStopped : public MotionShellBesideAnotherRobot {
 protected:
  MotionShellThatIsStopped() {
    Advertise(*user_, theirs_);
    network_.RunFor(Milliseconds(500));
    Request(kRecoveryStand, [this](std::int32_t code) { stand_code_ = code; });
    network_.RunFor(Milliseconds(200));
  }

  void Request(std::int32_t id, std::function<void(std::int32_t code)> on_code) {
    msg::MotionResultCmd::Request request;
    request.motion_id = id;
    client_->Call(request, std::chrono::seconds(20), [on_code](const auto& reply) {
      on_code(reply ? reply.value().code : kCodeNetError);
    });
  }
  void ExpectThatItStaysStopped() {
    EXPECT_EQ(stand_code_, std::nullopt);
    ASSERT_TRUE(shell_->core().emergency_stop);
    PublishStatus(*user_, theirs_, "dog", "boot of a second computer");
    network_.RunFor(std::chrono::seconds(2));
    EXPECT_EQ(stand_code_, MotionCode(MotionKey::kEstop));
    EXPECT_TRUE(shell_->core().emergency_stop);
    EXPECT_NE(board_.last.mode, TheTable().Find(kRecoveryStand)->mode);
  }

  std::unique_ptr<transport::Client<msg::MotionResultCmd>> client_ =
      transport::MakeClient<msg::MotionResultCmd>(*user_, "dog1/motion_result_cmd").value();
  std::optional<std::int32_t> stand_code_;
};

TEST_F(MotionShellThatIsStopped, ByARequestDoesNotStandUpByAnEarlierOne) {
  Request(kEmergencyStop, [](std::int32_t) {});
  network_.RunFor(Milliseconds(200));
  ExpectThatItStaysStopped();
}

TEST_F(MotionShellThatIsStopped, ByTheMachineDoesNotStandUpByAnEarlierRequest) {
  shell_->Do(motion_event::EmergencyStop{});
  ExpectThatItStaysStopped();
}

TEST_F(MotionShellThatIsStopped, ByItsBoardDoesNotStandUpByAnEarlierRequest) {
  board_.board.report.mode = TheTable().Find(kEmergencyStop)->mode;
  network_.RunFor(Milliseconds(200));
  ExpectThatItStaysStopped();
}

TEST_F(MotionShellThatIsStopped, AgainDoesNotStandUpByARequestFromBetweenTwoStops) {
  shell_->Do(motion_event::EmergencyStop{});
  Request(kRecoveryStand, [this](std::int32_t code) { stand_code_ = code; });
  network_.RunFor(Milliseconds(200));
  shell_->Do(motion_event::EmergencyStop{});
  ExpectThatItStaysStopped();
}

// The config of a program that was started by hand on this computer has another name.
TEST_F(MotionShellBesideAnotherRobot, IsMovedByAProgramOfItsOwnHost) {
  PublishStatus(*user_, theirs_, "another name", "boot of dog");
  EXPECT_TRUE(RequestsMotion(121));
}

// A bridge repeats the statuses of others; what it sends itself is of no machine.
TEST_F(MotionShellBesideAnotherRobot, IsMovedByWhatABridgeRepeats) {
  Advertise(*user_, theirs_);
  msg::ActuatorStatus status;
  status.name = "program";
  status.machine = "another dog";
  status.host = "boot of another dog";
  status.participant = node_->participant().value();
  ASSERT_TRUE(theirs_->Publish(status));
  network_.RunFor(Milliseconds(200));
  EXPECT_TRUE(RequestsMotion(121));
}

// The line waited for a disk that did not answer, and the stop for the line.
TEST_F(MotionShellTest, SendsAStopBeforeTheLineThatSaysSo) {
  class Board : public MotionBackend {
   public:
    explicit Board(std::vector<std::string>& done) : done_(done) {}
    void Send(const BodyCommand& command) override {
      done_.push_back("mode " + std::to_string(command.mode));
    }

   private:
    std::vector<std::string>& done_;
  };
  std::vector<std::string> done;
  const auto node = network_.MakeNode("another dog");
  const auto clock = transport::Clock::Steady(node->loop());
  const auto shell =
      MotionShell::Make(
          {*node, *clock, TheTable(), config_, "dog2",
           [](const std::string&) -> Result<> { return Ok(); },
           [&](const std::string& text) { done.push_back(text); }},
          [&](const MotionBackend::OnBody&) -> Result<std::unique_ptr<MotionBackend>> {
            return std::unique_ptr<MotionBackend>(std::make_unique<Board>(done));
          })
          .value();
  shell->Do(motion_event::EmergencyStop{});
  EXPECT_THAT(done, ElementsAre("mode 0", "emergency stop"));
}

// A board that takes gaits, and a disk that answers when the test lets it.
class MotionShellWithASlowDisk : public MotionShellTest {
 protected:
  class Board : public MotionBackend {
   public:
    explicit Board(std::vector<OnDefined>& definitions) : definitions_(definitions) {}
    void Send(const BodyCommand& /*command*/) override {}
    bool TakesGaits() const override { return true; }
    void DefineGait(const UserGait& /*gait*/, OnDefined then) override {
      definitions_.push_back(std::move(then));
    }

   private:
    std::vector<OnDefined>& definitions_;
  };

  MotionShellWithASlowDisk() {
    config_.gaits = SourceDir() + "/config/motion/gaits";
    MotionShell::Dependencies dependencies{
        *slow_node_,
        *slow_clock_,
        TheTable(),
        config_,
        "dog2",
        [](const std::string&) -> Result<> { return Ok(); },
        [this](const std::string& text) { log_.push_back(text); }};
    dependencies.in_background = [this](MotionShell::Background work) {
      disk_.push_back(std::move(work));
    };
    slow_ = MotionShell::Make(
                std::move(dependencies),
                [this](MotionBackend::OnBody on_body) -> Result<std::unique_ptr<MotionBackend>> {
                  on_body_ = std::move(on_body);
                  return std::unique_ptr<MotionBackend>(std::make_unique<Board>(definitions_));
                })
                .value();
    network_.RunFor(Milliseconds(200));
    Request(msg::MotionCustomCmd::kDefinition);
  }

  void Request(std::int32_t type) {
    msg::MotionCustomCmd::Request request;
    request.cmd_type = type;
    request.motion_id = 400;
    code_.reset();
    client_->Call(request, std::chrono::seconds(30), [this](const auto& reply) {
      code_ = reply ? reply.value().code : kCodeNetError;
    });
    network_.RunFor(Milliseconds(100));
  }
  // From now on a body stands, in Active.
  void StartBoard() {
    slow_->Do(motion_event::Opened{});
    standing_.report.mode = TheTable().Find(kRecoveryStand)->mode;
    standing_.report.bar = 100;
    standing_.has_new_motion = false;
    reports_ = slow_node_->loop().Every(Milliseconds(20), [this] { on_body_(standing_); });
    network_.RunFor(Milliseconds(100));
  }
  // The disk has read the files of that DEFINITION, and the board takes the gait.
  void Define(std::size_t definition) {
    ASSERT_EQ(disk_.size(), definition + 1);
    disk_[definition]()();
    ASSERT_EQ(definitions_.size(), definition + 1);
    definitions_[definition](Ok());
    network_.RunFor(Milliseconds(100));
  }

  std::unique_ptr<transport::Node> slow_node_ = network_.MakeNode("another dog");
  std::unique_ptr<transport::Clock> slow_clock_ = transport::Clock::Steady(slow_node_->loop());
  std::vector<MotionShell::Background> disk_;
  std::vector<MotionBackend::OnDefined> definitions_;  // that the board has not answered
  MotionBackend::OnBody on_body_;
  BodyState standing_;
  transport::LoopHandlePtr reports_;
  std::unique_ptr<transport::Client<msg::MotionCustomCmd>> client_ =
      transport::MakeClient<msg::MotionCustomCmd>(*user_, "dog2/motion_custom_cmd").value();
  std::optional<std::int32_t> code_;
  std::unique_ptr<MotionShell> slow_;
};

// The disk was read on the loop, and meanwhile the board got no frame.
TEST_F(MotionShellWithASlowDisk, ReadsAGaitBesideItsLoop) {
  network_.RunFor(std::chrono::seconds(1));
  ASSERT_EQ(disk_.size(), 1U);
  EXPECT_FALSE(code_);
  disk_[0]()();
  network_.RunFor(std::chrono::seconds(1));
  ASSERT_TRUE(code_);
  EXPECT_NE(*code_, MotionCode(KeyCode::kTimeout)) << "it is refused, as the body is not known";
}

TEST_F(MotionShellWithASlowDisk, DefinesNoGaitWhoseCallerMayHaveGivenUp) {
  network_.RunFor(std::chrono::seconds(3));
  ASSERT_EQ(disk_.size(), 1U);
  disk_[0]()();
  network_.RunFor(std::chrono::seconds(1));
  EXPECT_EQ(code_, MotionCode(KeyCode::kTimeout));
}

// It executed the gait from before, which the board still had.
TEST_F(MotionShellWithASlowDisk, ExecutesNoGaitWhileItsNewDefinitionIsRead) {
  StartBoard();
  Define(0);
  ASSERT_EQ(code_, kCodeOk);
  Request(msg::MotionCustomCmd::kDefinition);
  Request(msg::MotionCustomCmd::kExecution);
  EXPECT_EQ(code_, MotionCode(MotionKey::kSequenceDefinition));
  EXPECT_TRUE(slow_->core().Idle());
  Define(1);
  EXPECT_EQ(code_, kCodeOk);
  Request(msg::MotionCustomCmd::kExecution);
  EXPECT_FALSE(slow_->core().Idle());
}

// It came a moment after the stop, and was played if recovery stand had been taken before.
TEST_F(MotionShellWithASlowDisk, PlaysNoSequenceThatIsDefinedAfterAStop) {
  StartBoard();
  Define(0);
  const auto client =
      transport::MakeClient<msg::MotionSequenceShow>(*user_, "dog2/motion_sequence_cmd").value();
  network_.RunFor(Milliseconds(500));
  msg::MotionSequenceShow::Request sequence;
  sequence.motion_id = 400;
  sequence.gait_list = {{true, false, false, true, 12}};
  sequence.pace_list.emplace_back();
  sequence.pace_list[0].right_forefoot.w = 0.05;
  sequence.pace_list[0].duration = 300;
  std::string describe;
  client->Call(sequence, std::chrono::seconds(30), [&describe](const auto& reply) {
    describe = reply ? reply.value().describe : reply.error().message;
  });
  network_.RunFor(Milliseconds(100));
  ASSERT_EQ(definitions_.size(), 2U) << describe;
  slow_->Do(motion_event::EmergencyStop{});
  definitions_[1](Ok());
  network_.RunFor(Milliseconds(100));
  EXPECT_THAT(describe, HasSubstr("stopped after it was requested"));
}

// Each waited for the one before, without limit.
TEST_F(MotionShellWithASlowDisk, ReadsTheFilesOfAGaitOnceAtATime) {
  StartBoard();
  Request(msg::MotionCustomCmd::kDefinition);
  EXPECT_EQ(code_, MotionCode(KeyCode::kTargetBusy));
  Define(0);
  EXPECT_EQ(code_, kCodeOk);
  Request(msg::MotionCustomCmd::kDefinition);
  EXPECT_EQ(disk_.size(), 2U);
}

TEST_F(MotionShellWithASlowDisk, DropsAGaitThatIsReadAfterItsEnd) {
  network_.RunFor(std::chrono::seconds(1));
  ASSERT_EQ(disk_.size(), 1U);
  const auto then = disk_[0]();
  slow_.reset();
  then();
  EXPECT_FALSE(code_);
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
