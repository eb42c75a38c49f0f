#include "musher/ota/slots.hpp"

#include <cstdio>

#include "musher/base/checksum.hpp"
#include "musher/base/toml/document.hpp"
#include "musher/ota/fault.hpp"

namespace musher::ota {
namespace {

using config_toml::Table;

constexpr std::string_view kChecksum = "# checksum ";

std::string ChecksumLine(std::string_view text) {
  char hex[17];
  std::snprintf(hex, sizeof hex, "%016llx", static_cast<unsigned long long>(Fnv1a(text)));
  return std::string(kChecksum) + hex + "\n";
}

// Quotes a text for one line with single quotation marks.
std::string Literal(std::string text) {
  for (char& c : text) {
    if (c == '\'') c = '"';
    if (static_cast<unsigned char>(c) < 0x20U || c == 0x7f) c = ' ';
  }
  return "'" + text + "'";
}

std::string Text(const Table& table, std::string_view key) {
  const auto* member = Find(table, key);
  const auto* text = member == nullptr ? nullptr : member->value.As<std::string>();
  return text == nullptr ? "" : *text;
}

bool Flag(const Table& table, std::string_view key) {
  const auto* member = Find(table, key);
  const auto* flag = member == nullptr ? nullptr : member->value.As<bool>();
  return flag != nullptr && *flag;
}

std::string Name(Slot slot) {
  return "slot " + std::string(SlotName(slot));
}

// Without a state: the target of the link, which was confirmed last. Without a link the older
// version, since the newer one may never have been trial-booted.
Result<Boot> DecideWithoutState(std::optional<Slot> link, const LookIntoSlot& look) {
  const SlotContent a = look(Slot::kA);
  const SlotContent b = look(Slot::kB);
  if (!a && !b) {
    return FaultError(Fault::kNoVersion, "no version can be started. Slot a: " + a.error().message +
                                             ". Slot b: " + b.error().message);
  }
  const bool a_is_older = a && b && std::is_lteq(Compare(a.value(), b.value()));
  Slot start = a_is_older || !b ? Slot::kA : Slot::kB;
  if (a && b && link) start = *link;
  const SlotContent& content = start == Slot::kA ? a : b;
  Boot boot{start, false, content.value(), {start, false, false, false, {}}, ""};
  boot.reason =
      "the state of the slots is lost; starting " + Name(start) + ", version " + boot.version.text;
  return boot;
}

}  // namespace

std::string_view SlotName(Slot slot) {
  return slot == Slot::kA ? "a" : "b";
}

std::optional<Slot> SlotOf(std::string_view name) {
  if (name == "a") return Slot::kA;
  if (name == "b") return Slot::kB;
  return std::nullopt;
}

std::string FormatState(const SlotState& state) {
  const auto flag = [](bool value) { return value ? "true\n" : "false\n"; };
  std::string text = "# Which version the robot starts. Written by musher.\nconfirmed = \"" +
                     std::string(SlotName(state.confirmed)) + "\"\n";
  text += std::string("on_trial_boot = ") + flag(state.on_trial_boot);
  text += std::string("started = ") + flag(state.started);
  text += std::string("other_good = ") + flag(state.other_good);
  if (state.taking_down) text += "taking_down = true\n";
  if (!state.installing.empty()) text += "installing = " + Literal(state.installing) + "\n";
  if (state.last) {
    text += "\n[last]\nslot = \"" + std::string(SlotName(state.last->slot)) +
            "\"\nversion = " + Literal(state.last->version) + "\nkept = " + flag(state.last->kept) +
            "reason = " + Literal(state.last->reason) + "\n";
  }
  return text + ChecksumLine(text);
}

std::optional<SlotState> ParseState(std::string_view text) {
  const std::size_t end = text.rfind(kChecksum);
  if (end == std::string_view::npos || text.substr(end) != ChecksumLine(text.substr(0, end))) {
    return std::nullopt;
  }
  const auto document = config_toml::ParseDocument(text);
  const auto* table = std::get_if<Table>(&document);
  const auto confirmed = table == nullptr ? std::nullopt : SlotOf(Text(*table, "confirmed"));
  if (!confirmed) return std::nullopt;
  SlotState state{*confirmed,
                  Flag(*table, "on_trial_boot"),
                  Flag(*table, "started"),
                  Flag(*table, "other_good"),
                  std::nullopt,
                  Text(*table, "installing"),
                  Flag(*table, "taking_down")};
  const auto* last = Find(*table, "last");
  if (const auto* end_of_trial_boot = last == nullptr ? nullptr : last->value.As<Table>()) {
    state.last = TrialBootEnd{SlotOf(Text(*end_of_trial_boot, "slot")).value_or(*confirmed),
                              Text(*end_of_trial_boot, "version"), Flag(*end_of_trial_boot, "kept"),
                              Text(*end_of_trial_boot, "reason")};
  }
  return state;
}

namespace {

// The start of a machine of which nothing runs.
Result<Boot> DecideDue(const std::optional<SlotState>& state, std::optional<Slot> link,
                       const LookIntoSlot& look) {
  if (!state) return DecideWithoutState(link, look);
  SlotState next = *state;
  next.taking_down = false;
  std::string reason;
  const Slot other = Other(state->confirmed);
  std::optional<SlotContent> tried;  // the other slot, once it was looked into
  if (state->on_trial_boot) {
    tried = look(other);
    if (*tried && !state->started) {
      next.started = true;
      return Boot{other, true, tried->value(), next,
                  "trial boot of " + Name(other) + ", version " + tried->value().text};
    }
    const std::string version = *tried ? tried->value().text : "";
    const std::string why = *tried ? "its trial boot did not finish" : tried->error().message;
    next = AfterTrialBoot(next, version, Error{kCodeFailed, why});
    reason = "rolled back to " + Name(state->confirmed) + "; the version in " + Name(other) +
             " failed: " + why;
  }
  const SlotContent confirmed = look(state->confirmed);
  if (confirmed) return Boot{state->confirmed, false, confirmed.value(), next, reason};
  if (!tried) tried = look(other);
  if (!*tried) {
    return FaultError(Fault::kNoVersion, "no version can be started. " + Name(state->confirmed) +
                                             ": " + confirmed.error().message + ". " + Name(other) +
                                             ": " + tried->error().message);
  }
  next = SlotState{other, false, false, false, next.last};
  return Boot{other, false, tried->value(), next,
              Name(state->confirmed) + " is damaged (" + confirmed.error().message + "); " +
                  "starting " + Name(other) + ", version " + tried->value().text};
}

}  // namespace

Result<Boot> DecideBoot(const std::optional<SlotState>& state, std::optional<Slot> link,
                        const LookIntoSlot& look, std::optional<Slot> running) {
  auto due = DecideDue(state, link, look);
  if (!due || !running || due.value().start == *running) return due;
  if (state && state->taking_down) return due;
  const SlotContent content = look(*running);
  if (!content) return due;  // a version that was altered is not started
  const std::string from = "actuators run from " + Name(*running);
  if (due.value().on_trial_boot) {
    return Boot{*running, false, content.value(), *state,
                "the " + due.value().reason + ", waits: " + from +
                    "; it begins with the next start after `musher down`"};
  }
  return Boot{*running,
              false,
              content.value(),
              state ? *state : due.value().next,
              from + ", which is not due: the machine is taken down, and starts from " +
                  Name(due.value().start),
              true};
}

SlotState AfterTrialBoot(const SlotState& state, const std::string& version,
                         const Result<>& outcome) {
  const Slot tried = Other(state.confirmed);
  SlotState next;
  next.confirmed = outcome ? tried : state.confirmed;
  next.other_good = outcome.ok();
  next.last = TrialBootEnd{tried, version, outcome.ok(), outcome ? "" : outcome.error().message};
  return next;
}

}  // namespace musher::ota
