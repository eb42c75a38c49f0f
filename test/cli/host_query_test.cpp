// Scripts on other hosts, with a script in the place of ssh. With a real one they are tested in
// test/integration/hosts.

#include "musher/cli/machine/host_query.hpp"

#include <gmock/gmock.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "musher/cli/commands/host_logs.hpp"
#include "musher/cli/console/wall_time.hpp"
#include "musher/test/support/temp_folder.hpp"

namespace musher::cli::host_query_test {

using ::testing::AllOf;
using ::testing::ContainsRegex;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class OtherHosts : public ::testing::Test {
 protected:
  OtherHosts() { setenv("PATH", (folder_.path() + ":" + path_).c_str(), 1); }
  ~OtherHosts() override { setenv("PATH", path_.c_str(), 1); }

  // What runs in the place of ssh; $address is that of the host.
  void Ssh(const std::string& text) const {
    const std::string file = folder_ / "ssh";
    std::ofstream(file) << "#!/bin/sh\nfor address; do case $address in 10.*) break;; esac; done\n"
                        << text << "\n";
    std::filesystem::permissions(file, std::filesystem::perms::owner_all);
  }
  static HostConfig Host(const std::string& name, const std::string& address) {
    HostConfig host;
    host.name = name;
    host.address = address;
    host.user = "root";
    return host;
  }

  const std::string path_ = getenv("PATH");
  const TempFolder folder_;
  const HostConfig vision_ = Host("vision", "10.0.0.2");
  const HostConfig payload_ = Host("payload", "10.0.0.3");
};

TEST_F(OtherHosts, AnswerWithoutWhatTheirLoginPrints) {
  Ssh("echo Welcome; exec sh -s");
  const auto answers = QueryHosts({{&vision_, "echo one\necho two\n"}}, std::chrono::seconds(20));
  ASSERT_EQ(answers.size(), 1U);
  EXPECT_THAT(answers[0].lines, ElementsAre("one", "two"));
  EXPECT_THAT(answers[0].trouble, IsEmpty());
  ASSERT_TRUE(answers[0].clock_offset_ns);
  EXPECT_LT(std::abs(*answers[0].clock_offset_ns), 20'000'000'000);
}

TEST_F(OtherHosts, ThatRefuseTheKeySayWhatToDo) {
  Ssh("echo 'root@10.0.0.2: Permission denied (publickey).' >&2; exit 255");
  const auto answers = QueryHosts({{&vision_, "echo\n"}}, std::chrono::seconds(20));
  EXPECT_THAT(answers.front().trouble,
              AllOf(HasSubstr("host vision (root@10.0.0.2): root@10.0.0.2: Permission denied"),
                    HasSubstr("authorized_keys"), HasSubstr("`ssh root@10.0.0.2 true`")));
}

TEST_F(OtherHosts, ThatHangAreNamedAndTheOthersAnswer) {
  Ssh("[ $address != 10.0.0.2 ] || exec sleep 1000; exec sh -s");
  const Time begin = std::chrono::steady_clock::now();
  const auto answers =
      QueryHosts({{&vision_, "echo one\n"}, {&payload_, "echo two\n"}}, std::chrono::seconds(10));
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::minutes(2));
  EXPECT_THAT(answers[0].trouble, HasSubstr("host vision (root@10.0.0.2): no answer within 10 s"));
  EXPECT_THAT(answers[1].lines, ElementsAre("two"));
}

TEST_F(OtherHosts, ThatAreSlowKeepWhatHasArrived) {
  Ssh("exec sh -s");
  const auto answers =
      QueryHosts({{&vision_, "echo one\nexec sleep 1000\n"}}, std::chrono::seconds(10));
  EXPECT_THAT(answers[0].lines, ElementsAre("one"));
  EXPECT_THAT(answers[0].trouble, HasSubstr("its answer was not whole within 10 s"));
  EXPECT_TRUE(answers[0].clock_offset_ns);
}

TEST_F(OtherHosts, ThatPrintALineWithoutEndAreNamedAtOnce) {
  Ssh("exec sh -s");
  const Time begin = std::chrono::steady_clock::now();
  const auto answers =
      QueryHosts({{&vision_, "echo one\nexec cat /dev/zero\n"}}, std::chrono::minutes(2));
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::minutes(1));
  EXPECT_THAT(answers[0].lines, ElementsAre("one"));
  EXPECT_THAT(answers[0].trouble,
              HasSubstr("host vision (root@10.0.0.2): it has printed a line of more than 64 MiB"));
}

class JournalOfOtherHosts : public OtherHosts {
 protected:
  // What runs there in the place of journalctl.
  void Journal(const std::string& text) const {
    Ssh("exec sh -s");
    const std::string file = folder_ / "journalctl";
    std::ofstream(file) << "#!/bin/sh\n"
                        << "line() { echo '{\"__CURSOR\":\"'$1'\",\"_SYSTEMD_UNIT\":"
                           "\"musher-dog-eyes.service\",\"MESSAGE\":\"'$2'\"}'; }\n"
                        << text << "\n";
    std::filesystem::permissions(file, std::filesystem::perms::owner_all);
  }
  static std::vector<std::string> Texts(const std::vector<LogEntry>& entries) {
    std::vector<std::string> texts;
    for (const LogEntry& entry : entries) texts.push_back(entry.text);
    return texts;
  }

  const HostLog eyes_{"eyes", &vision_, "musher-dog-eyes.service"};
};

TEST_F(JournalOfOtherHosts, IsReadFromItsEnd) {
  Journal("case \"$*\" in *' -r -n 50 '*) line c2 second; line c1 first;; *) line c2;; esac");
  const ReadHostLogs read = ReadLogsOf({eyes_}, 0, 50);
  EXPECT_THAT(read.troubles, IsEmpty());
  EXPECT_THAT(Texts(read.entries.at(0)), ElementsAre("first", "second"));
  const JournalPosition& position = read.positions.at(&vision_);
  EXPECT_EQ(position.cursor, "c2");
  EXPECT_THAT(position.shown, ElementsAre("c1", "c2"));
}

TEST_F(JournalOfOtherHosts, ThatIsSlowIsShownAsFarAsItHasArrived) {
  Journal("line c2 second; line c1 first; case \"$*\" in *' -u '*) exec sleep 1000;; esac");
  const ReadHostLogs read = ReadLogsOf({eyes_}, 0, 50, std::chrono::seconds(10));
  EXPECT_THAT(Texts(read.entries.at(0)), ElementsAre("first", "second"));
  EXPECT_THAT(read.troubles,
              ElementsAre(AllOf(HasSubstr("host vision (root@10.0.0.2): its answer was not whole "
                                          "within 10 s: the older lines of its logs are missing"),
                                HasSubstr("--since"))));
}

TEST_F(JournalOfOtherHosts, ThatTheUserMayNotReadSaysSo) {
  Ssh("echo musher-clock 0; echo musher-denied robot");
  const ReadHostLogs read = ReadLogsOf({eyes_}, 0, 50);
  EXPECT_THAT(read.troubles, ElementsAre(AllOf(HasSubstr("user robot may not read its journal"),
                                               HasSubstr("`usermod -aG systemd-journal robot`"))));
}

TEST_F(JournalOfOtherHosts, IsFollowedFromWhereItWasRead) {
  EXPECT_THAT(FollowScript({eyes_}, "s=1;i=2", WallNow()),
              HasSubstr(" -f --no-tail --cursor='s=1;i=2' -u musher-dog-eyes.service"));
}

// The host was out of reach when it was to be read.
TEST_F(JournalOfOtherHosts, ThatWasNotReadIsFollowedFromTheBegin) {
  EXPECT_THAT(FollowScript({eyes_}, "", WallNow() - 60'000'000'000),
              ContainsRegex(" -f --no-tail --since=-7[0-9]s -u musher-dog-eyes.service"));
}

TEST_F(JournalOfOtherHosts, ThatIsReadInPartSaysSo) {
  Journal(
      "case \"$*\" in *' -u '*) seq 100000 | sed 's/.*/{\"__CURSOR\":\"c&\",\"_SYSTEMD_UNIT\":"
      "\"musher-dog-eyes.service\",\"MESSAGE\":\"m\"}/';; esac");
  const ReadHostLogs read = ReadLogsOf({eyes_}, 0, 0, std::chrono::minutes(2));
  EXPECT_EQ(read.entries.at(0).size(), 100'000U);
  EXPECT_THAT(read.troubles,
              ElementsAre(HasSubstr("of eyes only the newest 100000 lines are read, older ones are "
                                    "missing; all are in `ssh root@10.0.0.2 journalctl -u ")));
}

TEST_F(OtherHosts, WithoutSshSaysWhatToInstall) {
  setenv("PATH", folder_.path().c_str(), 1);
  const auto answers = QueryHosts({{&vision_, "echo\n"}}, std::chrono::seconds(20));
  EXPECT_THAT(answers.front().trouble, HasSubstr("install openssh-client here"));
}

TEST(JournalOfAnotherHost, GivesLinesWithTheirUnit) {
  const auto line = ParseJournalLine(
      R"({"__REALTIME_TIMESTAMP":"1790000000123456","_SYSTEMD_UNIT":"musher-dog-eyes.service",)"
      R"("MESSAGE":"hot"})");
  ASSERT_TRUE(line);
  EXPECT_EQ(line->unit, "musher-dog-eyes.service");
  EXPECT_EQ(line->line, (WrittenLine{"hot", 1'790'000'000'123'456'000}));
  // Of systemd about the unit, and with bytes that are no UTF-8.
  const auto about = ParseJournalLine(
      R"({"_SYSTEMD_UNIT":"init.scope","UNIT":"musher-dog-eyes.service","MESSAGE":[104,10,255]})");
  ASSERT_TRUE(about);
  EXPECT_EQ(about->unit, "musher-dog-eyes.service");
  EXPECT_EQ(about->line.text, "h \xff");
  EXPECT_FALSE(ParseJournalLine("-- No entries --"));
}

}  // namespace musher::cli::host_query_test
