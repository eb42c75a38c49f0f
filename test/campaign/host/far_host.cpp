#include "musher/test/campaign/host/far_host.hpp"

#include <signal.h>

#include <fstream>
#include <string>

#include "musher/test/campaign/robot/processes.hpp"

namespace musher::campaign {

FarHost::FarHost(const std::filesystem::path& folder,
                 const benchmark::Child::Environment& environment)
    : go_(folder / "go"),
      host_({benchmark::Program("campaign_host"), folder}, environment,
            benchmark::Child::Output::kPiped) {
  host_.AwaitOutput();
  init_ = ChildrenOf(host_.pid()).at(0);
  cable_ = std::make_unique<Cable>(init_);
}

void FarHost::Reboot() {
  kill(init_, SIGUSR1);
}

std::vector<std::string> FarHost::There(const std::vector<std::string>& words) const {
  std::vector<std::string> command = {
      "/usr/bin/nsenter", "-t", std::to_string(init_), "-n", "-p", "-m", "--"};
  command.insert(command.end(), words.begin(), words.end());
  return command;
}

void FarHost::Go() {
  std::ofstream{go_};
}

}  // namespace musher::campaign
