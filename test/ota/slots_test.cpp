// Versions, the state and the choice of a slot: what needs no disk.

#include "musher/ota/slots.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "musher/ota/fault.hpp"
#include "musher/ota/install_flow.hpp"
#include "musher/ota/root.hpp"

namespace musher::ota::slots_test {

using ::testing::HasSubstr;

TEST(Versions, AreOrderedAsSemverHasIt) {
  const std::vector<std::string> ascending = {
      "0.9.9",      "1.0.0-1",    "1.0.0-2",  "1.0.0-10", "1.0.0-alpha", "1.0.0-alpha.1",
      "1.0.0-beta", "1.0.0-rc.1", "1.0.0",    "1.0.1",    "1.2.0",       "1.10.0",
      "2.0.0",      "10.0.0-a-b", "10.0.0+x", "10.0.1"};
  for (std::size_t i = 0; i < ascending.size(); ++i) {
    for (std::size_t k = 0; k < ascending.size(); ++k) {
      const auto a = ParseVersion(ascending[i]);
      const auto b = ParseVersion(ascending[k]);
      ASSERT_TRUE(a && b);
      EXPECT_EQ(Compare(*a, *b), i <=> k) << ascending[i] << " and " << ascending[k];
    }
  }
}

TEST(Versions, DifferingOnlyInTheirBuildAreTheSame) {
  EXPECT_TRUE(Compare(*ParseVersion("1.0.0+a"), *ParseVersion("1.0.0+b")) == 0);
}

TEST(Versions, ThatAreNoneAreRefused) {
  for (const std::string text :
       {"", "1", "1.0", "1.0.0.0", "01.0.0", "1.0.x", "v1.0.0", "1.0.0-", "1.0.0-a..b", "1.0.0-01",
        "1.0.0+", "1.0.0 ", "-1.0.0", "99999999999999999999.0.0", "1.0.0-\"'"}) {
    EXPECT_FALSE(ParseVersion(text)) << text;
  }
}

SlotContent Holds(const std::string& version) {
  return *ParseVersion(version);
}
SlotContent Damaged() {
  return FaultError(Fault::kAltered, "a file is altered");
}

struct Content {
  SlotContent a;
  SlotContent b;
  LookIntoSlot Look() const {
    return [this](Slot slot) { return slot == Slot::kA ? a : b; };
  }
};

TEST(SlotStates, SurviveTheDisk) {
  for (const Slot confirmed : {Slot::kA, Slot::kB}) {
    for (int flags = 0; flags < 8; ++flags) {
      SlotState state{confirmed, (flags & 1) != 0, (flags & 2) != 0, (flags & 4) != 0, {}};
      EXPECT_EQ(ParseState(FormatState(state)), state);
      state.last = TrialBootEnd{Slot::kB, "1.2.0", false, "legs: \"it's\"\nbroken"};
      state.last->reason = "legs: said \"no\" in one line";
      state.installing = "1.3.0";
      EXPECT_EQ(ParseState(FormatState(state)), state);
    }
  }
}

TEST(SlotStates, ThatWereAlteredAnywhereAreRejected) {
  const std::string whole = FormatState({Slot::kB, true, false, true, {}});
  for (std::size_t i = 0; i < whole.size(); ++i) {
    std::string altered = whole;
    altered[i] ^= 4;
    EXPECT_FALSE(ParseState(altered)) << i;
  }
}

TEST(Boots, StartWhatIsConfirmed) {
  const Content content{Holds("1.0.0"), Holds("2.0.0")};
  const auto boot = DecideBoot(SlotState{Slot::kA, false, false, true, {}}, {}, content.Look());
  ASSERT_TRUE(boot);
  EXPECT_EQ(boot.value().start, Slot::kA);
  EXPECT_FALSE(boot.value().on_trial_boot);
  EXPECT_EQ(boot.value().reason, "");
}

TEST(Boots, LookIntoOneSlotOnlyWhereThatIsEnough) {
  int looks = 0;
  const auto boot = DecideBoot(SlotState{}, {}, [&looks](Slot) {
    ++looks;
    return Holds("1.0.0");
  });
  EXPECT_TRUE(boot);
  EXPECT_EQ(looks, 1);
}

TEST(Boots, TryAVersionOnce) {
  const Content content{Holds("1.0.0"), Holds("2.0.0")};
  SlotState state{Slot::kA, true, false, false, {}};
  const auto first = DecideBoot(state, {}, content.Look());
  ASSERT_TRUE(first);
  EXPECT_EQ(first.value().start, Slot::kB);
  EXPECT_TRUE(first.value().on_trial_boot);
  const auto second = DecideBoot(first.value().next, {}, content.Look());
  ASSERT_TRUE(second);
  EXPECT_EQ(second.value().start, Slot::kA);
  EXPECT_FALSE(second.value().next.on_trial_boot);
  EXPECT_FALSE(second.value().next.other_good);
  EXPECT_THAT(second.value().reason, HasSubstr("its trial boot did not finish"));
  const auto third = DecideBoot(second.value().next, {}, content.Look());
  EXPECT_EQ(third.value().reason, "");
}

TEST(Boots, DoNotTryADamagedVersion) {
  const Content content{Holds("1.0.0"), Damaged()};
  const auto boot = DecideBoot(SlotState{Slot::kA, true, false, false, {}}, {}, content.Look());
  ASSERT_TRUE(boot);
  EXPECT_EQ(boot.value().start, Slot::kA);
  EXPECT_THAT(boot.value().reason, HasSubstr("a file is altered"));
}

TEST(Boots, StartAVersionThatFailedRatherThanNone) {
  const Content content{Damaged(), Holds("2.0.0")};
  const auto boot = DecideBoot(SlotState{Slot::kA, true, true, false, {}}, {}, content.Look());
  ASSERT_TRUE(boot);
  EXPECT_EQ(boot.value().start, Slot::kB);
  EXPECT_EQ(boot.value().next.confirmed, Slot::kB);
}

// Whatever is remembered, and whatever the slots hold: a version that verifies is started if there
// is one, and the state that follows leads to a start as well.
TEST(Boots, FindAVersionWhereverThereIsOne) {
  for (const bool a : {false, true}) {
    for (const bool b : {false, true}) {
      const Content content{a ? Holds("1.0.0") : Damaged(), b ? Holds("2.0.0") : Damaged()};
      for (const std::optional<Slot> link :
           {std::optional<Slot>(), std::optional(Slot::kA), std::optional(Slot::kB)}) {
        for (int i = 0; i < 17; ++i) {
          std::optional<SlotState> state;
          if (i > 0) {
            const int flags = i - 1;
            state = SlotState{(flags & 8) != 0 ? Slot::kA : Slot::kB,
                              (flags & 1) != 0,
                              (flags & 2) != 0,
                              (flags & 4) != 0,
                              {}};
          }
          const auto boot = DecideBoot(state, link, content.Look());
          ASSERT_EQ(boot.ok(), a || b);
          if (!boot) continue;
          ASSERT_TRUE(boot.value().start == Slot::kA ? a : b);
          const auto next = DecideBoot(boot.value().next, link, content.Look());
          ASSERT_TRUE(next);
          ASSERT_FALSE(next.value().on_trial_boot);
        }
      }
    }
  }
}

// A process ends only after TearDown: a robot that stands does not fall.
TEST(Boots, LeaveAPendingTrialBootForLaterWhileActuatorsRunFromTheOtherSlot) {
  const Content content{Holds("1.0.0"), Holds("1.1.0")};
  const SlotState pending{Slot::kA, true, false, false, {}};
  const auto boot = DecideBoot(pending, {}, content.Look(), Slot::kA);
  ASSERT_TRUE(boot);
  EXPECT_EQ(boot.value().start, Slot::kA);
  EXPECT_FALSE(boot.value().on_trial_boot);
  EXPECT_FALSE(boot.value().takes_down);
  EXPECT_EQ(boot.value().next, pending);
  EXPECT_THAT(boot.value().reason, HasSubstr("the trial boot of slot b, version 1.1.0, waits"));
}

TEST(Boots, TakeDownTheVersionThatIsRolledBackWhileItsActuatorsRun) {
  const Content content{Holds("1.0.0"), Holds("1.1.0")};
  const SlotState started{Slot::kA, true, true, false, {}};
  const auto boot = DecideBoot(started, {}, content.Look(), Slot::kB);
  ASSERT_TRUE(boot);
  EXPECT_EQ(boot.value().start, Slot::kB);
  EXPECT_FALSE(boot.value().on_trial_boot);
  EXPECT_TRUE(boot.value().takes_down);
  EXPECT_EQ(boot.value().next, started) << "saved once the TearDown is under way";
  const auto down = DecideBoot(boot.value().next, {}, content.Look());
  ASSERT_TRUE(down);
  EXPECT_EQ(down.value().start, Slot::kA);
  EXPECT_THAT(down.value().reason, HasSubstr("its trial boot did not finish"));
  EXPECT_FALSE(down.value().next.taking_down);
}

// The new version may be why the controller crashes.
TEST(Boots, RollBackAtOnceIfTakingTheVersionDownHasNotFinishedBefore) {
  const Content content{Holds("1.0.0"), Holds("1.1.0")};
  SlotState state{Slot::kA, true, true, false, {}};
  state.taking_down = true;
  ASSERT_EQ(ParseState(FormatState(state)), state);
  const auto boot = DecideBoot(state, {}, content.Look(), Slot::kB);
  ASSERT_TRUE(boot);
  EXPECT_EQ(boot.value().start, Slot::kA);
  EXPECT_FALSE(boot.value().takes_down);
}

TEST(Boots, DoNotStartARunningVersionThatWasAltered) {
  const Content content{Holds("1.0.0"), Damaged()};
  const auto boot = DecideBoot(SlotState{}, {}, content.Look(), Slot::kB);
  ASSERT_TRUE(boot);
  EXPECT_EQ(boot.value().start, Slot::kA);
}

TEST(Flows, TakeTheMachineOutOfOtaAfterEveryFailureBeforeTheTrialBoot) {
  const Flow whole = InstallFlow(true);
  for (std::size_t failing = 0; failing < whole.left.size(); ++failing) {
    Flow flow = whole;
    for (std::size_t i = 0; i < failing; ++i) Advance(flow, Ok());
    const Step step = flow.left.front();
    SCOPED_TRACE(StepName(step));
    Advance(flow, Error{kCodeFailed, "no"});
    EXPECT_EQ(flow.failure->message, "no");
    const bool was_there = step == Step::kEnterOta || step == Step::kPrepare ||
                           step == Step::kCopy || step == Step::kCheckWritten ||
                           step == Step::kMarkTrialBoot;
    ASSERT_EQ(flow.left.size(), was_there ? 1U : 0U);
    if (!was_there) continue;
    EXPECT_EQ(flow.left.front(), Step::kLeaveOta);
    Advance(flow, Error{kCodeFailed, "not even that"});
    EXPECT_EQ(flow.failure->message, "no");
    EXPECT_EQ(flow.afterwards->message, "not even that");
    EXPECT_TRUE(flow.left.empty());
  }
}

TEST(Flows, WithoutAMachineHaveNoStepThatNeedsOne) {
  for (Flow flow : {InstallFlow(false), RollbackFlow(false)}) {
    for (; !flow.left.empty(); Advance(flow, Ok())) {
      const Step step = flow.left.front();
      EXPECT_TRUE(step == Step::kCheck || step == Step::kPrepare || step == Step::kCopy ||
                  step == Step::kCheckWritten || step == Step::kMarkTrialBoot);
    }
    EXPECT_FALSE(flow.failure);
  }
}

TEST(RootFile, IsReadBackAsItWasWritten) {
  RootConfig config{"dog", "keys/ota.pub", "config/robot.toml", std::chrono::seconds(20)};
  const auto read = ParseRootConfig(FormatRootConfig(config), "ota.toml");
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read.value(), config);
}

TEST(RootFile, HasAllItsErrorsReported) {
  const auto read =
      ParseRootConfig("robot = \"a b\"\nconfig = \"/etc/x\"\ntrail_s = 3\n", "ota.toml");
  ASSERT_FALSE(read);
  EXPECT_THAT(read.error().message, HasSubstr("ota.toml:1:9: error: robot"));
  EXPECT_THAT(read.error().message, HasSubstr("ota.toml:2:10: error: config"));
  EXPECT_THAT(read.error().message, HasSubstr("did you mean \"trial_s\"?"));
}

}  // namespace musher::ota::slots_test
