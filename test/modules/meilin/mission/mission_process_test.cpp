// musher-meilin as a planner and the robot's action servers use it: the real program over DDS.

#include <gmock/gmock.h>
#include <zmq.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <fstream>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "musher/base/files.hpp"
#include "musher/messages/action_of_motion_interfaces/move_to_pose.hpp"
#include "musher/messages/geometry_msgs/geometry.hpp"
#include "musher/messages/r2_interfaces/arm_action.hpp"
#include "musher/messages/r2_interfaces/get_action_seq.hpp"
#include "musher/messages/r2_interfaces/spear_action.hpp"
#include "musher/messages/r2_interfaces/start_autonomy.hpp"
#include "musher/messages/r2_interfaces/suspension_control.hpp"
#include "musher/messages/std_msgs/basic.hpp"
#include "musher/messages/std_msgs/string.hpp"
#include "musher/modules/meilin/mission/plan_topic.hpp"
#include "musher/modules/meilin/plan/action_sequence.hpp"
#include "musher/test/application/groot2_client.hpp"
#include "musher/test/modules/module_process.hpp"
#include "musher/test/support/domain.hpp"
#include "musher/test/support/paths.hpp"
#include "musher/transport/action.hpp"

namespace musher::meilin::mission_process_test {

using ::testing::HasSubstr;

// An action server that ends each goal at once, or accepts it and never ends it.
template <msg::Action A>
class Peer {
 public:
  Peer(transport::Node& node, const std::string& name) {
    transport::ActionHandlers<A> handlers;
    handlers.start = [this, &node](transport::ServerGoal<A> goal) {
      goals.push_back(goal.goal());
      came.push_back(node.loop().Now());
      if (silent) {
        kept_.push_back(std::move(goal));
        return;
      }
      typename A::Result result{};
      result.success = true;
      result.message = "done";
      goal.Succeed(result);
    };
    handlers.cancel = [this](transport::ServerGoal<A> goal) {
      ++cancelled;
      if (!deaf) goal.Canceled({});
    };
    server_ = transport::MakeActionServer<A>(node, name, std::move(handlers)).value();
  }

  bool silent = false;
  bool deaf = false;  // a cancelled goal does not end
  int cancelled = 0;
  std::vector<typename A::Goal> goals;
  std::vector<Time> came;  // when each of them did

 private:
  std::vector<transport::ServerGoal<A>> kept_;
  std::unique_ptr<transport::ActionServer<A>> server_;
};

class MissionProcess : public test::ModuleProcess {
 protected:
  MissionProcess()
      : ModuleProcess("meilin", "musher-meilin",
                      {"SetUp", "TearDown", "SelfCheck", "Active", "Protected"}),
        moves_(peer_.node(), "move_to_pose"),
        suspension_(peer_.node(), "suspension_control"),
        arm_(std::in_place, peer_.node(), "arm_action"),
        spear_(peer_.node(), "spear_action") {
    Follow("meilin/state", state_);
    Follow("meilin/last_error", last_error_);
    Follow("meilin/plan_id", plan_id_);
    Follow("meilin/status", status_);
    plans_ = Publisher<msg::Float32MultiArray>("mf_action_seq", transport::kLatchedQos);
    segments_ = Publisher<msg::String>("planning/segments", transport::kLatchedQos);
    poses_ = Publisher<msg::PoseStamped>("transformed/pose");
  }
  void Follow(const std::string& topic, std::string& text) {
    Subscribe<msg::String>(
        topic, [&text](const msg::String& sample) { text = sample.data; }, transport::kLatchedQos);
  }
  static std::string StageFile() { return SourceDir() + "/config/meilin/meilin_stage.xml"; }
  void StartMatch(const std::string& tree, const std::string& keys = "") {
    ASSERT_NO_FATAL_FAILURE(StartWaiting(tree, keys));
    ASSERT_EQ(Begin("full"), "begins with the region full");
  }
  // The word of a person; the reply.
  std::string Begin(const std::string& region) {
    const auto client =
        transport::MakeClient<msg::StartAutonomy>(peer_.node(), "start_autonomy").value();
    std::optional<std::string> reply;
    EXPECT_TRUE(peer_.Until([&] { return client->Ready(); }));
    client->Call({region}, std::chrono::seconds(120), [&reply](const auto& result) {
      reply = result ? result.value().message : result.error().message;
    });
    EXPECT_TRUE(peer_.Until([&] { return reply.has_value(); }));
    return reply.value_or("");
  }
  void StartWaiting(const std::string& tree, const std::string& keys = "") {
    ASSERT_NO_FATAL_FAILURE(Start("tree_file = \"" + tree + "\"\n" + keys));
    ASSERT_TRUE(peer_.Switch("SelfCheck")) << peer_.Output();
    ASSERT_TRUE(peer_.Switch("Active")) << peer_.Output();
  }
  // Until the match is in that state.
  void Await(const std::string& state) {
    ASSERT_TRUE(peer_.Until([&] { return state_ == state; }))
        << state_ << " " << last_error_ << "\n"
        << peer_.Output();
  }
  // The reason and the plan are on topics of their own, which may come later than the state.
  bool AwaitError(const std::string& part) {
    return peer_.Until([&] { return last_error_.find(part) != std::string::npos; });
  }
  bool AwaitPlan(const std::string& id) {
    return peer_.Until([&] { return plan_id_ == id; });
  }
  // Until the progress on the disk has this: a process is killed then.
  bool AwaitProgress(const std::string& part) {
    const auto looks = peer_.node().loop().Every(Milliseconds(20), [] {});
    return peer_.Until([&] {
      return ReadFile(peer_.folder() / "state/meilin_progress.toml").find(part) !=
             std::string::npos;
    });
  }
  // To (0, 1), up to (1, 1), and the box of (2, 1), 200 mm above it on both sides.
  static msg::Float32MultiArray Plan() {
    return ToActionSequence(
        {{false, {0, 1}, 0, 0}, {false, {1, 1}, 200, 0}, {true, {2, 1}, 200, 0}});
  }
  // A number of meilin/status; -1: it is not there.
  int InStatus(const std::string& key) const {
    const auto status = nlohmann::json::parse(status_, nullptr, /*allow_exceptions=*/false);
    return status.is_object() ? status.value(key, -1) : -1;
  }
  void SendPose(double x_m, double y_m) {
    msg::PoseStamped pose;
    pose.header.frame_id = "map";
    pose.pose.position = {x_m, y_m, 0};
    pose.pose.orientation.w = 1;
    EXPECT_TRUE(poses_->Publish(pose));
  }

  std::string state_;
  std::string last_error_;
  std::string plan_id_;
  std::string status_;
  Peer<msg::MoveToPose> moves_;
  Peer<msg::SuspensionControl> suspension_;
  std::optional<Peer<msg::ArmAction>> arm_;
  Peer<msg::SpearAction> spear_;
  std::unique_ptr<transport::Publisher<msg::Float32MultiArray>> plans_;
  std::unique_ptr<transport::Publisher<msg::String>> segments_;
  std::unique_ptr<transport::Publisher<msg::PoseStamped>> poses_;
};

TEST_F(MissionProcess, CarriesOutAPlanByTheGoalsOfTheServers) {
  ASSERT_NO_FATAL_FAILURE(StartMatch(StageFile()));
  ASSERT_NO_FATAL_FAILURE(Await("WAITING_MF_ACTION_SEQ"));
  const Time sent = peer_.node().loop().Now();
  ASSERT_TRUE(plans_->Publish(Plan()));
  ASSERT_TRUE(peer_.Until([this] { return !moves_.goals.empty(); })) << peer_.Output();
  RecordProperty("plan_to_goal_us",
                 static_cast<int>((peer_.node().loop().Now() - sent).count() / 1000));
  ASSERT_NO_FATAL_FAILURE(Await("MISSION_SUCCESS"));
  EXPECT_TRUE(AwaitPlan("mf_action_seq_1"));
  ASSERT_EQ(moves_.goals.size(), 3U);
  EXPECT_DOUBLE_EQ(moves_.goals[1].x, 2.4);
  EXPECT_DOUBLE_EQ(moves_.goals[1].y, 2.4);
  EXPECT_NEAR(moves_.goals[2].x, 2.6, 1e-9) << "1 m before the box";
  ASSERT_EQ(suspension_.goals.size(), 2U);
  EXPECT_EQ(suspension_.goals[0].mode, 1) << "up";
  EXPECT_EQ(suspension_.goals[0].height, 200);
  EXPECT_EQ(suspension_.goals[1].mode, 3) << "directly";
  EXPECT_EQ(suspension_.goals[1].height, 230);
  ASSERT_EQ(arm_->goals.size(), 1U);
  EXPECT_EQ(arm_->goals[0].command, 1);
  EXPECT_TRUE(arm_->goals[0].wait_result);
  ExpectTornDown();
}

TEST_F(MissionProcess, RequestsThePlanOfABufferWhereItIsConfigured) {
  int requests = 0;
  int in_plan = 0;  // those from its first goal to its last one
  const auto buffer =
      transport::MakeServer<msg::GetActionSeq>(peer_.node(), "get_action_seq",
                                               [&](const msg::GetActionSeq::Request&, auto reply) {
                                                 ++requests;
                                                 if (!moves_.goals.empty() && arm_->goals.empty()) {
                                                   ++in_plan;
                                                 }
                                                 msg::GetActionSeq::Response response;
                                                 response.has_data = requests == 2;
                                                 if (response.has_data) response.data = Plan();
                                                 reply(response);
                                               })
          .value();
  ASSERT_NO_FATAL_FAILURE(StartMatch(StageFile(), "plan_service = true\n"));
  ASSERT_NO_FATAL_FAILURE(Await("MISSION_SUCCESS"));
  EXPECT_GE(requests, 2);
  EXPECT_EQ(in_plan, 0) << "it does not ask while the plan runs";
  EXPECT_TRUE(AwaitPlan("mf_action_seq_1"));
}

TEST_F(MissionProcess, DoesNotCarryOutAgainWhatItsBufferDoesNotForget) {
  int requests = 0;
  const auto buffer =
      transport::MakeServer<msg::GetActionSeq>(peer_.node(), "get_action_seq",
                                               [&](const msg::GetActionSeq::Request&, auto reply) {
                                                 ++requests;
                                                 reply({Plan(), true});
                                               })
          .value();
  moves_.silent = true;
  ASSERT_NO_FATAL_FAILURE(
      StartMatch(StageFile(), "plan_service = true\nmeilin_default_align_timeout = 3\n"));
  ASSERT_NO_FATAL_FAILURE(Await("MISSION_FAILED"));
  const int before = requests;
  ASSERT_EQ(Begin("meilin"), "begins with the region meilin");
  ASSERT_TRUE(peer_.Until([&] { return requests >= before + 3; })) << peer_.Output();
  EXPECT_EQ(moves_.goals.size(), 1U) << "the robot stands";
  EXPECT_EQ(state_, "WAITING_MF_ACTION_SEQ");
  EXPECT_THAT(peer_.Output(), HasSubstr("get_action_seq hands out a plan that was taken before"));
}

TEST_F(MissionProcess, CarriesOutAnOldPlanAndRefusesADamagedOne) {
  const std::string tree = peer_.folder() / "old.xml";
  std::ofstream(tree) << R"(<root BTCPP_format="4"><BehaviorTree ID="Old">
    <KeepRunningUntilFailure><Sequence>
      <PopNextSegment queue="{segment_queue}" segment_type="{segment_type}" target_x="{x}"
                      target_y="{y}" target_yaw="{yaw}" arm_command="{arm}" timeout_sec="{limit}"/>
      <SwitchSegmentType segment_type="{segment_type}">
        <Align name="ALIGN" target_x="{x}" target_y="{y}" target_yaw="{yaw}"/>
        <ArmAction name="default" command="{arm}" timeout_sec="{limit}"/>
      </SwitchSegmentType>
    </Sequence></KeepRunningUntilFailure></BehaviorTree></root>)";
  ASSERT_NO_FATAL_FAILURE(StartMatch(tree));
  ASSERT_NO_FATAL_FAILURE(Await("MISSION_SUCCESS")) << "nothing to do";
  ASSERT_TRUE(segments_->Publish({R"({"plan_id": "p", "segments": [{"segment_type": "ALING"}]})"}));
  ASSERT_NO_FATAL_FAILURE(Await("PLAN_REJECTED"));
  ASSERT_TRUE(AwaitError("segments[0].segment_type")) << last_error_;
  ASSERT_TRUE(segments_->Publish({R"({"stage": "MF", "plan_id": "seven", "segments": [
    {"segment_type": "ALIGN", "move_target": {"x": 1.5, "y": -2, "yaw": 3.14159265358979}},
    {"segment_type": "GRASP", "arm_command": 1}]})"}));
  EXPECT_TRUE(AwaitPlan("seven"));
  ASSERT_TRUE(peer_.Until([this] { return !arm_->goals.empty(); })) << peer_.Output();
  ASSERT_NO_FATAL_FAILURE(Await("MISSION_SUCCESS"));
  ASSERT_EQ(moves_.goals.size(), 1U);
  EXPECT_EQ(moves_.goals[0].y, -2);
  EXPECT_NEAR(moves_.goals[0].yaw_deg, 180, 1e-6);
  EXPECT_EQ(arm_->goals.size(), 1U);
}

TEST_F(MissionProcess, ThatIsKilledGoesOnWithAnOldPlanOnCommand) {
  const std::string tree = SourceDir() + "/config/meilin/segments.xml";
  arm_->silent = true;
  ASSERT_NO_FATAL_FAILURE(StartMatch(tree));
  ASSERT_TRUE(segments_->Publish({R"({"plan_id": "seven", "segments": [
    {"segment_type": "ALIGN", "move_target": {"x": 1.2, "y": 1.2}},
    {"segment_type": "GRASP"}]})"}));
  ASSERT_TRUE(peer_.Until([this] { return !arm_->goals.empty(); })) << peer_.Output();
  ASSERT_TRUE(AwaitProgress("next = 1\n"));
  ASSERT_TRUE(peer_.AwaitStatus([](const auto& report) { return report.state == "Active"; }));
  peer_.Signal(SIGKILL);
  ASSERT_EQ(peer_.AwaitExit(), -SIGKILL);
  arm_->silent = false;
  ASSERT_NO_FATAL_FAILURE(StartWaiting(tree));
  ASSERT_NO_FATAL_FAILURE(Await("WAITING_START"));
  EXPECT_EQ(arm_->goals.size(), 1U);
  EXPECT_EQ(Begin(""), "goes on with plan seven at segment 2 of 2, GRASP");
  ASSERT_NO_FATAL_FAILURE(Await("MISSION_SUCCESS"));
  EXPECT_EQ(arm_->goals.size(), 2U);
  EXPECT_EQ(moves_.goals.size(), 1U) << "what was done is not done again";
}

TEST_F(MissionProcess, AServerThatNeverEndsAGoalFailsTheMatchAndANewPlanGoesOn) {
  moves_.silent = true;
  ASSERT_NO_FATAL_FAILURE(StartMatch(StageFile(), "meilin_default_align_timeout = 3\n"));
  ASSERT_TRUE(plans_->Publish(Plan()));
  ASSERT_NO_FATAL_FAILURE(Await("MISSION_FAILED"));
  ASSERT_TRUE(AwaitError("timed out")) << last_error_;
  EXPECT_TRUE(peer_.Until([this] { return moves_.cancelled == 1; })) << "the robot is to stand";
  moves_.silent = false;
  ASSERT_TRUE(plans_->Publish(Plan()));
  ASSERT_NO_FATAL_FAILURE(Await("MISSION_SUCCESS"));
  EXPECT_TRUE(AwaitPlan("mf_action_seq_2"));
}

TEST_F(MissionProcess, HasItsStateAndTheReasonInOneMessage) {
  std::vector<std::string> all;
  Subscribe<msg::String>(
      "meilin/status", [&all](const msg::String& sample) { all.push_back(sample.data); },
      transport::kLatchedQos);
  moves_.silent = true;
  ASSERT_NO_FATAL_FAILURE(StartMatch(StageFile(), "meilin_default_align_timeout = 3\n"));
  ASSERT_TRUE(plans_->Publish(Plan()));
  ASSERT_NO_FATAL_FAILURE(Await("MISSION_FAILED"));
  ASSERT_TRUE(peer_.Until([&] { return !all.empty() && all.back() == status_; }));
  int failed = 0;
  for (const std::string& status : all) {
    if (status.find("\"MISSION_FAILED\"") == std::string::npos) continue;
    ++failed;
    EXPECT_THAT(status, HasSubstr("\"last_error\":\"segment 1 of 3, move (0, 1): "));
  }
  EXPECT_GE(failed, 1);
}

TEST_F(MissionProcess, AGoalWhoseEndNeverComesDelaysOnlyTheNextOne) {
  moves_.silent = moves_.deaf = true;
  ASSERT_NO_FATAL_FAILURE(StartMatch(StageFile(), "meilin_default_align_timeout = 3\n"));
  ASSERT_TRUE(plans_->Publish(Plan()));
  ASSERT_NO_FATAL_FAILURE(Await("MISSION_FAILED"));
  ASSERT_TRUE(peer_.Until([this] { return moves_.cancelled == 1; }));
  moves_.silent = false;
  std::vector<PlanStep> steps;
  for (const int col : {1, 2, 1, 0, 1, 2}) steps.push_back({false, {0, col}, 0, 0});
  const std::size_t before = moves_.goals.size();
  ASSERT_TRUE(plans_->Publish(ToActionSequence(steps)));
  ASSERT_TRUE(peer_.Until([&] { return moves_.goals.size() > before; })) << peer_.Output();
  ASSERT_NO_FATAL_FAILURE(Await("MISSION_SUCCESS"));
  // The wait for a lost end is a second: a busy computer may make one gap so long, not most of
  // them.
  std::vector<double> gaps_s;
  for (std::size_t i = before + 1; i < moves_.came.size(); ++i) {
    gaps_s.push_back(std::chrono::duration<double>(moves_.came[i] - moves_.came[i - 1]).count());
  }
  ASSERT_GE(gaps_s.size(), 5U);
  std::ranges::sort(gaps_s);
  EXPECT_LT(gaps_s[gaps_s.size() / 2], 1) << ::testing::PrintToString(gaps_s);
}

TEST_F(MissionProcess, LeavingActiveCancelsAndTheHaltedSegmentIsTheNext) {
  moves_.silent = true;
  ASSERT_NO_FATAL_FAILURE(StartMatch(StageFile()));
  ASSERT_TRUE(plans_->Publish(Plan()));
  ASSERT_TRUE(peer_.Until([this] { return !moves_.goals.empty(); })) << peer_.Output();
  ASSERT_TRUE(peer_.Switch("Protected"));
  EXPECT_TRUE(peer_.Until([this] { return moves_.cancelled == 1; })) << peer_.Output();
  ASSERT_NO_FATAL_FAILURE(Await("PAUSED"));
  moves_.silent = false;
  ASSERT_TRUE(peer_.Switch("Active"));
  ASSERT_NO_FATAL_FAILURE(Await("MISSION_SUCCESS"));
  ASSERT_EQ(moves_.goals.size(), 4U);
  EXPECT_EQ(moves_.goals[0], moves_.goals[1]);
}

// A client of Groot2's protocol that has set a breakpoint and is lost: from then on it is silent.
void SetABreakpointAndBeLost(int port) {
  void* const context = zmq_ctx_new();
  void* const socket = zmq_socket(context, ZMQ_REQ);
  const int linger = 0;
  const int timeout_ms = 120'000;
  zmq_setsockopt(socket, ZMQ_LINGER, &linger, sizeof linger);
  zmq_setsockopt(socket, ZMQ_RCVTIMEO, &timeout_ms, sizeof timeout_ms);
  zmq_connect(socket, ("tcp://127.0.0.1:" + std::to_string(port)).c_str());
  const groot2::Parts reply =
      groot2::Ask(socket, {groot2::Header('I'), groot2::HookJson(1, 0, "SKIPPED")});
  EXPECT_EQ(reply.size(), 1U) << "a second part would be an error";
  zmq_close(socket);
  zmq_ctx_term(context);
}

TEST_F(MissionProcess, ThatLosesItsDebuggerCancelsItsGoalAndStandsUntilItsStart) {
  const int port = 25'000 + 2 * transport::TestDomain();
  moves_.silent = true;
  ASSERT_NO_FATAL_FAILURE(
      StartMatch(StageFile(), "groot2_port = " + std::to_string(port) + "\ngroot2_hooks = true\n"));
  ASSERT_TRUE(plans_->Publish(Plan()));
  ASSERT_TRUE(peer_.Until([this] { return !moves_.goals.empty(); })) << peer_.Output();
  SetABreakpointAndBeLost(port);
  EXPECT_TRUE(peer_.Until([this] { return moves_.cancelled == 1; })) << peer_.Output();
  ASSERT_NO_FATAL_FAILURE(Await("WAITING_START"));
  ASSERT_TRUE(AwaitOutput("Groot2 is lost, and it had hooks: halted until musher-meilin start"))
      << peer_.Output();
  EXPECT_EQ(moves_.goals.size(), 1U);
  moves_.silent = false;
  EXPECT_EQ(Begin(""), "goes on with plan mf_action_seq_1 at segment 1 of 3, move (0, 1)");
  ASSERT_NO_FATAL_FAILURE(Await("MISSION_SUCCESS"));
  ASSERT_EQ(moves_.goals.size(), 4U);
  EXPECT_EQ(moves_.goals[0], moves_.goals[1]) << "the move that was halted is not done";
}

TEST_F(MissionProcess, ThatIsKilledStandsAndGoesOnOnlyOnCommand) {
  moves_.silent = true;
  ASSERT_NO_FATAL_FAILURE(StartMatch(StageFile()));
  ASSERT_TRUE(plans_->Publish(Plan()));  // latched: the next process receives it, too
  ASSERT_TRUE(peer_.Until([this] { return !moves_.goals.empty(); })) << peer_.Output();
  ASSERT_TRUE(AwaitProgress("begun = true\n"));
  // So that the status of the next process is known from this one's.
  ASSERT_TRUE(peer_.AwaitStatus([](const auto& report) { return report.state == "Active"; }));
  peer_.Signal(SIGKILL);
  ASSERT_EQ(peer_.AwaitExit(), -SIGKILL);
  moves_.silent = false;
  const std::size_t before = moves_.goals.size();
  ASSERT_NO_FATAL_FAILURE(StartWaiting(StageFile()));
  ASSERT_NO_FATAL_FAILURE(Await("WAITING_START"));
  ASSERT_TRUE(AwaitOutput("a plan that was taken before is not taken again")) << peer_.Output();
  EXPECT_THAT(Begin("rack"), HasSubstr("expected full, meilin or final"));
  EXPECT_EQ(moves_.goals.size(), before);
  EXPECT_THAT(status_, HasSubstr("plan mf_action_seq_1 at segment 1 of 3, move (0, 1)"));
  EXPECT_THAT(Begin(""), HasSubstr("goes on with plan mf_action_seq_1"));
  ASSERT_NO_FATAL_FAILURE(Await("MISSION_SUCCESS"));
  EXPECT_TRUE(AwaitPlan("mf_action_seq_1"));
}

TEST_F(MissionProcess, AStartRightAfterARestartInAClimbWaitsForTheFirstPose) {
  suspension_.silent = true;
  ASSERT_NO_FATAL_FAILURE(StartMatch(StageFile()));
  ASSERT_TRUE(plans_->Publish(Plan()));
  ASSERT_TRUE(peer_.Until([this] { return !suspension_.goals.empty(); })) << peer_.Output();
  ASSERT_TRUE(peer_.AwaitStatus([](const auto& report) { return report.state == "Active"; }));
  peer_.Signal(SIGKILL);
  ASSERT_EQ(peer_.AwaitExit(), -SIGKILL);
  ASSERT_NO_FATAL_FAILURE(StartWaiting(StageFile()));
  const auto client =
      transport::MakeClient<msg::StartAutonomy>(peer_.node(), "start_autonomy").value();
  ASSERT_TRUE(peer_.Until([&] { return client->Ready() && poses_->MatchedReaders() > 0; }));
  std::string reply;
  client->Call({"meilin"}, std::chrono::seconds(120), [&reply](const auto& result) {
    reply = result ? result.value().message : result.error().message;
  });
  const auto poses = peer_.node().loop().Every(Milliseconds(50), [this] { SendPose(1.2, 2.4); });
  ASSERT_TRUE(peer_.Until([&] { return !reply.empty(); }));
  EXPECT_EQ(reply, "begins with the region meilin");
}

TEST_F(MissionProcess, RefusesAnOldPlanThatItsTreeCannotRun) {
  ASSERT_NO_FATAL_FAILURE(StartMatch(StageFile()));
  ASSERT_NO_FATAL_FAILURE(Await("WAITING_MF_ACTION_SEQ"));
  ASSERT_TRUE(segments_->Publish({R"({"plan_id": "7", "segments": [
    {"segment_type": "GRASP", "arm_command": 1}]})"}));
  ASSERT_NO_FATAL_FAILURE(Await("PLAN_REJECTED"));
  EXPECT_TRUE(AwaitError("no node of it is PopNextSegment")) << last_error_;
}

TEST_F(MissionProcess, OfTwoPlansAtOnceTheLaterOneIsCarriedOut) {
  ASSERT_NO_FATAL_FAILURE(StartMatch(StageFile()));
  ASSERT_TRUE(plans_->Publish(Plan()));
  ASSERT_TRUE(plans_->Publish(ToActionSequence({{false, {0, 2}, 0, 0}})));
  EXPECT_TRUE(peer_.Until([this] {
    return state_ == "MISSION_SUCCESS" && !moves_.goals.empty() && moves_.goals.back().y > 3.5;
  })) << state_
      << " " << peer_.Output();
}

TEST_F(MissionProcess, AFreshPoseDecidesWhereAPlanBeginsUnlessItIsNoNumber) {
  ASSERT_NO_FATAL_FAILURE(StartMatch(StageFile(), "meilin_pose_timeout_sec = 0\n"));
  ASSERT_NO_FATAL_FAILURE(Await("WAITING_MF_ACTION_SEQ"));
  ASSERT_TRUE(peer_.Until([this] { return poses_->MatchedReaders() > 0; }));
  // From (1, 1); from the initial cell (0, 0) it is a climb across cells.
  const auto plan = ToActionSequence({{false, {2, 1}, 400, 0}});
  ASSERT_TRUE(plans_->Publish(plan));
  ASSERT_NO_FATAL_FAILURE(Await("PLAN_REJECTED"));
  ASSERT_TRUE(AwaitError("move with height change requires adjacent target grid")) << last_error_;
  // Two topics have no order: until the pose is there the plan is refused. The next one is sent
  // once the last one is decided: a second one that came while the first runs would be checked from
  // its end, (2, 1), and this robot's pose stays.
  int sent = 1;
  const auto decided = [&] { return InStatus("plans") + InStatus("refusals") == sent; };
  ASSERT_TRUE(peer_.Until(decided)) << status_;
  while (InStatus("plans") == 0) {
    ASSERT_LT(sent, 1000) << last_error_;
    SendPose(2.4, 2.4);
    SendPose(std::numeric_limits<double>::quiet_NaN(), 2.4);
    ASSERT_TRUE(plans_->Publish(plan));
    ++sent;
    ASSERT_TRUE(peer_.Until(decided)) << status_;
  }
  ASSERT_NO_FATAL_FAILURE(Await("MISSION_SUCCESS"));
  EXPECT_EQ(suspension_.goals.at(0).height, 200);
}

TEST_F(MissionProcess, FailsItsSelfCheckWhereAServerIsMissing) {
  arm_.reset();
  Start("tree_file = \"" + StageFile() + "\"\nself_check_sec = 0.2\n");
  EXPECT_THAT(Failure("SelfCheck"), HasSubstr("no server of arm_action"));
}

// A match that was begun, on another computer: it cannot know that a plan was written just now.
class AMatchElsewhere : public test::ModuleProcess {
 protected:
  AMatchElsewhere() : ModuleProcess("meilin", "musher-meilin") {
    state_ = Publisher<msg::String>("meilin/state", transport::kLatchedQos);
    status_ = Publisher<msg::String>("meilin/status", transport::kLatchedQos);
    Subscribe<msg::Float32MultiArray>(
        "mf_action_seq", [this](const auto&) { OnPlan(); }, transport::kLatchedQos);
    Publish();
  }
  void OnPlan() {
    came_.push_back(peer_.node().loop().Now());
    refused_ = came_.size() == 1 ? reason_ : "";
    Publish();
  }
  void Publish() {
    const auto plans = static_cast<int>(came_.size());
    const nlohmann::json status = {{"state", "WAITING_MF_ACTION_SEQ"},
                                   {"refused_plan", refused_},
                                   {"plans", refused_.empty() ? plans : 0},
                                   {"refusals", refused_.empty() ? 0 : plans}};
    static_cast<void>(status_->Publish({status.dump()}));
  }
  int SendPlan() {
    return Run({"musher-meilin", "send", "plan", SourceDir() + "/config/meilin/plan_blue.toml"});
  }

  std::string reason_;  // of the refusal of the first plan
  std::string refused_;
  std::vector<Time> came_;
  std::unique_ptr<transport::Publisher<msg::String>> state_;
  std::unique_ptr<transport::Publisher<msg::String>> status_;
};

TEST_F(AMatchElsewhere, GetsThePlanOfTheToolOnceMoreWhereItsSenderHadJustConnected) {
  reason_ = kSenderHasJustConnected;
  EXPECT_EQ(SendPlan(), 0) << Said();
  ASSERT_EQ(came_.size(), 2U) << Said();
  EXPECT_GE(came_[1] - came_[0], PlanSenders::kJustConnected);
}

TEST_F(AMatchElsewhere, GetsThePlanOfTheToolOnceWhereItRefusesIt) {
  reason_ = "there is no way";
  EXPECT_EQ(SendPlan(), 1) << Said();
  EXPECT_EQ(came_.size(), 1U);
  EXPECT_THAT(Said(), HasSubstr("the last plan was refused: there is no way"));
}

}  // namespace musher::meilin::mission_process_test
