// musher complete WORD...: prints the completions of the last word, one per line, with its meaning
// after a tab; ":files", ":folders", ":configs" (.toml) and ":trees" (.xml) make the shell complete
// file names. The scripts of `musher completion` call it. It answers soon and reports no errors.

#include <algorithm>
#include <filesystem>
#include <map>
#include <memory>
#include <vector>

#include "musher/base/host.hpp"
#include "musher/cli/commands/complete.hpp"
#include "musher/cli/machine/behavior_request.hpp"
#include "musher/cli/machine/link.hpp"
#include "musher/cli/machine/skill_choice.hpp"
#include "musher/cli/machine/skill_offers.hpp"
#include "musher/cli/machine/topics.hpp"
#include "musher/lifecycle/config/config_toml.hpp"
#include "musher/lifecycle/state.hpp"
#include "musher/messages/musher_msgs/behavior.hpp"
#include "musher/messages/musher_msgs/capabilities.hpp"
#include "musher/messages/musher_msgs/tree.hpp"
#include "musher/transport/dds/dds_node.hpp"

namespace musher::cli {
namespace {

using Words = std::vector<std::string>;

// A controller of this host is discovered in some 10 ms and answers at once.
constexpr Duration kFind = Milliseconds(500);
constexpr Duration kFindElsewhere = Milliseconds(200);
constexpr Duration kFindApplications = Milliseconds(300);

// The states without SetUp and Uninitialized, which cannot be commanded.
Words Commandable(const std::vector<std::string_view>& states) {
  Words words;
  for (const std::string_view state : states) {
    if (state != kUninitialized && state != kSetUp) words.emplace_back(state);
  }
  return words;
}

Words Of(const MachineConfig& config, Names names) {
  Words words;
  if (names == Names::kStates) return Commandable({config.states.begin(), config.states.end()});
  if (names == Names::kCapabilities) {
    words.reserve(config.capabilities.size());
    for (const CapabilityConfig& capability : config.capabilities) words.push_back(capability.name);
  } else {
    words.reserve(config.actuators.size());
    for (const ActuatorConfig& actuator : config.actuators) words.push_back(actuator.name);
  }
  return words;
}

template <msg::Service S>
std::unique_ptr<transport::Client<S>> ClientOf(Link& link, const std::string& name) {
  auto client = transport::MakeClient<S>(link.node(), name);
  return client ? std::move(client).value() : nullptr;
}

// The actuators that offer a state machine or a tree, as `names` says.
Words Applications(Link& link, const std::string& name_space, const Words& actuators, Names names) {
  struct Clients {
    std::unique_ptr<transport::Client<msg::GetBehavior>> behavior;
    std::unique_ptr<transport::Client<msg::GetTree>> tree;

    bool Ready() const {
      return (behavior != nullptr && behavior->Ready()) || (tree != nullptr && tree->Ready());
    }
  };
  std::vector<Clients> all;
  all.reserve(actuators.size());
  for (const std::string& name : actuators) {
    const std::string full = transport::ResolveName(name_space, name);
    Clients one;
    if (names != Names::kTrees) {
      one.behavior = ClientOf<msg::GetBehavior>(link, full + "/get_behavior");
    }
    if (names != Names::kStateMachines) {
      one.tree = ClientOf<msg::GetTree>(link, full + "/get_tree");
    }
    all.push_back(std::move(one));
  }
  const auto ready = [](const Clients& one) { return one.Ready(); };
  link.RunUntil([&] { return std::all_of(all.begin(), all.end(), ready); }, kFindApplications);
  Words applications;
  for (std::size_t i = 0; i < actuators.size(); ++i) {
    if (all[i].Ready()) applications.push_back(actuators[i]);
  }
  return applications;
}

Words Capabilities(Link& link) {
  Words words;
  const auto answer = link.Call<msg::GetCapabilities>("get_capabilities", {}, kFind);
  if (const auto* all = std::get_if<msg::GetCapabilities::Response>(&answer)) {
    words.reserve(all->capabilities.size());
    for (const msg::Capability& capability : all->capabilities) words.push_back(capability.name);
  }
  return words;
}

Words Commands(const CompleteOptions& options, GlobalOptions global) {
  if (options.application.empty()) return {};
  global.timeout = kFind;
  const auto link = Link::OpenAtOnce(global);
  if (!link) return {};
  const auto answer = QueryBehavior(*link.value(), global, options.application, {"", 0});
  const auto* report = std::get_if<msg::GetBehavior::Response>(&answer);
  return report == nullptr ? Words{} : report->commands;
}

Words RunningHere(const std::string& name_space) {
  const auto domain = transport::DomainId({});
  if (!domain) return {};
  return NameLock::HeldBelow(NameLock::NameOf(domain.value(), name_space, ""));
}

bool IsApplication(Names names) {
  return names == Names::kApplications || names == Names::kStateMachines || names == Names::kTrees;
}

// nullopt: it is not discovered in time.
std::optional<msg::MachineStatus> StatusOfMachine(Link& link) {
  if (link.CallsHere()) {
    const auto answer = link.Call<msg::GetStatus>("get_status", {}, kFind);
    const auto* reply = std::get_if<msg::GetStatus::Response>(&answer);
    return reply == nullptr ? std::nullopt : std::optional(reply->status);
  }
  link.Choose();
  if (!link.FollowStatus({})) return std::nullopt;
  link.RunUntil([&] { return link.status().has_value(); },
                link.LeaderHere() != 0 ? kFind : kFindElsewhere);
  return link.status();
}

// The names of the running machine.
Words OfMachine(const GlobalOptions& global, Names names) {
  const auto link = Link::OpenForCalls(global);
  const auto status = StatusOfMachine(*link);
  Words actuators = RunningHere(global.name_space);  // without a controller
  if (status) {
    actuators.clear();
    actuators.reserve(status->actuators.size());
    for (const auto& actuator : status->actuators) actuators.push_back(actuator.name);
  }
  if (names == Names::kActuators) return actuators;
  if (IsApplication(names)) {
    if (!link->Join()) return {};
    return Applications(*link, global.name_space, actuators, names);
  }
  if (!status) return {};
  if (names == Names::kCapabilities) return Capabilities(*link);
  if (status->host != HostId()) return {};
  const auto config = ReadConfigFile(status->config_file).config;
  return config ? Of(*config, names) : Words{};
}

// The skills that are offered, their actuators, or the keys of the skill on the line.
std::vector<CompleteOptions::Word> SkillWords(const CompleteOptions& options,
                                              const GlobalOptions& global) {
  const auto link = Link::OpenAtOnce(global);
  if (!link) return {};
  const auto offers = SkillOffers::Begin(*link.value(), global);
  if (!offers) return {};
  offers.value()->AwaitAny(kFind);
  std::map<std::string, std::string> words;
  for (const msg::SkillOffers& of : offers.value()->all()) {
    if (options.names == Names::kSkillActuators) words[of.actuator] = "";
    for (const msg::SkillOffer& offer : of.skills) {
      if (options.names == Names::kSkills) words[offer.skill] = offer.summary;
      if (options.names != Names::kSkillKeys || offer.skill != options.skill) continue;
      for (const std::string& declared : offer.parameters) {
        const std::string key = ParameterName(declared);
        words[key + "="] = declared.substr(std::min(key.size() + 2, declared.size()));
      }
    }
  }
  std::vector<CompleteOptions::Word> all;
  all.reserve(words.size());
  for (const auto& [text, meaning] : words) all.push_back({text, meaning});
  return all;
}

// With their types.
std::vector<CompleteOptions::Word> TopicWords(const GlobalOptions& global) {
  const auto link = Link::OpenAtOnce(global);
  if (!link) return {};
  const auto topics = Topics::Begin(*link.value());
  if (!topics) return {};
  topics.value()->AwaitAll(kFind);
  std::vector<CompleteOptions::Word> words;
  for (const view::ListedTopic& topic : topics.value()->table().List()) {
    words.push_back({topic.name, topic.type});
  }
  return words;
}

Words NamesFor(const CompleteOptions& options, const GlobalOptions& global) {
  if (options.names == Names::kCommands) return Commands(options, global);
  std::error_code error;  // reading a FIFO would block
  if (std::filesystem::is_regular_file(options.config, error)) {
    const ConfigReading reading = ReadConfigFile(options.config);
    const auto& read = reading.config ? reading.config : reading.faulty;
    if (read) return Of(*read, options.names);
  }
  Words words = OfMachine(global, options.names);
  const bool none = words.empty() && options.names == Names::kStates;
  return none ? Commandable({BuiltInStates().begin(), BuiltInStates().end()}) : words;
}

}  // namespace

ExitCode Complete(const CompleteOptions& options, const GlobalOptions& global, Console& console) {
  std::vector<CompleteOptions::Word> words = options.words;
  switch (options.names) {
    case Names::kNone:
      break;
    case Names::kConfigs:
      console.Print(":configs");
      break;
    case Names::kDrawings:
      console.Print(":configs");
      console.Print(":trees");
      break;
    case Names::kTreeFiles:
      console.Print(":trees");
      break;
    case Names::kFiles:
      console.Print(":files");
      break;
    case Names::kFolders:
      console.Print(":folders");
      break;
    case Names::kTopics:
      for (CompleteOptions::Word& word : TopicWords(global)) words.push_back(std::move(word));
      break;
    case Names::kSkills:
    case Names::kSkillKeys:
    case Names::kSkillActuators:
      for (CompleteOptions::Word& word : SkillWords(options, global)) {
        words.push_back(std::move(word));
      }
      break;
    default:
      for (std::string& word : NamesFor(options, global)) words.push_back({std::move(word), ""});
  }
  for (const CompleteOptions::Word& word : words) {
    if (!word.text.starts_with(options.begin)) continue;
    console.Print(options.prefix + word.text + "\t" + Printable(word.meaning));
  }
  return ExitCode::kDone;
}

}  // namespace musher::cli
