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

// Its motion board is the board here, its NX board the robot's host, which has no systemd.
TEST_F(TwoComputers, AreTheBoardsOfACyberdog) {
  const TempFolder reader;
  std::filesystem::create_directories(reader / "examples/two_computers");
  std::filesystem::create_directory(reader / "config");
  std::filesystem::copy(SourceDir() + "/config/exec", reader / "config/exec");
  std::string text = ReadFile(SourceDir() + "/examples/two_computers/cyberdog.toml");
  const auto replace = [&](const std::string& words, const std::string& by) {
    const std::size_t at = text.find(words);
    ASSERT_NE(at, std::string::npos) << words;
    text.replace(at, words.size(), by);
  };
  replace("192.168.44.233", kBoardAddress);
  replace("\"id_robot\"", "\"" + root_->Key() + "\"");
  replace("\"known_hosts\"", "\"" + root_->KnownHosts() + "\"");
  replace("eth0", kLink);
  replace("units = \"always\"", "");
  replace("cpus = 2.0\nmemory_max_mb = 2048\n", "");
  replace("sandbox = \"read-only\"\nmemory_max_mb = 512\n", "");
  replace("namespace = \"cyberdog\"", "namespace = \"" + name_space_ + "\"");
  const std::string config = reader / "examples/two_computers/cyberdog.toml";
  std::ofstream(config) << text;
  ASSERT_EQ(OnBoard({"mkdir -p /usr/local/bin " + reader.path() + " && ln -sf " + BinDir() +
                     "/musher-exec /usr/local/bin/musher-exec && mkdir -p " + reader.path()})
                .exit,
            0);
  ASSERT_EQ(RunToEnd({"cp", "-r", reader.path() + "/.", root_->path() + reader.path()}).exit, 0);
  const Ended check = robot_->Run({"check", "--hosts", config});
  EXPECT_EQ(check.exit, 0) << check.out << check.err;
  const Ended up = robot_->Run({"up", config, "--detach"});
  ASSERT_EQ(up.exit, 0) << up.out << up.err;
  ASSERT_TRUE(AwaitActive()) << robot_->Status();
  EXPECT_THAT(Units(), HasSubstr("musher-cyberdog-motion_manager.service"));
  EXPECT_EQ(robot_->Run({"down"}).exit, 0);
  EXPECT_THAT(Units(), IsEmpty());
}

}  // namespace musher::testing::two_computers_test
