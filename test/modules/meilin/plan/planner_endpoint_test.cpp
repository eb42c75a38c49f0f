// The planner on a simulated network: maps in, plans out, and the buffer of the last plan.

#include "musher/modules/meilin/plan/planner_endpoint.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "musher/messages/r2_interfaces/get_action_seq.hpp"
#include "musher/test/support/paths.hpp"
#include "musher/transport/sim/network.hpp"

namespace musher::meilin::planner_endpoint_test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr const char* kMap =
    R"({"grid": [[0,0,0],[0,2,0],[0,2,1],[0,2,0],[0,3,0],[0,0,0]], "team": "blue", "method": 1})";

class PlannerEndpointTest : public ::testing::Test {
 protected:
  PlannerEndpointTest() {
    Keep<msg::String>("planning/paths_for_web", paths_);
    Keep<msg::String>("planning/last_error", errors_);
    Keep<msg::String>("mf_buffer_status", status_);
    Keep<msg::Float32MultiArray>("mf_action_seq", plans_);
    map_ =
        Must(transport::MakePublisher<msg::String>(*peer_, "mf_r2_data", transport::kLatchedQos));
    command_ = Must(transport::MakePublisher<msg::String>(*peer_, "planning/command"));
    buffer_ = Must(transport::MakeClient<msg::GetActionSeq>(*peer_, "get_action_seq"));
  }

  void Start(const PlannerConfig& config = {}) {
    endpoint_ =
        Must(PlannerEndpoint::Make({*node_, *clock_, "", [](LogLevel, const auto&) {}}, config));
    Run(1000);  // discovery
    endpoint_->Permit(true, "");
  }
  template <class M>
  void Keep(const std::string& topic, std::vector<M>& samples) {
    kept_.push_back(Must(transport::MakeSubscription<M>(
        *peer_, topic, [&samples](const M& sample, const auto&) { samples.push_back(sample); },
        transport::kLatchedQos)));
  }
  template <class T>
  static T Must(Result<T> result) {
    if (!result) ADD_FAILURE() << result.error().message;
    return std::move(result).value();
  }
  void Run(std::int64_t ms) { network_.RunFor(Milliseconds(ms)); }
  void SendMap(const std::string& text) {
    EXPECT_TRUE(map_->Publish({text}));
    Run(200);
  }
  void Command(const std::string& text) {
    EXPECT_TRUE(command_->Publish({text}));
    Run(200);
  }
  msg::GetActionSeq::Response Ask() {
    std::optional<msg::GetActionSeq::Response> response;
    buffer_->Call({}, Milliseconds(1000), [&](const auto& reply) {
      if (reply) response = reply.value();
    });
    Run(300);
    EXPECT_TRUE(response.has_value());
    return response.value_or(msg::GetActionSeq::Response{});
  }
  int Fetches(const msg::Float32MultiArray& plan) const {
    int fetches = 0;
    for (std::size_t at = 0; at < plan.data.size(); at += 8) fetches += plan.data[at] == 1 ? 1 : 0;
    return fetches;
  }

  transport::sim::Network network_{1};
  std::unique_ptr<transport::Node> node_ = network_.MakeNode("robot");
  std::unique_ptr<transport::Node> peer_ = network_.MakeNode("page");
  std::unique_ptr<transport::Clock> clock_ = transport::Clock::Steady(node_->loop());
  std::vector<msg::String> paths_, errors_, status_;
  std::vector<msg::Float32MultiArray> plans_;
  std::vector<std::unique_ptr<transport::Subscription>> kept_;
  std::unique_ptr<transport::Publisher<msg::String>> map_, command_;
  std::unique_ptr<transport::Client<msg::GetActionSeq>> buffer_;
  std::unique_ptr<PlannerEndpoint> endpoint_;
};

TEST_F(PlannerEndpointTest, PublishesThePlansOfAMap) {
  Start();
  SendMap(kMap);
  ASSERT_EQ(paths_.size(), 1U);
  const auto json = nlohmann::json::parse(paths_[0].data);
  EXPECT_EQ(json["buckets"].size(), 5U);
  EXPECT_FALSE(json["buckets"][2]["paths"].empty());
  EXPECT_TRUE(plans_.empty()) << "only a command sends a plan";
  EXPECT_EQ(errors_.back().data, "");
}

TEST_F(PlannerEndpointTest, SendsThePlanThatIsChosen) {
  Start();
  SendMap(kMap);
  Command("SEND");
  ASSERT_EQ(plans_.size(), 1U);
  EXPECT_EQ(Fetches(plans_[0]), 2);
  EXPECT_TRUE(ReadActionSequence(plans_[0], {}, {}).ok());
  Command("SEND 3");
  Command("SEND 0 2");
  ASSERT_EQ(plans_.size(), 3U);
  EXPECT_EQ(Fetches(plans_[1]), 3);
  EXPECT_EQ(Fetches(plans_[2]), 0);
}

TEST_F(PlannerEndpointTest, RefusesWithTheReason) {
  Start();
  Command("SEND");
  EXPECT_THAT(errors_.back().data, HasSubstr("there is no map of boxes yet"));
  SendMap(R"({"grid": [[0,0,0]], "team": "green"})");
  EXPECT_THAT(errors_.back().data, HasSubstr("team: unknown value 'green'"));
  EXPECT_THAT(errors_.back().data, HasSubstr("grid: expected six rows"));
  EXPECT_TRUE(paths_.empty());
  SendMap(kMap);
  for (const char* command : {"SENT", "SEND x", "SEND 2 x", "SEND 2 1 1", ""}) {
    Command(command);
    EXPECT_THAT(errors_.back().data, HasSubstr("is refused: expected")) << command;
  }
  for (const char* command : {"SEND 4", "SEND 5", "SEND 2 11", "SEND 2 0"}) {
    Command(command);
    EXPECT_THAT(errors_.back().data, HasSubstr("is refused: there is no plan")) << command;
  }
  EXPECT_TRUE(plans_.empty());
}

TEST_F(PlannerEndpointTest, ReportsAMapWithoutAPath) {
  Start();
  SendMap(R"({"grid": [[0,0,0],[3,3,3],[0,0,0],[0,0,0],[0,0,0],[0,0,0]], "team": "red"})");
  EXPECT_THAT(errors_.back().data, HasSubstr("no path leads to row 5"));
  Command("SEND");
  EXPECT_THAT(errors_.back().data, HasSubstr("the last map of boxes has no plan"));
}

TEST_F(PlannerEndpointTest, HandsTheLastPlanOutOnce) {
  Start();
  EXPECT_FALSE(Ask().has_data);
  SendMap(kMap);
  Command("SEND");
  EXPECT_TRUE(endpoint_->has_plan());
  const auto first = Ask();
  EXPECT_TRUE(first.has_data);
  EXPECT_EQ(first.data, plans_.at(0));
  EXPECT_FALSE(Ask().has_data);
  std::vector<std::string> status;
  for (const msg::String& sample : status_) status.push_back(sample.data);
  EXPECT_THAT(status, ElementsAre("empty", "has_data", "empty"));
}

TEST_F(PlannerEndpointTest, BuffersThePlanOfAnotherSender) {
  Start();
  const auto page = Must(transport::MakePublisher<msg::Float32MultiArray>(*peer_, "mf_action_seq",
                                                                          transport::kLatchedQos));
  Run(500);
  const auto plan = ToActionSequence({{false, {0, 1}, 0, 0}});
  EXPECT_TRUE(page->Publish(plan));
  Run(200);
  EXPECT_EQ(Ask().data, plan);
}

TEST_F(PlannerEndpointTest, SendsNothingWhileItIsNotPermitted) {
  Start();
  SendMap(kMap);
  Command("SEND");
  endpoint_->Permit(false, "it is in Protected");
  EXPECT_FALSE(Ask().has_data);
  Command("SEND");
  EXPECT_THAT(errors_.back().data, HasSubstr("it is in Protected"));
  EXPECT_EQ(plans_.size(), 1U);
  endpoint_->Permit(true, "");
  EXPECT_TRUE(Ask().has_data) << "the plan of before is still there";
}

TEST_F(PlannerEndpointTest, SendsByItselfAfterTheTimeOfTheConfig) {
  PlannerConfig config;
  config.auto_send = Milliseconds(10'000);
  Start(config);
  SendMap(kMap);
  Run(9'000);
  EXPECT_TRUE(plans_.empty());
  Run(1'000);
  ASSERT_EQ(plans_.size(), 1U);
  SendMap(kMap);
  Command("SEND 3");
  Run(20'000);
  EXPECT_EQ(plans_.size(), 2U) << "a command has taken its place";
  SendMap(kMap);
  endpoint_->Permit(false, "it is in Protected");
  Run(20'000);
  EXPECT_EQ(plans_.size(), 2U);
}

TEST_F(PlannerEndpointTest, AnswersAThousandDamagedMaps) {
  Start();
  std::uint32_t random = 22;
  const auto any = [&random](std::size_t below) {
    random = random * 1664525U + 1013904223U;
    return (random >> 8U) % below;
  };
  for (int count = 0; count < 1000; ++count) {
    std::string text = kMap;
    for (int edits = 0; edits < 3; ++edits) text[any(text.size())] = static_cast<char>(any(128));
    EXPECT_TRUE(map_->Publish({text}));
    Run(5);
  }
  SendMap(kMap);
  EXPECT_EQ(errors_.back().data, "");
}

TEST(PlannerConfig, HasItsDefaultsInTheShippedFile) {
  const Parsed<PlannerConfig> shipped =
      ReadPlannerFile(SourceDir() + "/config/meilin/planner.toml");
  ASSERT_TRUE(shipped.config);
  const PlannerConfig standard;
  EXPECT_EQ(shipped.config->auto_send, standard.auto_send);
  EXPECT_EQ(shipped.config->topics.map, standard.topics.map);
  EXPECT_EQ(shipped.config->topics.buffer_service, standard.topics.buffer_service);
  EXPECT_EQ(shipped.config->rules.plan.normal_height_mm, standard.rules.plan.normal_height_mm);
  EXPECT_EQ(shipped.config->rules.plan.highest_wheel_mm, standard.rules.plan.highest_wheel_mm);
  EXPECT_EQ(shipped.config->rules.costs.down_400_s, standard.rules.costs.down_400_s);
}

TEST(PlannerConfig, HasAnEntranceInRow0) {
  EXPECT_EQ(ReadPlannerText("entrance = [0, 2]\n", "p.toml").config->rules.entrance, (Cell{0, 2}));
  for (const char* text : {"entrance = [1, 0]", "entrance = [0, 3]", "entrance = [0]"}) {
    const Parsed<PlannerConfig> reading = ReadPlannerText(text, "p.toml");
    ASSERT_EQ(reading.diagnostics.size(), 1U) << text;
    EXPECT_THAT(reading.diagnostics[0].message, HasSubstr("a match enters in row 0")) << text;
  }
}

TEST(PlannerConfig, NamesThePlaceOfAnError) {
  const Parsed<PlannerConfig> reading = ReadPlannerText(
      "auto_sent_ms = 1\n[topics]\nmap = \"a b\"\n[costs]\nflat_s = -1\n", "p.toml");
  ASSERT_EQ(reading.diagnostics.size(), 3U);
  EXPECT_EQ(FormatDiagnostic(reading.diagnostics[0]),
            "p.toml:1:1: error: unknown key \"auto_sent_ms\"; did you mean \"auto_send_ms\"?");
  EXPECT_EQ(reading.diagnostics[1].line, 3);
  EXPECT_EQ(reading.diagnostics[2].line, 5);
}

}  // namespace
}  // namespace musher::meilin::planner_endpoint_test
