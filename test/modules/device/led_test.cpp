#include "musher/modules/device/led.hpp"

#include <gmock/gmock.h>
#include <rapidcheck/gtest.h>

#include <map>
#include <set>
#include <string>
#include <vector>

namespace musher::device::led_test {

using msg::LedExecute;
using Request = LedExecute::Request;
using ::testing::HasSubstr;

Request EffectRequest(const std::string& client, std::uint8_t effect,
                      std::uint8_t target = LedExecute::kHead) {
  return {true, client, target, LedExecute::kUserColor, effect, 1, 2, 3};
}

Request Release(const std::string& client, std::uint8_t target = LedExecute::kHead) {
  return {false, client, target, 0, 0, 0, 0, 0};
}

std::int32_t CodeOf(const Result<>& result) {
  return result ? 0 : result.error().code;
}

TEST(LedArbiter, ShowsTheDefaultOfSystemAtFirst) {
  const LedArbiter arbiter;
  const LedArbiter::Shown head = arbiter.Show(LedExecute::kHead);
  EXPECT_EQ(head.client, LedClient::kSystem);
  EXPECT_EQ(head.light, (Light{LedExecute::kUserColor, 9, 6, 33, 226}));
  EXPECT_EQ(arbiter.Show(LedExecute::kTail), head);
  EXPECT_EQ(arbiter.Show(LedExecute::kMini).light.effect, 48);
}

TEST(LedArbiter, ShowsTheFirstClientInPrecedenceAndStoresTheOthers) {
  LedArbiter arbiter;
  EXPECT_TRUE(arbiter.Execute(EffectRequest("tracking", 1)));
  EXPECT_TRUE(arbiter.Execute(EffectRequest("bms", 2)));
  const Result<> stored = arbiter.Execute(EffectRequest("vp", 3));
  ASSERT_FALSE(stored);
  EXPECT_EQ(stored.error().code, 1125);
  EXPECT_THAT(stored.error().message, HasSubstr("'bms'"));
  EXPECT_EQ(arbiter.Show(LedExecute::kHead).light.effect, 2);

  EXPECT_TRUE(arbiter.Execute(Release("bms")));
  EXPECT_EQ(arbiter.Show(LedExecute::kHead).client, LedClient::kVp);
  EXPECT_TRUE(arbiter.Execute(Release("vp")));
  EXPECT_EQ(arbiter.Show(LedExecute::kHead).client, LedClient::kTracking);
  EXPECT_TRUE(arbiter.Execute(Release("tracking")));
  EXPECT_EQ(arbiter.Show(LedExecute::kHead), LedArbiter().Show(LedExecute::kHead));
}

TEST(LedArbiter, LetsAClientChangeItsOwnLight) {
  LedArbiter arbiter;
  EXPECT_TRUE(arbiter.Execute(EffectRequest("vp", 1)));
  EXPECT_TRUE(arbiter.Execute(EffectRequest("vp", 4)));
  EXPECT_EQ(arbiter.Show(LedExecute::kHead).light.effect, 4);
}

TEST(LedArbiter, KeepsTheTargetsApart) {
  LedArbiter arbiter;
  EXPECT_TRUE(arbiter.Execute(EffectRequest("lowpower", 1, LedExecute::kTail)));
  EXPECT_EQ(arbiter.Show(LedExecute::kTail).client, LedClient::kLowPower);
  EXPECT_EQ(arbiter.Show(LedExecute::kHead).client, LedClient::kSystem);
}

TEST(LedArbiter, AcceptsARepeatedReleaseAndOneWithoutARequest) {
  LedArbiter arbiter;
  EXPECT_TRUE(arbiter.Execute(Release("bms")));
  EXPECT_TRUE(arbiter.Execute(Release("bms")));
  EXPECT_EQ(arbiter, LedArbiter());
}

TEST(LedArbiter, LetsSystemAlwaysOccupy) {
  LedArbiter arbiter;
  Request request = EffectRequest("system", 5);
  request.occupation = false;
  EXPECT_TRUE(arbiter.Execute(request));
  EXPECT_EQ(arbiter.Show(LedExecute::kHead).light.effect, 5);
  EXPECT_EQ(CodeOf(arbiter.Execute(Release("system"))), 1123);  // it is checked like a request
}

TEST(LedArbiter, ChecksTargetClientModeAndEffectInThisOrder) {
  LedArbiter arbiter;
  Request request = {true, "unknown", 9, 9, 0xFF, 0, 0, 0};
  EXPECT_EQ(CodeOf(arbiter.Execute(request)), 1121);
  request.target = LedExecute::kMini;
  EXPECT_EQ(CodeOf(arbiter.Execute(request)), 1122);
  request.client = "vp";
  EXPECT_EQ(CodeOf(arbiter.Execute(request)), 1123);
  request.mode = LedExecute::kUserColor;
  EXPECT_EQ(CodeOf(arbiter.Execute(request)), 1124);
  request.effect = LedExecute::kCircularRing;
  EXPECT_EQ(CodeOf(arbiter.Execute(request)), 0);
}

TEST(LedArbiter, NeedsNoModeAndNoEffectForARelease) {
  LedArbiter arbiter;
  EXPECT_TRUE(arbiter.Execute(EffectRequest("vp", 1)));
  EXPECT_EQ(CodeOf(arbiter.Execute({false, "vp", LedExecute::kHead, 77, 77, 0, 0, 0})), 0);
  EXPECT_EQ(CodeOf(arbiter.Execute({false, "unknown", LedExecute::kHead, 0, 0, 0, 0, 0})), 1122);
  EXPECT_EQ(CodeOf(arbiter.Execute({false, "vp", 0, 0, 0, 0, 0, 0})), 1121);
}

TEST(LedArbiter, LeavesEverythingAsItWasWhenItRefuses) {
  LedArbiter arbiter;
  EXPECT_TRUE(arbiter.Execute(EffectRequest("vp", 1)));
  const LedArbiter before = arbiter;
  EXPECT_EQ(CodeOf(arbiter.Execute(EffectRequest("vp", 0x0A))), 1124);
  EXPECT_EQ(arbiter, before);
}

// Every possible effect, against the ranges of the table.
TEST(LedArbiter, ListsTheEffectsOfEachTargetAndMode) {
  const auto legal = [](std::uint8_t target, std::uint8_t mode) {
    std::set<int> effects;
    for (int effect = 0; effect <= 0xFF; ++effect) {
      LedArbiter arbiter;
      const Request request = {true, "vp", target, mode, static_cast<std::uint8_t>(effect),
                               0,    0,    0};
      if (arbiter.Execute(request)) effects.insert(effect);
    }
    return std::vector<int>{*effects.begin(), *effects.rbegin(), static_cast<int>(effects.size())};
  };
  for (const std::uint8_t target : {LedExecute::kHead, LedExecute::kTail}) {
    EXPECT_EQ(legal(target, LedExecute::kUserColor), (std::vector<int>{0x01, 0x09, 9}));
    EXPECT_EQ(legal(target, LedExecute::kPredefined), (std::vector<int>{0xA0, 0xB5, 22}));
  }
  EXPECT_EQ(legal(LedExecute::kMini, LedExecute::kUserColor), (std::vector<int>{0x30, 0x31, 2}));
  EXPECT_EQ(legal(LedExecute::kMini, LedExecute::kPredefined), (std::vector<int>{0x32, 0x36, 5}));
}

Request AnyRequest() {
  Request request;
  request.occupation = *rc::gen::arbitrary<bool>();
  request.client = *rc::gen::weightedOneOf<std::string>(
      {{15,
        rc::gen::map(rc::gen::elementOf(kLedClients), [](auto name) { return std::string(name); })},
       {1, rc::gen::just(std::string("unknown"))}});
  request.target = *rc::gen::inRange<std::uint8_t>(0, 5);
  request.mode = *rc::gen::inRange<std::uint8_t>(0, 4);
  request.effect = *rc::gen::element<std::uint8_t>(0x00, 0x01, 0x09, 0x30, 0x31, 0x32, 0xA0, 0xB5);
  request.r_value = *rc::gen::arbitrary<std::uint8_t>();
  return request;
}

RC_GTEST_PROP(LedArbiter, AlwaysShowsTheFirstInPrecedenceOfThoseStored, ()) {
  LedArbiter arbiter;
  // For each target the last light granted to each client, by precedence.
  std::map<std::uint8_t, std::map<std::size_t, Light>> stored;
  for (const std::uint8_t target : kLedTargets) stored[target][5] = DefaultLight(target);
  for (int i = *rc::gen::inRange(0, 40); i > 0; --i) {
    const Request request = AnyRequest();
    const std::int32_t code = CodeOf(arbiter.Execute(request));
    if (code == 0 || code == 1125) {
      std::size_t client = 0;
      while (kLedClients.at(client) != request.client) ++client;
      if (request.occupation || request.client == "system") {
        stored[request.target][client] = {request.mode, request.effect, request.r_value,
                                          request.g_value, request.b_value};
        RC_ASSERT((code == 1125) == (stored[request.target].begin()->first != client));
      } else {
        RC_ASSERT(code == 0);
        stored[request.target].erase(client);
      }
    }
    for (const std::uint8_t target : kLedTargets) {
      const auto& [client, light] = *stored[target].begin();
      RC_ASSERT(arbiter.Show(target) == (LedArbiter::Shown{static_cast<LedClient>(client), light}));
    }
  }
}

}  // namespace musher::device::led_test
