// Rules of the user that are violated while the machine runs: what the controller records.

#include <gmock/gmock.h>

#include "musher/test/controller/two_controllers.hpp"

namespace musher::testing::rule_record_test {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;

class ViolatedRules : public TwoControllers {
 protected:
  void BringUpWith(const std::string& rules) {
    UserRulesReading read = ReadUserRules(config_, "rules.txt", rules);
    ASSERT_THAT(read.diagnostics, IsEmpty());
    first_.disk.rules = std::move(read.rules);
    ASSERT_NO_FATAL_FAILURE(BringUpFirst());
  }
  std::vector<std::string> Recorded() const {
    std::vector<std::string> messages;
    for (const JournalRow& row : first_.disk.recording) {
      const auto* entry = std::get_if<JournalEntry>(&row.item);
      if (entry == nullptr || entry->event != NameOf(EventName::kRuleViolated)) continue;
      EXPECT_EQ(entry->id, RecordId(0)) << "it is not of a decision, which a replay repeats";
      messages.push_back(entry->message);
    }
    return messages;
  }
  void Set(const State& state) {
    std::optional<SwitchResult> result;
    first_.process->shell().SetState(state, std::nullopt, [&](const auto& r) { result = r; });
    ASSERT_TRUE(RunUntil([&] { return result.has_value(); }));
    ASSERT_TRUE(result->done()) << result->reason;
    network_.RunFor(std::chrono::seconds(2));
  }
};

TEST_F(ViolatedRules, AreRecordedOnceUntilTheyHoldAgainAndChangeNothing) {
  ASSERT_NO_FATAL_FAILURE(BringUpWith("never machine Active while b is Active\n"));
  network_.RunFor(std::chrono::seconds(30));
  EXPECT_THAT(Recorded(),
              ElementsAre("a rule of yours is violated: never machine Active while b is Active "
                          "(the machine is in Active, b is in Active); nothing is changed"));
  EXPECT_EQ(first_.machine().state, "Active");
  EXPECT_FALSE(first_.machine().current);
  EXPECT_THAT(first_.process->shell().Status().violated_rules,
              ElementsAre("never machine Active while b is Active"));
  ASSERT_NO_FATAL_FAILURE(Set("LowPower"));
  EXPECT_THAT(Recorded(), SizeIs(1));
  EXPECT_THAT(first_.process->shell().Status().violated_rules, IsEmpty());
  ASSERT_NO_FATAL_FAILURE(Set("Active"));
  EXPECT_THAT(Recorded(), SizeIs(2));
}

TEST_F(ViolatedRules, WithATimeAreRecordedWhenItIsOver) {
  ASSERT_NO_FATAL_FAILURE(BringUpWith("within 20 s of Active b in LowPower\n"));
  network_.RunFor(std::chrono::seconds(10));
  EXPECT_THAT(Recorded(), IsEmpty());
  network_.RunFor(std::chrono::seconds(30));
  EXPECT_THAT(Recorded(),
              ElementsAre("a rule of yours is violated: within 20 s of Active b in LowPower (b is "
                          "in Active); nothing is changed"));
  EXPECT_THAT(first_.process->shell().Status().violated_rules,
              ElementsAre("within 20 s of Active b in LowPower"));
  ASSERT_NO_FATAL_FAILURE(Set("LowPower"));
  EXPECT_THAT(first_.process->shell().Status().violated_rules, IsEmpty());
  ASSERT_NO_FATAL_FAILURE(Set("Active"));
  network_.RunFor(std::chrono::seconds(30));
  EXPECT_THAT(Recorded(), SizeIs(1)) << "b was there when this switch began";
}

TEST_F(ViolatedRules, AreNoneWhereTheyHold) {
  ASSERT_NO_FATAL_FAILURE(BringUpWith("never a Active while b is not Active\n"));
  ASSERT_NO_FATAL_FAILURE(Set("LowPower"));
  ASSERT_NO_FATAL_FAILURE(Set("Active"));
  EXPECT_THAT(Recorded(), IsEmpty());
}

}  // namespace musher::testing::rule_record_test
