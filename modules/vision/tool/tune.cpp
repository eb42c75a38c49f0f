#include "musher/modules/vision/tool/tune.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <map>
#include <opencv2/core/utils/logger.hpp>
#include <opencv2/imgcodecs.hpp>
#include <utility>

#include "musher/base/files.hpp"
#include "musher/base/suggest.hpp"
#include "musher/modules/vision/course/course_parameters.hpp"

namespace musher::vision::tool {
namespace {

constexpr std::string_view kNothing = "none", kAnything = "yes";

struct Labelled {
  std::string file;
  const CourseEntry* entry = nullptr;
  std::string label;
  cv::Mat bgr;
};

enum class Verdict { kRight, kMissed, kWrong };

// What a detector says of a picture; nothing: it sees nothing, or is not sure.
std::optional<std::string> SaidBy(const CourseSight& sight) {
  if (sight.lines) {
    if (sight.lines->contours == 0 || !sight.lines->doubt.empty()) return std::nullopt;
    return sight.lines->ycy;
  }
  if (!sight.sighting || !sight.sighting->seen) return std::nullopt;
  return sight.sighting->text;
}

Verdict Compare(const Labelled& picture, const CourseSight& sight) {
  const auto said = SaidBy(sight);
  if (picture.label == kNothing) return said ? Verdict::kWrong : Verdict::kRight;
  if (!said) return Verdict::kMissed;
  return picture.label == kAnything || picture.label == *said ? Verdict::kRight : Verdict::kWrong;
}

struct Score {
  int right = 0, missed = 0, wrong = 0;
  int penalty() const { return missed + kMissesOfAWrong * wrong; }
};

using Colors = std::map<std::string, HsvRange>;  // "yellow"

// The name and the place of a detector's colour; nothing: it has none.
std::pair<std::string, HsvRange*> ColorOf(CourseParameters& parameters) {
  if (auto* lines = std::get_if<LinesParameters>(&parameters)) return {"yellow", &lines->yellow};
  if (auto* marker = std::get_if<MarkerParameters>(&parameters)) return {"yellow", &marker->yellow};
  if (auto* arrow = std::get_if<ArrowParameters>(&parameters)) return {"green", &arrow->green};
  if (auto* barrier = std::get_if<BarrierParameters>(&parameters)) return {"red", &barrier->red};
  return {"", nullptr};
}

// With that colour, where it has one; as a detector of the file does without.
Verdict Look(const Labelled& picture, const Colors& colors) {
  CourseParameters parameters = picture.entry->parameters;
  const auto [name, range] = ColorOf(parameters);
  if (const auto color = colors.find(name); color != colors.end()) *range = color->second;
  const auto detector = FactoryOf(parameters).make();
  if (!detector) return Verdict::kMissed;
  return Compare(picture, detector.value()->Look(picture.bgr, 1, std::nullopt));
}

Score ScoreOf(const std::vector<Labelled>& pictures, const Colors& colors) {
  Score score;
  for (const Labelled& picture : pictures) {
    const Verdict verdict = Look(picture, colors);
    ++(verdict == Verdict::kRight    ? score.right
       : verdict == Verdict::kMissed ? score.missed
                                     : score.wrong);
  }
  return score;
}

// What is tried for a range: each value of `values` in its turn.
struct Move {
  void (*set)(HsvRange& range, int value);
  int least = 0, most = 0, step = 1;
};
const std::array kMoves{
    // The hues as a whole first: no end of a range that is wrong as a whole does better alone.
    Move{[](HsvRange& range, int value) {
           constexpr int kHues = 180, kWide = 20;
           range.from[0] = value;
           range.to[0] = (value + kWide) % kHues;
         },
         0, 176, 4},
    Move{[](HsvRange& range, int value) { range.from[1] = value; }, 20, 220, 20},
    Move{[](HsvRange& range, int value) { range.from[2] = value; }, 10, 160, 15},
    Move{[](HsvRange& range, int value) { range.from[0] = value; }, 0, 176, 4},
    Move{[](HsvRange& range, int value) { range.to[0] = value; }, 3, 179, 4},
};

class ColorSearch {
 public:
  ColorSearch(const std::vector<Labelled>& pictures, std::string name, HsvRange range)
      : pictures_(pictures), name_(std::move(name)), range_(range), penalty_(With(range)) {}

  // Move after move, until a round of them makes nothing better.
  HsvRange Best() {
    constexpr int kRounds = 4;
    int before = penalty_ + 1;
    for (int i = 0; i < kRounds && penalty_ > 0 && penalty_ < before; ++i) {
      before = penalty_;
      for (const Move& move : kMoves) Try(move);
    }
    return range_;
  }

 private:
  int With(const HsvRange& range) const { return ScoreOf(pictures_, {{name_, range}}).penalty(); }

  // A third of the circle of hues at most: no colour is wider.
  static bool IsPossible(const HsvRange& range) {
    constexpr int kHues = 180, kWidest = 60;
    const int wide = (range.to[0] - range.from[0] + kHues) % kHues;
    return wide <= kWidest && range.from[1] <= range.to[1] && range.from[2] <= range.to[2];
  }

  // Takes the middle of the values that do best, where they do better than the present one.
  void Try(const Move& move) {
    std::vector<HsvRange> best;
    int least = penalty_;
    for (int value = move.least; value <= move.most; value += move.step) {
      HsvRange range = range_;
      move.set(range, value);
      if (!IsPossible(range)) continue;
      const int penalty = With(range);
      if (penalty > least || (penalty == least && best.empty())) continue;
      if (penalty < least) best.clear();
      least = penalty;
      best.push_back(range);
    }
    if (best.empty()) return;
    range_ = best[best.size() / 2];
    penalty_ = least;
  }

  const std::vector<Labelled>& pictures_;
  const std::string name_;
  HsvRange range_;
  int penalty_;
};

std::vector<std::string> LabelsOf(CourseKind kind) {
  switch (kind) {
    case CourseKind::kLines:
      return {"left", "right", "center", "yes", "none"};
    case CourseKind::kArrow:
      return {"left", "right", "yes", "none"};
    default:
      return {"yes", "none"};
  }
}

// The detector and the label of "front_lane-left-1.png".
Result<Labelled> ReadPicture(const VisionConfig& config, const std::filesystem::path& path) {
  constexpr std::string_view kExample =
      "as in front_lane-left-1.png: a detector, what it has to say, and more";
  const std::string name = path.stem();
  const std::size_t dash = name.find('-');
  if (dash == std::string::npos) {
    return Error{kCodeFailed,
                 fmt::format("{} has no label in its name, {}", path.string(), kExample)};
  }
  Labelled picture;
  picture.file = path;
  const std::string detector = name.substr(0, dash);
  picture.label = name.substr(dash + 1, name.find('-', dash + 1) - dash - 1);
  std::vector<std::string> names;
  for (const CourseEntry& entry : config.detectors) {
    CourseParameters parameters = entry.parameters;
    if (ColorOf(parameters).second == nullptr) continue;
    names.push_back(entry.name);
    if (entry.name == detector) picture.entry = &entry;
  }
  if (picture.entry == nullptr) {
    return Error{kCodeFailed, fmt::format("{}: {}", path.string(),
                                          NoSuch("detector with a colour", detector, names))};
  }
  const auto labels = LabelsOf(picture.entry->kind);
  if (std::ranges::find(labels, picture.label) == labels.end()) {
    return Error{kCodeFailed,
                 fmt::format("{}: {}", path.string(), NoSuch("label", picture.label, labels))};
  }
  picture.bgr = cv::imread(path, cv::IMREAD_COLOR);
  if (picture.bgr.empty()) {
    return Error{kCodeFailed, path.string() + " is no picture that can be read"};
  }
  return picture;
}

Result<std::vector<Labelled>> ReadPictures(const VisionConfig& config, const std::string& folder) {
  std::error_code error;
  std::vector<std::filesystem::path> paths = EntriesOf(folder, error);
  std::erase_if(paths, [](const std::filesystem::path& path) {
    const std::string extension = path.extension();
    return extension != ".png" && extension != ".jpg" && extension != ".bmp";
  });
  if (error) return Error{kCodeFailed, folder + ": " + error.message()};
  if (paths.empty())
    return Error{kCodeFailed, folder + " has no picture: expected .png, .jpg or .bmp"};
  std::ranges::sort(paths);
  std::vector<Labelled> pictures;
  for (const auto& path : paths) {
    auto picture = ReadPicture(config, path);
    if (!picture) return picture.error();
    pictures.push_back(std::move(picture).value());
  }
  return pictures;
}

void PrintScores(const std::vector<Labelled>& pictures, const Colors& colors, std::ostream& out) {
  std::map<std::string, std::vector<Labelled>> by_detector;
  for (const Labelled& picture : pictures) by_detector[picture.entry->name].push_back(picture);
  for (const auto& [name, own] : by_detector) {
    const Score score = ScoreOf(own, colors);
    out << fmt::format("  {:<26}{:>4} right {:>4} missed {:>4} wrong\n", name, score.right,
                       score.missed, score.wrong);
    for (const Labelled& picture : own) {
      const Verdict verdict = Look(picture, colors);
      if (verdict == Verdict::kRight) continue;
      out << fmt::format("    {}: {}\n", verdict == Verdict::kWrong ? "wrong" : "missed",
                         std::filesystem::path(picture.file).filename().string());
    }
  }
}

std::string TomlOf(const Colors& colors) {
  std::string table = "[hall]\n";
  for (const auto& [name, range] : colors) {
    table += fmt::format("{} = {{ from = [{}, {}, {}], to = [{}, {}, {}] }}\n", name, range.from[0],
                         range.from[1], range.from[2], range.to[0], range.to[1], range.to[2]);
  }
  return table;
}

}  // namespace

Result<> Tune(const VisionConfig& config, const TuneOptions& options, std::ostream& out) {
  // Errors of a file are reported here, not by OpenCV.
  cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
  const auto pictures = ReadPictures(config, options.folder);
  if (!pictures) return pictures.error();
  out << fmt::format("{} pictures, with the colours of {}:\n", pictures.value().size(),
                     options.file);
  PrintScores(pictures.value(), {}, out);

  std::map<std::string, std::vector<Labelled>> by_color;
  std::map<std::string, HsvRange> present;
  for (const Labelled& picture : pictures.value()) {
    CourseParameters parameters = picture.entry->parameters;
    const auto [name, range] = ColorOf(parameters);
    by_color[name].push_back(picture);
    present.emplace(name, *range);
  }
  Colors proposed;
  for (const auto& [name, own] : by_color) {
    if (ScoreOf(own, {}).penalty() == 0) continue;
    const HsvRange best = ColorSearch(own, name, present[name]).Best();
    if (ScoreOf(own, {{name, best}}).penalty() < ScoreOf(own, {}).penalty()) proposed[name] = best;
  }
  if (proposed.empty()) {
    out << "no other colours do better\n";
    return Ok();
  }
  out << "with these colours:\n";
  PrintScores(pictures.value(), proposed, out);
  out << "\n" << TomlOf(proposed);
  for (const CourseEntry& entry : config.detectors) {
    const std::string key = ColorKeyOf(entry.kind);
    if (!entry.own_color || !proposed.contains(key)) continue;
    out << fmt::format("remove parameters.{} of {}: it wins over [hall]\n", key, entry.name);
  }
  return Ok();
}

}  // namespace musher::vision::tool
