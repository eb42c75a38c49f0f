// The shipped course is driven from START to END by rendered pictures alone: what the cameras of
// the simulated dog see is all that the race knows.

#include "musher/test/modules/race/drive/course_drive.hpp"

#include <gmock/gmock.h>

namespace musher::race::testing {
namespace {

using ::testing::Contains;

struct Route {
  std::uint64_t seed;
  std::map<std::string, std::string> chosen;
  bool yellow_light = false;
};
void PrintTo(const Route& route, std::ostream* out) {
  *out << "seed " << route.seed;
}

class WholeCourse : public ::testing::TestWithParam<Route> {};

TEST_P(WholeCourse, IsDrivenByTheCamerasAlone) {
  DriveSettings settings;
  settings.seed = GetParam().seed;
  settings.chosen = GetParam().chosen;
  settings.yellow_light = GetParam().yellow_light;
  CourseDrive drive(settings);
  const DriveResult result = drive.Run();
  std::string log;
  for (const std::string& line : result.log) log += line + "\n";
  EXPECT_EQ(result.state, "END") << log;
  const world::Referee& referee = result.world->referee();
  EXPECT_TRUE(referee.finished()) << "a zone is missing, or out of order\n" << log;
  EXPECT_EQ(referee.whole_foot_count(), 0U) << "a foot was wholly on a line\n" << log;
  EXPECT_EQ(referee.collisions(), 0U) << log;
  EXPECT_THAT(result.states, Contains("START_TO_QRA").Times(GetParam().yellow_light ? 2 : 1))
      << "it continues behind the light";
  EXPECT_THAT(result.states, Contains("YELLOW_LIGHT_COUNTDOWN").Times(GetParam().yellow_light));
}

INSTANTIATE_TEST_SUITE_P(
    OfBothWays, WholeCourse,
    ::testing::Values(Route{1, {{"qr_a", "A-1"}, {"arrow", "left"}, {"qr_b", "B-2"}}},
                      Route{4, {{"qr_a", "A-2"}, {"arrow", "right"}, {"qr_b", "B-1"}}, true}),
    [](const auto& route) { return "To_" + route.param.chosen.at("arrow"); });

}  // namespace
}  // namespace musher::race::testing
