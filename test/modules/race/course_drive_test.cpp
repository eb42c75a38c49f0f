// The shipped course is driven from START to END by rendered pictures alone: what the cameras of
// the simulated dog see is all that the race knows.

#include "musher/test/modules/race/drive/course_drive.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <opencv2/imgcodecs.hpp>

#include "musher/modules/vision/course/marker_finder.hpp"
#include "musher/modules/world/render/render.hpp"
#include "musher/modules/world/scene_file/scene_toml.hpp"
#include "musher/modules/world/simulation/referee_report.hpp"
#include "musher/test/modules/race/drive/check_places.hpp"
#include "musher/test/modules/race/drive/other_halls.hpp"
#include "musher/test/support/nightly.hpp"
#include "musher/test/support/paths.hpp"

namespace musher::race::testing {
namespace {

using ::testing::Contains;
using ::testing::Le;
using ::testing::SizeIs;

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
  EXPECT_THAT(result.wrong_words, ::testing::IsEmpty());
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

// The same with the body on a motion board on LCM, in virtual time: what the race and the motion
// manager know of it has come by datagrams, and so do all its commands.
TEST(WayToTheArrowOverLcm, IsDrivenByTheCamerasAlone) {
  const Route route{4, {{"qr_a", "A-2"}, {"arrow", "right"}, {"qr_b", "B-1"}}, true};
  DriveSettings settings = SettingsOf(route);
  settings.over_lcm = true;
  settings.until = "R1_TO_QRB";
  CourseDrive drive(settings);
  const DriveResult result = drive.Run();
  EXPECT_EQ(result.state, "R1_TO_QRB") << Joined(result.log);
  EXPECT_THAT(result.states, Contains("IN_A2"));
  EXPECT_GT(result.datagrams, static_cast<std::size_t>(result.took / Milliseconds(20)));
  ExpectNoFault(result, route);
}

TEST(WholeCourseOverLcm, IsDrivenByTheCamerasAlone) {
  for (const Route& route : {Route{4, {{"qr_a", "A-2"}, {"arrow", "right"}, {"qr_b", "B-1"}}},
                             Route{20, {{"qr_a", "A-1"}, {"arrow", "left"}, {"qr_b", "B-2"}}}}) {
    DriveSettings settings = SettingsOf(route);
    settings.over_lcm = true;
    CourseDrive drive(settings);
    const DriveResult result = drive.Run();
    EXPECT_EQ(result.state, "END") << Joined(result.log);
    EXPECT_TRUE(result.world->referee().finished()) << Joined(result.log);
    ExpectNoFault(result, route);
  }
}

// A lamp over the S lane: the line walker was not stopped by it.
TEST(WayThroughTheSLane, StopsAtAYellowLightAndGoesOnAfterIt) {
  DriveSettings settings;
  settings.from = "S1_TO_S2";
  settings.pose = world::Pose2{{0.1, -0.4}, 0};
  settings.until = "IN_S2";
  settings.light_at_m = Eigen::Vector2d(2.6, -0.12);
  settings.limit = std::chrono::minutes(2);
  CourseDrive drive(settings);
  const DriveResult result = drive.Run();
  EXPECT_EQ(result.state, "IN_S2") << Joined(result.log);
  EXPECT_THAT(result.states, Contains("YELLOW_LIGHT_COUNTDOWN").Times(1)) << Joined(result.log);
  EXPECT_THAT(result.states, Contains("S1_TO_S2").Times(2));
  EXPECT_EQ(result.world->referee().whole_foot_count(), 0U) << Joined(result.log);
}

// Beyond the S lane there is no line any more: a walk that was stopped there ended as lost.
TEST(WayThroughTheSLane, GoesOnToItsEndFromALightBehindTheLines) {
  DriveSettings settings;
  settings.from = "S1_TO_S2";
  settings.pose = world::Pose2{{2.9, 0.13}, 0.6};
  settings.until = "IN_S2";
  settings.light_at_m = Eigen::Vector2d(5.3, 0.743);
  settings.limit = std::chrono::minutes(2);
  CourseDrive drive(settings);
  const DriveResult result = drive.Run();
  EXPECT_EQ(result.state, "IN_S2") << Joined(result.log);
  EXPECT_THAT(result.states, Contains("YELLOW_LIGHT_COUNTDOWN").Times(1)) << Joined(result.log);
  EXPECT_NEAR(result.world->body().pose().position_m.x(), 4.93, 0.2) << Joined(result.log);
}

// From beside the lane of board B, 0.1 m off the place where the way aside begins: the line ahead
// of a bay says nothing of that, and the lines on either side do.
TEST(WayIntoTheBaysOfZoneB, IsCorrectedByTheLinesThatBoundThem) {
  for (const double aside_m : {0.1, -0.1}) {
    DriveSettings settings;
    settings.seed = 7;
    settings.from = "QRB_TO_B1";
    settings.pose = world::Pose2{{12.83, 0.743 + aside_m}, 0};
    settings.until = "IN_B2";
    settings.limit = std::chrono::minutes(3);
    std::map<std::string, double> beside_m;
    settings.on_state = [&](const std::string& state, const world::World& world) {
      beside_m[state] = world.body().pose().position_m.y();
    };
    CourseDrive drive(settings);
    const DriveResult result = drive.Run();
    EXPECT_EQ(result.state, "IN_B2") << Joined(result.log);
    EXPECT_NEAR(beside_m["IN_B1"], 2.163, 0.08) << Joined(result.log);
    EXPECT_NEAR(result.world->body().pose().position_m.y(), -0.677, 0.08) << Joined(result.log);
    EXPECT_EQ(result.world->referee().whole_foot_count(), 0U) << Joined(result.log);
    EXPECT_THAT(result.reservations, ::testing::IsEmpty());
    std::cout << fmt::format("begun {:+.2f} m aside: {:+.3f} m in B1, {:+.3f} m in B2\n", aside_m,
                             beside_m["IN_B1"] - 2.163,
                             result.world->body().pose().position_m.y() + 0.677);
  }
}

// The course of the design document, in the hall of its measures.
TEST(WholeCourseOfTheDocument, IsDrivenByTheCamerasAlone) {
  for (const Route& route : {Route{1, {{"qr_a", "A-1"}, {"arrow", "left"}, {"qr_b", "B-2"}}},
                             Route{4, {{"qr_a", "A-2"}, {"arrow", "right"}, {"qr_b", "B-1"}}}}) {
    DriveSettings settings = SettingsOf(route);
    settings.course = "race/course_seed.toml";
    CourseDrive drive(settings);
    const DriveResult result = drive.Run();
    EXPECT_EQ(result.state, "END") << Joined(result.log);
    EXPECT_TRUE(result.world->referee().finished()) << Joined(result.log);
    ExpectNoFault(result, route);
  }
}

// Its 23 steps back end 0.5 m before the START lane. A line of lane Q passed for one of that lane
// there: the place was right by the cameras, and feet were on the line of the START lane.
TEST(WayBackToTheStartOfTheDocument, EndsInTheStartLane) {
  for (const auto& [from, x_m] : {std::pair("A1_TO_START", -1.23), {"A2_TO_START", 1.23}}) {
    DriveSettings settings;
    settings.course = "race/course_seed.toml";
    settings.from = from;
    settings.pose = world::Pose2{{x_m, -1.28}, -M_PI / 2};
    settings.limit = std::chrono::minutes(2);
    CourseDrive drive(settings);
    const DriveResult result = drive.Run();
    EXPECT_EQ(result.state, "END") << Joined(result.log);
    EXPECT_EQ(result.world->referee().whole_foot_count(), 0U) << Joined(result.log);
    EXPECT_NEAR(result.world->body().pose().position_m.y(), 0, 0.15) << Joined(result.log);
  }
}

// Laid out for the measures that the shipped scene has, a hall is the shipped scene.
TEST(HallScene, WithTheMeasuresOfTheShippedSceneIsThatScene) {
  const auto reading = world::ReadSceneFile(SourceDir() + "/config/scenes/course.toml");
  ASSERT_TRUE(reading.scene);
  const world::Scene& shipped = *reading.scene;
  EXPECT_EQ(HallOf(0.83, 0.05), Hall{});
  world::Scene laid = shipped;
  LayOut(Hall{}, {}, laid);
  ASSERT_EQ(laid.lines.size(), shipped.lines.size());
  constexpr double kNear = 0.005;
  // In another order, and some from their other end.
  for (const world::Line& line : shipped.lines) {
    const bool found = std::ranges::any_of(laid.lines, [&](const world::Line& other) {
      const auto same = [&](const Eigen::Vector2d& first, const Eigen::Vector2d& last) {
        return (line.points_m.front() - first).norm() < kNear &&
               (line.points_m.back() - last).norm() < kNear;
      };
      return line.points_m.size() == other.points_m.size() && line.watched == other.watched &&
             line.width_m == other.width_m &&
             (same(other.points_m.front(), other.points_m.back()) ||
              same(other.points_m.back(), other.points_m.front()));
    });
    EXPECT_TRUE(found) << line.points_m.front().transpose() << " to "
                       << line.points_m.back().transpose();
  }
  for (std::size_t i = 0; i < shipped.zones.size(); ++i) {
    EXPECT_LT((shipped.zones[i].center_m - laid.zones[i].center_m).norm(), kNear)
        << shipped.zones[i].name;
    EXPECT_LT((shipped.zones[i].half_m - laid.zones[i].half_m).norm(), kNear)
        << shipped.zones[i].name;
  }
  for (std::size_t i = 0; i < shipped.boards.size(); ++i) {
    EXPECT_LT((shipped.boards[i].center_m - laid.boards[i].center_m).norm(), kNear);
  }
}

// Looks of the light's detector in a hall: from places in five lanes, at each with no lamp and with
// one at several distances ahead.
struct LampLooks {
  int seen = 0, missed = 0, doubts_of_lamp = 0;
  int nothing = 0, wrong = 0, doubts = 0;
  std::string reason;  // of the last doubt
};

LampLooks LookForLamps(const HallCase& hall) {
  const auto reading = world::ReadSceneFile(SourceDir() + "/config/scenes/course.toml",
                                            {.seed = hall.route.seed, .chosen = hall.route.chosen});
  world::Scene scene = reading.scene.value();
  LayOut(hall.hall.hall, hall.hall.s, scene);
  Furnish(hall.hall.flooring, hall.route.seed, scene);
  Illuminate(hall.hall.light, scene);
  const world::Pose2 poses[] = {{{-0.78, 0}, 0},
                                {{-0.2, 0.05}, 0.1},
                                {{0, -0.5}, -M_PI / 2},
                                {{0.6, -1.8}, M_PI / 2},
                                {{0.9, -0.4}, 0}};
  world::Ball lamp = *std::ranges::find(scene.balls, "yellow light", &world::Ball::name);
  scene.balls.clear();
  lamp.shown = true;
  for (const world::Pose2& pose : poses) {
    for (const double ahead_m : {0.85, 1.1, 1.5, 2.0}) {
      lamp.center_m.head<2>() = pose.position_m + ahead_m * Eigen::Vector2d(std::cos(pose.yaw_rad),
                                                                            std::sin(pose.yaw_rad));
      scene.balls.push_back(lamp);
    }
  }
  const auto scenery = world::Scenery::Make(scene).value();
  if (hall.hall.flooring != Flooring::kShipped) std::filesystem::remove(scene.ground.file);
  const world::Camera camera(scene.cameras.cameras[0]);
  LampLooks looks;
  const char* folder = std::getenv("MUSHER_HALL_PICTURES");
  for (std::size_t i = 0; i < std::size(poses) * 5; ++i) {
    const std::size_t place = i / 5;
    const std::optional<std::size_t> shown =
        i % 5 == 0 ? std::nullopt : std::optional(place * 4 + i % 5 - 1);
    world::View view;
    view.body = poses[place];
    view.attitude = {scene.body.stand_height_m, 0, 0};
    view.seed = i + 1;
    for (std::size_t ball = 0; ball < scene.balls.size(); ++ball) {
      if (ball != shown) view.hidden_balls.push_back(ball);
    }
    const world::Image image = camera.Shoot(*scenery, view);
    const cv::Mat bgr(image.height, image.width, CV_8UC3,
                      const_cast<std::uint8_t*>(image.bgr.data()));
    const vision::MarkerLook look = vision::LookForMarker(bgr, vision::LightParameters());
    if (!look.doubt.empty()) looks.reason = look.doubt;
    if (shown) {
      ++(look.marker ? looks.seen : look.doubt.empty() ? looks.missed : looks.doubts_of_lamp);
    } else {
      ++(look.marker ? looks.wrong : look.doubt.empty() ? looks.nothing : looks.doubts);
    }
    if (folder != nullptr) {
      cv::imwrite(fmt::format("{}/lamp-{}-{:02}.png", folder, hall.number, i), bgr);
    }
  }
  return looks;
}

// In four of them each picture was a doubt: the robot stood, and said that no picture came.
TEST(YellowLight, IsSeenInEachHallAndOnlyWhereItIs) {
  for (const HallCase& hall : Halls()) {
    const LampLooks looks = LookForLamps(hall);
    std::cout << fmt::format(
        "hall {:2}: lamps seen {}, missed {}, doubts {}; none: rightly nothing {}, WRONG {}, "
        "doubts "
        "{} {}\n",
        hall.number, looks.seen, looks.missed, looks.doubts_of_lamp, looks.nothing, looks.wrong,
        looks.doubts, looks.reason);
    EXPECT_EQ(looks.wrong, 0) << "hall " << hall.number;
    EXPECT_EQ(looks.doubts, 0) << "hall " << hall.number << ": " << looks.reason;
    EXPECT_EQ(looks.seen, 20) << "hall " << hall.number;
  }
}

// In pictures of the world's renderer, and in those of the painter that has no part in it.
const std::vector<HallCase>& HallsInBothPictures() {
  static const std::vector<HallCase> halls = [] {
    std::vector<HallCase> both = Halls();
    for (HallCase hall : Halls()) {
      hall.hall.painted = true;
      both.push_back(hall);
    }
    return both;
  }();
  return halls;
}

std::string PicturesOf(const HallCase& hall) {
  return hall.hall.painted ? "painted" : "rendered";
}

// What is known to lead away from its place: beside a bay that is hardly wider than the body, a
// line of the next bay; where the cross lane of zone B is wider than the camera's region; and where
// a line of 3 cm is missed in warm and weak light, one of the next lane.
bool IsKnownToLeadAway(const HallCase& hall, const std::string& check) {
  const double lane_m = hall.hall.hall.lane_m;
  if (check == "left_dy" || check == "bay_sides_dy") return lane_m < 0.75;
  if (check == "junction_ycy") return hall.number == 6 || hall.number == 9;
  if (check == "left_ycy") return hall.number == 6 && hall.hall.painted;
  if (check == "left_cross_ycy" || check == "right_cross_ycy") return lane_m > 0.9;
  return false;
}

// A way back ended 0.7 m beside the START lane, with feet on its line: the check at its end took
// lines of lane Q and of a bay for those of the START lane, and led away from it five times.
TEST(ChecksInOtherHalls, LeadToTheirPlaces) {
  for (const HallCase& hall : HallsInBothPictures()) {
    if (!::musher::testing::Nightly() && hall.number != 5) continue;
    DriveSettings settings = SettingsOf(hall.route);
    settings.hall = hall.hall;
    CourseDrive drive(settings);
    std::map<Saying, int> counts;
    for (const CheckPlace& place : CheckPlaces(hall.hall.hall, hall.hall.s)) {
      for (const double off : {-0.2, -0.1, 0.0, 0.1, 0.2}) {
        const Saying said = SaidFrom(drive, place, off);
        ++counts[said];
        EXPECT_TRUE(said != Saying::kAway || IsKnownToLeadAway(hall, place.check))
            << "hall " << hall.number << ", " << PicturesOf(hall) << ": " << place.check << " of "
            << place.state << " from " << off << " beside its place";
      }
    }
    std::cout << fmt::format("hall {:2}, {:8}: right {:3}, unsure {:3}, away {}, none {}\n",
                             hall.number, PicturesOf(hall), counts[Saying::kRight],
                             counts[Saying::kUnsure], counts[Saying::kAway], counts[Saying::kNone]);
    EXPECT_GT(counts[Saying::kRight], 60);
  }
}

DriveResult DriveIn(const HallCase& hall) {
  DriveSettings settings = SettingsOf(hall.route);
  settings.hall = hall.hall;
  settings.until = hall.until;
  if (const char* folder = std::getenv("MUSHER_HALL_PICTURES")) settings.pictures = folder;
  CourseDrive drive(settings);
  DriveResult result = drive.Run();
  std::cout << fmt::format(
      "hall {:2}, {}: lane {:.2f} m, line {:.2f} m, S {:.1f} m {:.0f}°, slip {:.2f}, {}, {:.0f} "
      "K, light {:.2f}: {}, {} whole feet ({} touches), {} wrong words, {} reservations, {:.0f} "
      "s\n",
      hall.number, PicturesOf(hall), hall.hall.hall.lane_m, hall.hall.hall.line_m,
      hall.hall.s.radius_m, hall.hall.s.arc_deg, *hall.route.slip, NameOf(hall.hall.flooring),
      hall.hall.light.temperature_k, hall.hall.light.share, result.state,
      result.world->referee().whole_foot_count(), result.world->referee().touch_count(),
      result.wrong_words.size(), result.reservations.size(), ToSeconds(result.took));
  if (!result.reason.empty()) std::cout << "  " << result.reason << "\n";
  for (const std::string& each : result.reservations) std::cout << "  " << each << "\n";
  return result;
}

// It comes to its end, or stands in ERROR and says why: either way no foot is wholly on a line. The
// halls with `ends` have to be driven, so that the others may not all stop in their first state.
class WholeCourseOfAnotherHall : public ::testing::TestWithParam<HallCase> {};

TEST_P(WholeCourseOfAnotherHall, IsDrivenOrEndsWithItsReason) {
  const HallCase& hall = GetParam();
  const DriveResult result = DriveIn(hall);
  const world::Referee& referee = result.world->referee();
  EXPECT_EQ(referee.whole_foot_count(), 0U) << Joined(result.log);
  EXPECT_EQ(referee.collisions(), 0U) << Joined(result.log);
  EXPECT_THAT(result.wrong_words, ::testing::IsEmpty());
  if (hall.ends) {
    EXPECT_EQ(result.state, "END") << result.reason << "\n" << Joined(result.log);
  }
  if (result.state == "END") {
    EXPECT_TRUE(referee.finished())
        << RefereeText(result.world->scene(), referee, result.took) << Joined(result.log);
  } else {
    EXPECT_EQ(result.state, "ERROR") << Joined(result.log);
    EXPECT_FALSE(result.reason.empty()) << Joined(result.log);
  }
}

INSTANTIATE_TEST_SUITE_P(Nightly, WholeCourseOfAnotherHall,
                         ::testing::ValuesIn(HallsInBothPictures()), [](const auto& hall) {
                           return "Hall" + std::to_string(hall.param.number) + "_" +
                                  PicturesOf(hall.param);
                         });

// From the last bay, in both pictures.
TEST(WayBackToTheStartOfOtherHalls, EndsInTheStartLane) {
  for (HallCase hall : HallsInBothPictures()) {
    if (hall.number != 4 && hall.number != 5) continue;
    const Hall& measures = hall.hall.hall;
    DriveSettings settings = SettingsOf(hall.route);
    settings.hall = hall.hall;
    const bool west = hall.route.chosen.at("qr_a") == "A-2";  // the other bay than at first
    settings.from = west ? "A1_TO_START" : "A2_TO_START";
    settings.pose = world::Pose2{
        {(west ? -1 : 1) * measures.bay_a_aside_m, measures.bay_a_in_m - measures.cross_m},
        -M_PI / 2};
    settings.limit = std::chrono::minutes(2);
    CourseDrive drive(settings);
    const DriveResult result = drive.Run();
    EXPECT_EQ(result.state, "END") << Joined(result.log);
    EXPECT_EQ(result.world->referee().whole_foot_count(), 0U) << Joined(result.log);
    EXPECT_NEAR(result.world->body().pose().position_m.y(), 0, 0.12) << Joined(result.log);
  }
}

// What the gate drives of these: into the first bay of a narrow hall, and of a wide one.
TEST(WayToTheBayOfAnotherHall, IsDrivenByTheCamerasAlone) {
  for (const int number : {1, 12}) {
    HallCase hall = Halls()[static_cast<std::size_t>(number) - 1];
    hall.until = hall.route.chosen.at("qr_a") == "A-1" ? "A1_TO_S1" : "A2_TO_S1";
    const DriveResult result = DriveIn(hall);
    EXPECT_EQ(result.state, hall.until) << Joined(result.log);
    ExpectNoFault(result, hall.route);
  }
}

// All that it sees has the colour of the yellow light there: each picture was a doubt, and the
// robot stood in its first state.
TEST(AHallInWarmLight, IsDrivenPastItsYellowLight) {
  HallCase hall = Halls()[1];
  hall.route.yellow_light = true;
  hall.until = "IN_QR_A";
  const DriveResult result = DriveIn(hall);
  EXPECT_EQ(result.state, "IN_QR_A") << Joined(result.log);
  ExpectNoFault(result, hall.route);
}

INSTANTIATE_TEST_SUITE_P(
    OfBothWays, WholeCourse,
    ::testing::Values(Route{1, {{"qr_a", "A-1"}, {"arrow", "left"}, {"qr_b", "B-2"}}},
                      Route{4, {{"qr_a", "A-2"}, {"arrow", "right"}, {"qr_b", "B-1"}}, true}),
    [](const auto& route) { return "To_" + route.param.chosen.at("arrow"); });

}  // namespace
}  // namespace musher::race::testing
