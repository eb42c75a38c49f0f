#include "musher/base/config_path.hpp"

#include <gtest/gtest.h>

#include <cstdlib>

namespace musher::config_path_test {

TEST(ConfigPath, IsTheFileThatTheEnvironmentNamesWhereNoneIsGiven) {
  setenv("MUSHER_CONFIG", "/robots/dog.toml", 1);
  EXPECT_EQ(ConfigPath(""), "/robots/dog.toml");
  EXPECT_EQ(ConfigPath("sled.toml"), "sled.toml");
  unsetenv("MUSHER_CONFIG");
  EXPECT_EQ(ConfigPath(""), "");
  EXPECT_EQ(ConfigPath("sled.toml"), "sled.toml");
}

}  // namespace musher::config_path_test
