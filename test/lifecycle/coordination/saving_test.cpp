// What is not on disk, in the machine and its records.

#include <gmock/gmock.h>

#include "musher/test/lifecycle/coordination/switching.hpp"

namespace musher::testing::saving_test {

using ::testing::IsEmpty;
using ::testing::SizeIs;

TEST(Saving, AJournalThatCannotBeWrittenIsNotOnDiskUntilItIs) {
  Harness t(MachineOf(1));
  t.Begin();
  t.Rest();
  const auto count = [&t](EventName event) {
    return std::ranges::count(t.records, event, &action::Record::event);
  };
  t.Feed(event::SaveEnded{Stored::kJournal, 0, false, "no space"});
  t.Feed(event::SaveEnded{Stored::kJournal, 0, false, "no space"});
  ASSERT_THAT(t.machine().saves.unsaved, SizeIs(1));
  EXPECT_EQ(t.machine().saves.unsaved[0].what, Stored::kJournal);
  EXPECT_EQ(t.machine().saves.unsaved[0].why, "no space");
  EXPECT_EQ(count(EventName::kSaveFailed), 1);
  t.Feed(event::SaveEnded{Stored::kJournal, 0, true, ""});
  EXPECT_THAT(t.machine().saves.unsaved, IsEmpty());
  EXPECT_EQ(count(EventName::kSaveRecovered), 1);
}

}  // namespace musher::testing::saving_test
