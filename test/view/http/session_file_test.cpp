#include "musher/view/http/session_file.hpp"

#include <gmock/gmock.h>
#include <sys/stat.h>

#include "musher/base/files.hpp"
#include "musher/test/support/temp_folder.hpp"

namespace musher::http::session_file_test {

using std::chrono::hours;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr std::int64_t kNoon = 1'780'000'000'000;
constexpr std::int64_t kHour = 3'600'000;
const std::string kId = "0123456789abcdef0123456789abcdef";

TEST(SessionFile, KeepsWhoActsAndForHowLongStill) {
  const TempFolder folder;
  const std::string path = folder / "sessions";
  EXPECT_THAT(ReadSessions(path, kNoon).value(), IsEmpty());
  ASSERT_TRUE(WriteSessions(path, {{kId, "anna (192.168.1.7)", hours(1)}}, kNoon).ok());
  struct stat info {};
  ASSERT_EQ(stat(path.c_str(), &info), 0);
  EXPECT_EQ(info.st_mode & 0777, 0600u);
  EXPECT_THAT(ReadSessions(path, kNoon + kHour).value(),
              ElementsAre(KeptSession{kId, "anna (192.168.1.7)", hours(2)}));
  EXPECT_THAT(ReadSessions(path, kNoon + 11 * kHour).value(), IsEmpty());
}

TEST(SessionFile, OfAHostWhoseClockWasSetBackIsValid) {
  const std::string text = SessionsText({{kId, "anna", hours(1)}}, kNoon);
  EXPECT_THAT(SessionsIn(text, 5), ElementsAre(KeptSession{kId, "anna", hours(0)}));
}

TEST(SessionFile, WithLinesOfAnotherFormHasTheOthers) {
  const std::string good = SessionsText({{kId, "anna", hours(0)}}, kNoon);
  for (const std::string bad :
       {"", "x", kId.c_str(), "0123456789abcdef0123456789abcdef 5",
        "0123456789abcdef0123456789abcdef 5x anna", "0123456789abcdef0123456789abcdef -5 anna",
        "0123456789abcdef0123456789abcdeX 5 anna",
        "0123456789abcdef0123456789abcdef 99999999999999999999 anna"}) {
    EXPECT_THAT(SessionsIn(bad + "\n" + good, kNoon), ::testing::SizeIs(1)) << bad;
  }
}

TEST(SessionFile, ThatOthersMayReadIsRefused) {
  const TempFolder folder;
  const std::string path = folder / "sessions";
  ASSERT_TRUE(WriteSessions(path, {}, kNoon).ok());
  ASSERT_EQ(chmod(path.c_str(), 0644), 0);
  EXPECT_FALSE(ReadSessions(path, kNoon).ok());
}

}  // namespace musher::http::session_file_test
