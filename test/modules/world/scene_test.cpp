// Scene files. Every scenes/bad/<case>.toml must give exactly the diagnostics of <case>.expected
// beside it; with MUSHER_UPDATE_GOLDEN=1 in the environment the test writes them instead, to be
// read before they are committed.

#include <gmock/gmock.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "musher/modules/world/scene/place.hpp"
#include "musher/modules/world/scene_file/scene_toml.hpp"
#include "musher/test/support/paths.hpp"

namespace musher::world::scene_test {

namespace fs = std::filesystem;
using ::testing::IsEmpty;

std::string ReadText(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  EXPECT_TRUE(file) << path << " cannot be read";
  return {std::istreambuf_iterator<char>(file), {}};
}

TEST(Scene, OfTheRepositoryIsGood) {
  for (const auto& entry : fs::directory_iterator(SourceDir() + "/config/scenes")) {
    if (entry.path().extension() != ".toml") continue;  // a picture of one
    const SceneReading reading = ReadSceneFile(entry.path());
    EXPECT_THAT(reading.diagnostics, IsEmpty()) << entry.path();
    EXPECT_TRUE(reading.scene) << entry.path();
  }
}

TEST(Scene, MayBeEmptyAndIsNamedAsItsFile) {
  const SceneReading reading = ReadSceneText("", "scenes/meadow.toml");
  ASSERT_TRUE(reading.scene);
  EXPECT_EQ(reading.scene->name, "meadow");
  EXPECT_TRUE(IsFree(*reading.scene, reading.scene->start.position_m));
}

TEST(Scene, PutsItsEventsInTheOrderOfTheirTimes) {
  const SceneReading reading = ReadSceneText(
      "[[event]]\nat_s = 2.5\ncable = true\n[[event]]\nat_s = 1\ntouch = 3\n", "s.toml");
  ASSERT_TRUE(reading.scene);
  ASSERT_EQ(reading.scene->events.size(), 2u);
  EXPECT_EQ(std::get<Touch>(reading.scene->events[0].what).state, 3);
  EXPECT_EQ(reading.scene->events[1].at, Milliseconds(2500));
}

TEST(Scene, TakesAWallForAThinBoxBetweenItsEnds) {
  const SceneReading reading =
      ReadSceneText("[[wall]]\nfrom_m = [1, 1]\nto_m = [1, 3]\nthickness_m = 0.2\n", "s.toml");
  ASSERT_TRUE(reading.scene);
  ASSERT_EQ(reading.scene->boxes.size(), 1u);
  EXPECT_NEAR(From(reading.scene->boxes[0], {1.5, 2}).distance_m, 0.4, 1e-9);
  EXPECT_NEAR(From(reading.scene->boxes[0], {1, 3.5}).distance_m, 0.5, 1e-9);
}

TEST(Scene, ThatCannotBeReadReportsWhy) {
  const SceneReading missing = ReadSceneFile("/nowhere/yard.toml");
  ASSERT_EQ(missing.diagnostics.size(), 1u);
  EXPECT_EQ(FormatDiagnostic(missing.diagnostics[0]),
            "/nowhere/yard.toml: error: the file cannot be read: No such file or directory");
  const SceneReading folder = ReadSceneFile(SourceDir());
  ASSERT_EQ(folder.diagnostics.size(), 1u);
  EXPECT_FALSE(folder.scene);
}

TEST(Scene, ThatIsInvalidReportsEveryErrorWithItsPlace) {
  int cases = 0;
  for (const auto& entry : fs::directory_iterator(SourceDir() + "/test/modules/world/scenes/bad")) {
    if (entry.path().extension() != ".toml") continue;
    ++cases;
    SCOPED_TRACE(entry.path().filename());
    const SceneReading reading =
        ReadSceneText(ReadText(entry.path()), entry.path().filename().string());
    EXPECT_FALSE(reading.scene);
    std::string printed;
    for (const Diagnostic& diagnostic : reading.diagnostics) {
      printed += FormatDiagnostic(diagnostic) + "\n";
    }
    const fs::path expected = fs::path(entry.path()).replace_extension(".expected");
    if (std::getenv("MUSHER_UPDATE_GOLDEN") != nullptr) std::ofstream(expected) << printed;
    EXPECT_EQ(printed, ReadText(expected));
  }
  EXPECT_GE(cases, 6);
}

}  // namespace musher::world::scene_test
