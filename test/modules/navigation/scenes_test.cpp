// Held scenes of the whole navigation: no contact of a body that drives, a definite end, and the
// goal where there is a way.

#include "musher/test/modules/navigation/scenes.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <cctype>

namespace musher::navigation::testing {

void PrintTo(const Scene& scene, std::ostream* out) {
  *out << scene.kind << ", " << scene.name;
}

namespace scenes_test {

class HeldScenesNightly : public ::testing::TestWithParam<Scene> {};

TEST_P(HeldScenesNightly, EndWithoutAContact) {
  const SceneEnd end = RunScene(GetParam(), true);
  EXPECT_EQ(end.contacts, 0);
  EXPECT_NE(end.kind, SceneEnd::Kind::kEndless);
  if (!GetParam().passable) {
    EXPECT_NE(end.reason, "");
  } else {
    EXPECT_EQ(end.kind, SceneEnd::Kind::kArrived) << end.reason;
  }
}

std::string NameOf(const ::testing::TestParamInfo<Scene>& scene) {
  std::string name = scene.param.kind + "_" + scene.param.name;
  std::erase_if(name, [](char c) { return c == '.' || c == ','; });
  std::ranges::replace_if(
      name, [](unsigned char c) { return !std::isalnum(c); }, '_');
  return name;
}

INSTANTIATE_TEST_SUITE_P(All, HeldScenesNightly, ::testing::ValuesIn(HeldScenes()), NameOf);

}  // namespace scenes_test
}  // namespace musher::navigation::testing
