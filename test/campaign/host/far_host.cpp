#include "musher/test/campaign/host/far_host.hpp"

#include <fstream>

#include "musher/test/campaign/robot/processes.hpp"

namespace musher::campaign {

FarHost::FarHost(const std::filesystem::path& folder,
                 const benchmark::Child::Environment& environment)
    : go_(folder / "go"),
      host_({benchmark::Program("campaign_host"), folder}, environment,
            benchmark::Child::Output::kPiped) {
  host_.AwaitOutput();
  cable_ = std::make_unique<Cable>(ChildrenOf(host_.pid()).at(0));
}

void FarHost::Go() {
  std::ofstream{go_};
}

}  // namespace musher::campaign
