// A disk that fills up, fails or is read-only, at any operation.

#include <utility>

#include "musher/test/ota/robot_on_disk.hpp"

namespace musher::ota::testing::disk_trouble_test {

using ::testing::HasSubstr;

class DiskTrouble : public ::testing::Test {
 protected:
  DiskTrouble() : disk_(DiskWith({"1.0.0", "1.1.0", "1.2.0"})) {}

  // Every operation from this one on fails, as on a disk that is full.
  void FailFrom(int operation) {
    count_ = 0;
    disk_->fail = [this, operation](const std::string& what) -> Result<> {
      if (++count_ < operation || what.starts_with("remove")) return Ok();
      return FaultError(Fault::kNoSpace, what + ": No space left on device");
    };
  }

  std::unique_ptr<SimDisk> disk_;
  int count_ = 0;
};

TEST_F(DiskTrouble, FullAtAnyOperationEndsTheInstallationAndHarmsNothing) {
  int failures = 0;
  for (int operation = 1;; ++operation) {
    SCOPED_TRACE(operation);
    disk_ = DiskWith({"1.0.0", "1.1.0", "1.2.0"});
    FailFrom(operation);
    const auto installed = Install(*disk_, BundleOf("1.1.0"));
    disk_->fail = nullptr;
    if (installed) break;
    ++failures;
    ASSERT_TRUE(Is(installed.error(), Fault::kNoSpace)) << installed.error().message;
    const auto boot = OpenRoot(*disk_).Boot();
    ASSERT_TRUE(boot);
    // Only once the last rename is done it is not known whether it will survive.
    ASSERT_TRUE(Holds(*disk_, boot.value().start, boot.value().version.text));
    if (boot.value().on_trial_boot) {
      ASSERT_TRUE(OpenRoot(*disk_).EndTrialBoot("1.1.0", Ok()));
    }
    ASSERT_TRUE(Install(*disk_, BundleOf("1.2.0")));
    ASSERT_TRUE(Holds(*disk_, OpenRoot(*disk_).Boot().value().start, "1.2.0"));
  }
  EXPECT_GT(failures, 30);
  std::cout << failures << " operations on a full disk\n";
}

TEST_F(DiskTrouble, ATrialBootThatCannotBeSavedIsNotBegun) {
  ASSERT_TRUE(Install(*disk_, BundleOf("1.1.0")));
  FailFrom(1);
  const auto boot = OpenRoot(*disk_).Boot();
  ASSERT_TRUE(boot);
  EXPECT_FALSE(boot.value().on_trial_boot);
  EXPECT_EQ(boot.value().version.text, "1.0.0");
  EXPECT_THAT(boot.value().reason, HasSubstr("but not now"));
  disk_->fail = nullptr;
  EXPECT_TRUE(OpenRoot(*disk_).Boot().value().on_trial_boot);
}

TEST_F(DiskTrouble, ATrialBootWhoseOutcomeCannotBeSavedIsRolledBackByTheNextStart) {
  ASSERT_TRUE(Install(*disk_, BundleOf("1.1.0")));
  ASSERT_TRUE(OpenRoot(*disk_).Boot().value().on_trial_boot);
  FailFrom(1);
  EXPECT_FALSE(OpenRoot(*disk_).EndTrialBoot("1.1.0", Ok()));
  const auto boot = OpenRoot(*disk_).Boot();  // nor can this be written
  ASSERT_TRUE(boot);
  EXPECT_EQ(boot.value().version.text, "1.0.0");
  EXPECT_THAT(boot.value().reason, HasSubstr("this cannot be saved"));
}

// The file had its new content already: "mark for the trial boot" was reported as failed, and the
// next start tried that version.
TEST_F(DiskTrouble, AMarkWhoseFolderCannotBeSyncedStartsNoTrialBoot) {
  bool failed = false;
  disk_->fail = [&](const std::string& what) -> Result<> {
    if (failed || what != "sync /robot" || !OpenRoot(*disk_).LoadState()->on_trial_boot) {
      return Ok();
    }
    failed = true;
    return Error{kCodeFailed, what + ": Input/output error"};
  };
  const auto installed = Install(*disk_, BundleOf("1.1.0"));
  ASSERT_FALSE(installed);
  EXPECT_THAT(installed.error().message, HasSubstr("Input/output error"));
  ASSERT_TRUE(failed);
  const auto boot = OpenRoot(*disk_).Boot();
  ASSERT_TRUE(boot);
  EXPECT_FALSE(boot.value().on_trial_boot);
  EXPECT_EQ(boot.value().version.text, "1.0.0");
  ASSERT_TRUE(Install(*disk_, BundleOf("1.1.0")));
  EXPECT_TRUE(OpenRoot(*disk_).Boot().value().on_trial_boot);
}

// It was rolled back, as its controller reports, and the next start began it as a version that was
// kept.
TEST_F(DiskTrouble, AKeptVersionWhoseFolderCannotBeSyncedIsRolledBackByTheNextStart) {
  ASSERT_TRUE(Install(*disk_, BundleOf("1.1.0")));
  ASSERT_TRUE(OpenRoot(*disk_).Boot().value().on_trial_boot);
  bool failed = false;
  disk_->fail = [&failed](const std::string& what) -> Result<> {
    if (what != "sync /robot" || std::exchange(failed, true)) return Ok();
    return Error{kCodeFailed, what + ": Input/output error"};
  };
  EXPECT_FALSE(OpenRoot(*disk_).EndTrialBoot("1.1.0", Ok()));
  ASSERT_TRUE(failed);
  const auto boot = OpenRoot(*disk_).Boot();
  ASSERT_TRUE(boot);
  EXPECT_FALSE(boot.value().on_trial_boot);
  EXPECT_EQ(boot.value().version.text, "1.0.0");
}

// A failed version stays failed, whether or not that may be lost with the power.
TEST_F(DiskTrouble, AFailedVersionWhoseFolderCannotBeSyncedIsNotTriedAgain) {
  ASSERT_TRUE(Install(*disk_, BundleOf("1.1.0")));
  ASSERT_TRUE(OpenRoot(*disk_).Boot().value().on_trial_boot);
  disk_->fail = [](const std::string& what) -> Result<> {
    if (what != "sync /robot") return Ok();
    return Error{kCodeFailed, what + ": Input/output error"};
  };
  EXPECT_FALSE(OpenRoot(*disk_).EndTrialBoot("1.1.0", Error{kCodeFailed, "legs: no answer"}));
  const auto boot = OpenRoot(*disk_).Boot(std::nullopt, /*takes_trial=*/true);
  ASSERT_TRUE(boot);
  EXPECT_FALSE(boot.value().on_trial_boot);
  EXPECT_EQ(boot.value().version.text, "1.0.0");
}

// Another controller leads, so this start has not begun it.
TEST_F(DiskTrouble, APostponedTrialBootIsBegunByTheNextStart) {
  ASSERT_TRUE(Install(*disk_, BundleOf("1.1.0")));
  ASSERT_TRUE(OpenRoot(*disk_).Boot().value().on_trial_boot);
  ASSERT_TRUE(OpenRoot(*disk_).PostponeTrialBoot());
  const auto boot = OpenRoot(*disk_).Boot();
  ASSERT_TRUE(boot);
  EXPECT_TRUE(boot.value().on_trial_boot) << boot.value().reason;
  EXPECT_EQ(OpenRoot(*disk_).Boot().value().version.text, "1.0.0") << "its one start is used now";
}

// Its start was put back as used, and the next start rolled back a version that was never begun.
TEST_F(DiskTrouble, APostponedTrialBootWhoseFolderCannotBeSyncedIsBegunByTheNextStart) {
  ASSERT_TRUE(Install(*disk_, BundleOf("1.1.0")));
  ASSERT_TRUE(OpenRoot(*disk_).Boot().value().on_trial_boot);
  bool failed = false;
  disk_->fail = [&failed](const std::string& what) -> Result<> {
    if (what != "sync /robot" || std::exchange(failed, true)) return Ok();
    return Error{kCodeFailed, what + ": Input/output error"};
  };
  EXPECT_FALSE(OpenRoot(*disk_).PostponeTrialBoot());
  ASSERT_TRUE(failed);
  const auto boot = OpenRoot(*disk_).Boot();
  ASSERT_TRUE(boot);
  EXPECT_TRUE(boot.value().on_trial_boot) << boot.value().reason;
  EXPECT_EQ(boot.value().version.text, "1.1.0");
}

TEST_F(DiskTrouble, ReadOnlyRobotsStart) {
  FailFrom(1);
  const auto boot = OpenRoot(*disk_).Boot();
  ASSERT_TRUE(boot);
  EXPECT_EQ(boot.value().version.text, "1.0.0");
  EXPECT_EQ(boot.value().reason, "");
}

TEST_F(DiskTrouble, ADamagedConfirmedVersionIsReplacedByTheOther) {
  ASSERT_TRUE(Install(*disk_, BundleOf("1.1.0")));
  ASSERT_TRUE(OpenRoot(*disk_).Boot().value().on_trial_boot);
  ASSERT_TRUE(OpenRoot(*disk_).EndTrialBoot("1.1.0", Ok()));
  disk_->Put("/robot/slots/b/bin/legs", "?");
  const auto boot = OpenRoot(*disk_).Boot();
  ASSERT_TRUE(boot);
  EXPECT_EQ(boot.value().version.text, "1.0.0");
  EXPECT_THAT(boot.value().reason, HasSubstr("slot b is damaged"));
  EXPECT_EQ(OpenRoot(*disk_).Boot().value().reason, "");
}

// A takeover in a trial boot: both controllers find the version good, and the second one rolled it
// back.
TEST_F(DiskTrouble, AVersionThatIsKeptMayBeKeptAgain) {
  ASSERT_TRUE(Install(*disk_, BundleOf("1.1.0")));
  ASSERT_TRUE(OpenRoot(*disk_).Boot().value().on_trial_boot);
  ASSERT_TRUE(OpenRoot(*disk_).EndTrialBoot("1.1.0", Ok()));
  const auto kept = OpenRoot(*disk_).LoadState();
  EXPECT_TRUE(OpenRoot(*disk_).EndTrialBoot("1.1.0", Ok()));
  EXPECT_FALSE(OpenRoot(*disk_).EndTrialBoot("1.2.0", Ok()));
  EXPECT_FALSE(OpenRoot(*disk_).EndTrialBoot("1.1.0", Error{kCodeFailed, "it is late"}));
  EXPECT_EQ(OpenRoot(*disk_).LoadState(), kept);
}

// The slot's programs come first on PATH.
TEST_F(DiskTrouble, AVersionWithAProgramThatWasNotSignedIsNotStarted) {
  ASSERT_TRUE(Install(*disk_, BundleOf("1.1.0")));
  ASSERT_TRUE(OpenRoot(*disk_).Boot().value().on_trial_boot);
  ASSERT_TRUE(OpenRoot(*disk_).EndTrialBoot("1.1.0", Ok()));
  const std::string program = "/robot/slots/b/bin/sh";
  ASSERT_TRUE(disk_->Create(program, 0755));
  auto boot = OpenRoot(*disk_).Boot();
  ASSERT_TRUE(boot);
  EXPECT_EQ(boot.value().version.text, "1.0.0");
  EXPECT_THAT(boot.value().reason, HasSubstr("bin/sh is not in the signed manifest"));
  disk_->PutLink("/robot/slots/a/bin/musher-audio", "/tmp/elsewhere");
  boot = OpenRoot(*disk_).Boot();
  ASSERT_FALSE(boot) << "a link can lead to any program";
  EXPECT_THAT(boot.error().message, HasSubstr("bin/musher-audio is not in the signed manifest"));
}

TEST_F(DiskTrouble, WhatAModuleLeavesBesideItsProgramAndCannotBeRunIsOfNoInterest) {
  disk_->Put("/robot/slots/a/bin/__pycache__/legs.pyc", "x");
  ASSERT_TRUE(disk_->Create("/robot/slots/a/bin/legs.log", 0644));
  ASSERT_TRUE(disk_->Create("/robot/slots/a/data/tool", 0755)) << "not on PATH";
  const auto boot = OpenRoot(*disk_).Boot();
  ASSERT_TRUE(boot);
  EXPECT_EQ(boot.value().version.text, "1.0.0");
  EXPECT_EQ(boot.value().reason, "");
}

TEST_F(DiskTrouble, AStateThatIsDamagedOrLostLeavesTheVersionThatTheLinkNames) {
  ASSERT_TRUE(Install(*disk_, BundleOf("1.1.0")));
  ASSERT_TRUE(OpenRoot(*disk_).Boot().value().on_trial_boot);
  ASSERT_TRUE(OpenRoot(*disk_).EndTrialBoot("1.1.0", Ok()));
  const std::string whole = disk_->Content("/robot/ota_state");
  for (std::size_t size = 0; size < whole.size(); ++size) {
    disk_->Put("/robot/ota_state", whole.substr(0, size));
    const auto boot = OpenRoot(*disk_).Boot();
    ASSERT_TRUE(boot);
    ASSERT_EQ(boot.value().version.text, "1.1.0") << size;
    ASSERT_THAT(boot.value().reason, HasSubstr("is lost"));
  }
}

TEST_F(DiskTrouble, WithoutStateAndLinkTheOlderVersionIsStarted) {
  ASSERT_TRUE(Install(*disk_, BundleOf("1.1.0")));
  ASSERT_TRUE(disk_->Remove("/robot/ota_state"));
  ASSERT_TRUE(disk_->Remove("/robot/current"));
  EXPECT_EQ(OpenRoot(*disk_).Boot().value().version.text, "1.0.0");
}

TEST_F(DiskTrouble, WithoutAnIntactVersionItReportsTheDamageOfEach) {
  disk_->Put("/robot/slots/a/bin/legs", "?");
  const auto boot = OpenRoot(*disk_).Boot();
  ASSERT_FALSE(boot);
  EXPECT_TRUE(Is(boot.error(), Fault::kNoVersion));
  EXPECT_THAT(boot.error().message, HasSubstr("bin/legs has 1 bytes instead of 705"));
  EXPECT_THAT(boot.error().message, HasSubstr("slot b: /robot/slots/b/manifest.toml is missing"));
}

}  // namespace musher::ota::testing::disk_trouble_test
