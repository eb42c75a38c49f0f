#include "musher/controller/shell/switch_log.hpp"

#include <nlohmann/json.hpp>

namespace musher {
namespace {

using Json = nlohmann::json;

// The text of a key; empty where there is none. Journals are read as they are found.
std::string TextOf(const Json& json, const char* key) {
  const auto found = json.find(key);
  return found != json.end() && found->is_string() ? found->get<std::string>() : std::string();
}

}  // namespace

msg::GetSwitch::Response FindSwitch(const std::vector<JournalEntry>& entries, Epoch epoch,
                                    CommandNumber number) {
  msg::GetSwitch::Response response;
  response.epoch = epoch.value();
  response.switch_number = number.value();
  bool begun = false;          // a switch of that number, by the controller that is looked at
  bool of_that_epoch = false;  // it began, or ended, in that epoch, which may rise meanwhile
  for (const JournalEntry& entry : entries) {
    if (number == 0 && entry.epoch == epoch && !begun) response.found = true;
    const bool relevant = entry.kind == "switch" && entry.switch_number != 0 &&
                          entry.epoch <= epoch && entry.data.starts_with('{');
    if (!relevant || (number != 0 && entry.switch_number != number)) continue;
    const Json json = Json::parse(entry.data, nullptr, false);
    if (!json.is_object() || !json.contains("target")) continue;
    const std::string outcome = TextOf(json, "outcome");
    const bool begins = outcome.empty();
    if (begins) {
      if (entry.epoch != epoch && number == 0) continue;
      begun = true;
      of_that_epoch = entry.epoch == epoch;
      response.switch_number = entry.switch_number.value();
      response.outcome.clear();
      response.reason.clear();
    } else if (begun ? entry.switch_number != CommandNumber(response.switch_number)
                     : number == 0 || entry.epoch != epoch) {
      continue;
    }
    of_that_epoch |= entry.epoch == epoch;
    response.target = TextOf(json, "target");
    response.actuator = entry.actuator;
    response.outcome = outcome;
    response.code = entry.code;
    if (!begins && entry.code != kCodeOk) response.reason = entry.message;
    response.state = TextOf(json, "state");
    response.found = of_that_epoch;
  }
  return response;
}

}  // namespace musher
