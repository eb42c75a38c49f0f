// A shared library whose nodes can not be added: it throws something that is no std::exception.

#include "musher/behavior/tree/plugin/plugin.hpp"

MUSHER_TREE_PLUGIN(factory) {
  throw 7;
}
