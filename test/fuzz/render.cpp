// The command line's output for untrusted messages: a valid line of JSON, and a text without
// control characters for the terminal.

#include <nlohmann/json.hpp>
#include <sstream>

#include "musher/cli/machine/why.hpp"
#include "musher/cli/render/json.hpp"
#include "musher/cli/render/log_lines.hpp"
#include "musher/cli/render/skill.hpp"
#include "musher/cli/render/text.hpp"
#include "musher/cli/render/tree.hpp"
#include "musher/test/fuzz/fuzz.hpp"

namespace musher::cli {
namespace {

using fuzz::Require;

void RequireJson(const std::string& text) {
  Require(nlohmann::json::accept(text), "the JSON is valid");
  Require(text.find('\n') == std::string::npos, "a document is on one line");
}

void RequirePrintable(const std::string& text) {
  for (const char c : text) {
    const bool control = (static_cast<unsigned char>(c) < ' ' && c != '\n') || c == 0x7f;
    Require(!control, "a text has no control characters: " + std::to_string(int{c}));
  }
}

template <class M>
std::optional<M> Take(std::span<const std::byte> bytes) {
  return msg::Decode<M>(bytes);
}

void Render(std::uint8_t kind, std::span<const std::byte> bytes) {
  switch (kind % 10) {
    case 0:
      if (const auto status = Take<msg::MachineStatus>(bytes)) {
        RequireJson(StatusJson(*status));
        RequireJson(ReleaseJson(*status));
        RequirePrintable(StatusText(*status, false));
        RequirePrintable(StatusLine(*status, 0));
        RequirePrintable(ReleaseText(*status, false));
      }
      return;
    case 1:
      if (const auto result = Take<msg::SetState::Response>(bytes)) {
        RequireJson(SwitchJson(*result));
        RequirePrintable(SwitchText(*result, false));
      }
      return;
    case 2:
      if (const auto plan = Take<msg::GetPlan::Response>(bytes)) {
        RequireJson(PlanJson(*plan));
        RequirePrintable(PlanText(*plan, false));
      }
      return;
    case 3:
      if (const auto history = Take<msg::GetHistory::Response>(bytes)) {
        RequireJson(HistoryJson(*history));
        RequirePrintable(HistoryText(history->entries, false));
        if (const auto why = FindWhy(*history, {State("Active")})) {
          RequireJson(WhyJson(why.value()));
          RequirePrintable(WhyText(why.value(), false));
        }
      }
      return;
    case 4:
      if (const auto capabilities = Take<msg::Capabilities>(bytes)) {
        RequireJson(CapabilitiesJson(*capabilities));
        RequirePrintable(CapabilitiesText(*capabilities, false));
        for (const msg::Capability& one : capabilities->capabilities) {
          RequireJson(CapabilityJson(one));
          RequirePrintable(CapabilityText(one, false));
        }
      }
      return;
    case 5:
      if (const auto offers = Take<msg::SkillOffers>(bytes)) {
        RequireJson(SkillsJson({*offers}));
        RequirePrintable(SkillsText({*offers}, true, false));
      }
      return;
    case 6:
      if (const auto feedback = Take<msg::SkillFeedback>(bytes)) {
        const SkillReport report = ReadSkillReport(feedback->message);
        RequireJson(SkillFeedbackJson(*feedback, 0));
        RequirePrintable(SkillFeedbackLine(*feedback, 0, false));
        RequirePrintable(SkillReportLine(report));
        RequirePrintable(SkillProgressText(feedback->skill, report, 0, false));
      }
      return;
    case 7:
      if (const auto report = Take<msg::GetTree::Response>(bytes)) {
        RequireJson(TreeJson("a", *report));
        RequirePrintable(TreeText("a", *report, false));
        RequirePrintable(TreeLines(*report, 0, false));
        RequirePrintable(TreeDot("a", *report));
        RequirePrintable(TreeMermaid(*report));
      }
      return;
    case 9: {
      LogLines log("legs");
      std::istringstream text(
          std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
      for (std::string line; std::getline(text, line);) {
        const LogEntry entry = log.Take({line});
        RequireJson(LogJson(entry));
        RequirePrintable(LogText(entry, 6, false));
      }
      return;
    }
    default:
      if (const auto progress = Take<Progress>(bytes)) {
        RequireJson(ProgressJson(*progress));
        RequirePrintable(ProgressText(*progress, false));
      }
  }
}

}  // namespace
}  // namespace musher::cli

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  musher::cli::Render(data[0], std::as_bytes(std::span(data + 1, size - 1)));
  return 0;
}
