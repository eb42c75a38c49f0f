// The JSON documents of `musher ota`.

#include <nlohmann/json.hpp>

#include "musher/cli/console/json_line.hpp"
#include "musher/cli/render/json.hpp"

namespace musher::cli {

std::string OtaStepJson(const std::string& step, std::uint64_t bytes) {
  return JsonLine({{"step", step}, {"bytes", bytes}});
}

std::string OtaResultJson(const std::string& version, const std::string& outcome,
                          const std::string& reason) {
  return JsonLine({{"version", version}, {"outcome", outcome}, {"reason", reason}});
}

std::string OtaKeysJson(const std::string& secret, const std::string& open) {
  return JsonLine({{"private_key", secret}, {"public_key", open}});
}

std::string OtaBundleJson(const ota::Manifest& manifest, const std::string& where) {
  return JsonLine({{"folder", where},
                   {"robot", manifest.robot},
                   {"version", manifest.version.text},
                   {"created", manifest.created},
                   {"files", manifest.files.size()},
                   {"bytes", manifest.SizeBytes()}});
}

std::string OtaStatusJson(const OtaRobot& robot) {
  OrderedJson slots = OrderedJson::object();
  for (const OtaRobot::SlotInfo& slot : robot.slots) {
    slots[slot.slot] = {
        {"role", slot.role}, {"version", Known(slot.version)}, {"fault", Known(slot.fault)}};
  }
  OrderedJson last;
  if (robot.last) {
    last = {{"slot", ota::SlotName(robot.last->slot)},
            {"version", robot.last->version},
            {"kept", robot.last->kept},
            {"reason", robot.last->reason}};
  }
  return JsonLine({{"robot", robot.robot},
                   {"root", robot.root},
                   {"pid", Known(robot.pid)},
                   {"slots", slots},
                   {"last", last}});
}

}  // namespace musher::cli
