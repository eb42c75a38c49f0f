// An installer that is killed at each of its operations, on real files.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <filesystem>
#include <fstream>
#include <iostream>

#include "musher/ota/fault.hpp"
#include "musher/ota/install.hpp"
#include "musher/ota/posix_disk.hpp"
#include "musher/ota/signature.hpp"
#include "musher/test/support/paths.hpp"
#include "musher/test/support/process.hpp"
#include "musher/test/support/temp_folder.hpp"

namespace musher::ota::kill_test {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

class RealFiles : public ::testing::Test {
 protected:
  RealFiles() {
    for (const std::string version : {"1.0.0", "1.1.0", "1.2.0"}) Bundle(version);
    EXPECT_TRUE(InitRoot(disk_, root_, folder_ / "1.0.0", keys_.public_pem, {}, {}));
  }

  void Bundle(const std::string& version) {
    const std::string built = folder_ / ("built-" + version);
    fs::create_directories(built + "/bin");
    std::ofstream(built + "/bin/legs") << std::string(10'000, 'l') << version;
    fs::permissions(built + "/bin/legs", fs::perms(0755));
    std::ofstream(built + "/robot.toml") << "# " << version << "\n";
    Manifest manifest;
    manifest.robot = "dog";
    manifest.version = ParseVersion(version).value();
    const auto made = MakeBundle(disk_, built, manifest, keys_.private_pem, folder_ / version, {});
    ASSERT_TRUE(made) << made.error().message;
  }

  // How the installer ended: its exit code, or minus the signal.
  int Install(const std::string& version, int killed_at) const {
    const ::musher::testing::Ended ended = ::musher::testing::RunToEnd(
        {BinDir() + "/ota_killed_installer", root_, folder_ / version, std::to_string(killed_at)});
    return ended.signal == 0 ? ended.exit : -ended.signal;
  }

  const TempFolder folder_;
  const std::string root_ = folder_ / "robot";
  const KeyPair keys_ = MakeKeyPair().value();
  PosixDisk disk_;
};

TEST_F(RealFiles, KilledAtAnyOperationAreFoundWithAVersionThatStarts) {
  const std::string untouched = folder_ / "untouched";
  fs::copy(root_, untouched, fs::copy_options::recursive | fs::copy_options::copy_symlinks);
  int kills = 0;
  for (int number = 1;; ++number) {
    SCOPED_TRACE(number);
    fs::remove_all(root_);
    fs::copy(untouched, root_, fs::copy_options::recursive | fs::copy_options::copy_symlinks);
    const int end = Install("1.1.0", number);
    if (end == 0) break;
    ASSERT_EQ(end, -SIGKILL);
    ++kills;
    const auto root = Root::Open(disk_, root_);
    ASSERT_TRUE(root);
    const auto boot = root.value().Boot();
    ASSERT_TRUE(boot) << boot.error().message;
    ASSERT_TRUE(root.value().Look(boot.value().start));
    if (boot.value().on_trial_boot) {
      ASSERT_TRUE(root.value().EndTrialBoot(boot.value().version.text, Ok()));
    }
    ASSERT_EQ(Install("1.2.0", 0), 0);
    ASSERT_EQ(root.value().Boot().value().version.text, "1.2.0");
  }
  EXPECT_GT(kills, 40);
  std::cout << kills << " kills\n";
}

TEST_F(RealFiles, HaveTheModesOfTheManifestWhateverTheUmaskIs) {
  const mode_t before = umask(077);
  EXPECT_EQ(Install("1.1.0", 0), 0);
  umask(before);
  EXPECT_EQ(disk_.Look(root_ + "/slots/b/bin/legs").value().mode, 0755U);
  EXPECT_EQ(disk_.Look(root_ + "/slots/b/robot.toml").value().mode, 0644U);
}

TEST_F(RealFiles, ThatAreLinksOrPipesAreNotOpened) {
  ASSERT_TRUE(disk_.MakeLink("/etc/passwd", folder_ / "link"));
  EXPECT_FALSE(disk_.Open(folder_ / "link"));
  ASSERT_EQ(mkfifo((folder_ / "pipe").c_str(), 0600), 0);
  const auto pipe = disk_.Open(folder_ / "pipe");
  ASSERT_FALSE(pipe);
  EXPECT_THAT(pipe.error().message, HasSubstr("is not a plain file"));
}

TEST_F(RealFiles, ThatAreLockedSayByWhomAndAreFreeAgainWhenTheLockIsDropped) {
  const std::string file = folder_ / "lock";
  EXPECT_EQ(HolderOf(file), 0);
  {
    const auto lock = disk_.Take(file, false);
    ASSERT_TRUE(lock);
    EXPECT_EQ(HolderOf(file), getpid());
    const auto second = disk_.Take(file, false);
    ASSERT_FALSE(second);
    EXPECT_THAT(second.error().message, HasSubstr("process " + std::to_string(getpid())));
  }
  EXPECT_EQ(HolderOf(file), 0);
}

// A slot that is a link would have its files written, or removed, elsewhere.
TEST_F(RealFiles, BehindASlotThatIsALinkAreLeftAlone) {
  const std::string elsewhere = folder_ / "elsewhere";
  fs::create_directory(elsewhere);
  std::ofstream(elsewhere + "/precious") << "x";
  fs::remove_all(root_ + "/slots/b");
  fs::create_symlink(elsewhere, root_ + "/slots/b");
  EXPECT_EQ(Install("1.1.0", 0), 0);
  EXPECT_TRUE(fs::exists(elsewhere + "/precious"));
  EXPECT_FALSE(fs::is_symlink(root_ + "/slots/b"));
}

// What we sign, OpenSSL's own program takes for signed.
TEST_F(RealFiles, AreSignedAsTheOpensslProgramHasIt) {
  if (std::system("command -v openssl >/dev/null") != 0) GTEST_SKIP() << "no openssl here";
  const std::string bundle = folder_ / "1.0.0";
  const std::string verify = "openssl pkeyutl -verify -rawin -pubin -inkey " + root_ +
                             "/ota.pub -in " + bundle + "/manifest.toml -sigfile " + bundle +
                             "/manifest.sig >/dev/null";
  EXPECT_EQ(std::system(verify.c_str()), 0);
  std::ofstream(bundle + "/manifest.toml", std::ios::app) << "#";
  EXPECT_NE(std::system((verify + " 2>&1").c_str()), 0);
}

}  // namespace musher::ota::kill_test
