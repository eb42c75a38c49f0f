#pragma once
// Random trees of all nodes, with the leaves of interpreter.hpp: each port that may be an entry is
// one at times, subtrees remap keys in each way and are used again, scripts are expressions of all
// operators.

#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "musher/test/behavior/tree/conformance/interpreter.hpp"

namespace musher::tree::conformance {

class Generator {
 public:
  explicit Generator(std::uint32_t seed)
      : random_(seed), fails_(seed % 3 == 0), narrow_(seed % 20 == 19) {}

  bool fails() const { return fails_; }  // nodes may fail
  // A number from `from` to `to`.
  int Number(int from, int to) {
    return from + static_cast<int>(random_() % static_cast<std::uint32_t>(to - from + 1));
  }
  bool OneIn(int times) { return Number(1, times) == 1; }

  // A whole tree of at most this depth.
  Model Tree(int depth);
  Model Tree() { return Tree(narrow_ ? 8 : Number(1, 4)); }
  // What a person may write into the entry of a ManualSelector.
  std::string Selection();

 private:
  std::string OneOf(const std::vector<std::string>& texts) {
    return texts[static_cast<std::size_t>(Number(0, static_cast<int>(texts.size()) - 1))];
  }

  Model Node(int depth);
  Model Leaf();
  void AddPorts(Model& leaf);
  void AddUse(Model& leaf);
  void AddSetBlackboard(Model& leaf);
  std::string Does(bool at_once);
  Model Control(int depth);
  int ChildrenOf(const std::string& kind);
  void AddCases(int cases, Model& control);
  Model Decorator(int depth);
  void AddLoop(Model& loop);
  Model Subtree(int depth);
  void AddKeys(Model& subtree);

  std::string Milliseconds() { return OneIn(3) ? "{z}" : std::to_string(10 * Number(0, 3)); }
  std::string Count(int from, int to);
  std::string Bool() { return OneIn(5) ? "{b}" : OneOf({"true", "false"}); }
  std::string AnyEntry();
  std::string Place();

  std::string WholeKey();
  std::string NumberKey();
  std::string TextConstant();
  Expression Constant(bool whole);
  Expression Amount(int depth, bool whole);
  Expression Operation(int depth, bool whole);
  Expression Truth(int depth);
  Expression Chain(int depth);
  Expression Text();
  Expression AssignsNumber(const std::string& key, bool whole);
  Expression Assigns();
  Expression Script();
  Expression Condition();

  std::mt19937 random_;
  const bool fails_;
  const bool narrow_;  // and deep
  int names_ = 0;
  std::vector<Model> subtrees_;  // whose trees others may use, too
};

}  // namespace musher::tree::conformance
