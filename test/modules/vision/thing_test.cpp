// The shipped detectors of arrows, bars, lamps, letters and codes in rooms that no author of a
// detector has drawn: what they say is right, or they say nothing. See thing_pictures.hpp.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <iostream>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/objdetect.hpp>
#include <optional>
#include <ostream>
#include <set>
#include <string>
#include <variant>
#include <vector>

#include "musher/modules/vision/course/course_detectors.hpp"
#include "musher/modules/vision/vision_config.hpp"
#include "musher/test/modules/vision/photographs.hpp"
#include "musher/test/modules/vision/thing_pictures.hpp"
#include "musher/test/support/nightly.hpp"
#include "musher/test/support/paths.hpp"

namespace musher::vision::things {
namespace {

// What has to be said of a picture, and where; nothing in the box: nothing has to be found.
struct Truth {
  std::string word;  // of an arrow or a board
  std::optional<cv::Rect2d> box;
  std::optional<double> depth_m{};  // of a bar or a lamp
};

struct Thing {
  std::string name;
  bool is_there = true;  // false: something alike, of which nothing must be said
  std::function<Truth(RoomPicture&, cv::RNG&)> put;
};

struct Condition {
  std::string name;
  Room room;
  bool is_covered = false;
};

const std::vector<Condition>& Conditions() {
  static const std::vector<Condition> all = [] {
    const Room room;
    std::vector<Condition> some{{"plain", room}};
    const auto add = [&](const std::string& name, const std::function<void(Room&)>& change) {
      some.push_back({name, room});
      change(some.back().room);
    };
    add("bricks", [](Room& other) { other.wall = Wall::kBricks; });
    add("wood", [](Room& other) { other.wall = Wall::kWood; });
    add("3000 K", [](Room& other) { other.kelvin = 3000; });
    add("8000 K", [](Room& other) { other.kelvin = 8000; });
    add("15 %", [](Room& other) { other.share = 0.15; });
    add("120 %", [](Room& other) { other.share = 1.2; });
    add("shadow", [](Room& other) { other.shadow = true; });
    add("blur", [](Room& other) { other.blur_px = 1.8; });
    add("red shirt", [](Room& other) { other.beside = Beside::kRedShirt; });
    add("poster", [](Room& other) { other.beside = Beside::kPoster; });
    add("window", [](Room& other) { other.beside = Beside::kWindow; });
    add("bricks, 3000 K", [](Room& other) {
      other.wall = Wall::kBricks;
      other.kelvin = 3000;
    });
    some.push_back({"covered", room, true});
    return some;
  }();
  return all;
}

bool Flip(cv::RNG& random) {
  return random.uniform(0.0, 1.0) < 0.5;
}

// Where all of it is in the picture.
Place Somewhere(cv::RNG& random, double width_m, double height_m, double near_m, double far_m) {
  Place place;
  place.ahead_m = random.uniform(near_m, far_m);
  place.width_m = width_m;
  place.height_m = height_m;
  const double room_m = std::max(0.0, 0.7 * place.ahead_m - width_m / 2 - 0.05);
  place.left_m = random.uniform(-room_m, room_m + 1e-6);
  place.yaw_deg = random.uniform(-20.0, 20.0);
  place.up_m = random.uniform(0.35, 0.5);
  return place;
}

// Arrows ---------------------------------------------------------------------------------------

Corners Turned(Corners corners, bool left) {
  for (cv::Point2d& corner : corners) corner.x = left ? 1 - corner.x : corner.x;
  return corners;
}

const Corners kBlock{{.12, .4}, {.55, .4}, {.55, .18}, {.88, .5}, {.55, .82}, {.55, .6}, {.12, .6}};
const Corners kChevron{{.3, .15}, {.5, .15}, {.75, .5}, {.5, .85}, {.3, .85}, {.55, .5}};
const Corners kElbow{{.2, .9},   {.2, .28},  {.55, .28}, {.55, .12}, {.85, .37},
                     {.55, .62}, {.55, .46}, {.38, .46}, {.38, .9}};
const Corners kTapered{{.1, .47},  {.55, .38}, {.55, .18}, {.9, .5},
                       {.55, .82}, {.55, .62}, {.1, .53}};
const Corners kUpwards{{.42, .9}, {.42, .5}, {.25, .5}, {.5, .12}, {.75, .5}, {.58, .5}, {.58, .9}};
const Corners kBothWays{{.08, .5}, {.32, .2}, {.32, .42}, {.68, .42}, {.68, .2},
                        {.92, .5}, {.68, .8}, {.68, .58}, {.32, .58}, {.32, .8}};
const Corners kSquare{{0, 0}, {1, 0}, {1, 1}, {0, 1}};

Thing ArrowOf(const std::string& name, const Corners& shape, bool is_there, bool white_on_green) {
  return {name, is_there, [=](RoomPicture& picture, cv::RNG& random) {
            const Place place = Somewhere(random, 0.5, 0.4, 0.7, 2.2);
            const bool left = Flip(random);
            Face face = Blank(place, white_on_green ? kGreen : kWhite);
            if (!white_on_green) Frame(face, 0.03, kBlack);
            Fill(face, Turned(shape, left), white_on_green ? kWhite : kGreen);
            picture.Put(face, place);
            return is_there ? Truth{left ? "left" : "right", RoomPicture::BoxOf(place)} : Truth{};
          }};
}

Truth PutPlant(RoomPicture& picture, cv::RNG& random) {
  const Place place = Somewhere(random, 0.5, 0.6, 0.7, 2.2);
  Face face = Blank(place, {}, 0);
  for (int i = 0; i < 14; ++i) {
    const double wide = random.uniform(0.1, 0.35), high = random.uniform(0.1, 0.35);
    FillEllipse(face, {random.uniform(0.0, 1 - wide), random.uniform(0.0, 0.7 - high), wide, high},
                kGreen * random.uniform(0.5, 1.3));
  }
  Fill(face, {{.35, .7}, {.65, .7}, {.6, 1}, {.4, 1}}, {0.05, 0.12, 0.3});
  picture.Put(face, place);
  return {};
}

std::vector<Thing> Arrows() {
  return {ArrowOf("block", kBlock, true, false),
          ArrowOf("chevron", kChevron, true, false),
          ArrowOf("elbow", kElbow, true, false),
          ArrowOf("tapered", kTapered, true, false),
          ArrowOf("white on green", kBlock, true, true),
          ArrowOf("no arrow: upwards", kUpwards, false, false),
          ArrowOf("no arrow: both ways", kBothWays, false, false),
          ArrowOf("no arrow: white square on green", {{.3, .3}, {.7, .3}, {.7, .7}, {.3, .7}},
                  false, true),
          ArrowOf("no arrow: green board", kSquare, false, false),
          {"no arrow: plant", false, PutPlant}};
}

// Bars -----------------------------------------------------------------------------------------

constexpr double kBarM = 0.08;  // high, as config/vision/course.toml has it

void FillStripes(Face& face, double stripe_m, double width_m, double slant,
                 const cv::Scalar& color) {
  const double step = stripe_m / width_m;
  for (double at = -step; at < 1 + step; at += 2 * step) {
    Fill(face, {{at + slant * step, 0}, {at + (1 + slant) * step, 0}, {at + step, 1}, {at, 1}},
         color);
  }
}

Place BarPlace(cv::RNG& random) {
  Place place = Somewhere(random, random.uniform(0.9, 1.3), kBarM, 0.9, 2.4);
  place.left_m = random.uniform(-0.2, 0.2);
  place.yaw_deg /= 2;
  place.up_m = random.uniform(0.4, 0.55);
  return place;
}

Thing BarOf(const std::string& name, const cv::Scalar& ground, const cv::Scalar& stripes) {
  return {name, true, [=](RoomPicture& picture, cv::RNG& random) {
            const Place place = BarPlace(random);
            Face face = Blank(place, ground);
            FillStripes(face, random.uniform(0.08, 0.14), place.width_m,
                        Flip(random) ? 0 : random.uniform(0.4, 0.8), stripes);
            picture.Put(face, place);
            return Truth{"", RoomPicture::BoxOf(place), RoomPicture::DepthOf(place)};
          }};
}

Truth PutGate(RoomPicture& picture, cv::RNG& random) {
  const Place bar = BarPlace(random);
  picture.Put(Blank(bar, kRed), bar);
  const double yaw = bar.yaw_deg * M_PI / 180;
  for (const double side : {-0.5, 0.5}) {
    Place post = bar;
    post.width_m = 0.07;
    post.height_m = bar.up_m + kBarM / 2;
    post.up_m = post.height_m / 2;
    post.left_m += side * bar.width_m * std::cos(yaw);
    post.ahead_m += side * bar.width_m * std::sin(yaw);
    picture.Put(Blank(post, kRed), post);
  }
  return {"", RoomPicture::BoxOf(bar), RoomPicture::DepthOf(bar)};
}

// Of a person whose red shirt the upper edge of the picture cuts.
Truth PutNearShirt(RoomPicture& picture, cv::RNG& random) {
  Place place{random.uniform(0.7, 1.6), random.uniform(-0.3, 0.3), 0.7, 0, 0.45, 1.4};
  Face face = Blank(place, {}, 0);
  Fill(face, {{.12, .45}, {.88, .45}, {.8, 1}, {.55, 1}, {.5, .55}, {.45, 1}, {.2, 1}},
       {0.15, 0.06, 0.04});
  Fill(face, {{0, 0}, {1, 0}, {.95, .5}, {.05, .5}}, kRed);
  picture.Put(face, place);
  return {};
}

Truth PutPost(RoomPicture& picture, cv::RNG& random) {
  Place place = Somewhere(random, 0.1, 0.8, 0.9, 2.4);
  place.up_m = 0.4;
  picture.Put(Blank(place, kRed), place);
  return {};
}

// Amber, under a dark ceiling.
Truth PutRowOfLamps(RoomPicture& picture, cv::RNG& random) {
  const double ahead_m = random.uniform(2.2, 3.4), up_m = 0.35 + 0.36 * ahead_m;
  const Place ceiling{ahead_m + 0.1, 0, up_m, 0, 4, 0.8};
  picture.Put(Blank(ceiling, kBlack), ceiling);
  const int count = random.uniform(3, 6);
  const double radius_m = random.uniform(0.04, 0.06), step_m = radius_m * random.uniform(4.0, 5.8);
  for (int i = 0; i < count; ++i) {
    picture.PutLamp(
        {ahead_m, (i - count / 2) * step_m, up_m, radius_m, kAmber, random.uniform(2.0, 10.0)});
  }
  return {};
}

// A low panel of wood, its slats 27 mm wide, with black gaps of 13 mm.
Truth PutSlats(RoomPicture& picture, cv::RNG& random) {
  Place place = Somewhere(random, 1.2, random.uniform(0.1, 0.3), 0.8, 1.6);
  place.left_m = random.uniform(-0.2, 0.2);
  Face face = Blank(place, kBlack);
  constexpr double kSlatM = 0.027, kStepM = 0.04;
  for (double at_m = 0; at_m < place.width_m; at_m += kStepM) {
    const double left = at_m / place.width_m, right = (at_m + kSlatM) / place.width_m;
    Fill(face, {{left, 0}, {right, 0}, {right, 1}, {left, 1}}, {0.05, 0.24, 0.45});
  }
  picture.Put(face, place);
  return {};
}

// Before a light wall: red backs of chairs, or pennants on a string.
Truth PutRedRow(RoomPicture& picture, cv::RNG& random, const Corners& shape) {
  const double ahead_m = random.uniform(1.4, 3.0);
  const Place wall{ahead_m + 0.2, 0, 1.2, 0, 8, 3.2};
  picture.Put(Blank(wall, cv::Scalar(0.7, 0.72, 0.72) * random.uniform(0.8, 1.1)), wall);
  const int count = random.uniform(3, 6);
  const double wide_m = random.uniform(0.12, 0.25), step_m = wide_m * random.uniform(1.5, 2.2);
  const double high_m = wide_m * random.uniform(0.8, 1.2), up_m = random.uniform(0.3, 0.6);
  for (int i = 0; i < count; ++i) {
    const Place place{ahead_m, (i - (count - 1) / 2.0) * step_m, up_m, 0, wide_m, high_m};
    Face face = Blank(place, {}, 0);
    Fill(face, shape, kRed);
    picture.Put(face, place);
  }
  return {};
}

Truth PutChairs(RoomPicture& picture, cv::RNG& random) {
  return PutRedRow(picture, random, kSquare);
}

Truth PutPennants(RoomPicture& picture, cv::RNG& random) {
  return PutRedRow(picture, random, {{0, 0}, {1, 0}, {0.6, 1}, {0.4, 1}});
}

// Red, white and red, 3 : 2.
Truth PutFlag(RoomPicture& picture, cv::RNG& random) {
  Place place = Somewhere(random, 0.9, 0.6, 1.2, 2.4);
  place.yaw_deg /= 2;
  Face face = Blank(place, kRed);
  Fill(face, {{0, 1 / 3.0}, {1, 1 / 3.0}, {1, 2 / 3.0}, {0, 2 / 3.0}}, kWhite);
  picture.Put(face, place);
  return {};
}

Truth PutNothing(RoomPicture& /*picture*/, cv::RNG& /*random*/) {
  return {};
}

std::vector<Thing> Bars() {
  return {BarOf("red", kRed, kRed),
          BarOf("red and white", kWhite, kRed),
          BarOf("yellow and black", kBlack, kYellow),
          {"gate", true, PutGate},
          {"no bar: shirt at the top", false, PutNearShirt},
          {"no bar: post", false, PutPost},
          {"no bar: row of lamps", false, PutRowOfLamps},
          {"no bar: slats", false, PutSlats},
          {"no bar: chairs", false, PutChairs},
          {"no bar: pennants", false, PutPennants},
          {"no bar: flag", false, PutFlag},
          {"no bar", false, PutNothing}};
}

// Lamps ----------------------------------------------------------------------------------------

Thing LampOf(const std::string& name, const cv::Scalar& color, double brightness,
             bool is_there = true) {
  return {
      name, is_there, [=](RoomPicture& picture, cv::RNG& random) {
        const Place place = Somewhere(random, 0.2, 0.2, 0.8, 2.4);
        const Lamp lamp{place.ahead_m, place.left_m, place.up_m,
                        0.1,           color,        brightness * random.uniform(0.7, 1.4)};
        picture.PutLamp(lamp);
        return is_there ? Truth{"", RoomPicture::BoxOf(lamp), RoomPicture::DepthOf(lamp)} : Truth{};
      }};
}

// Yellow and square, with a white disc.
Truth PutSignWithDisc(RoomPicture& picture, cv::RNG& random) {
  const Place place = Somewhere(random, 0.4, 0.4, 0.8, 2.4);
  Face face = Blank(place, kYellow);
  const double disc = random.uniform(0.4, 0.75);
  FillEllipse(face, {0.5 - disc / 2, 0.5 - disc / 2, disc, disc}, kWhite);
  picture.Put(face, place);
  return {};
}

std::vector<Thing> Lamps() {
  return {LampOf("yellow", kLampYellow, 2),
          LampOf("yellow, white core", kLampYellow, 30),
          LampOf("amber", kAmber, 2),
          LampOf("amber, white core", kAmber, 80),
          LampOf("no lamp: white", kLampWhite, 10, false),
          LampOf("no lamp: red", {0.02, 0.04, 1}, 3, false),
          {"no lamp: sign with a disc", false, PutSignWithDisc},
          LampOf("no lamp: green", {0.15, 1, 0.1}, 3, false),
          {"no lamp", false, PutNothing}};
}

// Signs ----------------------------------------------------------------------------------------

Thing SignOf(const std::string& name, bool is_round, bool is_there, const cv::Scalar& color,
             double wide_m = 0.2) {
  return {name, is_there, [=](RoomPicture& picture, cv::RNG& random) {
            Place place = Somewhere(random, wide_m, 0.2, 0.9, 2.6);
            place.up_m = 0.4 + 0.1 * place.ahead_m;
            Face face = Blank(place, {}, 0);
            if (is_round) {
              FillEllipse(face, {0, 0, 1, 1}, color);
            } else {
              Fill(face, kSquare, color);
            }
            picture.Put(face, place);
            return is_there ? Truth{"", RoomPicture::BoxOf(place), RoomPicture::DepthOf(place)}
                            : Truth{};
          }};
}

std::vector<Thing> Signs() {
  return {SignOf("round", true, true, kYellow),
          SignOf("square", false, true, kYellow),
          SignOf("no sign: white disc", true, false, kWhite),
          SignOf("no sign: red disc", true, false, kRed),
          SignOf("no sign: long and yellow", false, false, kYellow, 0.7),
          {"no sign", false, PutNothing}};
}

// Boards ---------------------------------------------------------------------------------------

constexpr std::array kFonts{cv::FONT_HERSHEY_SIMPLEX, cv::FONT_HERSHEY_DUPLEX,
                            cv::FONT_HERSHEY_COMPLEX};

Thing LettersOf(const std::string& text, bool is_there, bool is_lit = false) {
  const std::string name = (is_there ? "" : "no word: ") + text + (is_lit ? " under a lamp" : "");
  return {name, is_there, [=](RoomPicture& picture, cv::RNG& random) {
            const Place place = Somewhere(random, text.size() > 4 ? 0.8 : 0.5, 0.32, 0.7, 1.8);
            Face face = Blank(place, kWhite);
            if (Flip(random)) Frame(face, 0.04, kBlack);
            Write(face, text, 0.45, kFonts.at(std::size_t(random.uniform(0, 3))), kBlack);
            picture.Put(face, place);
            if (is_lit) {
              picture.PutLamp({place.ahead_m - 0.05, place.left_m + random.uniform(-0.1, 0.1),
                               place.up_m + 0.2, 0.05, kLampWhite, 30});
            }
            return is_there ? Truth{text, RoomPicture::BoxOf(place)} : Truth{};
          }};
}

std::vector<Thing> Boards() {
  return {LettersOf("A-1", true),       LettersOf("A-2", true),
          LettersOf("B-1", true),       LettersOf("B-2", true),
          LettersOf("A-1", true, true), LettersOf("8-1", false),
          LettersOf("A-1 A-2", false),  LettersOf("STOP", false),
          LettersOf("B-8", false),      {"no word: no board", false, PutNothing}};
}

Thing CodeOf(const std::string& word, bool is_there, bool inverted) {
  const std::string name = (is_there ? "" : "no word: ") + word + (inverted ? ", inverted" : "");
  return {
      name, is_there, [=](RoomPicture& picture, cv::RNG& random) {
        const Place place = Somewhere(random, 0.4, 0.4, 0.6, 1.5);
        cv::Mat code;
        cv::QRCodeEncoder::create()->encode(word, code);
        constexpr int kQuiet = 3;  // squares, beside those of the encoder
        Face face = Blank(place, inverted ? kBlack : kWhite);
        const double side = 1.0 / (code.cols + 2 * kQuiet);
        for (int y = 0; y < code.rows; ++y) {
          for (int x = 0; x < code.cols; ++x) {
            if (code.at<std::uint8_t>(y, x) != 0) continue;
            const double left = (x + kQuiet) * side, top = (y + kQuiet) * side;
            Fill(face,
                 {{left, top}, {left + side, top}, {left + side, top + side}, {left, top + side}},
                 inverted ? kWhite : kBlack);
          }
        }
        picture.Put(face, place);
        return is_there ? Truth{word, RoomPicture::BoxOf(place)} : Truth{};
      }};
}

std::vector<Thing> Codes() {
  return {CodeOf("A-1", true, false), CodeOf("B-2", true, false), CodeOf("A-2", true, true),
          CodeOf("B-1", true, true), CodeOf("P-7", false, false)};
}

// Verdicts -------------------------------------------------------------------------------------

enum class Verdict { kFound, kNothing, kWrong };

cv::Rect2d BoxOf(const msg::Sighting& sighting) {
  return {sighting.x * 640.0, sighting.y * 480.0, sighting.width * 640.0, sighting.height * 480.0};
}

// Whether a box is that of the thing, as far as the picture shows it.
bool IsOver(const cv::Rect2d& found, const cv::Rect2d& real, double most_factor) {
  constexpr double kRimPx = 4;
  const cv::Rect2d shown = real & cv::Rect2d(0, 0, 640, 480);
  const cv::Point2d middle = (found.tl() + found.br()) / 2;
  const cv::Rect2d around(shown.x - kRimPx, shown.y - kRimPx, shown.width + 2 * kRimPx,
                          shown.height + 2 * kRimPx);
  return around.contains(middle) && found.height < most_factor * around.height &&
         around.height < most_factor * (found.height + 2 * kRimPx);
}

// Not of a bar that an edge cuts: it has no distance.
bool IsAsFar(const msg::Sighting& sighting, const Truth& truth) {
  constexpr double kMostOff = 0.35;
  const double distance_m = sighting.distance_m, depth_m = truth.depth_m.value();
  return std::isnan(distance_m) || std::abs(distance_m - depth_m) < kMostOff * depth_m;
}

Verdict OfSighting(const CourseSight& sight, const Truth& truth, double most_factor) {
  if (!sight.sighting || !sight.sighting->seen) return Verdict::kNothing;
  if (!truth.box) return Verdict::kWrong;
  const bool is_it =
      IsOver(BoxOf(*sight.sighting), *truth.box, most_factor) && IsAsFar(*sight.sighting, truth);
  return is_it ? Verdict::kFound : Verdict::kWrong;
}

Verdict OfWord(const std::string& said, const Truth& truth) {
  if (said.empty()) return Verdict::kNothing;
  return said == truth.word ? Verdict::kFound : Verdict::kWrong;
}

CourseEntry Shipped(CourseKind kind) {
  const Parsed<VisionConfig> reading = ReadVisionFile(SourceDir() + "/config/vision/course.toml");
  for (const CourseEntry& entry : reading.config.value().detectors) {
    if (entry.kind == kind) return entry;
  }
  ADD_FAILURE() << "there is no detector of that kind";
  return {};
}

struct Count {
  int found = 0, missed = 0, wrong = 0, right_nothing = 0;
  void Add(Verdict verdict, bool is_there) {
    ++(verdict == Verdict::kWrong   ? wrong
       : verdict == Verdict::kFound ? found
       : is_there                   ? missed
                                    : right_nothing);
  }
  int pictures() const { return found + missed + wrong + right_nothing; }
  std::string Text() const {
    return fmt::format("found {:3} missed {:3} WRONG {:2} rightly nothing {:3}", found, missed,
                       wrong, right_nothing);
  }
};

// One detector and its pictures.
class Contest {
 public:
  Contest(CourseKind kind, std::vector<Thing> things)
      : kind_(kind), entry_(Shipped(kind)), things_(std::move(things)) {
    if (auto* qr = std::get_if<QrParameters>(&entry_.parameters)) qr->thorough_every = 1;
  }

  // The things in that condition: all in the nightly run, else the `number`th of both sorts, from 1
  // on.
  void Try(const Condition& condition, std::uint64_t seed, std::size_t number) {
    std::vector<Thing> there, alike;
    for (const Thing& thing : things_) (thing.is_there ? there : alike).push_back(thing);
    if (!testing::Nightly()) {
      there = {there.at((number - 1) % there.size())};
      alike = {alike.at((number - 1) % alike.size())};
    }
    for (const std::vector<Thing>& some : {there, alike}) {
      for (const Thing& thing : some) Try(condition, thing, seed += 17);
    }
  }

  std::string Table() const {
    std::string table;
    for (const auto* counts : {&by_condition_, &by_thing_}) {
      for (const auto& [name, count] : *counts) {
        table += fmt::format("  {:28} {}\n", name, count.Text());
      }
    }
    return table + fmt::format("  {:28} {}\n", "all", all_.Text());
  }
  const std::string& wrong() const { return wrong_; }
  const Count& all() const { return all_; }
  Count In(const std::string& condition) { return by_condition_[condition]; }

 private:
  void Try(const Condition& condition, const Thing& thing, std::uint64_t seed);
  Verdict Look(const RoomPicture& picture, const Truth& truth, std::string& said) const;

  const CourseKind kind_;
  CourseEntry entry_;
  const std::vector<Thing> things_;
  std::map<std::string, Count> by_condition_, by_thing_;
  Count all_;
  std::string wrong_;
};

Verdict Contest::Look(const RoomPicture& picture, const Truth& truth, std::string& said) const {
  const auto* qr = std::get_if<QrParameters>(&entry_.parameters);
  const auto detector = qr != nullptr ? MakeQrDetector(*qr) : entry_.factory.make().value();
  const Lens lens{false, kFocalPx / 640, kFocalPx / 480};
  CourseSight sight = detector->Look(picture.Taken(), 1, lens);
  said = sight.sighting ? sight.sighting->text : "";
  switch (kind_) {
    case CourseKind::kArrow:
      return OfWord(said, truth);
    case CourseKind::kQr:
      for (std::uint64_t exposure = 1; !sight.text && exposure < 3; ++exposure) {
        sight = detector->Look(picture.Taken(exposure), std::int64_t(exposure) + 1, std::nullopt);
      }
      said = sight.text.value_or("");
      return OfWord(said, truth);
    default:
      return OfSighting(sight, truth, kind_ == CourseKind::kLight ? 1.7 : 2.5);
  }
}

void Contest::Try(const Condition& condition, const Thing& thing, std::uint64_t seed) {
  Room room = condition.room;
  room.seed = seed;
  RoomPicture picture(room);
  cv::RNG random(seed * 101 + 13);
  const Truth truth = thing.put(picture, random);
  if (condition.is_covered && truth.box) {  // by a post before it
    const double at = random.uniform(truth.box->x, truth.box->br().x);
    const Place post{0.55, (320 - at) / 381 * 0.55, 0.35, 0, 0.02, 0.9};
    picture.Put(Blank(post, {0.1, 0.1, 0.1}), post);
  }
  std::string said;
  const Verdict verdict = Look(picture, truth, said);
  by_condition_[condition.name].Add(verdict, thing.is_there);
  by_thing_[thing.name].Add(verdict, thing.is_there);
  all_.Add(verdict, thing.is_there);
  const std::string text =
      fmt::format("{}, {}, seed {}: '{}'", condition.name, thing.name, seed, said);
  if (verdict == Verdict::kWrong) wrong_ += text + "\n";
  const char* folder = std::getenv("MUSHER_SHOW_PICTURES");
  const bool is_shown =
      verdict == Verdict::kWrong || (verdict == Verdict::kNothing && thing.is_there);
  if (folder == nullptr || !is_shown) return;
  static int shown = 0;
  cv::Mat bgr = picture.Taken();
  cv::putText(bgr, (verdict == Verdict::kWrong ? "WRONG " : "missed ") + text, {4, 12},
              cv::FONT_HERSHEY_SIMPLEX, 0.4, {0, 0, 255});
  if (truth.box) cv::rectangle(bgr, *truth.box, {255, 0, 255});
  cv::imwrite(fmt::format("{}/{:04}.png", folder, shown++), bgr);
}

// In each condition; in the gate in each `gate_step`th one. MUSHER_FIRST=N has other pictures.
void ExpectRightOrNothing(CourseKind kind, std::vector<Thing> things, int nightly_rounds,
                          std::size_t gate_step) {
  constexpr double kLeastFound = 0.5;
  Contest contest(kind, std::move(things));
  const char* first = std::getenv("MUSHER_FIRST");
  std::uint64_t seed = first == nullptr ? 1 : std::strtoull(first, nullptr, 10);
  const int rounds = testing::Nightly() ? nightly_rounds : 1;
  for (int round = 0; round < rounds; ++round) {
    std::size_t number = 0;
    for (const Condition& condition : Conditions()) {
      seed += 1000;
      ++number;
      if (testing::Nightly() || number % gate_step == 0) {
        contest.Try(condition, seed, number / gate_step);
      }
    }
  }
  std::cout << contest.Table();
  const Count& all = contest.all();
  // Known of the nightly pictures: a yellow disc printed on a poster counts as a light and as a
  // sign, and a printed red stripe that a panel covers in part as a bar.
  const bool is_yellow = kind == CourseKind::kLight || kind == CourseKind::kMarker;
  const int known = testing::Nightly() && is_yellow ? contest.In("poster").wrong : 0;
  const double most_wrong = testing::Nightly() ? 0.006 : 0;
  EXPECT_LE(all.wrong - known, most_wrong * all.pictures()) << contest.wrong();
  EXPECT_GE(all.found, kLeastFound * (all.found + all.missed)) << "hardly anything is found";
  if (!testing::Nightly()) return;
  const Count plain = contest.In("plain");
  EXPECT_GE(plain.found, 0.8 * (plain.found + plain.missed + plain.wrong)) << "in plain pictures";
}

TEST(ThingsInRooms, ArrowsAreRightOrNotRead) {
  ExpectRightOrNothing(CourseKind::kArrow, Arrows(), 3, 2);
}

TEST(ThingsInRooms, BarsAreRightOrNotSeen) {
  ExpectRightOrNothing(CourseKind::kBarrier, Bars(), 3, 2);
}

TEST(ThingsInRooms, LampsAreRightOrNotSeen) {
  ExpectRightOrNothing(CourseKind::kLight, Lamps(), 3, 2);
}

TEST(ThingsInRooms, SignsAreRightOrNotSeen) {
  ExpectRightOrNothing(CourseKind::kMarker, Signs(), 3, 2);
}

TEST(ThingsInRooms, LettersAreRightOrNotRead) {
  ExpectRightOrNothing(CourseKind::kQr, Boards(), 2, 5);
}

TEST(ThingsInRooms, CodesAreRightOrNotRead) {
  ExpectRightOrNothing(CourseKind::kQr, Codes(), 2, 5);
}

struct Scenes {
  photographs::Package package;
  photographs::Half half = photographs::Half::kLookedAt;
};

void PrintTo(const Scenes& scenes, std::ostream* out) {
  *out << scenes.package.name;
}

std::vector<Scenes> AllScenes() {
  std::vector<Scenes> all;
  for (const photographs::Package& package : photographs::Packages()) {
    for (const photographs::Half half : {photographs::Half::kLookedAt, photographs::Half::kHeld}) {
      bool has_any = false;
      for (std::size_t i = 0; i < package.scenes.size(); ++i) {
        has_any = has_any || photographs::HalfOf(package, i) == half;
      }
      if (has_any) all.push_back({package, half});
    }
  }
  return all;
}

// Before photographs of a Debian package, in four lights in turn; those that may be looked at also
// in parts, in each light.
class ThingsBeforePhotographs : public ::testing::TestWithParam<Scenes> {
 protected:
  void SetUp() override {
    if (!photographs::IsInstalled(GetParam().package)) {
      GTEST_SKIP() << "needs the Debian package " << GetParam().package.name;
    }
  }

  static constexpr std::size_t kLights = 4;

  static Condition Lit(const photographs::Photograph& photograph, std::size_t light) {
    Room room;
    room.scene = photographs::LinearOf(GetParam().package, photograph);
    switch (light % kLights) {
      case 1:
        room.kelvin = 3000;
        break;
      case 2:
        room.share = 0.15;
        break;
      case 3:
        room.blur_px = 1.8;
        break;
      default:
        break;
    }
    return {photograph.name, room};
  }

  // Prints what is found, missed and wrong. `known`: photographs with something that is taken for
  // the thing, as red plates for a bar.
  static void ExpectRightOrNotFound(CourseKind kind, std::vector<Thing> things,
                                    const std::set<std::string>& known = {}) {
    Contest contest(kind, std::move(things));
    const std::vector<photographs::Photograph>& scenes = GetParam().package.scenes;
    std::uint64_t seed = 7000;
    for (std::size_t i = 0; i < scenes.size(); ++i) {
      seed += 1000;
      if (photographs::HalfOf(GetParam().package, i) != GetParam().half) continue;
      contest.Try(Lit(scenes[i], i), seed, 1);
    }
    int wrong = contest.all().wrong;
    for (const std::string& name : known) wrong -= contest.In(name).wrong;
    std::cout << contest.Table();
    EXPECT_EQ(wrong, 0) << contest.wrong();
  }

  static void ExpectRightInParts(CourseKind kind, const std::vector<Thing>& things,
                                 const std::set<std::string>& known = {}) {
    if (GetParam().half == photographs::Half::kHeld) GTEST_SKIP() << "is not looked at";
    Contest contest(kind, things);
    const std::vector<photographs::Photograph>& scenes = GetParam().package.scenes;
    std::uint64_t seed = 100'000;
    for (std::size_t i = 0; i < scenes.size(); ++i) {
      if (photographs::HalfOf(GetParam().package, i) != GetParam().half) continue;
      std::size_t light = i;
      for (const photographs::Photograph& part : photographs::PartsOf(scenes[i])) {
        contest.Try(Lit(part, light++), seed += 1000, 1);
      }
    }
    int wrong = contest.all().wrong;
    for (const std::string& name : known) wrong -= contest.In(name).wrong;
    std::cout << contest.Table();
    EXPECT_EQ(wrong, 0) << contest.wrong();
  }
};

TEST_P(ThingsBeforePhotographs, ArrowsAreRightOrNotRead) {
  ExpectRightOrNotFound(CourseKind::kArrow, Arrows());
}

TEST_P(ThingsBeforePhotographs, BarsAreRightOrNotSeen) {
  ExpectRightOrNotFound(CourseKind::kBarrier, Bars(),
                        {"butterfly.jpg", "coffee.png", "aitzgorri_by_Aitzol_Berasategi.jpg",
                         "fluent-color.png", "goldfish.png", "rhythm.jpg"});
}

TEST_P(ThingsBeforePhotographs, LampsAreRightOrNotSeen) {
  ExpectRightOrNotFound(CourseKind::kLight, Lamps(), {"GreenMeadow.jpg"});
}

TEST_P(ThingsBeforePhotographs, LampsBeforePartsAreRightOrNotSeen) {
  ExpectRightInParts(CourseKind::kLight, Lamps());
}

TEST_P(ThingsBeforePhotographs, SignsAreRightOrNotSeen) {
  ExpectRightOrNotFound(CourseKind::kMarker, Signs(), {"Dragonfly_by_Bolly.jpg"});
}

TEST_P(ThingsBeforePhotographs, SignsBeforePartsAreRightOrNotSeen) {
  ExpectRightInParts(CourseKind::kMarker, Signs(), {"aloeL.jpg"});
}

TEST_P(ThingsBeforePhotographs, CodesAreRightOrNotRead) {
  ExpectRightOrNotFound(CourseKind::kQr, Codes());
}

// A suite of its own: they take longer than all others.
class LettersBeforePhotographs : public ThingsBeforePhotographs {};

TEST_P(LettersBeforePhotographs, AreRightOrNotRead) {
  ExpectRightOrNotFound(CourseKind::kQr, Boards());
}

std::string NameOf(const ::testing::TestParamInfo<Scenes>& info) {
  std::string name = info.param.package.name;
  std::ranges::replace_if(
      name, [](char letter) { return letter == '-' || letter == '.'; }, '_');
  return name + (info.param.half == photographs::Half::kHeld ? "_held" : "_looked_at");
}

INSTANTIATE_TEST_SUITE_P(Packages, ThingsBeforePhotographs, ::testing::ValuesIn(AllScenes()),
                         NameOf);
INSTANTIATE_TEST_SUITE_P(Packages, LettersBeforePhotographs, ::testing::ValuesIn(AllScenes()),
                         NameOf);

}  // namespace
}  // namespace musher::vision::things
