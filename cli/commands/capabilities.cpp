// musher capabilities [NAME]: what the robot can do now, and why not the rest.

#include <CLI/CLI.hpp>
#include <algorithm>

#include "musher/base/suggest.hpp"
#include "musher/cli/commands/commands.hpp"
#include "musher/cli/grammar/grammar.hpp"
#include "musher/cli/machine/link.hpp"
#include "musher/cli/render/json.hpp"
#include "musher/cli/render/text.hpp"

namespace musher::cli {
namespace {

struct CapabilitiesOptions {
  std::string name;  // empty: all
};

Failure Unknown(const std::string& name, const msg::Capabilities& known) {
  std::vector<std::string> names;
  for (const msg::Capability& capability : known.capabilities) names.push_back(capability.name);
  const bool near = !Nearest(name, names).empty();
  return {ExitCode::kNotDone,
          {kCodeParametersInvalid,
           NoSuch("capability", name, names) +
               (near ? "" : "; a function that the config does not declare runs in Active only")}};
}

ExitCode Capabilities(const CapabilitiesOptions& options, const GlobalOptions& global,
                      Console& console) {
  const auto link = Link::OpenForCalls(global, &console);
  const auto answer =
      link->Call<msg::GetCapabilities>("get_capabilities", {}, std::chrono::seconds(5));
  if (const auto* failure = std::get_if<Failure>(&answer)) return console.Fail(*failure);
  const msg::Capabilities all{std::get<msg::GetCapabilities::Response>(answer).capabilities};
  const bool colour = console.mode().colour;
  if (options.name.empty()) {
    console.Print(console.mode().json ? CapabilitiesJson(all) : CapabilitiesText(all, colour));
    return ExitCode::kDone;
  }
  const auto one = std::find_if(all.capabilities.begin(), all.capabilities.end(),
                                [&](const auto& c) { return c.name == options.name; });
  if (one == all.capabilities.end()) return console.Fail(Unknown(options.name, all));
  console.Print(console.mode().json ? CapabilityJson(*one) : CapabilityText(*one, colour));
  return one->allowed ? ExitCode::kDone : ExitCode::kNotDone;
}

}  // namespace

void AddCapabilities(Grammar& grammar) {
  auto [app, options] = grammar.Add("capabilities", "Show what the robot can do now, and why not",
                                    Capabilities, "musher capabilities back_flip");
  grammar
      .Offer(app.add_option("NAME", options.name, "Only this one; exit code 1 if it is refused"),
             Names::kCapabilities)
      ->type_name("");
}

}  // namespace musher::cli
