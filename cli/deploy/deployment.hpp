#pragma once
// Copies a version to all hosts of a plan and switches them to it: all of them, or none.
//
//   look ─▶ send ─▶ stage ─▶ switch ─▶ done
//     │       │       │         └──▶ undo, where one has failed
//     └───────┴───────┴──▶ end, every host runs what it ran
//
// Each step is taken on all hosts that need it before the next one: a host that has staged the same
// files is only switched, and one that runs them is left as it is, and is not switched back either.
// So a deployment that was cut at any point is repeated, also for a host whose disk is new. Every
// wait has an end. A switch that was begun is not interrupted.
//
// Threads: any; blocks.

#include <functional>
#include <set>
#include <string>
#include <vector>

#include "musher/cli/deploy/deploy_plan.hpp"
#include "musher/ota/install.hpp"

namespace musher::cli {

struct DeployOptions {
  std::string robot;  // name in the bundles
  ota::Version version;
  std::string private_pem;
  std::string public_pem;  // for a host without a root
  std::string created;
  ota::InstallOptions install;
  int interrupt = -1;  // descriptor that is readable once it is to end; -1: none
};

struct DeployOutcome {
  std::vector<std::string> troubles;  // each with its host; empty: all hosts have the version
  bool unknown = false;               // one may have it, with troubles
  bool interrupted = false;           // before the switch, with troubles
  std::set<std::string> had = {};     // hosts that ran this version, with these files, before
};
// `progress` is called with each step.
DeployOutcome Deploy(const DeployPlan& plan, const DeployOptions& options,
                     const std::function<void(const std::string&)>& progress);

}  // namespace musher::cli
