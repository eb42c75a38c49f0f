#include "musher/view/record/qos_text.hpp"

#include <sstream>

namespace musher::view {
namespace {

using transport::Qos;

constexpr const char* kForever = "    sec: 9223372036\n    nsec: 854775807\n";
constexpr int kLatchedDepth = 100;

// "reliable" of the line "  reliability: reliable".
std::string ValueOf(const std::string& line, const std::string& key) {
  const std::size_t at = line.find(key + ":");
  if (at == std::string::npos) return "";
  std::istringstream rest(line.substr(at + key.size() + 1));
  std::string value;
  rest >> value;
  return value;
}

}  // namespace

std::string QosText(const std::vector<Qos>& offered) {
  std::string text;
  for (const Qos& qos : offered) {
    const bool reliable = qos.reliability == Qos::Reliability::kReliable;
    const bool latched = qos.durability == Qos::Durability::kTransientLocal;
    text += "- history: unknown\n  depth: 0\n";
    text += std::string("  reliability: ") + (reliable ? "reliable" : "best_effort") + "\n";
    text += std::string("  durability: ") + (latched ? "transient_local" : "volatile") + "\n";
    text += std::string("  deadline:\n") + kForever;
    text += std::string("  lifespan:\n") + kForever;
    text += "  liveliness: automatic\n";
    text += std::string("  liveliness_lease_duration:\n") + kForever;
    text += "  avoid_ros_namespace_conventions: false\n";
  }
  return text;
}

Qos QosFrom(std::string_view text) {
  Qos qos;
  bool said = false;
  bool reliable = false;
  bool latched = false;
  std::istringstream lines{std::string(text)};
  for (std::string line; std::getline(lines, line);) {
    const std::string reliability = ValueOf(line, "reliability");
    const std::string durability = ValueOf(line, "durability");
    if (!reliability.empty()) said = true;
    if (reliability == "reliable" || reliability == "1") reliable = true;
    if (durability == "transient_local" || durability == "1") latched = true;
  }
  if (said && !reliable) qos.reliability = Qos::Reliability::kBestEffort;
  if (latched) {
    qos.durability = Qos::Durability::kTransientLocal;
    qos.depth = kLatchedDepth;
  }
  return qos;
}

}  // namespace musher::view
