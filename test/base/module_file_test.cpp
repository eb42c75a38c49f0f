// The TOML file of a user's module.

#include "musher/base/toml/module_file.hpp"

#include <gmock/gmock.h>

#include <fstream>

#include "musher/test/support/temp_folder.hpp"

namespace musher::module_file_test {

using ::testing::HasSubstr;

class ModuleFile : public ::testing::Test {
 protected:
  Result<> Read(const std::string& text) {
    std::ofstream(path_) << text;
    return ReadModuleFile(path_, [this](config_toml::TableReader& table) {
      speed_ = table.Number("speed_mm_s", 1, 100).value_or(speed_);
    });
  }
  const TempFolder folder_;
  const std::string path_ = folder_ / "gripper.toml";
  double speed_ = 40;
};

TEST_F(ModuleFile, GivesTheKeysThatItsModuleReads) {
  EXPECT_TRUE(Read("speed_mm_s = 12.5"));
  EXPECT_EQ(speed_, 12.5);
}

TEST_F(ModuleFile, ReportsAllItsErrorsWithTheirPositions) {
  const Result<> read = Read("speed_mm_s = 400\nspeed_mms = 3");
  ASSERT_FALSE(read);
  EXPECT_THAT(read.error().message,
              HasSubstr("gripper.toml:1:14: error: speed_mm_s: expected a number from 1 to 100"));
  EXPECT_THAT(read.error().message, HasSubstr("\n" + path_ +
                                              ":2:1: error: unknown key "
                                              "\"speed_mms\"; did you mean \"speed_mm_s\"?"));
}

TEST_F(ModuleFile, ReportsWhyItIsNotRead) {
  EXPECT_THAT(Read("speed_mm_s = ").error().message, HasSubstr("gripper.toml:1:"));
  EXPECT_THAT(ReadModuleFile(folder_ / "none.toml", [](auto&) {}).error().message,
              HasSubstr("none.toml: error: the file cannot be read: No such file"));
}

}  // namespace musher::module_file_test
