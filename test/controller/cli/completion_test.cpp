#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <fstream>
#include <regex>
#include <set>

#include "musher/controller/cli/completion_scripts.hpp"
#include "musher/test/controller/cli/program.hpp"
#include "musher/test/controller/temp_folder.hpp"

namespace musher::cli {
namespace {

const std::vector<std::string> kCommands = {"check", "up",      "down",  "status",     "set",
                                            "plan",  "history", "graph", "completion", "restart",
                                            "estop", "keys",    "ota"};

// Every long option that the help of the program and of its commands tells.
std::set<std::string> AllOptions() {
  std::string help = RunProgram({"--help"}).out;
  for (const std::string& command : kCommands) help += RunProgram({command, "--help"}).out;
  for (const char* one : {"init", "add"}) help += RunProgram({"keys", one, "--help"}).out;
  for (const char* one : {"keygen", "bundle", "init", "verify", "install", "status", "rollback"}) {
    help += RunProgram({"ota", one, "--help"}).out;
  }
  const std::regex at_begin("(^|\\n)  (-[a-z],)?(--[a-z-]+)");
  std::set<std::string> options;
  for (std::sregex_iterator i(help.begin(), help.end(), at_begin), end; i != end; ++i) {
    options.insert((*i)[3]);
  }
  return options;
}

std::string Shell(const std::string& program, const TempFolder& folder, const std::string& script) {
  std::ofstream(folder / "script") << script;
  FILE* pipe = popen((program + " " + (folder / "script") + " 2>&1").c_str(), "r");
  std::string text;
  std::array<char, 4096> part{};
  while (std::fgets(part.data(), part.size(), pipe) != nullptr) text += part.data();
  pclose(pipe);
  return text;
}

// What bash offers after these words, the last of them unfinished.
std::string BashOffers(const std::string& words) {
  const TempFolder folder;
  return Shell("bash", folder,
               std::string(kBashCompletion) + "\ncd " + folder.path() +
                   "\ntouch robot.toml other.txt\nCOMP_WORDS=(" + words +
                   ")\nCOMP_CWORD=$((${#COMP_WORDS[@]} - 1))\n_musher_with_space\n"
                   "printf '%s|' \"${COMPREPLY[@]}\"\n");
}

TEST(CompletionScripts, KnowEveryCommandAndEveryOption) {
  ASSERT_GT(AllOptions().size(), 10U);
  for (const char* script : {kBashCompletion, kZshCompletion}) {
    for (const std::string& command : kCommands) {
      EXPECT_THAT(script, testing::HasSubstr(command));
    }
    for (const std::string& option : AllOptions()) EXPECT_THAT(script, testing::HasSubstr(option));
  }
}

TEST(CompletionScripts, ArePrintedByTheCommand) {
  EXPECT_EQ(RunProgram({"completion", "bash"}).out, kBashCompletion);
  EXPECT_EQ(RunProgram({"completion", "zsh"}).out, kZshCompletion);
  EXPECT_EQ(RunProgram({"completion", "fish"}).exit, 2);
}

TEST(CompletionScripts, CompleteInBash) {
  EXPECT_EQ(BashOffers("musher st"), "status |");
  EXPECT_EQ(BashOffers("musher set Pro"), "Protected |");
  EXPECT_EQ(BashOffers("musher --json plan LowP"), "LowPower |");
  EXPECT_EQ(BashOffers("musher check ''"), "robot.toml |");
  EXPECT_EQ(BashOffers("musher history --lim"), "--limit |");
  EXPECT_EQ(BashOffers("musher keys a"), "add |");
  EXPECT_EQ(BashOffers("musher keys add guest --role ob"), "observer |");
  EXPECT_EQ(BashOffers("musher status --transport l"), "local |lan |");
}

TEST(CompletionScripts, AreCorrectForZsh) {
  if (std::system("command -v zsh >/dev/null") != 0) GTEST_SKIP() << "there is no zsh here";
  const TempFolder folder;
  EXPECT_EQ(Shell("zsh -n", folder, kZshCompletion), "");
}

}  // namespace
}  // namespace musher::cli
