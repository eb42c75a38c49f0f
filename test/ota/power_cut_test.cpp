// The power fails at any time of an upgrade. Whatever the disk has kept of the unsynced data,
// the robot starts a version that is whole, and can be upgraded.

#include <set>

#include "musher/test/ota/robot_on_disk.hpp"
#include "musher/test/support/nightly.hpp"

namespace musher::ota::testing::power_cut_test {

using Lost = SimDisk::Lost;

// Goes through a robot's life and cuts the power at each of its steps.
class Life {
 public:
  // `seeds`: the number of random losses for each time.
  Life(std::unique_ptr<SimDisk> disk, int seeds) : seeds_(seeds), disk_(std::move(disk)) {
    disk_->on_step = [this](const std::string& what) { CutHere(what); };
  }

  SimDisk& disk() { return *disk_; }
  int cuts() const { return cuts_; }
  const std::vector<std::string>& faults() const { return faults_; }

  // From now on the robot may start these, and no others.
  void MayStart(std::set<std::string> versions) { may_start_ = std::move(versions); }

  void Upgrade(const std::string& version, bool keeps) {
    const std::set<std::string> before = may_start_;
    may_start_.insert(version);
    ASSERT_TRUE(Install(*disk_, BundleOf(version)));
    EndTrialBoot(version, keeps, before);
  }
  void GoBack(const std::string& version) {
    const std::set<std::string> before = may_start_;
    may_start_.insert(version);
    ASSERT_TRUE(MarkRollback(OpenRoot(*disk_), std::nullopt));
    EndTrialBoot(version, true, before);
  }

 private:
  void EndTrialBoot(const std::string& version, bool keeps, const std::set<std::string>& before) {
    const Root root = OpenRoot(*disk_);
    const auto boot = root.Boot();
    ASSERT_TRUE(boot);
    ASSERT_TRUE(boot.value().on_trial_boot) << boot.value().reason;
    ASSERT_EQ(boot.value().version.text, version);
    const Result<> outcome = keeps ? Ok() : Result<>(Error{kCodeFailed, "the legs do not answer"});
    ASSERT_TRUE(root.EndTrialBoot(version, outcome));
    may_start_ = keeps ? std::set<std::string>{version} : before;
  }

  void CutHere(const std::string& what) {
    CheckAfterCut(what, Lost::kAll, 0);
    CheckAfterCut(what, Lost::kNothing, 0);
    for (int i = 0; i < seeds_; ++i) CheckAfterCut(what, Lost::kSome, seed_++);
  }

  void CheckAfterCut(const std::string& what, Lost lost, std::uint64_t seed) {
    ++cuts_;
    const auto disk = disk_->AfterPowerCut(lost, seed);
    const std::string fault = FaultOf(*disk);
    if (!fault.empty()) faults_.push_back(what + ", seed " + std::to_string(seed) + ": " + fault);
  }

  // What is wrong with a disk on which the power was cut; empty: nothing.
  std::string FaultOf(SimDisk& disk) const {
    const auto root = Root::Open(disk, kRoot);
    if (!root) return root.error().message;
    const auto state = root.value().LoadState();
    if (!state) return "ota_state is not whole";
    if (state->on_trial_boot && !root.value().Look(Other(state->confirmed))) {
      return "a version is on trial that is not whole";
    }
    const auto boot = root.value().Boot();
    if (!boot) return boot.error().message;
    const std::string version = boot.value().version.text;
    if (!may_start_.contains(version)) return "starts version " + version;
    if (!Holds(disk, boot.value().start, version)) return "version " + version + " is not whole";
    if (boot.value().on_trial_boot && !root.value().EndTrialBoot(version, Ok()))
      return "cannot keep it";
    if (const auto again = Install(disk, BundleOf("9.0.0")); !again) return again.error().message;
    const auto next = root.value().Boot();
    if (!next || !next.value().on_trial_boot || !Holds(disk, next.value().start, "9.0.0")) {
      return "the next upgrade is not tried";
    }
    return "";
  }

  const int seeds_;
  std::unique_ptr<SimDisk> disk_;
  std::set<std::string> may_start_;
  int cuts_ = 0;
  std::uint64_t seed_ = 1;
  std::vector<std::string> faults_;
};

std::string FirstOf(const std::vector<std::string>& faults) {
  return faults.empty() ? "" : std::to_string(faults.size()) + " faults, first: " + faults.front();
}

TEST(PowerCut, LeavesAVersionThatStartsAfterEveryOperation) {
  const int seeds = musher::testing::Nightly() ? 12 : 1;
  Life life(DiskWith({"1.0.0", "1.1.0", "1.2.0", "1.3.0", "9.0.0"}), seeds);
  life.MayStart({"1.0.0"});
  life.Upgrade("1.1.0", true);   // into an empty slot
  life.Upgrade("1.2.0", false);  // over an older version, and back
  life.Upgrade("1.3.0", true);   // over one that had failed
  life.GoBack("1.1.0");
  EXPECT_EQ(life.faults().size(), 0U) << FirstOf(life.faults());
  EXPECT_GT(life.cuts(), 200 * (2 + seeds));
  RecordProperty("power_cuts", life.cuts());
  std::cout << life.cuts() << " power cuts, " << life.faults().size() << " faults\n";
}

TEST(PowerCut, WhileANewRootIsMadeLeavesItToBeMadeAgain) {
  auto disk = std::make_unique<SimDisk>();
  MakeBundleOf(*disk, ManifestOf("1.0.0"), BundleOf("1.0.0"));
  std::uint64_t seed = 1;
  int cuts = 0;
  disk->on_step = [&](const std::string& what) {
    for (const Lost lost : {Lost::kAll, Lost::kNothing, Lost::kSome, Lost::kSome}) {
      const auto after = disk->AfterPowerCut(lost, seed++);
      ++cuts;
      const bool is_root = after->IsThere(std::string(kRoot) + "/ota_state");
      if (!is_root) {
        const auto again = InitRoot(*after, kRoot, BundleOf("1.0.0"), TheKeys().public_pem, {}, {});
        ASSERT_TRUE(again) << what << ": " << again.error().message;
      }
      const auto boot = OpenRoot(*after).Boot();
      ASSERT_TRUE(boot) << what << ": " << boot.error().message;
      ASSERT_TRUE(Holds(*after, boot.value().start, "1.0.0")) << what;
    }
  };
  ASSERT_TRUE(InitRoot(*disk, kRoot, BundleOf("1.0.0"), TheKeys().public_pem, {}, {}));
  EXPECT_GT(cuts, 100);
}

// The cuts must find what is wrong, else they say nothing.

class Flaw : public ::testing::Test {
 protected:
  Flaw() : life_(DiskWith({"1.0.0", "1.1.0", "9.0.0"}), 2) { life_.MayStart({"1.0.0", "1.1.0"}); }
  Life life_;
};

TEST_F(Flaw, AFileThatIsNotSyncedIsFound) {
  life_.disk().forgets_to_sync = [](const std::string& path) { return path.ends_with("bin/legs"); };
  ASSERT_TRUE(Install(life_.disk(), BundleOf("1.1.0")));
  ASSERT_TRUE(OpenRoot(life_.disk()).Boot());
  EXPECT_GT(life_.faults().size(), 0U);
}

TEST_F(Flaw, AFolderThatIsNotSyncedIsFound) {
  life_.disk().forgets_to_sync = [](const std::string& path) { return path.ends_with("slots/b"); };
  ASSERT_TRUE(Install(life_.disk(), BundleOf("1.1.0")));
  ASSERT_TRUE(OpenRoot(life_.disk()).Boot());
  EXPECT_GT(life_.faults().size(), 0U);
}

TEST_F(Flaw, AStateThatIsRenamedBeforeItIsSyncedIsFound) {
  life_.disk().forgets_to_sync = [](const std::string& path) {
    return path.ends_with("ota_state.new");
  };
  ASSERT_TRUE(Install(life_.disk(), BundleOf("1.1.0")));
  EXPECT_GT(life_.faults().size(), 0U);
}

TEST_F(Flaw, ATrialBootThatIsMarkedBeforeItIsWrittenIsFound) {
  const Root root = OpenRoot(life_.disk());
  auto steps = Installation::Begin(root, BundleOf("1.1.0"), {}, std::nullopt);
  ASSERT_TRUE(steps && steps.value().Check({}) && steps.value().Prepare());
  ASSERT_TRUE(steps.value().MarkTrialBoot());
  ASSERT_TRUE(steps.value().Copy({}));
  EXPECT_GT(life_.faults().size(), 0U);
}

}  // namespace musher::ota::testing::power_cut_test
