#include "musher/test/fault_injection/host/far_host.hpp"

#include <signal.h>

#include <fstream>
#include <string>

#include "musher/test/fault_injection/robot/processes.hpp"

namespace musher::fault_injection {

FarHost::FarHost(const std::filesystem::path& folder,
                 const benchmark::Child::Environment& environment)
    : go_(folder / "go"),
      host_({benchmark::Program("fault_injection_host"), folder}, environment,
            benchmark::Child::Output::kPiped) {
  host_.AwaitOutput();
  init_ = ChildrenOf(host_.pid()).at(0);
  link_ = std::make_unique<Link>(init_);
}

void FarHost::Reboot() {
  kill(init_, SIGUSR1);
}

std::vector<std::string> FarHost::There(const std::vector<std::string>& words) const {
  std::vector<std::string> command = {
      "/usr/bin/nsenter", "-t", std::to_string(init_), "-n", "-p", "-m", "-r", "-w", "--"};
  command.insert(command.end(), words.begin(), words.end());
  return command;
}

void FarHost::Go() {
  std::ofstream{go_};
}

}  // namespace musher::fault_injection
