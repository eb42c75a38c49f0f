// Tests the tree without a robot, in virtual time.

#include <gtest/gtest.h>

#include "garden.hpp"
#include "musher/behavior/tree/build.hpp"
#include "musher/behavior/tree/xml/tree_xml.hpp"

class AGarden : public ::testing::Test {
 protected:
  AGarden() {
    EXPECT_TRUE(AddNodes(factory_, garden_));
    const tree::Reading reading = tree::ReadTreeFile(GARDEN_XML);
    for (const auto& each : reading.diagnostics) ADD_FAILURE() << FormatDiagnostic(each);
    built_ = tree::Build(reading.document, factory_);
    for (const auto& each : built_.diagnostics) ADD_FAILURE() << FormatDiagnostic(each);
  }
  tree::Status Wait(musher::Duration time) {
    tree::Status status = tree::Status::kRunning;
    const musher::Time end = now_ + time;
    while (now_ < end && status == tree::Status::kRunning) {
      status = built_.tree->TickOnce(now_).value();
      garden_.Advance(kStep);
      now_ += kStep;
    }
    return status;
  }

  static constexpr musher::Duration kStep = std::chrono::milliseconds(50);
  Garden garden_;
  tree::Factory factory_;
  tree::Built built_;
  musher::Time now_;
};

TEST_F(AGarden, IsWateredUntilItsSoilIsWet) {
  EXPECT_EQ(Wait(std::chrono::seconds(30)), tree::Status::kSuccess);
  EXPECT_GE(garden_.soil_percent, 60);
  EXPECT_FALSE(garden_.pump);
  EXPECT_FALSE(garden_.tap);
}

TEST_F(AGarden, IsLeftAloneWithoutWaterAfterAMinute) {
  garden_.has_tap_water = false;
  EXPECT_EQ(Wait(std::chrono::seconds(59)), tree::Status::kRunning);
  EXPECT_EQ(Wait(std::chrono::seconds(2)), tree::Status::kFailure);
  EXPECT_FALSE(garden_.tap);
}

TEST_F(AGarden, StopsItsPumpInAHalt) {
  Wait(std::chrono::seconds(1));
  EXPECT_TRUE(garden_.pump);
  ASSERT_TRUE(built_.tree->Halt(now_));
  EXPECT_FALSE(garden_.pump);
}
