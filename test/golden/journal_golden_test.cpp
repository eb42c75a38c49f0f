// A journal of an earlier version is read by all that come after it, and nothing that it recorded
// is lost. journal/<version>.txt has the inputs of a robot's short life as that version wrote them.
// journal_events/<version>.txt has an event of each kind, and a machine, with a value in each
// field. A new version adds its files with MUSHER_UPDATE_GOLDEN=1 in the environment; the files of
// earlier versions are never written again.

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

void Write(const fs::path& path) {
  std::ofstream file(path);
  for (const JournalItem& item : RecordedLife()) {
    if (const auto* input = std::get_if<JournalInput>(&item)) {
      file << std::visit([](const auto& what) { return Line(what); }, input->what) << "\n";
    }
  }
}

TEST(JournalCompatibility, EveryInputOfEveryVersionIsReadWithoutLossAndReplayed) {
  const fs::path folder = fs::path(SourceDir()) / "test" / "golden" / "journal";
  if (std::getenv("MUSHER_UPDATE_GOLDEN") != nullptr) {
    Write(folder / (std::string(Version()) + ".txt"));
  }
  int versions = 0;
  for (const auto& entry : fs::directory_iterator(folder)) {
    SCOPED_TRACE("as version " + entry.path().stem().string() + " wrote it");
    std::ifstream file(entry.path());
    std::vector<JournalRow> rows;
    for (std::string line; std::getline(file, line);) {
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

// A field that is renamed or removed is lost in the line that is read.
TEST(JournalCompatibility, EveryFieldOfEveryEventOfEveryVersionIsRead) {
  const fs::path folder = fs::path(SourceDir()) / "test" / "golden" / "journal_events";
  const fs::path own = folder / (std::string(Version()) + ".txt");
  if (std::getenv("MUSHER_UPDATE_GOLDEN") != nullptr) {
    fs::create_directories(folder);
    std::ofstream file(own);
    for (const std::string& line : EveryValue()) file << line << "\n";
  }
  for (const auto& entry : fs::directory_iterator(folder)) {
    SCOPED_TRACE("as version " + entry.path().stem().string() + " wrote it");
    std::ifstream file(entry.path());
    for (std::string line; std::getline(file, line);) {
      auto input = Read(line);
      ASSERT_TRUE(input) << input.error().message << " in " << line;
      EXPECT_EQ(std::visit([](const auto& what) { return Line(what); }, input.value().what), line);
    }
  }
  std::vector<std::string> written;
  std::ifstream file(own);
  for (std::string line; std::getline(file, line);) written.push_back(line);
  EXPECT_EQ(written, EveryValue()) << "a kind of event or a field has no line for this version";
}

}  // namespace musher::recording::journal_golden_test
