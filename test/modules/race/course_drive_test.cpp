// The shipped course is driven from START to END by rendered pictures alone: what the cameras of
// the simulated dog see is all that the race knows.

#include "musher/test/modules/race/drive/course_drive.hpp"

#include <gmock/gmock.h>

namespace musher::race::testing {
namespace {

using ::testing::Contains;
using ::testing::Le;
using ::testing::SizeIs;

struct Route {
  std::uint64_t seed;
  std::map<std::string, std::string> chosen;
  bool yellow_light = false;
  std::optional<double> slip = {};
  std::set<std::string> unseen = {};
};
void PrintTo(const Route& route, std::ostream* out) {
  *out << "seed " << route.seed;
}

std::string Joined(const std::vector<std::string>& log) {
  std::string all;
  for (const std::string& line : log) all += line + "\n";
  return all;
}

class WholeCourse : public ::testing::TestWithParam<Route> {};

DriveSettings SettingsOf(const Route& route) {
  DriveSettings settings;
  settings.seed = route.seed;
  settings.chosen = route.chosen;
  settings.yellow_light = route.yellow_light;
  settings.slip = route.slip;
  settings.unseen = route.unseen;
  return settings;
}

void ExpectNoFault(const DriveResult& result, const Route& route) {
  const std::string log = Joined(result.log);
  const world::Referee& referee = result.world->referee();
  EXPECT_EQ(referee.whole_foot_count(), 0U) << "a foot was wholly on a line\n" << log;
  EXPECT_EQ(referee.collisions(), 0U) << log;
  EXPECT_THAT(result.states, Contains("START_TO_QRA").Times(route.yellow_light ? 2 : 1))
      << "it continues behind the light";
  EXPECT_THAT(result.states, Contains("YELLOW_LIGHT_COUNTDOWN").Times(route.yellow_light));
}

TEST_P(WholeCourse, IsDrivenByTheCamerasAlone) {
  CourseDrive drive(SettingsOf(GetParam()));
  const DriveResult result = drive.Run();
  EXPECT_EQ(result.state, "END") << Joined(result.log);
  EXPECT_TRUE(result.world->referee().finished()) << "a zone is missing, or out of order\n"
                                                  << Joined(result.log);
  ExpectNoFault(result, GetParam());
  EXPECT_THAT(result.reservations, SizeIs(Le(2U)));
}

// Feet that slip four times as much as usual lay down outside of both bays of zone B.
TEST(WholeCourseOfSlippingFeet, IsDrivenByTheOdometry) {
  const Route route{
      .seed = 1, .chosen = {{"qr_a", "A-1"}, {"arrow", "left"}, {"qr_b", "B-2"}}, .slip = 0.12};
  CourseDrive drive(SettingsOf(route));
  const DriveResult result = drive.Run();
  EXPECT_EQ(result.state, "END") << Joined(result.log);
  EXPECT_TRUE(result.world->referee().finished()) << Joined(result.log);
  ExpectNoFault(result, route);
}

// A bar that is not recognised: the robot walks as far as the lane is long, and into both bays.
TEST(WholeCourseOfAnUnseenBar, EndsInItsBays) {
  const Route route{.seed = 1,
                    .chosen = {{"qr_a", "A-1"}, {"arrow", "left"}, {"qr_b", "B-2"}},
                    .unseen = {"barrier"}};
  CourseDrive drive(SettingsOf(route));
  const DriveResult result = drive.Run();
  EXPECT_EQ(result.state, "END") << Joined(result.log);
  EXPECT_TRUE(result.world->referee().finished()) << Joined(result.log);
  ExpectNoFault(result, route);
}

// What the gate drives: past the light, to the bay of its code, through the S lane, to the arrow.
TEST(WayToTheArrow, IsDrivenByTheCamerasAlone) {
  const Route route{4, {{"qr_a", "A-2"}, {"arrow", "right"}, {"qr_b", "B-1"}}, true};
  DriveSettings settings = SettingsOf(route);
  settings.until = "R1_TO_QRB";
  CourseDrive drive(settings);
  const DriveResult result = drive.Run();
  EXPECT_EQ(result.state, "R1_TO_QRB") << Joined(result.log);
  EXPECT_THAT(result.states, Contains("IN_A2"));
  ExpectNoFault(result, route);
}

INSTANTIATE_TEST_SUITE_P(
    OfBothWays, WholeCourse,
    ::testing::Values(Route{1, {{"qr_a", "A-1"}, {"arrow", "left"}, {"qr_b", "B-2"}}},
                      Route{4, {{"qr_a", "A-2"}, {"arrow", "right"}, {"qr_b", "B-1"}}, true}),
    [](const auto& route) { return "To_" + route.param.chosen.at("arrow"); });

}  // namespace
}  // namespace musher::race::testing
