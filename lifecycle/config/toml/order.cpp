// The references between actuators by `after` and `binds_to`.

#include <algorithm>
#include <cstddef>
#include <unordered_map>

#include "musher/lifecycle/config/toml/draft.hpp"

namespace musher::config_toml {
namespace {

constexpr std::size_t kLongestShownCycle = 8;

class OrderCheck {
 public:
  OrderCheck(const std::vector<ActuatorDraft>& actuators, const Table& tables, Findings& findings)
      : actuators_(actuators), findings_(findings) {
    for (const Member& table : tables) names_.push_back(table.key);
    for (std::size_t i = 0; i < actuators.size(); ++i) {
      index_.emplace(actuators[i].config.name, i);
    }
  }

  void Run() {
    edges_.resize(actuators_.size());
    for (std::size_t i = 0; i < actuators_.size(); ++i) {
      edges_[i] = CheckNames(i, "after", actuators_[i].after);
      for (const Edge& edge : edges_[i]) CheckStage(i, edge);
    }
    OpenCycles("`after` forms a cycle: ");
    const auto order = edges_;
    for (std::size_t i = 0; i < actuators_.size(); ++i) {
      edges_[i] = CheckNames(i, "binds_to", actuators_[i].binds_to);
    }
    OpenCycles("`binds_to` forms a cycle: ");
    // After a restart each would wait for the other: one by `after`, the other by `binds_to`.
    for (std::size_t i = 0; i < actuators_.size(); ++i) {
      edges_[i].insert(edges_[i].end(), order[i].begin(), order[i].end());
    }
    OpenCycles("`after` and `binds_to` together form a cycle: ");
  }

 private:
  struct Edge {
    std::size_t to;
    Position at;
    std::string_view key;  // that names it
  };
  enum class Mark { kNew, kOpen, kDone };

  void Fault(std::size_t actuator, std::string_view key, Position at, std::string_view message) {
    findings_.Error(at, "actuator." + actuators_[actuator].config.name + "." + std::string(key) +
                            ": " + std::string(message));
  }

  // The words that name another actuator.
  std::vector<Edge> CheckNames(std::size_t actuator, std::string_view key,
                               const std::vector<Word>& words) {
    std::vector<Edge> edges;
    for (const Word& word : words) {
      const auto found = index_.find(word.text);
      if (found == index_.end()) {
        const std::string guess = findings_.Guess(word.text, names_);
        Fault(actuator, key, word.at, "unknown actuator " + Quote(word.text) + guess);
      } else if (found->second == actuator) {
        Fault(actuator, key, word.at, "expected another actuator, found the actuator itself");
      } else {
        edges.push_back({found->second, word.at, key});
      }
    }
    return edges;
  }

  void CheckStage(std::size_t actuator, const Edge& edge) {
    const ActuatorConfig& self = actuators_[actuator].config;
    const ActuatorConfig& other = actuators_[edge.to].config;
    if (other.stage <= self.stage) return;
    Fault(actuator, "after", edge.at,
          Quote(other.name) + " is of stage " + std::to_string(other.stage) +
              ", which begins only when stage " + std::to_string(self.stage) + " is up");
  }

  // Reports every cycle and removes the edge that closes it, so that no cycle hides another one.
  // Depth first without recursion; an edge to a node of the present path closes a cycle.
  void OpenCycles(std::string_view what) {
    std::vector<Mark> marks(actuators_.size(), Mark::kNew);
    for (std::size_t start = 0; start < actuators_.size(); ++start) {
      if (marks[start] != Mark::kNew) continue;
      std::vector<std::size_t> way = {start};
      std::vector<std::size_t> next_edge = {0};
      std::unordered_map<std::size_t, std::size_t> place = {{start, 0}};
      marks[start] = Mark::kOpen;
      while (!way.empty()) {
        const std::size_t node = way.back();
        if (next_edge.back() == edges_[node].size()) {
          marks[node] = Mark::kDone;
          place.erase(node);
          way.pop_back();
          next_edge.pop_back();
          continue;
        }
        const Edge edge = edges_[node][next_edge.back()++];
        if (marks[edge.to] == Mark::kOpen) {
          ReportCycle(way, place.at(edge.to), edge, what);
          edges_[node].erase(edges_[node].begin() +
                             static_cast<std::ptrdiff_t>(--next_edge.back()));
        } else if (marks[edge.to] == Mark::kNew) {
          marks[edge.to] = Mark::kOpen;
          place.emplace(edge.to, way.size());
          way.push_back(edge.to);
          next_edge.push_back(0);
        }
      }
    }
  }

  void ReportCycle(const std::vector<std::size_t>& way, std::size_t first, const Edge& closing,
                   std::string_view what) {
    const auto name = [&](std::size_t place) { return actuators_[way[place]].config.name; };
    std::string text;
    const std::size_t length = way.size() - first;
    for (std::size_t i = 0; i < std::min(length, kLongestShownCycle); ++i) {
      text += name(first + i) + " -> ";
    }
    if (length > kLongestShownCycle) {
      text += "(" + std::to_string(length - kLongestShownCycle) + " more) -> ";
    }
    Fault(way.back(), closing.key, closing.at, std::string(what) + text + name(first));
  }

  const std::vector<ActuatorDraft>& actuators_;
  Findings& findings_;
  std::vector<std::string_view> names_;
  std::unordered_map<std::string_view, std::size_t> index_;
  std::vector<std::vector<Edge>> edges_;
};

}  // namespace

void CheckOrder(const std::vector<ActuatorDraft>& actuators, const Table& tables,
                Findings& findings) {
  OrderCheck(actuators, tables, findings).Run();
}

}  // namespace musher::config_toml
