// The charger, by the reports of one publisher of the battery or of several.

#include "musher/modules/race/charger_reports.hpp"

#include <gtest/gtest.h>

namespace musher::race::charger_reports_test {

class TheChargerReports : public ::testing::Test {
 protected:
  static constexpr std::uint64_t kOwn = 1;
  static constexpr std::uint64_t kOther = 2;

  // Half a second after the one before.
  ChargerReports::Change Take(std::uint64_t publisher, bool on) {
    now_ += Milliseconds(500);
    return reports_.Take(transport::EndpointId(publisher), on, now_);
  }

  ChargerReports reports_;
  Time now_{};
};

TEST_F(TheChargerReports, OfOnePublisherCountAtAChange) {
  EXPECT_EQ(Take(kOwn, false).on, std::nullopt);
  EXPECT_EQ(Take(kOwn, true).on, true);
  EXPECT_EQ(Take(kOwn, true).on, std::nullopt);
  EXPECT_EQ(Take(kOwn, false).on, false);
  EXPECT_EQ(Take(kOwn, false).on, std::nullopt);
}

TEST_F(TheChargerReports, OfTwoThatDisagreeAreNotBelievedInTurn) {
  EXPECT_EQ(Take(kOwn, true).on, true);
  for (int i = 0; i < 100; ++i) {
    EXPECT_EQ(Take(kOther, false).on, std::nullopt) << i;
    EXPECT_EQ(Take(kOwn, true).on, std::nullopt) << i;
  }
  EXPECT_EQ(Take(kOwn, false).on, false);
}

// A robot that charges in the same namespace would hide that this one is put on a charger.
TEST_F(TheChargerReports, OfASecondPublisherCountAlsoWhereTheFirstOneReportsACharger) {
  EXPECT_EQ(Take(kOther, true).on, true);
  EXPECT_EQ(Take(kOwn, false).on, std::nullopt);
  EXPECT_EQ(Take(kOwn, true).on, true);
  EXPECT_EQ(Take(kOwn, false).on, std::nullopt) << "the other one is on a charger";
  EXPECT_EQ(Take(kOther, false).on, false);
}

TEST_F(TheChargerReports, OfSeveralPublishersAreNamedOnce) {
  EXPECT_FALSE(Take(kOwn, false).doubled);
  EXPECT_FALSE(Take(kOther, false).doubled) << "it may have taken the place of the first one";
  EXPECT_TRUE(Take(kOwn, false).doubled);
  for (int i = 0; i < 100; ++i) {
    EXPECT_FALSE(Take(kOther, false).doubled) << i;
    EXPECT_FALSE(Take(kOwn, false).doubled) << i;
  }
}

TEST_F(TheChargerReports, OfSeveralPublishersAreNamedAgainAfterOneWasAlone) {
  for (const std::uint64_t publisher : {kOwn, kOther, kOwn}) Take(publisher, false);
  now_ += ChargerReports::kSilent;
  EXPECT_FALSE(Take(kOwn, false).doubled);
  EXPECT_TRUE(Take(kOther, false).doubled);
}

TEST_F(TheChargerReports, OfARestartedPublisherTakeThePlaceOfThoseBefore) {
  EXPECT_EQ(Take(kOwn, true).on, true);
  EXPECT_EQ(Take(kOther, true).on, std::nullopt) << "it was on a charger before";
  EXPECT_EQ(Take(kOther, false).on, std::nullopt) << "the one before may still report one";
  now_ += ChargerReports::kSilent;
  const ChargerReports::Change alone = Take(kOther, false);
  EXPECT_EQ(alone.on, false);
  EXPECT_FALSE(alone.doubled);
}

TEST_F(TheChargerReports, OfTheOnlyPublisherCountHoweverRareTheyAre) {
  EXPECT_EQ(Take(kOwn, true).on, true);
  now_ += 10 * ChargerReports::kSilent;
  EXPECT_EQ(Take(kOwn, true).on, std::nullopt);
}

}  // namespace musher::race::charger_reports_test
