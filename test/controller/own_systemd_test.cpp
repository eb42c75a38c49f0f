// Which systemd runs the processes of this host, and what a unit gets from its controller. Units
// themselves are tested in host_units_test.cpp and test/integration/hosts.

#include "musher/controller/process/own_systemd.hpp"

#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <string>

#include "musher/test/support/temp_folder.hpp"

namespace musher::own_systemd_test {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Pair;

constexpr uid_t kRoot = 0;
constexpr uid_t kUser = 4711;

TEST(OwnSystemd, IsThatOfTheSystemForRootAndThatOfTheUserForAnyOther) {
  const TempFolder folder;
  std::ofstream(folder / "bus") << "";
  const std::string address = "unix:path=" + (folder / "bus") + ",guid=17";
  const OwnSystemd of_root = FindOwnSystemd({{"DBUS_SYSTEM_BUS_ADDRESS", address}}, kRoot);
  EXPECT_EQ(of_root.socket, folder / "bus");
  EXPECT_THAT(of_root.trouble, IsEmpty());
  const OwnSystemd of_user = FindOwnSystemd({{"XDG_RUNTIME_DIR", folder.path()}}, kUser);
  EXPECT_EQ(of_user.socket, folder / "bus");
  EXPECT_THAT(of_user.trouble, IsEmpty());
  EXPECT_EQ(FindOwnSystemd({{"DBUS_SESSION_BUS_ADDRESS", address}}, kUser).socket, folder / "bus");
}

TEST(OwnSystemd, ThatIsMissingIsNamedWithWhatToDo) {
  if (!std::filesystem::exists("/run/systemd/system")) {
    EXPECT_THAT(FindOwnSystemd({}, kRoot).trouble,
                AllOf(HasSubstr("systemd does not run on this host"), HasSubstr("remove `units`")));
  }
  EXPECT_THAT(FindOwnSystemd({{"DBUS_SYSTEM_BUS_ADDRESS", "unix:path=/none/bus"}}, kRoot).trouble,
              AllOf(HasSubstr("no /none/bus"), HasSubstr("install the package dbus")));
  EXPECT_THAT(FindOwnSystemd({{"DBUS_SYSTEM_BUS_ADDRESS", "tcp:host=other"}}, kRoot).trouble,
              HasSubstr("names no socket of this host"));
  EXPECT_THAT(FindOwnSystemd({}, kUser).trouble, AllOf(HasSubstr("no systemd of user 4711 runs"),
                                                       HasSubstr("loginctl enable-linger 4711")));
}

TEST(UnitOfThisHost, InheritsWhatAChildDoes) {
  ProcessSpec spec;
  spec.argv = {"arm", "--fast"};
  spec.env = {{"SHARED", "its own"}};
  InheritForUnit({{"SHARED", "the controller's"},
                  {"TEXT", "zwölf\tlines\nof it"},
                  {"INVOCATION_ID", "of the controller"},
                  {"NOTIFY_SOCKET", "/run/notify"},
                  {"MUSHER_STARTED_AS", "0000000017/7//other"},
                  {"BASH_FUNC_x%%", "() { :; }"},
                  {"BYTES", "\xff"},
                  {"CUT", "\xc3"},
                  {"BELL", "\a"}},
                 spec);
  EXPECT_THAT(spec.env,
              ElementsAre(Pair("SHARED", "its own"), Pair("TEXT", "zwölf\tlines\nof it")));
  EXPECT_EQ(spec.cwd, "-" + std::filesystem::current_path().string());
  EXPECT_THAT(spec.argv, ElementsAre("/usr/bin/env", "arm", "--fast"));
}

// A program of that user would look for its files in the home folder of the controller's.
TEST(UnitOfThisHost, OfAnotherUserInheritsNothingOfTheControllersUser) {
  const std::map<std::string, std::string> environment = {
      {"DBUS_SESSION_BUS_ADDRESS", "unix:path=/run/user/0/bus"},
      {"HOME", "/root"},
      {"LANG", "C.UTF-8"},
      {"LOGNAME", "root"},
      {"SHELL", "/bin/sh"},
      {"USER", "root"},
      {"XDG_RUNTIME_DIR", "/run/user/0"},
      {"XDG_STATE_HOME", "/var/lib"}};
  ProcessSpec spec;
  spec.argv = {"/opt/arm"};
  spec.limits.user = "robot";
  spec.env = {{"HOME", "/srv/robot"}};
  InheritForUnit(environment, spec);
  EXPECT_THAT(spec.env, ElementsAre(Pair("HOME", "/srv/robot"), Pair("LANG", "C.UTF-8")));
  ProcessSpec own;
  own.argv = {"/opt/arm"};
  InheritForUnit(environment, own);
  EXPECT_EQ(own.env, environment);
}

TEST(UnitOfThisHost, KeepsItsPathAndItsFolder) {
  ProcessSpec spec;
  spec.argv = {"/opt/arm"};
  spec.cwd = "/srv";
  InheritForUnit({}, spec);
  EXPECT_EQ(spec.cwd, "/srv");
  EXPECT_THAT(spec.argv, ElementsAre("/opt/arm"));
}

}  // namespace musher::own_systemd_test
