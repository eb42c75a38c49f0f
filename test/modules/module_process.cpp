#include "musher/test/modules/module_process.hpp"

#include <fcntl.h>

#include <fstream>
#include <iterator>

namespace musher::test {

ModuleProcess::ModuleProcess(const std::string& actuator, const std::string& program,
                             const ActuatorStates& states)
    : peer_(actuator, states, program) {}

void ModuleProcess::Start(const std::string& file) {
  peer_.Start(file);
  ASSERT_TRUE(peer_.AwaitVisible()) << peer_.Output();
}

void ModuleProcess::StartOnWorldTime(const std::string& file) {
  peer_.StartOnWorldTime(file);
  ASSERT_TRUE(peer_.AwaitVisible()) << peer_.Output();
}

void ModuleProcess::StartWorld(const std::string& scene) {
  const std::string file = peer_.folder() / "scene.toml";
  std::ofstream(file) << scene;
  world_.emplace(
      exec::Child::Start({{BinDir() + "/musher-world", file, "--alone"}, peer_.folder().path(), {}},
                         peer_.reaper())
          .value());
}

void ModuleProcess::ExpectDone(const State& state) {
  const auto done = peer_.Switch(state);
  ASSERT_TRUE(done) << state;
  EXPECT_EQ(done.value().verdict, msg::ActuatorCommand::kVerdictDone)
      << state << ": " << done.value().message << peer_.Output();
}

std::string ModuleProcess::Failure(const State& state) {
  const auto done = peer_.Switch(state);
  if (!done) return "no answer";
  EXPECT_EQ(done.value().verdict, msg::ActuatorCommand::kVerdictFailed);
  return std::to_string(done.value().code) + " " + done.value().message;
}

void ModuleProcess::ExpectTornDown() {
  ExpectDone(kTearDown);
  EXPECT_EQ(peer_.AwaitExit(), 0) << peer_.Output();
}

void ModuleProcess::ExpectRefused(const std::string& file, const std::string& sentence) {
  peer_.Start(file);
  EXPECT_EQ(peer_.AwaitExit(), 2);
  EXPECT_THAT(peer_.Output(), ::testing::HasSubstr(sentence));
}

bool ModuleProcess::AwaitOutput(const std::string& text) {
  return peer_.Until([&] { return peer_.Output().find(text) != std::string::npos; });
}

exec::Child ModuleProcess::Launch(std::vector<std::string> words) {
  words.front() = BinDir() + "/" + words.front();
  const UniqueFd output(
      open((peer_.folder() / "said").c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600));
  return exec::Child::Start({words, peer_.folder().path(), {}}, peer_.reaper(), output.get())
      .value();
}

int ModuleProcess::Await(exec::Child& program) {
  bool ended = false;
  const auto watch = peer_.node().loop().WhenReadable(program.pidfd(), [&ended] { ended = true; });
  EXPECT_TRUE(peer_.Until([&ended] { return ended; })) << Said();
  const ExitStatus status = program.Reap();
  return status.killed ? -status.number : status.number;
}

int ModuleProcess::Run(std::vector<std::string> words) {
  exec::Child program = Launch(std::move(words));
  return Await(program);
}

std::string ModuleProcess::Said() const {
  std::ifstream stream(peer_.folder() / "said");
  return {std::istreambuf_iterator<char>(stream), {}};
}

}  // namespace musher::test
