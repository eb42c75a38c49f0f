// In virtual time: what a client of Foxglove's protocol does passes the guards of the page.

#include "musher/view/foxglove/foxglove_server.hpp"

#include <gmock/gmock.h>

#include <cstring>

#include "musher/messages/action_msgs/cancel_goal.hpp"
#include "musher/messages/geometry_msgs/geometry.hpp"
#include "musher/messages/lifecycle_msgs/services.hpp"
#include "musher/messages/musher_msgs/actuator_command.hpp"
#include "musher/messages/musher_msgs/behavior.hpp"
#include "musher/messages/musher_msgs/machine_services.hpp"
#include "musher/messages/musher_msgs/policy_request.hpp"
#include "musher/messages/musher_msgs/skill_feedback.hpp"
#include "musher/messages/musher_msgs/tree.hpp"
#include "musher/messages/protocol/motion.hpp"
#include "musher/messages/std_msgs/string.hpp"
#include "musher/transport/service.hpp"
#include "musher/transport/sim/network.hpp"
#include "musher/view/foxglove/call_guard.hpp"

namespace musher::view::foxglove::foxglove_server_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

class Socket : public http::WebSocket {
 public:
  void Send(std::shared_ptr<const std::string> message, bool binary) override {
    (binary ? replies : texts).push_back(*message);
  }
  std::size_t queued_bytes() const override { return 0; }
  void Ping(std::string payload) override {
    if (answer_ping) answer_ping(payload);
  }
  void Close(unsigned /*code*/, std::string /*reason*/) override {}
  const http::Request& request() const override { return request_; }
  const std::string& subprotocol() const override { return subprotocol_; }

  std::vector<std::string> texts;
  std::vector<std::string> replies;                             // of services
  std::function<void(const std::string& payload)> answer_ping;  // empty: its link is lost

 private:
  http::Request request_;
  std::string subprotocol_ = kSubprotocol;
};

class AFoxgloveClient : public ::testing::Test {
 protected:
  AFoxgloveClient() {
    set_state_ = transport::MakeServer<msg::SetState>(
                     *robot_, "musher/set_state",
                     [this](const msg::SetState::Request& request, auto reply) {
                       switches_.push_back(request.machine + " " + request.machine_id + " " +
                                           request.target);
                       reply({});
                     })
                     .value();
    pause_ = transport::MakeServer<msg::PauseSkill>(
                 *robot_, "dog/pause_skill",
                 [this](const msg::PauseSkill::Request& request, auto reply) {
                   pauses_.push_back(request.pause);
                   reply({true, ""});
                 })
                 .value();
    chat_ = transport::MakeSubscription<msg::String>(
                *robot_, "chat",
                [this](const msg::String& text, const transport::SampleInfo&) {
                  chats_.push_back(text.data);
                })
                .value();
    Offer(1, "dog/pause_skill", "musher_msgs::srv::dds_::PauseSkill_");
    Offer(2, "musher/set_state", "musher_msgs::srv::dds_::SetState_");
    Offer(3, "dog/musher_command", "musher_msgs::srv::dds_::ActuatorCommand_");
    server_.OnServicesChanged();  // its ids are 1 and more, by name
    handlers_ = server_.OnWebSocket(socket_, [this] { return may_act_; });
    socket_->answer_ping = handlers_.on_pong;
    network_.RunFor(std::chrono::seconds(1));
  }

  FoxgloveServer::Guards Guards() {
    FoxgloveServer::Guards guards;
    guards.leader = [this]() -> std::optional<FoxgloveServer::Leader> {
      if (!leads_) return std::nullopt;
      return FoxgloveServer::Leader{{"robot", "1234"}, robot_->participant()};
    };
    guards.why_not_meant = [this] { return not_meant_; };
    guards.why_not_published = [this](const std::string&) { return not_published_; };
    guards.check_servers = [this](const std::string& actuator, const auto& /*servers*/,
                                  const std::function<void(FoxgloveServer::WhyNot)>& then) {
      checked_.push_back(actuator);
      then(not_sent_);
    };
    guards.uptime_ms = [this] { return UptimeMs(); };
    guards.why_late = [this](std::int64_t seen_ms) -> FoxgloveServer::WhyNot {
      if (UptimeMs() - seen_ms <= 5000) return std::nullopt;
      return Error{kCodeStateInvalid, "the request is late"};
    };
    guards.only_lowers = [](const std::string& state, const std::string& /*actuator*/) {
      return state == "DeActive";
    };
    guards.counts = [this](transport::ParticipantId server, const auto&) {
      return server != not_meant_server_;
    };
    return guards;
  }
  std::int64_t UptimeMs() const { return ToMilliseconds(network_.now().time_since_epoch()); }
  // What follows was sent by the client before a wifi was lost for half a minute.
  void LoseLink() {
    socket_->answer_ping = nullptr;
    network_.RunFor(std::chrono::seconds(30));
  }
  void AdvertiseTopic(const std::string& topic, const std::string& type) {
    handlers_.on_message(R"({"op":"advertise","channels":[{"id":5,"topic":")" + topic +
                             R"(","encoding":"cdr","schemaName":")" + type + R"("}]})",
                         false);
    network_.RunFor(std::chrono::seconds(1));
  }
  void Offer(std::uint64_t id, const std::string& name, const std::string& type) {
    transport::DiscoveredEndpoint endpoint;
    endpoint.id = transport::EndpointId(id);
    endpoint.topic = "rq/" + name + "Request";
    endpoint.type = type + "Request_";
    server_.OnFound(endpoint);
  }
  // The number of a service, as it was advertised.
  std::uint32_t IdOf(const std::string& name) const {
    for (const std::string& text : socket_->texts) {
      const std::size_t at = text.find(R"("name":"/)" + name + '"');
      if (at == std::string::npos) continue;
      const std::size_t id = text.rfind(R"("id":)", at);
      return static_cast<std::uint32_t>(std::stoul(text.substr(id + 5)));
    }
    ADD_FAILURE() << name << " is not advertised";
    return 0;
  }
  static std::string Number(std::uint32_t number) {
    std::string bytes(sizeof(number), '\0');
    std::memcpy(bytes.data(), &number, sizeof(number));  // little-endian, as the protocol
    return bytes;
  }
  // The fields of a request in CDR, which begin with those of its id.
  template <class Request>
  static std::string Cdr(const Request& request) {
    const msg::Bytes bytes = transport::internal::EncodeEnvelope(msg::RequestId{}, request);
    const std::string all(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    return all.substr(0, 4) + all.substr(20);
  }
  template <class Request>
  void Call(const std::string& service, const Request& request) {
    handlers_.on_message(
        '\2' + Number(IdOf(service)) + Number(7) + Number(3) + "cdr" + Cdr(request), true);
    network_.RunFor(std::chrono::seconds(2));
  }
  void Publish(const std::string& text) {
    const msg::Bytes bytes = msg::Encode(msg::String{text});
    handlers_.on_message(
        '\1' + Number(5) + std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()),
        true);
    network_.RunFor(std::chrono::seconds(2));
  }

  transport::sim::Network network_{1};
  std::unique_ptr<transport::Node> robot_ = network_.MakeNode("robot");
  std::unique_ptr<transport::Node> desk_ = network_.MakeNode("desk");
  std::vector<std::string> switches_;
  std::vector<bool> pauses_;
  std::vector<std::string> chats_;
  std::unique_ptr<transport::Server<msg::SetState>> set_state_;
  std::unique_ptr<transport::Server<msg::PauseSkill>> pause_;
  std::unique_ptr<transport::Subscription> chat_;
  bool may_act_ = true;
  bool leads_ = true;
  FoxgloveServer::WhyNot not_meant_;
  transport::ParticipantId not_meant_server_ = 0;
  FoxgloveServer::WhyNot not_published_;
  FoxgloveServer::WhyNot not_sent_;
  std::vector<std::string> checked_;  // actuators whose servers were
  TopicTable table_;
  FoxgloveServer server_{*desk_, table_, {"robot", "", Guards()}};
  std::shared_ptr<Socket> socket_ = std::make_shared<Socket>();
  http::WebSocketHandlers handlers_;
};

// It was obeyed by the controller of each machine of the namespace.
TEST_F(AFoxgloveClient, CallsTheMachineThatIsFollowed) {
  Call("musher/set_state", msg::SetState::Request{"DeActive", "", "", "", ""});
  EXPECT_THAT(switches_, ElementsAre("robot 1234 DeActive"));
  EXPECT_THAT(socket_->replies, SizeIs(1));
}

TEST_F(AFoxgloveClient, CallsNoOtherMachine) {
  Call("musher/set_state", msg::SetState::Request{"DeActive", "", "", "robot", "5678"});
  EXPECT_THAT(switches_, IsEmpty());
  EXPECT_THAT(socket_->texts.back(), HasSubstr("is followed. Nothing was done"));
}

TEST_F(AFoxgloveClient, CallsNothingWhereAnotherMachineMayBeMeant) {
  not_meant_ = Error{kCodeTargetBusy, "several machines are named robot"};
  Call("musher/set_state", msg::SetState::Request{"DeActive", "", "", "", ""});
  EXPECT_THAT(switches_, IsEmpty());
  EXPECT_THAT(socket_->texts.back(), HasSubstr("several machines are named robot"));
}

TEST_F(AFoxgloveClient, SwitchesNoMachineOfAnotherNamespace) {
  Offer(4, "other/musher/set_state", "musher_msgs::srv::dds_::SetState_");
  server_.OnServicesChanged();
  Call("other/musher/set_state", msg::SetState::Request{"DeActive", "", "", "", ""});
  EXPECT_THAT(socket_->texts.back(), HasSubstr("is of another namespace"));
}

TEST_F(AFoxgloveClient, SwitchesNothingWhileNoControllerLeads) {
  leads_ = false;
  Call("musher/set_state", msg::SetState::Request{"DeActive", "", "", "", ""});
  EXPECT_THAT(switches_, IsEmpty());
  EXPECT_THAT(socket_->texts.back(), HasSubstr("no controller leads"));
}

// The login was looked at when the socket was opened, and 12 hours later it still acted.
TEST_F(AFoxgloveClient, ActsNoMoreOnceItsLoginHasEnded) {
  handlers_.on_message(R"({"op":"advertise","channels":[{"id":5,"topic":"/chat","encoding":"cdr",)"
                       R"("schemaName":"std_msgs/msg/String"}]})",
                       false);
  network_.RunFor(std::chrono::seconds(1));
  Publish("before");
  may_act_ = false;
  Publish("after");
  EXPECT_THAT(socket_->texts.back(), HasSubstr("/chat is not published: publishing needs a login"));
  Call("musher/set_state", msg::SetState::Request{"DeActive", "", "", "", ""});
  EXPECT_THAT(socket_->texts.back(), HasSubstr("needs a login"));
  EXPECT_THAT(chats_, ElementsAre("before"));
  EXPECT_THAT(switches_, IsEmpty());
}

TEST_F(AFoxgloveClient, PublishesNothingThatAnotherMachineReceivesAndSaysSoOnce) {
  handlers_.on_message(R"({"op":"advertise","channels":[{"id":5,"topic":"/chat","encoding":"cdr",)"
                       R"("schemaName":"std_msgs/msg/String"}]})",
                       false);
  network_.RunFor(std::chrono::seconds(1));
  not_published_ = Error{kCodeTargetBusy, "other receives it"};
  const std::size_t before = socket_->texts.size();
  Publish("one");
  Publish("two");
  EXPECT_THAT(chats_, IsEmpty());
  EXPECT_EQ(socket_->texts.size(), before + 1);
  EXPECT_THAT(socket_->texts.back(), HasSubstr("other receives it"));
  not_published_ = std::nullopt;
  Publish("three");
  EXPECT_THAT(chats_, ElementsAre("three"));
}

TEST_F(AFoxgloveClient, PausesAlwaysAndResumesOnlyTheMachineThatIsMeant) {
  not_sent_ = Error{kCodeTargetBusy, "dog is an actuator of several machines"};
  Call("dog/pause_skill", msg::PauseSkill::Request{"jump", false});
  EXPECT_THAT(pauses_, IsEmpty());
  EXPECT_THAT(checked_, ElementsAre("dog"));
  EXPECT_THAT(socket_->texts.back(), HasSubstr("several machines"));
  not_meant_ = Error{kCodeTargetBusy, "several machines are named robot"};
  Call("dog/pause_skill", msg::PauseSkill::Request{"jump", true});
  EXPECT_THAT(pauses_, ElementsAre(true));
}

// A switch up was obeyed half a minute after the person had pressed it.
TEST_F(AFoxgloveClient, SwitchesNothingUpThatALostLinkHasHeldUp) {
  LoseLink();
  Call("musher/set_state", msg::SetState::Request{"Active", "", "", "", ""});
  EXPECT_THAT(switches_, IsEmpty());
  EXPECT_THAT(socket_->texts.back(), HasSubstr("the request is late"));
  Call("musher/set_state", msg::SetState::Request{"DeActive", "", "", "", ""});
  EXPECT_THAT(switches_, ElementsAre("robot 1234 DeActive")) << "that one only lowers";
  socket_->answer_ping = handlers_.on_pong;
  network_.RunFor(std::chrono::seconds(2));
  Call("musher/set_state", msg::SetState::Request{"Active", "", "", "", ""});
  EXPECT_THAT(switches_, SizeIs(2)) << "its link is back";
}

TEST_F(AFoxgloveClient, PausesAndDoesNotResumeByWhatALostLinkHasHeldUp) {
  LoseLink();
  Call("dog/pause_skill", msg::PauseSkill::Request{"jump", false});
  EXPECT_THAT(pauses_, IsEmpty());
  Call("dog/pause_skill", msg::PauseSkill::Request{"jump", true});
  EXPECT_THAT(pauses_, ElementsAre(true));
}

TEST_F(AFoxgloveClient, PublishesNothingButAStopThatALostLinkHasHeldUp) {
  AdvertiseTopic("/chat", "std_msgs/msg/String");
  LoseLink();
  Publish("START");
  EXPECT_THAT(chats_, IsEmpty());
  EXPECT_THAT(socket_->texts.back(), HasSubstr("the request is late"));
  Publish("STOP");
  EXPECT_THAT(chats_, ElementsAre("STOP"));
}

class ACancellationByFoxglove : public AFoxgloveClient {
 protected:
  using Server = std::unique_ptr<transport::Server<msg::CancelGoal>>;
  static Server Serve(transport::Node& node, std::int8_t return_code, Duration after) {
    return transport::MakeServer<msg::CancelGoal>(
               node, "dog/walk/_action/cancel_goal",
               [&node, return_code, after, timer = std::make_shared<transport::LoopHandlePtr>()](
                   const msg::CancelGoal::Request&, auto reply) {
                 *timer = node.loop().At(node.loop().Now() + after, [reply, return_code] {
                   msg::CancelGoal::Response response;
                   response.return_code = return_code;
                   reply(response);
                 });
               })
        .value();
  }
  // The code of the reply.
  int Cancel(const msg::CancelGoal::Request& request) {
    Offer(5, "dog/walk/_action/cancel_goal", "action_msgs::srv::dds_::CancelGoal_");
    server_.OnServicesChanged();
    LoseLink();  // a cancellation is never too late
    Call("dog/walk/_action/cancel_goal", request);
    if (socket_->replies.size() != 1) return -1;
    const std::string& reply = socket_->replies[0];
    return reply.at(reply.find("cdr") + 3 + 4);  // after the header of CDR
  }

  const std::shared_ptr<transport::Node> other_ = network_.MakeNode("other");
};

// The first reply was that of a server which does not run the goal.
TEST_F(ACancellationByFoxglove, GetsTheReplyOfTheServerThatRunsTheGoal) {
  const auto first = Serve(*other_, msg::CancelGoal::kErrorUnknownGoalId, Milliseconds(0));
  const auto second = Serve(*robot_, msg::CancelGoal::kErrorNone, Milliseconds(500));
  msg::CancelGoal::Request request;
  request.goal_info.goal_id.uuid[0] = 7;
  EXPECT_EQ(Cancel(request), msg::CancelGoal::kErrorNone);
}

// Another robot's server has cancelled its own goals, and was the first to reply.
TEST_F(ACancellationByFoxglove, OfAllGoalsGetsTheReplyOfTheServerThatIsMeant) {
  const auto first = Serve(*other_, msg::CancelGoal::kErrorNone, Milliseconds(0));
  const auto second = Serve(*robot_, msg::CancelGoal::kErrorRejected, Milliseconds(500));
  not_meant_server_ = other_->participant();
  EXPECT_EQ(Cancel({}), msg::CancelGoal::kErrorRejected);
}

template <class S>
bool IsNeverTooLate(const typename S::Request& request, bool lowers = false) {
  return IsNeverLate(S::kTypeName, transport::internal::EncodeEnvelope(msg::RequestId{}, request),
                     [lowers](const std::string&, const std::string&) { return lowers; });
}

TEST(ACallOfFoxglove, IsNeverTooLateWhereItReadsStopsCancelsOrLowers) {
  EXPECT_TRUE(IsNeverTooLate<msg::GetPlan>({}));
  EXPECT_TRUE(IsNeverTooLate<msg::CancelGoal>({}));
  EXPECT_TRUE(IsNeverTooLate<msg::CancelSkill>({}));
  EXPECT_TRUE(IsNeverTooLate<msg::SetState>({}, true));
  EXPECT_FALSE(IsNeverTooLate<msg::SetState>({}, false));
  EXPECT_FALSE(IsNeverTooLate<msg::ReleaseEmergencyStop>({}));
  EXPECT_FALSE(IsNeverTooLate<msg::RestartActuator>({}));
  EXPECT_TRUE(IsNeverTooLate<msg::SendCommand>({"STOP"}));
  EXPECT_TRUE(IsNeverTooLate<msg::SendCommand>({"stop"})) << "the wedding takes it";
  EXPECT_FALSE(IsNeverTooLate<msg::SendCommand>({"START"}));
  msg::RequestPolicy::Request policy;
  policy.request = "power-off";
  EXPECT_TRUE(IsNeverTooLate<msg::RequestPolicy>(policy));
  for (const char* request : {"wake-up", "keep", "low-power", "low-power-store"}) {
    policy.request = request;
    EXPECT_FALSE(IsNeverTooLate<msg::RequestPolicy>(policy)) << request;
  }
  policy.enable = true;
  EXPECT_TRUE(IsNeverTooLate<msg::RequestPolicy>(policy)) << "stores that it goes to LowPower";
}

TEST(ACallOfFoxglove, OfAMotionOrATransitionMayBeTooLateUnlessItStopsOrEnds) {
  msg::MotionResultCmd::Request motion;
  EXPECT_TRUE(IsNeverTooLate<msg::MotionResultCmd>(motion)) << "0: its emergency stop";
  motion.motion_id = 111;
  EXPECT_FALSE(IsNeverTooLate<msg::MotionResultCmd>(motion));
  msg::ChangeState::Request change;
  change.transition.label = "activate";
  EXPECT_FALSE(IsNeverTooLate<msg::ChangeState>(change));
  change.transition.label = "deactivate";
  EXPECT_TRUE(IsNeverTooLate<msg::ChangeState>(change));
  change.transition = {3, ""};
  EXPECT_FALSE(IsNeverTooLate<msg::ChangeState>(change));
  change.transition = {4, ""};
  EXPECT_TRUE(IsNeverTooLate<msg::ChangeState>(change));
}

// The stop of a program and that of a body by a gait were refused, and both went on.
TEST(ACallOfFoxglove, IsNeverTooLateWhereItStopsAProgramOrTheBodyByAGait) {
  msg::ManageProgram::Request program;
  for (const std::uint8_t operation : {msg::ManageProgram::kList, msg::ManageProgram::kStop}) {
    program.operation = operation;
    EXPECT_TRUE(IsNeverTooLate<msg::ManageProgram>(program)) << int{operation};
  }
  program.operation = msg::ManageProgram::kRun;
  EXPECT_FALSE(IsNeverTooLate<msg::ManageProgram>(program));
  msg::MotionCustomCmd::Request gait;
  gait.cmd_type = msg::MotionCustomCmd::kExecution;
  EXPECT_TRUE(IsNeverTooLate<msg::MotionCustomCmd>(gait)) << "0: its emergency stop";
  gait.motion_id = 400;
  EXPECT_FALSE(IsNeverTooLate<msg::MotionCustomCmd>(gait));
}

template <class M>
bool IsMessageNeverTooLate(const M& message) {
  return IsMessageNeverLate(M::kTypeName, msg::Encode(message));
}

TEST(AMessageOfFoxglove, MayBeTooLateUnlessItStops) {
  msg::Twist twist;
  EXPECT_TRUE(IsMessageNeverTooLate(twist));
  twist.linear.x = 0.3;
  EXPECT_FALSE(IsMessageNeverTooLate(twist));
  msg::TwistStamped stamped;
  EXPECT_TRUE(IsMessageNeverTooLate(stamped));
  stamped.twist = twist;
  EXPECT_FALSE(IsMessageNeverTooLate(stamped));
  msg::MotionServoCmd servo;
  servo.motion_id = 303;
  servo.cmd_type = msg::MotionServoCmd::kData;
  EXPECT_FALSE(IsMessageNeverTooLate(servo));
  servo.cmd_type = msg::MotionServoCmd::kEnd;
  EXPECT_TRUE(IsMessageNeverTooLate(servo));
}

TEST_F(AFoxgloveClient, CommandsNoActuatorBesideTheController) {
  Call("dog/musher_command", msg::ActuatorCommand::Request{});
  EXPECT_THAT(socket_->texts.back(), HasSubstr("by the controller alone; call /musher/set_state"));
}

}  // namespace musher::view::foxglove::foxglove_server_test
