// Why a machine is as it is, and what failed last, from entries as a controller sends them.

#include "musher/cli/machine/why.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <ctime>

#include "musher/cli/render/json.hpp"
#include "musher/cli/render/text.hpp"

namespace musher::cli::why_test {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr std::int32_t kTimeout = 107;

class Explaining : public ::testing::Test {
 protected:
  Explaining() {
    setenv("TZ", "UTC", 1);
    tzset();
  }
  void Add(std::uint64_t cause, const std::string& message, std::int32_t code = 0,
           const std::string& state = "", const std::string& data = "") {
    const std::uint64_t id = history_.entries.size() + 1;
    history_.entries.push_back({id, static_cast<std::int64_t>(id) * 1'000'000, 1, 0, "switch", "",
                                code, message, cause, state, data});
  }
  std::string Text(const State& state = State("")) const {
    return WhyText(FindWhy(history_, {state}).value(), false);
  }

  msg::GetHistory::Response history_;
};

// After an undone switch it explained the change of state before it, and left the failure out.
TEST_F(Explaining, AStateNamesTheFailureAfterItFirst) {
  Add(0, "switch to Active requested");
  Add(1, "the machine is Active", 0, "Active");
  Add(0, "switch to LowPower requested");
  Add(3, "legs did not answer", kTimeout);
  Add(4, "switch 2 is undone", kTimeout);
  EXPECT_EQ(Text(),
            "1970-01-01 00:00:00.005  last failure: switch 2 is undone (107 Robot: Timeout)\n"
            "1970-01-01 00:00:00.004    because legs did not answer (107 Robot: Timeout)\n"
            "1970-01-01 00:00:00.003    because switch to LowPower requested\n"
            "1970-01-01 00:00:00.002  the machine went to Active\n"
            "1970-01-01 00:00:00.001    because switch to Active requested\n");
}

TEST_F(Explaining, AStateNamesTheFailureBeforeItLast) {
  Add(0, "eyes did not start", kTimeout);
  Add(0, "switch to Active requested");
  Add(2, "the machine is Active", 0, "Active");
  EXPECT_EQ(Text(),
            "1970-01-01 00:00:00.003  the machine went to Active\n"
            "1970-01-01 00:00:00.002    because switch to Active requested\n"
            "1970-01-01 00:00:00.001  last failure: eyes did not start (107 Robot: Timeout)\n");
}

TEST_F(Explaining, AFailureThatIsTheCauseOfTheStateIsNamedOnce) {
  Add(0, "legs crashed", kTimeout);
  Add(1, "falling back to Protected", 0, "Protected");
  EXPECT_THAT(FindWhy(history_, {}).value().failure.entries, IsEmpty());
}

TEST_F(Explaining, AStateThatWasNamedLeavesOtherFailuresOut) {
  Add(0, "the machine is Active", 0, "Active");
  Add(0, "legs crashed", kTimeout);
  EXPECT_EQ(Text(State("Active")), "1970-01-01 00:00:00.001  the machine went to Active\n");
}

// As the controller records it: the hang, the backtrace beside it, and the exit as a consequence.
TEST_F(Explaining, AHangIsTheFailureAndItsBacktraceIsFolded) {
  Add(0, "the machine is Active", 0, "Active");
  Add(0, "legs hung", kTimeout);
  Add(2, "taking a backtrace of legs; then process 7 gets SIGKILL", kTimeout);
  Add(0, "backtrace of legs:", 0, "", "TID 7:\n#0  read\n#1  main\n");
  Add(3, "legs's process 7 ended: killed by SIGKILL", kTimeout);
  history_.events = {"machine_usable", "actuator_hung", "backtrace_started", "backtrace_taken",
                     "process_exited"};
  EXPECT_THAT(Text(), ::testing::StartsWith("1970-01-01 00:00:00.002  last failure: legs hung "
                                            "(107 Robot: Timeout)  "
                                            "[3 lines in `musher history`]\n"));
}

// Such a switch is the change and the failure: its reason was left out.
TEST_F(Explaining, AChangeThatLeftAnActuatorBehindHasItsReason) {
  Add(0, "switch to LowPower requested");
  Add(1, "switch 3 is done-degraded: legs: no brake", kTimeout, "LowPower");
  EXPECT_EQ(Text(),
            "1970-01-01 00:00:00.002  the machine went to LowPower: switch 3 is done-degraded: "
            "legs: no brake (107 Robot: Timeout)\n"
            "1970-01-01 00:00:00.001    because switch to LowPower requested\n");
}

// The cause is another actuator than the one that the switch left behind, which nothing else named.
TEST_F(Explaining, AFallbackNamesTheActuatorThatItLeftBehind) {
  Add(0, "lidar is degraded: crashed", kTimeout);
  history_.entries.back().actuator = "lidar";
  Add(1, "switch 5 is done-degraded: legs: no brake", kTimeout, "Protected");
  EXPECT_THAT(Text(), HasSubstr("went to Protected: switch 5 is done-degraded: legs: no brake"));
  history_.entries.front().actuator = "legs";
  EXPECT_THAT(Text(), HasSubstr("went to Protected\n")) << "its failure follows as the cause";
}

TEST_F(Explaining, IsIncompleteWithoutTheCauseOfTheFailure) {
  Add(0, "the machine is Active", 0, "Active");
  Add(0, "legs crashed", kTimeout);
  EXPECT_THAT(WhyJson(FindWhy(history_, {}).value()), HasSubstr("\"complete\":true"));
  history_.entries.back().cause = 77;
  EXPECT_THAT(WhyJson(FindWhy(history_, {}).value()), HasSubstr("\"complete\":false"));
}

// Each `--why` read the whole journal of a robot that never failed.
TEST_F(Explaining, OlderEntriesAreNotNeededWhereNothingFailedUnlessAFailureIsAskedFor) {
  Add(0, "the machine is Active", 0, "Active");
  EXPECT_FALSE(NeedsOlderEntries(history_, {}));
  EXPECT_TRUE(NeedsOlderEntries(history_, {.failure_only = true}));
  EXPECT_TRUE(NeedsOlderEntries(history_, {.actuator = "legs"}));
}

// The newest 1000 entries are read first.
TEST_F(Explaining, OlderEntriesAreNeededUntilTheChangeTheFailureAndTheirCausesAreRead) {
  Add(0, "legs crashed", kTimeout);
  EXPECT_TRUE(NeedsOlderEntries(history_, {})) << "no change of state";
  Add(0, "the machine is Active", 0, "Active");
  EXPECT_FALSE(NeedsOlderEntries(history_, {}));
  EXPECT_TRUE(NeedsOlderEntries(history_, {.actuator = "legs"})) << "no failure of legs";
  EXPECT_TRUE(NeedsOlderEntries(history_, {State("OTA")}));
  EXPECT_FALSE(NeedsOlderEntries(history_, {State("Active")}));
  history_.entries.front().cause = 77;
  EXPECT_TRUE(NeedsOlderEntries(history_, {})) << "no cause of the failure";
}

TEST(History, EndsWithoutARecordWhereItsControllerWasKilled) {
  msg::GetHistory::Response history;
  EXPECT_FALSE(EndsWithoutRecord(history));
  history.events = {"controller_started", "machine_stopped", "controller_started", "switch_done"};
  EXPECT_TRUE(EndsWithoutRecord(history));
  history.events.emplace_back("machine_stopped");
  EXPECT_FALSE(EndsWithoutRecord(history));
}

}  // namespace musher::cli::why_test
