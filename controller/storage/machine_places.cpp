#include "musher/controller/storage/machine_places.hpp"

#include <algorithm>
#include <charconv>
#include <fstream>
#include <optional>
#include <set>
#include <string_view>
#include <system_error>

#include "musher/base/words.hpp"

namespace musher {
namespace {

// Of a name as NameLock::NameOf() makes it; nullopt: of no actuator or controller.
std::optional<MachinePlace> PlaceOfName(std::string_view name) {
  constexpr std::string_view kController = "/musher/controller";
  MachinePlace place;
  const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), place.domain);
  if (error != std::errc() || end == name.data() + name.size() || *end != '/') return std::nullopt;
  name.remove_prefix(static_cast<std::size_t>(end - name.data()) + 1);
  const bool leads = name.ends_with(kController);
  const std::size_t last = leads ? name.size() - kController.size() : name.rfind('/');
  if (last == std::string_view::npos) return std::nullopt;
  place.name_space = name.substr(0, last);
  const std::string& where = place.name_space;
  if (!leads && (where == "musher" || where.ends_with("/musher"))) return std::nullopt;
  return place;
}

}  // namespace

std::string MachinePlace::Text(int own_domain) const {
  const std::string text = NamespaceText(name_space);
  return domain == own_domain ? text : text + " of DDS domain " + std::to_string(domain);
}

std::string MachinePlace::Options(const MachinePlace& own) const {
  std::string options;
  if (name_space != own.name_space) options = "--namespace " + ShellWord(name_space);
  if (domain == own.domain) return options;
  return options + (options.empty() ? "" : " ") + "--domain " + std::to_string(domain);
}

std::vector<MachinePlace> PlacesHere() {
  constexpr std::string_view kBegin = " @musher/";
  std::set<MachinePlace> places;
  std::ifstream table("/proc/net/unix");
  for (std::string line; std::getline(table, line);) {
    const std::size_t at = line.find(kBegin);
    if (at == std::string::npos) continue;
    const auto place = PlaceOfName(std::string_view(line).substr(at + kBegin.size()));
    if (place) places.insert(*place);
  }
  return {places.begin(), places.end()};
}

std::string WhyNotFrom(const MachinePlace& own, const std::vector<MachinePlace>& places,
                       const std::string& found) {
  const auto beside = std::ranges::find_if(
      places, [&](const MachinePlace& one) { return one != own && one.domain == own.domain; });
  const bool own_runs = std::ranges::count(places, own) != 0;
  if (own_runs || beside == places.end()) return "";
  return "the machine of this host runs in " + beside->Text(own.domain) + "; found " + found +
         " in " + own.Text(own.domain) + ". Nothing was done";
}

}  // namespace musher
