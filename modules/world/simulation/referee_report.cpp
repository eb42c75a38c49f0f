#include "musher/modules/world/simulation/referee_report.hpp"

#include <algorithm>
#include <cstdio>

#include "musher/base/joined.hpp"
#include "musher/modules/world/scene/variation.hpp"

namespace musher::world {
namespace {

template <class... Numbers>
std::string Format(const char* format, Numbers... numbers) {
  char text[160];
  std::snprintf(text, sizeof(text), format, numbers...);
  return text;
}

// Since it first moved, until it finished or now.
Duration RunTime(const Referee& referee, Duration now) {
  return referee.finished().value_or(now) - referee.began().value_or(now);
}

const LineTouch* Deepest(const Referee& referee) {
  const auto& touches = referee.touches();
  const auto deepest = std::max_element(
      touches.begin(), touches.end(),
      [](const LineTouch& a, const LineTouch& b) { return a.depth_m < b.depth_m; });
  return deepest == touches.end() ? nullptr : &*deepest;
}

std::string JsonText(const std::string& text) {
  std::string quoted = "\"";
  for (const char letter : text) {
    if (letter == '"' || letter == '\\') quoted += '\\';
    if (static_cast<unsigned char>(letter) < 0x20) {
      quoted += Format("\\u%04x", static_cast<unsigned>(letter));
    } else {
      quoted += letter;
    }
  }
  return quoted + '"';
}

template <class Item, class Write>
std::string Listed(const std::vector<Item>& items, Write write) {
  std::string text = "[";
  for (std::size_t i = 0; i < items.size(); ++i) text += (i > 0 ? "," : "") + write(items[i]);
  return text + "]";
}

std::string JsonOf(const LineTouch& touch) {
  return Format(
             R"({"foot":"%s","line":%zu,"from_s":%.2f,"to_s":%.2f,"depth_m":%.3f,"x_m":%.3f,"y_m":%.3f,)",
             kFeet.at(touch.foot), touch.line + 1, ToSeconds(touch.from), ToSeconds(touch.to),
             touch.depth_m, touch.where_m.x(), touch.where_m.y()) +
         R"("whole_foot":)" + (touch.whole_foot ? "true}" : "false}");
}

}  // namespace

ZonesInOrder CompareZones(const Scene& scene, const std::vector<ZoneVisit>& visits) {
  const std::vector<std::string>& order = scene.referee.order;
  const auto name = [&](std::size_t visit) { return scene.zones[visits[visit].zone].name; };
  // common[i][k]: the length of the longest common part of the order from i and the visits from k.
  std::vector<std::vector<std::size_t>> common(order.size() + 1,
                                               std::vector<std::size_t>(visits.size() + 1, 0));
  for (std::size_t i = order.size(); i-- > 0;) {
    for (std::size_t k = visits.size(); k-- > 0;) {
      common[i][k] = order[i] == name(k) ? common[i + 1][k + 1] + 1
                                         : std::max(common[i + 1][k], common[i][k + 1]);
    }
  }
  ZonesInOrder zones;
  zones.in_order.assign(visits.size(), false);
  std::size_t i = 0;
  for (std::size_t k = 0; k < visits.size(); ++k) {
    while (i < order.size() && common[i][k] > 0 && order[i] != name(k) &&
           common[i + 1][k] == common[i][k] && common[i][k + 1] < common[i][k]) {
      zones.missing.push_back(order[i++]);
    }
    if (i < order.size() && order[i] == name(k)) {
      zones.in_order[k] = true;
      ++i;
      continue;
    }
    const bool again = k > 0 && name(k) == name(k - 1);
    if (scene.zones[visits[k].zone].lie && !again) zones.out_of_turn.push_back(name(k));
  }
  zones.ahead.assign(order.begin() + static_cast<std::ptrdiff_t>(i), order.end());
  return zones;
}

std::string RefereeText(const Scene& scene, const Referee& referee, Duration now) {
  const ZonesInOrder zones = CompareZones(scene, referee.visits());
  std::string text = scene.name + ", " + SampledText(scene) + "\n";
  text += referee.finished() ? "finished after " : "not finished after ";
  text += Format("%.1f s\n", ToSeconds(RunTime(referee, now)));
  std::vector<std::string> reached;
  for (std::size_t i = 0; i < referee.visits().size(); ++i) {
    const ZoneVisit& visit = referee.visits()[i];
    if (!zones.in_order[i]) continue;
    reached.push_back(scene.zones[visit.zone].name + Format(" (%.1f s)", ToSeconds(visit.at)));
  }
  text += "reached in order: " + Joined(reached, "none") + "\n";
  text += "missing: " + Joined(zones.missing, "none") + "\n";
  if (!zones.ahead.empty()) text += "still ahead: " + Joined(zones.ahead, "none") + "\n";
  text += "lay down out of turn in: " + Joined(zones.out_of_turn, "none") + "\n";
  text += Format("feet on lines: %zu, with the whole foot: %zu\n", referee.touch_count(),
                 referee.whole_foot_count());
  if (const LineTouch* deepest = Deepest(referee)) {
    text += Format("the deepest: %.3f m, the %s foot at (%.2f m, %.2f m) at %.1f s\n",
                   deepest->depth_m, kFeet.at(deepest->foot), deepest->where_m.x(),
                   deepest->where_m.y(), ToSeconds(deepest->from));
  }
  text += Format("collisions: %zu\nmoved by hand: %zu", referee.collisions(), referee.carried());
  return text;
}

std::string RefereeJson(const Scene& scene, const Referee& referee, Duration now) {
  const ZonesInOrder zones = CompareZones(scene, referee.visits());
  std::string sampled;
  for (const Sampled& each : scene.sampled) {
    sampled += (sampled.empty() ? "" : ",") + JsonText(each.name) + ":" + JsonText(each.value);
  }
  std::size_t index = 0;
  const auto visit = [&](const ZoneVisit& each) {
    return "{\"zone\":" + JsonText(scene.zones[each.zone].name) +
           Format(R"(,"at_s":%.2f,"in_order":)", ToSeconds(each.at)) +
           (zones.in_order[index++] ? "true}" : "false}");
  };
  const LineTouch* deepest = Deepest(referee);
  return "{\"name\":" + JsonText(scene.name) + ",\"seed\":" + std::to_string(scene.seed) +
         ",\"sampled\":{" + sampled + "},\"finished\":" + (referee.finished() ? "true" : "false") +
         Format(",\"time_s\":%.2f", ToSeconds(RunTime(referee, now))) +
         ",\"reached\":" + Listed(referee.visits(), visit) +
         ",\"missing\":" + Listed(zones.missing, JsonText) +
         ",\"ahead\":" + Listed(zones.ahead, JsonText) +
         ",\"out_of_turn\":" + Listed(zones.out_of_turn, JsonText) +
         Format(R"(,"lines":{"count":%zu,"whole_foot":%zu,"deepest_m":%.3f,"touches":)",
                referee.touch_count(), referee.whole_foot_count(),
                deepest != nullptr ? deepest->depth_m : 0.0) +
         Listed(referee.touches(), JsonOf) + "}" +
         Format(R"(,"collisions":%zu,"moved_by_hand":%zu})", referee.collisions(),
                referee.carried());
}

}  // namespace musher::world
