// Bundles that must not be taken, each with its own reason, and a robot that is as it was.

#include "musher/test/ota/robot_on_disk.hpp"

namespace musher::ota::testing::bundle_test {

using ::testing::HasSubstr;

class Bundle : public ::testing::Test {
 protected:
  static constexpr const char* kManifest = "/bundles/1.1.0/manifest.toml";
  static constexpr const char* kSignature = "/bundles/1.1.0/manifest.sig";
  static constexpr const char* kLegs = "/bundles/1.1.0/payload/bin/legs";

  Bundle() : disk_(DiskWith({"1.0.0", "1.1.0"})) {}

  // Refused for this reason, in these words, and without a trace.
  void ExpectRefused(Fault fault, const std::string& words, InstallOptions options = {}) {
    int changes = 0;
    disk_->on_step = [&changes](const std::string&) { ++changes; };
    const auto installed = Install(*disk_, BundleOf("1.1.0"), options);
    disk_->on_step = nullptr;
    ASSERT_FALSE(installed);
    EXPECT_TRUE(Is(installed.error(), fault))
        << installed.error().code << ": " << installed.error().message;
    EXPECT_THAT(installed.error().message, HasSubstr(words));
    EXPECT_EQ(changes, 0);
    const auto boot = OpenRoot(*disk_).Boot();
    ASSERT_TRUE(boot);
    EXPECT_EQ(boot.value().version.text, "1.0.0");
  }

  // The manifest says this, and the right key says so, too.
  void PutManifest(const std::string& text) {
    disk_->Put(kManifest, text);
    disk_->Put(kSignature, Sign(text, TheKeys().private_pem).value());
  }
  void Replace(const std::string& part, const std::string& by) {
    std::string text = disk_->Content(kManifest);
    const std::size_t at = text.find(part);
    ASSERT_NE(at, std::string::npos);
    PutManifest(text.replace(at, part.size(), by));
  }
  void PutBundle(const Manifest& manifest) {
    ASSERT_TRUE(RemoveAll(*disk_, BundleOf("1.1.0")));
    MakeBundleOf(*disk_, manifest, BundleOf("1.1.0"));
  }

  std::unique_ptr<SimDisk> disk_;
};

TEST_F(Bundle, ThatIsAllRightIsTaken) {
  ASSERT_TRUE(Install(*disk_, BundleOf("1.1.0")));
  const auto boot = OpenRoot(*disk_).Boot();
  ASSERT_TRUE(boot);
  EXPECT_TRUE(boot.value().on_trial_boot);
  EXPECT_TRUE(Holds(*disk_, Slot::kB, "1.1.0"));
}

TEST_F(Bundle, WithoutASignatureIsRefused) {
  ASSERT_TRUE(disk_->Remove(kSignature));
  ExpectRefused(Fault::kUnsigned, "there is no signature");
}

TEST_F(Bundle, WithACutSignatureIsRefused) {
  disk_->Put(kSignature, disk_->Content(kSignature).substr(0, 63));
  ExpectRefused(Fault::kWrongSignature, "signed with another key, or altered");
}

TEST_F(Bundle, SignedWithAnotherKeyIsRefused) {
  const std::string other = MakeKeyPair().value().private_pem;
  disk_->Put(kSignature, Sign(disk_->Content(kManifest), other).value());
  ExpectRefused(Fault::kWrongSignature, "signed with another key, or altered");
}

TEST_F(Bundle, WhoseManifestWasAlteredAfterwardsIsRefused) {
  std::string text = disk_->Content(kManifest);
  disk_->Put(kManifest, text.replace(text.find("1.1.0"), 5, "1.9.0"));
  ExpectRefused(Fault::kWrongSignature, "signed with another key, or altered");
}

TEST_F(Bundle, WithAnAlteredFileIsRefused) {
  std::string content = disk_->Content(kLegs);
  content[5] ^= 1;
  disk_->Put(kLegs, content);
  ExpectRefused(Fault::kAltered, "bin/legs is not the file that was signed");
}

TEST_F(Bundle, WithACutFileIsRefused) {
  disk_->Put(kLegs, disk_->Content(kLegs).substr(1));
  ExpectRefused(Fault::kAltered, "bin/legs has 704 bytes instead of 705");
}

TEST_F(Bundle, WithAMissingFileIsRefused) {
  ASSERT_TRUE(disk_->Remove(kLegs));
  ExpectRefused(Fault::kMissing, "bin/legs is missing");
}

TEST_F(Bundle, WithAFileThatIsNotListedIsRefused) {
  disk_->Put("/bundles/1.1.0/payload/bin/guest", "x");
  ExpectRefused(Fault::kExtra, "bin/guest is not in the manifest");
}

TEST_F(Bundle, WithALinkInsteadOfAFileIsRefused) {
  ASSERT_TRUE(disk_->Remove(kLegs));
  disk_->PutLink(kLegs, "/bundles/1.0.0/payload/bin/legs");
  ExpectRefused(Fault::kBadPath, "bin/legs is a symbolic link");
}

TEST_F(Bundle, WhosePathsLeaveTheSlotIsRefused) {
  for (const std::string path :
       {"../legs", "bin/../../legs", "bin/..", "./legs", "bin//legs", ""}) {
    SCOPED_TRACE(path);
    Replace("path = 'bin/legs'", "path = '" + path + "'");
    ExpectRefused(Fault::kBadPath, "expected");
    Replace("path = '" + path + "'", "path = 'bin/legs'");
  }
}

TEST_F(Bundle, WithAnAbsolutePathIsRefused) {
  Replace("path = 'bin/legs'", "path = '/etc/passwd'");
  ExpectRefused(Fault::kBadPath, "found an absolute one");
}

TEST_F(Bundle, WithAFileOfMushersOwnIsRefused) {
  Replace("path = 'bin/legs'", "path = 'manifest.toml'");
  ExpectRefused(Fault::kBadPath, "another name than musher's");
}

TEST_F(Bundle, WithAPathTwiceIsRefused) {
  Replace("path = 'bin/voice'", "path = 'bin/legs'");
  ExpectRefused(Fault::kBadPath, "bin/legs is listed twice");
}

TEST_F(Bundle, WithAFileInTheWayOfAFolderIsRefused) {
  Replace("path = 'robot.toml'", "path = 'bin'");
  ExpectRefused(Fault::kBadPath, "bin is listed as a file, and as the folder of bin/legs");
}

TEST_F(Bundle, OfTheSameVersionIsRefused) {
  PutBundle(ManifestOf("1.0.0"));
  ExpectRefused(Fault::kNotNewer, "it is the same version", {.allow_downgrade = true});
}

TEST_F(Bundle, OfAnOlderVersionIsRefusedUnlessItIsAllowed) {
  PutBundle(ManifestOf("0.9.9"));
  ExpectRefused(Fault::kNotNewer, "it is older: version 0.9.9, the robot has 1.0.0");
  EXPECT_TRUE(Install(*disk_, BundleOf("1.1.0"), {.allow_downgrade = true}));
}

TEST_F(Bundle, ThatNeedsANewerVersionBeforeItIsRefused) {
  Manifest manifest = ManifestOf("3.0.0");
  manifest.min_version = ParseVersion("2.0.0");
  PutBundle(manifest);
  ExpectRefused(Fault::kTooFar, "can only upgrade version 2.0.0 or newer, the robot has 1.0.0");
}

TEST_F(Bundle, ForAnotherRobotIsRefused) {
  Manifest manifest = ManifestOf("1.1.0");
  manifest.robot = "cat";
  PutBundle(manifest);
  ExpectRefused(Fault::kOtherRobot, "it is for robot cat, not for dog");
}

TEST_F(Bundle, OfAnUnknownFormatIsRefused) {
  PutManifest("format = 2\nwhatever = \"that is\"\n");
  ExpectRefused(Fault::kUnknownFormat, "has format 2; this musher supports 1");
}

TEST_F(Bundle, WhoseManifestIsNotTomlIsRefused) {
  PutManifest("format = 1\nrobot = \n");
  ExpectRefused(Fault::kBadManifest, "manifest.toml:2:");
}

TEST_F(Bundle, WhoseManifestIsIncompleteIsRefused) {
  Replace("sha256 = \"", "sha255 = \"");
  ExpectRefused(Fault::kBadManifest, "sha25");
}

TEST_F(Bundle, WhoseManifestHas100MbIsRefusedUnread) {
  disk_->Put(kManifest, std::string(100'000'000, '#'));
  ExpectRefused(Fault::kBadManifest, "has 100000000 bytes, at most 4194304 are read");
}

TEST_F(Bundle, ThatDoesNotFitIsRefusedBeforehand) {
  disk_->free_bytes = 1000;
  ExpectRefused(Fault::kNoSpace, "it needs 2 MB in /robot/slots, there are 1 MB");
}

TEST_F(Bundle, ThatIsAFileOrNotThereIsRefused) {
  const auto missing = Install(*disk_, "/bundles/none");
  ASSERT_FALSE(missing);
  EXPECT_TRUE(Is(missing.error(), Fault::kMissing));
  const auto file = Install(*disk_, kLegs);
  ASSERT_FALSE(file);
}

TEST_F(Bundle, ThatChangesBetweenItsCheckAndItsCopyIsNotTried) {
  const Root root = OpenRoot(*disk_);
  auto steps = Installation::Begin(root, BundleOf("1.1.0"), {}, std::nullopt);
  ASSERT_TRUE(steps && steps.value().Check({}) && steps.value().Prepare());
  disk_->Put(kLegs, std::string(705, '?'));
  const auto copied = steps.value().Copy({});
  ASSERT_FALSE(copied);
  EXPECT_TRUE(Is(copied.error(), Fault::kAltered));
  EXPECT_EQ(root.Boot().value().version.text, "1.0.0");
}

TEST_F(Bundle, ThatChangesWhileItIsCopiedIsNotTried) {
  const Root root = OpenRoot(*disk_);
  auto steps = Installation::Begin(root, BundleOf("1.1.0"), {}, std::nullopt);
  ASSERT_TRUE(steps && steps.value().Check({}) && steps.value().Prepare());
  disk_->on_open = [this](const std::string& path) {
    if (path == kLegs) disk_->Put(kLegs, std::string(1'000'000, '?'));
  };
  const auto copied = steps.value().Copy({});
  ASSERT_FALSE(copied);
  EXPECT_THAT(copied.error().message, HasSubstr("grows while it is copied"));
}

TEST_F(Bundle, ThatTheDiskKeepsOtherwiseThanItWasWrittenIsNotTried) {
  const Root root = OpenRoot(*disk_);
  auto steps = Installation::Begin(root, BundleOf("1.1.0"), {}, std::nullopt);
  ASSERT_TRUE(steps && steps.value().Check({}) && steps.value().Prepare());
  ASSERT_TRUE(steps.value().Copy({}));
  disk_->Put("/robot/slots/b/bin/legs", std::string(705, '\0'));
  const auto written = steps.value().CheckWritten({});
  ASSERT_FALSE(written);
  EXPECT_THAT(written.error().message, HasSubstr("cannot be read back from /robot/slots/b"));
}

TEST_F(Bundle, IsNotInstalledByTwoAtOnce) {
  const Root root = OpenRoot(*disk_);
  const auto first = Installation::Begin(root, BundleOf("1.1.0"), {}, std::nullopt);
  ASSERT_TRUE(first);
  const auto second = Installation::Begin(root, BundleOf("1.1.0"), {}, std::nullopt);
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().code, kCodeTargetBusy);
  EXPECT_THAT(second.error().message, HasSubstr("another installation is running"));
}

TEST_F(Bundle, DoesNotGoWhereTheMachineRunsFrom) {
  const Root root = OpenRoot(*disk_);
  const auto installation = Installation::Begin(root, BundleOf("1.1.0"), {}, Slot::kB);
  ASSERT_FALSE(installation);
  EXPECT_THAT(installation.error().message,
              HasSubstr("runs from the slot that the installation would change"));
}

TEST_F(Bundle, IsMadeOfPlainFilesOnly) {
  disk_->PutLink("/built/1.1.0/bin/link", "legs");
  const auto made = MakeBundle(*disk_, "/built/1.1.0", ManifestOf("1.1.0"), TheKeys().private_pem,
                               "/bundles/new", {});
  ASSERT_FALSE(made);
  EXPECT_THAT(made.error().message, HasSubstr("bin/link is a symbolic link"));
  EXPECT_FALSE(disk_->IsThere("/bundles/new"));
}

TEST_F(Bundle, IsNotMadeOverAnother) {
  const auto made = MakeBundle(*disk_, "/built/1.1.0", ManifestOf("1.1.0"), TheKeys().private_pem,
                               BundleOf("1.0.0"), {});
  ASSERT_FALSE(made);
  EXPECT_THAT(made.error().message, HasSubstr("already exists"));
}

TEST_F(Bundle, ReportsWhatIsWrongWithAKey) {
  const auto made = MakeBundle(*disk_, "/built/1.1.0", ManifestOf("1.1.0"), TheKeys().public_pem,
                               "/bundles/new", {});
  ASSERT_FALSE(made);
  EXPECT_THAT(made.error().message, HasSubstr("not an Ed25519 private key"));
}

}  // namespace musher::ota::testing::bundle_test
