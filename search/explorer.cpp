#include "musher/search/explorer.hpp"

#include <algorithm>
#include <chrono>
#include <deque>
#include <sstream>
#include <unordered_map>
#include <utility>

#include "musher/search/fingerprint.hpp"
#include "musher/search/fingerprint_set.hpp"
#include "musher/search/reduction.hpp"
#include "musher/search/rules.hpp"

namespace musher::search {
namespace {

// Which of the choices in a world are not searched.
class LeftOut {
 public:
  LeftOut(const Model& model, const World& world, unsigned twins)
      : twins_(twins), only_(SearchedAlone(model, world)) {}

  bool Has(const Choice& choice) const {
    return (twins_ >> choice.actuator & 1U) != 0 || (only_ && choice.which() != *only_);
  }

 private:
  unsigned twins_;
  std::optional<ActuatorIndex> only_;
};

// The stable states that have been reached: as many in a search that leaves nothing out.
class StableStates {
 public:
  explicit StableStates(const Model& model) : model_(model) { model_.reduces = true; }

  // Returns whether it was new.
  bool Insert(const World& world) {
    return fingerprints_.Insert(IdentityOf(model_, world).fingerprint);
  }
  std::size_t size() const { return fingerprints_.size(); }

 private:
  Model model_;
  FingerprintSet fingerprints_;
};

class Explorer {
 public:
  Explorer(const Model& model, SearchLimits* limits)
      : model_(model), limits_(limits), stable_(model) {}

  Searched Run(const World& root) && {
    const Identity identity = IdentityOf(model_, root);
    seen_.Insert(identity.fingerprint);
    origins_.push_back({});
    layer_.push_back({0, identity.twins, root});
    for (std::size_t depth = 0; !layer_.empty() && !searched_.fault; ++depth) {
      for (Node& node : layer_) {
        if (!searched_.fault && MayGoOn(depth)) Expand(node);
        node.world = World();  // its memory is the next layer's
      }
      layer_ = std::exchange(next_, {});
    }
    searched_.figures.pairs = 1;
    searched_.figures.nodes = origins_.size();
    searched_.figures.leaves = stable_.size();
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

  // Whether a scenario with `depth` choices is of interest.
  bool MayGoOn(std::size_t depth) {
    if (limits_ == nullptr) return true;
    if (limits_->stop || depth >= limits_->below) searched_.finished = false;
    return searched_.finished;
  }

  void Expand(Node& node) {
    const std::vector<Choice> choices = Choices(model_, node.world);
    if (IsQuiet(node.world, choices)) {
      stable_.Insert(node.world);
      Notes notes;
      CheckRest(model_, node.world, notes);
      if (!notes.violations.empty()) return ReportFault(node.id, std::nullopt, std::move(notes));
    }
    const LeftOut left_out(model_, node.world, node.twins);
    for (std::uint32_t k = 0; k < choices.size(); ++k) {
      if (left_out.Has(choices[k])) continue;
      World world = k + 1 < choices.size() ? node.world : std::move(node.world);
      Notes notes;
      Make(model_, world, choices[k], notes);
      ++searched_.figures.transitions;
      if (!notes.violations.empty()) return ReportFault(node.id, k, std::move(notes));
      const Identity identity = IdentityOf(model_, world);
      if (!seen_.Insert(identity.fingerprint)) continue;
      origins_.push_back({node.id, k});
      if (limits_ != nullptr) ++limits_->nodes;
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
    searched_.fault = Fault{std::move(notes.violations), text, false};
  }

  const Model& model_;
  SearchLimits* limits_;
  Searched searched_;
  FingerprintSet seen_;
  StableStates stable_;
  std::vector<Origin> origins_;
  std::deque<Node> layer_;  // grows without a move of its nodes
  std::deque<Node> next_;
};

// Depth first. On the way it finds the nodes from which no choice without a fault leads to a quiet
// one, which exist only where choices lead in a circle: the strongly connected components of the
// nodes, by Tarjan's algorithm.
class DepthFirstExplorer {
 public:
  DepthFirstExplorer(const Model& model, const World& root, SearchLimits& limits)
      : model_(model), root_(root), limits_(limits), stable_(model) {
    searched_.rule_coverage.resize(model.stable_rules.size());
    searched_.timed_coverage.resize(model.timed_rules.size());
  }

  Searched Run() && {
    Visit(root_, 0);
    while (!path_.empty() && !searched_.fault) {
      if (limits_.stop) {
        searched_.finished = false;
        break;
      }
      Advance();
    }
    searched_.figures.pairs = 1;
    searched_.figures.nodes = seen_.size();
    searched_.figures.leaves = stable_.size();
    return std::move(searched_);
  }

 private:
  struct Node {
    World world;
    LeftOut left_out;
    std::vector<Choice> choices = {};
    std::size_t next = 0;  // of the choices; the one before it leads to the next node of the path
    Fingerprint fingerprint = {};
    int cost = 0;  // of the choice that leads here
    // The nodes have numbers as they are reached. `low`: of the first one that is known to be in
    // the same circle.
    std::size_t number = 0;
    std::size_t low = 0;
    bool settles = false;  // choices without a fault lead to a quiet node
  };

  // Puts a node at the end of the path, unless it is known. `cost`: of the choice that leads there.
  void Visit(World world, int cost) {
    const Identity identity = IdentityOf(model_, world);
    if (!seen_.Insert(identity.fingerprint)) return SeeAgain(identity.fingerprint, cost);
    ++limits_.nodes;
    const LeftOut left_out(model_, world, identity.twins);
    Node node{std::move(world), left_out};
    node.fingerprint = identity.fingerprint;
    node.cost = cost;
    node.number = node.low = seen_.size();
    node.choices = Choices(model_, node.world);
    if (IsQuiet(node.world, node.choices)) {
      node.settles = true;
      Notes notes;
      if (stable_.Insert(node.world)) notes.rule_coverage = &searched_.rule_coverage;
      CheckRest(model_, node.world, notes);
      if (!notes.violations.empty()) return ReportFault(std::move(notes));
    }
    open_.emplace(node.fingerprint, node.number);
    open_order_.push_back(node.fingerprint);
    path_.push_back(std::move(node));
  }

  // A choice of the last node leads to a known one: an open one is in a circle with it, and all
  // others settle.
  void SeeAgain(const Fingerprint& fingerprint, int cost) {
    Node& node = path_.back();
    if (const auto open = open_.find(fingerprint); open != open_.end()) {
      node.low = std::min(node.low, open->second);
    } else if (cost == 0) {
      node.settles = true;
    }
  }

  // Makes the next choice of the last node of the path.
  void Advance() {
    Node& node = path_.back();
    while (node.next < node.choices.size() && node.left_out.Has(node.choices[node.next])) {
      ++node.next;
    }
    if (node.next == node.choices.size()) return Leave();
    const Choice choice = node.choices[node.next++];
    World world = node.next < node.choices.size() ? node.world : std::move(node.world);
    Notes notes;
    notes.timed_coverage = &searched_.timed_coverage;
    Make(model_, world, choice, notes);
    ++searched_.figures.transitions;
    if (!notes.violations.empty()) return ReportFault(std::move(notes));
    Visit(std::move(world), choice.cost);
  }

  // All choices of the last node have been made.
  void Leave() {
    const Node& node = path_.back();
    const bool settles = node.settles;
    const std::size_t low = node.low;
    const int cost = node.cost;
    if (low == node.number) {  // it is the first one of its circle, or in none
      if (!settles) return ReportCircle();
      Close(node.fingerprint);
    }
    path_.pop_back();
    if (path_.empty()) return;
    Node& before = path_.back();
    before.low = std::min(before.low, low);
    before.settles |= settles && cost == 0;
  }

  // Its nodes are those that are open from its first one on.
  void Close(const Fingerprint& first) {
    for (bool last = false; !last;) {
      const Fingerprint fingerprint = open_order_.back();
      open_order_.pop_back();
      open_.erase(fingerprint);
      last = fingerprint == first;
    }
  }

  std::string PathText(std::size_t nodes) const {
    std::string text;
    for (std::size_t i = 0; i < nodes; ++i) {
      text += (text.empty() ? "" : ".") + std::to_string(path_[i].next - 1);
    }
    return text;
  }

  void ReportFault(Notes notes) {
    searched_.fault = Fault{std::move(notes.violations), PathText(path_.size()), false};
  }

  // Follows choices without a fault from the last node until they lead to one of them again.
  void ReportCircle() {
    std::string path = PathText(path_.size() - 1);
    World world = WorldAt(path);
    std::vector<Fingerprint> followed = {path_.back().fingerprint};
    for (;;) {
      const std::vector<Choice> choices = Choices(model_, world);
      const auto next = std::ranges::find(choices, 0, &Choice::cost);
      if (next == choices.end()) return;  // not reached: such a node is quiet
      path += (path.empty() ? "" : ".") + std::to_string(next - choices.begin());
      Notes notes;
      Make(model_, world, *next, notes);
      const Fingerprint fingerprint = IdentityOf(model_, world).fingerprint;
      if (const auto again = std::ranges::find(followed, fingerprint); again != followed.end()) {
        const std::string count = std::to_string(followed.end() - again);
        searched_.fault =
            Fault{{"the machine never comes to rest: the last " + count +
                   (count == "1" ? " event repeats" : " events repeat") + " without an end"},
                  path,
                  true};
        return;
      }
      followed.push_back(fingerprint);
    }
  }

  World WorldAt(const std::string& path) const {
    std::vector<std::string> ignored;
    const std::vector<PathStep> steps = StepsOf(model_, root_, path, ignored);
    return steps.empty() ? root_ : steps.back().world;
  }

  struct Hash {
    std::size_t operator()(const Fingerprint& f) const { return f.low; }
  };

  const Model& model_;
  const World& root_;
  SearchLimits& limits_;
  Searched searched_;
  FingerprintSet seen_;
  StableStates stable_;
  std::deque<Node> path_;
  // The nodes of which it is not decided yet whether they settle, with their numbers: those of the
  // path, and of circles with them. Also in the order in which they were reached.
  std::unordered_map<Fingerprint, std::size_t, Hash> open_;
  std::vector<Fingerprint> open_order_;
};

}  // namespace

std::size_t Fault::Choices() const {
  if (path.empty()) return 0;
  return static_cast<std::size_t>(std::ranges::count(path, '.')) + 1;
}

Figures& Figures::operator+=(const Figures& other) {
  pairs += other.pairs;
  nodes += other.nodes;
  transitions += other.transitions;
  leaves += other.leaves;
  seconds += other.seconds;
  return *this;
}

Searched SearchAll(const Model& model, const World& root, SearchLimits* limits) {
  const auto begun = std::chrono::steady_clock::now();
  Searched searched = Explorer(model, limits).Run(root);
  searched.figures.seconds = ToSeconds(std::chrono::steady_clock::now() - begun);
  return searched;
}

Searched SearchDepthFirst(const Model& model, const World& root, SearchLimits& limits) {
  const auto begun = std::chrono::steady_clock::now();
  Searched searched = DepthFirstExplorer(model, root, limits).Run();
  searched.figures.seconds = ToSeconds(std::chrono::steady_clock::now() - begun);
  return searched;
}

std::vector<PathStep> StepsOf(const Model& model, const World& root, const std::string& path,
                              std::vector<std::string>& violations) {
  std::vector<PathStep> steps;
  World world = root;
  std::istringstream numbers(path);
  for (std::string number; std::getline(numbers, number, '.');) {
    const std::vector<Choice> choices = Choices(model, world);
    const std::size_t k = std::stoul(number);
    if (k >= choices.size()) {
      steps.push_back({{"(no choice " + number + " here)"}, world, true});
      return steps;
    }
    Notes notes;
    notes.log = true;
    Make(model, world, choices[k], notes);
    violations.insert(violations.end(), notes.violations.begin(), notes.violations.end());
    steps.push_back({std::move(notes.scenario), world});
  }
  Notes notes;
  if (IsQuiet(world, Choices(model, world))) CheckRest(model, world, notes);
  violations.insert(violations.end(), notes.violations.begin(), notes.violations.end());
  return steps;
}

std::string ScenarioOf(const Model& model, const World& root, const std::string& path) {
  std::string scenario;
  std::vector<std::string> violations;
  for (const PathStep& step : StepsOf(model, root, path, violations)) {
    for (const std::string& sentence : step.sentences) scenario += "  " + sentence + "\n";
  }
  for (const std::string& violation : violations) scenario += "VIOLATION: " + violation + "\n";
  return scenario;
}

}  // namespace musher::search
