#include "musher/test/fault_injection/options.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <map>

#include "musher/base/suggest.hpp"

namespace musher::fault_injection {
namespace {

constexpr int kMaxFaults = 100'000;

bool Matches(const Kind& kind, const std::string& word) {
  return kind.name == word || kind.family == word;
}

Usage Unknown(const std::string& word) {
  std::vector<std::string> names;
  std::string list;
  for (const Kind& kind : AllKinds()) {
    names.push_back(kind.name);
    list += (list.empty() ? "" : ", ") + kind.name;
  }
  for (const Kind& kind : AllKinds()) names.push_back(kind.family);
  const std::string near = Nearest(word, names);
  return {"unknown kind '" + word + "'" + (near.empty() ? "" : "; did you mean '" + near + "'?") +
          "\nkinds: " + list};
}

// Why a kind cannot run here; "": it can.
std::string MissingRequirement(const Kind& kind, const Isolation& isolation) {
  if (kind.need == Need::kNetwork) return isolation.no_network;
  if (kind.need == Need::kMounts) return isolation.no_mounts;
  return "";
}

}  // namespace

Options ReadOptions(int argc, char** argv) {
  Options options;
  CLI::App app("Injects faults into a robot of real processes and checks what follows");
  app.add_option("--faults", options.faults, "how many faults")
      ->check(CLI::Range(1, kMaxFaults))
      ->capture_default_str();
  app.add_option("--seed", options.seed,
                 "of the random generator: the same seed gives the same faults")
      ->capture_default_str();
  app.add_option("--report", options.report, "folder for report.md, .json, .svg and failed/")
      ->capture_default_str();
  app.add_option("--only", options.only, "only this kind or family of kinds; may be repeated")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  app.add_flag("--list", options.list, "prints the kinds");
  try {
    app.parse(argc, argv);
  } catch (const CLI::CallForHelp& help) {
    std::exit(app.exit(help));
  } catch (const CLI::ParseError& error) {
    throw Usage{error.what()};
  }
  for (const std::string& word : options.only) {
    const bool known = std::any_of(AllKinds().begin(), AllKinds().end(),
                                   [&](const Kind& kind) { return Matches(kind, word); });
    if (!known) throw Unknown(word);
  }
  return options;
}

int List() {
  std::string family;
  for (const Kind& kind : AllKinds()) {
    if (kind.family != family) std::printf("%s\n", kind.family.c_str());
    family = kind.family;
    std::printf("  %-24s %s\n", kind.name.c_str(), kind.about.c_str());
  }
  return EXIT_SUCCESS;
}

Selection Select(const Options& options, const Isolation& isolation) {
  Selection selection;
  std::map<std::string, std::string> skipped;  // names by reason
  for (const Kind& kind : AllKinds()) {
    const auto meant = [&](const std::string& word) { return Matches(kind, word); };
    const auto by_name = [&](const std::string& word) { return kind.name == word; };
    const auto& only = options.only;
    const bool named = std::any_of(only.begin(), only.end(), by_name);
    if (!only.empty() && !std::any_of(only.begin(), only.end(), meant)) continue;
    const std::string blocker = MissingRequirement(kind, isolation);
    if (blocker.empty()) {
      selection.kinds.push_back(&kind);
      continue;
    }
    if (named) {
      throw Usage{kind.name + " cannot run here: " + blocker};
    }
    std::string& names = skipped[blocker];
    names += (names.empty() ? "" : ", ") + kind.name;
  }
  for (const auto& [blocker, names] : skipped) {
    selection.skipped.push_back("skipped (" + blocker + "): " + names);
  }
  return selection;
}

}  // namespace musher::fault_injection
