// A journal of an earlier version is read by all that come after it, and nothing that it recorded
// is lost. journal/<version>.txt has the inputs of a robot's short life as that version wrote them.
// A new version adds its file with MUSHER_UPDATE_GOLDEN=1 in the environment; the files of earlier
// versions are never written again.

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

}  // namespace musher::recording::journal_golden_test
