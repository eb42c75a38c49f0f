#include "musher/navigation/route/route_graph.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <queue>
#include <utility>

#include "musher/navigation/navigation_fault.hpp"
#include "musher/navigation/place_text.hpp"

namespace musher::navigation {
namespace {

using Json = nlohmann::json;

constexpr double kMostCost = 1e9;
constexpr double kPassedM = 0.1;  // at least, of an edge
constexpr double kMostRoutePoses = 100'000;

// The first fault with its place, and how many there are.
class GraphFaults {
 public:
  void Add(const std::string& path, const std::string& message) {
    if (count_++ == 0) first_ = path + (path.empty() ? "" : ": ") + message;
  }
  bool empty() const { return count_ == 0; }
  Error error() const {
    return MakeError(Fault::kMap,
                     first_ + (count_ > 1 ? fmt::format(" (and {} more faults)", count_ - 1) : ""));
  }

 private:
  std::string first_;
  std::size_t count_ = 0;
};

std::string TextOf(const Json& value) {
  constexpr std::size_t kLongest = 40;
  if (value.is_object()) return "an object";
  if (value.is_array()) return "an array";
  const std::string text = value.dump(-1, ' ', true, Json::error_handler_t::replace);
  return text.size() <= kLongest ? text : text.substr(0, kLongest) + "...";
}

const Json* Member(const Json& object, const char* key) {
  if (!object.is_object()) return nullptr;
  const auto found = object.find(key);
  return found == object.end() ? nullptr : &*found;
}

class GraphReader {
 public:
  GraphReader(const std::string& frame, GraphFaults& faults) : frame_(frame), faults_(faults) {}

  void Read(const Json& json) {
    const Json* features = Member(json, "features");
    if (features == nullptr || !features->is_array()) {
      return faults_.Add("features", "expected an array of nodes and edges, as GeoJSON has it");
    }
    for (std::size_t i = 0; i < features->size(); ++i) {
      ReadFeature((*features)[i], fmt::format("features[{}]", i));
    }
    if (graph_.nodes.empty() && faults_.empty()) {
      faults_.Add("features", "the graph has no nodes, expected features of the type Point");
    }
    Connect();
  }
  RouteGraph Take() && { return std::move(graph_); }

 private:
  struct ReadEdge {
    GraphEdge edge;
    RouteId start = 0, end = 0;
    std::optional<double> cost;  // nullopt: its length
    std::string path;
  };

  void ReadFeature(const Json& feature, const std::string& path) {
    const Json* geometry = Member(feature, "geometry");
    const Json* type = geometry == nullptr ? nullptr : Member(*geometry, "type");
    const Json* properties = Member(feature, "properties");
    const std::string name = type != nullptr && type->is_string() ? type->get<std::string>() : "";
    if (name != "Point" && name != "MultiLineString" && name != "LineString") {
      return faults_.Add(
          path + ".geometry.type",
          "expected Point (a node), MultiLineString or LineString (an edge)" +
              (type == nullptr ? std::string(", it is missing") : ", found " + TextOf(*type)));
    }
    if (properties == nullptr || !properties->is_object()) {
      return faults_.Add(path + ".properties", "expected an object with an id");
    }
    const auto id = Id(*properties, "id", path);
    if (!id) return;
    if (name == "Point") {
      ReadNode(*id, *geometry, *properties, path);
    } else {
      ReadLine(*id, *properties, path);
    }
  }

  void ReadNode(RouteId id, const Json& geometry, const Json& properties, const std::string& path) {
    if (!node_ids_.insert(id).second) {
      return faults_.Add(path + ".properties.id", fmt::format("the graph has node {} already", id));
    }
    const Json* frame = Member(properties, "frame");
    if (frame != nullptr && *frame != frame_ && *frame != Json("")) {
      return faults_.Add(
          path + ".properties.frame",
          "expected \"" + frame_ + "\", the frame of the server, found " + TextOf(*frame));
    }
    const Json* at = Member(geometry, "coordinates");
    const auto is_number = [](const Json& value) {
      return value.is_number() && std::abs(value.get<double>()) <= kFarthestNodeM;
    };
    if (at == nullptr || !at->is_array() || at->size() < 2 || at->size() > 3 ||
        !std::ranges::all_of(*at, is_number)) {
      return faults_.Add(path + ".geometry.coordinates",
                         "expected [x, y] or [x, y, z] in m, from -1e6 to 1e6");
    }
    const double z_m = at->size() == 3 ? (*at)[2].get<double>() : 0;
    graph_.nodes.push_back({id, {(*at)[0].get<double>(), (*at)[1].get<double>(), z_m}});
  }

  void ReadLine(RouteId id, const Json& properties, const std::string& path) {
    if (!edge_ids_.insert(id).second) {
      return faults_.Add(path + ".properties.id", fmt::format("the graph has edge {} already", id));
    }
    const auto start = Id(properties, "startid", path), end = Id(properties, "endid", path);
    const Json* overridable = Member(properties, "overridable");
    if (overridable != nullptr && !overridable->is_boolean()) {
      return faults_.Add(path + ".properties.overridable",
                         "expected true or false, found " + TextOf(*overridable));
    }
    const Json* cost = Member(properties, "cost");
    const bool has_cost = cost != nullptr && cost->is_number() && cost->get<double>() >= 0 &&
                          cost->get<double>() <= kMostCost;
    if (cost != nullptr && !has_cost) {
      return faults_.Add(path + ".properties.cost",
                         "expected a number from 0 to 1e9, found " + TextOf(*cost));
    }
    if (!start || !end) return;
    ReadEdge read{{id, 0, 0, 0}, *start, *end, {}, path};
    if (overridable != nullptr && !overridable->get<bool>()) {
      read.cost = has_cost ? cost->get<double>() : 0;
    }
    edges_.push_back(std::move(read));
  }

  // A whole number, also as 3.0.
  std::optional<RouteId> Id(const Json& properties, const char* key, const std::string& path) {
    const Json* value = Member(properties, key);
    if (value != nullptr && value->is_number()) {
      const auto number = value->get<double>();
      if (number >= 0 && number <= std::numeric_limits<RouteId>::max() &&
          number == std::floor(number)) {
        return static_cast<RouteId>(number);
      }
    }
    faults_.Add(path + ".properties." + key,
                "expected a whole number from 0 to 65535, " +
                    (value == nullptr ? std::string("it is missing") : "found " + TextOf(*value)));
    return std::nullopt;
  }

  // Edges may come before their nodes.
  void Connect() {
    const auto by_id = [](const auto& a, const auto& b) { return a.id < b.id; };
    std::ranges::sort(graph_.nodes, by_id);
    std::ranges::sort(edges_,
                      [](const ReadEdge& a, const ReadEdge& b) { return a.edge.id < b.edge.id; });
    graph_.leave.resize(graph_.nodes.size());
    for (ReadEdge& read : edges_) {
      const auto from = End(read, "startid", read.start), to = End(read, "endid", read.end);
      if (!from || !to) continue;
      if (*from == *to) {
        faults_.Add(read.path + ".properties.endid",
                    fmt::format("the edge leads from node {} to itself", read.end));
        continue;
      }
      GraphEdge& edge = read.edge;
      edge.from = *from;
      edge.to = *to;
      edge.cost = read.cost.value_or(Distance(graph_.nodes[*from].at, graph_.nodes[*to].at));
      graph_.leave[*from].push_back(graph_.edges.size());
      graph_.edges.push_back(edge);
    }
  }

  // A node that was refused is not reported once more.
  std::optional<std::size_t> End(const ReadEdge& read, const char* key, RouteId id) {
    const auto node = graph_.NodeOf(id);
    if (!node && !node_ids_.contains(id)) {
      faults_.Add(read.path + ".properties." + key, fmt::format("there is no node {}", id));
    }
    return node;
  }

  const std::string frame_;
  GraphFaults& faults_;
  RouteGraph graph_;
  std::vector<ReadEdge> edges_;
  std::set<RouteId> node_ids_, edge_ids_;
};

// "line 3, column 7", of a byte from 1 on.
std::string PlaceInText(std::string_view text, std::size_t byte) {
  const std::string_view before = text.substr(0, byte == 0 ? 0 : byte - 1);
  const std::size_t begin = before.rfind('\n') + 1;  // npos + 1 is 0
  return fmt::format("line {}, column {}", 1 + std::ranges::count(before, '\n'),
                     before.size() - begin + 1);
}

template <class T>
std::optional<std::size_t> IndexOf(const std::vector<T>& all, RouteId id) {
  const auto found = std::ranges::lower_bound(all, id, {}, &T::id);
  if (found == all.end() || found->id != id) return std::nullopt;
  return static_cast<std::size_t>(found - all.begin());
}

double FlatDistance(const Point& a, const Point& b) {
  return std::hypot(a.x_m - b.x_m, a.y_m - b.y_m);
}

// Whether a place is beside an edge, and between its ends.
bool IsBeside(const RouteGraph& graph, std::size_t edge, const Point& place, double within_m) {
  const Point& a = graph.nodes[graph.edges[edge].from].at;
  const Point& b = graph.nodes[graph.edges[edge].to].at;
  const double length_m = FlatDistance(a, b);
  if (length_m <= 0) return false;
  const double x = (b.x_m - a.x_m) / length_m, y = (b.y_m - a.y_m) / length_m;
  const double along_m = (place.x_m - a.x_m) * x + (place.y_m - a.y_m) * y;
  const double off_m = std::abs((place.y_m - a.y_m) * x - (place.x_m - a.x_m) * y);
  return off_m <= within_m && along_m >= kPassedM && along_m <= length_m - kPassedM;
}

double YawBetween(const Point& a, const Point& b, double otherwise) {
  return FlatDistance(a, b) > 0 ? std::atan2(b.y_m - a.y_m, b.x_m - a.x_m) : otherwise;
}

}  // namespace

std::optional<std::size_t> RouteGraph::NodeOf(RouteId id) const {
  return IndexOf(nodes, id);
}
std::optional<std::size_t> RouteGraph::EdgeOf(RouteId id) const {
  return IndexOf(edges, id);
}

Result<RouteGraph> ReadRouteGraph(std::string_view geojson, const std::string& frame) {
  if (geojson.size() > kMostGraphBytes) {
    return MakeError(Fault::kMap,
                     fmt::format("the graph is larger than {} MiB", kMostGraphBytes >> 20U));
  }
  GraphFaults faults;
  GraphReader reader(frame, faults);
  try {
    reader.Read(Json::parse(geojson));
  } catch (const Json::parse_error& error) {
    faults.Add(PlaceInText(geojson, error.byte), "invalid JSON");
  } catch (const Json::exception&) {
    faults.Add("", "invalid JSON: a number is too large");
  }
  if (!faults.empty()) return faults.error();
  return std::move(reader).Take();
}

double CostOf(const RouteGraph& graph, std::size_t edge, const EdgeChanges& changes) {
  const auto dearer = changes.dearer.find(edge);
  return graph.edges[edge].cost + (dearer == changes.dearer.end() ? 0 : dearer->second);
}

Result<Route> FindRoute(const RouteGraph& graph, std::size_t from, std::size_t to,
                        const EdgeChanges& changes) {
  constexpr double kFar = std::numeric_limits<double>::infinity();
  constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();
  std::vector<double> cost(graph.nodes.size(), kFar);
  std::vector<std::size_t> by(graph.nodes.size(), kNone);  // the edge that leads there
  using Entry = std::pair<double, std::size_t>;            // of two as cheap, the smaller id first
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  cost[from] = 0;
  open.emplace(0, from);
  while (!open.empty()) {
    const auto [spent, node] = open.top();
    open.pop();
    if (spent > cost[node]) continue;
    if (node == to) break;
    for (const std::size_t edge : graph.leave[node]) {
      if (changes.closed.contains(edge)) continue;
      const std::size_t next = graph.edges[edge].to;
      const double sum = spent + CostOf(graph, edge, changes);
      if (sum >= cost[next]) continue;
      cost[next] = sum;
      by[next] = edge;
      open.emplace(sum, next);
    }
  }
  if (cost[to] == kFar) {
    return MakeError(
        Fault::kWalledIn,
        fmt::format(
            "no route leads from node {} to node {}{}", graph.nodes[from].id, graph.nodes[to].id,
            changes.closed.empty() ? ""
                                   : fmt::format("; {} edges are closed", changes.closed.size())));
  }
  Route route{{to}, {}, cost[to]};
  for (std::size_t node = to; node != from; node = graph.edges[by[node]].from) {
    route.edges.push_back(by[node]);
    route.nodes.push_back(graph.edges[by[node]].from);
  }
  std::ranges::reverse(route.nodes);
  std::ranges::reverse(route.edges);
  return route;
}

Result<std::size_t> NearestNode(const RouteGraph& graph, const Point& place, double within_m,
                                const std::string& what) {
  std::size_t nearest = 0;
  double nearest_m = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < graph.nodes.size(); ++i) {
    const double apart_m = FlatDistance(graph.nodes[i].at, place);
    if (apart_m >= nearest_m) continue;
    nearest_m = apart_m;
    nearest = i;
  }
  if (nearest_m <= within_m) return nearest;
  return MakeError(
      Fault::kOutside,
      fmt::format("{} {} is {} m from the nearest node, expected at most {} m", what,
                  PlaceText(place, true), MetresText(nearest_m), MetresText(within_m)));
}

Route WithoutDetours(const RouteGraph& graph, Route route, const std::optional<Point>& start,
                     const std::optional<Point>& goal, double within_m,
                     const EdgeChanges& changes) {
  if (start && !route.edges.empty() && IsBeside(graph, route.edges.front(), *start, within_m)) {
    route.cost -= CostOf(graph, route.edges.front(), changes);
    route.nodes.erase(route.nodes.begin());
    route.edges.erase(route.edges.begin());
  }
  if (goal && !route.edges.empty() && IsBeside(graph, route.edges.back(), *goal, within_m)) {
    route.cost -= CostOf(graph, route.edges.back(), changes);
    route.nodes.pop_back();
    route.edges.pop_back();
  }
  return route;
}

Path PathAlong(const RouteGraph& graph, const Route& route, double step_m, double yaw_rad) {
  double length_m = 0;
  for (const std::size_t edge : route.edges) {
    length_m +=
        Distance(graph.nodes[graph.edges[edge].from].at, graph.nodes[graph.edges[edge].to].at);
  }
  const double most = kMostRoutePoses - 2 * static_cast<double>(route.nodes.size());
  const double each_m = std::max(step_m, length_m / std::max(most, 1.0));
  Path path;
  for (const std::size_t edge : route.edges) {
    const Point& a = graph.nodes[graph.edges[edge].from].at;
    const Point& b = graph.nodes[graph.edges[edge].to].at;
    yaw_rad = YawBetween(a, b, yaw_rad);
    const int count = static_cast<int>(std::max(1.0, std::ceil(Distance(a, b) / each_m)));
    for (int i = 0; i < count; ++i) {
      path.push_back({Between(a, b, static_cast<double>(i) / count), yaw_rad});
    }
  }
  path.push_back({graph.nodes[route.nodes.back()].at, yaw_rad});
  return path;
}

}  // namespace musher::navigation
