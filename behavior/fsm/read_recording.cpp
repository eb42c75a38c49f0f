// Reads the lines of a recording. They may be incomplete, if the recording process crashed, or
// edited by a person.

#include <algorithm>
#include <utility>

#include "musher/base/suggest.hpp"
#include "musher/behavior/fsm/recording_text.hpp"
#include "musher/behavior/fsm/replay.hpp"

namespace musher::fsm {
namespace {

using Line = Recording::Line;
using Kind = Line::Kind;

struct Verb {
  std::string_view word;
  Kind kind;
  bool has_time;
  std::size_t words;  // after it, besides the time
};

constexpr Verb kVerbs[] = {
    {"start", Kind::kStart, true, 1},  {"tick", Kind::kTick, true, 0},
    {"pause", Kind::kPause, false, 0}, {"command", Kind::kCommand, false, 1},
    {"force", Kind::kForce, false, 1}, {"reset", Kind::kReset, false, 0},
    {"stop", Kind::kStop, false, 0},   {"input", Kind::kInput, false, 2},
};

void ReadHeader(RecordingLine& line, Recording& recording) {
  recording.has_inside = line.rest().starts_with(std::string(kRecordingFormat) + " ");
  if (!recording.has_inside && !line.rest().starts_with(std::string(kRecordingFormat1) + " ")) {
    line.Fail("a recording begins with \"" + std::string(kRecordingFormat) + "\" and a machine");
  }
  line.Word();
  line.Word();
  recording.machine = line.Word();
  line.End();
}

Line ReadLine(RecordingLine& reader, int number) {
  Line line;
  line.number = number;
  const std::string word = reader.Word();
  if (word == "changed" || word == "inside") {
    line.kind = Kind::kChanged;
    if (word == "inside") line.text = "inside ";
    line.text += reader.rest();
    while (!reader.AtEnd()) reader.Word();
    return line;
  }
  if (word == kRestored) {
    reader.Fail("from here on the machine was restored from a snapshot, which is not recorded");
  }
  const auto* const verb = std::ranges::find(kVerbs, word, &Verb::word);
  if (verb == std::end(kVerbs)) {
    std::vector<std::string_view> words{"changed", "inside"};
    for (const Verb& known : kVerbs) words.push_back(known.word);
    reader.Fail(word + " is not a kind of line" + DidYouMean(word, words));
  }
  line.kind = verb->kind;
  if (verb->has_time) line.time = reader.Seconds();
  if (verb->words > 0) line.name = reader.Word();
  if (verb->words > 1) line.text = reader.Word();
  while (line.kind == Kind::kCommand && !reader.AtEnd()) {
    std::string field = reader.Word();
    line.data.emplace_back(std::move(field), reader.Word());
  }
  reader.End();
  return line;
}

}  // namespace

Result<Recording> ReadRecording(std::string_view text, const std::string& file) {
  Recording recording;
  recording.file = file;
  int number = 0;
  try {
    while (!text.empty() || number == 0) {
      ++number;
      const std::size_t end = text.find('\n');
      RecordingLine reader(text.substr(0, end), file, number);
      if (end == std::string_view::npos && number > 1) {
        recording.cut_short = true;
        break;
      }
      if (number == 1) {
        ReadHeader(reader, recording);
      } else {
        recording.lines.push_back(ReadLine(reader, number));
      }
      text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    }
  } catch (Error& fault) {
    return std::move(fault);
  }
  return recording;
}

}  // namespace musher::fsm
