// A shared library of another compiler.

extern "C" __attribute__((visibility("default"), used))
const char* const musher_tree_plugin[] = {"musher tree plugin 0"};
