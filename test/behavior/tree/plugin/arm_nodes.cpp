// A shared library with nodes, as a robot's project has it.

// [plugin]
#include "musher/behavior/tree/plugin/plugin.hpp"

namespace arm {

namespace tree = musher::tree;

class Grip : public tree::Action {
 public:
  explicit Grip(tree::Setup& setup)
      : force_n_(setup.Input<double>("force_n", 5.0)), held_(setup.Output<bool>("held")) {}

 private:
  tree::Status Do(const tree::Tick&) override {
    if (force_n_.Get() < 0) throw std::runtime_error("a force below 0");
    held_.Set(force_n_.Get() > 1);
    return tree::Status::kSuccess;
  }
  tree::InPort<double> force_n_;
  tree::OutPort<bool> held_;
};

}  // namespace arm

MUSHER_TREE_PLUGIN(factory) {
  return factory.Add<arm::Grip>("Grip");
}
// [plugin end]
