#include "musher/view/http/login.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>
#include <sys/stat.h>

#include <set>

#include "musher/base/files.hpp"
#include "musher/test/support/temp_folder.hpp"

namespace musher::http::login_test {

using testing::HasSubstr;

const std::string kToken = "0123456789abcdef0123456789abcdef";
const Time kStart{std::chrono::hours(1000)};

// Counts up.
Random Counting() {
  return [next = std::uint32_t{0}](std::span<std::byte> bytes) mutable {
    ++next;
    for (std::size_t i = 0; i < bytes.size(); ++i) {
      bytes[i] = i < 4 ? static_cast<std::byte>(next >> (8 * i)) : std::byte{0x5A};
    }
  };
}

TEST(Login, BeginsASessionWithACode) {
  Login login(Counting(), kToken);
  const std::string code = login.NewCode("anna", kStart).code;
  const auto session = login.Redeem(code, "192.168.1.7", kStart);
  ASSERT_TRUE(session.ok());
  EXPECT_NE(session.value(), code);
  EXPECT_EQ(login.Find(session.value(), kStart), "anna (192.168.1.7)");
  EXPECT_EQ(login.Find(code, kStart), std::nullopt);
  EXPECT_EQ(login.Find("", kStart), std::nullopt);
}

TEST(Login, TakesACodeOnce) {
  Login login(Counting(), kToken);
  const std::string code = login.NewCode("anna", kStart).code;
  ASSERT_TRUE(login.Redeem(code, "::1", kStart).ok());
  const auto again = login.Redeem(code, "::1", kStart);
  ASSERT_FALSE(again.ok());
  EXPECT_THAT(again.error().message, HasSubstr("the link was used already"));
  EXPECT_EQ(login.sessions(), 1u);
}

TEST(Login, TakesACodeForTenMinutes) {
  Login login(Counting(), kToken);
  const std::string one = login.NewCode("", kStart).code;
  const std::string two = login.NewCode("", kStart).code;
  EXPECT_TRUE(login.Redeem(one, "::1", kStart + kCodeTime - Duration(1)).ok());
  const auto late = login.Redeem(two, "::1", kStart + kCodeTime);
  ASSERT_FALSE(late.ok());
  EXPECT_THAT(late.error().message, HasSubstr("older than 10 minutes"));
}

TEST(Login, EndsASessionAfterTwelveHoursWithoutARequest) {
  Login login(Counting(), kToken);
  const auto session = login.Redeem(login.NewCode("", kStart).code, "::1", kStart).value();
  EXPECT_EQ(login.Find(session, kStart + kSessionTime - Duration(1)), "::1");
  EXPECT_EQ(login.Find(session, kStart + 2 * kSessionTime - Duration(2)), "::1");
  EXPECT_EQ(login.Find(session, kStart + 3 * kSessionTime), std::nullopt);
}

TEST(Login, EndsASessionOnRequest) {
  Login login(Counting(), kToken);
  const auto session = login.Redeem(login.NewCode("", kStart).code, "::1", kStart).value();
  login.End(session);
  EXPECT_EQ(login.Find(session, kStart), std::nullopt);
}

TEST(Login, KeepsTheSessionsThatAreUsed) {
  Login login(Counting(), kToken);
  const auto first = login.Redeem(login.NewCode("", kStart).code, "::1", kStart).value();
  const auto idle = login.Redeem(login.NewCode("", kStart).code, "::1", kStart).value();
  for (std::size_t i = 1; i < kMaxSessions; ++i) {
    const Time now = kStart + std::chrono::seconds(i);
    EXPECT_TRUE(login.Find(first, now).has_value());
    EXPECT_TRUE(login.Redeem(login.NewCode("", now).code, "::1", now).ok());
  }
  EXPECT_EQ(login.sessions(), kMaxSessions);
  EXPECT_EQ(login.Find(idle, kStart + std::chrono::minutes(5)), std::nullopt);
  EXPECT_TRUE(login.Find(first, kStart + std::chrono::minutes(5)).has_value());
}

TEST(Login, BeginsASessionWithAPin) {
  Login login(Counting(), kToken);
  const LoginCode code = login.NewCode("anna", kStart);
  ASSERT_THAT(code.pin, testing::MatchesRegex("[0-9]{6}"));
  const std::string typed = code.pin.substr(0, 3) + " " + code.pin.substr(3);
  const auto session = login.RedeemPin(typed, "10.0.0.9", kStart);
  ASSERT_TRUE(session.ok());
  EXPECT_EQ(login.Find(session.value(), kStart), "anna (10.0.0.9)");
  EXPECT_THAT(login.RedeemPin(code.pin, "10.0.0.9", kStart).error().message,
              HasSubstr("no PIN is valid now"));
  EXPECT_THAT(login.Redeem(code.code, "10.0.0.9", kStart).error().message,
              HasSubstr("the link was used already"));
}

TEST(Login, TakesAPinForTenMinutesAndOnlyThatOfTheNewestCode) {
  Login login(Counting(), kToken);
  const LoginCode old = login.NewCode("anna", kStart);
  const LoginCode code = login.NewCode("ben", kStart);
  EXPECT_FALSE(login.RedeemPin(old.pin, "::1", kStart).ok());
  EXPECT_TRUE(login.Redeem(old.code, "::1", kStart).ok()) << "the link of anna stays valid";
  EXPECT_FALSE(login.RedeemPin(code.pin, "::1", kStart + kCodeTime).ok());
}

TEST(Login, EndsAPinThatIsGuessedFromManyAddresses) {
  Login login(Counting(), kToken);
  const LoginCode code = login.NewCode("anna", kStart);
  const std::string wrong = code.pin == "000000" ? "000001" : "000000";
  for (std::size_t i = 0; i < kMaxWrongPins; ++i) {
    EXPECT_FALSE(login.RedeemPin(wrong, "10.0.0." + std::to_string(i), kStart).ok());
  }
  EXPECT_FALSE(login.RedeemPin(code.pin, "10.0.0.99", kStart).ok());
  EXPECT_TRUE(login.Redeem(code.code, "10.0.0.99", kStart).ok());
  EXPECT_FALSE(login.RedeemPin("", "10.0.0.99", kStart).ok());
}

TEST(Login, KeepsSessionsOverARestartWithTheirRestOfTime) {
  Login login(Counting(), kToken);
  const auto session = login.Redeem(login.NewCode("anna", kStart).code, "::1", kStart).value();
  const auto hour = std::chrono::hours(1);
  const std::vector<KeptSession> kept = login.Kept(kStart + hour);
  EXPECT_THAT(kept, testing::ElementsAre(KeptSession{session, "anna (::1)", hour}));
  const Time boot{std::chrono::seconds(30)};  // steady time begins again
  Login next(Counting(), kToken);
  next.Restore(kept, boot);
  EXPECT_TRUE(next.Lives(session, boot));
  EXPECT_EQ(next.Find(session, boot + kSessionTime - hour - Duration(1)), "anna (::1)");
  Login late(Counting(), kToken);
  late.Restore(kept, boot);
  EXPECT_EQ(late.Find(session, boot + kSessionTime - hour), std::nullopt);
  EXPECT_FALSE(late.Lives(session, boot + kSessionTime - hour));
  EXPECT_THAT(late.Kept(boot + kSessionTime - hour), testing::IsEmpty());
}

TEST(Login, EndsAllSessionsAndUnusedCodes) {
  Login login(Counting(), kToken);
  const auto session = login.Redeem(login.NewCode("", kStart).code, "::1", kStart).value();
  const LoginCode unused = login.NewCode("", kStart);
  login.EndAll();
  EXPECT_EQ(login.Find(session, kStart), std::nullopt);
  EXPECT_FALSE(login.Redeem(unused.code, "::1", kStart).ok());
  EXPECT_FALSE(login.RedeemPin(unused.pin, "::1", kStart).ok());
}

TEST(Login, MakesAnAddressWaitThatGuesses) {
  Login login(Counting(), kToken);
  const LoginCode code = login.NewCode("", kStart);
  for (std::size_t i = 0; i < kMaxFailures; ++i) {
    EXPECT_THAT(login.Redeem("guess", "10.0.0.9", kStart).error().message,
                HasSubstr("the link is not valid"));
  }
  EXPECT_EQ(login.Redeem("guess", "10.0.0.9", kStart).error().code, kCodeTargetBusy);
  EXPECT_EQ(login.MayMakeLinks("guess", "10.0.0.9", kStart).error().code, kCodeTargetBusy);
  EXPECT_EQ(login.RedeemPin(code.pin, "10.0.0.9", kStart).error().code, kCodeTargetBusy);
  EXPECT_TRUE(login.RedeemPin(code.pin, "10.0.0.9", kStart + kFailureTime).ok());
}

// Behind a proxy all have one address: any of them kept the others out, and a stolen login alive.
TEST(Login, TakesTheRightCodeAndTokenFromAnAddressThatGuesses) {
  Login login(Counting(), kToken);
  const std::string code = login.NewCode("", kStart).code;
  for (std::size_t i = 0; i <= kMaxFailures; ++i) {
    EXPECT_FALSE(login.Redeem("guess", "127.0.0.1", kStart).ok());
  }
  EXPECT_TRUE(login.MayMakeLinks(kToken, "127.0.0.1", kStart).ok());
  EXPECT_TRUE(login.Redeem(code, "127.0.0.1", kStart).ok());
}

TEST(Login, ComparesTheToken) {
  Login login(Counting(), kToken);
  EXPECT_TRUE(login.MayMakeLinks(kToken, "::1", kStart).ok());
  EXPECT_FALSE(login.MayMakeLinks("", "::1", kStart).ok());
  EXPECT_FALSE(login.MayMakeLinks(kToken + "0", "::1", kStart).ok());
  Login without(Counting(), "");
  EXPECT_FALSE(without.MayMakeLinks("", "::1", kStart).ok());
}

TEST(Login, HasOneLineForAPerson) {
  Login login(Counting(), kToken);
  const std::string code = login.NewCode("anna\nroot" + std::string(100, 'x'), kStart).code;
  const std::string person = *login.Find(login.Redeem(code, "::1", kStart).value(), kStart);
  EXPECT_THAT(person, HasSubstr("anna?root"));
  EXPECT_LT(person.size(), 80u);
}

RC_GTEST_PROP(Login, NeedsNoMoreMemoryInTheLongRun, (const std::vector<std::uint8_t>& steps)) {
  Login login(Counting(), kToken);
  Time now = kStart;
  std::string code;
  for (const std::uint8_t step : steps) {
    for (int i = 0; i < 20; ++i) {
      now += std::chrono::seconds(step);
      if (step % 3 == 0) code = login.NewCode("a", now).code;
      if (step % 3 == 1) std::ignore = login.Redeem(code, std::to_string(step), now);
      if (step % 3 == 2) std::ignore = login.MayMakeLinks(code, std::to_string(i), now);
    }
    RC_ASSERT(login.codes() <= kMaxCodes);
    RC_ASSERT(login.sessions() <= kMaxSessions);
  }
}

TEST(SameSecret, ComparesAllBytes) {
  EXPECT_TRUE(SameSecret("", ""));
  EXPECT_TRUE(SameSecret("abc", "abc"));
  for (const std::string other : {"abd", "bbc", "ab", "abcd", ""}) {
    EXPECT_FALSE(SameSecret("abc", other));
  }
}

TEST(KernelRandom, DiffersEachTime) {
  std::set<std::array<std::byte, 16>> seen;
  for (int i = 0; i < 100; ++i) {
    std::array<std::byte, 16> bytes{};
    KernelRandom(bytes);
    EXPECT_TRUE(seen.insert(bytes).second);
  }
}

class TokenFile : public testing::Test {
 protected:
  Result<std::string> Read() const { return ReadOrMakeToken(path_, Counting()); }

  TempFolder folder_;
  const std::string path_ = folder_ / "token";
};

TEST_F(TokenFile, IsMadeForItsOwnerAlone) {
  const auto made = Read();
  ASSERT_TRUE(made.ok());
  struct stat info {};
  ASSERT_EQ(stat(path_.c_str(), &info), 0);
  EXPECT_EQ(info.st_mode & 0777, 0600u);
  EXPECT_EQ(ReadFile(path_), made.value() + "\n");
  EXPECT_EQ(ReadOrMakeToken(path_, KernelRandom).value(), made.value());
}

TEST_F(TokenFile, IsRefusedIfOthersMayReadIt) {
  ASSERT_TRUE(Read().ok());
  ASSERT_EQ(chmod(path_.c_str(), 0640), 0);
  EXPECT_THAT(Read().error().message, HasSubstr("can be read or written by other users"));
}

TEST_F(TokenFile, IsRefusedIfItIsSomethingElse) {
  ASSERT_EQ(symlink("/etc/hostname", path_.c_str()), 0);
  EXPECT_FALSE(Read().ok());
  ASSERT_EQ(unlink(path_.c_str()), 0);
  ASSERT_EQ(mkdir(path_.c_str(), 0700), 0);
  EXPECT_THAT(Read().error().message, HasSubstr("is not a regular file"));
  ASSERT_EQ(rmdir(path_.c_str()), 0);
  ASSERT_TRUE(ReplaceFile(path_, "short\n", {.mode = 0600}).ok());
  EXPECT_THAT(Read().error().message, HasSubstr("32 hexadecimal digits"));
}

TEST_F(TokenFile, InAMissingFolderIsAnError) {
  const auto token = ReadOrMakeToken(path_ + "/missing/token", Counting());
  ASSERT_FALSE(token.ok());
  EXPECT_THAT(token.error().message, HasSubstr("/missing/token: No such file"));
}

}  // namespace musher::http::login_test
