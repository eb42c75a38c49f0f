#include <fmt/format.h>

#include "musher/base/code.hpp"
#include "musher/base/joined.hpp"
#include "musher/cli/console/printable.hpp"
#include "musher/cli/console/table.hpp"
#include "musher/cli/render/text.hpp"

namespace musher::cli {
namespace {

std::string WhyNot(const msg::Capability& capability) {
  if (capability.allowed) return capability.reason;
  return WithCode(capability.reason, capability.code);
}

Table::Cell Verdict(const msg::Capability& capability) {
  return capability.allowed ? Table::Cell{"yes", Style::kGood} : Table::Cell{"no", Style::kBad};
}

}  // namespace

std::string CapabilitiesText(const msg::Capabilities& all, bool colour) {
  const msg::Capabilities shown = Printable(all);
  if (shown.capabilities.empty()) return "the config declares no capabilities\n";
  Table table({"CAPABILITY", "ALLOWED", "RUNS IN", "REASON"});
  for (const msg::Capability& capability : shown.capabilities) {
    table.Add({{capability.name},
               Verdict(capability),
               {Joined(capability.states)},
               {WhyNot(capability), capability.allowed ? Style::kBusy : Style::kDim}});
  }
  return table.Text(colour);
}

std::string CapabilityText(const msg::Capability& one, bool colour) {
  const msg::Capability shown = Printable(one);
  const Table::Cell verdict = Verdict(shown);
  std::string text = Paint(shown.name, Style::kBold, colour) + "  " +
                     Paint(shown.allowed ? "allowed" : "refused", verdict.style, colour);
  if (const std::string why = WhyNot(shown); !why.empty()) text += ": " + why;
  text += '\n';
  if (!shown.description.empty()) text += "  " + shown.description + '\n';
  return text + "  actuators: " + Joined(shown.actuators) + "; runs in: " + Joined(shown.states) +
         '\n';
}

}  // namespace musher::cli
