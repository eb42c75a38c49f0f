// The operations on a sensor, and the outcome of a self-check.

#include <gmock/gmock.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "musher/messages/protocol/sensor.hpp"
#include "musher/modules/sensor/operation.hpp"
#include "musher/modules/sensor/self_check.hpp"

namespace musher::sensor::decisions_test {

using Operation = msg::SensorOperation;

TEST(Operating, LeadsFromClosedOverOpenToStartedAndBack) {
  Phase phase = Phase::kClosed;
  for (const auto& [operation, next] :
       {std::pair(Operation::kOpen, Phase::kOpen), std::pair(Operation::kStart, Phase::kStarted),
        std::pair(Operation::kStop, Phase::kOpen), std::pair(Operation::kClose, Phase::kClosed)}) {
    const Result<Phase> done = Operate(SensorKind::kLidar, phase, operation);
    ASSERT_TRUE(done) << done.error().message;
    EXPECT_EQ(done.value(), next);
    phase = done.value();
  }
}

TEST(Operating, MayBeRequestedTwice) {
  for (const Phase phase : {Phase::kClosed, Phase::kOpen, Phase::kStarted}) {
    for (std::uint8_t operation = 1; operation <= 4; ++operation) {
      const Result<Phase> once = Operate(SensorKind::kGps, phase, operation);
      if (!once) continue;
      const Result<Phase> twice = Operate(SensorKind::kGps, once.value(), operation);
      ASSERT_TRUE(twice) << static_cast<int>(operation);
      EXPECT_EQ(twice.value(), once.value());
    }
  }
}

TEST(Operating, RefusesOperationsOutOfOrderWithTheSensorsCode) {
  const std::vector<std::pair<Phase, std::uint8_t>> out_of_order = {
      {Phase::kClosed, Operation::kStart},
      {Phase::kClosed, Operation::kStop},
      {Phase::kStarted, Operation::kOpen},
      {Phase::kStarted, Operation::kClose}};
  for (const auto& [phase, operation] : out_of_order) {
    EXPECT_EQ(Operate(SensorKind::kLidar, phase, operation).error().code, 2103);
    EXPECT_EQ(Operate(SensorKind::kTof, phase, operation).error().code, 2203);
    EXPECT_EQ(Operate(SensorKind::kUltrasonic, phase, operation).error().code, 2303);
    EXPECT_EQ(Operate(SensorKind::kGps, phase, operation).error().code, 2403);
  }
}

TEST(Operating, RefusesAnUnknownOperation) {
  for (const auto operation : {std::uint8_t{0}, std::uint8_t{5}, std::uint8_t{255}}) {
    EXPECT_EQ(Operate(SensorKind::kLidar, Phase::kOpen, operation).error().code, 2010);
  }
}

std::vector<SensorResult> Findings(const std::vector<SensorKind>& failing) {
  std::vector<SensorResult> findings;
  for (const SensorKind kind : kSensorKinds) {
    Result<> result;
    if (std::find(failing.begin(), failing.end(), kind) != failing.end()) {
      result = Error{CodeOf(kind, KeyCode::kSelfCheckFailed), "silent"};
    }
    findings.push_back({kind, result});
  }
  return findings;
}

TEST(SelfCheck, IsInTheOrderLidarTofUltrasonicGps) {
  std::vector<std::string_view> names;
  std::vector<std::int32_t> codes;
  for (const SensorKind kind : kSensorKinds) {
    names.push_back(NameOf(kind));
    codes.push_back(CodeOf(kind, KeyCode::kSelfCheckFailed));
  }
  EXPECT_THAT(names, ::testing::ElementsAre("lidar", "tof", "ultrasonic", "gps"));
  EXPECT_THAT(codes, ::testing::ElementsAre(2109, 2209, 2309, 2409));
}

TEST(SelfCheck, EndsAtTheFirstCriticalSensorThatFailsWithItsCodeAlone) {
  const SelfCheckVerdict verdict =
      EvaluateSelfCheck(Findings({SensorKind::kLidar, SensorKind::kTof, SensorKind::kGps}),
                        {SensorKind::kGps, SensorKind::kTof});
  ASSERT_FALSE(verdict.result);
  EXPECT_EQ(verdict.result.error().code, 2209);
  EXPECT_EQ(verdict.result.error().message, "tof (critical): silent, 2209");
}

TEST(SelfCheck, IsPassedDegradedByTheOthersTogetherUnderTheCodeOfTheFirst) {
  const SelfCheckVerdict verdict = EvaluateSelfCheck(
      Findings({SensorKind::kUltrasonic, SensorKind::kTof}), {SensorKind::kLidar});
  EXPECT_TRUE(verdict.result) << "the robot does its work without them";
  EXPECT_EQ(verdict.degraded.code, 2209);
  EXPECT_EQ(verdict.degraded.message, "tof: silent, 2209; ultrasonic: silent, 2309");
}

// Sums of codes can make 2304 and the like, whose lowest eight bits are 0.
TEST(SelfCheck, NeverTakesAFailureForNone) {
  for (unsigned failing = 0; failing < 16; ++failing) {
    for (unsigned critical = 0; critical < 16; ++critical) {
      std::vector<SensorKind> failed;
      std::vector<SensorKind> wanted;
      for (const SensorKind kind : kSensorKinds) {
        if ((failing >> static_cast<unsigned>(kind)) & 1U) failed.push_back(kind);
        if ((critical >> static_cast<unsigned>(kind)) & 1U) wanted.push_back(kind);
      }
      const SelfCheckVerdict verdict = EvaluateSelfCheck(Findings(failed), wanted);
      ASSERT_EQ(verdict.well(), failed.empty());
      ASSERT_EQ(verdict.result.ok(), (failing & critical) == 0);
      if (failed.empty()) continue;
      const std::int32_t code =
          verdict.result ? verdict.degraded.code : verdict.result.error().code;
      EXPECT_NE(code & 0xFF, 0);
      EXPECT_EQ(code % 100, 9);
    }
  }
}

}  // namespace musher::sensor::decisions_test
