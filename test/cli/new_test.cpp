#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "musher/base/files.hpp"
#include "musher/cli/commands/new_project.hpp"
#include "musher/test/cli/program.hpp"
#include "musher/test/support/paths.hpp"
#include "musher/test/support/temp_folder.hpp"

namespace musher::cli::new_test {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

std::string Spelt(std::string_view name, const Project& project = {"module", "cpp"}) {
  const auto both = ProjectName::From(name, project);
  return both ? both.value().snake + " " + both.value().camel : both.error().message;
}

TEST(ProjectName, HasTwoSpellings) {
  EXPECT_EQ(Spelt("arm"), "arm Arm");
  EXPECT_EQ(Spelt("left_arm"), "left_arm LeftArm");
  EXPECT_EQ(Spelt("LeftArm2"), "left_arm2 LeftArm2");
  EXPECT_EQ(Spelt("HTTPServer"), "http_server HttpServer");
}

TEST(ProjectName, IsRefusedWithTheReason) {
  EXPECT_THAT(Spelt(""), HasSubstr("it is empty"));
  EXPECT_THAT(Spelt("left-arm"), HasSubstr("did you mean 'left_arm'?"));
  EXPECT_THAT(Spelt("../arm"), HasSubstr("letters, digits and '_' only"));
  EXPECT_THAT(Spelt("größe"), HasSubstr("letters, digits and '_' only"));
  EXPECT_THAT(Spelt("2arm"), HasSubstr("begins with a digit"));
  for (const char* name : {"_arm", "arm_", "left__arm"}) {
    EXPECT_THAT(Spelt(name), HasSubstr("between two words"));
  }
  for (const char* name : {"class", "lambda", "Namespace", "None", "test", "musher", "Log",
                           "report", "machine", "errno", "stdout", "linux"}) {
    EXPECT_THAT(Spelt(name), HasSubstr("is a word of C++, Python, CMake")) << name;
  }
  EXPECT_THAT(Spelt(std::string(65, 'a')), HasSubstr("more than 64"));
}

TEST(ProjectName, DoesNotHideAModuleOfPythonsLibraryInAProjectInPython) {
  for (const char* name : {"signal", "Logging", "zlib", "abc"}) {
    EXPECT_THAT(Spelt(name, {"app", "python"}), HasSubstr(".py' would hide a module of Python's"));
  }
  EXPECT_EQ(Spelt("signal"), "signal Signal");
  EXPECT_EQ(Spelt("zip", {"module", "python"}), "zip Zip");
}

class MakeProjectTest : public ::testing::Test {
 protected:
  static Result<std::vector<std::string>> Make(const Project& project, const std::string& name,
                                               const fs::path& folder) {
    return MakeProject(SourceDir() + "/examples", project, ProjectName::From(name, project).value(),
                       folder);
  }
  // No folder and no draft is left.
  std::vector<std::string> Contents() const {
    std::vector<std::string> names;
    for (const fs::path& path : EntriesOf(folder_.path())) names.push_back(path.filename());
    return names;
  }

  const TempFolder folder_;
};

TEST_F(MakeProjectTest, ReplacesEachSpellingOfTheName) {
  const auto files = Make({"module", "cpp"}, "LeftArm", folder_ / "arm");
  ASSERT_TRUE(files) << files.error().message;
  EXPECT_THAT(files.value(),
              ElementsAre(".gitignore", "CMakeLists.txt", "README.md", "left_arm.cpp",
                          "left_arm.hpp", "left_arm_test.cpp", "robot.toml"));
  for (const std::string& file : files.value()) {
    if (file == ".gitignore") continue;
    const std::string text = ReadFile(folder_ / ("arm/" + file));
    EXPECT_THAT(text, HasSubstr("left_arm")) << file;
    EXPECT_THAT(text, Not(HasSubstr("new_module"))) << file;
    EXPECT_THAT(text, Not(HasSubstr("NewModule"))) << file;
  }
  EXPECT_THAT(ReadFile(folder_ / "arm/left_arm.hpp"), HasSubstr("class LeftArm : public"));
}

TEST_F(MakeProjectTest, MakesAProjectInPython) {
  for (const char* kind : {"module", "app"}) {
    const auto files = Make({kind, "python"}, "LeftArm", folder_ / kind);
    ASSERT_TRUE(files) << files.error().message;
    EXPECT_THAT(files.value(), ::testing::IsSupersetOf({".gitignore", "README.md", "left_arm.py",
                                                        "left_arm_test.py", "robot.toml"}));
    for (const std::string& file : files.value()) {
      if (file == ".gitignore") continue;
      const std::string text = ReadFile(folder_ / kind + "/" + file);
      EXPECT_THAT(text, ::testing::AnyOf(HasSubstr("left_arm"), HasSubstr("LeftArm"))) << file;
      EXPECT_THAT(text, Not(HasSubstr("new_python"))) << file;
      EXPECT_THAT(text, Not(HasSubstr("NewPython"))) << file;
    }
    const fs::perms perms = fs::status(folder_ / kind + "/left_arm.py").permissions();
    EXPECT_NE(perms & fs::perms::owner_exec, fs::perms::none);
  }
}

TEST_F(MakeProjectTest, AcceptsAnEmptyFolderOnly) {
  fs::create_directory(folder_ / "arm");
  EXPECT_TRUE(Make({"robot", ""}, "arm", folder_ / "arm"));
  const auto again = Make({"robot", ""}, "arm", folder_ / "arm");
  ASSERT_FALSE(again);
  EXPECT_THAT(again.error().message, HasSubstr("exists and is not empty"));
  std::ofstream(folder_ / "file") << "x";
  EXPECT_THAT(Make({"robot", ""}, "arm", folder_ / "file").error().message,
              HasSubstr("is not a folder"));
  EXPECT_THAT(Make({"robot", ""}, "arm", folder_ / "no/arm").error().message,
              HasSubstr("there is no folder"));
}

TEST_F(MakeProjectTest, KeepsAnEmptyFolderThatIsAWorkingDirectory) {
  fs::create_directory(folder_ / "arm");
  const fs::path before = fs::current_path();
  fs::current_path(folder_ / "arm");
  const auto made = Make({"robot", ""}, "arm", ".");
  const bool still_there = fs::exists("robot.toml");
  fs::current_path(before);
  ASSERT_TRUE(made) << made.error().message;
  EXPECT_TRUE(still_there);
  EXPECT_EQ(EntriesOf(fs::path(folder_ / "arm")).size(), made.value().size());
}

TEST_F(MakeProjectTest, LeavesNothingBehindOnAFailure) {
  const Project module{"module", "cpp"};
  const auto made = MakeProject(folder_ / "no_templates", module,
                                ProjectName::From("arm", module).value(), folder_ / "arm");
  ASSERT_FALSE(made);
  EXPECT_THAT(made.error().message, HasSubstr("cannot be read; install Musher again"));
  EXPECT_THAT(Contents(), IsEmpty());
}

TEST_F(MakeProjectTest, WithoutThePythonPackageSaysWhatToInstall) {
  const Project module{"module", "python"};
  const auto made = MakeProject(folder_ / "no_templates", module,
                                ProjectName::From("arm", module).value(), folder_ / "arm");
  ASSERT_FALSE(made);
  EXPECT_THAT(made.error().message, HasSubstr("install the package python3-musher"));
}

class NewCommand : public MakeProjectTest {};

TEST_F(NewCommand, MakesAConfigOfEachKindThatCheckAccepts) {
  const std::vector<std::vector<std::string>> kinds = {{"module"},
                                                       {"app"},
                                                       {"robot"},
                                                       {"module", "--language", "python"},
                                                       {"app", "--language", "python"}};
  for (const auto& kind : kinds) {
    const std::string made = folder_ / (kind.front() + kind.back());
    std::vector<std::string> line = {"new", kind.front(), "arm", "--folder", made};
    line.insert(line.end(), kind.begin() + 1, kind.end());
    const Ran ran = RunProgram(line);
    ASSERT_EQ(ran.exit, 0) << ran.err;
    EXPECT_THAT(ran.out, HasSubstr("next:\n  cd " + made + "\n"));
    EXPECT_EQ(ran.out.find("  python3 arm_test.py\n") != std::string::npos,
              kind.back() == "python");
    const Ran check = RunProgram({"check", made + "/robot.toml"});
    EXPECT_EQ(check.exit, 0) << check.out;
  }
}

TEST_F(NewCommand, IsRefusedWithASentence) {
  EXPECT_EQ(RunProgram({"new", "module"}).exit, 2);
  EXPECT_EQ(RunProgram({"new", "gadget", "arm"}).exit, 2);
  EXPECT_EQ(RunProgram({"new", "module", "arm", "--language", "pyhton"}).exit, 2);
  EXPECT_EQ(RunProgram({"new", "robot", "arm", "--language", "python"}).exit, 2);
  const Ran keyword = RunProgram({"new", "app", "class", "--folder", folder_ / "x"});
  EXPECT_EQ(keyword.exit, 2);
  EXPECT_THAT(keyword.err, HasSubstr("musher: invalid name 'class'"));
  EXPECT_THAT(Contents(), IsEmpty());
}

TEST_F(NewCommand, PrintsCommandsToCopyAlsoForAFolderWithASpace) {
  const std::string made = folder_ / "my robots/rover";
  fs::create_directory(folder_ / "my robots");
  const Ran ran = RunProgram({"new", "robot", "rover", "--folder", made});
  EXPECT_THAT(ran.out, HasSubstr("next:\n  cd '" + made + "'\n"));
}

TEST_F(NewCommand, IsOneJsonDocument) {
  const Ran ran = RunProgram({"--json", "new", "robot", "rover", "--folder", folder_ / "rover/"});
  EXPECT_EQ(ran.exit, 0) << ran.err;
  EXPECT_THAT(ran.out,
              ::testing::StartsWith(R"({"kind":"robot","language":null,"name":"rover",")"));
  EXPECT_THAT(
      ran.out,
      HasSubstr(R"("files":[".gitignore","README.md","base.toml","lights.toml","robot.toml"])"));
}

TEST_F(MakeProjectTest, ARobotGetsItsKeysAndIsUsedWithThem) {
  const std::string made = folder_ / "rover";
  ASSERT_EQ(RunProgram({"new", "robot", "rover", "--folder", made}).exit, 0);
  const std::string config = made + "/robot.toml";
  const Ran keys = RunProgram({"keys", "init", config});
  EXPECT_EQ(keys.exit, 0) << keys.err;
  EXPECT_THAT(keys.err, HasSubstr("now add to " + config + " the table [security]"));
  std::ofstream(config, std::ios::app) << "\n[security]\nkeys = \"keys\"\n";
  const Ran check = RunProgram({"check", config});
  EXPECT_EQ(check.exit, 0) << check.out << check.err;
  const std::string identities = RunProgram({"keys", "list", "--keys", made + "/keys"}).out;
  EXPECT_THAT(identities, ::testing::AllOf(HasSubstr("controller"), HasSubstr("operator")));
}

}  // namespace musher::cli::new_test
