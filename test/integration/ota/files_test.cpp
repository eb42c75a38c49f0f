// musher ota keygen, bundle, init, verify: what a person types wrong, and what comes of it.

#include "musher/test/integration/ota/root.hpp"

namespace musher::testing::files_test {

using ::testing::HasSubstr;

class OtaFiles : public RobotWithUpgrades {
 protected:
  void ExpectRefused(std::vector<std::string> words, int exit, const std::string& message) const {
    words.insert(words.begin(), "ota");
    const Ended ended = Musher(words);
    EXPECT_EQ(ended.exit, exit);
    EXPECT_THAT(ended.err, HasSubstr(message));
    words.push_back("--json");
    EXPECT_THAT(std::string(Json(Musher(words).out)["error"]), HasSubstr(message));
  }
  const std::string key_ = folder_ / "key.key";
  const std::string open_ = folder_ / "key.pub";
  const std::string built_ = folder_ / "built-1.0.0";
};

TEST_F(OtaFiles, KeysAreNotReplacedAndNotShown) {
  namespace fs = std::filesystem;
  EXPECT_EQ(fs::status(key_).permissions(), fs::perms::owner_read | fs::perms::owner_write);
  ExpectRefused({"keygen", folder_ / "key"}, 2, "key.key already exists");
}

TEST_F(OtaFiles, AKeyThatOthersCanReadDoesNotSign) {
  std::filesystem::permissions(key_, std::filesystem::perms(0644));
  ExpectRefused({"bundle", built_, "--version", "2.0.0", "--key", key_, "--out", folder_ / "x"}, 2,
                "the signing key is readable by others");
}

TEST_F(OtaFiles, ABundleNeedsAVersionAndAGoodConfig) {
  ExpectRefused({"bundle", built_, "--version", "2.0", "--key", key_, "--out", folder_ / "x"}, 2,
                "--version '2.0' is not MAJOR.MINOR.PATCH");
  std::ofstream(built_ + "/robot.toml") << "[controller]\n";
  const Ended ended = Musher(
      {"ota", "bundle", built_, "--version", "2.0.0", "--key", key_, "--out", folder_ / "x"});
  EXPECT_EQ(ended.exit, 2);
  EXPECT_THAT(ended.err, HasSubstr("robot.toml:1:1: error:"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "x"));
}

TEST_F(OtaFiles, ABundleNeedsAConfigThatCanBeUpgradedAgain) {
  std::ifstream file(built_ + "/robot.toml");
  std::string text((std::istreambuf_iterator<char>(file)), {});
  for (std::size_t at = 0; (at = text.find("\"OTA\"")) != std::string::npos;) {
    text.replace(at, 5, "\"Error\"");
  }
  std::ofstream(built_ + "/robot.toml") << text;
  ExpectRefused({"bundle", built_, "--version", "2.0.0", "--key", key_, "--out", folder_ / "x"}, 2,
                "robot.toml: the machine has no state OTA, which upgrades need");
  EXPECT_FALSE(std::filesystem::exists(folder_ / "x"));
}

TEST_F(OtaFiles, ABundleHasTheRulesThatItsConfigNames) {
  const auto bundle = [&] {
    return Musher(
        {"ota", "bundle", built_, "--version", "2.0.0", "--key", key_, "--out", folder_ / "x"});
  };
  std::ofstream(built_ + "/robot.toml", std::ios::app) << "[safety]\nrules = \"rules.txt\"\n";
  const Ended missing = bundle();
  EXPECT_EQ(missing.exit, 2);
  EXPECT_THAT(missing.err, HasSubstr("safety.rules: " + built_ + "/rules.txt: the file cannot"));
  std::ofstream(built_ + "/rules.txt") << "never leg Active\n";
  const Ended wrong = bundle();
  EXPECT_EQ(wrong.exit, 2);
  EXPECT_THAT(wrong.err, HasSubstr(built_ + "/rules.txt:1:7: error:"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "x"));
  std::ofstream(built_ + "/rules.txt") << "never legs Active while voice is OTA\n";
  const Ended right = bundle();
  EXPECT_EQ(right.exit, 0) << right.err;
  EXPECT_TRUE(std::filesystem::exists(folder_ / "x/payload/rules.txt"));
}

// They may be on the robot, where the bundle does not bring them.
TEST_F(OtaFiles, RulesThatABundleDoesNotHaveAreNamed) {
  std::ofstream(built_ + "/robot.toml", std::ios::app)
      << "[safety]\nrules = \"/etc/dog/rules.txt\"\n";
  const Ended ended = Musher(
      {"ota", "bundle", built_, "--version", "2.0.0", "--key", key_, "--out", folder_ / "x"});
  EXPECT_EQ(ended.exit, 0);
  EXPECT_THAT(ended.err, HasSubstr("/etc/dog/rules.txt, which [safety] rules names, is not in"));
}

TEST_F(OtaFiles, ARootIsNotMadeTwice) {
  ExpectRefused({"init", root_, "--from", Bundle("1.0.0"), "--key", open_}, 1,
                "is already an upgrade root; `musher ota install` upgrades it");
}

TEST_F(OtaFiles, ARootIsNotMadeFromABundleOfAnotherKey) {
  ASSERT_EQ(Musher({"ota", "keygen", folder_ / "other"}).exit, 0);
  ExpectRefused(
      {"init", folder_ / "new", "--from", Bundle("1.0.0"), "--key", folder_ / "other.pub"}, 1,
      "signed with another key, or altered");
  ExpectRefused({"init", folder_ / "new", "--from", Bundle("1.0.0"), "--key", key_}, 2,
                "key.key is not a public key but a private one");
  EXPECT_FALSE(std::filesystem::exists(folder_ / "new"));
}

TEST_F(OtaFiles, VerifyReadsAllAndChangesNothing) {
  Make("1.1.0", {});
  const Ended good = Musher({"ota", "verify", Bundle("1.1.0"), "--json"});
  EXPECT_EQ(good.exit, 0) << good.err;
  EXPECT_THAT(good.out, HasSubstr(R"("version":"1.1.0")"));
  EXPECT_THAT(Musher({"ota", "verify", Bundle("1.1.0")}).out,
              HasSubstr(" bytes; complete, signature valid"));
  EXPECT_EQ(Musher({"ota", "verify", Bundle("1.1.0"), "--key", open_}).exit, 0);
  Make("1.2.0", {.options = {"--robot", "cat"}});
  ExpectRefused({"verify", Bundle("1.2.0")}, 1, "it is for robot cat, not for dog");
  std::filesystem::remove(Bundle("1.1.0") + "/manifest.sig");
  ExpectRefused({"verify", Bundle("1.1.0")}, 1, "there is no signature");
}

TEST_F(OtaFiles, ConfigsThatAreFaultyAreFoundBeforeTheRobotLiesDown) {
  const std::string built = folder_ / "built-1.1.0";
  Make("1.1.0", {});
  // A bundle of another tool: signed, whole, and of no use.
  std::filesystem::remove_all(Bundle("1.1.0"));
  std::ofstream(built + "/robot.toml", std::ios::app) << "[nonsense]\n";
  std::ofstream(built + "/good.toml") << std::ifstream(built_ + "/robot.toml").rdbuf();
  ASSERT_EQ(Musher({"ota", "bundle", built, "--version", "1.1.0", "--key", key_, "--out",
                    Bundle("1.1.0"), "--config", "good.toml"})
                .exit,
            0);
  ASSERT_EQ(UpDetached().exit, 0);
  ExpectRefused({"install", Bundle("1.1.0")}, 1, "its state config is invalid");
  EXPECT_EQ(Where(), "Active from a");
}

TEST_F(OtaFiles, RulesThatAreMissingAreFoundBeforeTheRobotLiesDown) {
  const std::string built = folder_ / "built-1.1.0";
  Make("1.1.0", {});
  std::filesystem::remove_all(Bundle("1.1.0"));
  std::ofstream(built + "/good.toml") << std::ifstream(built_ + "/robot.toml").rdbuf();
  std::ofstream(built + "/robot.toml", std::ios::app) << "[safety]\nrules = \"rules.txt\"\n";
  ASSERT_EQ(Musher({"ota", "bundle", built, "--version", "1.1.0", "--key", key_, "--out",
                    Bundle("1.1.0"), "--config", "good.toml"})
                .exit,
            0);
  ASSERT_EQ(UpDetached().exit, 0);
  ExpectRefused({"install", Bundle("1.1.0")}, 1, "rules.txt: the file cannot be read");
  EXPECT_EQ(Where(), "Active from a");
}

TEST_F(OtaFiles, AFolderThatIsNotAnUpgradeRootIsReported) {
  const Ended up = Musher({"up", folder_.path()});
  EXPECT_EQ(up.exit, 2);
  EXPECT_THAT(up.err, HasSubstr("is not an upgrade root"));
  EXPECT_THAT(up.err, HasSubstr("`musher ota init` makes one"));
}

TEST_F(OtaFiles, TheRootIsThatOfTheRunningMachineWhereNoneIsGiven) {
  unsetenv("MUSHER_OTA_ROOT");
  ASSERT_EQ(UpDetached().exit, 0);
  EXPECT_EQ(Versions()["root"], root_);
  ASSERT_EQ(Musher({"down"}).exit, 0);
  const Ended status = Musher({"ota", "status"});
  EXPECT_EQ(status.exit, 2);
  EXPECT_THAT(status.err,
              HasSubstr("no upgrade root given; use --root FOLDER or $MUSHER_OTA_ROOT"));
}

TEST_F(OtaFiles, AVersionThatRottedIsLeftForTheOther) {
  Make("1.1.0", {});
  ASSERT_EQ(Install("1.1.0").exit, 0);
  ASSERT_EQ(UpDetached().exit, 0);
  ASSERT_EQ(Musher({"down"}).exit, 0);
  std::ofstream(root_ + "/slots/b/legs.toml", std::ios::app) << "#";
  const Ended up = UpDetached();
  EXPECT_EQ(up.exit, 0) << up.err;
  EXPECT_EQ(Where(), "Active from a");
  EXPECT_THAT(History(), HasSubstr("slot b is damaged"));
}

}  // namespace musher::testing::files_test
