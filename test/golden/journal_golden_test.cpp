// A journal of an earlier version is read by all that come after it, and nothing that it recorded
// is lost. journal/<version>.txt has the inputs of a robot's short run as that version wrote them.
// journal_events/<version>.txt has an event of each kind, and a machine, with a value in each
// field; present.txt there has those of the present code, with what was appended since the last
// version. With MUSHER_UPDATE_GOLDEN=1 in the environment the test writes present.txt, and the
// files of a new version; those of an existing version are never written again.

#include <gmock/gmock.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "musher/base/version.hpp"
#include "musher/controller/journal/encoding.hpp"
#include "musher/controller/journal/replay.hpp"
#include "musher/test/controller/recorded_robot.hpp"
#include "musher/test/support/paths.hpp"

namespace musher::recording::journal_golden_test {

namespace fs = std::filesystem;

// A line: the kind of input, and its JSON.
std::string Line(const ConfigText& config) {
  return "config " + EncodeConfig(config);
}
std::string Line(const TimedEvent& timed) {
  return "event " + EncodeEvent(timed.event, timed.now);
}
std::string Line(const SnapshotPtr& snapshot) {
  return "machine " + EncodeSnapshot(*snapshot);
}

Result<JournalInput> Read(const std::string& line) {
  const std::string kind = line.substr(0, line.find(' '));
  const std::string text = line.substr(kind.size() + 1);
  const auto input = [](auto decoded) -> Result<JournalInput> {
    if (!decoded) return decoded.error();
    return JournalInput{1, std::move(decoded).value()};
  };
  if (kind == "config") return input(DecodeConfig(text));
  if (kind == "event") return input(DecodeEvent(text));
  auto snapshot = DecodeSnapshot(text);
  if (!snapshot) return snapshot.error();
  return JournalInput{1, std::make_shared<const MachineSnapshot>(std::move(snapshot).value())};
}

fs::path Folder(const std::string& name) {
  return fs::path(SourceDir()) / "test" / "golden" / name;
}

bool MustUpdate() {
  return std::getenv("MUSHER_UPDATE_GOLDEN") != nullptr;
}

std::vector<std::string> Lines(const fs::path& path) {
  std::vector<std::string> lines;
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) lines.push_back(line);
  return lines;
}

void Write(const fs::path& path) {
  std::ofstream file(path);
  for (const JournalItem& item : RecordedLife()) {
    if (const auto* input = std::get_if<JournalInput>(&item)) {
      file << std::visit([](const auto& what) { return Line(what); }, input->what) << "\n";
    }
  }
}

TEST(JournalCompatibility, EveryInputOfEveryVersionIsReadWithoutLossAndReplayed) {
  const fs::path folder = Folder("journal");
  const fs::path version = folder / (std::string(Version()) + ".txt");
  if (MustUpdate() && !fs::exists(version)) Write(version);
  int versions = 0;
  for (const auto& entry : fs::directory_iterator(folder)) {
    SCOPED_TRACE("as version " + entry.path().stem().string() + " wrote it");
    std::vector<JournalRow> rows;
    for (const std::string& line : Lines(entry.path())) {
      auto input = Read(line);
      ASSERT_TRUE(input) << input.error().message << " in " << line;
      EXPECT_EQ(std::visit([](const auto& what) { return Line(what); }, input.value().what), line);
      rows.push_back({static_cast<std::int64_t>(rows.size()) + 1, std::move(input).value()});
    }
    const auto report = Replay(rows, {});
    ASSERT_TRUE(report) << report.error().message;
    EXPECT_EQ(report.value().not_replayed, 0U);
    EXPECT_EQ(report.value().starts, 2U);
    EXPECT_GT(report.value().inputs, 20U);
    ++versions;
  }
  EXPECT_GE(versions, 1);
}

// Values that differ from the default, in each field.
void Fill(bool& value) {
  value = !value;
}
template <class T>
requires(std::is_integral_v<T>) void Fill(T& value) {
  value = 7;
}
void Fill(std::string& text) {
  text = "text";
}
template <class T>
requires(std::is_enum_v<T>) void Fill(T& value) {
  value = static_cast<T>(fields::kValueNames<T>.size() - 1);
}
void Fill(Duration& value) {
  value = Milliseconds(7);
}
void Fill(Time& value) {
  value = Time(Milliseconds(7));
}
template <typename Kind>
void Fill(StrongNumber<Kind>& number) {
  number = StrongNumber<Kind>(7);
}
void Fill(State& state) {
  state = "Dancing";
}
template <fields::Struct T>
void Fill(T& value);
template <class T>
void Fill(std::vector<T>& items) {
  T item{};
  Fill(item);
  items.push_back(std::move(item));
}
template <class T>
void Fill(PerActuator<T>& items) {
  T item{};
  Fill(item);
  items.push_back(std::move(item));
}
template <class T>
void Fill(std::optional<T>& value) {
  Fill(value.emplace());
}
template <class T, class AnyField>
void FillOne(T& value, const AnyField& field) {
  Fill(value.*field.member);
}
template <class T, class B>
void FillOne(T& value, const fields::Base<B>& /*base*/) {
  Fill(static_cast<B&>(value));
}
template <fields::Struct T>
void Fill(T& value) {
  std::apply([&](const auto&... fields) { (FillOne(value, fields), ...); }, fields::kFields<T>);
}

template <std::size_t I = 0>
void AddEvents(std::vector<std::string>& lines) {
  std::variant_alternative_t<I, Event> event;
  Fill(event);
  lines.push_back(Line(TimedEvent{event, Time(Milliseconds(7))}));
  if constexpr (I + 1 < std::variant_size_v<Event>) AddEvents<I + 1>(lines);
}

std::vector<std::string> EveryValue() {
  std::vector<std::string> lines;
  AddEvents(lines);
  auto snapshot = std::make_shared<MachineSnapshot>();
  Fill(snapshot->machine);
  lines.push_back(Line(SnapshotPtr(snapshot)));
  return lines;
}

void Write(const fs::path& path, const std::vector<std::string>& lines) {
  std::ofstream file(path);
  for (const std::string& line : lines) file << line << "\n";
}

// A field that is renamed or removed is lost in the line that is read.
TEST(JournalCompatibility, EveryFieldOfEveryEventOfEveryVersionIsRead) {
  const fs::path folder = Folder("journal_events");
  const fs::path version = folder / (std::string(Version()) + ".txt");
  if (MustUpdate() && !fs::exists(version)) Write(version, EveryValue());
  int versions = 0;
  for (const auto& entry : fs::directory_iterator(folder)) {
    SCOPED_TRACE("as in " + entry.path().filename().string());
    for (const std::string& line : Lines(entry.path())) {
      auto input = Read(line);
      ASSERT_TRUE(input) << input.error().message << " in " << line;
      EXPECT_EQ(std::visit([](const auto& what) { return Line(what); }, input.value().what), line);
    }
    ++versions;
  }
  EXPECT_GE(versions, 2);
}

// A field that was appended since the last version is in no file of a version: its name could
// change without a word.
TEST(JournalCompatibility, EveryFieldIsRecordedAlsoBetweenTwoVersions) {
  const fs::path present = Folder("journal_events") / "present.txt";
  if (MustUpdate()) Write(present, EveryValue());
  EXPECT_EQ(Lines(present), EveryValue())
      << "if only events and fields were appended, MUSHER_UPDATE_GOLDEN=1 records them";
}

}  // namespace musher::recording::journal_golden_test
