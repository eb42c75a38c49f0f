// Every configs/{good,bad}/<case>.toml is read and must give exactly the diagnostics of
// <case>.expected beside it. A new case is these two files; with MUSHER_UPDATE_GOLDEN=1 in the
// environment the test writes the expectations instead, to be read before they are committed.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "musher/cyberdog/voice_policy.hpp"  // reads [policy.voice]
#include "musher/lifecycle/config/config_toml.hpp"
#include "musher/test/support/paths.hpp"

namespace musher::config_golden_test {

namespace fs = std::filesystem;

std::string ReadText(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  EXPECT_TRUE(file) << path << " cannot be read";
  return {std::istreambuf_iterator<char>(file), {}};
}

std::vector<fs::path> Files(const std::string& kind, const std::string& extension) {
  std::vector<fs::path> files;
  for (const auto& entry :
       fs::directory_iterator(fs::path(SourceDir()) / "test" / "golden" / "configs" / kind)) {
    if (entry.path().extension() == extension) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

// As `musher check` would print it, with the bare file name.
std::string Print(const ConfigReading& reading) {
  std::string text;
  for (const Diagnostic& diagnostic : reading.diagnostics) {
    text += FormatDiagnostic(diagnostic) + "\n";
  }
  return text;
}

bool MustUpdate() {
  return std::getenv("MUSHER_UPDATE_GOLDEN") != nullptr;
}

void CheckAll(const std::string& kind, bool is_good) {
  for (const fs::path& path : Files(kind, ".toml")) {
    SCOPED_TRACE(path.filename());
    if (path.filename().string().starts_with("hosts") && !SupportsHosts()) continue;
    const ConfigReading reading = ReadConfigText(ReadText(path), path.filename().string());
    EXPECT_EQ(reading.config.has_value(), is_good);
    EXPECT_EQ(HasError(reading.diagnostics), !is_good);
    const fs::path expected = fs::path(path).replace_extension(".expected");
    if (MustUpdate()) std::ofstream(expected, std::ios::binary) << Print(reading);
    EXPECT_EQ(Print(reading), ReadText(expected));
  }
}

TEST(GoldenConfigs, GoodOnesAreReadWithExactlyTheExpectedWarnings) {
  CheckAll("good", true);
}

TEST(GoldenConfigs, BadOnesAreRefusedWithExactlyTheExpectedDiagnostics) {
  CheckAll("bad", false);
}

TEST(GoldenConfigs, EveryExpectationHasItsConfig) {
  EXPECT_GE(Files("good", ".toml").size(), 5U);
  EXPECT_GE(Files("bad", ".toml").size(), 30U);
  for (const std::string kind : {"good", "bad"}) {
    for (const fs::path& path : Files(kind, ".expected")) {
      EXPECT_TRUE(fs::exists(fs::path(path).replace_extension(".toml"))) << path;
    }
  }
}

}  // namespace musher::config_golden_test
