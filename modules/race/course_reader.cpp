#include "musher/modules/race/course_reader.hpp"

#include <algorithm>
#include <filesystem>
#include <utility>

#include "musher/base/toml/file.hpp"
#include "musher/base/toml/names.hpp"
#include "musher/modules/race/course_parts.hpp"

namespace musher::race {
namespace {

using namespace parts;  // NOLINT(google-build-using-namespace): this file is one of its parts

class CourseReader {
 public:
  CourseReader(const Table& table, const std::string& path, Findings& findings)
      : folder_(config_toml::FolderOf(path)),
        root_(table, {1, 1}, "", findings),
        findings_(findings),
        reading_{{}, findings} {}

  Course Read() {
    Collect();
    Each("detector", course().detectors, [this](auto& t, auto& d) { ReadDetector(t, d); });
    Each("movement", course().movements, ReadMovement);
    Each("result", course().results, ReadResult);
    ReadTop();
    In("checks", [this](TableReader& t) { ReadCheckRules(t); });
    In("robot", [this](TableReader& t) { ReadRobot(t, folder_, course().robot); });
    In("body", [this](TableReader& t) {
      Take(t, "silent_ms", course().body.silent, 0);
      Take(t, "refused_ms", course().body.refused);
    });
    Each("check", course().checks, [this](auto& t, auto& c) { ReadCheck(t, c); });
    Each("keep", course().keeps, [this](auto& t, auto& k) { ReadKeep(t, k); });
    Each("wait", course().waits, [this](auto& t, auto& w) { ReadWait(t, w); });
    Each("until", course().untils, [this](auto& t, auto& u) { ReadUntil(t, u); });
    Each("walk", course().walks, [this](auto& t, auto& w) { ReadWalk(t, w); });
    Each("speech", course().speeches, [this](auto& t, auto& s) { ReadSpeech(t, s, reading_); });
    In("light", [this](TableReader& t) { ReadLight(t); });
    Each("command", course().commands, [this](auto& t, auto& c) { ReadCommand(t, c); });
    Index state = 0;
    Each("state", course().states, [&](TableReader& t, StateRule& s) {
      ReadState(t, s, reading_.places[state++], reading_);
    });
    CheckCommands(root_, reading_);
    root_.RefuseOthers();
    CheckStates(reading_);
    return std::move(course());
  }

 private:
  Course& course() { return reading_.course; }

  // The names of all things, so that a table may refer to one below it.
  void Collect() {
    const auto names = [this](const char* section, auto& things) {
      const Table* all = root_.SubTable(section);
      if (all == nullptr) return;
      for (const config_toml::Member& member : *all) {
        if (member.value.As<Table>() == nullptr) {
          findings_.Error(member.at, std::string(section) + "." + member.key +
                                         ": expected a table, as in [" + section + "." +
                                         member.key + "]");
          continue;
        }
        if (!config_toml::IsName(member.key)) {
          findings_.Error(member.at, std::string(section) + ": expected " +
                                         std::string(config_toml::kNameRule) + ", found " +
                                         config_toml::Quote(member.key));
        }
        things.emplace_back();
        things.back().name = member.key;
      }
    };
    names("detector", course().detectors);
    names("movement", course().movements);
    names("result", course().results);
    names("check", course().checks);
    names("keep", course().keeps);
    names("wait", course().waits);
    names("until", course().untils);
    names("walk", course().walks);
    names("speech", course().speeches);
    names("command", course().commands);
    names("state", course().states);
    reading_.places.resize(course().states.size());
    if (const auto counters = root_.Strings("counters", {.may_be_empty = true})) {
      for (const auto& counter : *counters) course().counters.push_back(counter.text);
    }
    if (!course().states.empty()) return;
    reading_.has_ends = false;
    root_.Require("state", "the states, tables [state.NAME]");
  }

  // `read` gets each table [section.NAME], in the order of the names.
  template <class Thing, class Read>
  void Each(const char* section, std::vector<Thing>& things, Read&& read) {
    const Table* all = root_.SubTable(section);
    if (all == nullptr) return;
    Index next = 0;
    for (const config_toml::Member& member : *all) {
      const Table* table = member.value.As<Table>();
      if (table == nullptr) continue;
      TableReader reader(*table, member.at, std::string(section) + "." + member.key, findings_);
      read(reader, things[next++]);
      reader.RefuseOthers();
    }
  }
  template <class Read>
  void In(const char* section, Read&& read) {
    const Table* table = root_.SubTable(section);
    if (table == nullptr) return;
    TableReader reader(*table, root_.At(section), section, findings_);
    read(reader);
    reader.RefuseOthers();
  }

  template <class Thing>
  void TakeReference(TableReader& table, const char* key, const char* kind,
                     const std::vector<Thing>& things, Index& index) {
    table.Require(key, "the name of a " + std::string(kind));
    index = Reference(table, key, kind, things).value_or(index);
  }
  void TakeTopic(TableReader& table, const char* key, std::string& topic) {
    table.Require(key, "a topic");
    const auto word = table.String(key);
    if (!word) return;
    topic = word->text;
    if (!config_toml::IsTopic(topic)) {
      table.Fault(
          word->at, key,
          "expected a topic, as in \"/qr_detector/sighting\", found " + config_toml::Quote(topic));
    }
  }

  // The state of a key of the file, another one than those of the keys before it.
  void TakeEnd(const char* key, Index& index, const std::vector<const char*>& before) {
    root_.Require(key, "the name of a state");
    const auto state = Reference(root_, key, "state", course().states);
    if (!state) reading_.has_ends = false;
    index = state.value_or(index);
    for (const char* other : before) {
      const auto same = root_.String(other);
      if (!state || !same || same->text != course().states[*state].name) continue;
      reading_.has_ends = false;
      root_.Fault(root_.At(key), key,
                  same->text + " is also the state of \"" + other + "\"; expected another one");
    }
  }

  void ReadTop() {
    TakeEnd("start", course().start, {});
    TakeEnd("end", course().end, {"start"});
    TakeEnd("error", course().error, {"start", "end"});
    root_.Require("stand", "the name of a movement");
    if (const auto stand = Reference(root_, "stand", "movement", course().movements)) {
      course().stand = *stand;
      if (course().movements[*stand].walks) {
        root_.Fault(root_.At("stand"), "stand", "expected one motion, found a walk");
      }
    }
    Take(root_, "step_ms", course().step, 50);
    course().language =
        root_.Choice<Language>("language", {{"zh", Language::kChinese}, {"en", Language::kEnglish}})
            .value_or(course().language);
  }

  void ReadDetector(TableReader& table, Detector& detector) {
    using Kind = Detector::Kind;
    TakeTopic(table, "topic", detector.topic);
    table.Require("type", "\"sighting\" or \"lines\"");
    detector.kind =
        table.Choice<Kind>("type", {{"sighting", Kind::kSighting}, {"lines", Kind::kLines}})
            .value_or(detector.kind);
  }

  void ReadCheckRules(TableReader& table) {
    CheckRules& rules = course().check;
    rules.max_corrections =
        static_cast<int>(table.Integer("max_corrections", 0, 100).value_or(rules.max_corrections));
    Take(table, "settle_ms", rules.settle, 0);
    Take(table, "picture_ms", rules.picture);
    Take(table, "open_ms", rules.open, 0);
    Take(table, "silent_ms", rules.silent);
  }

  void ReadCorrections(TableReader& table, bool by_dy, Corrections& corrections) {
    const auto take = [&](const char* key, LineWord word) {
      corrections.at(static_cast<std::size_t>(word)) = StretchAt(table, key, reading_);
    };
    take(by_dy ? "front" : "left", by_dy ? LineWord::kFront : LineWord::kLeft);
    take(by_dy ? "back" : "right", by_dy ? LineWord::kBack : LineWord::kRight);
  }

  void TakeDetector(TableReader& table, Detector::Kind kind, Index& index) {
    table.Require("detector", "the name of a detector");
    const auto found = Reference(table, "detector", "detector", course().detectors);
    if (!found) return;
    index = *found;
    if (course().detectors[index].kind == kind) return;
    table.Fault(table.At("detector"), "detector",
                course().detectors[index].name + " is not a detector of type \"" +
                    (kind == Detector::Kind::kLines ? "lines" : "sighting") + "\"");
  }

  void ReadCheck(TableReader& table, Check& check) {
    using By = Check::By;
    table.Require("word", "\"ycy\", \"dy\" or \"box\"");
    check.by = table.Choice<By>("word", {{"ycy", By::kYcy}, {"dy", By::kDy}, {"box", By::kBox}})
                   .value_or(By::kYcy);
    const bool of_box = check.by == By::kBox;
    TakeDetector(table, of_box ? Detector::Kind::kSighting : Detector::Kind::kLines,
                 check.detector);
    if (of_box) check.threshold = table.Number("threshold", 0, 0.5).value_or(check.threshold);
    if (const auto most = table.Integer("max_corrections", 0, 1000)) {
      check.max_corrections = static_cast<int>(*most);
    }
    ReadCorrections(table, check.by == By::kDy, check.usual);
    check.after_turn = check.usual;
    const Table* turn = table.SubTable("after_turn");
    if (turn == nullptr) return;
    TableReader reader(*turn, table.At("after_turn"), table.path() + ".after_turn", findings_);
    ReadCorrections(reader, check.by == By::kDy, check.after_turn);
    reader.RefuseOthers();
  }

  void ReadWait(TableReader& table, Wait& wait) {
    if (table.Has("time_ms")) return Take(table, "time_ms", wait.limit);
    wait.detector = 0;
    TakeDetector(table, Detector::Kind::kSighting, *wait.detector);
    TakeReference(table, "result", "result", course().results, wait.result);
    table.Require("limit_ms", "milliseconds, or time_ms for a plain wait");
    Take(table, "limit_ms", wait.limit);
    wait.retries = static_cast<int>(table.Integer("retries", 0, 100).value_or(0));
    if (const auto retry = StretchAt(table, "retry", reading_)) wait.retry = *retry;
    if (wait.retries > 0) table.Require("retry", "a walk, as in { move = \"forward\", count = 2 }");
    wait.adds = CounterAt(table, "adds");
    ReadOtherwise(table, wait.otherwise, reading_);
    const bool by_default = wait.otherwise.kind == Otherwise::Kind::kDefault;
    if (by_default && wait.result < course().results.size() &&
        !course().results[wait.result].by_default) {
      table.Fault(table.At("otherwise"), "otherwise",
                  "the result " + course().results[wait.result].name + " has no default");
    }
  }

  std::optional<Index> CounterAt(TableReader& table, const char* key) {
    const auto word = table.String(key);
    return word ? Refer(table, key, "counter", *word, course().counters) : std::nullopt;
  }

  void ReadKeep(TableReader& table, Keep& keep) {
    TakeDetector(table, Detector::Kind::kLines, keep.detector);
    keep.yaw_rad_s = table.Number("yaw_rad_s", 0, 20).value_or(keep.yaw_rad_s);
    keep.most_rad_s = table.Number("most_rad_s", 0, 2).value_or(keep.most_rad_s);
    Take(table, "fresh_ms", keep.fresh);
  }

  void RefuseDefault(TableReader& table, Otherwise& otherwise) {
    ReadOtherwise(table, otherwise, reading_);
    if (otherwise.kind != Otherwise::Kind::kDefault) return;
    table.Fault(table.At("otherwise"), "otherwise", "expected \"continue\" or a state");
  }

  void ReadUntil(TableReader& table, Until& until) {
    TakeDetector(table, Detector::Kind::kSighting, until.detector);
    table.Require("phase", "the phase of a sighting, as in \"top\"");
    if (const auto phase = table.String("phase")) until.phase = phase->text;
    table.Require("most", "the most steps");
    if (const auto most = ReadStretch(table, reading_, "most")) until.most = *most;
    RefuseDefault(table, until.otherwise);
  }

  void ReadWalk(TableReader& table, LaneWalk& walk) {
    TakeTopic(table, "command", walk.command);
    TakeTopic(table, "status", walk.status);
    if (const auto end = table.String("end")) walk.end = end->text;
    Take(table, "limit_ms", walk.limit);
    Take(table, "silent_ms", walk.silent);
    RefuseDefault(table, walk.otherwise);
  }

  void ReadLight(TableReader& table) {
    LightRule& light = course().light.emplace();
    TakeDetector(table, Detector::Kind::kSighting, light.detector);
    light.within_m = table.Number("stop_within_m", 0.01, 100).value_or(light.within_m);
    table.Require("state", "the name of a state");
    const auto state = Reference(table, "state", "state", course().states);
    if (!state) reading_.has_leads = false;
    light.state = state.value_or(light.state);
    Take(table, "clear_ms", light.clear);
    Take(table, "again_ms", light.again);
    Take(table, "blind_ms", light.blind);
  }

  void ReadCommand(TableReader& table, CourseCommand& command) {
    table.Require("accepted", "the states in which it is accepted");
    command.accepted = States(table, "accepted", reading_);
    command.leaves = States(table, "leaves", reading_);
    command.counter = CounterAt(table, "set");
    if (table.Has("set")) table.Require("to", "the value of the counter");
    command.value = static_cast<int>(table.Integer("to", 0, kMostSteps).value_or(0));
  }

  const std::filesystem::path folder_;
  TableReader root_;
  Findings& findings_;
  Reading reading_;
};

}  // namespace

CourseReading ReadCourseText(std::string_view text, const std::string& path) {
  return config_toml::ReadTextWith<CourseReading>(
      text, path, [&](const Table& root, Findings& findings) {
        return CourseReader(root, path, findings).Read();
      });
}

CourseReading ReadCourseFile(const std::string& path) {
  return config_toml::ReadFileWith(path, ReadCourseText);
}

}  // namespace musher::race
