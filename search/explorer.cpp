#include "musher/search/explorer.hpp"

#include <algorithm>
#include <chrono>
#include <deque>
#include <sstream>
#include <unordered_set>
#include <utility>

#include "musher/search/fingerprint.hpp"
#include "musher/search/rules.hpp"

namespace musher::search {
namespace {

class Explorer {
 public:
  explicit Explorer(const Model& model) : model_(model) {}

  Searched Run(const World& root) && {
    const Identity identity = IdentityOf(model_, root);
    seen_.insert(identity.fingerprint);
    origins_.push_back({});
    layer_.push_back({0, identity.twins, root});
    while (!layer_.empty() && !searched_.fault) {
      for (Node& node : layer_) {
        if (!searched_.fault) Expand(node);
        node.world = World();  // its memory is the next layer's
      }
      layer_ = std::exchange(next_, {});
    }
    searched_.figures.pairs = 1;
    searched_.figures.nodes = origins_.size();
    return std::move(searched_);
  }

 private:
  struct Node {
    std::uint32_t id = 0;
    unsigned twins = 0;
    World world;
  };
  // How a node was reached first.
  struct Origin {
    std::uint32_t from = 0;
    std::uint32_t choice = 0;
  };

  void Expand(Node& node) {
    const std::vector<Choice> choices = Choices(model_, node.world);
    if (IsQuiet(node.world, choices)) {
      ++searched_.figures.leaves;
      Notes notes;
      CheckRest(model_, node.world, notes);
      if (!notes.violations.empty()) return ReportFault(node.id, std::nullopt, std::move(notes));
    }
    for (std::uint32_t k = 0; k < choices.size(); ++k) {
      if ((node.twins >> choices[k].actuator & 1U) != 0) continue;
      World world = k + 1 < choices.size() ? node.world : std::move(node.world);
      Notes notes;
      Make(model_, world, choices[k], notes);
      ++searched_.figures.transitions;
      if (!notes.violations.empty()) return ReportFault(node.id, k, std::move(notes));
      const Identity identity = IdentityOf(model_, world);
      if (!seen_.insert(identity.fingerprint).second) continue;
      origins_.push_back({node.id, k});
      next_.push_back(
          {static_cast<std::uint32_t>(origins_.size() - 1), identity.twins, std::move(world)});
    }
  }

  void ReportFault(std::uint32_t id, std::optional<std::uint32_t> last, Notes notes) {
    std::vector<std::uint32_t> path;
    if (last) path.push_back(*last);
    for (; id != 0; id = origins_[id].from) path.push_back(origins_[id].choice);
    std::string text;
    std::reverse(path.begin(), path.end());
    for (const std::uint32_t choice : path) {
      text += (text.empty() ? "" : ".") + std::to_string(choice);
    }
    searched_.fault = Fault{std::move(notes.violations), text};
  }

  const Model& model_;
  Searched searched_;
  std::unordered_set<Fingerprint, FingerprintHash> seen_;
  std::vector<Origin> origins_;
  std::deque<Node> layer_;  // grows without a move of its nodes
  std::deque<Node> next_;
};

}  // namespace

Figures& Figures::operator+=(const Figures& other) {
  pairs += other.pairs;
  nodes += other.nodes;
  transitions += other.transitions;
  leaves += other.leaves;
  seconds += other.seconds;
  return *this;
}

Searched SearchAll(const Model& model, const World& root) {
  const auto begun = std::chrono::steady_clock::now();
  Searched searched = Explorer(model).Run(root);
  searched.figures.seconds = ToSeconds(std::chrono::steady_clock::now() - begun);
  return searched;
}

std::string ScenarioOf(const Model& model, const World& root, const std::string& path) {
  std::string scenario;
  World world = root;
  std::istringstream steps(path);
  Notes notes;
  notes.log = true;
  for (std::string step; std::getline(steps, step, '.');) {
    const std::vector<Choice> choices = Choices(model, world);
    const std::size_t k = std::stoul(step);
    if (k >= choices.size()) return scenario + "(no choice " + step + " here)\n";
    Make(model, world, choices[k], notes);
  }
  if (IsQuiet(world, Choices(model, world))) CheckRest(model, world, notes);
  for (const std::string& sentence : notes.scenario) scenario += "  " + sentence + "\n";
  for (const std::string& violation : notes.violations)
    scenario += "VIOLATION: " + violation + "\n";
  return scenario;
}

}  // namespace musher::search
