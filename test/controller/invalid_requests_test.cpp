// What comes over the wire from unknown clients, from the past, or by mistake: a refusal with a
// code and a reason, and nothing has changed.

#include <gmock/gmock.h>

#include <future>
#include <sstream>
#include <string>
#include <tuple>

#include "musher/actuator/machine_actuator.hpp"
#include "musher/controller/machine_controller.hpp"
#include "musher/lifecycle/record/texts.hpp"
#include "musher/messages/musher_msgs/actuator_command.hpp"
#include "musher/messages/musher_msgs/machine_services.hpp"
#include "musher/messages/musher_msgs/policy_request.hpp"
#include "musher/test/actuator/robot_file.hpp"
#include "musher/test/support/paths.hpp"
#include "musher/test/support/process.hpp"
#include "musher/test/support/refusals.hpp"
#include "musher/transport/service.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher::invalid_requests_test {

using msg::ActuatorCommand;
using msg::GetPlan;
using msg::SetState;
using ::testing::FieldsAre;
using ::testing::HasSubstr;
using testing::IsRefused;
using testing::kAllStates;
using testing::RobotFile;

class InvalidRequests : public ::testing::Test {
 protected:
  InvalidRequests()
      : file_({"arm"}, kAllStates), node_(transport::NodeThread::Start().value()), arm_("arm") {
    arm_.RegisterStateCallback([](const State&) { return kCodeOk; });
    EXPECT_TRUE(arm_.Init(file_.path(), node_).ok());
    EXPECT_TRUE(arm_.Start().ok());
    EXPECT_TRUE(controller_.Init(file_.path(), node_).ok());
    EXPECT_TRUE(controller_.AwaitSetUp().ok());
    EXPECT_TRUE(controller_.Switch("SelfCheck").done());
    EXPECT_TRUE(controller_.Switch("Active").done());
  }
  ~InvalidRequests() override {
    EXPECT_EQ(arm_.CurrentState(), "Active") << "nothing has changed";
    EXPECT_EQ(controller_.GetMachineState(), "Active");
  }

  std::string NameSpace() const { return "test_" + std::to_string(getpid()); }

  // Calls a service from the controller's own participant.
  template <class S>
  typename S::Response Call(const std::string& service, const typename S::Request& request) {
    std::unique_ptr<transport::Client<S>> client;
    std::promise<Result<typename S::Response>> promise;
    node_->RunOnLoop([&] {
      client = transport::MakeClient<S>(node_->node(), service).value();
      client->Call(request, std::chrono::seconds(20), [&](Result<typename S::Response> reply) {
        promise.set_value(std::move(reply));
      });
    });
    const auto reply = promise.get_future().get();
    node_->RunOnLoop([&] { client.reset(); });
    EXPECT_TRUE(reply.ok());
    return reply.ok() ? reply.value() : typename S::Response{};
  }

  SetState::Response Set(const std::string& target, const std::string& actuator = "") {
    return Call<SetState>(transport::MachineService(NameSpace(), "set_state"), {target, actuator});
  }

  // A command as the controller would send it now, but for what the test changes.
  ActuatorCommand::Response Command(std::function<void(ActuatorCommand::Request&)> change) {
    const std::string service = transport::CommandService(NameSpace(), "arm");
    ActuatorCommand::Request query;
    query.kind = ActuatorCommand::kKindQuery;
    query.epoch = 1;
    const auto status = Call<ActuatorCommand>(service, query).status;
    ActuatorCommand::Request request;
    request.kind = ActuatorCommand::kKindSwitch;
    request.epoch = status.epoch;
    request.number = status.number + 1;
    request.target = "LowPower";
    request.budget_ns = Duration(std::chrono::seconds(10)).count();
    request.status_stamp_ns = status.stamp_ns;
    request.incarnation = status.incarnation;
    change(request);
    return Call<ActuatorCommand>(service, request);
  }

  // What a command of another process, with an epoch that is so much ahead, comes to: verdict,
  // code, and the arm's epoch then.
  std::tuple<int, int, std::uint64_t> OfAnUnknownClient(std::uint64_t ahead) const {
    const testing::Ended client =
        testing::RunToEnd({BinDir() + "/controller_unknown_client",
                           transport::CommandService(NameSpace(), "arm"), std::to_string(ahead)});
    std::tuple<int, int, std::uint64_t> said{-1, -1, 0};
    std::istringstream(client.out) >> std::get<0>(said) >> std::get<1>(said) >> std::get<2>(said);
    EXPECT_EQ(client.exit, 0) << client.err;
    return said;
  }

  RobotFile file_;
  std::shared_ptr<transport::NodeThread> node_;
  ActuatorRunner<MachineActuator> arm_;
  MachineController controller_;
};

TEST_F(InvalidRequests, AnUnknownStateIsRefusedAndTheNearestIsNamed) {
  const auto response = Set("Lowpower");
  EXPECT_EQ(response.outcome, "refused");
  EXPECT_EQ(response.code, kCodeParametersInvalid);
  EXPECT_THAT(response.reason, HasSubstr("did you mean 'LowPower'"));
  EXPECT_EQ(response.state, "Active");
}

// A query right after a switch was answered with less than had happened.
TEST_F(InvalidRequests, TheHistoryHasAllEntriesFromBeforeTheRequest) {
  for (std::uint64_t number = 4; number <= 12; number += 2) {
    EXPECT_EQ(Set("LowPower").outcome, "done");
    EXPECT_EQ(Set("Active").outcome, "done");
    const auto history =
        Call<msg::GetHistory>(transport::MachineService(NameSpace(), "get_history"), {0, 1});
    ASSERT_EQ(history.entries.size(), 1U) << history.error;
    const auto done = texts::SwitchEnded(CommandNumber(number), SwitchOutcome::kDone, "");
    EXPECT_EQ(history.entries[0].message, done.message);
  }
}

TEST_F(InvalidRequests, AnUnknownActuatorIsRefused) {
  EXPECT_EQ(Set("Active", "tail").code, kCodeParametersInvalid);
}

TEST_F(InvalidRequests, AStateOutsideTheFlowIsRefused) {
  EXPECT_EQ(Set("SetUp").code, kCodeStateInvalid);
  EXPECT_EQ(Set("Uninitialized").outcome, "refused");
}

TEST_F(InvalidRequests, OversizeStringsAreRefused) {
  const std::string huge(1'000'000, 'x');
  EXPECT_THAT(Set(huge), IsRefused(Refusal::kNameTooLong));
  EXPECT_THAT(Set("Active", huge), IsRefused(Refusal::kNameTooLong));
  const auto plan = Call<GetPlan>(transport::MachineService(NameSpace(), "get_plan"), {huge, ""});
  EXPECT_FALSE(plan.allowed);
  EXPECT_EQ(plan.code, kCodeParametersInvalid);
}

TEST_F(InvalidRequests, ACommandOfAnOldEpochIsRefusedByTheActuator) {
  const auto response = Command([](auto& request) { request.epoch = 0; });
  EXPECT_EQ(response.verdict, ActuatorCommand::kVerdictRefused);
  EXPECT_EQ(response.code, kCodePermissionDenied);
}

TEST_F(InvalidRequests, ACommandOfAnOldNumberIsRefusedByTheActuator) {
  const auto response = Command([](auto& request) { request.number = 1; });
  EXPECT_EQ(response.verdict, ActuatorCommand::kVerdictRefused);
  EXPECT_EQ(response.code, kCodeStatusError);
}

TEST_F(InvalidRequests, AWellFormedCommandOfAnUnauthenticatedParticipantIsRefused) {
  for (const std::uint64_t ahead : {0, 1, 1000}) {
    EXPECT_THAT(OfAnUnknownClient(ahead),
                FieldsAre(ActuatorCommand::kVerdictRefused, kCodePermissionDenied, 1));
  }
}

TEST_F(InvalidRequests, AnEpochThatNoOtherCouldExceedIsRefused) {
  EXPECT_THAT(OfAnUnknownClient(UINT64_MAX),
              FieldsAre(ActuatorCommand::kVerdictRefused, kCodeParametersInvalid, 1));
}

TEST_F(InvalidRequests, ARequestForAnotherMachineIsRefused) {
  SetState::Request request{"LowPower", ""};
  request.machine = "cat";
  const auto response =
      Call<SetState>(transport::MachineService(NameSpace(), "set_state"), request);
  EXPECT_EQ(response.outcome, "refused");
  EXPECT_THAT(response, IsRefused(Refusal::kRequestOfOtherMachine));
  EXPECT_THAT(response.reason, HasSubstr("meant for another machine, cat"));
  GetPlan::Request plan{"LowPower", ""};
  plan.machine = "cat";
  EXPECT_EQ(Call<GetPlan>(transport::MachineService(NameSpace(), "get_plan"), plan).code,
            kCodePermissionDenied);
  const auto restart = Call<msg::RestartActuator>(
      transport::MachineService(NameSpace(), "restart_actuator"), {"arm", "", "cat"});
  EXPECT_EQ(restart.code, kCodePermissionDenied);
}

TEST_F(InvalidRequests, ACommandOfAnotherMachineIsRefusedByTheActuator) {
  const auto response = Command([](auto& request) { request.machine = "cat"; });
  EXPECT_EQ(response.verdict, ActuatorCommand::kVerdictRefused);
  EXPECT_THAT(response, IsRefused(Refusal::kOtherMachine));
  EXPECT_THAT(response.message, HasSubstr("another machine, cat"));
}

TEST_F(InvalidRequests, ACommandForAnotherProcessIsRefusedByTheActuator) {
  const auto response = Command([](auto& request) { request.incarnation = 4711; });
  EXPECT_EQ(response.code, kCodePermissionDenied);
}

TEST_F(InvalidRequests, ACommandThatIsTooOldIsRefusedByTheActuator) {
  const auto response = Command([](auto& request) { request.budget_ns = -1'000'000'000; });
  EXPECT_EQ(response.code, kCodeTimeout);
}

TEST_F(InvalidRequests, ACommandForAHugeOrUnknownStateIsRefusedByTheActuator) {
  const auto response = Command([](auto& request) { request.target = std::string(100'000, 'x'); });
  EXPECT_EQ(response.code, kCodeUnSupport);
  EXPECT_LT(response.message.size(), 1000U);
}

TEST_F(InvalidRequests, ACommandOfAnUnknownKindIsRefusedByTheActuator) {
  const auto response = Command([](auto& request) { request.kind = 77; });
  EXPECT_EQ(response.verdict, ActuatorCommand::kVerdictRefused);
  EXPECT_THAT(response, IsRefused(Refusal::kUnknownKind));
}

TEST_F(InvalidRequests, AnUnknownRequestToThePolicyIsRefused) {
  const auto response = Call<msg::RequestPolicy>(
      transport::MachineService(NameSpace(), "request_policy"), {"dance", "", 0, false});
  EXPECT_THAT(response, IsRefused(Refusal::kUnknownRequest));
}

}  // namespace musher::invalid_requests_test
