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
    Each("detector", course().detectors, [](TableReader&, auto& d) { return DetectorRows(d); });
    Each("movement", course().movements, MovementRows);
    Each("result", course().results, [](TableReader&, auto& r) { return ResultRows(r); });
    for (const Row& row : TopRows()) row(root_);
    Each("check", course().checks, [&](TableReader&, auto& c) { return CheckRows(c); });
    Each("keep", course().keeps, [&](TableReader&, auto& k) { return KeepRows(k); });
    Each("wait", course().waits, [&](TableReader& t, auto& w) { return WaitRows(t, w); });
    Each("until", course().untils, [&](TableReader&, auto& u) { return UntilRows(u); });
    Each("walk", course().walks, [&](TableReader&, auto& w) { return WalkRows(w); });
    Each("speech", course().speeches,
         [&](TableReader&, auto& s) { return SpeechRows(s, reading_); });
    ReadLight();
    Each("command", course().commands, [&](TableReader&, auto& c) { return CommandRows(c); });
    Index state = 0;
    Each("state", course().states, [&](TableReader&, StateRule& rule) {
      StatePlace& place = reading_.places[state++];
      return Rows{[&](TableReader& t) { ReadState(t, rule, place, reading_); }};
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

  // Reads each table [section.NAME], in the order of the names, by the rows that `rows` has for it.
  template <class Thing, class RowsOf>
  void Each(const char* section, std::vector<Thing>& things, RowsOf&& rows) {
    const Table* all = root_.SubTable(section);
    if (all == nullptr) return;
    Index next = 0;
    for (const config_toml::Member& member : *all) {
      const Table* table = member.value.As<Table>();
      if (table == nullptr) continue;
      TableReader reader(*table, member.at, std::string(section) + "." + member.key, findings_);
      ReadRows(reader, rows(reader, things[next++]));
    }
  }

  static Row TopicRow(std::string_view key, std::string& topic) {
    return row::Required(key, "a topic", row::Topic(key, topic, "/qr_detector/sighting"));
  }

  // The state of a key of the file, another one than those of the keys before it.
  Row EndRow(const char* key, Index& index, const std::vector<const char*>& before) {
    return [this, key, &index, before](TableReader& root) {
      root.Require(key, "the name of a state");
      const auto state = Reference(root, key, "state", course().states);
      if (!state) reading_.has_ends = false;
      index = state.value_or(index);
      for (const char* other : before) {
        const auto same = root.String(other);
        if (!state || !same || same->text != course().states[*state].name) continue;
        reading_.has_ends = false;
        root.Fault(root.At(key), key,
                   same->text + " is also the state of \"" + other + "\"; expected another one");
      }
    };
  }

  void ReadStand(TableReader& root) {
    root.Require("stand", "the name of a movement");
    const auto stand = Reference(root, "stand", "movement", course().movements);
    if (!stand) return;
    course().stand = *stand;
    if (!course().movements[*stand].walks) return;
    root.Fault(root.At("stand"), "stand", "expected one motion, found a walk");
  }

  Rows TopRows() {
    return {
        EndRow("start", course().start, {}),
        EndRow("end", course().end, {"start"}),
        EndRow("error", course().error, {"start", "end"}),
        [this](TableReader& root) { ReadStand(root); },
        row::Time("step_ms", course().step, 50),
        row::Choice("language", course().language,
                    {{"zh", Language::kChinese}, {"en", Language::kEnglish}}),
        row::Sub("checks", CheckRuleRows()),
        row::Sub("robot", RobotRows(folder_, course().robot)),
        row::Sub("hall", HallRows(course().hall)),
        row::Sub("odometry", OdometryRows(course().odometry)),
        row::Sub("body", {row::Time("silent_ms", course().body.silent, 0),
                          row::Time("refused_ms", course().body.refused)}),
    };
  }

  static Rows DetectorRows(Detector& detector) {
    using Kind = Detector::Kind;
    return {TopicRow("topic", detector.topic),
            row::Required("type", "\"sighting\", \"lines\" or \"text\"",
                          row::Choice("type", detector.kind,
                                      {{"sighting", Kind::kSighting},
                                       {"lines", Kind::kLines},
                                       {"text", Kind::kText}}))};
  }

  Rows CheckRuleRows() {
    CheckRules& rules = course().check;
    return {
        row::Integer("max_corrections", rules.max_corrections, 0, 100),
        row::Time("settle_ms", rules.settle, 0),
        row::Time("picture_ms", rules.picture),
        row::Time("open_ms", rules.open, 0),
        row::Time("silent_ms", rules.silent),
        row::Integer("most_given_up", rules.most_given_up, 0, 1000),
        row::Integer("agreeing_pictures", rules.agreeing, 1, 100),
        row::Number("most_off_m", rules.most_off_m, 0, 10),
        row::Number("most_off_share", rules.most_off_share, 0, 1),
        [this](TableReader& table) { ReadStepBack(table); },
    };
  }

  void ReadStepBack(TableReader& table) {
    auto reader = table.Sub("step_back");
    if (!reader) return;
    const char* const walk = "a walk, as in { move = \"backward\", count = 3 }";
    reader->Require("away", walk);
    reader->Require("back", walk);
    const auto away = StretchAt(*reader, "away", reading_);
    const auto back = StretchAt(*reader, "back", reading_);
    reader->RefuseOthers();
    if (away && back) course().check.step_back = StepBack{*away, *back};
  }

  // By the corrections of both it is known whether they contradict each other.
  void ReadAgreement(TableReader& table, Check& check) {
    const auto other = Reference(table, "agrees_with", "check", course().checks);
    if (!other) return;
    check.agrees_with = other;
    const char* const key = "agrees_with";
    if (&course().checks[*other] == &check) {
      table.Fault(table.At(key), key, "expected another check, of another camera");
    } else if (check.by == Check::By::kBox) {
      table.Fault(table.At(key), key, "expected a check of lines, found one of a box");
    }
  }

  // `or_text`: a detector of words will do, too.
  Row DetectorRow(Detector::Kind kind, Index& index, bool or_text = false) {
    return [this, kind, &index, or_text](TableReader& table) {
      table.Require("detector", "the name of a detector");
      const auto found = Reference(table, "detector", "detector", course().detectors);
      if (!found) return;
      index = *found;
      const Detector::Kind is = course().detectors[index].kind;
      if (is == kind || (or_text && is == Detector::Kind::kText)) return;
      table.Fault(table.At("detector"), "detector",
                  course().detectors[index].name + " is not a detector of type \"" +
                      (kind == Detector::Kind::kLines ? "lines" : "sighting") + "\"" +
                      (or_text ? " or \"text\"" : ""));
    };
  }

  void ReadCorrections(TableReader& table, bool by_dy, Corrections& corrections) {
    const auto take = [&](const char* key, LineWord word) {
      corrections.at(static_cast<std::size_t>(word)) = StretchAt(table, key, reading_);
    };
    take(by_dy ? "front" : "left", by_dy ? LineWord::kFront : LineWord::kLeft);
    take(by_dy ? "back" : "right", by_dy ? LineWord::kBack : LineWord::kRight);
  }

  static void ReadAccepted(TableReader& table, Check& check) {
    const auto words = table.Strings("accept");
    if (!words) return;
    const bool by_dy = check.by == Check::By::kDy;
    for (const auto& each : *words) {
      const auto word = LineWordOf(each.text);
      const bool fits = word && (by_dy ? word == LineWord::kFront || word == LineWord::kBack
                                       : word == LineWord::kLeft || word == LineWord::kRight);
      if (!fits) {
        table.Fault(each.at, "accept",
                    std::string("expected ") +
                        (by_dy ? "\"front\" or \"back\"" : "\"left\" or \"right\"") + ", found " +
                        config_toml::Quote(each.text));
        continue;
      }
      const auto index = static_cast<std::size_t>(*word);
      check.accepted.at(index) = true;
      if (!check.usual.at(index)) continue;
      table.Fault(each.at, "accept", each.text + " has a correction, too");
    }
  }

  Rows CheckRows(Check& check) {
    using By = Check::By;
    const auto corrections = [this, &check](Corrections& which) {
      return [this, &check, &which](TableReader& table) {
        ReadCorrections(table, check.by == By::kDy, which);
      };
    };
    return {
        row::Required(
            "word", "\"ycy\", \"dy\" or \"box\"",
            row::Choice("word", check.by, {{"ycy", By::kYcy}, {"dy", By::kDy}, {"box", By::kBox}})),
        [this, &check](TableReader& table) {
          const bool of_box = check.by == By::kBox;
          DetectorRow(of_box ? Detector::Kind::kSighting : Detector::Kind::kLines,
                      check.detector)(table);
          if (of_box) row::Number("threshold", check.threshold, 0, 0.5)(table);
        },
        [&check](TableReader& table) {
          const auto most = table.Integer("max_corrections", 0, 1000);
          if (most) check.max_corrections = static_cast<int>(*most);
        },
        row::Bool("required", check.required),
        [this, &check](TableReader& table) { ReadAgreement(table, check); },
        corrections(check.usual),
        [&check](TableReader& table) { ReadAccepted(table, check); },
        [&check](TableReader&) { check.after_turn = check.usual; },
        row::Sub("after_turn", {corrections(check.after_turn)}),
    };
  }

  Row RetryRow(Wait& wait) {
    return [this, &wait](TableReader& table) {
      if (const auto retry = StretchAt(table, "retry", reading_)) wait.retry = *retry;
      if (wait.retries == 0) return;
      table.Require("retry", "a walk, as in { move = \"forward\", count = 2 }");
    };
  }

  void CheckDefault(TableReader& table, const Wait& wait) {
    if (wait.otherwise.kind != Otherwise::Kind::kDefault) return;
    if (wait.result >= course().results.size()) return;
    const ResultRule& result = course().results[wait.result];
    if (result.by_default) return;
    table.Fault(table.At("otherwise"), "otherwise",
                "the result " + result.name + " has no default");
  }

  Rows WaitRows(TableReader& table, Wait& wait) {
    if (table.Has("time_ms")) return {row::Time("time_ms", wait.limit)};
    return {
        DetectorRow(Detector::Kind::kSighting, wait.detector.emplace(0), true),
        ReferenceRow("result", "result", course().results, wait.result),
        row::Required("limit_ms", "milliseconds, or time_ms for a plain wait",
                      row::Time("limit_ms", wait.limit)),
        row::Integer("retries", wait.retries, 0, 100),
        RetryRow(wait),
        CounterRow("adds", reading_, wait.adds),
        OtherwiseRow(wait.otherwise, reading_),
        [this, &wait](TableReader& reader) { CheckDefault(reader, wait); },
    };
  }

  Rows KeepRows(Keep& keep) {
    return {
        DetectorRow(Detector::Kind::kLines, keep.detector),
        row::Number("yaw_rad_s", keep.yaw_rad_s, 0, 20),
        row::Number("most_rad_s", keep.most_rad_s, 0, 2),
        row::Time("fresh_ms", keep.fresh),
        row::Bool("one_line", keep.one_line),
    };
  }

  // Without a default.
  Row EndOrStateRow(Otherwise& otherwise) {
    return [this, &otherwise](TableReader& table) {
      OtherwiseRow(otherwise, reading_)(table);
      if (otherwise.kind != Otherwise::Kind::kDefault) return;
      table.Fault(table.At("otherwise"), "otherwise", "expected \"continue\" or a state");
    };
  }

  Rows UntilRows(Until& until) {
    const auto read_most = [this, &until](TableReader& table) {
      const auto most = ReadStretch(table, reading_, "most");
      if (most) until.most = *most;
    };
    return {
        DetectorRow(Detector::Kind::kSighting, until.detector),
        row::Required("phase", "the phase of a sighting, as in \"top\"",
                      row::Text("phase", until.phase)),
        row::Required("most", "the most steps", read_most),
        EndOrStateRow(until.otherwise),
    };
  }

  Rows WalkRows(LaneWalk& walk) {
    return {
        TopicRow("command", walk.command),
        TopicRow("status", walk.status),
        row::Text("end", walk.end),
        row::Time("limit_ms", walk.limit),
        row::Time("silent_ms", walk.silent),
        row::Integer("retries", walk.retries, 0, 100),
        row::Time("retry_ms", walk.retry_after, 0),
        row::Number("least_m", walk.least_m, 0, 1000),
        row::Number("most_m", walk.most_m, 0, 1000),
        [&walk](TableReader& table) {
          if (walk.most_m == 0 || walk.most_m > walk.least_m) return;
          table.Fault(table.At("most_m"), "most_m", "expected more than least_m, or 0");
        },
        EndOrStateRow(walk.otherwise),
    };
  }

  void ReadLight() {
    auto table = root_.Sub("light");
    if (!table) return;
    LightRule& light = course().light.emplace();
    const auto read_state = [&](TableReader& reader) {
      const auto state = Reference(reader, "state", "state", course().states);
      if (!state) reading_.has_leads = false;
      light.state = state.value_or(light.state);
    };
    ReadRows(*table, {DetectorRow(Detector::Kind::kSighting, light.detector),
                      row::Number("stop_within_m", light.within_m, 0.01, 100),
                      row::Required("state", "the name of a state", read_state),
                      row::Time("clear_ms", light.clear), row::Time("again_ms", light.again),
                      row::Time("blind_ms", light.blind)});
  }

  Rows CommandRows(CourseCommand& command) {
    return {
        row::Required("accepted", "the states in which it is accepted",
                      StatesRow("accepted", reading_, command.accepted)),
        StatesRow("leaves", reading_, command.leaves),
        CounterRow("set", reading_, command.counter),
        [](TableReader& table) {
          if (table.Has("set")) table.Require("to", "the value of the counter");
        },
        row::Integer("to", command.value, 0, kMostSteps),
    };
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
