// The example of a robot of two computers, as its README says to type it.

#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "musher/test/integration/hosts/robot_and_board.hpp"

namespace musher::testing::two_computers_test {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class TwoComputers : public RobotAndBoard {
 protected:
  // What a reader types: the lines with a prompt.
  static std::vector<std::string> Commands(const std::string& page) {
    std::vector<std::string> commands;
    std::istringstream lines(page);
    for (std::string line; std::getline(lines, line);) {
      if (line.starts_with("$ ")) commands.push_back(line.substr(2));
    }
    return commands;
  }
  static std::string WithAddress(std::string text) {
    const std::string theirs = "192.168.44.2";
    for (std::size_t at = 0; (at = text.find(theirs, at)) != std::string::npos;) {
      text.replace(at, theirs.size(), kBoardAddress);
    }
    return text;
  }
};

TEST_F(TwoComputers, AreOneRobotAsTheReadmeSays) {
  const std::filesystem::path example = SourceDir() + "/examples/two_computers";
  const TempFolder reader;
  for (const auto& file : std::filesystem::directory_iterator(example)) {
    std::string text = WithAddress(ReadFile(file.path()));
    // `check --hosts` refuses a limit that the board does not keep.
    const std::size_t limit = text.find("\nmemory_max_mb");
    if (limit != std::string::npos && !KeepsMemory()) {
      text.erase(limit, text.find('\n', limit + 1) - limit);
    }
    std::ofstream(reader / file.path().filename().string()) << text;
  }
  ASSERT_EQ(OnBoard({"ln", "-sf", BinDir() + "/musher-exec", "/usr/local/bin/musher-exec"}).exit,
            0);
  std::string printed;
  for (const std::string& command : Commands(ReadFile(reader / "README.md"))) {
    SCOPED_TRACE(command);
    const Ended typed = robot_->Do({"env", "-u", "MUSHER_NAMESPACE",
                                    "PATH=" + BinDir() + ":/usr/bin:/bin:/usr/sbin:/sbin", "sh",
                                    "-c", "cd " + reader.path() + " && " + command});
    ASSERT_EQ(typed.exit, 0) << typed.out << typed.err;
    printed += typed.out;
    // In the place of ssh-copy-id, which asks for a password.
    if (command.starts_with("ssh-keygen")) {
      std::ofstream(root_->path() + "/root/.ssh/authorized_keys", std::ios::app)
          << ReadFile(reader / "id_robot.pub");
    }
  }
  EXPECT_THAT(printed, AllOf(HasSubstr("a picture"), HasSubstr("killed by SIGKILL"),
                             HasSubstr("eyes started on host vision")));
  EXPECT_THAT(Units(), IsEmpty());
}

}  // namespace musher::testing::two_computers_test
