// A robot of real processes: what happens to it is counted at the next scrape.

#include <signal.h>

#include <cstdlib>

#include "musher/base/host.hpp"
#include "musher/test/integration/cli/machine.hpp"
#include "musher/test/view/metrics/openmetrics_grammar.hpp"
#include "musher/transport/dds/dds_node.hpp"
#include "musher/transport/linux_event_loop.hpp"
#include "musher/view/metrics/metrics_watch.hpp"

namespace musher::view::process_test {

using musher::testing::AllHaveArrived;
using musher::testing::Musher;
using musher::testing::ParsedLabels;
using musher::testing::ParsedMetrics;
using musher::testing::ParseOpenMetrics;
using musher::testing::Status;

class Metrics : public musher::testing::MachineByCli {
 protected:
  Metrics() {
    MetricsWatch::Options options;
    options.name_space = name_space_;
    options.began_wall_ns =
        std::chrono::nanoseconds(std::chrono::system_clock::now().time_since_epoch()).count();
    options.host = HostId();
    node_ = transport::MakeDdsNode(loop_).value();
    watch_ = std::make_unique<MetricsWatch>(*node_, std::move(options));
  }

  ParsedMetrics Scrape() {
    std::optional<std::string> text;
    watch_->Scrape(MetricsFormat::kOpenMetrics,
                   [&](const Result<std::string>& answer) { text = answer.value(); });
    const bool answered =
        loop_.RunUntil([&] { return text.has_value(); }, loop_.Now() + std::chrono::seconds(120));
    EXPECT_TRUE(answered);
    ParsedMetrics parsed = ParseOpenMetrics(text.value_or(""));
    EXPECT_THAT(parsed.errors, ::testing::IsEmpty());
    return parsed;
  }
  // A scrape may be answered before discovery has ended, without the history. The value of the
  // first one for which `is_so` holds, else of the last one after two minutes; -1: there is none.
  double AwaitThat(const std::string& sample, const ParsedLabels& labels,
                   const std::function<bool(double)>& is_so) {
    const Time deadline = loop_.Now() + std::chrono::seconds(120);
    for (;;) {
      const double value = Value(sample, labels);
      if (is_so(value) || loop_.Now() > deadline) return value;
      loop_.RunUntil([] { return false; }, loop_.Now() + Milliseconds(100));
    }
  }
  double Await(const std::string& sample, const ParsedLabels& labels, double expected) {
    return AwaitThat(sample, labels, [expected](double value) { return value == expected; });
  }
  double Value(const std::string& sample, const ParsedLabels& labels) {
    return Scrape().Value(sample, labels).value_or(-1);
  }

  transport::LinuxEventLoop loop_;
  std::unique_ptr<transport::Node> node_;
  std::unique_ptr<MetricsWatch> watch_;
};

TEST_F(Metrics, OfARobotCountItsCrashItsSwitchAndItsRefusal) {
  ASSERT_EQ(UpDetached().exit, 0);
  const ParsedLabels active = {{"musher_machine_state", "Active"}};
  ASSERT_EQ(Await("musher_machine_state", active, 1), 1);

  ASSERT_EQ(Musher({"set", "LowPower"}).exit, 0);
  const ParsedLabels done = {{"target", "LowPower"}, {"outcome", "done"}};
  EXPECT_EQ(Await("musher_switches_total", done, 1), 1);
  EXPECT_EQ(Value("musher_switch_duration_seconds_count", {{"target", "LowPower"}}), 1);
  EXPECT_EQ(Value("musher_command_duration_seconds_count",
                  {{"actuator", "voice"}, {"target", "LowPower"}}),
            1);

  ASSERT_EQ(Musher({"estop"}).exit, 0);
  EXPECT_NE(Musher({"set", "Active"}).exit, 0);
  const ParsedLabels refused = {{"target", "unknown"}, {"outcome", "refused"}};
  EXPECT_EQ(Await("musher_switches_total", refused, 1), 1);
  EXPECT_EQ(Value("musher_emergency_stop", {}), 1);
  ASSERT_EQ(Musher({"estop", "--release"}).exit, 0);

  const int voice = Status()["actuators"]["voice"]["pid"];
  ASSERT_GT(voice, 0);
  kill(voice, SIGKILL);
  const ParsedLabels crashed = {{"actuator", "voice"}, {"verdict", "crashed"}};
  EXPECT_EQ(Await("musher_actuator_faults_total", crashed, 1), 1);
  EXPECT_EQ(Await("musher_actuator_restarts_total", {{"actuator", "voice"}}, 1), 1);
  EXPECT_EQ(Value("musher_actuator_faults_total", {{"actuator", "legs"}, {"verdict", "crashed"}}),
            0);
  EXPECT_GT(Value("musher_actuator_resident_memory_bytes", {{"actuator", "legs"}}), 100'000);
  // The period of heartbeats may be longer than all of this took.
  const double age = AwaitThat("musher_actuator_heartbeat_age_seconds", {{"actuator", "legs"}},
                               [](double seconds) { return seconds >= 0; });
  EXPECT_GE(age, 0);
  EXPECT_LT(age, 5);
}

TEST_F(Metrics, OfARestartedControllerContinue) {
  ASSERT_EQ(UpDetached().exit, 0);
  const ParsedLabels done = {{"target", "LowPower"}, {"outcome", "done"}};
  ASSERT_EQ(Await("musher_controller_up", {}, 1), 1);
  ASSERT_EQ(Musher({"set", "LowPower"}).exit, 0);
  ASSERT_EQ(Await("musher_switches_total", done, 1), 1);
  const double epoch = Value("musher_controller_epoch", {});
  kill(Status()["pid"], SIGKILL);
  ASSERT_EQ(UpDetached().exit, 0);
  EXPECT_EQ(Await("musher_controller_epoch", {}, epoch + 1), epoch + 1);
  EXPECT_EQ(Value("musher_switches_total", done), 1);
  ASSERT_EQ(Musher({"set", "OTA"}).exit, 0);
  ASSERT_EQ(Musher({"set", "LowPower"}).exit, 0);
  EXPECT_EQ(Await("musher_switches_total", done, 2), 2);
}

}  // namespace musher::view::process_test
