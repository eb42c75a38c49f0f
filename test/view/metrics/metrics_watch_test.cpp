// In virtual time, with a controller of the test's own.

#include "musher/view/metrics/metrics_watch.hpp"

#include <gmock/gmock.h>

#include "musher/test/view/metrics/openmetrics_grammar.hpp"
#include "musher/transport/sim/network.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher::view::metrics_watch_test {

using musher::testing::ParsedMetrics;
using musher::testing::ParseOpenMetrics;
using ::testing::IsEmpty;

constexpr std::int64_t kBegan = 1'000'000'000;  // of musher-view
constexpr std::size_t kRead = 200;              // entries, by the first scrape

// Publishes a status and has a history.
class FakeController {
 public:
  FakeController(transport::sim::Network& network, std::uint64_t epoch)
      : node_(network.MakeNode("robot")), epoch_(epoch) {
    status_ = transport::MakePublisher<msg::MachineStatus>(
                  *node_, transport::MachineStatusTopic("dog"), transport::kLatchedQos)
                  .value();
    server_ = transport::MakeServer<msg::GetHistory>(
                  *node_, transport::MachineService("dog", "get_history"),
                  transport::Server<msg::GetHistory>::Handler(
                      [this](const auto& request, auto reply) { OnGetHistory(request, reply); }))
                  .value();
    heartbeats_ = transport::MakePublisher<msg::ActuatorHeartbeat>(
                      *node_, transport::ActuatorHeartbeatTopic("dog"), transport::kHeartbeatQos)
                      .value();
    msg::MachineStatus status;
    status.machine = "dog";
    status.state = "Active";
    status.epoch = epoch;
    status.actuators.resize(1);
    status.actuators[0].name = "legs";
    status.actuators[0].presence = "present";
    status.actuators[0].host = "robot";
    status.actuators[0].pid = 7;
    EXPECT_TRUE(status_->Publish(status).ok());
  }

  void Add(std::size_t crashes, std::int64_t wall_ns) {
    for (std::size_t i = 0; i < crashes; ++i) {
      msg::HistoryEntry entry;
      entry.id = ++id_;
      entry.epoch = epoch_;
      entry.wall_ns = wall_ns;
      entry.kind = "actuator";
      entry.actuator = "legs";
      history.entries.push_back(entry);
      history.events.emplace_back("actuator_crashed");
    }
  }
  void Heartbeat() {
    msg::ActuatorHeartbeat heartbeat;
    heartbeat.name = "legs";
    heartbeat.period_ns = 100'000'000;
    EXPECT_TRUE(heartbeats_->Publish(heartbeat).ok());
  }

  msg::GetHistory::Response history;
  bool answers = true;
  std::vector<std::uint32_t> requests;  // their limits

 private:
  void OnGetHistory(const msg::GetHistory::Request& request,
                    const transport::Server<msg::GetHistory>::Reply& reply) {
    requests.push_back(request.limit);
    if (!answers) return;
    msg::GetHistory::Response response = history;
    const std::size_t limit = request.limit;
    if (response.entries.size() > limit) {
      const auto left_out = static_cast<std::ptrdiff_t>(response.entries.size() - limit);
      response.entries.erase(response.entries.begin(), response.entries.begin() + left_out);
      response.events.erase(response.events.begin(), response.events.begin() + left_out);
    }
    reply(response);
  }

  std::unique_ptr<transport::Node> node_;
  const std::uint64_t epoch_;
  std::uint64_t id_ = 0;
  std::unique_ptr<transport::Publisher<msg::MachineStatus>> status_;
  std::unique_ptr<transport::Publisher<msg::ActuatorHeartbeat>> heartbeats_;
  std::unique_ptr<transport::Server<msg::GetHistory>> server_;
};

class MetricsWatchTest : public ::testing::Test {
 protected:
  MetricsWatchTest() : node_(network_.MakeNode("robot")) {
    MetricsWatch::Options options;
    options.name_space = "dog";
    options.began_wall_ns = kBegan;
    options.host = "robot";
    options.usage_of = [this](pid_t pid) { return ProcessUsage{pid, 1, cpu_seconds_, 4096}; };
    watch_ = std::make_unique<MetricsWatch>(*node_, std::move(options));
  }

  // The answer, within the time that a scrape may take.
  ParsedMetrics Scrape() {
    std::optional<std::string> text;
    watch_->Scrape(MetricsFormat::kOpenMetrics, [&](const Result<std::string>& answer) {
      ASSERT_FALSE(text) << "answered twice";
      text = answer.value();
    });
    const Time begin = network_.now();
    network_.RunUntil([&] { return text.has_value(); }, begin + 2 * MetricsWatch::kTimeout);
    took_ = network_.now() - begin;
    EXPECT_TRUE(text.has_value());
    ParsedMetrics parsed = ParseOpenMetrics(text.value_or(""));
    EXPECT_THAT(parsed.errors, IsEmpty());
    return parsed;
  }
  double Crashes() {
    return Scrape()
        .Value("musher_actuator_faults_total", {{"actuator", "legs"}, {"verdict", "crashed"}})
        .value_or(-1);
  }

  transport::sim::Network network_{1};
  std::unique_ptr<transport::Node> node_;
  std::unique_ptr<MetricsWatch> watch_;
  double cpu_seconds_ = 1;
  Duration took_{};
};

TEST_F(MetricsWatchTest, TheFirstScrapeHasTheStatusAndWhatHappenedSinceTheViewBegan) {
  FakeController controller(network_, 1);
  controller.Add(3, kBegan - 1);
  controller.Add(2, kBegan);
  EXPECT_EQ(Crashes(), 2);
  EXPECT_LT(took_, MetricsWatch::kTimeout);
  EXPECT_EQ(Scrape().Value("musher_controller_up"), 1);
}

TEST_F(MetricsWatchTest, NothingIsSubscribedBeforeTheFirstScrape) {
  FakeController controller(network_, 1);
  network_.RunFor(std::chrono::seconds(10));
  EXPECT_THAT(controller.requests, IsEmpty());
  const std::uint64_t steps = network_.steps();
  controller.Heartbeat();
  network_.RunFor(std::chrono::seconds(1));
  EXPECT_EQ(network_.steps(), steps);  // no reader
}

TEST_F(MetricsWatchTest, EachScrapeHasWhatHappenedUpToIt) {
  FakeController controller(network_, 1);
  controller.Add(1, kBegan + 1);
  EXPECT_EQ(Crashes(), 1);
  controller.Add(1, kBegan + 2);
  EXPECT_EQ(Crashes(), 2);
  EXPECT_EQ(Crashes(), 2);
  EXPECT_THAT(controller.requests, ::testing::ElementsAre(kRead, JournalCursor::kNextEntries,
                                                          JournalCursor::kNextEntries));
}

// They stood still until the clock had caught up.
TEST_F(MetricsWatchTest, CountersGoOnWhenTheWallClockIsSetBack) {
  FakeController controller(network_, 1);
  controller.Add(1, kBegan + 1);
  EXPECT_EQ(Crashes(), 1);
  controller.Add(1, kBegan - 100);
  EXPECT_EQ(Crashes(), 2);
}

TEST_F(MetricsWatchTest, AScrapeThatMissesEntriesReadsMore) {
  FakeController controller(network_, 1);
  controller.Add(1, kBegan + 1);
  EXPECT_EQ(Crashes(), 1);
  controller.Add(3 * kRead, kBegan + 2);
  EXPECT_EQ(Crashes(), 1 + 3 * kRead);
  EXPECT_GT(controller.requests.back(), kRead);
}

TEST_F(MetricsWatchTest, ALongOldHistoryIsNotReadAtTheFirstScrape) {
  FakeController controller(network_, 1);
  controller.Add(5 * kRead, kBegan - 1);
  controller.Add(1, kBegan + 1);
  EXPECT_EQ(Crashes(), 1);
  EXPECT_THAT(controller.requests, ::testing::ElementsAre(kRead));
}

TEST_F(MetricsWatchTest, AnswersWithoutAController) {
  EXPECT_EQ(Scrape().Value("musher_controller_up"), 0);
  EXPECT_EQ(took_, MetricsWatch::kTimeout);  // it may be found meanwhile
  const ParsedMetrics second = Scrape();
  EXPECT_EQ(took_, Duration::zero());
  EXPECT_EQ(second.Value("musher_scrapes_incomplete_total"), 0);
}

TEST_F(MetricsWatchTest, AControllerThatDoesNotAnswerDelaysAScrapeByOneSecond) {
  FakeController controller(network_, 1);
  controller.Add(1, kBegan + 1);
  controller.answers = false;
  const ParsedMetrics parsed = Scrape();
  EXPECT_EQ(took_, MetricsWatch::kTimeout);
  EXPECT_EQ(parsed.Value("musher_controller_up"), 1);
  EXPECT_EQ(parsed.Value("musher_scrapes_incomplete_total"), 1);
  controller.answers = true;
  EXPECT_EQ(Crashes(), 1);
}

TEST_F(MetricsWatchTest, AControllerWithAJournalOfItsOwnContinuesTheCounters) {
  {
    FakeController controller(network_, 1);
    controller.Add(2, kBegan + 1);
    EXPECT_EQ(Crashes(), 2);
  }
  network_.RunFor(std::chrono::seconds(20));
  EXPECT_EQ(Scrape().Value("musher_controller_up"), 0);
  FakeController successor(network_, 2);
  successor.Add(1, kBegan + 2);
  network_.RunFor(std::chrono::seconds(1));
  EXPECT_EQ(Crashes(), 3);
}

TEST_F(MetricsWatchTest, ScrapesAtTheSameTimeShareOneLookAtTheHistory) {
  FakeController controller(network_, 1);
  Scrape();
  controller.requests.clear();
  int answers = 0;
  for (int i = 0; i < 5; ++i) {
    watch_->Scrape(MetricsFormat::kPrometheus, [&](const auto&) { ++answers; });
  }
  network_.RunFor(std::chrono::seconds(1));
  EXPECT_EQ(answers, 5);
  EXPECT_THAT(controller.requests, ::testing::SizeIs(1));
}

TEST_F(MetricsWatchTest, HasHeartbeatsAndWhatProcessesOfThisHostUse) {
  FakeController controller(network_, 1);
  Scrape();
  network_.RunFor(Milliseconds(500));
  controller.Heartbeat();
  network_.RunFor(Milliseconds(500));
  cpu_seconds_ = 3;
  const ParsedMetrics parsed = Scrape();
  EXPECT_LE(parsed.Value("musher_actuator_heartbeat_age_seconds", {{"actuator", "legs"}}), 0.6);
  EXPECT_EQ(parsed.Value("musher_actuator_cpu_seconds_total", {{"actuator", "legs"}}), 2);
}

TEST_F(MetricsWatchTest, AWatchThatIsDroppedAnswersNoMore) {
  FakeController controller(network_, 1);
  watch_->Scrape(MetricsFormat::kOpenMetrics, [](const auto&) { ADD_FAILURE(); });
  watch_ = nullptr;
  network_.RunFor(std::chrono::seconds(5));
}

}  // namespace musher::view::metrics_watch_test
