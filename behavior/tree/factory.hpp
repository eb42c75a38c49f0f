#pragma once
// Which nodes there are. A new factory has the nodes of BehaviorTree.CPP 4.
//
//   tree::Factory factory;
//   added = factory.Add<Move>("Move", robot);       // Move(tree::Setup&, Robot&)
//   factory.AddEnum("RED", 1);
//
// Arguments that are variables are passed by reference, and must outlive the trees.
//
// Threads: one at a time, like the trees that it builds.

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/behavior/tree/node.hpp"
#include "musher/behavior/tree/setup.hpp"

namespace musher::tree {

enum class NodeKind : std::uint8_t { kAction, kCondition, kDecorator, kControl, kSubtree };
std::string_view Name(NodeKind kind);  // "Action", as in XML

// A node that takes the place of others in a test.
struct TestNodeConfig {
  Status result = Status::kSuccess;
  Duration delay{};  // RUNNING until then
  std::string success_script{};
  std::string failure_script{};
  std::string post_script{};
  LeafFunction result_of{};  // its status in place of `result`; RUNNING: it is called again
};

// What a rule may name of a leaf. `path`: of all nodes above it, `tree_path` of the subtrees only,
// as BehaviorTree.CPP has it.
struct LeafNames {
  std::string name;
  std::string id;  // of its class
  std::string path;
  std::string tree_path;
};

// What takes the place of the nodes whose name or path matches.
struct Substitution {
  std::string pattern;
  TestNodeConfig config{};
  std::string node{};  // the name of a node; empty: a test node of `config`

  bool has_wildcard() const { return pattern.find('*') != std::string::npos; }
  bool Matches(const LeafNames& leaf) const;
};

// What is known of a node beside its ports, for people and editors: "author", "Ada".
using MetadataFields = std::vector<std::pair<std::string, std::string>>;

class Factory {
 public:
  using Make = std::function<std::unique_ptr<Node>(Setup&)>;
  struct Registered {
    NodeKind kind = NodeKind::kAction;
    bool takes_time = false;  // may return RUNNING by itself
    Make make;
    bool placeholder = false;   // of a model: whether it takes time is unknown
    std::string description{};  // for people
    std::string uses{};  // the part of the robot that only one node can use at a time: "base"
    MetadataFields metadata{};
  };

  Factory();
  // One without any node.
  static Factory Empty();

  // Fails where the name is taken, or can not be the name of an XML element. A node may have
  // `static tree::MetadataFields Metadata()`.
  template <class N, class... Args>
  Result<> Add(std::string_view name, Args&&... args) {
    Registered registered{
        KindOf<N>(), std::is_base_of_v<StatefulAction, N>,
        [kept = std::tuple<Args...>(std::forward<Args>(args)...)](Setup& setup) {
          return std::apply(
              [&setup](auto&... each) -> std::unique_ptr<Node> {
                if constexpr (std::is_constructible_v<N, Setup&, decltype(each)...>) {
                  return std::make_unique<N>(setup, each...);
                } else {
                  return std::make_unique<N>(each...);
                }
              },
              kept);
        }};
    if constexpr (requires { MetadataFields(N::Metadata()); }) registered.metadata = N::Metadata();
    return Register(name, std::move(registered));
  }
  Result<> AddAction(std::string_view name, LeafFunction function);
  Result<> AddCondition(std::string_view name, LeafFunction function);
  Result<> Register(std::string_view name, Registered registered);

  // A name for a number, in scripts and ports.
  void AddEnum(std::string_view name, double value) {
    if (enums_.use_count() > 1) enums_ = std::make_shared<Enums>(*enums_);  // a tree has them
    enums_->insert_or_assign(std::string(name), value);
  }
  // Nodes whose name or path matches, with '*' for any characters, become test nodes.
  void Substitute(std::string pattern, TestNodeConfig config);
  // They become nodes of another name, which gets those ports of theirs that it has. Fails where
  // there is no such node.
  Result<> SubstituteByNode(std::string pattern, std::string_view node);

  const Registered* Find(std::string_view name) const;  // null: there is none
  std::vector<std::string> Names() const;               // sorted
  const Enums& enums() const { return *enums_; }
  std::shared_ptr<const Enums> shared_enums() const { return enums_; }
  bool has_substitutes() const { return !substitutes_.empty(); }
  const std::vector<Substitution>& substitutions() const { return substitutes_; }
  // The first one that matches; null: there is none.
  const Substitution* Substituted(const LeafNames& leaf) const;
  // The ports of a node.
  std::vector<PortModel> PortsOf(std::string_view name) const;

 private:
  struct WithoutNodes {};
  explicit Factory(WithoutNodes) {}

  template <class N>
  static constexpr NodeKind KindOf() {
    static_assert(std::is_base_of_v<Node, N>, "a node derives from Action, Condition, ...");
    if constexpr (std::is_base_of_v<Condition, N>) return NodeKind::kCondition;
    if constexpr (std::is_base_of_v<Decorator, N>) return NodeKind::kDecorator;
    if constexpr (std::is_base_of_v<Control, N>) return NodeKind::kControl;
    return NodeKind::kAction;
  }

  std::map<std::string, Registered, std::less<>> nodes_;
  std::shared_ptr<Enums> enums_ = std::make_shared<Enums>();
  std::vector<Substitution> substitutes_;
};

// The nodes of BehaviorTree.CPP 4.
void AddCleanups(Factory& factory);
void AddControls(Factory& factory);
void AddDecorators(Factory& factory);
void AddLeaves(Factory& factory);
void AddLoops(Factory& factory);
void AddManualSelector(Factory& factory);
std::unique_ptr<Node> MakeTestNode(Setup& setup, const TestNodeConfig& config);

}  // namespace musher::tree
