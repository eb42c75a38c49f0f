// A thousand damaged plans of each form: each is accepted or refused with a reason.

#include <gtest/gtest.h>

#include <bit>
#include <functional>
#include <random>
#include <string>

#include "musher/modules/meilin/plan/action_sequence.hpp"
#include "musher/modules/meilin/plan/box_map_text.hpp"
#include "musher/modules/meilin/plan/plan_file.hpp"
#include "musher/modules/meilin/plan/segments_json.hpp"

namespace musher::meilin::mutated_plans_test {
namespace {

constexpr int kPlans = 1000;

std::string Mutated(std::string text, std::mt19937& random) {
  const auto any = [&random](std::size_t below) {
    return std::uniform_int_distribution<std::size_t>(0, below - 1)(random);
  };
  constexpr std::string_view kPieces[] = {"[",    "]",   "{",  "}",        "\"",
                                          ",",    "nan", "-1", "1e999",    "\xff",
                                          "null", "\n",  "=",  "[[step]]", "99999999999999999999"};
  for (std::size_t edits = 1 + any(4); edits > 0 && !text.empty(); --edits) {
    const std::size_t at = any(text.size());
    switch (any(4)) {
      case 0:
        text.erase(at, 1 + any(8));
        break;
      case 1:
        text.insert(at, kPieces[any(std::size(kPieces))]);
        break;
      case 2:
        text[at] = static_cast<char>(any(256));
        break;
      default:
        text.insert(at, text.substr(any(text.size()), any(20)));
        break;
    }
  }
  return text;
}

// `accept` returns whether the text is accepted, and fails the test for a refusal without a reason.
void ExpectDecided(const std::string& text, const std::function<bool(const std::string&)>& accept) {
  ASSERT_TRUE(accept(text));
  std::mt19937 random(22);
  int refused = 0;
  for (int plan = 0; plan < kPlans; ++plan) refused += accept(Mutated(text, random)) ? 0 : 1;
  EXPECT_GT(refused, kPlans / 4) << "mutations that nothing notices test nothing";
}

TEST(MutatedPlans, OfNumbersAreDecided) {
  const std::vector<PlanStep> steps = {{false, {0, 1}, 0, 0},   {true, {1, 1}, 200, 0},
                                       {false, {1, 1}, 200, 0}, {true, {2, 1}, 200, 0},
                                       {false, {2, 1}, 400, 0}, {false, {3, 1}, 600, 0}};
  const msg::Float32MultiArray plan = ToActionSequence(steps);
  ASSERT_TRUE(ReadActionSequence(plan, {}, {}).ok());
  std::mt19937 random(22);
  int refused = 0;
  for (int count = 0; count < kPlans; ++count) {
    msg::Float32MultiArray mutated = plan;
    for (int edits = 0; edits < 2; ++edits) {
      const std::size_t at = random() % mutated.data.size();
      switch (random() % 4) {
        case 0:
          mutated.data[at] = std::bit_cast<float>(static_cast<std::uint32_t>(random()));
          break;
        case 1:
          mutated.data[at] += 1;
          break;
        case 2:
          mutated.data.resize(at + 1);
          break;
        default:
          mutated.layout.dim.resize(random() % 3);
          break;
      }
    }
    const PlanReading reading = ReadActionSequence(mutated, {}, {});
    EXPECT_EQ(reading.ok(), !reading.segments.empty());
    EXPECT_EQ(reading.ok(), reading.message().empty());
    refused += reading.ok() ? 0 : 1;
  }
  EXPECT_GT(refused, kPlans / 4);
}

TEST(MutatedPlans, OfOldSegmentsAreDecided) {
  ExpectDecided(R"({"stage": "meilin", "plan_id": "7", "segments": [
      {"segment_type": "ALIGN", "move_target": {"x": 1.5, "y": -2, "yaw": 0.5}, "max_speed": 0.3},
      {"segment_type": "CLIMB", "move_target": {"x": 1, "y": 2}, "climb_mode": "UP",
       "climb_direction": "LEFT", "climb_height": 200}, {"segment_type": "GRASP"}]})",
                [](const std::string& text) {
                  const SegmentsReading reading = ReadSegmentsJson(text);
                  EXPECT_EQ(reading.ok(), !reading.segments.empty());
                  return reading.ok();
                });
}

TEST(MutatedPlans, OfBoxMapsAreDecided) {
  ExpectDecided(R"({"grid": [[0,0,0],[0,2,0],[0,0,1],[3,0,0],[0,0,0],[0,0,0]], "team": "red",
                    "method": 0, "timestamp": 17})",
                [](const std::string& text) {
                  const BoxMapReading reading = ReadBoxMapJson(text);
                  EXPECT_EQ(reading.map.has_value(), reading.faults.empty());
                  return reading.map.has_value();
                });
}

TEST(MutatedPlans, OfFilesAreDecidedWithTheirPlaces) {
  ExpectDecided(
      "side = \"blue\"\nstart = [0, 1]\n[[step]]\nmove = [0, 1]\n[[step]]\nfetch = [1, 1]\n"
      "yaw_deg = 0\n[[step]]\nmove = [1, 1]\n",
      [](const std::string& text) {
        const DrawnPlanReading reading = ReadPlanText(text, "plan.toml");
        EXPECT_EQ(reading.plan.has_value(), !HasError(reading.diagnostics));
        for (const Diagnostic& diagnostic : reading.diagnostics) EXPECT_GT(diagnostic.line, 0);
        return reading.plan.has_value();
      });
}

TEST(MutatedPlans, OfMapFilesAreDecidedWithTheirPlaces) {
  ExpectDecided(
      "team = \"blue\"\nmethod = \"one-way\"\ngrid = [[0,0,0],[0,2,0],[0,0,1],[3,0,0],[0,0,0],"
      "[0,0,0]]\n",
      [](const std::string& text) {
        const BoxMapFileReading reading = ReadBoxMapText(text, "map.toml");
        EXPECT_EQ(reading.map.has_value(), !HasError(reading.diagnostics));
        for (const Diagnostic& diagnostic : reading.diagnostics) EXPECT_GT(diagnostic.line, 0);
        return reading.map.has_value();
      });
}

}  // namespace
}  // namespace musher::meilin::mutated_plans_test
