// `musher keys` and `musher up` by hand: what is made, and what is said when it is not right.

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>

#include "musher/test/security/secured_machine.hpp"

namespace musher::testing::command_test {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::ContainsRegex;
using ::testing::HasSubstr;

using Keys = SecuredMachine;

mode_t ModeOf(const std::string& file) {
  struct stat info {};
  EXPECT_EQ(stat(file.c_str(), &info), 0) << file;
  return info.st_mode & 0777;
}

TEST_F(Keys, AreReadableByTheirOwnerOnlyWhateverTheMaskIs) {
  const mode_t mask = umask(0);
  const std::string folder = folder_ / "open_mask";
  EXPECT_EQ(Musher({"keys", "init", folder}).exit, 0);
  umask(mask);
  EXPECT_EQ(ModeOf(folder), 0700U);
  EXPECT_EQ(ModeOf(folder + "/ca"), 0700U);
  int keys = 0;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.path().extension() != ".key") continue;
    ++keys;
    EXPECT_EQ(ModeOf(entry.path()), 0600U) << entry.path();
  }
  EXPECT_EQ(keys, 4);  // two CAs, controller, operator
}

TEST_F(Keys, AreNotOverwrittenUnlessForced) {
  const Ended again = Musher({"keys", "init", config_});
  EXPECT_EQ(again.exit, 2);
  EXPECT_THAT(again.err, HasSubstr("already has keys; --force creates new ones"));
  const Ended add = Musher({"keys", "add", "voice"});
  EXPECT_EQ(add.exit, 2);
  EXPECT_THAT(add.err, HasSubstr("voice.key already exists; --force replaces it"));
  EXPECT_EQ(Musher({"keys", "add", "voice", "--force"}).exit, 0);
  EXPECT_EQ(Musher({"keys", "init", config_, "--force"}).exit, 0);
  EXPECT_EQ(Musher({"up", config_, "--detach"}).exit, 0);
}

TEST_F(Keys, AreListedWithRoleExpiryAndRevocation) {
  Identity("visitor", "observer");
  EXPECT_EQ(Musher({"keys", "revoke", "visitor"}).exit, 0);
  EXPECT_EQ(Musher({"keys", "add", "guest", "--role", "operator", "--days", "3"}).exit, 0);
  const Ended list = Musher({"keys", "list"});
  EXPECT_THAT(list.out,
              AllOf(HasSubstr("controller  controller"), HasSubstr("voice       actuator"),
                    ContainsRegex("expires in [23] days"), HasSubstr("revoked")));
  const auto json = Json(Musher({"keys", "list", "--json"}).out);
  EXPECT_EQ(json["identities"]["visitor"]["revoked"], true);
  EXPECT_EQ(json["identities"]["visitor"]["role"], "observer");
  EXPECT_EQ(json["identities"]["legs"]["revoked"], false);
  EXPECT_EQ(json["identities"].size(), 7U);
}

TEST_F(Keys, AreIssuedOnlyWhereTheCasKeysAre) {
  fs::rename(keys_ + "/ca", folder_ / "taken_off");
  const Ended add = Musher({"keys", "add", "visitor", "--role", "observer"});
  EXPECT_EQ(add.exit, 2);
  EXPECT_THAT(add.err, HasSubstr("issue and revoke identities where the folder ca/ is kept"));
  ASSERT_NO_FATAL_FAILURE(Start());  // the robot does not need them
}

TEST_F(Keys, OfANewRobotAreMadeBesideItsConfigWhichThenNamesThem) {
  fs::create_directory(folder_ / "new");
  const std::string open = folder_ / "new/open.toml";
  std::string text = ReadFile(config_);
  std::ofstream(open) << text.substr(0, text.find("[security]"));
  const Ended init = Musher({"keys", "init", open});
  EXPECT_EQ(init.exit, 0) << init.err;
  EXPECT_THAT(init.err,
              HasSubstr("now add to " + open + " the table [security] with keys = \"keys\""));
  EXPECT_TRUE(fs::exists(folder_ / "new/keys/voice.cert"));
}

TEST_F(Keys, HaveNamesThatCannotEscapeTheirFolder) {
  for (const char* name : {"../voice", "a b", "<x>", "identity_ca", ""}) {
    const Ended add = Musher({"keys", "add", name});
    EXPECT_EQ(add.exit, 2) << name;
  }
}

// Nothing is started then, and it is said which file is wrong, and how.
class WrongKeys : public SecuredMachine {
 protected:
  void ExpectRefusal(const std::string& why) {
    const Ended up = UpDetached();
    EXPECT_EQ(up.exit, 2) << up.out;
    EXPECT_THAT(up.err, HasSubstr(why));
    EXPECT_FALSE(fs::exists(folder_ / "state/journal.sqlite"));
  }
};

TEST_F(WrongKeys, ThatOthersCanReadAreRefused) {
  ASSERT_EQ(chmod((keys_ + "/voice.key").c_str(), 0640), 0);
  ExpectRefusal(keys_ + "/voice.key is readable by others; run `chmod 600 " + keys_ +
                "/voice.key`");
}

TEST_F(WrongKeys, InAFolderThatOthersCanChangeAreRefusedAndDoctorSaysSo) {
  ASSERT_EQ(chmod(keys_.c_str(), 0777), 0);
  const std::string why = keys_ + " is writable for all users, who could replace files in it";
  ExpectRefusal(why);
  const Ended doctor = Musher({"doctor", config_, "--json"});
  EXPECT_EQ(doctor.exit, 1);
  const nlohmann::json checks = Json(doctor.out)["checks"];
  const auto of_keys =
      std::ranges::find_if(checks, [](const auto& check) { return check["check"] == "keys"; });
  ASSERT_NE(of_keys, checks.end());
  EXPECT_EQ((*of_keys)["result"], "error");
  EXPECT_THAT((*of_keys)["reason"].get<std::string>(), HasSubstr(why));
  EXPECT_THAT((*of_keys)["fix"].get<std::string>(), HasSubstr("chmod -R go-w " + keys_));
  const Ended add = Musher({"keys", "add", "visitor"});
  EXPECT_EQ(add.exit, 2);
  EXPECT_THAT(add.err, HasSubstr(why));
}

TEST_F(WrongKeys, OfAnotherUserAreRefused) {
  if (geteuid() != 0) GTEST_SKIP() << "only root gives a file away";
  const std::string key = keys_ + "/voice.key";
  const std::string why = key + " belongs to user 12345, who can read it";
  ASSERT_EQ(chown(key.c_str(), 12345, 12345), 0);
  const Ended started = Musher({"up", config_, "--detach"});
  EXPECT_EQ(started.exit, 0) << "its process may run as that user: " << started.err;
  const auto status =
      AwaitStatus([](const auto& s) { return s["actuators"]["voice"]["degraded"]; });
  EXPECT_THAT(status["actuators"]["voice"]["message"].get<std::string>(), HasSubstr(why));
  EXPECT_EQ(Musher({"down"}).exit, 0);
  const std::string own = keys_ + "/controller.key";
  ASSERT_EQ(chown(own.c_str(), 12345, 12345), 0);
  const Ended up = UpDetached();
  EXPECT_NE(up.exit, 0);
  EXPECT_THAT(up.err, HasSubstr(own + " belongs to user 12345, who can read it"));
}

TEST_F(WrongKeys, ThatAreMissingAreReported) {
  fs::remove(keys_ + "/legs.cert");
  ExpectRefusal("legs.cert: No such file or directory; `musher keys add legs` creates an identity");
  fs::remove_all(keys_);
  ExpectRefusal("identity_ca.cert: No such file or directory; `musher keys init` creates");
}

TEST_F(WrongKeys, ThatAreBrokenAreReplacedWithForce) {
  std::ofstream(keys_ + "/legs.cert") << "-----BEGIN NONSENSE-----";
  ExpectRefusal("`musher keys add legs --force` replaces it");
}

TEST_F(WrongKeys, OfAnotherRobotAreRefused) {
  const std::string foreign = folder_ / "foreign";
  ASSERT_EQ(Musher({"keys", "init", foreign}).exit, 0);
  for (const char* kind : {".cert", ".key", ".permissions"}) {
    fs::copy_file(foreign + "/controller" + kind, keys_ + "/controller" + kind,
                  fs::copy_options::overwrite_existing);
  }
  ExpectRefusal("controller.cert was not issued by the CA of " + keys_ + "/identity_ca.cert");
}

TEST_F(WrongKeys, ThatDoNotBelongToTheirCertificateAreRefused) {
  fs::copy_file(keys_ + "/legs.key", keys_ + "/voice.key", fs::copy_options::overwrite_existing);
  ExpectRefusal("voice.key is not the key of " + keys_ + "/voice.cert");
}

TEST_F(WrongKeys, WithThePermissionsOfAnotherIdentityAreRefused) {
  fs::copy_file(keys_ + "/controller.permissions", keys_ + "/voice.permissions",
                fs::copy_options::overwrite_existing);
  ExpectRefusal("voice.permissions is for serialNumber=");
}

TEST_F(WrongKeys, WithPermissionsThatWereChangedAreRefused) {
  std::string text = ReadFile(keys_ + "/voice.permissions");
  const std::size_t at = text.find("DENY");
  ASSERT_NE(at, std::string::npos);
  std::ofstream(keys_ + "/voice.permissions") << text.replace(at, 4, "ALLOW");
  ExpectRefusal("voice.permissions was not signed by the CA of " + keys_ +
                "/permissions_ca.cert, or was changed");
}

TEST_F(WrongKeys, InADomainThatSecurityDoesNotKnowAreRefused) {
  setenv("ROS_DOMAIN_ID", "231", 1);
  ExpectRefusal("DDS Security supports the domains 0 to 230");
}

TEST_F(WrongKeys, WhereAPluginIsNotWhatItShouldBeAreRefused) {
  const std::string plugins = folder_ / "plugins";
  fs::create_directory(plugins);
  fs::copy_file(PLUGIN_DIR "/libdds_security_crypto.so", plugins + "/libdds_security_auth.so");
  setenv("LD_LIBRARY_PATH", plugins.c_str(), 1);
  ExpectRefusal("the plugins of DDS Security are libdds_security_auth.so");
  unsetenv("LD_LIBRARY_PATH");
}

}  // namespace musher::testing::command_test
