#include "musher/modules/world/scene_file/scene_things.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "musher/base/toml/findings.hpp"
#include "musher/modules/world/scene_file/scene_keys.hpp"
#include "musher/modules/world/simulation/text.hpp"

namespace musher::world {
namespace {

using config_toml::Findings;
using config_toml::TableReader;
using Eigen::Vector2d;
using keys::Set;

constexpr int kMostFaceOfThing = 999;
constexpr std::size_t kLongestCode = 300;  // bytes; more squares than a camera can resolve
constexpr std::size_t kLongestText = 500;  // bytes
constexpr double kLongestShowS = 3600;
constexpr Color kArrowInk{32, 150, 60};
constexpr double kLeastPieceM = 1e-6;
constexpr double kArcStep = 3 * M_PI / 180;

class Things {
 public:
  Things(std::string folder, const Choices& choices, Findings& findings, Scene& scene)
      : folder_(std::move(folder)), choices_(choices), findings_(findings), scene_(scene) {}

  void ReadBox(TableReader& reader) {
    Box box{keys::Name(reader), keys::Center(reader), {}};
    for (const char* key : {"length_m", "width_m"}) reader.Require(key, "a length in metres");
    box.half_m.x() = keys::Length(reader, "length_m").value_or(1) / 2;
    box.half_m.y() = keys::Length(reader, "width_m").value_or(1) / 2;
    Set(box.yaw_rad, keys::Angle(reader, "yaw_deg"));
    ReadLook(reader, box);
    scene_.boxes.push_back(std::move(box));
  }

  void ReadWall(TableReader& reader) {
    for (const char* key : {"from_m", "to_m"}) reader.Require(key, "a point, as in [1.5, -2.0]");
    const auto from = keys::Pair(reader, "from_m");
    const auto to = keys::Pair(reader, "to_m");
    const double thickness = keys::Length(reader, "thickness_m").value_or(0.1);
    Box wall{keys::Name(reader), {}, {}};
    ReadLook(reader, wall);
    if (!from || !to) return;
    const Vector2d along = *to - *from;
    if (along.norm() < keys::kSmallestM) {
      return reader.Fault(reader.At("to_m"), "to_m", "expected another point than from_m");
    }
    wall.center_m = (*from + *to) / 2;
    wall.half_m = {along.norm() / 2, thickness / 2};
    wall.yaw_rad = std::atan2(along.y(), along.x());
    std::vector<Door> doors;
    keys::Each(reader, "door", findings_, [&](TableReader& door) { ReadDoor(door, wall, doors); });
    PutUp(wall, doors);
  }

  // An opening from the ground upwards; distances are along the wall.
  struct Door {
    double from_m = 0;
    double to_m = 0;
    double height_m = 0;
  };

  void ReadDoor(TableReader& reader, const Box& wall, std::vector<Door>& doors) {
    reader.Require("at_m", "the distance from from_m to its middle");
    const double at = keys::Height(reader, "at_m").value_or(0);
    const double half = keys::Length(reader, "width_m").value_or(0.9) / 2;
    const double height = keys::Length(reader, "height_m").value_or(wall.height_m);
    const double length = 2 * wall.half_m.x();
    if (at - half < 0 || at + half > length) {
      return reader.Fault(
          reader.At("at_m"), "at_m",
          "the door does not fit into its wall, which is " + MetresText(length) + " m long");
    }
    if (!doors.empty() && at - half < doors.back().to_m) {
      return reader.Fault(reader.At("at_m"), "at_m",
                          "expected the doors of a wall side by side, in the order of at_m");
    }
    doors.push_back({at - half, at + half, height});
  }

  // The pieces of the wall beside its doors, and over them.
  void PutUp(const Box& wall, const std::vector<Door>& doors) {
    const double length = 2 * wall.half_m.x();
    const Eigen::Rotation2Dd turn(wall.yaw_rad);
    const auto piece = [&](double from, double to, double bottom_m, double height_m) {
      if (to - from < kLeastPieceM || height_m < kLeastPieceM) return;
      Box box = wall;
      box.center_m = wall.center_m + turn * Vector2d((from + to - length) / 2, 0);
      box.half_m.x() = (to - from) / 2;
      box.bottom_m = bottom_m;
      box.height_m = height_m;
      scene_.boxes.push_back(std::move(box));
    };
    double from = 0;
    for (const Door& door : doors) {
      piece(from, door.from_m, wall.bottom_m, wall.height_m);
      piece(door.from_m, door.to_m, wall.bottom_m + door.height_m, wall.height_m - door.height_m);
      from = door.to_m;
    }
    piece(from, length, wall.bottom_m, wall.height_m);
  }

  void ReadCircle(TableReader& reader) {
    Circle circle{keys::Name(reader), keys::Center(reader), 0};
    reader.Require("radius_m", "a length in metres");
    circle.radius_m = keys::Length(reader, "radius_m").value_or(1);
    ReadLook(reader, circle);
    scene_.circles.push_back(std::move(circle));
  }

  void ReadBall(TableReader& reader) {
    Ball ball;
    ball.center_m.head<2>() = keys::Center(reader);
    Set(ball.radius_m, keys::Length(reader, "radius_m"));
    ball.center_m.z() = keys::Height(reader, "bottom_m").value_or(0) + ball.radius_m;
    Set(ball.color, keys::ReadColor(reader, "color", findings_));
    Set(ball.glows, reader.Bool("glows"));
    ball.name = keys::Name(reader);
    Set(ball.shown, reader.Bool("shown"));
    Set(ball.show_within_m, keys::Height(reader, "show_within_m"));
    if (const auto show_for_s = reader.Number("show_for_s", 0, kLongestShowS)) {
      ball.show_for = FromSeconds(*show_for_s);
    }
    if (reader.Has("show_within_m") != reader.Has("show_for_s")) {
      findings_.Error(reader.at(),
                      reader.path() + ": expected both show_within_m and show_for_s, or neither");
    }
    if (ball.name.empty() && (!ball.shown || ball.show_within_m > 0)) {
      reader.Require("name", "a name, because the ball appears");
    }
    scene_.balls.push_back(std::move(ball));
  }

  void ReadBoard(TableReader& reader) {
    Board board;
    board.name = keys::Name(reader);
    board.center_m = keys::Center(reader);
    Set(board.yaw_rad, keys::Angle(reader, "yaw_deg"));
    Set(board.width_m, keys::Length(reader, "width_m"));
    Set(board.height_m, keys::Length(reader, "height_m"));
    Set(board.bottom_m, keys::Height(reader, "bottom_m"));
    Set(board.color, keys::ReadColor(reader, "color", findings_));
    const auto ink = keys::ReadColor(reader, "ink", findings_);
    if (reader.Has("arrow")) board.sign.ink = kArrowInk;
    Set(board.sign.ink, ink);
    Set(board.round, reader.Choice<bool>("shape", {{"square", false}, {"round", true}}));
    ReadSign(reader, board.sign);
    scene_.boards.push_back(std::move(board));
  }

  void ReadSign(TableReader& reader, Sign& sign) {
    int signs = 0;
    for (const auto& [key, kind, longest] : {std::tuple("qr", Sign::Kind::kQr, kLongestCode),
                                             std::tuple("text", Sign::Kind::kText, kLongestText)}) {
      const auto text = choices_.String(reader, key);
      if (!text) continue;
      ++signs;
      sign.kind = kind;
      sign.content = text->text;
      if (text->text.empty() || text->text.size() > longest) {
        reader.Fault(text->at, key,
                     "expected 1 to " + std::to_string(longest) + " bytes, found " +
                         std::to_string(text->text.size()));
      }
    }
    if (const auto arrow = choices_.String(reader, "arrow")) {
      ++signs;
      sign.kind = Sign::Kind::kArrow;
      sign.content = arrow->text;
      if (arrow->text != "left" && arrow->text != "right") {
        reader.Fault(arrow->at, "arrow",
                     "expected one of left and right, found " + config_toml::Quote(arrow->text) +
                         findings_.Guess(arrow->text, {"left", "right"}));
      }
    }
    if (reader.Has("picture")) {
      ++signs;
      sign.kind = Sign::Kind::kPicture;
      Set(sign.content, keys::PictureFile(reader, "picture", folder_));
    }
    if (reader.Has("face")) {
      ++signs;
      sign.kind = Sign::Kind::kFace;
      sign.face = static_cast<int>(reader.Integer("face", 0, kMostFaceOfThing).value_or(0));
    }
    if (signs > 1) {
      findings_.Error(reader.at(), reader.path() +
                                       ": expected at most one of picture, qr, text, arrow and "
                                       "face, found several");
    }
  }

  // Straight from point to point, or an arc round a centre.
  void ReadLine(TableReader& reader) {
    Line line;
    Set(line.width_m, keys::Length(reader, "width_m"));
    Set(line.color, keys::ReadColor(reader, "color", findings_));
    Set(line.watched, reader.Bool("watched"));
    const bool closed = reader.Bool("closed").value_or(false);
    if (reader.Has("points_m") == reader.Has("center_m")) {
      findings_.Error(reader.at(), reader.path() +
                                       ": expected either points_m, or center_m with radius_m for "
                                       "an arc");
    }
    Set(line.points_m, keys::Points(reader, "points_m"));
    if (const auto center = keys::Pair(reader, "center_m")) {
      reader.Require("radius_m", "a length in metres");
      const double radius = keys::Length(reader, "radius_m").value_or(1);
      const double from = reader.Number("from_deg", -720, 720).value_or(0) * M_PI / 180;
      const double to = reader.Number("to_deg", -720, 720).value_or(360) * M_PI / 180;
      const int steps = std::max(1, static_cast<int>(std::ceil(std::abs(to - from) / kArcStep)));
      for (int i = 0; i <= steps; ++i) {
        const double angle = from + (to - from) * i / steps;
        line.points_m.emplace_back(*center + radius * Vector2d(std::cos(angle), std::sin(angle)));
      }
    }
    if (closed && !line.points_m.empty()) line.points_m.push_back(line.points_m.front());
    scene_.lines.push_back(std::move(line));
  }

  void ReadLabel(TableReader& reader) {
    reader.Require("text", "what is written there");
    const auto text = reader.String("text");
    scene_.labels.push_back({text ? text->text : "", keys::Center(reader)});
  }

  void ReadPad(TableReader& reader) {
    const Vector2d center = keys::Center(reader);
    scene_.pads.push_back({center, keys::Length(reader, "size_m").value_or(0.8)});
  }

 private:
  template <class Thing>
  void ReadLook(TableReader& reader, Thing& thing) {
    Set(thing.height_m, keys::Length(reader, "height_m"));
    Set(thing.bottom_m, keys::Height(reader, "bottom_m"));
    Set(thing.color, keys::ReadColor(reader, "color", findings_));
  }

  const std::string folder_;
  const Choices& choices_;
  Findings& findings_;
  Scene& scene_;
};

}  // namespace

void ReadThings(TableReader& root, const std::string& folder, const Choices& choices,
                Findings& findings, Scene& scene) {
  Things things(folder, choices, findings, scene);
  const std::pair<const char*, void (Things::*)(TableReader&)> kinds[] = {
      {"box", &Things::ReadBox},   {"wall", &Things::ReadWall},   {"circle", &Things::ReadCircle},
      {"ball", &Things::ReadBall}, {"board", &Things::ReadBoard}, {"line", &Things::ReadLine},
      {"pad", &Things::ReadPad},   {"label", &Things::ReadLabel}};
  for (const auto& [key, read] : kinds) {
    keys::Each(root, key, findings,
               [&, read = read](TableReader& reader) { (things.*read)(reader); });
  }
}

}  // namespace musher::world
