// A robot's folder of keys: what is issued, and what is taken for good.

#include <gmock/gmock.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fstream>

#include "musher/test/support/temp_folder.hpp"
#include "musher/transport/security/check.hpp"
#include "musher/wire/security/authority.hpp"

namespace musher::transport::keys::keys_test {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

std::string Text(const std::string& file) {
  std::ifstream in(file);
  return {std::istreambuf_iterator<char>(in), {}};
}

class Keys : public ::testing::Test {
 protected:
  Keys() { EXPECT_TRUE(CreateAuthority(folder_, Protection::kEncrypted, false)); }

  Result<> Add(const std::string& name, Role role = Role::kActuator, int days = 30,
               bool force = false) {
    return Issue(folder_, name, role, {}, {days, force});
  }
  std::string ErrorOf(const std::string& name) {
    const auto checked = Check(folder_, name);
    return checked ? "" : checked.error().message;
  }
  void Replace(const std::string& file, const std::string& from, const std::string& to) {
    std::string text = Text(file);
    const std::size_t at = text.find(from);
    ASSERT_NE(at, std::string::npos);
    std::ofstream(file) << text.replace(at, from.size(), to);
  }

  const TempFolder temp_;
  const KeyFolder folder_{temp_ / "keys"};
};

TEST_F(Keys, AreGoodUntilTheyExpire) {
  ASSERT_TRUE(Add("legs", Role::kActuator, 30));
  const auto until = Check(folder_, "legs");
  ASSERT_TRUE(until) << until.error().message;
  const auto left = until.value() - std::chrono::system_clock::now();
  EXPECT_GT(left, std::chrono::days(29));
  EXPECT_LE(left, std::chrono::days(30));
  ASSERT_TRUE(Add("old", Role::kActuator, -1));
  EXPECT_THAT(ErrorOf("old"), AllOf(HasSubstr("old.cert has expired on "),
                                    HasSubstr("`musher keys add old --force`")));
}

TEST_F(Keys, NeverOutliveTheirCa) {
  ASSERT_TRUE(Add("legs", Role::kActuator, 36'500));
  EXPECT_LE(Check(folder_, "legs").value(),
            std::chrono::system_clock::now() + std::chrono::days(3650));
}

TEST_F(Keys, AreRevokedWhenTheyAreReplaced) {
  ASSERT_TRUE(Add("legs"));
  const std::string before = Text(folder_.Certificate("legs"));
  const std::string permissions = Text(folder_.Permissions("legs"));
  EXPECT_FALSE(Add("legs"));
  ASSERT_TRUE(Add("legs", Role::kObserver, 30, true));
  EXPECT_EQ(ErrorOf("legs"), "");
  std::ofstream(folder_.Permissions("legs")) << permissions;  // those of more power
  EXPECT_THAT(ErrorOf("legs"), HasSubstr("legs.permissions is for "));
  std::ofstream(folder_.Certificate("legs")) << before;
  EXPECT_THAT(ErrorOf("legs"), HasSubstr("is not the key of"));
}

TEST_F(Keys, ThatWereRevokedStayRevokedWhileOthersAre) {
  for (const char* name : {"a", "b", "c"}) ASSERT_TRUE(Add(name));
  for (const char* name : {"a", "b", "a"}) ASSERT_TRUE(Revoke(folder_, name));
  EXPECT_THAT(ErrorOf("a"), HasSubstr("is revoked"));
  EXPECT_THAT(ErrorOf("b"), HasSubstr("is revoked"));
  EXPECT_EQ(ErrorOf("c"), "");
}

// With one CA for both, every holder of a certificate could sign permissions.
TEST_F(Keys, DoNotLetTheirOwnerSignPermissions) {
  const KeyFolder other(temp_ / "other");
  ASSERT_TRUE(CreateAuthority(other, Protection::kEncrypted, false));
  ASSERT_TRUE(Issue(other, "legs", Role::kController, {}, {}));
  ASSERT_TRUE(Add("legs"));
  std::ofstream(folder_.Permissions("legs")) << Text(other.Permissions("legs"));
  EXPECT_THAT(ErrorOf("legs"), HasSubstr("was not signed by the CA of"));
}

TEST_F(Keys, WithAChangedGovernanceAreRefused) {
  ASSERT_TRUE(Add("legs"));
  Replace(folder_.Governance(), "<enable_join_access_control>true",
          "<enable_join_access_control>no");
  EXPECT_THAT(ErrorOf("legs"), HasSubstr("governance.p7s was not signed by the CA of"));
}

TEST_F(Keys, ThatAreNoKeysAreNamed) {
  ASSERT_TRUE(Add("legs"));
  std::ofstream(folder_.Certificate("legs")) << "no certificate";
  EXPECT_THAT(ErrorOf("legs"), HasSubstr("legs.cert is not a certificate (PEM)"));
  std::ofstream(folder_.Revocations()) << "";
  EXPECT_THAT(ErrorOf("legs"), HasSubstr("revoked.crl is empty"));
}

TEST_F(Keys, InAFolderThatOthersCanChangeAreNeitherUsedNorIssued) {
  ASSERT_TRUE(Add("legs"));
  for (const std::string& folder : {folder_.path(), folder_.CaFolder()}) {
    ASSERT_EQ(chmod(folder.c_str(), 0777), 0);
    const std::string why = folder + " is writable for all users, who could replace files in it";
    const auto issued = Add("voice");
    ASSERT_FALSE(issued) << folder;
    EXPECT_THAT(issued.error().message, HasSubstr(why));
    EXPECT_FALSE(Revoke(folder_, "legs")) << folder;
    if (folder == folder_.path()) {
      EXPECT_THAT(ErrorOf("legs"), HasSubstr(why));
    } else {
      EXPECT_EQ(ErrorOf("legs"), "") << "an actuator reads nothing of the CA's folder";
    }
    ASSERT_EQ(chmod(folder.c_str(), 0700), 0);
  }
  EXPECT_EQ(ErrorOf("legs"), "");
}

TEST_F(Keys, OfAnotherUserAreNotUsed) {
  if (geteuid() != 0) GTEST_SKIP() << "only root gives a file away";
  ASSERT_TRUE(Add("legs"));
  constexpr uid_t kAnother = 12345;
  const std::string key = folder_.Key("legs");
  ASSERT_EQ(chown(key.c_str(), kAnother, kAnother), 0);
  EXPECT_EQ(ErrorOf("legs"),
            key + " belongs to user 12345, who can read it; run `chown 0 " + key + "`");
  EXPECT_TRUE(Check(folder_, "legs", KeyUse::kByAnyProcess))
      << "an actuator that runs as this user is started by root";
  ASSERT_EQ(chown(key.c_str(), 0, 0), 0);
  ASSERT_EQ(chown(folder_.path().c_str(), kAnother, kAnother), 0);
  EXPECT_THAT(ErrorOf("legs"), HasSubstr(folder_.path() + " belongs to user 12345"));
  EXPECT_FALSE(Add("voice"));
  EXPECT_FALSE(CreateAuthority(folder_, Protection::kEncrypted, true));
}

TEST(Permissions, OfAnActuatorAreThoseOfItsOwnName) {
  const Grant grant{"legs", "CN=legs", Role::kActuator, {}, {}};
  const std::string xml = PermissionsXml(grant, {});
  EXPECT_THAT(xml, HasSubstr("<topic>rr/*/legs/musher_commandReply</topic>"));
  EXPECT_THAT(xml, HasSubstr("<partition>legs</partition>"));
  EXPECT_THAT(xml, HasSubstr("<subject_name>CN=legs</subject_name>"));
  EXPECT_THAT(xml.substr(0, xml.find("<deny_rule>")), Not(HasSubstr("rq/musher")));
  EXPECT_THAT(xml, HasSubstr("<default>DENY</default>"));
}

TEST(Permissions, OfAnObserverAllowOnlyQueries) {
  const std::string xml = PermissionsXml({"guest", "CN=guest", Role::kObserver, {}, {}}, {});
  EXPECT_THAT(xml, Not(HasSubstr("<topic>*</topic>")));
  EXPECT_THAT(xml, Not(HasSubstr("set_state")));
  EXPECT_THAT(xml, Not(HasSubstr("emergency_stop")));
  EXPECT_THAT(xml, HasSubstr("<topic>rq/musher/get_statusRequest</topic>"));
  EXPECT_THAT(xml, HasSubstr("<topic>ros_discovery_info</topic>")) << "to be listed as a node";
  EXPECT_THAT(xml, HasSubstr("<topic>rq/*/get_skillRequest</topic>"));
  EXPECT_THAT(xml, HasSubstr("<topic>rt/skill_feedback</topic>"));
  EXPECT_THAT(xml, Not(HasSubstr("send_goal"))) << "an observer starts no skill";
}

const ExtensionInterfaces kExtension{.published = {"mode"},
                                     .queries = {"get_mode"},
                                     .subscribed = {"note"},
                                     .services = {"wake"},
                                     .operator_topics = {"mode_requested"},
                                     .operator_services = {"set_mode"}};

TEST(Permissions, OfAnExtensionAreThoseThatItNames) {
  const auto may = [](Role role, const std::string& topic) {
    const std::string xml = PermissionsXml({"x", "CN=x", role, {}, {}}, kExtension);
    const std::string allowed = xml.substr(0, xml.find("<deny_rule>"));
    return allowed.find("<topic>" + topic + "</topic>") < allowed.find("<subscribe>");
  };
  for (const char* topic :
       {"rq/set_modeRequest", "rq/*/set_modeRequest", "rt/mode_requested", "rt/*/mode_requested"}) {
    EXPECT_TRUE(may(Role::kOperator, topic)) << topic;
    EXPECT_FALSE(may(Role::kActuator, topic)) << topic;
    EXPECT_FALSE(may(Role::kObserver, topic)) << topic;
  }
  for (const Role role : {Role::kOperator, Role::kActuator, Role::kObserver}) {
    EXPECT_TRUE(may(role, "rq/get_modeRequest"));
    EXPECT_FALSE(may(role, "rt/mode"));
    EXPECT_FALSE(may(role, "rr/set_modeReply"));
    EXPECT_EQ(may(role, "rq/wakeRequest"), role != Role::kObserver);
    EXPECT_EQ(may(role, "rt/note"), role != Role::kObserver);
  }
  EXPECT_TRUE(may(Role::kController, "rt/mode"));
  EXPECT_TRUE(may(Role::kController, "rr/*/set_modeReply"));
}

TEST(Permissions, DenyAllElseOnTheTopicsOfAnExtension) {
  const auto denied = [](const ExtensionInterfaces& extension) {
    const std::string xml = PermissionsXml({"x", "CN=x", Role::kActuator, {}, {}}, extension);
    return xml.substr(xml.find("<deny_rule>"));
  };
  for (const char* topic : {"rt/mode", "rr/get_modeReply", "rt/note", "rq/*/wakeRequest",
                            "rt/mode_requested", "rq/set_modeRequest"}) {
    const std::string element = "<topic>" + std::string(topic) + "</topic>";
    EXPECT_THAT(denied(kExtension), HasSubstr(element));
    EXPECT_THAT(denied({}), Not(HasSubstr(element)));
  }
}

TEST(Permissions, OfAControllerCoverAllOfTheMachinesManagedNode) {
  const std::string xml = PermissionsXml({"dog", "CN=dog", Role::kController, {}, {}}, {});
  const std::string allowed = xml.substr(0, xml.find("<deny_rule>"));
  EXPECT_THAT(allowed, HasSubstr("<topic>rt/musher/transition_event</topic>"));
  EXPECT_THAT(allowed, HasSubstr("<topic>rr/musher/*Reply</topic>"));
}

TEST(Governance, AdmitsNoParticipantWithoutACertificate) {
  const std::string xml = GovernanceXml(Protection::kSigned);
  EXPECT_THAT(xml, HasSubstr("<allow_unauthenticated_participants>false<"));
  EXPECT_THAT(xml, HasSubstr("<enable_join_access_control>true<"));
  EXPECT_THAT(xml, Not(HasSubstr("ENCRYPT")));
  EXPECT_THAT(GovernanceXml(Protection::kEncrypted), Not(HasSubstr("SIGN")));
}

}  // namespace musher::transport::keys::keys_test
