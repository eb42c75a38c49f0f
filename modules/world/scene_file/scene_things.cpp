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

namespace row = config_toml::row;
using config_toml::Findings;
using config_toml::Row;
using config_toml::TableReader;
using Eigen::Vector2d;

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
    Box box;
    keys::ReadSome(reader,
                   {row::Text("name", box.name), keys::Center(box.center_m),
                    keys::Half("length_m", box.half_m.x()), keys::Half("width_m", box.half_m.y()),
                    keys::Angle("yaw_deg", box.yaw_rad), LookRow(box)});
    scene_.boxes.push_back(std::move(box));
  }

  void ReadWall(TableReader& reader) {
    for (const char* key : {"from_m", "to_m"}) reader.Require(key, "a point, as in [1.5, -2.0]");
    const auto from = keys::ReadPoint(reader, "from_m");
    const auto to = keys::ReadPoint(reader, "to_m");
    double thickness = 0.1;
    Box wall{};
    keys::ReadSome(reader, {keys::Length("thickness_m", thickness), row::Text("name", wall.name),
                            LookRow(wall)});
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
    double at = 0;
    double width = 0.9;
    double height = wall.height_m;
    keys::ReadSome(reader, {row::Required("at_m", "the distance from from_m to its middle",
                                          keys::Height("at_m", at)),
                            keys::Length("width_m", width), keys::Length("height_m", height)});
    const double half = width / 2;
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
    Circle circle;
    circle.radius_m = 1;
    keys::ReadSome(reader, {row::Text("name", circle.name), keys::Center(circle.center_m),
                            row::Required("radius_m", "a length in metres",
                                          keys::Length("radius_m", circle.radius_m)),
                            LookRow(circle)});
    scene_.circles.push_back(std::move(circle));
  }

  void ReadBall(TableReader& reader) {
    Ball ball;
    double bottom_m = 0;
    double show_for_s = ToSeconds(ball.show_for);
    keys::ReadSome(
        reader, {keys::Center(ball.center_m.head<2>()), keys::Length("radius_m", ball.radius_m),
                 keys::Height("bottom_m", bottom_m), keys::Colour("color", ball.color, findings_),
                 row::Bool("glows", ball.glows), row::Text("name", ball.name),
                 row::Bool("shown", ball.shown), keys::Height("show_within_m", ball.show_within_m),
                 row::Number("show_for_s", show_for_s, 0, kLongestShowS)});
    ball.center_m.z() = bottom_m + ball.radius_m;
    ball.show_for = FromSeconds(show_for_s);
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
    const auto take_arrow = [&](TableReader& table) {
      if (table.Has("arrow")) board.sign.ink = kArrowInk;
    };
    keys::ReadSome(
        reader, {row::Text("name", board.name), keys::Center(board.center_m),
                 keys::Angle("yaw_deg", board.yaw_rad), keys::Length("width_m", board.width_m),
                 keys::Length("height_m", board.height_m), keys::Height("bottom_m", board.bottom_m),
                 keys::Colour("color", board.color, findings_), take_arrow,
                 keys::Colour("ink", board.sign.ink, findings_),
                 row::Choice("shape", board.round, {{"square", false}, {"round", true}})});
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
      keys::PictureFile("picture", sign.content, folder_)(reader);
    }
    if (reader.Has("face")) {
      ++signs;
      sign.kind = Sign::Kind::kFace;
      sign.face = 0;
      row::Integer("face", sign.face, 0, kMostFaceOfThing)(reader);
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
    bool closed = false;
    keys::ReadSome(reader, {keys::Length("width_m", line.width_m),
                            keys::Colour("color", line.color, findings_),
                            row::Bool("watched", line.watched), row::Bool("closed", closed)});
    if (reader.Has("points_m") == reader.Has("center_m")) {
      findings_.Error(reader.at(), reader.path() +
                                       ": expected either points_m, or center_m with radius_m for "
                                       "an arc");
    }
    keys::Set(line.points_m, keys::ReadPoints(reader, "points_m"));
    if (const auto center = keys::ReadPoint(reader, "center_m")) {
      double radius = 1;
      double from = 0;
      double to = 2 * M_PI;
      keys::ReadSome(
          reader,
          {row::Required("radius_m", "a length in metres", keys::Length("radius_m", radius)),
           row::Degrees("from_deg", from, -720, 720), row::Degrees("to_deg", to, -720, 720)});
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
    GroundLabel label;
    keys::ReadSome(reader,
                   {row::Required("text", "what is written there", row::Text("text", label.text)),
                    keys::Center(label.middle_m)});
    scene_.labels.push_back(std::move(label));
  }

  void ReadPad(TableReader& reader) {
    Pad pad;
    pad.size_m = 0.8;
    keys::ReadSome(reader, {keys::Center(pad.center_m), keys::Length("size_m", pad.size_m)});
    scene_.pads.push_back(pad);
  }

 private:
  template <class Thing>
  Row LookRow(Thing& thing) {
    return [this, &thing](TableReader& reader) {
      keys::ReadSome(reader, {keys::Length("height_m", thing.height_m),
                              keys::Height("bottom_m", thing.bottom_m),
                              keys::Colour("color", thing.color, findings_)});
    };
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
