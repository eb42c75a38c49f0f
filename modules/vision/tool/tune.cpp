#include "musher/modules/vision/tool/tune.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <map>
#include <opencv2/core/utils/logger.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <utility>

#include "musher/base/files.hpp"
#include "musher/base/suggest.hpp"
#include "musher/modules/vision/course/course_parameters.hpp"
#include "musher/modules/vision/tool/hall_table.hpp"

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

// What [hall] says otherwise.
struct Proposal {
  std::map<std::string, HsvRange> colors;  // "yellow"
  std::map<std::string, Region> regions;   // "barrier"
  std::optional<WhiteBalance> balance;

  bool empty() const { return colors.empty() && regions.empty() && !balance; }
};

// The name and the place of a detector's colour; nothing: it has none.
std::pair<std::string, HsvRange*> ColorOf(CourseParameters& parameters) {
  if (auto* lines = std::get_if<LinesParameters>(&parameters)) return {"yellow", &lines->yellow};
  if (auto* marker = std::get_if<MarkerParameters>(&parameters)) return {"yellow", &marker->yellow};
  if (auto* arrow = std::get_if<ArrowParameters>(&parameters)) return {"green", &arrow->green};
  if (auto* barrier = std::get_if<BarrierParameters>(&parameters)) return {"red", &barrier->red};
  return {"", nullptr};
}

// The place of a detector's region; nothing: [hall] has none for its kind.
Region* RegionOf(CourseParameters& parameters) {
  if (auto* marker = std::get_if<MarkerParameters>(&parameters)) return &marker->region;
  if (auto* arrow = std::get_if<ArrowParameters>(&parameters)) return &arrow->region;
  if (auto* barrier = std::get_if<BarrierParameters>(&parameters)) return &barrier->region;
  return nullptr;
}

// Why a detector is not sure of a picture; empty: it is.
std::string DoubtOf(const CourseSight& sight) {
  return sight.lines ? sight.lines->doubt : sight.doubt;
}

struct Looked {
  Verdict verdict = Verdict::kMissed;
  std::string doubt;
};

// As a detector of the file does, but for what is proposed.
Looked Look(const Labelled& picture, const Proposal& proposal) {
  const CourseEntry& entry = *picture.entry;
  CourseParameters parameters = entry.parameters;
  const auto [name, range] = ColorOf(parameters);
  const auto color = proposal.colors.find(name);
  if (color != proposal.colors.end()) *range = color->second;
  const auto region = proposal.regions.find(RegionKeyOf(entry.kind));
  if (region != proposal.regions.end()) *RegionOf(parameters) = region->second;
  const auto balance = proposal.balance ? proposal.balance : entry.balance;
  const auto detector = FactoryOf(parameters, balance).make();
  if (!detector) return {};
  const CourseSight sight = detector.value()->Look(picture.bgr, 1, std::nullopt);
  return {Compare(picture, sight), DoubtOf(sight)};
}

Score ScoreOf(const std::vector<Labelled>& pictures, const Proposal& proposal) {
  Score score;
  for (const Labelled& picture : pictures) {
    const Verdict verdict = Look(picture, proposal).verdict;
    ++(verdict == Verdict::kRight    ? score.right
       : verdict == Verdict::kMissed ? score.missed
                                     : score.wrong);
  }
  return score;
}

// What is tried for a colour or a region: each value in its turn.
template <class Thing>
struct Move {
  void (*set)(Thing& thing, int value);
  int least = 0, most = 0, step = 1;
};

const std::vector<Move<HsvRange>>& ColorMoves() {
  static const std::vector<Move<HsvRange>> moves{
      // The hues as a whole first: no end of a range that is wrong as a whole does better alone.
      {[](HsvRange& range, int value) {
         constexpr int kHues = 180, kWide = 20;
         range.from[0] = value;
         range.to[0] = (value + kWide) % kHues;
       },
       0, 176, 4},
      {[](HsvRange& range, int value) { range.from[1] = value; }, 20, 220, 20},
      {[](HsvRange& range, int value) { range.from[2] = value; }, 10, 160, 15},
      {[](HsvRange& range, int value) { range.from[0] = value; }, 0, 176, 4},
      {[](HsvRange& range, int value) { range.to[0] = value; }, 3, 179, 4},
  };
  return moves;
}

// In hundredths.
const std::vector<Move<Region>>& RegionMoves() {
  static const std::vector<Move<Region>> moves{
      {[](Region& region, int value) { region.top = value / 100.0; }, 0, 80, 5},
      {[](Region& region, int value) { region.bottom = value / 100.0; }, 20, 100, 5},
      {[](Region& region, int value) { region.left = value / 100.0; }, 0, 80, 5},
      {[](Region& region, int value) { region.right = value / 100.0; }, 20, 100, 5},
  };
  return moves;
}

// A third of the circle of hues at most: no colour is wider.
bool IsPossible(const HsvRange& range) {
  constexpr int kHues = 180, kWidest = 60;
  const int wide = (range.to[0] - range.from[0] + kHues) % kHues;
  return wide <= kWidest && range.from[1] <= range.to[1] && range.from[2] <= range.to[2];
}

bool IsPossible(const Region& region) {
  constexpr double kLeast = 0.2;
  return region.bottom - region.top >= kLeast && region.right - region.left >= kLeast;
}

// Moves from the present thing to the one with the least penalty.
template <class Thing>
class Search {
 public:
  Search(std::function<int(const Thing&)> penalty, const Thing& present)
      : penalty_of_(std::move(penalty)), thing_(present), penalty_(penalty_of_(present)) {}

  // Move after move, until a round of them makes nothing better. Nothing: the present one stays.
  std::optional<Thing> Better(const std::vector<Move<Thing>>& moves) {
    constexpr int kRounds = 4;
    const int present = penalty_;
    int before = penalty_ + 1;
    for (int i = 0; i < kRounds && penalty_ > 0 && penalty_ < before; ++i) {
      before = penalty_;
      for (const Move<Thing>& move : moves) Try(move);
    }
    return penalty_ < present ? std::optional(thing_) : std::nullopt;
  }

 private:
  // Takes the middle of the values that do best, where they do better than the present one.
  void Try(const Move<Thing>& move) {
    std::vector<Thing> best;
    int least = penalty_;
    for (int value = move.least; value <= move.most; value += move.step) {
      Thing thing = thing_;
      move.set(thing, value);
      if (!IsPossible(thing)) continue;
      const int penalty = penalty_of_(thing);
      if (penalty > least || (penalty == least && best.empty())) continue;
      if (penalty < least) best.clear();
      least = penalty;
      best.push_back(thing);
    }
    if (best.empty()) return;
    thing_ = best[best.size() / 2];
    penalty_ = least;
  }

  const std::function<int(const Thing&)> penalty_of_;
  Thing thing_;
  int penalty_;
};

// The pictures of the detectors that have each key.
using ByKey = std::map<std::string, std::vector<Labelled>>;

ByKey Grouped(const std::vector<Labelled>& pictures, std::string (*key_of)(CourseKind)) {
  ByKey by_key;
  for (const Labelled& picture : pictures) {
    const std::string key = key_of(picture.entry->kind);
    if (!key.empty()) by_key[key].push_back(picture);
  }
  return by_key;
}

void TuneColors(const std::vector<Labelled>& pictures, Proposal& proposal) {
  for (const auto& [name, own] : Grouped(pictures, ColorKeyOf)) {
    const auto penalty = [&, key = name, &its = own](const HsvRange& range) {
      Proposal tried = proposal;
      tried.colors[key] = range;
      return ScoreOf(its, tried).penalty();
    };
    CourseParameters parameters = own.front().entry->parameters;
    const auto better = Search<HsvRange>(penalty, *ColorOf(parameters).second).Better(ColorMoves());
    if (better) proposal.colors[name] = *better;
  }
}

void TuneRegions(const std::vector<Labelled>& pictures, Proposal& proposal) {
  for (const auto& [name, own] : Grouped(pictures, RegionKeyOf)) {
    const auto penalty = [&, key = name, &its = own](const Region& region) {
      Proposal tried = proposal;
      tried.regions[key] = region;
      return ScoreOf(its, tried).penalty();
    };
    CourseParameters parameters = own.front().entry->parameters;
    const auto proposed = proposal.regions.find(name);
    const Region present =
        proposed == proposal.regions.end() ? *RegionOf(parameters) : proposed->second;
    const auto better = Search<Region>(penalty, present).Better(RegionMoves());
    if (better) proposal.regions[name] = *better;
  }
}

// Regions first: a colour that finds nothing at all does better than one that also finds what is
// elsewhere in the picture.
Proposal Tuned(const std::vector<Labelled>& pictures, Proposal proposal) {
  TuneRegions(pictures, proposal);
  TuneColors(pictures, proposal);
  if (!proposal.colors.empty()) TuneRegions(pictures, proposal);
  return proposal;
}

// By which the pictures' mean is grey, and by which their brightest part is white.
std::vector<WhiteBalance> BalancesOf(const std::vector<Labelled>& pictures) {
  constexpr int kLeastValue = 20, kMostValue = 250;
  cv::Scalar all, brightest;
  for (const Labelled& picture : pictures) {
    cv::Mat value;
    cv::cvtColor(picture.bgr, value, cv::COLOR_BGR2HSV);
    cv::extractChannel(value, value, 2);
    cv::Mat counts, bright;
    cv::inRange(value, kLeastValue, kMostValue, counts);
    all += cv::mean(picture.bgr, counts);
    double most = 0;
    cv::minMaxLoc(value, nullptr, &most, nullptr, nullptr, counts);
    constexpr double kNearly = 0.85;
    cv::inRange(value, kNearly * most, kMostValue, bright);
    brightest += cv::mean(picture.bgr, bright);
  }
  std::vector<WhiteBalance> balances;
  for (const cv::Scalar& mean : {all, brightest}) {
    if (mean[0] <= 0 || mean[1] <= 0 || mean[2] <= 0) continue;
    const auto gain = [](double factor) {
      return std::round(100 * std::clamp(factor, kLeastGain, kMostGain)) / 100;
    };
    balances.push_back({gain(mean[1] / mean[2]), 1, gain(mean[1] / mean[0])});
  }
  return balances;
}

// A white balance where regions and colours alone leave something missed or wrong.
Proposal BestOf(const std::vector<Labelled>& pictures) {
  Proposal best = Tuned(pictures, {});
  int least = ScoreOf(pictures, best).penalty();
  for (const WhiteBalance& balance : BalancesOf(pictures)) {
    if (least == 0) break;
    Proposal other = Tuned(pictures, {.colors = {}, .regions = {}, .balance = balance});
    const int penalty = ScoreOf(pictures, other).penalty();
    if (penalty >= least) continue;
    least = penalty;
    best = std::move(other);
  }
  return best;
}

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

void PrintScores(const std::vector<Labelled>& pictures, const Proposal& proposal,
                 std::ostream& out) {
  std::map<std::string, std::vector<Labelled>> by_detector;
  for (const Labelled& picture : pictures) by_detector[picture.entry->name].push_back(picture);
  for (const auto& [name, own] : by_detector) {
    const Score score = ScoreOf(own, proposal);
    out << fmt::format("  {:<26}{:>4} right {:>4} missed {:>4} wrong\n", name, score.right,
                       score.missed, score.wrong);
    for (const Labelled& picture : own) {
      const Looked looked = Look(picture, proposal);
      if (looked.verdict == Verdict::kRight) continue;
      out << fmt::format("    {}: {}{}\n", looked.verdict == Verdict::kWrong ? "wrong" : "missed",
                         std::filesystem::path(picture.file).filename().string(),
                         looked.doubt.empty() ? "" : ": " + looked.doubt);
    }
  }
}

std::vector<HallKey> KeysOf(const Proposal& proposal) {
  std::vector<HallKey> keys;
  for (const auto& [name, range] : proposal.colors) {
    keys.push_back(
        {name, fmt::format("{{ from = [{}, {}, {}], to = [{}, {}, {}] }}", range.from[0],
                           range.from[1], range.from[2], range.to[0], range.to[1], range.to[2])});
  }
  if (const auto& balance = proposal.balance) {
    keys.push_back({"white_balance", fmt::format("[{:.2f}, {:.2f}, {:.2f}]", balance->red,
                                                 balance->green, balance->blue)});
  }
  for (const auto& [name, region] : proposal.regions) {
    keys.push_back(
        {"regions." + name,
         fmt::format("{{ top = {:.2f}, bottom = {:.2f}, left = {:.2f}, right = {:.2f} }}",
                     region.top, region.bottom, region.left, region.right)});
  }
  return keys;
}

// What is said last: which detectors do not take it from [hall].
void PrintOwn(const VisionConfig& config, const Proposal& proposal, std::ostream& out) {
  for (const CourseEntry& entry : config.detectors) {
    const std::string color = ColorKeyOf(entry.kind), region = RegionKeyOf(entry.kind);
    if (entry.own_color && proposal.colors.contains(color)) {
      out << fmt::format("remove parameters.{} of {}: it wins over [hall]\n", color, entry.name);
    }
    if (entry.own_region && proposal.regions.contains(region)) {
      out << fmt::format("remove parameters.region of {}: it wins over [hall]\n", entry.name);
    }
  }
}

// Changes [hall] of the file, at once or not at all, and says so line by line.
Result<> Write(const std::string& file, const std::vector<HallKey>& keys, std::ostream& out) {
  const auto change = WithHallKeys(ReadFile(file), keys);
  if (!change) return Error{kCodeFailed, file + ": " + change.error().message};
  if (!ReadVisionText(change.value().text, file).config) {
    return Error{kCodeFailed, file +
                                  " cannot be changed: its [hall] has such a key in another form; "
                                  "copy the table by hand"};
  }
  std::error_code error;
  const auto status = std::filesystem::status(file, error);
  ReplaceOptions options;
  options.draft = ".musher-tune";
  if (!error) options.mode = static_cast<mode_t>(status.permissions());
  const auto real = std::filesystem::canonical(file, error);  // not a link to it
  if (error) return Error{kCodeFailed, file + ": " + error.message()};
  if (Result<> replaced = ReplaceFile(real, change.value().text, options); !replaced) {
    return replaced;
  }
  out << fmt::format("\nwritten to [hall] of {}:\n", file);
  for (const std::string& line : change.value().before) out << "  - " << line << "\n";
  for (const HallKey& key : keys) out << "  + " << key.key << " = " << key.value << "\n";
  return Ok();
}

}  // namespace

Result<> Tune(const VisionConfig& config, const TuneOptions& options, std::ostream& out) {
  // Errors of a file are reported here, not by OpenCV.
  cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
  const auto pictures = ReadPictures(config, options.folder);
  if (!pictures) return pictures.error();
  out << fmt::format("{} pictures, with {} as it is:\n", pictures.value().size(), options.file);
  PrintScores(pictures.value(), {}, out);
  const Proposal proposal = BestOf(pictures.value());
  if (proposal.empty()) {
    out << "no other colours, regions or white balance do better\n";
    return Ok();
  }
  out << "with this table:\n";
  PrintScores(pictures.value(), proposal, out);
  const std::vector<HallKey> keys = KeysOf(proposal);
  if (options.write) {
    if (Result<> written = Write(options.file, keys, out); !written) return written;
  } else {
    out << "\n[hall]\n";
    for (const HallKey& key : keys) out << key.key << " = " << key.value << "\n";
    out << "\nnothing is written; --write changes [hall] of " << options.file << " so\n";
  }
  PrintOwn(config, proposal, out);
  return Ok();
}

}  // namespace musher::vision::tool
